//! Statistics of the light of the default training set.

use super::error::StageContext;
use super::progress::ensure_running;
use super::{ExperimentError, Resources};
use crate::camera::{Camera, SurfaceReflectances, training_reflectances, training_scenes};
use crate::design::light::{LightGatherer, LightSettings, LightStatistics};
use crate::scene::Scene;
use crate::spectrum::{Illuminant, Spectrum};

/// A gatherer for the light on the pixels of a camera under an illuminant, with components of the reflectances that pipelines learn from.
///
/// # Errors
/// When a setting is out of range.
pub fn light_gatherer(
    camera: &Camera,
    illuminant: &Illuminant,
    settings: &LightSettings,
) -> Result<LightGatherer, ExperimentError> {
    let context = || "statistics of light".to_owned();
    let reflectances = training_reflectances(camera.grid()).in_context(context)?;
    let light = illuminant.photons(camera.grid()).in_context(|| illuminant.name())?;
    let lit = |s: &Spectrum| s.times(&light);
    let spectra = reflectances.iter().map(lit).collect::<Result<Vec<_>, _>>().in_context(context)?;
    Ok(LightGatherer::new(camera, illuminant, &spectra, settings)?)
}

/// Gathers the statistics of the light on the pixels of a camera, over the default training set under an illuminant or over given scenes,
/// which have their field of view. The patches of a camera with crosstalk are one ring of pixels wider than the settings state. Each scene is
/// one step of progress.
///
/// # Errors
/// When a setting is out of range, a scene cannot be built or imaged, or the work is stopped.
pub fn light_statistics(
    camera: &Camera,
    illuminant: &Illuminant,
    scenes: Option<&[Scene]>,
    settings: &LightSettings,
    resources: Resources<'_>,
) -> Result<LightStatistics, ExperimentError> {
    let gatherer = light_gatherer(camera, illuminant, &settings.around(camera)?)?;
    let mut statistics = gatherer.statistics();
    let progress = resources.progress;
    let mut add = |name: &str, scene: &dyn Fn() -> Result<Scene, ExperimentError>| {
        ensure_running(progress)?;
        progress.begin(&format!("light of {name}"));
        gatherer.add(&mut statistics, &scene()?)?;
        progress.done();
        Ok::<_, ExperimentError>(())
    };
    match scenes {
        Some(scenes) => {
            progress.expect(scenes.len() as u64);
            scenes.iter().try_for_each(|s| add(s.name(), &|| Ok(s.clone())))?;
        }
        None => {
            let stored = resources.training_scenes;
            let reflectances =
                SurfaceReflectances::new(camera.grid()).in_context(|| "statistics of light".to_owned())?;
            let set = training_scenes(std::slice::from_ref(illuminant), stored);
            progress.expect(set.len() as u64);
            for scene in &set {
                let build = || {
                    scene
                        .build(camera, &reflectances, stored)
                        .in_context(|| format!("scene {}", scene.content))
                };
                add(scene.content.name(), &build)?;
            }
        }
    }
    Ok(statistics)
}
