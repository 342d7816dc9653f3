//! The illuminants of test scenes, and the pipelines of a camera for them.
//!
//! Scenes of the catalogue and scenes that can be relit have the illuminant of the comparison. Others keep their own light, such as
//! that of a street lamp. A camera has a pipeline for each of these lights, as it has a colour matrix for each with classic
//! processing, so that cameras are compared and not their illuminant estimation.

use std::sync::OnceLock;

use super::ExperimentError;
use super::error::StageContext;
use crate::camera::{Camera, TestScene};
use crate::l3::Pipeline;
use crate::spectrum::{Illuminant, Spectrum, WavelengthGrid};

/// Largest difference of two lights, relative to their maxima, up to which scenes share a pipeline. One lamp differs by up to 2 %
/// between scenes, whose spectra are means over bands or samples.
const SAME_LIGHT: f64 = 0.03;

/// An illuminant of test scenes.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneLight {
    /// The illuminant.
    pub illuminant: Illuminant,
    /// The wavelengths of the scenes; `None` for those of each camera.
    pub grid: Option<WavelengthGrid>,
}

/// The illuminants of a comparison: first that of its targets, then those of given scenes, each once for its wavelengths.
///
/// # Errors
/// Never for valid scenes.
pub fn scene_lights(
    illuminant: &Illuminant,
    scenes: &[TestScene],
) -> Result<Vec<SceneLight>, ExperimentError> {
    let mut lights = vec![SceneLight { illuminant: illuminant.clone(), grid: None }];
    for scene in scenes {
        let Some(grid) = scene.grid() else { continue };
        let context = || scene.name().to_owned();
        let light = &scene.light(illuminant, grid).in_context(context)?;
        let is_known =
            |known: &SceneLight| known.grid == Some(grid) && distance(&known.illuminant, light) <= SAME_LIGHT;
        if lights.iter().any(is_known) {
            continue;
        }
        let illuminant = match distance(illuminant, light) <= SAME_LIGHT || !scene.keeps_light() {
            true => illuminant.clone(),
            false => Illuminant::of_photons(scene.name(), light).in_context(context)?,
        };
        lights.push(SceneLight { illuminant, grid: Some(grid) });
    }
    Ok(lights)
}

/// Checks that cameras measure colour under all lights of a comparison, before any work for it.
///
/// # Errors
/// With the label of the camera and the illuminant; see [`Camera::ensure_measures_color`].
pub fn ensure_lights_suffice<'a>(
    cameras: impl IntoIterator<Item = (&'a str, &'a Camera)>,
    lights: &[SceneLight],
) -> Result<(), ExperimentError> {
    for (label, camera) in cameras {
        for SceneLight { illuminant, grid } in lights {
            let suffices =
                || camera.ensure_measures_color(&illuminant.photons(grid.unwrap_or(camera.grid()))?);
            suffices().in_context(|| format!("{label} under {}", illuminant.name()))?;
        }
    }
    Ok(())
}

/// The largest difference of an illuminant from a light (photons), both relative to their maxima. It is infinite if the illuminant
/// is not defined at the wavelengths of the light.
fn distance(illuminant: &Illuminant, light: &Spectrum) -> f64 {
    let Ok(photons) = illuminant.photons(light.grid()) else { return f64::INFINITY };
    let (a, b) = (photons.max(), light.max());
    let differences = photons.values().iter().zip(light.values()).map(|(x, y)| (x / a - y / b).abs());
    differences.fold(0.0, f64::max)
}

/// A pipeline and the light that it was learned for.
#[derive(Debug, Clone)]
pub struct LitPipeline {
    /// The illuminant.
    pub illuminant: Illuminant,
    /// The wavelengths of the training scenes.
    pub grid: WavelengthGrid,
    /// The pipeline.
    pub pipeline: Pipeline,
}

/// The pipelines of a camera, each for a light. That for the illuminant of the comparison is learned; others may still be.
#[derive(Debug)]
pub struct PipelineSet {
    first: LitPipeline,
    others: Vec<OtherLight>,
}

/// A light and its pipeline, once that is learned.
#[derive(Debug)]
struct OtherLight {
    illuminant: Illuminant,
    grid: WavelengthGrid,
    learned: OnceLock<LitPipeline>,
}

impl PipelineSet {
    /// One pipeline that renders raw images of a camera in every light. It was learned under the illuminant.
    #[must_use]
    pub fn of_any_light(illuminant: &Illuminant, camera: &Camera, pipeline: Pipeline) -> Self {
        Self::single(LitPipeline { illuminant: illuminant.clone(), grid: camera.grid(), pipeline })
    }

    /// One pipeline.
    #[must_use]
    pub fn single(first: LitPipeline) -> Self {
        Self { first, others: Vec::new() }
    }

    /// Adds another light, whose pipeline is still to be learned.
    pub(super) fn expect(&mut self, illuminant: Illuminant, grid: WavelengthGrid) {
        self.others.push(OtherLight { illuminant, grid, learned: OnceLock::new() });
    }

    /// Takes a pipeline that was expected.
    pub(super) fn learned(&self, lit: LitPipeline) {
        let is_for = |o: &&OtherLight| (&o.illuminant, o.grid) == (&lit.illuminant, lit.grid);
        if let Some(other) = self.others.iter().find(is_for) {
            other.learned.get_or_init(|| lit);
        }
    }

    /// The pipeline for the illuminant of the comparison.
    #[must_use]
    pub fn main(&self) -> &Pipeline {
        &self.first.pipeline
    }

    /// All pipelines that are learned, that for the illuminant of the comparison first.
    pub fn iter(&self) -> impl Iterator<Item = &LitPipeline> {
        std::iter::once(&self.first).chain(self.others.iter().filter_map(|other| other.learned.get()))
    }

    /// The pipeline for the wavelengths of a light (photons) whose illuminant is the nearest to it; `None` while it is still to be learned.
    #[must_use]
    pub fn for_light(&self, light: &Spectrum) -> Option<&Pipeline> {
        // Lights differ by at most 1, so that a pipeline for the same wavelengths always precedes the others.
        let distance = |illuminant: &Illuminant, grid: WavelengthGrid| {
            distance(illuminant, light) + if grid == light.grid() { 0.0 } else { 2.0 }
        };
        let mut nearest = (distance(&self.first.illuminant, self.first.grid), Some(&self.first));
        for other in &self.others {
            let distance = distance(&other.illuminant, other.grid);
            if distance < nearest.0 {
                nearest = (distance, other.learned.get());
            }
        }
        nearest.1.map(|lit| &lit.pipeline)
    }
}
