//! Training an L³ pipeline for every colour filter array of a study, from light that is gathered once.
//!
//! The light of one training scene on every pixel and the X, Y, Z of the standard observer do not depend on the filters, so
//! [`PipelineTrainer`] keeps them. Each design then needs a capture with noise and one without, one pass of statistics, and the
//! solution of the kernels; or only the latter, with [statistics of the light](super::class_light). A design is trained at its exposure for the ColorChecker of [`Targets`](super::Targets), so that
//! noise and levels are those of its scores.

use std::sync::Arc;

use super::imaged_scene::ImagedScene;
use super::learning_settings::{LearningSettings, LearningStatistics};
use super::light_trainer::LightTrainer;
use super::targets::Targets;
use super::training_scene;
use crate::camera::chart::LUMINANCE;
use crate::camera::stable_text::stable_text;
use crate::camera::{Camera, CameraError, OpticalImages};
use crate::l3::{Axes, L3Error, Levels, Pair, Pipeline, Statistics, Training};
use crate::numeric::Planes;
use crate::scene::{self, Setting, macbeth};
use crate::sensor::{Cfa, Exposure, Mosaic, NoiseMode, PixelSpectra};
use crate::spectrum::{Observer, Spectrum};

/// Range of the cuts between levels, as fractions of the response to white. Outside it, noise and kernels change little.
const LEVEL_RANGE: [f64; 2] = [0.03, 0.6];
/// Least response of a channel to white, relative to the brightest channel. Levels need a response above 0.
const MIN_WHITE: f64 = 1e-3;
/// Number of patches that a uniform surface counts for at each position. Of 16, 64, 128 and 256, it is the smallest with which
/// five sets of Gaussian filters all have a smaller ΔE 1976 and ΔE 2000 on the surfaces than the fitted colour matrix. Larger
/// numbers cost some resolution and cause false colour on black-and-white patterns.
pub(super) const SURFACE_PATCHES: u32 = 128;

/// The training scene on the pixels of a camera, with its reference.
#[derive(Debug)]
pub(super) struct TrainingLight {
    pub(super) pixels: PixelSpectra,
    /// X, Y, Z of the reference at every pixel.
    pub(super) seen: Planes,
    /// Y of the reference for white.
    pub(super) white_y: f64,
    /// Radiance of white, photons.
    pub(super) light: Spectrum,
}

/// Trains the pipeline of any colour filter array on one camera. It keeps everything that does not depend on the filters.
#[derive(Debug, Clone)]
pub struct PipelineTrainer {
    settings: LearningSettings,
    /// The chart, on which the exposure is found.
    pub(super) chart: Arc<ImagedScene>,
    pub(super) camera: Camera,
    pub(super) pixels: Arc<PixelSpectra>,
    /// X, Y, Z of the reference at every pixel.
    pub(super) seen: Arc<Planes>,
    /// Uniform surfaces: radiance and X, Y, Z, with Y = 1 for fully lit white.
    pub(super) surfaces: Arc<Vec<(Spectrum, [f64; 3])>>,
    /// Y of the reference for white.
    pub(super) white_y: f64,
    pub(super) light: Spectrum,
    pub(super) seed: u64,
    /// `None` where pipelines are learned from patches.
    from_light: Option<LightTrainer>,
}

/// A design at its exposure for the chart.
pub(super) struct ExposedDesign {
    pub(super) camera: Camera,
    pub(super) exposure: Exposure,
    /// The factor from X, Y, Z of the reference to targets.
    pub(super) scale: f64,
    /// Electrons per photon that enters the lens, for each channel.
    responsivities: Vec<Spectrum>,
    /// Response of the brightest channel to white.
    brightest: f64,
    /// Y of white on the scale of the targets, and the response of the brightest channel to white on that of the samples.
    pub(super) full: f64,
    pub(super) axes: Axes,
}

