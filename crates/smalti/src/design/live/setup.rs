//! The lens and pixel geometry of live pictures, and the light behind them.

use serde::{Deserialize, Serialize};

use crate::camera::description::{
    AutoExposureName, CameraDescription, ExposureDescription, IspDescription, OpticsDescription,
    PixelDescription, SensorDescription,
};
use crate::camera::target::Target;
use crate::camera::{Camera, CameraError, EvaluationSettings, Setup, TestScene};
use crate::design::imaged_scene::ImagedScene;
use crate::design::learning_settings::{LearningSettings, LearningStatistics};
use crate::design::pipeline_trainer::PipelineTrainer;
use crate::design::pixel_light::PixelLight;
use crate::design::preview::{PreviewScene, PreviewTraining, STEPS};
use crate::design::targets::Targets;
use crate::sensor::Filter;
use crate::spectrum::Illuminant;

/// Mean luminance of the light of setups, cd/m².
const LUMINANCE_CD_M2: f64 = 1.0;

/// What designs cannot change: the lens apart from its transmittance, the geometry of the pixels, the illuminant, and how pipelines are
/// learned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LiveSetup {
    /// The camera with a clear lens and bare pixels; see [`LiveSetup::new`].
    pub bare: CameraDescription,
    /// The illuminant of the scenes.
    pub illuminant: Illuminant,
    /// How pipelines are learned: always from statistics of light, and from patches where the training scene saturates a design.
    pub learning: LearningSettings,
}

/// The light of a scene of 1 cd/m² on bare pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LiveScene {
    /// Its name.
    pub name: String,
    /// The light.
    pub scene: PreviewScene,
}

/// The light of the training scene and of the targets of 1 cd/m² on bare pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LiveTraining {
    /// What it was gathered behind.
    pub setup: LiveSetup,
    /// The light.
    pub training: PreviewTraining,
    /// The light of the edge of high contrast, on which resolution is measured.
    pub edge: PreviewScene,
    /// The light of the edge with a luminance ratio of 4:1.
    pub low_contrast_edge: PreviewScene,
}

impl LiveSetup {
    /// The setup of a camera: its lens and pixel geometry. Everything else of the camera is left out.
    #[must_use]
    pub fn new(camera: &CameraDescription, illuminant: Illuminant, learning: LearningSettings) -> Self {
        let pixel = PixelDescription {
            pitch_um: camera.sensor.pixel.pitch_um,
            fill_factor: camera.sensor.pixel.fill_factor,
            ..PixelDescription::default()
        };
        let optics =
            OpticsDescription { transmittance: Filter::Flat(1.0), ir_cut: None, ..camera.optics.clone() };
        let bare = CameraDescription {
            name: "bare".into(),
            wavelengths_nm: camera.wavelengths_nm,
            optics,
            sensor: SensorDescription { pixel, ..SensorDescription::default() },
            exposure: ExposureDescription::default(),
            isp: IspDescription::default(),
        };
        Self {
            bare,
            illuminant,
            learning: LearningSettings { statistics: LearningStatistics::Light, ..learning },
        }
    }

    /// The camera with a clear lens and bare pixels.
    ///
    /// # Errors
    /// When a key is invalid.
    pub fn camera(&self) -> Result<Camera, CameraError> {
        Camera::new(self.bare.clone(), self.bare.grid()?)
    }

    /// Checks that a camera has the lens and the pixel geometry of the setup.
    ///
    /// # Errors
    /// [`CameraError::Key`] with the first key whose value is another.
    pub fn ensure_fits(&self, camera: &CameraDescription) -> Result<(), CameraError> {
        let own = Self::new(camera, self.illuminant.clone(), self.learning.clone()).bare;
        let differs = |key: &str, found: String, expected: String| CameraError::Key {
            key: key.into(),
            message: format!("{found}; the light of the scenes was gathered with {expected}"),
        };
        let (found, expected) = (&own.sensor.pixel, &self.bare.sensor.pixel);
        for (key, found, expected) in [
            ("sensor.pixel.pitch_um", found.pitch_um, expected.pitch_um),
            ("sensor.pixel.fill_factor", found.fill_factor, expected.fill_factor),
            ("optics.f_number", own.optics.f_number, self.bare.optics.f_number),
            ("optics.focal_length_mm", own.optics.focal_length_mm, self.bare.optics.focal_length_mm),
        ] {
            if found.to_bits() != expected.to_bits() {
                return Err(differs(key, found.to_string(), expected.to_string()));
            }
        }
        if own.grid()? != self.bare.grid()? {
            let text =
                |d: &CameraDescription| format!("{:?}", d.wavelengths_nm.unwrap_or([400.0, 10.0, 700.0]));
            return Err(differs("wavelengths_nm", text(&own), text(&self.bare)));
        }
        if own.optics != self.bare.optics {
            return Err(differs("optics", "another lens".into(), "the lens of the setup".into()));
        }
        match camera.exposure.auto {
            Some(AutoExposureName::Luminance) => Err(CameraError::Key {
                key: "exposure.auto".into(),
                message: "luminance meters a point that depends on the percentile; expected time_ms, specular or mean".into(),
            }),
            _ => Ok(()),
        }
    }

    /// The light of a scene on bare pixels, in `components` spectral components.
    ///
    /// # Errors
    /// When the scene cannot be built or imaged.
    pub fn scene(&self, scene: &TestScene, components: usize) -> Result<LiveScene, CameraError> {
        let setup: Setup = scene.before(&self.camera()?, &self.illuminant)?;
        Ok(LiveScene { name: scene.name().to_owned(), scene: PreviewScene::new(&setup, components)? })
    }

    /// The light of the training scene and of the targets on bare pixels, in `components` spectral components.
    ///
    /// # Errors
    /// When a setting is out of range or the scene cannot be imaged.
    pub fn training(&self, components: usize) -> Result<LiveTraining, CameraError> {
        let evaluation = EvaluationSettings {
            luminance_cd_m2: LUMINANCE_CD_M2,
            illuminant: self.illuminant.clone(),
            ..EvaluationSettings::default()
        };
        let targets = Targets::new(&self.camera()?, &evaluation, &[], &[], &|_, make| make())?;
        let trainer = PipelineTrainer::new(&targets, &self.learning, &|_, make| make())?;
        let setting = evaluation.setting(self.bare.grid()?);
        let light = |target: Target| {
            let imaged = ImagedScene::of_target(&target, &|_, make| make())?;
            let light = PixelLight::new(&imaged.camera.sensor, &imaged.pixels, components)?;
            let metered = imaged.metered().map(|s| s.values().to_vec());
            Ok::<_, CameraError>(PreviewScene { light: light.quantized(STEPS), metered })
        };
        let camera = self.camera()?;
        Ok(LiveTraining {
            setup: self.clone(),
            training: PreviewTraining::new(&trainer, components)?,
            edge: light(Target::edge(&camera, &setting)?)?,
            low_contrast_edge: light(Target::low_contrast_edge(&camera, &setting)?)?,
        })
    }
}
