//! The search for the best colour filter array.

use std::collections::BTreeMap;

use super::design_search::{Candidate, RIVALS, Search};
use super::design_store::DesignStore;
use super::design_task::{DesignTask, Designs};
use super::{ExperimentError, Progress};
use crate::camera::CameraError;
use crate::design::light::LightStatistics;
use crate::design::screen::Screen;
use crate::design::search::{FilterSearch, SampledSpace};
use crate::design::{DesignError, published, published_filters};
use crate::sensor::cfa::CfaInfo;
use crate::sensor::{Filter, Mosaic};

/// Largest tile of a published mosaic that competes.
const MAX_RIVAL_CELLS: usize = 64;
/// The numbers of filters of published mosaics.
const RIVAL_COLORS: std::ops::RangeInclusive<usize> = 3..=7;

/// Finds the filters for every mosaic of a task, those for the published mosaics, and the front. `statistics` has an entry for each illuminant. Each start
/// is one step of progress. What `store` has of an earlier run is not searched again.
///
/// The same task gives the same arrays for any number of threads.
///
/// # Errors
/// When a setting is invalid, the statistics are of another camera, or the work is stopped; [`ExperimentError::OpenParts`] when `store` leaves parts
/// to other processes.
pub fn design(
    task: &DesignTask,
    statistics: &[LightStatistics],
    store: &dyn DesignStore,
    progress: &dyn Progress,
) -> Result<Designs, ExperimentError> {
    task.validate()?;
    let screens = screens(task, statistics)?;
    let space = task.filters.sampled(task.camera.grid())?;
    let given = task.given()?;
    let own = screens
        .iter()
        .map(|screen| screen.expected(&task.camera.sensor.cfa))
        .collect::<Result<Vec<_>, _>>()?
        .concat();
    let goal = task.objective.goal(&own);
    let search = Search { task, screens: &screens, space: &space, store, progress };
    let free = search.filters(&goal, &[], task.search);
    let constrained = FilterSearch { given: &given, ..free };
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut is_whole = true;
    for &colors in &task.colors {
        let found: Vec<(Mosaic, Vec<Vec<Vec<f64>>>)> = match task.listed_mosaics(colors)? {
            Some(listed) => listed.into_iter().map(|mosaic| (mosaic, Vec::new())).collect(),
            None => {
                let annealed = search.annealed(&constrained, colors)?;
                is_whole &= annealed.is_some();
                annealed.into_iter().flatten().map(|found| (found.mosaic, vec![found.parameters])).collect()
            }
        };
        for (mosaic, first) in found {
            let item = candidates.len() as u32;
            candidates.push(Candidate { name: tile_name(&mosaic), is_published: false, mosaic, first, item });
        }
    }
    let mut rivals: Vec<Candidate> = Vec::new();
    let mut known = BTreeMap::new();
    if task.rivals {
        for colors in RIVAL_COLORS {
            for (info, mosaic) in published(colors)? {
                if mosaic.cells().len() <= MAX_RIVAL_CELLS {
                    let (name, item) = (info.name.to_owned(), RIVALS + rivals.len() as u32);
                    let first = vec![own_filters(info, &space, &mut known)?];
                    rivals.push(Candidate { name, is_published: true, mosaic, first, item });
                }
            }
        }
    }
    // The published mosaics do not wait for the layouts, so that several processes begin with all of them.
    let searched = if is_whole { search.contest(&constrained, candidates)? } else { None };
    let rivals = search.contest(&free, rivals)?;
    let (Some(searched), Some(rivals)) = (searched, rivals) else { return Err(ExperimentError::OpenParts) };
    let front = match &task.front {
        Some(front) => search.front(&given, front, &searched)?,
        None => Vec::new(),
    };
    Ok(Designs { own, goal, searched, rivals, front })
}

/// A screen for each illuminant of a task.
///
/// # Errors
/// When there are not as many statistics as illuminants, or they are of another camera.
pub fn screens(task: &DesignTask, statistics: &[LightStatistics]) -> Result<Vec<Screen>, DesignError> {
    if statistics.len() != task.illuminants.len() || statistics.is_empty() {
        let (found, expected) = (statistics.len(), task.illuminants.len());
        let message =
            format!("{expected} illuminants and {found} statistics of light; expected one for each");
        return Err(DesignError::key("illuminants", message));
    }
    statistics.iter().map(|s| Screen::new(&task.camera, s, &task.conditions)).collect()
}

/// The filters of a family that are the nearest to the built-in ones of a published mosaic. `known` has those of the filters before.
fn own_filters(
    info: &CfaInfo,
    space: &SampledSpace,
    known: &mut BTreeMap<String, Vec<f64>>,
) -> Result<Vec<Vec<f64>>, DesignError> {
    let mut nearest = |filter: Filter| {
        let name = format!("{filter:?}");
        if let Some(found) = known.get(&name) {
            return Ok(found.clone());
        }
        let wanted = filter.spectrum(space.grid()).map_err(CameraError::from)?;
        let found = space.start_near(wanted.values());
        known.insert(name, found.clone());
        Ok(found)
    };
    published_filters(info)?.into_iter().map(&mut nearest).collect()
}

/// A tile in letters, such as `ab/cd`.
fn tile_name(mosaic: &Mosaic) -> String {
    let letter = |&cell: &u8| char::from(b'a' + cell % 26);
    let rows = mosaic.cells().chunks(mosaic.cols().max(1));
    rows.map(|row| row.iter().map(letter).collect::<String>()).collect::<Vec<_>>().join("/")
}
