//! The search for the best colour filter array.

use std::sync::Mutex;
use std::sync::PoisonError;

use super::progress::ensure_running;
use super::{ExperimentError, Progress};
use crate::camera::Camera;
use crate::design::light::{LightSettings, LightStatistics};
use crate::design::screen::{ExpectedError, Screen, ScreenCondition};
use crate::design::search::{FilterSearch, FilterSpace, FoundFilters, Objective, SearchSettings};
use crate::design::{Design, FilterSet, MosaicFamily, published};
use crate::sensor::{Filter, Mosaic};
use crate::spectrum::{Illuminant, Spectrum};

/// Mosaics that are searched in full. When there are more, short searches choose them.
const FINALISTS: usize = 6;
/// Steps and starts of the short searches.
const SHORT: SearchSettings = SearchSettings { starts: 4, steps: 25, seed: 0 };
/// Largest tile of a published mosaic that competes.
const MAX_RIVAL_CELLS: usize = 64;
/// The numbers of filters of published mosaics.
const RIVAL_COLORS: std::ops::RangeInclusive<usize> = 3..=7;

/// A search: which array is wanted, for which camera and light.
#[derive(Debug, Clone)]
pub struct DesignTask {
    /// Its name.
    pub name: String,
    /// The camera, whose own filters do not matter.
    pub camera: Camera,
    /// The illuminant of the scenes.
    pub illuminant: Illuminant,
    /// Light and exposure.
    pub conditions: Vec<ScreenCondition>,
    /// Numbers of filters.
    pub colors: Vec<usize>,
    /// The filters that can be made.
    pub filters: FilterSpace,
    /// The mosaics that are searched.
    pub mosaics: MosaicFamily,
    /// Number of mosaics drawn for each number of filters; all when `None`.
    pub mosaic_count: Option<u64>,
    /// Whether the published mosaics compete, with filters found for each in the same way.
    pub rivals: bool,
    /// What is minimised.
    pub objective: Objective,
    /// The extent of the search.
    pub search: SearchSettings,
    /// The statistics of the light.
    pub light: LightSettings,
}

/// A mosaic with the filters that were found for it.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignedCfa {
    /// The name of a published mosaic, else its tile in letters.
    pub name: String,
    /// Whether the mosaic is published.
    pub is_published: bool,
    /// The mosaic; channel i has filter i.
    pub mosaic: Mosaic,
    /// The best filters of each start, best first; never empty.
    pub found: Vec<FoundFilters>,
}

impl DesignedCfa {
    /// The best filters.
    #[must_use]
    pub fn best(&self) -> Option<&FoundFilters> {
        self.found.first()
    }

    /// The array with its best filters in ascending order of wavelength.
    #[must_use]
    pub fn design(&self) -> Option<Design> {
        let best = self.best()?;
        let mean_nm = |s: &Spectrum| {
            let sum: f64 = s.values().iter().sum();
            let moment: f64 = s.values().iter().zip(s.grid().wavelengths_nm()).map(|(t, nm)| t * nm).sum();
            moment / sum.max(f64::MIN_POSITIVE)
        };
        let mut order: Vec<usize> = (0..best.transmittances.len()).collect();
        order.sort_by(|&a, &b| {
            mean_nm(&best.transmittances[a]).total_cmp(&mean_nm(&best.transmittances[b])).then(a.cmp(&b))
        });
        let place = |cell: &u8| order.iter().position(|i| *i == usize::from(*cell)).map(|p| p as u8);
        let cells = self.mosaic.cells().iter().map(place).collect::<Option<Vec<u8>>>()?;
        let filter = |i: &usize| {
            let (t, grid) = (&best.transmittances[*i], best.transmittances[*i].grid());
            Filter::Samples {
                start_nm: grid.start_nm(),
                step_nm: grid.step_nm(),
                values: t.values().to_vec(),
            }
        };
        Some(Design {
            filters: FilterSet { label: self.name.clone(), filters: order.iter().map(filter).collect() },
            mosaic: Mosaic::new(self.mosaic.rows(), self.mosaic.cols(), cells).ok()?,
        })
    }

    fn cost(&self) -> f64 {
        self.best().map_or(f64::INFINITY, |f| f.cost)
    }
}

/// The result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Designs {
    /// The expected errors of the camera's own array, one for each condition.
    pub own: Vec<ExpectedError>,
    /// The searched mosaics, best first.
    pub searched: Vec<DesignedCfa>,
    /// The published mosaics with filters of the same kind, best first.
    pub rivals: Vec<DesignedCfa>,
}

