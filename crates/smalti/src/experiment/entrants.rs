//! Scores of many cameras with learned pipelines: as those of a comparison, with figures alone, which fit into memory for any number.

use rayon::prelude::*;
use serde::Serialize;

use super::comparison::{imaged, scene_scores};
use super::contender::Contender;
use super::error::StageContext;
use super::exposure::{ExposurePlan, ExposurePolicy};
use super::picture_figures::{LightFigures, PictureFigures};
use super::pipelines::{PipelineTask, pipelines};
use super::store::Store;
use super::{ComparisonSettings, ExperimentError, Progress, Resources, scene_lights};
use crate::camera::stable_text::stable_text;
use crate::camera::{
    Camera, CameraDescription, CameraError, StoredTrainingScenes, TRAINING_SET_REVISION, TestScene,
    TrainingSettings, training_scenes,
};
use crate::l3::{self, Training};
use crate::optics::OpticalImage;
use crate::sensor::Channel;
use crate::spectrum::{Illuminant, Spectrum};

/// Cameras whose pipelines are learned together, from the same optical images.
const TOGETHER: usize = 8;
/// Cameras whose training statistics the store keeps.
const FEW: usize = 4;

/// A camera that is scored.
#[derive(Debug, Clone)]
pub struct Entrant {
    /// Its unique name.
    pub label: String,
    /// The camera.
    pub camera: Camera,
    /// The camera that its pipelines are learned for; `None` for itself.
    pub learned_for: Option<Camera>,
}

impl Entrant {
    /// A camera with pipelines of its own.
    #[must_use]
    pub fn new(label: impl Into<String>, camera: Camera) -> Self {
        Self { label: label.into(), camera, learned_for: None }
    }

    fn taught(&self) -> &Camera {
        self.learned_for.as_ref().unwrap_or(&self.camera)
    }
}

/// Tile and filters of a camera.
type Array<'a> = (usize, &'a [u8], &'a [Channel]);

/// All inputs of the scores of an entrant, for the cache key.
#[derive(Serialize)]
struct ScoresKey<'a> {
    smalti_version: &'a str,
    l3_revision: u32,
    refinement_revisions: [u32; 2],
    training_set_revision: u32,
    stored_scenes: Vec<&'a str>,
    camera: &'a CameraDescription,
    array: Array<'a>,
    learned_for: (&'a CameraDescription, Array<'a>),
    settings: &'a TrainingSettings,
    training: &'a Training,
    illuminant: &'a Illuminant,
    luminances_cd_m2: &'a [f64],
    seeds: [u64; 2],
    score: [f64; 2],
    scenes: &'a [(&'a str, Option<SceneKey>)],
}

/// A given scene: rows, columns, samples per pixel, its light, and the sum of its radiance, which tells files of one name apart.
type SceneKey = ([usize; 3], Spectrum, f64);

fn array(camera: &Camera) -> Array<'_> {
    let cfa = &camera.sensor.cfa;
    (cfa.mosaic().cols(), cfa.mosaic().cells(), cfa.channels())
}

/// The scenes of a comparison, for the cache key.
fn scene_keys(scenes: &[TestScene]) -> Result<Vec<(&str, Option<SceneKey>)>, ExperimentError> {
    let of = |scene| {
        let loaded = TestScene::loaded(scene).in_context(|| scene.name().to_owned())?;
        let key = loaded.map(|(loaded, samples_per_px)| {
            let radiance = loaded.radiance();
            let sum = radiance.planes().data().iter().map(|v| f64::from(*v)).sum();
            let size = [radiance.rows(), radiance.cols(), samples_per_px];
            (size, loaded.illuminant().clone(), sum)
        });
        Ok((scene.name(), key))
    };
    scenes.par_iter().map(of).collect()
}

fn key(
    entrant: &Entrant,
    settings: &ComparisonSettings,
    scenes: &[(&str, Option<SceneKey>)],
    (learning, training): (&TrainingSettings, &Training),
    stored: &dyn StoredTrainingScenes,
) -> Result<String, ExperimentError> {
    stable_text(&ScoresKey {
        smalti_version: env!("CARGO_PKG_VERSION"),
        l3_revision: l3::REVISION,
        refinement_revisions: [l3::REFINEMENT_REVISION, l3::REFINEMENT_RENDERING_REVISION],
        training_set_revision: TRAINING_SET_REVISION,
        stored_scenes: stored.names(),
        camera: entrant.camera.description(),
        array: array(&entrant.camera),
        learned_for: (entrant.taught().description(), array(entrant.taught())),
        settings: learning,
        training,
        illuminant: &settings.illuminant,
        luminances_cd_m2: &settings.luminances_cd_m2,
        seeds: [settings.seeds().start, settings.seeds().end],
        score: [settings.score.samples_per_degree, settings.score.highlight_share],
        scenes,
    })
    .in_context(|| entrant.label.clone())
}

