//! The search for better filters and a better mosaic.

use std::collections::BTreeMap;

use serde_json::json;
use smalti::camera::Camera;
use smalti::camera::description::{CameraDescription, CfaDescription, PatternDescription};
use smalti::design::light::LightSettings;
use smalti::design::live::{live_conditions, live_objective};
use smalti::design::screen::ExpectedError;
use smalti::design::search::{Annealing, FreeCurves, LayoutRules, SearchSettings, Tolerance};
use smalti::design::{MosaicFamily, Symmetry, Tile};
use smalti::experiment::{DesignTask, DesignedCfa, ForgetfulStore, design, light_statistics};
use smalti::sensor::Filter;
use smalti::spectrum::Spectrum;

use super::capture::LIGHT;
use super::design::camera;
use super::error::JobError;
use super::material::{Found, Native};
use super::message::Search;
use super::watch::Watch;

/// What stays: the letter of each channel of the task, kept ones first, and the rules.
struct Kept {
    /// The channels of the camera in the order of the task.
    channels: Vec<usize>,
    /// How many of them are in kept cells, and therefore have known letters.
    known: usize,
    /// Whether the filter of each channel of the camera stays.
    filters: Vec<bool>,
    rules: LayoutRules,
}

/// Searches all mosaics of the tile, and the filters for each from many starts.
pub(super) fn search(native: &Native, wanted: &Search, watch: &Watch) -> Result<Found, JobError> {
    let camera = camera(&wanted.design)?;
    let kept = kept(&camera, wanted);
    let mosaic = camera.sensor.cfa.mosaic();
    let task = DesignTask {
        name: camera.description().name.clone(),
        illuminants: vec![LIGHT],
        conditions: live_conditions(&camera, &wanted.luminances_cd_m2),
        colors: vec![camera.sensor.cfa.channels().len()],
        filters: wanted.family.space(FreeCurves::default()),
        mosaics: MosaicFamily::Tile(Tile {
            rows: mosaic.rows(),
            cols: mosaic.cols(),
            symmetry: Symmetry::default(),
        }),
        mosaic_count: None,
        rules: kept.rules.clone(),
        annealing: Annealing::default(),
        rivals: false,
        objective: live_objective(),
        front: None,
        tolerance: Tolerance::default(),
        search: SearchSettings::default(),
        light: LightSettings::default(),
        camera,
    };
    let statistics = light_statistics(&task.camera, &LIGHT, None, &task.light, native.resources(watch))?;
    let designs = design(&task, std::slice::from_ref(&statistics), &ForgetfulStore, watch)?;
    let best = designs.searched.first().ok_or(JobError::Broken)?;
    let found = best.best().ok_or(JobError::Broken)?;
    let own_cost = designs.goal.cost(&designs.own);
    let expected = |all: &[ExpectedError]| -> Vec<_> {
        let of = |(l, e): (&f64, &ExpectedError)| json!({"luminance_cd_m2": l, "cpsnr_db": e.cpsnr_db, "delta_e_2000": e.delta_e_2000});
        wanted.luminances_cd_m2.iter().zip(all).map(of).collect()
    };
    let said = json!({
        "design": described(&task.camera, &kept, best)?,
        "mosaics": designs.searched.len(),
        "is_better": found.cost < own_cost,
        "expected": expected(&found.expected),
        "own_expected": expected(&designs.own),
    });
    Ok(Found { said, files: Vec::new() })
}

/// The letter of a channel of a task.
fn letter(channel: usize) -> char {
    char::from(b'a' + (channel % 26) as u8)
}

/// Checks that the filters and cells that stay are those of the array.
pub(super) fn ensure_locks(camera: &Camera, wanted: &Search) -> Result<(), JobError> {
    let cfa = &camera.sensor.cfa;
    let mosaic = cfa.mosaic();
    let is_absent = |name: &&String| cfa.channels().iter().all(|c| c.name != **name);
    if let Some(name) = wanted.filters.iter().find(is_absent) {
        return Err(JobError::Wrong(format!("the array has no filter {name:?}")));
    }
    for [row, col] in &wanted.cells {
        if *row >= mosaic.rows() || *col >= mosaic.cols() {
            let (rows, cols) = (mosaic.rows(), mosaic.cols());
            let message = format!("the cell {row}, {col} is not in the tile of {rows} × {cols}");
            return Err(JobError::Wrong(message));
        }
    }
    Ok(())
}

