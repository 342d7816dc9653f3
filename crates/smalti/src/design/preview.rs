//! Pictures of any design of a study from light that was gathered before. The data that a page embeds suffice to capture and
//! process them as a sweep does, without scenes and lenses.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::imaged_scene::ImagedScene;
use super::pipeline_trainer::PipelineTrainer;
use super::pixel_light::{PixelLight, QuantizedLight, QuantizedPlanes};
use super::study::{Design, Study, TrialProcessing};
use super::training_data::TrainingLight;
use crate::camera::description::OpticsModelName;
use crate::camera::{Camera, CameraDescription, CameraError, Setup};
use crate::color::Image;
use crate::isp::{ColorFit, Isp, WhiteBalance};
use crate::sensor::{Cfa, NoiseMode, PixelSpectra};
use crate::spectrum::{Observer, Spectrum, WavelengthGrid};

/// Quantisation steps for the brightest pixel: twice as fine near white as a display of 8 bits.
pub(super) const STEPS: f64 = 1000.0;

/// The light of a scene on the pixels of a camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PreviewScene {
    /// The light.
    pub light: QuantizedLight,
    /// Irradiance at the metered point, photons s⁻¹ m⁻² nm⁻¹; `None` when the exposure time is stated or the rule meters all
    /// pixels.
    pub metered: Option<Vec<f64>>,
}

impl PreviewScene {
    /// The first principal components of the light of a setup.
    ///
    /// # Errors
    /// When the light on the pixels cannot be gathered or metered.
    pub fn new(setup: &Setup, max_components: usize) -> Result<Self, CameraError> {
        let sensor = &setup.camera.sensor;
        let light = PixelLight::new(sensor, &PixelSpectra::new(sensor, &setup.image)?, max_components)?;
        Ok(Self { light: light.quantized(STEPS), metered: metered(setup)? })
    }

    fn imaged(&self, camera: &Camera, factor: f64) -> Result<ImagedScene, CameraError> {
        let grid = camera.grid();
        let camera = camera.with_photodiodes(self.light.planes.rows, self.light.planes.cols);
        let pixels = self.light.light(grid)?.pixels(&camera.sensor, factor)?;
        let irradiance = |v: &Vec<f64>| scaled(v, factor, grid);
        Ok(ImagedScene::from_pixels(camera, pixels, self.metered.as_ref().map(irradiance).transpose()?))
    }
}

/// [`PreviewScene::metered`] of a setup.
///
/// # Errors
/// When the exposure rule is impossible or the optical image does not reach the sensor.
pub fn metered(setup: &Setup) -> Result<Option<Vec<f64>>, CameraError> {
    Ok(setup.camera.metered(&setup.image)?.map(|s| s.values().to_vec()))
}

fn scaled(values: &[f64], factor: f64, grid: WavelengthGrid) -> Result<Spectrum, CameraError> {
    Ok(Spectrum::new(grid, values.iter().map(|v| v * factor).collect())?)
}

/// The data that pipelines are trained with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PreviewTraining {
    /// The chart, on which exposures are found.
    pub chart: PreviewScene,
    /// The light of the training scene.
    pub light: QuantizedLight,
    /// X, Y, Z of the standard observer at every pixel of the training scene.
    pub seen: QuantizedPlanes,
    /// Y of the standard observer for white.
    pub white_y: f64,
    /// Radiance of white, photons s⁻¹ m⁻² sr⁻¹ nm⁻¹.
    pub white: Vec<f64>,
}

impl PreviewTraining {
    /// The first principal components of the light of a trainer.
    ///
    /// # Errors
    /// When a curve does not cover the wavelengths of the light.
    pub fn new(trainer: &PipelineTrainer, max_components: usize) -> Result<Self, CameraError> {
        let components = |camera: &Camera, pixels: &PixelSpectra| {
            Ok::<_, CameraError>(PixelLight::new(&camera.sensor, pixels, max_components)?.quantized(STEPS))
        };
        let data = &trainer.data;
        let chart = &data.chart;
        let largest = data.seen.data().iter().fold(0.0f32, |m, v| m.max(*v));
        Ok(Self {
            chart: PreviewScene {
                light: components(&chart.camera, &chart.pixels)?,
                metered: chart.metered().map(|s| s.values().to_vec()),
            },
            light: components(&data.camera, &data.pixels)?,
            seen: QuantizedPlanes::new(&data.seen, f64::from(largest) / STEPS),
            white_y: data.white_y,
            white: data.light.values().to_vec(),
        })
    }

    fn planes_mut(&mut self) -> [&mut QuantizedPlanes; 3] {
        [&mut self.chart.light.planes, &mut self.light.planes, &mut self.seen]
    }

