//! The scenes on which cameras are compared, by the names of sets and scenes.

use std::path::Path;
use std::sync::Arc;

use smalti::camera::{DeferredScene, TestScene};
use smalti::spectrum::{Illuminant, WavelengthGrid};

use crate::error::At;
use crate::rendered::StoredScene;
use crate::scene_file::is_meant;
use crate::{IoError, SceneRequest, rendered, scenes};

/// A set of test scenes. None of them is a training scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TestSet {
    /// Test patterns: dead leaves, ColorChecker, resolution charts and a room of high dynamic range, under the illuminant of the
    /// comparison.
    Charts,
    /// Scenes of measured reflectances: path-traced ones, each in its own light, and photographs under the illuminant of the
    /// comparison.
    #[default]
    Natural,
    /// Both.
    All,
}

impl TestSet {
    /// All sets with their names and summaries.
    pub const NAMED: [(&'static str, &'static str, Self); 3] = [
        ("charts", "Test patterns and charts", Self::Charts),
        (
            "natural",
            "Path-traced scenes in their own light, and photographs with measured reflectances",
            Self::Natural,
        ),
        ("all", "Both sets", Self::All),
    ];

    /// The scenes of the set under an illuminant.
    ///
    /// # Errors
    /// When the beginning of a stored scene is damaged, or the illuminant does not cover its wavelengths. Other damage is told where the
    /// scene is first needed.
    pub fn scenes(self, illuminant: &Illuminant) -> Result<Vec<TestScene>, IoError> {
        let mut scenes = Vec::new();
        if matches!(self, Self::Natural | Self::All) {
            let stored = rendered::names().iter().map(|scene| stored(scene, illuminant));
            scenes = stored.collect::<Result<_, _>>()?;
        }
        if matches!(self, Self::Charts | Self::All) {
            scenes.extend(TestScene::charts());
        }
        Ok(scenes)
    }
}

/// A scene of a comparison by its name: a built-in scene, which is relit if it can be, or a file, which is relit with one sample per
/// pixel. A name without parameters selects a scene of the set `charts` in its size there.
///
/// # Errors
/// When there is no such scene, a file cannot be read or relit, or the beginning of a stored scene is damaged.
pub fn test_scene(name: &str, illuminant: &Illuminant) -> Result<TestScene, IoError> {
    if let Some(scene) = rendered::find(name) {
        return stored(scene, illuminant);
    }
    if !is_meant(name) {
        scenes::ensure_in_catalog(name)?;
        return Ok(TestScene::built_in(name));
    }
    Ok(TestScene::relit(name, scenes::load(name, &under(illuminant))?, 1))
}

/// A scene at 1 cd/m² under an illuminant.
pub(crate) fn under(illuminant: &Illuminant) -> SceneRequest {
    SceneRequest {
        luminance_cd_m2: Some(1.0),
        illuminant: Some(illuminant.clone()),
        ..SceneRequest::default()
    }
}

/// A stored scene, under the illuminant if it can be relit. It is loaded when it is first needed.
fn stored(scene: &'static StoredScene, illuminant: &Illuminant) -> Result<TestScene, IoError> {
    let (name, grid) = (scene.name, WavelengthGrid::VISIBLE);
    let own_light = scene.own_light()?;
    let mut request = SceneRequest { luminance_cd_m2: Some(1.0), ..SceneRequest::default() };
    if own_light.is_none() {
        illuminant.photons(grid).at(Path::new(name))?;
        request = under(illuminant);
    }
    let load = move || scenes::load(name, &request).map_err(|error| error.to_string());
    Ok(TestScene::Deferred(Arc::new(DeferredScene::new(name, grid, own_light, load))))
}

/// The name of a scene without its folder, parameters and extension.
#[must_use]
pub fn scene_label(scene: &str) -> String {
    let name = if is_meant(scene) { scene } else { scene.split('?').next().unwrap_or(scene) };
    Path::new(name).file_stem().map_or_else(|| scene.to_owned(), |s| s.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pipelines are learned for the light and the wavelengths that are known before a scene is loaded.
    #[test]
    fn stored_scenes_have_the_light_and_the_wavelengths_that_were_stated() {
        for (name, keeps_light) in [("natural-street", true), ("photo-fig", false)] {
            let scene = test_scene(name, &Illuminant::A).unwrap();
            let stated = scene.light(&Illuminant::A, WavelengthGrid::VISIBLE).unwrap();
            let (loaded, samples_per_px) = scene.loaded().unwrap().unwrap();
            assert_eq!((scene.keeps_light(), samples_per_px), (keeps_light, 2), "{name}");
            assert_eq!(scene.grid(), Some(loaded.radiance().grid()));
            assert!((loaded.mean_luminance_cd_m2().unwrap() - 1.0).abs() < 1e-5);
            let level = loaded.illuminant().max() / stated.max();
            let pairs = loaded.illuminant().values().iter().zip(stated.values());
            assert!(
                pairs.clone().all(|(its, stated)| (its / (level * stated) - 1.0).abs() < 1e-12),
                "{name}"
            );
            // It is loaded once.
            assert!(Arc::ptr_eq(&loaded, &scene.loaded().unwrap().unwrap().0));
        }
    }
}
