//! Files that the page of the studio loads: the light of scenes on bare pixels, statistics of light, and what they are.
//!
//! | file | content |
//! |---|---|
//! | `manifest.json` | the setup, the camera to begin with, the scenes, and the names of the other files |
//! | `training.bin` | [`LiveTraining`](smalti::design::live::LiveTraining): the light that pipelines are learned from |
//! | `SCENE.bin` | [`LiveScene`]: the light of a scene |
//! | `statistics.bin` | [`LightStatistics`], as in a `.light` file |
//!
//! All but the manifest are deflated. The light is quantised to a thousandth of the brightest pixel; each number is stored as its difference from what its
//! neighbours predict.

mod file;
mod residuals;

use std::io::{Read, Write};
use std::path::Path;

use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use rayon::prelude::*;
use serde_json::{Value, json};
use smalti::camera::{Camera, CameraError, TestScene};
use smalti::design::LearningSettings;
use smalti::design::light::{LightSettings, LightStatistics};
use smalti::design::live::{LiveScene, LiveSetup};
use smalti::experiment::{ExperimentError, Progress, Resources, light_statistics};
use smalti::spectrum::Illuminant;
use thiserror::Error;

pub use file::{scene_from_bytes, scene_to_bytes, training_from_bytes, training_to_bytes};

use crate::{IoError, light, rendered, test_scenes};

/// Spectral components of scenes and of the training scene. They describe natural surfaces in daylight to a few thousandths.
const COMPONENTS: usize = 8;
/// The file with the statistics of light, and the most bytes that it has inflated.
const STATISTICS: &str = "statistics.bin";
const MOST_STATISTICS_BYTES: u64 = 1 << 30;
/// The scenes: identifier, name in the catalogue, name for people. The first is shown first.
const SCENES: [(&str, &str, &str); 5] = [
    ("brushes", "photo-brushes", "Paint brushes"),
    ("spices", "photo-spices", "Spices"),
    ("dahlia", "photo-dahlia", "Dahlia"),
    ("colorchecker", "macbeth", "ColorChecker"),
    ("leaves", "dead-leaves", "Dead leaves"),
];

/// How the studio learns: with smaller patches and a smaller training scene than a study, so that a mosaic takes a fraction of a second.
#[must_use]
pub fn learning() -> LearningSettings {
    LearningSettings { side: 5, size_px: 160, ..LearningSettings::default() }
}

/// The name in the catalogue of a scene of the studio.
#[must_use]
pub fn catalogue_name(id: &str) -> Option<&'static str> {
    SCENES.iter().find(|(own, ..)| *own == id).map(|(_, catalogue, _)| *catalogue)
}

/// The statistics of light among the files of the studio.
///
/// # Errors
/// When they are missing or damaged.
pub fn statistics_of(assets: &[StudioAsset]) -> Result<LightStatistics, IoError> {
    let path = Path::new(STATISTICS);
    let found = assets.iter().find(|asset| asset.name == STATISTICS).map_or(&[][..], |asset| &asset.bytes);
    let mut bytes = Vec::new();
    let inflated = DeflateDecoder::new(found).take(MOST_STATISTICS_BYTES).read_to_end(&mut bytes);
    inflated.map_err(|source| IoError::Read { path: path.to_owned(), source })?;
    light::from_bytes(&bytes, path)
}

/// A file of the studio.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StudioAsset {
    /// Its name, without a folder.
    pub name: String,
    /// Its content, as it is served.
    pub bytes: Vec<u8>,
}

/// Why there are no files.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StudioAssetError {
    /// The camera is invalid, or does not image a scene.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The statistics cannot be gathered.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// A scene cannot be read, or a file not be made.
    #[error(transparent)]
    Io(#[from] IoError),
}

/// The files of the studio for the lens and the pixel geometry of a camera, in daylight (D65); the page begins with this camera. Equal arguments
/// give equal bytes. This takes several seconds. Each file is one step of progress.
///
/// # Errors
/// When the camera is invalid or its lens cannot image a scene, or when it was stopped.
pub fn assets(camera: &Camera, progress: &dyn Progress) -> Result<Vec<StudioAsset>, StudioAssetError> {
    let illuminant = Illuminant::D65;
    let setup = LiveSetup::new(camera.description(), illuminant.clone(), learning());
    progress.expect(SCENES.len() as u64 + 1);
    let scenes: Vec<(Value, StudioAsset)> = SCENES
        .par_iter()
        .map(|(id, catalogue, name)| {
            if progress.is_stopped() {
                return Err(ExperimentError::Stopped.into());
            }
            let scene =
                LiveScene { name: (*id).into(), ..setup.scene(&scene(catalogue, &illuminant)?, COMPONENTS)? };
            let planes = &scene.scene.light.planes;
            let set = if rendered::find(catalogue).is_some() { "natural" } else { "charts" };
            let file = format!("{id}.bin");
            let about = json!({
                "id": id, "name": name, "set": set, "width": planes.cols, "height": planes.rows, "file": file,
            });
            let asset = deflated(file, &scene_to_bytes(&scene, Path::new(id))?);
            progress.done();
            Ok((about, asset))
        })
        .collect::<Result<_, StudioAssetError>>()?;
    let training = training_to_bytes(&setup.training(COMPONENTS)?, Path::new("training"))?;
    progress.done();
    let stored = rendered::TrainingSet::All.stored();
    let resources = Resources { training_scenes: stored, progress, ..Resources::default() };
    let statistics = light_statistics(camera, &illuminant, None, &LightSettings::default(), resources)?;
    let statistics = light::to_bytes(&statistics, Path::new("statistics"))?;
    let description = camera.description();
    let manifest = json!({
        "version": 1,
        "training": "training.bin",
        "statistics": STATISTICS,
        "scenes": scenes.iter().map(|(about, _)| about).collect::<Vec<_>>(),
        "setups": [{
            "id": description.name,
            "name": description.name,
            "illuminant": illuminant.name(),
            "fixed": {
                "optics.f_number": description.optics.f_number,
                "optics.focal_length_mm": description.optics.focal_length_mm,
                "sensor.pixel.pitch_um": description.sensor.pixel.pitch_um,
                "sensor.pixel.fill_factor": description.sensor.pixel.fill_factor,
            },
            "camera": description,
        }],
    });
    let manifest = StudioAsset { name: "manifest.json".into(), bytes: manifest.to_string().into_bytes() };
    let mut all = vec![manifest, deflated("training.bin".into(), &training)];
    all.push(deflated(STATISTICS.into(), &statistics));
    all.extend(scenes.into_iter().map(|(_, asset)| asset));
    Ok(all)
}

fn scene(name: &str, illuminant: &Illuminant) -> Result<TestScene, StudioAssetError> {
    Ok(test_scenes::test_scene(TestScene::built_in(name).name(), illuminant)?)
}

fn deflated(name: String, bytes: &[u8]) -> StudioAsset {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
    // Writing into memory does not fail.
    let bytes = encoder.write_all(bytes).and_then(|()| encoder.finish()).unwrap_or_default();
    StudioAsset { name, bytes }
}