impl ExposedDesign {
    /// The normalised samples of a surface, one for each channel.
    pub(super) fn samples(&self, radiance: &Spectrum) -> Vec<f64> {
        responses(&self.responsivities, radiance).iter().map(|r| r / self.brightest * self.full).collect()
    }
}

fn responses(responsivities: &[Spectrum], light: &Spectrum) -> Vec<f64> {
    let of = |r: &Spectrum| r.values().iter().zip(light.values()).map(|(r, l)| r * l).sum();
    responsivities.iter().map(of).collect()
}

impl PipelineTrainer {
    /// A trainer for the camera, luminance, illuminant and noise seed of targets. `images` may cache optical images, as in
    /// [`evaluate`](crate::camera::evaluate).
    ///
    /// # Errors
    /// When a setting is out of its range or a stage fails.
    pub fn new(
        targets: &Targets,
        settings: &LearningSettings,
        images: OpticalImages<'_>,
    ) -> Result<Self, CameraError> {
        settings.validate()?;
        targets.chart.camera.ensure_one_gain()?;
        let size = settings.size_px;
        let setting = targets.setting.clone();
        let light = macbeth::chart(1, &setting)?.illuminant().clone();
        let camera = targets.chart.camera.with_size(size, size);
        let horizontal_fov_deg = camera.field_of_view_deg(size, setting.distance_m)?;
        let wide = Setting { horizontal_fov_deg, ..setting.clone() };
        let key = stable_text(&("training", size, settings.scene, &wide, &camera.optics))?;
        let image = images(&key, &|| {
            Ok(camera.optics.image(&training_scene::scene(&camera, size, settings.scene, &light, &wide)?)?)
        })?;
        let luminance_cd_m2 = Observer::Cie1931.xyz_from_photons(&light)?[LUMINANCE];
        let white = scene::uniform(8, 8, &Setting { luminance_cd_m2, ..setting })?;
        let small = camera.with_size(1, 1);
        let white = small.seen_by_observer(&small.optics.image(&white)?)?;
        let light = TrainingLight {
            pixels: PixelSpectra::new(&camera.sensor, &image)?,
            seen: camera.seen_by_observer(&image)?,
            white_y: white.plane(LUMINANCE)?.iter().map(|&y| f64::from(y)).sum(),
            light,
        };
        Self::from_light(camera, settings, targets.chart.clone(), light, targets.seed)
    }

    /// A trainer from light that was gathered before, on a camera with as many pixels as the light.
    pub(super) fn from_light(
        camera: Camera,
        settings: &LearningSettings,
        chart: Arc<ImagedScene>,
        light: TrainingLight,
        seed: u64,
    ) -> Result<Self, CameraError> {
        settings.validate()?;
        let TrainingLight { pixels, seen, white_y, light } = light;
        let luminance_cd_m2 = Observer::Cie1931.xyz_from_photons(&light)?[LUMINANCE];
        let xyz = |s: Spectrum| {
            let seen = Observer::Cie1931.xyz_from_photons(&s)?.map(|v| v / luminance_cd_m2);
            Ok::<_, CameraError>((s, seen))
        };
        let surfaces =
            training_scene::surfaces(&camera, &light)?.into_iter().map(xyz).collect::<Result<_, _>>()?;
        let (settings, surfaces): (LearningSettings, _) = (settings.clone(), Arc::new(surfaces));
        let from_light = match settings.statistics {
            LearningStatistics::Patches => None,
            LearningStatistics::Light => Some(LightTrainer::new(&camera, &settings, &pixels)?),
        };
        let (pixels, seen) = (Arc::new(pixels), Arc::new(seen));
        Ok(Self { settings, chart, camera, pixels, seen, surfaces, white_y, light, seed, from_light })
    }

