//! Embedded pictures of some designs: those with learned pipelines, and those that the caller asks for. A browser that does not allow
//! WebAssembly shows them. They equal the pictures that the page draws, bit for bit.

use rayon::prelude::*;
use serde_json::{Value, json};
use smalti::design::Preview;
use smalti::experiment::Progress;
use smalti::sensor::NoiseMode;

use super::choice::Choice;
use super::sources::Sources;
use super::stages::{MAX_BYTES, Stages};
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

/// A design whose pictures are to be embedded.
struct Wish {
    study: usize,
    section: usize,
    row: usize,
    /// Whether the caller asked for it: then no limit applies, and the pictures are lossless.
    wanted: bool,
}

pub(super) fn gallery(
    sources: &Sources<'_>,
    choice: &Choice,
    stages: &Stages,
) -> Result<Gallery, ReportError> {
    let sections: Vec<(usize, &Section<'_>)> =
        sources.all.iter().enumerate().flat_map(|(i, (_, s))| s.iter().map(move |s| (i, s))).collect();
    let wishes = wishes(sources, &sections, stages);
    let (mut pictures, mut notes, mut bytes, mut left_out) = (Vec::new(), Vec::new(), stages.bytes, 0);
    for (index, (_, section)) in sections.iter().enumerate() {
        let here: Vec<&Wish> = wishes.iter().filter(|w| w.section == index).collect();
        if here.is_empty() {
            continue;
        }
        // The camera may need a file that is not part of the study.
        let drawn = match draw(
            section,
            &here,
            &|| stages.preview(index, section, sources.progress),
            sources.progress,
        ) {
            Ok(drawn) => drawn,
            Err(error) => {
                ensure_running(sources.progress)?;
                let why = plain(&in_one_line(&error));
                notes.push(format!("{}: no pictures by the simulator: {why}", section.title()));
                continue;
            }
        };
        for (wish, [zone, leaves]) in here.iter().zip(drawn) {
            let Some(place) = choice.place(wish.study, wish.row) else { continue };
            let size = zone.0.as_str().len() + leaves.0.as_str().len();
            if bytes + size > MAX_BYTES && !wish.wanted {
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
            "the pictures of {left_out} designs were left out, since the page would be too large"
        ));
    }
    Ok(Gallery { data: pictures.into(), notes })
}

type Encoded = (DataUri, usize, usize);

/// For each design the zone plate without noise and the scene with noise.
fn draw(
    section: &Section<'_>,
    wishes: &[&Wish],
    preview: &dyn Fn() -> Result<Preview, ReportError>,
    progress: &dyn Progress,
) -> Result<Vec<[Encoded; 2]>, ReportError> {
    let preview = preview()?;
    let one = |wish: &&Wish| {
        let design = preview.design(&section.results.trial(wish.row)?.design)?;
        let picture = |(scene, noise): (usize, NoiseMode)| {
            ensure_running(progress)?;
            let Pixels { width, height, rgb } = Pixels::of(&preview.picture(&design, scene, noise)?);
            let made = match wish.wanted {
                true => DataUri::png(width, height, &rgb),
                false => DataUri::jpeg(width, height, &rgb, QUALITY),
            }?;
            progress.picture();
            Ok::<_, ReportError>((made, width, height))
        };
        Ok([picture((0, NoiseMode::None))?, picture((1, NoiseMode::All))?])
    };
    wishes.par_iter().map(one).collect()
}

/// The designs that the caller asks for. Then, for each section, the best and the worst design of each number of colours, designs of
/// the front at even distances, and the second and third best.
fn wishes(sources: &Sources<'_>, sections: &[(usize, &Section<'_>)], stages: &Stages) -> Vec<Wish> {
    let mut wishes: Vec<Wish> = Vec::new();
    let mut add = |section: usize, row: usize, wanted: bool| {
        let Some((study, _)) = sections.get(section) else { return };
        let there = wishes.iter().any(|w| (w.section, w.row) == (section, row));
        if !there && (wanted || wishes.len() < sources.pictures + sources.wanted.len()) {
            wishes.push(Wish { study: *study, section, row, wanted });
        }
    };
    if let Some((results, _)) = sources.all.first() {
        for number in sources.wanted {
            let Ok(row) = results.data.numbers.binary_search(number) else { continue };
            let section = sections.iter().position(|(study, s)| *study == 0 && s.rows.contains(&row));
            if let Some(section) = section.filter(|s| !stages.has_failed(*s)) {
                add(section, row, true);
            }
        }
    }
    let undrawn =
        || sections.iter().enumerate().filter(|(index, _)| stages.wants_pictures(*index)).take(DRAWN);
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
    wishes
}
