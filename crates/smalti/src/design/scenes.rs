//! Scenes chosen by the user, on which a study scores designs in addition to the targets.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::imaged_scene::ImagedScene;
use super::scores::SceneFigures;
use crate::camera::compare::cut_to;
use crate::camera::stable_text::stable_text;
use crate::camera::{Camera, CameraError, OpticalImages, ScoreSettings, TEST_SAMPLES_PER_PX, score_picture};
use crate::isp::Isp;
use crate::numeric::Planes;
use crate::scene::{Scene, Setting, catalog};
use crate::sensor::{Cfa, NoiseMode};
use crate::spectrum::{Observer, Spectrum};

/// Maximum number of pixels of a scene. The light on each of them is kept in memory at every wavelength.
const MAX_PIXELS: usize = 1 << 20;

/// A scene of a study. Its JSON holds the name and the hash of a file, but not the content of the file.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct StudyScene {
    /// A built-in scene with its parameters, as accepted by [`catalog::build`], or the name of a file.
    pub name: String,
    /// Hash of the content of the file; `None` for a built-in scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hash: Option<String>,
    /// The content of the file.
    #[serde(skip)]
    pub scene: Option<Arc<Scene>>,
}

impl PartialEq for StudyScene {
    /// Compares name and hash.
    fn eq(&self, other: &Self) -> bool {
        (&self.name, &self.hash) == (&other.name, &other.hash)
    }
}

impl StudyScene {
    /// The scene in a setting, and the number of samples that a pixel spans in each direction: [`TEST_SAMPLES_PER_PX`] for a
    /// built-in scene, 1 for a file. A file is relit with the illuminant and the mean luminance of the setting.
    fn build(&self, setting: &Setting) -> Result<(Scene, usize), CameraError> {
        match (&self.scene, &self.hash) {
            (Some(scene), _) => {
                let scene = Scene::clone(scene).resampled(setting.grid)?.relit(&setting.illuminant)?;
                Ok((scene.with_mean_luminance(setting.luminance_cd_m2)?, 1))
            }
            (None, None) => Ok((catalog::build_natural(&self.name, setting)?, TEST_SAMPLES_PER_PX)),
            (None, Some(_)) => {
                Err(CameraError::Key { key: self.name.clone(), message: "the file has not been read".into() })
            }
        }
    }

    /// Its name without folder, parameters and extension.
    #[must_use]
    pub fn short_name(&self) -> &str {
        let name = self.name.split('?').next().unwrap_or(&self.name);
        let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
        match name.rsplit_once('.') {
            Some((stem, _)) if !stem.is_empty() => stem,
            _ => name,
        }
    }
}

/// A scene imaged on the camera of a study, with the reference seen by the standard observer.
#[derive(Debug, Clone)]
pub(super) struct SceneTarget {
    imaged: ImagedScene,
    /// X, Y, Z of the reference at every pixel.
    seen: Arc<Planes>,
    light: Spectrum,
}

impl SceneTarget {
    pub(super) fn new(
        camera: &Camera,
        scene: &StudyScene,
        setting: &Setting,
        images: OpticalImages<'_>,
    ) -> Result<Self, CameraError> {
        let (built, samples_per_px) = scene.build(setting)?;
        let radiance = built.radiance();
        let [rows, cols] = [radiance.rows(), radiance.cols()].map(|n| n / samples_per_px);
        if rows * cols > MAX_PIXELS {
            let message =
                format!("{rows} × {cols} pixels; at most {MAX_PIXELS} are scored: take a part of it");
            return Err(CameraError::Key { key: scene.name.clone(), message });
        }
        let (camera, built) = cut_to(camera, built, [rows, cols])?;
        let fov_deg = built.horizontal_fov_deg();
        let key = stable_text(&(&scene.name, &scene.hash, fov_deg, setting, &camera.optics))?;
        let image = images(&key, &|| Ok(camera.optics.image(&built)?))?;
        let seen = Arc::new(camera.seen_by_observer(&image)?);
        Ok(Self { light: built.illuminant().clone(), imaged: ImagedScene::new(camera, image)?, seen })
    }

    /// Scores the picture of a colour filter array and its processing against the reference, with all noise.
    pub(super) fn score(&self, cfa: &Cfa, isp: &dyn Isp, seed: u64) -> Result<SceneFigures, CameraError> {
        let (camera, exposure) = self.imaged.with_cfa(cfa)?;
        let raw = camera.sensor.capture(&self.imaged.pixels, &exposure, NoiseMode::All, seed)?;
        let picture = isp.render(&raw)?;
        let reference = camera.as_exposed(Planes::clone(&self.seen), &exposure, &self.light)?;
        let scores = score_picture(
            &picture,
            &reference,
            Observer::Cie1931.white(&self.light)?,
            &ScoreSettings::default(),
        )?;
        Ok(SceneFigures {
            cpsnr_db: scores.cpsnr_db,
            pixel_delta_e_2000_mean: scores.pixel_delta_e_2000_mean,
            scielab_mean: scores.scielab_mean,
            saturated_percent: raw.saturated_percent(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::{Illuminant, WavelengthGrid};

    fn scene(name: &str) -> StudyScene {
        StudyScene { name: name.into(), hash: None, scene: None }
    }

    #[test]
    fn short_names_have_no_folder_parameters_or_extension() {
        for (name, short) in [
            ("dead-leaves?rows=96&cols=128", "dead-leaves"),
            ("photos/lake.hdr", "lake"),
            (r"C:\photos\lake.old.npz", "lake.old"),
            ("macbeth", "macbeth"),
            ("folder.d/lake", "lake"),
            ("photos/.hidden", ".hidden"),
            ("chart?file=a/b.csv", "chart"),
        ] {
            assert_eq!(scene(name).short_name(), short);
        }
    }

    /// A built-in scene is built, a file is relit, and a file that was not read is named. Sums are of single precision.
    #[test]
    fn scenes_have_the_light_of_the_setting() {
        let setting = Setting {
            luminance_cd_m2: 40.0,
            illuminant: Illuminant::A,
            grid: WavelengthGrid::new(400.0, 20.0, 16).unwrap(),
            ..Setting::default()
        };
        let daylight = catalog::build_natural("macbeth?patch=4", &Setting::default()).unwrap();
        let read =
            StudyScene { scene: Some(Arc::new(daylight)), hash: Some("0".into()), name: "lake.npz".into() };
        for (scene, samples_per_px) in [(scene("macbeth?patch=4"), TEST_SAMPLES_PER_PX), (read.clone(), 1)] {
            let (built, found) = scene.build(&setting).unwrap();
            assert_eq!((found, built.radiance().grid()), (samples_per_px, setting.grid));
            let luminance = built.mean_luminance_cd_m2().unwrap();
            assert!((luminance / 40.0 - 1.0).abs() < 1e-4, "{luminance}");
        }
        let unread = StudyScene { scene: None, ..read.clone() };
        assert!(matches!(unread.build(&setting), Err(CameraError::Key { key, .. }) if key == "lake.npz"));
        // The content follows from the hash.
        assert!(unread == read && unread != scene("lake.npz"));
    }
}