/// Forwards all but the number of steps, which the caller has announced for the whole work, and preliminary results.
struct Announced<'a>(&'a dyn Progress);

impl Progress for Announced<'_> {
    fn begin(&self, step: &str) {
        self.0.begin(step);
    }

    fn done(&self) {
        self.0.done();
    }

    fn note(&self, text: &str) {
        self.0.note(text);
    }

    fn is_stopped(&self) -> bool {
        self.0.is_stopped()
    }
}

/// A store without the training statistics: those of dozens of cameras would displace all else from it, and their scores are kept.
struct WithoutStatistics<'a>(&'a dyn Store);

impl Store for WithoutStatistics<'_> {
    fn optical_image(
        &self,
        key: &str,
        make: &dyn Fn() -> Result<OpticalImage, CameraError>,
    ) -> Result<OpticalImage, CameraError> {
        self.0.optical_image(key, make)
    }
}

/// Learns pipelines for cameras and scores them on the scenes of a comparison, in the order of the entrants. Each camera exposes by its own rule. The store
/// keeps the scores of each entrant, so that work that was stopped resumes. Each training scene of up to eight cameras
/// together, and each luminance of a camera, is one step of progress.
///
/// # Errors
/// When a camera has no mosaic, a stage fails, or the work is stopped.
pub fn score_entrants(
    entrants: &[Entrant],
    settings: &ComparisonSettings,
    learning: (&TrainingSettings, &Training),
    resources: Resources<'_>,
) -> Result<Vec<PictureFigures>, ExperimentError> {
    let scenes = scene_keys(&settings.scenes)?;
    let keys = entrants
        .iter()
        .map(|e| key(e, settings, &scenes, learning, resources.training_scenes))
        .collect::<Result<Vec<_>, _>>()?;
    let mut scores: Vec<Option<PictureFigures>> =
        keys.iter().map(|key| resources.store.scores(key)).collect();
    let missing: Vec<usize> = (0..entrants.len()).filter(|i| scores[*i].is_none()).collect();
    let lights = scene_lights(&settings.illuminant, &settings.scenes)?;
    let batches = missing.chunks(TOGETHER);
    // Cameras on the wavelengths of each light learn from optical images of their own.
    let mut grids = Vec::new();
    if let Some(first) = entrants.first() {
        grids = lights.iter().map(|l| l.grid.unwrap_or(first.camera.grid())).collect();
        grids.dedup();
    }
    let illuminant = std::slice::from_ref(&settings.illuminant);
    let trained = grids.len() * training_scenes(illuminant, resources.training_scenes).len();
    let pictures = settings.luminances_cd_m2.len() * settings.scenes.len();
    let steps = batches.len() * trained + missing.len() * pictures;
    resources.progress.expect(steps as u64);
    let announced = Announced(resources.progress);
    let images = WithoutStatistics(resources.store);
    let store: &dyn Store = if entrants.len() > FEW { &images } else { resources.store };
    let inner = Resources { progress: &announced, store, ..resources };
    let mut setups = Vec::new();
    for batch in batches {
        let cameras: Vec<Camera> = batch.iter().map(|i| entrants[*i].taught().clone()).collect();
        let labels: Vec<String> = batch.iter().map(|i| entrants[*i].label.clone()).collect();
        let task = PipelineTask::learned((&cameras, &labels), learning, &lights);
        let sets = pipelines(task, inner)?;
        for (i, set) in batch.iter().zip(&sets) {
            let entrant = &entrants[*i];
            let contender = Contender::with_pipelines(&entrant.camera, &entrant.label, set.as_ref());
            setups = imaged(&contender, settings, &setups, inner)?;
            let found = figures(&contender, &setups, settings, inner)?;
            resources.store.keep_scores(&keys[*i], &found);
            scores[*i] = Some(found);
        }
    }
    Ok(scores.into_iter().flatten().collect())
}

/// The figures of a contender at every luminance.
pub(super) fn figures(
    contender: &Contender<'_>,
    setups: &[crate::camera::Setup],
    settings: &ComparisonSettings,
    resources: Resources<'_>,
) -> Result<PictureFigures, ExperimentError> {
    let progress = resources.progress;
    let pictures = settings.pictures(setups);
    let own =
        ExposurePlan::new(ExposurePolicy::Own, &[(contender.label, contender.camera)], pictures, resources)?;
    let none = LightFigures { metrics: Default::default(), time_s: 0.0 };
    let mut lights = vec![none; settings.luminances_cd_m2.len()];
    for (number, setup) in setups.iter().enumerate() {
        let scored = scene_scores(contender, (number, setup), settings, &own, progress)?;
        for (light, scene) in lights.iter_mut().zip(scored) {
            for (metric, values) in light.metrics.iter_mut().enumerate() {
                values.extend(scene.by_seed.iter().map(|figures| figures[metric]));
            }
            light.time_s += scene.scores.exposure_time_s / setups.len() as f64;
        }
    }
    Ok(PictureFigures { lights })
}
