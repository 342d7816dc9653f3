//! Pipelines of designs, learned from statistics of the light of one training scene, or from its patches where they saturate.

use std::collections::VecDeque;
use std::sync::Arc;

use serde::Serialize;

use super::setup::{LiveSetup, LiveTraining};
use super::target_light::TargetLight;
use crate::camera::description::{CameraDescription, CfaDescription, IspDescription};
use crate::camera::stable_text::stable_text;
use crate::camera::{Camera, CameraError, training_reflectances};
use crate::design::latest::keep_latest;
use crate::design::learning_settings::{LearningSettings, LearningStatistics};
use crate::design::pipeline_trainer::{PipelineTrainer, THOROUGH_LEVELS};
use crate::design::pixel_light::PixelLight;
use crate::design::targets::has_independent_samples;
use crate::design::training_data::TrainingLight;
use crate::l3::Pipeline;
use crate::numeric::Planes;
use crate::sensor::SensorError;
use crate::spectrum::{Observer, Spectrum};

/// Conditions whose training data are kept, about 10 MB each.
const KEPT: usize = 4;

/// How pipelines are learned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LiveEffort {
    /// As those of studies, in a millisecond where the mosaic is known: from statistics of light at the exposure of the design, or from patches
    /// where the training scene saturates it.
    Quick,
    /// From patches at several exposures, from the dark up to saturation. Scores of pictures are nearer to those of pipelines that are learned from
    /// all training scenes.
    #[default]
    Thorough,
}

/// A design under a light, with the pipeline that was learned for it.
#[derive(Debug, Clone)]
pub struct LiveDesign {
    pub(super) camera: Camera,
    /// Transmittance of the lens.
    pub(super) lens: Spectrum,
    pub(super) pipeline: Pipeline,
    pub(super) luminance_cd_m2: f64,
    learned_from: LearningStatistics,
    effort: LiveEffort,
    /// Seed of the noise in which patches were classified.
    seed: u64,
}

/// The provenance of a pipeline, as stored in its file.
#[derive(Serialize)]
struct Provenance<'a> {
    smalti_version: &'a str,
    learned_in: &'a str,
    camera: &'a CameraDescription,
    learning: LearningSettings,
    illuminant: String,
    luminance_cd_m2: f64,
    seed: u64,
    scenes: [String; 2],
}

impl LiveDesign {
    /// The camera.
    #[must_use]
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The pipeline.
    #[must_use]
    pub fn pipeline(&self) -> &Pipeline {
        &self.pipeline
    }

    /// The mean luminance of the scenes, cd/m².
    #[must_use]
    pub fn luminance_cd_m2(&self) -> f64 {
        self.luminance_cd_m2
    }
}

/// Learns the pipelines of designs. It keeps the training data of the latest conditions: of designs that differ in filters and mosaic alone
/// they are the same.
#[derive(Debug)]
pub struct LiveLearner {
    setup: LiveSetup,
    light: PixelLight,
    pub(super) chart: TargetLight,
    pub(super) edge: TargetLight,
    pub(super) low_contrast_edge: TargetLight,
    seen: Planes,
    white_y: f64,
    white: Spectrum,
    /// Reflectances of uniform surfaces, some of which are saturated.
    saturated: Vec<Spectrum>,
    kept: VecDeque<(String, Arc<PipelineTrainer>)>,
}

impl LiveLearner {
    /// A learner with the light of a training scene.
    ///
    /// # Errors
    /// When the parts of the light do not fit each other.
    pub fn new(training: LiveTraining) -> Result<Self, CameraError> {
        let LiveTraining { setup, training, edge, low_contrast_edge } = training;
        setup.learning.validate()?;
        let grid = setup.bare.grid()?;
        Ok(Self {
            light: training.light.light(grid)?,
            chart: TargetLight::new(&training.chart, grid)?,
            edge: TargetLight::new(&edge, grid)?,
            low_contrast_edge: TargetLight::new(&low_contrast_edge, grid)?,
            seen: training.seen.planes().map_err(SensorError::from)?,
            white_y: training.white_y,
            white: Spectrum::new(grid, training.white)?,
            saturated: training_reflectances(grid)?,
            kept: VecDeque::new(),
            setup,
        })
    }

    /// The setup of the light.
    #[must_use]
    pub fn setup(&self) -> &LiveSetup {
        &self.setup
    }

    /// The camera of a description, if it fits the setup.
    ///
    /// # Errors
    /// [`CameraError::Key`] with the first key that is invalid or differs from the setup.
    pub fn camera(&self, description: &CameraDescription) -> Result<Camera, CameraError> {
        self.setup.ensure_fits(description)?;
        let camera = Camera::new(description.clone(), self.setup.bare.grid()?)?;
        camera.ensure_one_gain()?;
        if !has_independent_samples(&camera.sensor) {
            let message = "pipelines are learned from statistics of light, which hold for a mosaic without crosstalk and binning";
            return Err(CameraError::Key { key: "sensor".into(), message: message.into() });
        }
        Ok(camera)
    }

