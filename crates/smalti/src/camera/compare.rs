//! Captures, renders and scores one scene with one camera, the unit of all comparisons.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use serde::Serialize;

use super::score::{PICTURE_METRICS, ReferenceToScore, picture_cpsnr_db};
use super::{Camera, CameraError, PictureScores, ScoreSettings};
use crate::color::Image;
use crate::isp::Isp;
use crate::numeric::Planes;
use crate::optics::OpticalImage;
use crate::scene::{Scene, Setting, catalog};
use crate::sensor::{ElectronRates, Exposure, NoiseMode, RawImage};
use crate::spectrum::{Observer, Spectrum};

/// Samples of a test scene per pixel in each direction, so that pixels integrate over finer detail, as in real scenes.
pub const TEST_SAMPLES_PER_PX: usize = 2;

/// The scenes for comparisons of cameras, in the form of [`catalog::build`]. Pictures have at most 288 × 384 pixels at
/// [`TEST_SAMPLES_PER_PX`].
///
/// None is a training scene: the dead leaves have other seeds (above 1000) and radii, the reflectances of the
/// ColorChecker (used for the room as well) are not in the training set, and chart and star have edges in other directions. The dead
/// leaves are painted with [`reflectance::natural`](crate::spectrum::reflectance::natural), as those of training are.
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

/// A scene imaged on a camera with as many pixels as the scene covers.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The camera, with as many pixels as the scene covers.
    pub camera: Camera,
    /// The irradiance on the sensor plane.
    pub image: Arc<OpticalImage>,
    /// The illuminant of the scene: radiance of a white diffuser, photons s⁻¹ m⁻² sr⁻¹ nm⁻¹.
    pub light: Spectrum,
    /// The exposure.
    pub exposure: Exposure,
}

impl Setup {
    /// Images a scene with `samples_per_px` samples per pixel in each direction, by setting its field of view. All cameras thus
    /// capture the scene with equally many pixels. The exposure is that of the camera's description.
    ///
    /// # Errors
    /// When the scene is smaller than a pixel or a stage fails.
    pub fn new(camera: &Camera, scene: Scene, samples_per_px: usize) -> Result<Self, CameraError> {
        let samples = [scene.radiance().rows(), scene.radiance().cols()];
        Self::with_size(camera, scene, samples.map(|n| n / samples_per_px.max(1)))
    }

    /// Images a scene on `rows` × `cols` pixels.
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

    /// Images a built-in scene with natural reflectances at [`TEST_SAMPLES_PER_PX`]. `spec` is its name with parameters. The
    /// camera determines field of view and wavelengths; those of the setting are ignored.
    ///
    /// # Errors
    /// As [`catalog::build`] and [`Setup::new`].
    pub fn of_test_scene(camera: &Camera, spec: &str, setting: &Setting) -> Result<Self, CameraError> {
        let grid = camera.grid();
        let scene = catalog::build_natural(spec, &Setting { grid, ..setting.clone() })?;
        Self::new(camera, scene, TEST_SAMPLES_PER_PX)
    }

    /// The same scene on another camera, with the same optical image; `None` when the lens, the pixel pitch or the wavelengths
    /// differ and the image must be computed again.
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

    /// The same scene with its light multiplied by `factor`, at the same exposure.
    ///
    /// # Errors
    /// When the factor is negative or not finite.
    pub fn in_light(&self, factor: f64) -> Result<Self, CameraError> {
        let image = self.image.scaled(factor)?;
        Ok(Self { image: Arc::new(image), light: self.light.scaled(factor)?, ..self.clone() })
    }

    /// The same scene with an exposure time, s; with `None`, that of the camera's description.
    ///
    /// # Errors
    /// When no exposure is found.
    pub fn exposed(&self, time_s: Option<f64>) -> Result<Self, CameraError> {
        Ok(Self { exposure: self.camera.exposure_or(time_s, &self.image)?, ..self.clone() })
    }
}

/// The camera with `rows` × `cols` pixels, and the scene with their field of view.
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

/// The scores of one scene with its picture and reference.
#[derive(Debug, Clone, Serialize)]
pub struct SceneScores {
    /// The differences from the reference.
    #[serde(flatten)]
    pub scores: PictureScores,
    /// Integration time, s.
    pub exposure_time_s: f64,
    /// Saturated raw samples, percent.
    pub saturated_percent: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// X, Y, Z of the illuminant of the scene, Y = 1.
    pub white: [f64; 3],
    /// The picture, X, Y, Z under the illuminant of the scene.
    #[serde(skip)]
    pub picture: Image,
    /// The reference of the standard observer, on the scale of the picture.
    #[serde(skip)]
    pub reference: Image,
}

/// Captures a scene with all noise, renders it, and scores the picture against [`Camera::reference_as_exposed`]. `isp` renders
/// X, Y, Z under the illuminant of the scene, not adapted, on the scale of [`Classic`](crate::isp::Classic).
///
/// # Errors
/// When a stage fails or the scene is dark.
pub fn compare_on(
    setup: &Setup,
    isp: &dyn Isp,
    seed: u64,
    settings: &ScoreSettings,
) -> Result<SceneScores, CameraError> {
    let scene = IntegratedScene::new(setup.clone())?;
    Ok(scene.compare_seeds((1.0, &setup.exposure), isp, seed..seed.saturating_add(1), settings)?.first)
}

