//! What a design depends on and what limits it, in closed form.

use super::ExperimentError;
use crate::camera::Camera;
use crate::design::light::LightStatistics;
use crate::design::screen::{ClassLimits, ExpectedError, Figures, MIN_PATCHES, Screen, ScreenCondition};
use crate::design::{DesignError, Deviation};
use crate::sensor::Cfa;
use crate::spectrum::Spectrum;

/// The deviations of a filter.
const DEVIATIONS: [Deviation; 4] = super::robustness::DEVIATIONS;

/// What an array depends on and what limits it.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignAnalysis {
    /// Expected errors of the array, one for each condition.
    pub expected: Vec<ExpectedError>,
    /// Expected errors when one filter deviates, or all.
    pub sensitivities: Vec<Sensitivity>,
    /// The classes of patches, in words.
    pub classes: Vec<String>,
    /// For each condition and class, the causes of the error.
    pub limits: Vec<Vec<ClassLimits>>,
}

/// The expected errors of an array with a deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// The name of the filter that deviates; `None` when all deviate alike.
    pub filter: Option<String>,
    /// The deviation.
    pub deviation: Deviation,
    /// Expected errors, one for each condition.
    pub expected: Vec<ExpectedError>,
}

/// Analyses an array on a camera, whose own filters do not matter, under conditions. `clear` is the transmittance of a filter without
/// absorbance, as for [`Deviation::of`]. The expected errors are those of the best linear pipeline for the filters as they
/// are: a pipeline that was learned for filters that deviate otherwise loses more.
///
/// # Errors
/// When the statistics are of another camera.
pub fn analyse_design(
    camera: &Camera,
    statistics: &LightStatistics,
    conditions: &[ScreenCondition],
    clear: f64,
    cfa: &Cfa,
) -> Result<DesignAnalysis, ExperimentError> {
    let screen = Screen::new(camera, statistics, conditions)?;
    let nominal: Vec<Spectrum> = cfa.channels().iter().map(|c| c.transmittance.clone()).collect();
    let mut names = Vec::new();
    let mut sets = vec![screen.responses(&nominal)];
    let one = cfa.channels().iter().enumerate().map(|(i, c)| (Some(i), Some(c.name.clone())));
    for (which, name) in one.chain([(None, None)]) {
        for deviation in DEVIATIONS {
            let filter = |(i, t): (usize, &Spectrum)| match which {
                Some(which) if which != i => Ok(t.clone()),
                _ => deviation.of(t, clear),
            };
            let filters = nominal.iter().enumerate().map(filter).collect::<Result<Vec<_>, _>>();
            sets.push(screen.responses(&filters.map_err(DesignError::from)?));
            names.push((name.clone(), deviation));
        }
    }
    let limits = screen.limits(cfa.mosaic(), &sets[0]);
    let mut all = screen.expected_of(cfa.mosaic(), &sets, Figures::All).into_iter();
    let expected = all.next().unwrap_or_default();
    let with = |((filter, deviation), expected)| Sensitivity { filter, deviation, expected };
    let classes = &statistics.settings().classes;
    let used = statistics.classes().iter().filter(|(_, class)| class.moments.count() >= MIN_PATCHES);
    Ok(DesignAnalysis {
        expected,
        sensitivities: names.into_iter().zip(all).map(with).collect(),
        classes: used.map(|(number, _)| classes.name(*number)).collect(),
        limits,
    })
}
