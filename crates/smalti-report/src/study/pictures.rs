//! Pictures of scenes by chosen designs.

use smalti::camera::{Camera, CameraError, EvaluationSettings, Setup};
use smalti::design::{Condition, PipelineTrainer, Targets, TrialProcessing};
use smalti::isp::{Isp, WhiteBalance};
use smalti::scene::Setting;
use smalti::sensor::NoiseMode;
use smalti::spectrum::Observer;

use super::sections::Section;
use crate::ReportError;
use crate::pictures::Pixels;

/// Rings up to the Nyquist frequency of the sensor in the middle of each side, on 256 × 256 pixels.
pub(super) const ZONE_PLATE: &str = "zone-plate?size=512&frequency=0.25";
/// Dead leaves with natural colours, on 288 × 384 pixels.
pub(super) const LEAVES: &str = "dead-leaves?rows=576&cols=768&least=2&largest=150&seed=1001";

/// The camera of a section and the training data of its pipelines, which all scenes share.
pub(super) struct SectionSetup<'a> {
    section: &'a Section<'a>,
    camera: Camera,
    setting: Setting,
    /// Training data, where pipelines are learned.
    trainer: Option<PipelineTrainer>,
}

/// A scene before the camera, for any design.
pub(super) struct SceneSetup<'a> {
    section: &'a SectionSetup<'a>,
    setup: Setup,
    noise: NoiseMode,
}

/// Condition and processing of a section, and its camera.
pub(super) fn camera_of<'a>(
    section: &Section<'a>,
) -> Result<(&'a Condition, TrialProcessing, Camera), ReportError> {
    let (condition, processing) =
        section.results.setup(section.setup).ok_or(ReportError::Missing { what: "condition" })?;
    let camera = Camera::new(condition.camera.clone(), condition.camera.grid()?)?;
    Ok((condition, processing, camera))
}

impl<'a> SectionSetup<'a> {
    pub(super) fn new(section: &'a Section<'a>) -> Result<Self, ReportError> {
        let (condition, processing, camera) = camera_of(section)?;
        let setting = Setting {
            luminance_cd_m2: condition.luminance_cd_m2,
            illuminant: condition.illuminant.clone(),
            grid: camera.grid(),
            ..Setting::default()
        };
        let evaluation = EvaluationSettings {
            luminance_cd_m2: condition.luminance_cd_m2,
            illuminant: condition.illuminant.clone(),
            seed: section.results.study().seed,
            ..EvaluationSettings::default()
        };
        let learn = || {
            let targets = Targets::new(&camera, &evaluation, &[], &[], &|_, make| make())?;
            PipelineTrainer::new(&targets, &section.results.study().l3, &|_, make| make())
        };
        let trainer = (processing == TrialProcessing::L3).then(learn).transpose()?;
        Ok(Self { section, camera, setting, trainer })
    }

    pub(super) fn scene(&self, scene: &str, noise: NoiseMode) -> Result<SceneSetup<'_>, ReportError> {
        let setup = Setup::of_test_scene(&self.camera, scene, &self.setting)?;
        Ok(SceneSetup { section: self, setup, noise })
    }
}

impl SceneSetup<'_> {
    /// The picture by the trial of a row.
    pub(super) fn picture(&self, row: usize) -> Result<Pixels, ReportError> {
        let SectionSetup { section, camera, trainer, .. } = self.section;
        let design = section.results.trial(row)?.design;
        let camera = camera.with_cfa(design.cfa(camera.grid())?);
        // The lens is the same, and so is the optical image.
        let setup =
            self.setup.before(&camera)?.ok_or(ReportError::Missing { what: "image before another lens" })?;
        let Setup { camera, image, light, exposure } = &setup;
        let raw = camera.sensor.capture(image, exposure, self.noise, section.results.study().seed);
        let raw = raw.map_err(CameraError::from)?;
        let isp: Box<dyn Isp> = match trainer {
            Some(trainer) => Box::new(trainer.pipeline(&camera.sensor.cfa)?.0),
            None => Box::new(camera.isp(light, WhiteBalance::None)?),
        };
        let picture = isp.render(&raw).map_err(CameraError::from)?;
        let white = Observer::Cie1931.white(light)?;
        Ok(Pixels::of(&picture.shown(Some(white), picture.brightness_gain())?))
    }
}
