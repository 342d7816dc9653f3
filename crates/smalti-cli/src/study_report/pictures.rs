//! Pictures that chosen designs make of a scene.

use anyhow::Context;
use smalti::camera::{Camera, EvaluationSettings, Setup};
use smalti::color::Image;
use smalti::design::{Lessons, Processing, Targets};
use smalti::isp::{Isp, WhiteBalance};
use smalti::scene::Setting;
use smalti::sensor::NoiseMode;
use smalti::spectrum::Observer;

use super::answers::Section;
use crate::brightness::brightness_gain;
use crate::pictures::shown;

/// Rings up to the Nyquist frequency of the sensor in the middle of each side, on 256 × 256 pixels.
pub(crate) const ZONE_PLATE: &str = "zone-plate?size=512&frequency=0.25";
/// Leaves in the colours of nature, on 288 × 384 pixels.
pub(crate) const LEAVES: &str = "dead-leaves?rows=576&cols=768&least=2&largest=150&seed=1001";

/// A scene before the camera of a section, ready for any of its designs.
pub(crate) struct Stage<'a> {
    section: &'a Section<'a>,
    camera: Camera,
    setup: Setup,
    noise: NoiseMode,
    /// Where pictures are made by pipelines that are learned.
    lessons: Option<Lessons>,
}

/// A picture, 8-bit sRGB row by row.
pub(crate) struct Picture {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) rgb: Vec<u8>,
}

impl<'a> Stage<'a> {
    pub(crate) fn new(section: &'a Section<'a>, scene: &str, noise: NoiseMode) -> anyhow::Result<Self> {
        let (condition, processing) = section.results.setup(section.setup).context("no such condition")?;
        let camera = Camera::new(condition.camera.clone(), condition.camera.grid()?)?;
        let setting = Setting {
            luminance_cd_m2: condition.luminance_cd_m2,
            illuminant: condition.illuminant.clone(),
            grid: camera.grid(),
            ..Setting::default()
        };
        let setup = Setup::of_test_scene(&camera, scene, &setting)?;
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
        Ok(Self { section, camera, setup, noise, lessons })
    }

    /// The picture that the design of a row makes.
    pub(crate) fn picture(&self, row: usize) -> anyhow::Result<Picture> {
        let design = self.section.results.design(row)?;
        let camera = self.camera.with_cfa(design.cfa(self.camera.grid())?);
        // The lens is the same, so the image is.
        let setup = self.setup.before(&camera)?.context("another lens")?;
        let Setup { camera, image, light, exposure } = &setup;
        let raw = camera.sensor.capture(image, exposure, self.noise, self.section.results.study().seed)?;
        let isp: Box<dyn Isp> = match &self.lessons {
            Some(lessons) => Box::new(lessons.pipeline(&camera.sensor.cfa)?.0),
            None => Box::new(camera.isp(light, WhiteBalance::None)?),
        };
        let picture = isp.render(&raw)?;
        let white = Observer::Cie1931.xyz_from_photons(light)?;
        let white = white.map(|v| v / white[1]);
        Ok(bytes(&shown(&picture, white, brightness_gain(&picture))?))
    }
}

fn bytes(image: &Image) -> Picture {
    let planes = image.planes();
    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
    let rgb = (0..image.rows() * image.cols())
        .flat_map(|i| [0, 1, 2].map(|c| byte(planes.plane(c).get(i).copied().unwrap_or(0.0))))
        .collect();
    Picture { width: image.cols(), height: image.rows(), rgb }
}
