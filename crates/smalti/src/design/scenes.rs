//! Scenes of one's own that designs are scored on beside the targets.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::scores::SceneFigures;
use super::shown::Shown;
use crate::camera::compare::cut_to;
use crate::camera::{Camera, CameraError, OpticalImages, ScoreSettings, TEST_SAMPLES_PER_PX, score_picture};
use crate::isp::Isp;
use crate::numeric::Planes;
use crate::scene::{Scene, Setting, catalog};
use crate::sensor::{Cfa, NoiseMode};
use crate::spectrum::{Observer, Spectrum};

/// Most pixels of a scene: the light on each of them is kept at every wavelength.
const MAX_PIXELS: usize = 1 << 20;

/// A scene of a study. As JSON it is its name and, of a file, the hash; what was in the file is not part of it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct StudyScene {
    /// A built-in scene with its parameters, as [`catalog::build`] takes it; or the name of a file.
    pub name: String,
    /// Hash of what is in the file; `None` for a built-in scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hash: Option<String>,
    /// What was in the file.
    #[serde(skip)]
    pub scene: Option<Arc<Scene>>,
}

impl PartialEq for StudyScene {
    /// By name and hash.
    fn eq(&self, other: &Self) -> bool {
        (&self.name, &self.hash) == (&other.name, &other.hash)
    }
}

impl StudyScene {
    /// The scene in a setting, and how many of its samples a pixel spans in each direction. A built-in one has
    /// [`TEST_SAMPLES_PER_PX`]; a file is not spread over fewer pixels than it has samples, and is put under light and
    /// luminance of the setting.
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

    /// The first part of its name, without folder, parameters and extension.
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

/// A scene before the camera of a study, and what the standard observer sees of it.
#[derive(Debug, Clone)]
pub(super) struct View {
    shown: Shown,
    /// X, Y, Z per pixel.
    seen: Arc<Planes>,
    light: Spectrum,
}

impl View {
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
        let key = format!("{} {:?} {fov_deg} {setting:?} {:?}", scene.name, scene.hash, camera.optics);
        let image = images(&key, &|| Ok(camera.optics.image(&built)?))?;
        let seen = Arc::new(camera.seen_by_observer(&image)?);
        Ok(Self { light: built.illuminant().clone(), shown: Shown::new(camera, image)?, seen })
    }

    /// The distance of the picture that a colour filter array and its processing make, with all noise.
    pub(super) fn score(&self, cfa: &Cfa, isp: &dyn Isp, seed: u64) -> Result<SceneFigures, CameraError> {
        let (camera, exposure) = self.shown.through(cfa)?;
        let raw = camera.sensor.capture(&self.shown.pixels, &exposure, NoiseMode::All, seed)?;
        let picture = isp.render(&raw)?;
        let reference = camera.as_exposed(Planes::clone(&self.seen), &exposure, &self.light)?;
        let found = score_picture(
            &picture,
            &reference,
            Observer::Cie1931.white(&self.light)?,
            &ScoreSettings::default(),
        )?;
        Ok(SceneFigures {
            cpsnr_db: found.cpsnr_db,
            pixel_delta_e_2000_mean: found.pixel_delta_e_2000_mean,
            scielab_mean: found.scielab_mean,
        })
    }
}
