//! Pictures of scenes by the designs of a study.

use super::error::DesignError;
use super::pipeline_trainer::PipelineTrainer;
use super::study::{Condition, Design, Study, TrialProcessing};
use super::targets::Targets;
use crate::camera::{Camera, CameraError, EvaluationSettings, Setup};
use crate::color::Image;
use crate::isp::{Isp, WhiteBalance};
use crate::scene::Setting;
use crate::sensor::NoiseMode;
use crate::spectrum::Observer;

/// A condition and a processing of a study, which take pictures with any design. The camera and the training data do not depend on
/// the design and are kept.
#[derive(Debug)]
pub struct TrialPhotographer {
    camera: Camera,
    setting: Setting,
    /// Training data, where pipelines are learned.
    trainer: Option<PipelineTrainer>,
    seed: u64,
}

/// A scene before the camera of a [`TrialPhotographer`], for any design.
#[derive(Debug)]
pub struct TrialScene<'a> {
    photographer: &'a TrialPhotographer,
    name: String,
    setup: Setup,
    noise: NoiseMode,
}

impl TrialPhotographer {
    /// Prepares the camera of a condition and the training data of the processing.
    ///
    /// # Errors
    /// When the camera is invalid or the training scene cannot be imaged.
    pub fn new(
        study: &Study,
        condition: &Condition,
        processing: TrialProcessing,
    ) -> Result<Self, DesignError> {
        let camera = condition.camera()?;
        let Condition { luminance_cd_m2, illuminant, .. } = condition;
        let (luminance_cd_m2, seed) = (*luminance_cd_m2, study.seed);
        let setting = Setting {
            luminance_cd_m2,
            illuminant: illuminant.clone(),
            grid: camera.grid(),
            ..Setting::default()
        };
        let learn = || {
            let illuminant = illuminant.clone();
            let evaluation =
                EvaluationSettings { luminance_cd_m2, illuminant, seed, ..EvaluationSettings::default() };
            let targets = Targets::new(&camera, &evaluation, &[], &[], &|_, make| make())?;
            PipelineTrainer::new(&targets, &study.l3, &|_, make| make())
        };
        let trainer = (processing == TrialProcessing::L3).then(learn).transpose()?;
        Ok(Self { camera, setting, trainer, seed })
    }

    /// Images a scene of the catalogue, named with its parameters, with two samples per pixel in each direction.
    ///
    /// # Errors
    /// When the scene does not exist or cannot be imaged.
    pub fn scene(&self, name: &str, noise: NoiseMode) -> Result<TrialScene<'_>, DesignError> {
        let setup = Setup::of_test_scene(&self.camera, name, &self.setting)?;
        Ok(TrialScene { photographer: self, name: name.to_owned(), setup, noise })
    }
}

impl TrialScene<'_> {
    /// The picture by a design, in sRGB as it is shown: adapted to the white of the scene, its brightness adjusted.
    ///
    /// # Errors
    /// When a filter cannot be sampled, or a stage fails.
    pub fn picture(&self, design: &Design) -> Result<Image, DesignError> {
        let TrialPhotographer { camera, setting, trainer, seed } = self.photographer;
        let camera = camera.with_cfa(design.cfa(camera.grid())?);
        // The lens is the same, and so is the optical image.
        let setup = match self.setup.before(&camera)? {
            Some(setup) => setup,
            None => Setup::of_test_scene(&camera, &self.name, setting)?,
        };
        let Setup { camera, image, light, exposure } = &setup;
        let raw = camera.sensor.capture(image, exposure, self.noise, *seed).map_err(CameraError::from)?;
        let isp: Box<dyn Isp> = match trainer {
            Some(trainer) => Box::new(trainer.pipeline(&camera.sensor.cfa)?.0),
            None => Box::new(camera.isp(light, WhiteBalance::None)?),
        };
        let picture = isp.render(&raw).map_err(CameraError::from)?;
        let white = Observer::Cie1931.white(light).map_err(CameraError::from)?;
        let gain = picture.brightness_gain();
        Ok(picture.shown(Some(white), gain).map_err(CameraError::from)?)
    }
}
