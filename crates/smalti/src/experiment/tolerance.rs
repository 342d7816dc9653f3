//! How the pictures of a design change when its filters deviate, over light.

use serde::Serialize;

use super::comparison::imaged;
use super::contender::Contender;
use super::entrants::figures;
use super::error::StageContext;
use super::pipelines::{PipelineTask, pipelines};
use super::robustness::DEVIATIONS;
use super::{ComparisonSettings, Estimate, ExperimentError, PictureFigures, Resources, scene_lights};
use crate::camera::{Camera, PICTURE_METRICS, TrainingSettings};
use crate::design::Deviation;
use crate::l3::Training;
use crate::numeric::bootstrap::Resamples;

/// The figures of a design at a luminance, with filters as designed or not.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ToleranceRow {
    /// The deviation of all filters.
    pub deviation: Deviation,
    /// It in words.
    pub name: String,
    /// Mean luminance of the scenes, cd/m².
    pub luminance_cd_m2: f64,
    /// The means of [`PICTURE_METRICS`] over scenes and seeds, with their intervals over scenes.
    pub means: [Estimate; PICTURE_METRICS.len()],
    /// How much larger the means are than those as designed, with the intervals of these differences, which are paired. Of the row as designed, `None`.
    pub changes: Option<[Estimate; PICTURE_METRICS.len()]>,
}

/// Scores a camera as designed and with filters that deviate, each at every luminance of `settings`: 5 nm to either side, and 5 % thinner or thicker. All have the
/// pipelines that are learned for the filters as designed. `clear` is the transmittance of a filter without absorbance, as for [`Deviation::of`].
/// Each training scene, and each scene at a luminance with a deviation, is one step of progress.
///
/// # Errors
/// When the camera has no mosaic, a stage fails, or the work is stopped.
pub fn tolerances(
    (camera, label): (&Camera, &str),
    clear: f64,
    settings: &ComparisonSettings,
    learning: (&TrainingSettings, &Training),
    resources: Resources<'_>,
) -> Result<Vec<ToleranceRow>, ExperimentError> {
    let deviations: Vec<Deviation> = std::iter::once(Deviation::NONE).chain(DEVIATIONS).collect();
    let pictures = settings.luminances_cd_m2.len() * settings.scenes.len();
    resources.progress.expect((deviations.len() * pictures) as u64);
    let lights = scene_lights(&settings.illuminant, &settings.scenes)?;
    let (cameras, labels) = ([camera.clone()], [label.to_owned()]);
    let sets = pipelines(PipelineTask::learned((&cameras, &labels), learning, &lights), resources)?;
    let set = sets.first().and_then(Option::as_ref);
    let mut setups = Vec::new();
    let mut scored: Vec<PictureFigures> = Vec::with_capacity(deviations.len());
    for deviation in &deviations {
        let label = format!("{label}, {deviation}");
        let deviating = deviation.of_camera(camera, clear).in_context(|| label.clone())?;
        let contender = Contender::with_pipelines(&deviating, &label, set);
        setups = imaged(&contender, settings, &setups, resources)?;
        scored.push(figures(&contender, &setups, settings, resources)?);
    }
    let (scenes, seeds) = (settings.scenes.len(), settings.seeds().count());
    let resamples = (scenes * seeds > 1).then(|| Resamples::new(scenes, seeds, settings.seed));
    let mut rows = Vec::with_capacity(deviations.len() * settings.luminances_cd_m2.len());
    let own = scored.first().ok_or(ExperimentError::NothingToCompare)?;
    for (number, (deviation, found)) in deviations.iter().zip(&scored).enumerate() {
        let lights = found.lights.iter().zip(&own.lights).zip(&settings.luminances_cd_m2);
        for ((light, own), luminance_cd_m2) in lights {
            let change = |metric: usize| {
                Estimate::of_difference(&light.metrics[metric], &own.metrics[metric], resamples.as_ref())
            };
            rows.push(ToleranceRow {
                deviation: *deviation,
                name: deviation.to_string(),
                luminance_cd_m2: *luminance_cd_m2,
                means: light.metrics.each_ref().map(|values| Estimate::of_mean(values, resamples.as_ref())),
                changes: (number > 0).then(|| std::array::from_fn(change)),
            });
        }
    }
    Ok(rows)
}