    fn trainer(&self, camera: &Camera, factor: f64, study: &Study) -> Result<PipelineTrainer, CameraError> {
        let grid = camera.grid();
        let chart = Arc::new(self.chart.imaged(camera, factor)?);
        let camera = camera.with_photodiodes(self.light.planes.rows, self.light.planes.cols);
        let mut seen = self.seen.planes().map_err(crate::sensor::SensorError::from)?;
        seen.data_mut().iter_mut().for_each(|v| *v *= factor as f32);
        let light = TrainingLight {
            pixels: self.light.light(grid)?.pixels(&camera.sensor, factor)?,
            seen,
            white_y: self.white_y * factor,
            light: scaled(&self.white, factor, grid)?,
        };
        PipelineTrainer::from_light(camera, &study.l3, chart, light, study.seed)
    }
}

/// The light from which the pictures of the designs under a condition are captured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PreviewLight {
    /// Factor by which the light of the scenes and of the training data is multiplied.
    pub factor: f64,
    /// The scenes.
    pub scenes: Vec<PreviewScene>,
    /// For designs with learned pipelines.
    pub training: Option<PreviewTraining>,
}

impl PreviewLight {
    /// All planes in the order of the fields. A page stores their codes separately from the JSON.
    pub fn planes_mut(&mut self) -> impl Iterator<Item = &mut QuantizedPlanes> {
        let scenes = self.scenes.iter_mut().map(|s| &mut s.light.planes);
        scenes.chain(self.training.iter_mut().flat_map(PreviewTraining::planes_mut))
    }
}

/// A condition and a processing of a study, prepared for pictures of its designs.
#[derive(Debug)]
pub struct Preview {
    camera: Camera,
    fit: ColorFit,
    white: [f64; 3],
    scenes: Vec<ImagedScene>,
    trainer: Option<PipelineTrainer>,
    seed: u64,
}

/// A colour filter array and its processing.
pub struct PreviewDesign {
    cfa: Cfa,
    isp: Box<dyn Isp>,
}

impl Preview {
    /// Prepares the condition with an index, and a processing.
    ///
    /// # Errors
    /// When there is no such condition, the light does not match the camera, or learned pipelines lack training data.
    pub fn new(
        study: &Study,
        condition: usize,
        processing: TrialProcessing,
        light: &PreviewLight,
    ) -> Result<Self, CameraError> {
        let key = |key: &str, message: &str| CameraError::Key { key: key.into(), message: message.into() };
        let Some(condition) = study.conditions.get(condition) else {
            return Err(key("condition", "the study has fewer conditions"));
        };
        // The light has already passed the lens, so only the transmittance of the lens counts and a measured PSF is not needed.
        let mut description = CameraDescription::clone(&condition.camera);
        if description.optics.model == OpticsModelName::Psf {
            (description.optics.model, description.optics.psf) = (OpticsModelName::Pinhole, None);
        }
        let grid = description.grid()?;
        let camera = Camera::new(description, grid)?;
        let photons = condition.illuminant.photons(grid)?;
        let trainer = match (processing, &light.training) {
            (TrialProcessing::Classic, _) => None,
            (TrialProcessing::L3, Some(training)) => Some(training.trainer(&camera, light.factor, study)?),
            (TrialProcessing::L3, None) => {
                return Err(key("training", "there is no training data for learned pipelines"));
            }
        };
        let scenes =
            light.scenes.iter().map(|s| s.imaged(&camera, light.factor)).collect::<Result<_, _>>()?;
        Ok(Self {
            fit: camera.color_fit(&photons)?,
            white: Observer::Cie1931.white(&photons)?,
            camera,
            scenes,
            trainer,
            seed: study.seed,
        })
    }

    /// A design with its processing; a learned pipeline is trained here.
    ///
    /// # Errors
    /// When a filter cannot be sampled, no exposure is found or the processing cannot be built.
    pub fn design(&self, design: &Design) -> Result<PreviewDesign, CameraError> {
        let cfa = design.cfa(self.camera.grid())?;
        let isp: Box<dyn Isp> = match &self.trainer {
            Some(trainer) => Box::new(trainer.pipeline(&cfa)?.0),
            None => Box::new(self.camera.with_cfa(cfa.clone()).isp_fitted_to(&self.fit, WhiteBalance::None)?),
        };
        Ok(PreviewDesign { cfa, isp })
    }

    /// The picture of a scene by a design, in sRGB for viewing.
    ///
    /// # Errors
    /// When there is no such scene, no exposure is found or a stage fails.
    pub fn picture(
        &self,
        design: &PreviewDesign,
        scene: usize,
        noise: NoiseMode,
    ) -> Result<Image, CameraError> {
        let Some(imaged) = self.scenes.get(scene) else {
            let message = format!("there are {} scenes, counted from 0", self.scenes.len());
            return Err(CameraError::Key { key: "scene".into(), message });
        };
        let (camera, exposure) = imaged.with_cfa(&design.cfa)?;
        let raw = camera.sensor.capture(&imaged.pixels, &exposure, noise, self.seed)?;
        let picture = design.isp.render(&raw)?;
        Ok(picture.shown(Some(self.white), picture.brightness_gain())?)
    }
}
