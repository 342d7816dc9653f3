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

/// The light that pipelines are learned from.
const TRAINING: &str = "training.bin";
/// The statistics of light.
const STATISTICS: &str = "statistics.bin";

/// How the studio learns: with smaller patches and a smaller training scene than a study, so that a mosaic takes a fraction of a second.
#[must_use]
pub fn learning() -> LearningSettings {
    LearningSettings { side: 5, size_px: 160, ..LearningSettings::default() }
}

/// Which light is gathered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// That of the training scene and of the first scene, in a second. The manifest names no file for the other scenes and the statistics, and the page gathers
    /// their light from [`sources`], as it does behind another lens.
    First,
    /// All, in several seconds.
    All,
}

impl Extent {
    /// The user waits for the first light, which never leaves this machine; all of the light may be put on a web server.
    fn compression(self) -> Compression {
        match self {
            Self::First => Compression::fast(),
            Self::All => Compression::best(),
        }
    }

    /// The scenes that have a file.
    fn scenes(self) -> &'static [StudioScene] {
        match self {
            Self::First => &SCENES[..1],
            Self::All => &SCENES,
        }
    }
}

/// The illuminant of the scenes.
const ILLUMINANT: Illuminant = Illuminant::D65;

/// The files of the studio for the lens and the pixel geometry of a camera, in daylight (D65); the page begins with this camera. Equal arguments
/// give equal bytes. They are [`manifest`] and [`light_files`].
///
/// # Errors
/// As [`light_files`].
pub fn assets(camera: &Camera, progress: &dyn Progress) -> Result<Vec<StudioAsset>, StudioAssetError> {
    let light = light_files(camera, Extent::All, progress)?;
    Ok(std::iter::once(manifest(camera, Extent::All)).chain(light).collect())
}

/// `manifest.json` of the files of an extent, which takes no time.
#[must_use]
pub fn manifest(camera: &Camera, extent: Extent) -> StudioAsset {
    let description = camera.description();
    let training_sources: BTreeMap<&str, String> =
        rendered::training::NAMES.iter().map(|name| (*name, lens::training_source(name))).collect();
    let about = |(at, scene): (usize, &StudioScene)| {
        json!({
            "id": scene.id,
            "name": scene.name,
            "catalogue": scene.catalogue,
            "set": if scene.is_photograph() { "natural" } else { "charts" },
            "file": (at < extent.scenes().len()).then(|| file_of(scene)),
            "source": scene.source(),
        })
    };
    let manifest = json!({
        "training": TRAINING,
        "statistics": (extent == Extent::All).then_some(STATISTICS),
        "training_sources": training_sources,
        "scenes": SCENES.iter().enumerate().map(about).collect::<Vec<_>>(),
        "setups": [{
            "id": description.name,
            "name": description.name,
            "illuminant": ILLUMINANT.name(),
            "camera": description,
        }],
    });
    StudioAsset { name: "manifest.json".into(), bytes: manifest.to_string().into_bytes() }
}

/// The files that [`manifest`] names, other than [`sources`]. The training scene, each scene, and each scene of the statistics is one step of progress.
///
/// # Errors
/// When the camera is invalid or its lens cannot image a scene, or when it was stopped.
pub fn light_files(
    camera: &Camera,
    extent: Extent,
    progress: &dyn Progress,
) -> Result<Vec<StudioAsset>, StudioAssetError> {
    let setup = LiveSetup::new(camera.description(), ILLUMINANT, learning());
    progress.expect(extent.scenes().len() as u64 + 1);
    let scenes = || {
        let asset = |about: &StudioScene| {
            if progress.is_stopped() {
                return Err(ExperimentError::Stopped.into());
            }
            let source = rendered::find(about.catalogue).and_then(|stored| stored.photograph());
            let scene = scene_light(&setup, about.id, source)?;
            let asset = deflated(file_of(about), &scene_to_bytes(&scene, Path::new(about.id))?, extent)?;
            progress.done();
            Ok(asset)
        };
        extent.scenes().par_iter().map(asset).collect::<Result<Vec<_>, StudioAssetError>>()
    };
    let training = || {
        let bytes = training_to_bytes(&training_light(&setup)?, Path::new("training"))?;
        progress.done();
        Ok::<_, StudioAssetError>(deflated(TRAINING.into(), &bytes, extent)?)
    };
    let (scenes, training) = rayon::join(scenes, training);
    let statistics = match extent {
        Extent::First => None,
        Extent::All => {
            let stored = rendered::TrainingSet::All.stored();
            let found = statistics_of_light(camera, &ILLUMINANT, stored, progress)?;
            let bytes = light::to_bytes(&found, Path::new("statistics"))?;
            Some(deflated(STATISTICS.into(), &bytes, extent)?)
        }
    };
    Ok(std::iter::once(training?).chain(statistics).chain(scenes?).collect())
}

/// The name of the file of a scene.
fn file_of(scene: &StudioScene) -> String {
    format!("{}.bin", scene.id)
}

fn deflated(name: String, bytes: &[u8], extent: Extent) -> Result<StudioAsset, IoError> {
    let mut encoder = DeflateEncoder::new(Vec::new(), extent.compression());
    let bytes = encoder.write_all(bytes).and_then(|()| encoder.finish());
    let bytes = bytes.map_err(IoError::writing(Path::new(&name)))?;
    Ok(StudioAsset { name, bytes })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use serde_json::Value;
    use smalti::camera::CameraDescription;
    use smalti::experiment::Silent;
    use smalti::spectrum::WavelengthGrid;

    use super::*;

    /// The files of light that a manifest names.
    fn named(manifest: &StudioAsset) -> BTreeSet<String> {
        let manifest: Value = serde_json::from_slice(&manifest.bytes).unwrap();
        let scenes = manifest["scenes"].as_array().unwrap().iter().map(|scene| &scene["file"]);
        let files = scenes.chain([&manifest["training"], &manifest["statistics"]]);
        files.filter_map(Value::as_str).map(str::to_owned).collect()
    }

    #[test]
    fn a_manifest_names_the_files_of_its_light() {
        let camera = Camera::new(CameraDescription::default(), WavelengthGrid::VISIBLE).unwrap();
        let light = light_files(&camera, Extent::First, &Silent).unwrap();
        let files: BTreeSet<String> = light.into_iter().map(|file| file.name).collect();
        assert_eq!(named(&manifest(&camera, Extent::First)), files);
        let all = named(&manifest(&camera, Extent::All));
        assert!(all.is_superset(&files));
        assert_eq!(all.len(), SCENES.len() + 2);
    }
}