    /// Learns the pipeline of a design for scenes of a mean luminance. `seed` is that of the noise in which patches are classified.
    ///
    /// With quick effort, a design that the training scene saturates is learned from the patches of its capture: statistics of light do not describe
    /// clipping. This takes longer.
    ///
    /// # Errors
    /// When the design is invalid or does not fit the setup, or its filters pass no light.
    pub fn learn(
        &mut self,
        description: &CameraDescription,
        luminance_cd_m2: f64,
        seed: u64,
        effort: LiveEffort,
    ) -> Result<LiveDesign, CameraError> {
        if !(luminance_cd_m2 > 0.0 && luminance_cd_m2.is_finite()) {
            let message = format!("{luminance_cd_m2}; expected a number above 0");
            return Err(CameraError::Key { key: "luminance_cd_m2".into(), message });
        }
        let camera = self.camera(description)?;
        let lens = camera.optics.transmittance_on(camera.grid())?;
        let trainer = self.trainer(&camera, &lens, luminance_cd_m2, seed)?;
        let cfa = &camera.sensor.cfa;
        let (pipeline, learned_from) = match effort {
            LiveEffort::Quick => trainer.pipeline_in_any_light(cfa)?,
            LiveEffort::Thorough => {
                (trainer.thorough_pipeline(cfa, &self.saturated)?, LearningStatistics::Patches)
            }
        };
        Ok(LiveDesign { camera, lens, pipeline, luminance_cd_m2, learned_from, effort, seed })
    }

    /// The pipeline of a design that was learned here, to be kept in a file: with its white point, and with a provenance that states how
    /// and on which scenes it was learned.
    ///
    /// # Errors
    /// When the illuminant does not lie on the wavelengths of the setup.
    pub fn table(&self, design: &LiveDesign) -> Result<Pipeline, CameraError> {
        let LiveDesign { camera, pipeline, luminance_cd_m2, learned_from, effort, seed, .. } = design;
        let LiveSetup { illuminant, learning, .. } = &self.setup;
        let mut learning = LearningSettings { statistics: *learned_from, ..learning.clone() };
        if *effort == LiveEffort::Thorough {
            learning.levels = THOROUGH_LEVELS;
        }
        let provenance = stable_text(&Provenance {
            smalti_version: env!("CARGO_PKG_VERSION"),
            learned_in: match (effort, learned_from) {
                (LiveEffort::Thorough, _) => "the studio, from patches at several exposures",
                (_, LearningStatistics::Light) => "the studio, from statistics of light",
                (_, LearningStatistics::Patches) => "the studio, from patches",
            },
            camera: camera.description(),
            illuminant: illuminant.name(),
            luminance_cd_m2: *luminance_cd_m2,
            seed: *seed,
            scenes: [
                format!("training scene {} of studies, {1} × {1} pixels", learning.scene, learning.size_px),
                match effort {
                    LiveEffort::Quick => "uniform surfaces with the reflectances that the colour matrix is fitted to",
                    LiveEffort::Thorough => {
                        "uniform surfaces with the reflectances that the colour matrix is fitted to, and with those of training"
                    }
                }
                .into(),
            ],
            learning,
        })?;
        let white = Observer::Cie1931.white(&illuminant.photons(camera.grid())?)?;
        Ok(pipeline.clone().with_white(Some(white)).with_provenance(provenance))
    }

    fn trainer(
        &mut self,
        camera: &Camera,
        lens: &Spectrum,
        luminance_cd_m2: f64,
        seed: u64,
    ) -> Result<Arc<PipelineTrainer>, CameraError> {
        let mut shared = camera.description().clone();
        shared.name = String::new();
        shared.sensor.cfa = CfaDescription::default();
        shared.isp = IspDescription::default();
        let key = stable_text(&(&shared, luminance_cd_m2.to_bits(), seed))?;
        if let Some(at) = self.kept.iter().position(|(k, _)| *k == key)
            && let Some(found) = self.kept.remove(at)
        {
            self.kept.push_back(found.clone());
            return Ok(found.1);
        }
        let chart = self.chart.imaged(camera, lens, luminance_cd_m2)?;
        let planes = self.light.planes();
        let camera = camera.with_size(planes.rows(), planes.cols());
        let pixels = self.light.behind(&camera.sensor, lens, luminance_cd_m2)?;
        let mut seen = self.seen.clone();
        seen.data_mut().iter_mut().for_each(|v| *v *= luminance_cd_m2 as f32);
        let light = TrainingLight {
            pixels,
            seen,
            white_y: self.white_y * luminance_cd_m2,
            light: self.white.scaled(luminance_cd_m2)?,
        };
        let trainer =
            PipelineTrainer::from_light(camera, &self.setup.learning, Arc::new(chart), light, seed)?;
        let trainer = Arc::new(trainer);
        keep_latest(&mut self.kept, KEPT, (key, trainer.clone()));
        Ok(trainer)
    }
}
