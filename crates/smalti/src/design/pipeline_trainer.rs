//! Training an L³ pipeline for every colour filter array of a study, from light that is gathered once.
//!
//! The light of one training scene on every pixel and the X, Y, Z of the standard observer do not depend on the filters, so
//! [`PipelineTrainer`] keeps them. Each design then needs a capture with noise and one without, one pass of statistics, and the
//! solution of the kernels; or only the latter, with [statistics of the light](super::class_light). A design is trained at its
//! exposure for the ColorChecker of [`Targets`](super::Targets), so that noise and levels are those of its scores.

use std::f64::consts::SQRT_2;
use std::sync::Arc;

use super::imaged_scene::ImagedScene;
use super::learning_settings::{LearningSettings, LearningStatistics};
use super::light_trainer::LightTrainer;
use super::targets::Targets;
use super::training_data::{ExposedDesign, LevelCuts, SURFACE_PATCHES, Surface, TrainingData, TrainingLight};
use super::training_scene;
use crate::camera::chart::LUMINANCE;
use crate::camera::score::{Brightness, limit_brightness};
use crate::camera::stable_text::stable_text;
use crate::camera::{Camera, CameraError, HIGHEST_CUT, OpticalImages};
use crate::l3::{EvenField, Pair, Pipeline, Statistics, Training};
use crate::numeric::Planes;
use crate::scene::{self, Setting, macbeth};
use crate::sensor::{Cfa, ElectronRates, Exposure, Mosaic, NoiseMode, PixelSpectra};
use crate::spectrum::{Observer, Spectrum};

/// Ratio of each exposure of [`PipelineTrainer::thorough_pipeline`] to the next, from the longest down. Pictures have parts that are darker and
/// brighter than the training scene. Where samples clip, exposures are closer, since different channels clip at each of them.
const EXPOSURE_RATIOS: [f64; 10] = [SQRT_2, SQRT_2, SQRT_2, SQRT_2, SQRT_2, 2.0, 2.0, 2.0, 2.0, 2.0];
/// The response of white at the longest of them, relative to saturation, and the limits of that exposure relative to that of the design.
const OVEREXPOSED: f64 = 3.0;
const LONGEST: [f64; 2] = [2.0, 10.0];
/// Levels of its pipelines, and the range of their cuts relative to the response to white.
pub(super) const THOROUGH_LEVELS: usize = 8;
const THOROUGH_RANGE: [f64; 2] = [0.01, 2.0];
/// Numbers of patches that a uniform surface counts for at each of its exposures: one of those that the colour matrix is fitted to, and one of those
/// with saturated colours, of which two channels can clip long before white does.
const THOROUGH_SURFACE_PATCHES: u32 = 64;
const SATURATED_SURFACE_PATCHES: u32 = 16;

