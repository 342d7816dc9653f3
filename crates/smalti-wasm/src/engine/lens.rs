//! The light behind one lens, on pixels of one geometry, and what it is gathered from.

use std::collections::BTreeMap;
use std::path::Path;

use smalti::camera::{Camera, CameraDescription};
use smalti::design::light::LightStatistics;
use smalti::design::live::{LiveLearner, LivePictures, LiveScene, LiveSetup};
use smalti::experiment::Silent;
use smalti::spectrum::Illuminant;
use smalti_io::{light, studio};

use super::error::EngineError;
use super::file::StudioFile;
use super::photograph::Photograph;
use super::request::LightOf;

/// What was loaded of the light behind one lens.
#[derive(Default)]
pub(super) struct Lens {
    learner: Option<LiveLearner>,
    /// Scenes whose light is not prepared yet.
    waiting: BTreeMap<String, LiveScene>,
    scenes: BTreeMap<String, LivePictures>,
    statistics: Option<LightStatistics>,
}

impl Lens {
    pub(super) fn load(&mut self, kind: StudioFile, bytes: &[u8]) -> Result<(), EngineError> {
        match kind {
            StudioFile::Training => {
                let training = studio::training_from_bytes(bytes, Path::new("training"))?;
                self.learner = Some(LiveLearner::new(training)?);
            }
            StudioFile::Scene => {
                let scene = studio::scene_from_bytes(bytes, Path::new("scene"))?;
                self.scenes.remove(&scene.name);
                self.waiting.insert(scene.name.clone(), scene);
            }
            StudioFile::Statistics => {
                self.statistics = Some(light::from_bytes(bytes, Path::new("statistics"))?);
            }
        }
        Ok(())
    }

    pub(super) fn learner(&mut self) -> Result<&mut LiveLearner, EngineError> {
        self.learner.as_mut().ok_or(EngineError::Missing("the light of the training scene"))
    }

    pub(super) fn statistics(&self) -> Result<&LightStatistics, EngineError> {
        self.statistics.as_ref().ok_or(EngineError::Missing("the statistics of light"))
    }

    /// The scene, prepared for pictures.
    pub(super) fn pictures(&mut self, scene: &str) -> Result<&mut LivePictures, EngineError> {
        if let Some(waiting) = self.waiting.remove(scene) {
            let setup = self.learner()?.setup();
            let pictures = LivePictures::new(waiting, &setup.illuminant, &setup.camera()?)?;
            self.scenes.insert(scene.to_owned(), pictures);
        }
        self.scenes.get_mut(scene).ok_or_else(|| EngineError::NoScene(scene.to_owned()))
    }
}

/// What light is gathered from, by name.
#[derive(Default)]
pub(super) struct Sources {
    pub(super) files: BTreeMap<String, Vec<u8>>,
    pub(super) photographs: BTreeMap<String, Photograph>,
}

impl Sources {
    /// The file of the light behind the lens and on the pixels of a camera, in daylight (D65): the same as that of
    /// [`studio::assets`](smalti_io::studio::assets) for this camera.
    pub(super) fn light(&self, camera: CameraDescription, of: &LightOf) -> Result<Vec<u8>, EngineError> {
        let illuminant = Illuminant::D65;
        let setup = LiveSetup::new(&camera, illuminant.clone(), studio::learning());
        Ok(match of {
            LightOf::Training => {
                studio::training_to_bytes(&studio::training_light(&setup)?, Path::new("training"))?
            }
            LightOf::Scene(id) => {
                let scene = match self.photographs.get(id) {
                    Some(photograph) => photograph.light(id, &setup)?,
                    None => studio::scene_light(&setup, id, self.files.get(id).map(Vec::as_slice))?,
                };
                studio::scene_to_bytes(&scene, Path::new(id))?
            }
            LightOf::Statistics => {
                let grid = camera.grid()?;
                let camera = Camera::new(camera, grid)?;
                let stored = studio::TrainingFiles(&self.files);
                let found = studio::statistics_of_light(&camera, &illuminant, &stored, &Silent)?;
                light::to_bytes(&found, Path::new("statistics"))?
            }
        })
    }
}
