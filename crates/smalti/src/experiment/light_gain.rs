//! Light gains between contenders of a comparison.

use super::comparison::ComparisonSettings;
use super::contender::Contender;
use super::error::StageContext;
use super::{ExperimentError, ExposurePlan, Progress};
use crate::camera::{CameraAndIsp, LightGainSettings, LightGains, light_gains};
use crate::numeric::Number;
use crate::spectrum::Spectrum;

/// The light gain of a pair of contenders.
pub struct PairwiseLightGain {
    /// The contender whose light changes.
    pub first: String,
    /// The contender that it is to equal.
    pub other: String,
    /// The gains by each metric.
    pub gains: LightGains,
}

/// How much more light contender `a` needs to equal contender `b`, by every metric.
///
/// # Errors
/// When a stage fails, or the work is stopped.
pub fn light_gain_between(
    a: &Contender<'_>,
    b: &Contender<'_>,
    settings: &LightGainSettings,
    progress: &dyn Progress,
) -> Result<LightGains, ExperimentError> {
    let isp_a = |light: &Spectrum| a.isp(light, progress);
    let isp_b = |light: &Spectrum| b.isp(light, progress);
    let (a, b) =
        (CameraAndIsp { camera: a.camera, isp: &isp_a }, CameraAndIsp { camera: b.camera, isp: &isp_b });
    light_gains(a, b, settings)
        .in_context(|| format!("light gain at {} cd/m²", Number(settings.luminance_cd_m2)))
}

/// The light gains of the first contender against every other contender with the same processing, at each luminance. Each is one
/// step of progress. Scenes, seeds and exposure times are those of the comparison.
///
/// # Errors
/// When a stage fails, or the work is stopped.
pub fn light_gains_to_first(
    contenders: &[Contender<'_>],
    settings: &ComparisonSettings,
    exposure: &ExposurePlan,
    progress: &dyn Progress,
) -> Result<Vec<PairwiseLightGain>, ExperimentError> {
    let Some((first, rest)) = contenders.split_first() else { return Ok(Vec::new()) };
    let mut gains = Vec::new();
    for other in rest.iter().filter(|c| c.processing == first.processing) {
        for (light, &luminance_cd_m2) in settings.luminances_cd_m2.iter().enumerate() {
            progress.begin(&format!("light gain of {} at {luminance_cd_m2} cd/m²", other.name()));
            let settings = LightGainSettings {
                luminance_cd_m2,
                illuminant: settings.illuminant.clone(),
                seed: settings.seed,
                seed_count: settings.seed_count,
                scenes: settings.scenes.clone(),
                times_s: (0..settings.scenes.len()).map(|scene| exposure.scene_s(scene, light)).collect(),
                chart_s: exposure.targets(light).map(|t| t.macbeth_s),
                score: settings.score,
            };
            let found = light_gain_between(first, other, &settings, progress)?;
            gains.push(PairwiseLightGain { first: first.name(), other: other.name(), gains: found });
            progress.done();
        }
    }
    Ok(gains)
}