/// Which cells and filters stay. A filter that stays keeps its cells.
fn kept(camera: &Camera, wanted: &Search) -> Kept {
    let cfa = &camera.sensor.cfa;
    let (mosaic, channels) = (cfa.mosaic(), cfa.channels());
    let filters: Vec<bool> = channels.iter().map(|c| wanted.filters.contains(&c.name)).collect();
    let stays = |row: usize, col: usize| {
        wanted.mosaic || wanted.cells.contains(&[row, col]) || filters[mosaic.channel_at(row, col)]
    };
    let places = || (0..mosaic.rows()).flat_map(|row| (0..mosaic.cols()).map(move |col| (row, col)));
    let is_known = |channel: &usize| {
        places().any(|(row, col)| mosaic.channel_at(row, col) == *channel && stays(row, col))
    };
    let (known, free): (Vec<usize>, Vec<usize>) = (0..channels.len()).partition(is_known);
    let (count, order) = (known.len(), [known, free].concat());
    let place = |channel: usize| order.iter().position(|c| *c == channel).unwrap_or_default();
    let line = |row: usize| {
        let cell = |col: usize| match stays(row, col) {
            true => letter(place(mosaic.channel_at(row, col))),
            false => '.',
        };
        (0..mosaic.cols()).map(cell).collect::<String>()
    };
    let given = |channel: usize| {
        let t = &channels[channel].transmittance;
        (letter(place(channel)), samples(t))
    };
    let rules = LayoutRules {
        kept: if count == 0 { Vec::new() } else { (0..mosaic.rows()).map(line).collect() },
        filters: (0..channels.len()).filter(|c| filters[*c]).map(given).collect(),
        ..LayoutRules::default()
    };
    Kept { channels: order, known: count, filters, rules }
}

fn samples(t: &Spectrum) -> Filter {
    let grid = t.grid();
    Filter::Samples { start_nm: grid.start_nm(), step_nm: grid.step_nm(), values: t.values().to_vec() }
}

/// The camera with an array that was found. Filters in cells that stay keep their letters; the others have theirs in the order of their wavelengths.
fn described(camera: &Camera, kept: &Kept, best: &DesignedCfa) -> Result<CameraDescription, JobError> {
    let found = best.best().ok_or(JobError::Broken)?;
    let own = camera.sensor.cfa.channels();
    let mean_nm = |t: &Spectrum| {
        let moment: f64 = t.values().iter().zip(t.grid().wavelengths_nm()).map(|(t, nm)| t * nm).sum();
        moment / t.values().iter().sum::<f64>().max(f64::MIN_POSITIVE)
    };
    let by_wavelength = |mut all: Vec<usize>, of: &dyn Fn(usize) -> f64| {
        all.sort_by(|a, b| of(*a).total_cmp(&of(*b)));
        all
    };
    let free = (kept.known..kept.channels.len()).collect();
    let free = by_wavelength(free, &|i| found.transmittances.get(i).map_or(0.0, mean_nm));
    let letters = by_wavelength(kept.channels[kept.known..].to_vec(), &|c| mean_nm(&own[c].transmittance));
    // The channel of the camera whose letter each channel of the task has.
    let mut channels = kept.channels.clone();
    free.into_iter().zip(letters).for_each(|(at, channel)| channels[at] = channel);
    let name = |at: usize| channels.get(at).map_or("", |c| own[*c].name.as_str());
    let mosaic = &best.mosaic;
    let line = |row| (0..mosaic.cols()).map(|col| name(mosaic.channel_at(row, col))).collect();
    let stated = &camera.description().sensor.cfa.filters;
    let filter = |(at, t): (usize, &Spectrum)| {
        let stays = channels.get(at).is_some_and(|c| kept.filters[*c]);
        let own = stated.get(name(at)).filter(|_| stays).cloned();
        (name(at).to_owned(), own.unwrap_or_else(|| samples(t)))
    };
    let filters: BTreeMap<String, Filter> = found.transmittances.iter().enumerate().map(filter).collect();
    let mut description = camera.description().clone();
    description.sensor.cfa = CfaDescription {
        pattern: PatternDescription::Letters((0..mosaic.rows()).map(line).collect()),
        filters,
        ..CfaDescription::default()
    };
    Ok(description)
}