    /// Trains the pipeline of a colour filter array. Also returns its reach: each pixel of its pictures depends on samples at
    /// most that many rows away.
    ///
    /// # Errors
    /// When the filters pass no light, the mosaic has more channels than L³ supports, or a stage fails.
    pub fn pipeline(&self, cfa: &Cfa) -> Result<(Pipeline, usize), CameraError> {
        let design = self.exposed(cfa)?;
        let pipeline = match &self.from_light {
            Some(trainer) => trainer.pipeline(self, &design)?,
            None => {
                let training = Training { solver: self.settings.solver, ..Training::default() };
                training.solve(&self.statistics(&design)?, String::new())?
            }
        };
        let reach = pipeline.reach();
        Ok((pipeline, reach))
    }

    /// Gathers what designs with a mosaic have in common, if it is not known yet. [`PipelineTrainer::pipeline`] does so when needed; doing
    /// it before the designs of a sweep are scored on several threads avoids that each thread does it.
    ///
    /// # Errors
    /// As [`PipelineTrainer::pipeline`].
    pub fn prepare(&self, mosaic: &Mosaic) -> Result<(), CameraError> {
        self.from_light.as_ref().map_or(Ok(()), |trainer| trainer.prepare(self, mosaic))
    }

    /// The exposure of a design for the chart, and the classes of its samples.
    pub(super) fn exposed(&self, cfa: &Cfa) -> Result<ExposedDesign, CameraError> {
        let (_, exposure) = self.chart.with_cfa(cfa)?;
        let camera = self.camera.with_cfa(cfa.clone());
        let y = &Observer::Cie1931.photon_weights(camera.grid())?[LUMINANCE];
        let scale = camera.exposure_scale(&exposure, &self.light, y)?;
        let responsivities = camera.responsivities()?;
        let white = responses(&responsivities, &self.light);
        let brightest = white.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        // At this exposure, the response of the brightest channel to white equals Y of white.
        let full = scale * self.white_y;
        let white: Vec<f64> = white.iter().map(|w| (w / brightest).max(MIN_WHITE) * full).collect();
        let noise = camera.sensor.signal_noise(&exposure)?;
        let axes = Axes::new(cfa.mosaic().clone(), self.settings.side, self.levels(cfa, &white)?, noise)?
            .with_levels_by_position(&white)?
            .with_textures(self.settings.textures);
        Ok(ExposedDesign { camera, exposure, scale, responsivities, brightest, full, axes })
    }

    /// The moments of the patches of a capture by a design.
    fn statistics(&self, design: &ExposedDesign) -> Result<Statistics, CameraError> {
        let ExposedDesign { camera, exposure, scale, full, axes, .. } = design;
        let outputs = ["X", "Y", "Z"].map(String::from).to_vec();
        let mut statistics = Statistics::new(axes.clone(), outputs, false)?;
        let raw = camera.sensor.capture_ideal(&*self.pixels, exposure)?;
        let seen = camera.sensor.capture(&*self.pixels, exposure, NoiseMode::All, self.seed)?;
        let mut target = Planes::clone(&self.seen);
        target.data_mut().iter_mut().for_each(|v| *v *= *scale as f32);
        statistics.add(&Pair { raw: &raw, seen: Some(&seen), target: &target })?;
        for (radiance, xyz) in &*self.surfaces {
            statistics.add_even(&design.samples(radiance), &xyz.map(|v| v * full), SURFACE_PATCHES)?;
        }
        Ok(statistics)
    }

    /// Cuts in equal ratios of the mean response over the tile.
    fn levels(&self, cfa: &Cfa, white: &[f64]) -> Result<Levels, L3Error> {
        let cells = cfa.mosaic().cells();
        let sum: f64 = cells.iter().filter_map(|&c| white.get(usize::from(c))).sum();
        let mean = sum / cells.len().max(1) as f64;
        let [least, most] = LEVEL_RANGE;
        let cuts = self.settings.levels.saturating_sub(1);
        let cut = |i: usize| (mean * least * libm::pow(most / least, (i as f64 + 0.5) / cuts as f64)) as f32;
        Levels::new((0..cuts).map(cut).collect())
    }
}