/// Trains the pipeline of any colour filter array on one camera. It keeps everything that does not depend on the filters.
#[derive(Debug, Clone)]
pub struct PipelineTrainer {
    pub(super) data: TrainingData,
    /// `None` where pipelines are learned from patches.
    from_light: Option<LightTrainer>,
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
        let data = TrainingData::new(camera, settings, chart, light, seed)?;
        let from_light = match settings.statistics {
            LearningStatistics::Patches => None,
            LearningStatistics::Light => Some(LightTrainer::new(&data)?),
        };
        Ok(Self { data, from_light })
    }

    /// Trains the pipeline of a colour filter array. Also returns its reach: each pixel of its pictures depends on samples at
    /// most that many rows away.
    ///
    /// # Errors
    /// When the filters pass no light, the mosaic has more channels than L³ supports, or a stage fails.
    pub fn pipeline(&self, cfa: &Cfa) -> Result<(Pipeline, usize), CameraError> {
        let design = self.data.exposed(cfa)?;
        let pipeline = match &self.from_light {
            Some(trainer) => trainer.pipeline(&self.data, &design)?,
            None => self.quick_patch_pipeline(&design)?,
        };
        let reach = pipeline.reach();
        Ok((pipeline, reach))
    }

    /// [`PipelineTrainer::pipeline`], also where the training scene saturates the design, which statistics of the light do not describe: there it is
    /// learned from the patches of a capture, which have classes of clipped samples. Also returns what it was learned from.
    pub(super) fn pipeline_in_any_light(
        &self,
        cfa: &Cfa,
    ) -> Result<(Pipeline, LearningStatistics), CameraError> {
        let design = self.data.exposed(cfa)?;
        match self.from_light.as_ref().map(|trainer| trainer.pipeline(&self.data, &design)) {
            None | Some(Err(CameraError::TrainingSaturates { .. })) => {
                Ok((self.quick_patch_pipeline(&design)?, LearningStatistics::Patches))
            }
            Some(learned) => Ok((learned?, LearningStatistics::Light)),
        }
    }

    /// A pipeline that is learned from patches at several exposures, from the dark up to saturation, and from uniform surfaces of `saturated`
    /// reflectances. It takes a few hundredths of a second.
    pub(super) fn thorough_pipeline(
        &self,
        cfa: &Cfa,
        saturated: &[Spectrum],
    ) -> Result<Pipeline, CameraError> {
        let cuts = LevelCuts { levels: THOROUGH_LEVELS, range: THOROUGH_RANGE, highest: HIGHEST_CUT };
        let design = self.data.exposed_in(cfa, &cuts)?;
        let longest = (OVEREXPOSED / design.full).clamp(LONGEST[0], LONGEST[1]);
        let shorter = EXPOSURE_RATIOS.iter().scan(longest, |exposure, ratio| {
            *exposure /= ratio;
            Some(*exposure)
        });
        let exposures: Vec<f64> = [longest].into_iter().chain(shorter).collect();
        let most = design.camera.knowable_luminance(&self.data.light)?;
        let saturated = self.data.surfaces_of(saturated)?;
        let surfaces =
            [(&**self.data.surfaces, THOROUGH_SURFACE_PATCHES), (&*saturated, SATURATED_SURFACE_PATCHES)];
        self.patch_pipeline(&design, &PatchTraining { exposures: &exposures, surfaces: &surfaces, most })
    }

    /// A pipeline that is learned from patches at the exposure of a design.
    fn quick_patch_pipeline(&self, design: &ExposedDesign) -> Result<Pipeline, CameraError> {
        let surfaces = [(&**self.data.surfaces, SURFACE_PATCHES)];
        self.patch_pipeline(
            design,
            &PatchTraining { exposures: &[1.0], surfaces: &surfaces, most: f64::INFINITY },
        )
    }

    fn patch_pipeline(
        &self,
        design: &ExposedDesign,
        from: &PatchTraining<'_>,
    ) -> Result<Pipeline, CameraError> {
        let training = Training { solver: self.data.settings.solver, ..Training::default() };
        Ok(training.solve(&self.statistics(design, from)?, String::new())?)
    }

    /// Gathers what designs with a mosaic have in common, if it is not known yet. [`PipelineTrainer::pipeline`] does so when needed; doing
    /// it before the designs of a sweep are scored on several threads avoids that each thread does it.
    ///
    /// # Errors
    /// As [`PipelineTrainer::pipeline`].
    pub fn prepare(&self, mosaic: &Mosaic) -> Result<(), CameraError> {
        self.from_light.as_ref().map_or(Ok(()), |trainer| trainer.prepare(&self.data, mosaic))
    }

    /// The moments of the patches of captures by a design.
    fn statistics(
        &self,
        design: &ExposedDesign,
        from: &PatchTraining<'_>,
    ) -> Result<Statistics, CameraError> {
        let (ExposedDesign { camera, exposure, scale, full, axes, .. }, data) = (design, &self.data);
        let outputs = ["X", "Y", "Z"].map(String::from).to_vec();
        let mut statistics = Statistics::new(axes.clone(), outputs, false)?;
        let rates = ElectronRates::of_pixels(&camera.sensor, &data.pixels)?.with_pattern_of(&camera.sensor);
        let mut surfaces: Vec<(Vec<f64>, &[f64; 3], u32)> = Vec::new();
        for &(some, times) in from.surfaces {
            surfaces.extend(some.iter().map(|(radiance, xyz)| (design.samples(radiance), xyz, times)));
        }
        for (seed, &factor) in (data.seed..).zip(from.exposures) {
            let exposure = Exposure { time_s: exposure.time_s * factor, ..*exposure };
            let raw = camera.sensor.capture_ideal((&rates, 1.0), &exposure)?;
            let seen = camera.sensor.capture((&rates, 1.0), &exposure, NoiseMode::All, seed)?;
            let mut target = Planes::clone(&data.seen);
            target.data_mut().iter_mut().for_each(|v| *v *= (scale * factor) as f32);
            limit_brightness(&mut target, from.most as f32, Brightness::Plane(LUMINANCE))?;
            statistics.add(&Pair { raw: &raw, seen: Some(&seen), target: &target })?;
            let exposed = |(samples, xyz, times): &(Vec<f64>, &[f64; 3], u32)| {
                let bright = (full * factor).min(from.most / xyz[LUMINANCE]);
                EvenField {
                    samples: samples.iter().map(|v| v * factor).collect(),
                    target: xyz.map(|v| v * bright).to_vec(),
                    times: *times,
                }
            };
            statistics.add_even(&surfaces.iter().map(exposed).collect::<Vec<_>>())?;
        }
        Ok(statistics)
    }
}

/// What a pipeline is learned from in addition to the training scene, and at which exposures.
struct PatchTraining<'a> {
    /// The exposures, relative to that of the design.
    exposures: &'a [f64],
    /// Uniform surfaces, and the number of patches that each of them counts for at every exposure.
    surfaces: &'a [(&'a [Surface], u32)],
    /// The largest Y of a target, on the scale of the samples. The raw image does not determine the luminance of brighter light.
    most: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{CameraDescription, EvaluationSettings};
    use crate::l3::Textures;
    use crate::spectrum::WavelengthGrid;

    /// A thorough pipeline has learned from darker light than one that is learned at the exposure of the design, and from light as bright.
    #[test]
    fn thorough_learning_reaches_into_the_dark() {
        let camera = Camera::new(CameraDescription::default(), WavelengthGrid::VISIBLE).unwrap();
        let settings = EvaluationSettings::default();
        let targets = Targets::new(&camera, &settings, &[], &[], &|_, make| make()).unwrap();
        let settings = LearningSettings {
            side: 3,
            size_px: 48,
            statistics: LearningStatistics::Patches,
            textures: Textures::None,
            ..LearningSettings::default()
        };
        let trainer = PipelineTrainer::new(&targets, &settings, &|_, make| make()).unwrap();
        let cfa = &camera.sensor.cfa;
        let quick = trainer.quick_patch_pipeline(&trainer.data.exposed(cfa).unwrap()).unwrap();
        let thorough = trainer.thorough_pipeline(cfa, &[]).unwrap();
        assert_eq!(quick.trained().len(), thorough.trained().len());
        for (one, many) in quick.trained().iter().zip(thorough.trained()) {
            assert!(many[0] < 0.5 * one[0] && many[1] > 0.9 * one[1], "{one:?} {many:?}");
        }
    }
}
