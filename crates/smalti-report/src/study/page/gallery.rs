//! Embedded pictures of some designs: those with learned pipelines, and those that the caller asks for. A browser that does not allow
//! WebAssembly shows them. They equal the pictures that the page draws, bit for bit.

use rayon::prelude::*;
use serde_json::{Value, json};
use smalti::design::Preview;
use smalti::experiment::Progress;
use smalti::sensor::NoiseMode;

use super::choice::Choice;
use super::optical_setups::{MAX_BYTES, OpticalSetups};
use super::sources::Sources;
use crate::page::DataUri;
use crate::pictures::Pixels;
use crate::study::book::{DRAWN, ensure_running};
use crate::study::sections::Section;
use crate::words::plain;
use crate::{ReportError, in_one_line};

/// The JPEG quality of pictures that the caller has not asked for. A lower quality adds halos to the rings of the zone plate.
const QUALITY: u8 = 78;

pub(super) struct Gallery {
    pub(super) data: Value,
    pub(super) notes: Vec<String>,
}

/// A trial whose pictures are to be embedded.
struct EmbeddedPicture {
    study: usize,
    section: usize,
    row: usize,
    /// Whether the caller requested it. Requested pictures are lossless and have no limit.
    requested: bool,
}

pub(super) fn gallery(
    sources: &Sources<'_>,
    choice: &Choice,
    optical_setups: &OpticalSetups,
) -> Result<Gallery, ReportError> {
    let sections: Vec<(usize, &Section<'_>)> =
        sources.all.iter().enumerate().flat_map(|(i, (_, s))| s.iter().map(move |s| (i, s))).collect();
    let embedded = embedded(sources, &sections, optical_setups);
    let (mut pictures, mut notes, mut bytes, mut left_out) =
        (Vec::new(), Vec::new(), optical_setups.bytes, 0);
    for (index, (_, section)) in sections.iter().enumerate() {
        let here: Vec<&EmbeddedPicture> = embedded.iter().filter(|w| w.section == index).collect();
        if here.is_empty() {
            continue;
        }
        // The camera may need a file that is not part of the study.
        let drawn = match draw(
            section,
            &here,
            &|| optical_setups.preview(index, section, sources.progress),
            sources.progress,
        ) {
            Ok(drawn) => drawn,
            Err(error) => {
                ensure_running(sources.progress)?;
                let why = plain(&in_one_line(&error));
                notes.push(format!("{}: no embedded pictures: {why}", section.title()));
                continue;
            }
        };
        for (picture, [zone, leaves]) in here.iter().zip(drawn) {
            let Some(place) = choice.place(picture.study, picture.row) else { continue };
            let size = zone.0.as_str().len() + leaves.0.as_str().len();
            if bytes + size > MAX_BYTES && !picture.requested {
                left_out += 1;
                continue;
            }
            bytes += size;
            let one = |(uri, width, height): (DataUri, usize, usize)| json!({"src": uri.as_str(), "width": width, "height": height});
            pictures.push(json!({"row": place, "zone_plate": one(zone), "scene": one(leaves)}));
        }
    }
    if left_out > 0 {
        notes.push(format!(
            "the pictures of {left_out} trials were left out, since the page would be too large"
        ));
    }
    Ok(Gallery { data: pictures.into(), notes })
}

type Encoded = (DataUri, usize, usize);

/// For each trial the zone plate without noise and the scene with noise.
fn draw(
    section: &Section<'_>,
    embedded: &[&EmbeddedPicture],
    preview: &dyn Fn() -> Result<Preview, ReportError>,
    progress: &dyn Progress,
) -> Result<Vec<[Encoded; 2]>, ReportError> {
    let preview = preview()?;
    let one = |of: &&EmbeddedPicture| {
        let design = preview.design(&section.results.trial(of.row)?.design)?;
        let picture = |(scene, noise): (usize, NoiseMode)| {
            ensure_running(progress)?;
            let Pixels { width, height, rgb } = Pixels::of(&preview.picture(&design, scene, noise)?);
            let made = match of.requested {
                true => DataUri::png(width, height, &rgb),
                false => DataUri::jpeg(width, height, &rgb, QUALITY),
            }?;
            progress.picture();
            Ok::<_, ReportError>((made, width, height))
        };
        Ok([picture((0, NoiseMode::None))?, picture((1, NoiseMode::All))?])
    };
    embedded.par_iter().map(one).collect()
}

/// The trials that the caller requested. Then, for each section, the best and the worst trial of each number of colours, trials of
/// the front at even distances, and the second and third best.
fn embedded(
    sources: &Sources<'_>,
    sections: &[(usize, &Section<'_>)],
    optical_setups: &OpticalSetups,
) -> Vec<EmbeddedPicture> {
    let mut embedded: Vec<EmbeddedPicture> = Vec::new();
    let mut add = |section: usize, row: usize, requested: bool| {
        let Some((study, _)) = sections.get(section) else { return };
        let there = embedded.iter().any(|w| (w.section, w.row) == (section, row));
        if !there && (requested || embedded.len() < sources.pictures + sources.requested.len()) {
            embedded.push(EmbeddedPicture { study: *study, section, row, requested });
        }
    };
    if let Some((results, _)) = sources.all.first() {
        for number in sources.requested {
            let Ok(row) = results.data.numbers.binary_search(number) else { continue };
            let section = sections.iter().position(|(study, s)| *study == 0 && s.rows.contains(&row));
            if let Some(section) = section.filter(|s| !optical_setups.has_failed(*s)) {
                add(section, row, true);
            }
        }
    }
    let undrawn =
        || sections.iter().enumerate().filter(|(index, _)| optical_setups.wants_pictures(*index)).take(DRAWN);
    let each = (sources.pictures / undrawn().count().max(1)).max(1);
    for (index, (_, section)) in undrawn() {
        let groups = &section.groups;
        let best = |rank: usize| groups.iter().filter_map(move |g| g.best.get(rank).copied());
        let in_turn = best(0)
            .chain(groups.iter().filter_map(|g| g.worst))
            .chain(section.some_of_front(6))
            .chain(best(1))
            .chain(best(2));
        let mut seen = std::collections::BTreeSet::new();
        in_turn
            .filter(|r| seen.insert(*r))
            .take(each.min(sources.pictures))
            .for_each(|row| add(index, row, false));
    }
    embedded
}
