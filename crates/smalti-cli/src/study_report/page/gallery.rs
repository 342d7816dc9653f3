//! Pictures of some designs in the page: by processing that it cannot draw itself, and those asked for.

use rayon::prelude::*;
use serde_json::{Value, json};
use smalti::sensor::NoiseMode;
use smalti_report::page::DataUri;

use super::Sources;
use super::choice::Choice;
use super::stages::{MOST_BYTES, Stages};
use crate::Watch;
use crate::pictures::Pixels;
use crate::study_report::answers::Section;
use crate::study_report::pictures::{LEAVES, Stage, Studio, ZONE_PLATE};
use crate::study_report::{DRAWN, results};

/// Of JPEG, for pictures that nobody asked for. Below, rings of a zone plate get halos that are not the camera's.
const QUALITY: u8 = 78;

pub(super) struct Gallery {
    pub(super) data: Value,
    pub(super) notes: Vec<String>,
}

/// A design that is to be pictured.
struct Wish {
    study: usize,
    section: usize,
    row: usize,
    /// Named by the caller: no limit applies, and every pixel is as it is.
    wanted: bool,
}

pub(super) fn gallery(sources: &Sources<'_>, choice: &Choice, stages: &Stages) -> anyhow::Result<Gallery> {
    let sections: Vec<(usize, &Section<'_>)> =
        sources.all.iter().enumerate().flat_map(|(i, (_, s))| s.iter().map(move |s| (i, s))).collect();
    let wishes = wishes(sources, &sections, stages);
    let (mut pictures, mut notes, mut bytes, mut left_out) = (Vec::new(), Vec::new(), stages.bytes, 0);
    for (index, (_, section)) in sections.iter().enumerate() {
        let here: Vec<&Wish> = wishes.iter().filter(|w| w.section == index).collect();
        if here.is_empty() {
            continue;
        }
        // The description of a camera may name a file that is not part of the study.
        let drawn = match draw(section, &here, sources.watch) {
            Ok(drawn) => drawn,
            Err(error) => {
                sources.watch.ask()?;
                let why = results::plain(&crate::in_one_line(error.as_ref()));
                notes.push(format!("{}: no pictures by the simulator: {why}", section.title()));
                continue;
            }
        };
        for (wish, [zone, leaves]) in here.iter().zip(drawn) {
            let Some(place) = choice.place(wish.study, wish.row) else { continue };
            let size = zone.0.as_str().len() + leaves.0.as_str().len();
            if bytes + size > MOST_BYTES && !wish.wanted {
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
            "the pictures of {left_out} designs were left out of the page: it would have become too large"
        ));
    }
    Ok(Gallery { data: pictures.into(), notes })
}

type Encoded = (DataUri, usize, usize);

/// The zone plate without noise and the scene with it, of each.
fn draw(section: &Section<'_>, wishes: &[&Wish], watch: &Watch<'_>) -> anyhow::Result<Vec<[Encoded; 2]>> {
    let studio = Studio::new(section)?;
    let stages = [studio.stage(ZONE_PLATE, NoiseMode::None)?, studio.stage(LEAVES, NoiseMode::All)?];
    let one = |wish: &&Wish| {
        let picture = |stage: &Stage<'_>| {
            watch.ask()?;
            let Pixels { width, height, rgb } = stage.picture(wish.row)?;
            let made = match wish.wanted {
                true => DataUri::png(width, height, &rgb),
                false => DataUri::jpeg(width, height, &rgb, QUALITY),
            }?;
            (watch.done)();
            anyhow::Ok((made, width, height))
        };
        let [zone, leaves] = &stages;
        anyhow::Ok([picture(zone)?, picture(leaves)?])
    };
    wishes.par_iter().map(one).collect()
}

/// The designs asked for; then of each number of colours the best and the worst; then the front, evenly; then the second and third
/// best. Of several sections in turn.
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
            let Ok(row) = results.number.binary_search(number) else { continue };
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
