//! The search for better filters and a better mosaic.

use serde_json::json;
use smalti::camera::Camera;
use smalti::camera::description::CameraDescription;
use smalti::design::light::LightSettings;
use smalti::design::live::{FoundChannel, LiveLocks, live_conditions, live_objective, with_array};
use smalti::design::screen::ExpectedError;
use smalti::design::search::{Annealing, FreeCurves, LayoutRules, Locks, SearchSettings, Tolerance};
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

/// The most filters of a mosaic that is searched: those of a task have the letters a to z.
const MOST_CHANNELS: usize = 26;

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
    let kept = kept(&camera, locks(&camera, wanted)?);
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
    char::from(b'a' + channel as u8)
}

/// What stays of an array whose channels all have letters in a task.
pub(super) fn locks(camera: &Camera, wanted: &Search) -> Result<Locks, JobError> {
    let channels = camera.sensor.cfa.channels().len();
    if channels > MOST_CHANNELS {
        let message = format!(
            "the mosaic has {channels} filters; a search takes at most {MOST_CHANNELS}, one for each letter"
        );
        return Err(JobError::Wrong(message));
    }
    let Search { filters, cells, mosaic, .. } = wanted;
    let locks = LiveLocks { filters: filters.clone(), cells: cells.clone(), mosaic: *mosaic };
    Ok(locks.of(camera)?)
}

/// Which cells and filters stay. A filter that stays keeps its cells.
fn kept(camera: &Camera, Locks { filters, cells }: Locks) -> Kept {
    let cfa = &camera.sensor.cfa;
    let (mosaic, channels) = (cfa.mosaic(), cfa.channels());
    let stays =
        |row: usize, col: usize| cells[row * mosaic.cols() + col] || filters[mosaic.channel_at(row, col)];
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
    let given = |channel: usize| (letter(place(channel)), Filter::sampled(&channels[channel].transmittance));
    let rules = LayoutRules {
        kept: if count == 0 { Vec::new() } else { (0..mosaic.rows()).map(line).collect() },
        filters: (0..channels.len()).filter(|c| filters[*c]).map(given).collect(),
        ..LayoutRules::default()
    };
    Kept { channels: order, known: count, filters, rules }
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
    let found = channels.iter().zip(&found.transmittances).map(|(channel, transmittance)| FoundChannel {
        letter: own[*channel].name.clone(),
        transmittance: transmittance.clone(),
        stays: kept.filters[*channel],
    });
    Ok(with_array(camera.description(), &best.mosaic, &found.collect::<Vec<_>>()))
}
