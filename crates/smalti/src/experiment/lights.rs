//! The illuminants of test scenes, and the pipelines of a camera for them.
//!
//! Scenes of the catalogue and scenes that can be relit have the illuminant of the comparison. Others keep their own light, such as
//! that of a street lamp. A camera has a pipeline for each of these lights, as it has a colour matrix for each with classic
//! processing, so that cameras are compared and not their illuminant estimation.

use super::ExperimentError;
use super::error::StageContext;
use crate::camera::TestScene;
use crate::l3::Pipeline;
use crate::spectrum::{Illuminant, Spectrum, SpectrumError, WavelengthGrid};

/// Largest difference of two lights, relative to their maxima, up to which scenes share a pipeline. One lamp differs by up to 2 %
/// between scenes, whose spectra are means over bands or samples.
const SAME_LIGHT: f64 = 0.03;

/// An illuminant of test scenes.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneLight {
    /// The illuminant.
    pub illuminant: Illuminant,
    /// The wavelengths of scenes that keep their light; `None` for those of each camera.
    pub grid: Option<WavelengthGrid>,
}

/// The illuminants of a comparison: first that of its targets and of scenes that are relit, then the others, each once.
///
/// # Errors
/// Never for valid scenes.
pub fn scene_lights(
    illuminant: &Illuminant,
    scenes: &[TestScene],
) -> Result<Vec<SceneLight>, ExperimentError> {
    let mut lights = vec![SceneLight { illuminant: illuminant.clone(), grid: None }];
    for scene in scenes {
        let own = || -> Result<_, SpectrumError> {
            let TestScene::Given { scene: given, keeps_light: true, .. } = scene else { return Ok(None) };
            let (light, grid) = (given.illuminant(), given.radiance().grid());
            let is_known = |known: &SceneLight| distance(&known.illuminant, light) <= SAME_LIGHT;
            if lights.iter().any(is_known) {
                return Ok(None);
            }
            Ok(Some(SceneLight {
                illuminant: Illuminant::of_photons(scene.name(), light)?,
                grid: Some(grid),
            }))
        };
        lights.extend(own().in_context(|| scene.name().to_owned())?);
    }
    Ok(lights)
}

/// The largest difference of an illuminant from a light (photons), both relative to their maxima. It is infinite if the illuminant
/// is not defined at the wavelengths of the light.
fn distance(illuminant: &Illuminant, light: &Spectrum) -> f64 {
    let Ok(photons) = illuminant.photons(light.grid()) else { return f64::INFINITY };
    let (a, b) = (photons.max(), light.max());
    let differences = photons.values().iter().zip(light.values()).map(|(x, y)| (x / a - y / b).abs());
    differences.fold(0.0, f64::max)
}

/// The pipelines of a camera, each for a light; at least one.
#[derive(Debug, Clone)]
pub struct PipelineSet {
    first: (Illuminant, Pipeline),
    others: Vec<(Illuminant, Pipeline)>,
}

impl PipelineSet {
    /// One pipeline for every light, which was learned under this illuminant.
    #[must_use]
    pub fn single(illuminant: Illuminant, pipeline: Pipeline) -> Self {
        Self { first: (illuminant, pipeline), others: Vec::new() }
    }

    /// The set with a further pipeline.
    #[must_use]
    pub fn with(mut self, illuminant: Illuminant, pipeline: Pipeline) -> Self {
        self.others.push((illuminant, pipeline));
        self
    }

    /// The pipeline for the illuminant of the comparison.
    #[must_use]
    pub fn main(&self) -> &Pipeline {
        &self.first.1
    }

    /// All pipelines with their illuminants, that of the comparison first.
    pub fn iter(&self) -> impl Iterator<Item = &(Illuminant, Pipeline)> {
        std::iter::once(&self.first).chain(&self.others)
    }

    /// The pipeline whose illuminant is the nearest to a light (photons).
    #[must_use]
    pub fn for_light(&self, light: &Spectrum) -> &Pipeline {
        let mut nearest = (distance(&self.first.0, light), &self.first.1);
        for (illuminant, pipeline) in &self.others {
            let distance = distance(illuminant, light);
            if distance < nearest.0 {
                nearest = (distance, pipeline);
            }
        }
        nearest.1
    }
}