/// Finds the filters for every mosaic of a task, and those for the published mosaics. Each start is one step of progress.
///
/// The same task gives the same arrays for any number of threads.
///
/// # Errors
/// When a setting is invalid, the statistics are of another camera, or the work is stopped.
pub fn design(
    task: &DesignTask,
    statistics: &LightStatistics,
    progress: &dyn Progress,
) -> Result<Designs, ExperimentError> {
    let screen = Screen::new(&task.camera, statistics, &task.conditions)?;
    let space = task.filters.sampled(task.camera.grid())?;
    let settings = task.search;
    let search = FilterSearch { screen: &screen, space: &space, objective: task.objective, settings };
    let mut candidates: Vec<(String, bool, Mosaic)> = Vec::new();
    for &colors in &task.colors {
        for mosaic in task.mosaics.pick_layouts(colors, task.mosaic_count, settings.seed)? {
            candidates.push((tile_name(&mosaic), false, mosaic));
        }
    }
    let mut rivals: Vec<(String, bool, Mosaic)> = Vec::new();
    if task.rivals {
        for colors in RIVAL_COLORS {
            for (info, mosaic) in published(colors)? {
                if mosaic.cells().len() <= MAX_RIVAL_CELLS {
                    rivals.push((info.name.to_owned(), true, mosaic));
                }
            }
        }
    }
    let searched = contest(&search, candidates, 0, progress)?;
    let rivals = contest(&search, rivals, 1 << 16, progress)?;
    Ok(Designs { own: screen.expected(&task.camera.sensor.cfa)?, searched, rivals })
}

/// Searches mosaics, best first. When there are many, short searches choose those that are searched in full; the others keep the result
/// of the short one.
fn contest(
    search: &FilterSearch<'_>,
    mosaics: Vec<(String, bool, Mosaic)>,
    first_item: u32,
    progress: &dyn Progress,
) -> Result<Vec<DesignedCfa>, ExperimentError> {
    let seed = search.settings.seed;
    let short = FilterSearch { settings: SearchSettings { seed, ..SHORT }, ..*search };
    let has_heats = mosaics.len() > FINALISTS;
    let of_full = search.settings.starts.div_ceil(2);
    let heats = if has_heats { mosaics.len() * SHORT.starts.div_ceil(2) } else { 0 };
    progress.expect((heats + of_full * mosaics.len().min(FINALISTS)) as u64);
    let best = Mutex::new(f64::INFINITY);
    let run = |search: &FilterSearch<'_>, name: &str, mosaic: &Mosaic, item: u32| {
        ensure_running(progress)?;
        let done = |cost: f64| {
            let mut best = best.lock().unwrap_or_else(PoisonError::into_inner);
            *best = best.min(cost);
            progress.begin(&format!("{name}: cost {cost:.3}, best so far {:.3}", *best));
            progress.done();
            !progress.is_stopped()
        };
        let found = search.filters(mosaic, item, &done)?;
        ensure_running(progress)?;
        Ok::<_, ExperimentError>(found)
    };
    let mut all: Vec<(DesignedCfa, u32)> = Vec::new();
    for ((name, is_published, mosaic), item) in mosaics.into_iter().zip(first_item..) {
        let found = if has_heats { run(&short, &name, &mosaic, item)? } else { Vec::new() };
        all.push((DesignedCfa { name, is_published, mosaic, found }, item));
    }
    all.sort_by(|a, b| a.0.cost().total_cmp(&b.0.cost()).then(a.1.cmp(&b.1)));
    for (design, item) in all.iter_mut().take(FINALISTS) {
        let mut found = run(search, &design.name, &design.mosaic, *item)?;
        found.append(&mut design.found);
        found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        design.found = found;
    }
    all.sort_by(|a, b| a.0.cost().total_cmp(&b.0.cost()).then(a.1.cmp(&b.1)));
    Ok(all.into_iter().map(|(design, _)| design).collect())
}

/// A tile in letters, such as `ab/cd`.
fn tile_name(mosaic: &Mosaic) -> String {
    let letter = |&cell: &u8| char::from(b'a' + cell % 26);
    let rows = mosaic.cells().chunks(mosaic.cols().max(1));
    rows.map(|row| row.iter().map(letter).collect::<String>()).collect::<Vec<_>>().join("/")
}