/// A scene compared for several seeds.
pub(crate) struct SeedScores {
    /// [`compare_on`] for the first seed.
    pub(crate) first: SceneScores,
    /// The raw image of the first seed.
    pub(crate) raw: RawImage,
    /// [`PictureScores::figures`] for every seed.
    pub(crate) figures: Vec<[f64; PICTURE_METRICS.len()]>,
}

/// A scene on a camera, integrated over wavelength once: all that captures and references at any multiple of its light need.
pub(crate) struct IntegratedScene {
    setup: Setup,
    rates: ElectronRates,
    /// The response of the standard observer.
    seen: Planes,
}

impl IntegratedScene {
    /// Integrates the optical image.
    ///
    /// # Errors
    /// When a curve does not cover the wavelengths of the image.
    pub(crate) fn new(setup: Setup) -> Result<Self, CameraError> {
        let Setup { camera, image, .. } = &setup;
        let witness = camera.witness(&camera.observer_channels()?)?;
        let [rates, witnessed] = ElectronRates::of_each([&camera.sensor, &witness.sensor], image)?;
        let (rates, seen) = (rates.with_pattern_of(&camera.sensor), witness.seen((&witnessed, 1.0))?);
        Ok(Self { setup, rates, seen })
    }

    /// The scene as it was imaged.
    pub(crate) fn setup(&self) -> &Setup {
        &self.setup
    }

    /// The illuminant at a multiple of its light.
    ///
    /// # Errors
    /// When the factor is negative or not finite.
    pub(crate) fn light(&self, factor: f64) -> Result<Spectrum, CameraError> {
        Ok(self.setup.light.scaled(factor)?)
    }

    /// The exposure at a multiple of the light, with a time, s, or with that of the camera's description.
    ///
    /// # Errors
    /// When no time is given and the rule finds no light.
    pub(crate) fn exposure(&self, factor: f64, time_s: Option<f64>) -> Result<Exposure, CameraError> {
        let Setup { camera, image, .. } = &self.setup;
        let time_s = match time_s {
            Some(time_s) => time_s,
            None => camera.times_in_light(image, &[factor])?[0],
        };
        camera.exposure_for(time_s, (&self.rates, factor))
    }

    fn reference(&self, factor: f64, exposure: &Exposure) -> Result<Image, CameraError> {
        let mut seen = self.seen.clone();
        seen.data_mut().iter_mut().for_each(|v| *v *= factor as f32);
        self.setup.camera.as_exposed(seen, exposure, &self.light(factor)?)
    }

    fn capture(&self, factor: f64, exposure: &Exposure, seed: u64) -> Result<RawImage, CameraError> {
        Ok(self.setup.camera.sensor.capture((&self.rates, factor), exposure, NoiseMode::All, seed)?)
    }

    /// [`compare_on`] at a multiple of the light for the first of several seeds, and the figures of the pictures for all of them, at
    /// least one.
    ///
    /// # Errors
    /// As [`compare_on`].
    pub(crate) fn compare_seeds(
        &self,
        (factor, exposure): (f64, &Exposure),
        isp: &dyn Isp,
        seeds: Range<u64>,
        settings: &ScoreSettings,
    ) -> Result<SeedScores, CameraError> {
        let white = Observer::Cie1931.white(&self.light(factor)?)?;
        let reference = self.reference(factor, exposure)?;
        let to_score = ReferenceToScore::new(&reference, white, settings)?;
        let seed = seeds.start;
        let scored = |seed: u64| -> Result<_, CameraError> {
            let raw = self.capture(factor, exposure, seed)?;
            let picture = isp.render(&raw)?;
            Ok((to_score.score(&picture)?, picture, raw))
        };
        // Each stage has parts that use one thread.
        let (first, others) = rayon::join(
            || scored(seed),
            || {
                let others = (seed.saturating_add(1)..seeds.end).into_par_iter();
                others.map(|seed| Ok(scored(seed)?.0.figures())).collect::<Result<Vec<_>, CameraError>>()
            },
        );
        let ((scores, picture, raw), others) = (first?, others?);
        let figures = std::iter::once(scores.figures()).chain(others).collect();
        let (exposure_time_s, saturated_percent) = (exposure.time_s, raw.saturated_percent());
        let first =
            SceneScores { scores, exposure_time_s, saturated_percent, seed, white, picture, reference };
        Ok(SeedScores { first, raw, figures })
    }

    /// The CPSNR of [`compare_on`] alone at a multiple of the light for each seed, dB, in a fraction of the time.
    ///
    /// # Errors
    /// As [`compare_on`].
    pub(crate) fn cpsnr_of_seeds(
        &self,
        (factor, exposure): (f64, &Exposure),
        isp: &dyn Isp,
        seeds: Range<u64>,
        settings: &ScoreSettings,
    ) -> Result<Vec<f64>, CameraError> {
        let reference = self.reference(factor, exposure)?;
        let cpsnr_db = |seed: u64| {
            let picture = isp.render(&self.capture(factor, exposure, seed)?)?;
            picture_cpsnr_db(&picture, &reference, settings)
        };
        seeds.into_par_iter().map(cpsnr_db).collect()
    }
}
