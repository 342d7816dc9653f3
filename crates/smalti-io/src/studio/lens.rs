//! The light behind one lens, on pixels of one geometry. The server gathers it for the camera with which the page begins, the page for every
//! other lens, from the same sources with the same functions.

use std::collections::BTreeMap;

use smalti::camera::{Camera, StoredTrainingScenes, TEST_SAMPLES_PER_PX, TestScene};
use smalti::design::light::{LightSettings, LightStatistics};
use smalti::design::live::{LiveScene, LiveSetup, LiveTraining};
use smalti::experiment::{Progress, Resources, light_statistics};
use smalti::scene::Scene;
use smalti::spectrum::{Illuminant, Spectrum, WavelengthGrid};

use super::asset::{StudioAsset, StudioAssetError};
use super::scenes::{COMPONENTS, SCENES};
use crate::error::At;
use crate::rendered::{self, training};
use crate::test_scenes::under;

/// The light of a scene of the studio. `file` is its source, one of [`sources`]; scenes of the catalogue have none.
///
/// # Errors
/// When there is no such scene, its source is damaged or missing, or the lens cannot image it.
pub fn scene_light(setup: &LiveSetup, id: &str, file: Option<&[u8]>) -> Result<LiveScene, StudioAssetError> {
    let known = SCENES.iter().find(|scene| scene.id == id);
    let scene = known.ok_or_else(|| StudioAssetError::NoScene(id.to_owned()))?;
    let test_scene = match (scene.is_photograph(), file) {
        (false, _) => TestScene::built_in(scene.catalogue),
        (true, None) => return Err(StudioAssetError::NoSource(id.to_owned())),
        (true, Some(bytes)) => {
            let photograph = rendered::of_photograph(scene.catalogue, bytes)?;
            let lit = under(&setup.illuminant).applied_to(photograph).at(scene.catalogue.as_ref())?;
            TestScene::relit(scene.catalogue, lit, TEST_SAMPLES_PER_PX)
        }
    };
    Ok(LiveScene { name: id.to_owned(), ..setup.scene(&test_scene, COMPONENTS)? })
}

/// The light that pipelines are learned from, and that of the targets.
///
/// # Errors
/// When the lens cannot image the scenes.
pub fn training_light(setup: &LiveSetup) -> Result<LiveTraining, StudioAssetError> {
    Ok(setup.training(COMPONENTS)?)
}

/// The statistics of light for expected figures, over the training scenes. Mosaic, exposure and processing of the camera do not count.
///
/// # Errors
/// When a scene is missing or damaged, or the work was stopped.
pub fn statistics_of_light(
    camera: &Camera,
    illuminant: &Illuminant,
    stored: &dyn StoredTrainingScenes,
    progress: &dyn Progress,
) -> Result<LightStatistics, StudioAssetError> {
    let resources = Resources { training_scenes: stored, progress, ..Resources::default() };
    Ok(light_statistics(camera, illuminant, None, &LightSettings::default(), resources)?)
}

/// Training scenes from files that were read before, by the names of [`sources`] without extension.
pub struct TrainingFiles<'a>(pub &'a BTreeMap<String, Vec<u8>>);

impl StoredTrainingScenes for TrainingFiles<'_> {
    fn names(&self) -> Vec<&'static str> {
        training::NAMES.to_vec()
    }

    fn load(&self, name: &str, grid: WavelengthGrid, painted_with: &[Spectrum]) -> Result<Scene, String> {
        let bytes = self.0.get(name).ok_or_else(|| format!("the file of {name} is missing"))?;
        training::scene(name, bytes, grid, painted_with)
    }
}

/// The files from which the page gathers the light behind another lens: photographs as JPEG, and path-traced scenes as `.spc`. The manifest
/// names them.
#[must_use]
pub fn sources() -> Vec<StudioAsset> {
    let photographs = SCENES.iter().filter_map(|scene| {
        let bytes = rendered::find(scene.catalogue)?.photograph()?;
        Some((scene.source()?, bytes))
    });
    let training =
        training::NAMES.iter().filter_map(|name| Some((training_source(name), training::file(name)?)));
    let asset = |(name, bytes): (String, &[u8])| StudioAsset { name, bytes: bytes.to_vec() };
    photographs.chain(training).map(asset).collect()
}

/// The name of the source of a training scene.
pub(super) fn training_source(name: &str) -> String {
    let extension = if name.starts_with("training-clutter") { "spc" } else { "jpg" };
    format!("{name}.{extension}")
}
