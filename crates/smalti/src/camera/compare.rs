//! One scene before a camera, taken and processed and scored: what comparisons of cameras and of processing are made of.

use std::sync::Arc;

use serde::Serialize;

use super::score::score_picture;
use super::{Camera, CameraError, PictureScores, ScoreSettings};
use crate::color::Image;
use crate::isp::Isp;
use crate::optics::OpticalImage;
use crate::scene::{Scene, Setting, catalog};
use crate::sensor::{Exposure, NoiseMode};
use crate::spectrum::{Observer, Spectrum};

/// Samples of a test scene per pixel of the sensor, in each direction: a pixel integrates over detail finer than itself, as
/// outside.
pub const TEST_SAMPLES_PER_PX: usize = 2;

/// Scenes to compare cameras on, as [`catalog::build`] takes them, for pictures of at most 288 × 384 pixels at
/// [`TEST_SAMPLES_PER_PX`].
///
/// Nothing is trained on them: the leaves have a seed above 1000 and other radii than training has, the reflectances of the
/// ColorChecker (the room is painted with them too) are not among those of training, and chart and star have edges of other
/// directions.
#[must_use]
pub fn test_scenes() -> &'static [&'static str] {
    &[
        "dead-leaves?rows=576&cols=768&least=2&largest=150&seed=1001",
        "macbeth?patch=128",
        "resolution-chart?rows=576",
        "siemens-star?size=576",
        "hdr?rows=384",
    ]
}

/// A scene before a camera that is cut to it.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The camera, with as many pixels as the scene covers.
    pub camera: Camera,
    /// What the lens throws on the sensor.
    pub image: Arc<OpticalImage>,
    /// The light on the scene: radiance of a white diffuser, photons s⁻¹ m⁻² sr⁻¹ nm⁻¹.
    pub light: Spectrum,
    /// How it is taken.
    pub exposure: Exposure,
}

impl Setup {
    /// A scene before a camera, so large that a pixel spans `samples_per_px` of its samples in each direction; its field of view
    /// is set accordingly. So every camera sees a scene with equally many pixels. The exposure is that of the
    /// camera's description.
    ///
    /// # Errors
    /// When the scene has no whole pixel, or a stage refuses.
    pub fn new(camera: &Camera, scene: Scene, samples_per_px: usize) -> Result<Self, CameraError> {
        let samples = [scene.radiance().rows(), scene.radiance().cols()];
        Self::with_size(camera, scene, samples.map(|n| n / samples_per_px.max(1)))
    }

    /// A scene before a camera that spans `size` pixels, rows and columns.
    pub(super) fn with_size(
        camera: &Camera,
        scene: Scene,
        [rows, cols]: [usize; 2],
    ) -> Result<Self, CameraError> {
        let (camera, scene) = cut_to(camera, scene, [rows, cols])?;
        let image = Arc::new(camera.optics.image(&scene)?);
        let exposure = camera.exposure(&image)?;
        Ok(Self { light: scene.illuminant().clone(), camera, image, exposure })
    }

    /// A built-in scene by its words, leaves painted with natural reflectances, at [`TEST_SAMPLES_PER_PX`].
    /// Field of view and wavelengths are those of the camera, whatever the setting says.
    ///
    /// # Errors
    /// As [`catalog::build`] and [`Setup::new`].
    pub fn of_test_scene(camera: &Camera, spec: &str, setting: &Setting) -> Result<Self, CameraError> {
        let grid = camera.grid();
        let scene = catalog::build_natural(spec, &Setting { grid, ..setting.clone() })?;
        Self::new(camera, scene, TEST_SAMPLES_PER_PX)
    }

    /// The same scene before another camera, without forming the image again: `None` where its lens, pitch or wavelengths
    /// differ, so that another image falls on its sensor.
    ///
    /// # Errors
    /// When no exposure is found.
    pub fn before(&self, camera: &Camera) -> Result<Option<Self>, CameraError> {
        let own = &self.camera;
        let same = own.optics == camera.optics
            && own.sensor.pixel.pitch_m == camera.sensor.pixel.pitch_m
            && own.grid() == camera.grid();
        if !same {
            return Ok(None);
        }
        let camera = camera.with_size(own.sensor.rows, own.sensor.cols);
        let exposure = camera.exposure(&self.image)?;
        Ok(Some(Self { camera, exposure, ..self.clone() }))
    }

    /// The same scene in `factor` times the light, at the same exposure.
    ///
    /// # Errors
    /// When the factor is negative or not finite.
    pub fn in_light(&self, factor: f64) -> Result<Self, CameraError> {
        let image = self.image.scaled(factor)?;
        Ok(Self { image: Arc::new(image), light: self.light.scaled(factor), ..self.clone() })
    }

    /// The same scene, exposed anew as the camera's description says.
    ///
    /// # Errors
    /// When no exposure is found.
    pub fn exposed(&self) -> Result<Self, CameraError> {
        Ok(Self { exposure: self.camera.exposure(&self.image)?, ..self.clone() })
    }
}

/// A camera with as many pixels as a scene covers, and the scene as wide as they see.
pub(crate) fn cut_to(
    camera: &Camera,
    scene: Scene,
    [rows, cols]: [usize; 2],
) -> Result<(Camera, Scene), CameraError> {
    let camera = camera.with_size(rows, cols);
    camera.sensor.validate()?;
    let fov_deg = camera.field_of_view_deg(cols, scene.distance_m())?;
    Ok((camera, scene.with_fov(fov_deg)?))
}

/// How well a scene came out.
#[derive(Debug, Clone, Serialize)]
pub struct SceneScores {
    /// The distance from the reference.
    #[serde(flatten)]
    pub scores: PictureScores,
    /// Integration time, s.
    pub exposure_time_s: f64,
    /// Share of the raw samples that are saturated, percent.
    pub saturated_percent: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// The picture, XYZ under the scene's light.
    #[serde(skip)]
    pub picture: Image,
    /// What the standard observer sees, on the scale of the picture.
    #[serde(skip)]
    pub reference: Image,
}

/// Takes a scene with all noise, processes it, scores the picture against
/// [`Camera::reference_as_exposed`]. `isp` makes XYZ as they are under the scene's light, on the scale of
/// [`Classic`](crate::isp::Classic).
///
/// # Errors
/// When a stage refuses, or the scene is dark.
pub fn compare_on(
    setup: &Setup,
    isp: &dyn Isp,
    seed: u64,
    settings: &ScoreSettings,
) -> Result<SceneScores, CameraError> {
    let Setup { camera, image, light, exposure } = setup;
    let raw = camera.sensor.capture(image, exposure, NoiseMode::All, seed)?;
    let (picture, reference) =
        rayon::join(|| isp.render(&raw), || camera.reference_as_exposed(image, exposure, light));
    let (picture, reference) = (picture?, reference?);
    let scores = score_picture(&picture, &reference, Observer::Cie1931.white(light)?, settings)?;
    let (exposure_time_s, saturated_percent) = (exposure.time_s, raw.saturated_percent());
    Ok(SceneScores { scores, exposure_time_s, saturated_percent, seed, picture, reference })
}
