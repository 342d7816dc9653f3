//! Pictures that chosen designs make of a scene.

use anyhow::Context;
use smalti::camera::{Camera, EvaluationSettings, Setup};
use smalti::design::{Lessons, Processing, Targets};
use smalti::isp::{Isp, WhiteBalance};
use smalti::scene::Setting;
use smalti::sensor::NoiseMode;
use smalti::spectrum::Observer;

use super::answers::Section;
use crate::pictures::Pixels;

/// Rings up to the Nyquist frequency of the sensor in the middle of each side, on 256 × 256 pixels.
pub(crate) const ZONE_PLATE: &str = "zone-plate?size=512&frequency=0.25";
/// Leaves in the colours of nature, on 288 × 384 pixels.
pub(crate) const LEAVES: &str = "dead-leaves?rows=576&cols=768&least=2&largest=150&seed=1001";

/// The camera of a section, and what its pipelines are learned from: made once for all scenes.
pub(crate) struct Studio<'a> {
    section: &'a Section<'a>,
    camera: Camera,
    setting: Setting,
    /// Where pictures are made by pipelines that are learned.
    lessons: Option<Lessons>,
}

/// A scene in a studio, ready for any of its designs.
pub(crate) struct Stage<'a> {
    studio: &'a Studio<'a>,
    setup: Setup,
    noise: NoiseMode,
}

impl<'a> Studio<'a> {
    pub(crate) fn new(section: &'a Section<'a>) -> anyhow::Result<Self> {
        let (condition, processing) = section.results.setup(section.setup).context("no such condition")?;
        let camera = Camera::new(condition.camera.clone(), condition.camera.grid()?)?;
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
        };
        let learn = || {
            let targets = Targets::new(&camera, &evaluation, &[], &[], &|_, make| make())?;
            Lessons::new(&targets, &section.results.study().l3, &|_, make| make())
        };
        let lessons = (processing == Processing::L3).then(learn).transpose()?;
        Ok(Self { section, camera, setting, lessons })
    }

    pub(crate) fn stage(&self, scene: &str, noise: NoiseMode) -> anyhow::Result<Stage<'_>> {
        let setup = Setup::of_test_scene(&self.camera, scene, &self.setting)?;
        Ok(Stage { studio: self, setup, noise })
    }
}

impl Stage<'_> {
    /// The picture that the design of a row makes.
    pub(crate) fn picture(&self, row: usize) -> anyhow::Result<Pixels> {
        let Studio { section, camera, lessons, .. } = self.studio;
        let design = section.results.design(row)?;
        let camera = camera.with_cfa(design.cfa(camera.grid())?);
        // The lens is the same, so the image is.
        let setup = self.setup.before(&camera)?.context("another lens")?;
        let Setup { camera, image, light, exposure } = &setup;
        let raw = camera.sensor.capture(image, exposure, self.noise, section.results.study().seed)?;
        let isp: Box<dyn Isp> = match lessons {
            Some(lessons) => Box::new(lessons.pipeline(&camera.sensor.cfa)?.0),
            None => Box::new(camera.isp(light, WhiteBalance::None)?),
        };
        let picture = isp.render(&raw)?;
        let white = Observer::Cie1931.white(light)?;
        Ok(Pixels::of(&picture.shown(Some(white), picture.brightness_gain())?))
    }
}
