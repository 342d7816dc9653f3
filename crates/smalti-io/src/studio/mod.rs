//! Files that the page of the studio loads: the light of scenes on bare pixels, statistics of light, and what they are.
//!
//! | file | content |
//! |---|---|
//! | `manifest.json` | the setup, the camera to begin with, the scenes, and the names of the other files |
//! | `training.bin` | [`LiveTraining`](smalti::design::live::LiveTraining): the light that pipelines are learned from |
//! | `SCENE.bin` | [`LiveScene`](smalti::design::live::LiveScene): the light of a scene |
//! | `statistics.bin` | [`LightStatistics`](smalti::design::light::LightStatistics), as in a `.light` file |
//! | `NAME.jpg`, `NAME.spc` | [`sources`]: what the page gathers the light behind another lens from |
//!
//! All but the manifest and the sources are deflated. The light is quantised to a thousandth of the brightest pixel; each number is stored as its difference from what its
//! neighbours predict.

mod asset;
mod file;
mod lens;
mod residuals;
mod scenes;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::DeflateEncoder;
use rayon::prelude::*;
use serde_json::json;
use smalti::camera::Camera;
use smalti::design::LearningSettings;
use smalti::design::live::LiveSetup;
use smalti::experiment::{ExperimentError, Progress};
use smalti::spectrum::Illuminant;

use self::scenes::{SCENES, StudioScene};

pub use asset::{StudioAsset, StudioAssetError};
pub use file::{scene_from_bytes, scene_to_bytes, training_from_bytes, training_to_bytes};
pub use lens::{TrainingFiles, scene_light, sources, statistics_of_light, training_light};
pub use scenes::{COMPONENTS, catalogue_name};

use crate::{IoError, light, rendered};

/// How the studio learns: with smaller patches and a smaller training scene than a study, so that a mosaic takes a fraction of a second.
#[must_use]
pub fn learning() -> LearningSettings {
    LearningSettings { side: 5, size_px: 160, ..LearningSettings::default() }
}

/// Which light is gathered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Extent {
    /// That of the training scene and of the first scene.
    First,
    All,
}

/// The files of the studio for the lens and the pixel geometry of a camera, in daylight (D65); the page begins with this camera. Equal arguments
/// give equal bytes. This takes several seconds. Each file is one step of progress.
///
/// # Errors
/// When the camera is invalid or its lens cannot image a scene, or when it was stopped.
pub fn assets(camera: &Camera, progress: &dyn Progress) -> Result<Vec<StudioAsset>, StudioAssetError> {
    gathered(camera, Extent::All, progress)
}

/// The files with which the page shows its first picture, in a second: the manifest names no file for the other scenes and the statistics, and the
/// page gathers their light from [`sources`], as it does behind another lens.
///
/// # Errors
/// As [`assets`].
pub fn first_assets(camera: &Camera, progress: &dyn Progress) -> Result<Vec<StudioAsset>, StudioAssetError> {
    gathered(camera, Extent::First, progress)
}

fn gathered(
    camera: &Camera,
    extent: Extent,
    progress: &dyn Progress,
) -> Result<Vec<StudioAsset>, StudioAssetError> {
    let illuminant = Illuminant::D65;
    let setup = LiveSetup::new(camera.description(), illuminant.clone(), learning());
    let count = if extent == Extent::First { 1 } else { SCENES.len() };
    progress.expect(count as u64 + 1);
    let scenes = || {
        let asset = |about: &StudioScene| {
            if progress.is_stopped() {
                return Err(ExperimentError::Stopped.into());
            }
            let source = rendered::find(about.catalogue).and_then(|stored| stored.photograph());
            let scene = scene_light(&setup, about.id, source)?;
            let asset = deflated(file_of(about), &scene_to_bytes(&scene, Path::new(about.id))?)?;
            progress.done();
            Ok(asset)
        };
        SCENES[..count].par_iter().map(asset).collect::<Result<Vec<_>, StudioAssetError>>()
    };
    let training = || {
        let bytes = training_to_bytes(&training_light(&setup)?, Path::new("training"))?;
        progress.done();
        Ok::<_, StudioAssetError>(deflated("training.bin".into(), &bytes)?)
    };
    let (scenes, training) = rayon::join(scenes, training);
    let statistics = match extent {
        Extent::First => None,
        Extent::All => {
            let stored = rendered::TrainingSet::All.stored();
            let found = statistics_of_light(camera, &illuminant, stored, progress)?;
            let bytes = light::to_bytes(&found, Path::new("statistics"))?;
            Some(deflated("statistics.bin".into(), &bytes)?)
        }
    };
    let description = camera.description();
    let training_sources: BTreeMap<&str, String> =
        rendered::training::NAMES.iter().map(|name| (*name, lens::training_source(name))).collect();
    let about = |(at, scene): (usize, &StudioScene)| {
        json!({
            "id": scene.id,
            "name": scene.name,
            "catalogue": scene.catalogue,
            "set": if scene.is_photograph() { "natural" } else { "charts" },
            "file": (at < count).then(|| file_of(scene)),
            "source": scene.source(),
        })
    };
    let manifest = json!({
        "training": "training.bin",
        "statistics": statistics.as_ref().map(|asset| &asset.name),
        "training_sources": training_sources,
        "scenes": SCENES.iter().enumerate().map(about).collect::<Vec<_>>(),
        "setups": [{
            "id": description.name,
            "name": description.name,
            "illuminant": illuminant.name(),
            "camera": description,
        }],
    });
    let manifest = StudioAsset { name: "manifest.json".into(), bytes: manifest.to_string().into_bytes() };
    Ok([manifest, training?].into_iter().chain(statistics).chain(scenes?).collect())
}

/// The name of the file of a scene.
fn file_of(scene: &StudioScene) -> String {
    format!("{}.bin", scene.id)
}

fn deflated(name: String, bytes: &[u8]) -> Result<StudioAsset, IoError> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
    let bytes = encoder.write_all(bytes).and_then(|()| encoder.finish());
    let bytes = bytes.map_err(IoError::writing(Path::new(&name)))?;
    Ok(StudioAsset { name, bytes })
}
