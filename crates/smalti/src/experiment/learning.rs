//! Learning of pipelines from scenes, from pairs of raw images and pictures, and from saved statistics.

use serde::Serialize;

use super::error::StageContext;
use super::material::{NamedScene, TrainingMaterial, add_scenes, first_light};
use super::pairs::{PairAlignment, RawAndPicture, add_pair, brightness};
use super::progress::ensure_running;
use super::training_statistics::{
    WhiteIn, continue_statistics, fresh_statistics, pair_statistics, second_stage,
};
use super::{ExperimentError, Progress};
use crate::camera::stable_text::stable_text;
use crate::camera::{Camera, CameraDescription, StoredTrainingScenes, TrainingSettings, TrainingTarget};
use crate::l3::{Learner, Pipeline, Quality, Statistics, Training};
use crate::spectrum::{Illuminant, Spectrum};

/// Camera, settings and sources of training statistics, for the provenance of a pipeline.
#[derive(Debug, Clone)]
pub struct TrainingRecord {
    /// The camera.
    pub camera: CameraDescription,
    /// The settings.
    pub settings: TrainingSettings,
    /// Names of the scenes, pairs and saved statistics.
    pub sources: Vec<String>,
}

impl TrainingRecord {
    pub(super) fn new(camera: &Camera, settings: &TrainingSettings, sources: Vec<String>) -> Self {
        Self { camera: camera.description().clone(), settings: settings.clone(), sources }
    }
}

/// The data that a pipeline is learned from. `E` is the error of reading a pair.
pub struct TrainingSources<'a, E> {
    /// Training scenes. `None` selects the default set, or no scenes with pairs or saved statistics.
    pub scenes: Option<Vec<NamedScene>>,
    /// Illuminants of the default set, which its scenes use in turn. The first one also determines the levels where no scene does.
    /// Without any, it is [`DEFAULT_TRAINING_LIGHT`](crate::camera::DEFAULT_TRAINING_LIGHT).
    pub illuminants: Vec<Illuminant>,
    /// Scenes of the default set that come from files.
    pub stored_scenes: &'a dyn StoredTrainingScenes,
    /// Pairs of raw images and pictures.
    pub pairs: Vec<TrainingPair<'a, E>>,
    /// Saved statistics to continue from, with their names.
    pub saved: Vec<(String, Statistics)>,
}

/// A pair of a raw image and its target picture, which is read when its turn comes, once for each stage.
pub struct TrainingPair<'a, E> {
    /// Its name in progress, messages and provenance.
    pub name: String,
    /// Whether to align the picture with the raw image; see [`PairAlignment`].
    pub align: bool,
    /// Reads the pair.
    pub read: Box<dyn Fn() -> Result<RawAndPicture, E> + Send + Sync + 'a>,
}

/// Gathered statistics.
#[derive(Debug, Clone)]
pub struct Gathered {
    /// The statistics.
    pub statistics: Statistics,
    /// Their origin.
    pub record: TrainingRecord,
    /// The alignment of each pair, in their order.
    pub alignments: Vec<PairAlignment>,
}

/// A learned pipeline and its statistics.
#[derive(Debug, Clone)]
pub struct Learned {
    /// The statistics.
    pub statistics: Statistics,
    /// The pipeline.
    pub pipeline: Pipeline,
    /// The alignment of each pair, in their order.
    pub alignments: Vec<PairAlignment>,
}

impl<E: From<ExperimentError>> TrainingSources<'_, E> {
    /// The scenes, if there are any.
    fn material(&self) -> Option<TrainingMaterial<'_>> {
        match &self.scenes {
            Some(scenes) => Some(TrainingMaterial::Scenes(scenes)),
            None if self.pairs.is_empty() && self.saved.is_empty() => {
                Some(TrainingMaterial::DefaultSet(&self.illuminants, self.stored_scenes))
            }
            None => None,
        }
    }

    /// The illuminant (photons) under which levels are cut.
    fn light(&self, camera: &Camera) -> Result<Spectrum, ExperimentError> {
        match self.scenes.as_ref().and_then(|scenes| scenes.first()) {
            Some(first) => Ok(first.scene.illuminant().clone()),
            None => first_light(&self.illuminants, camera),
        }
    }

    /// The mean of the normalised samples for which the pictures of the pairs have Y = 1, the geometric mean over the pairs: a camera
    /// brightens its pictures as it sees fit. `None` without a pair that is not dark.
    fn mean_of_white(&self, progress: &dyn Progress) -> Result<Option<f64>, E> {
        let mut logarithms = Vec::with_capacity(self.pairs.len());
        for TrainingPair { name, read, .. } in &self.pairs {
            ensure_running(progress)?;
            logarithms.extend(brightness(name, read()?)?.map(f64::ln));
        }
        let mean = logarithms.iter().sum::<f64>() / logarithms.len().max(1) as f64;
        Ok((!logarithms.is_empty()).then(|| (-mean).exp()))
    }

    /// Steps of progress that the first or the second stage takes.
    fn steps(&self, is_second_stage: bool) -> u64 {
        let scenes = self.material().map_or(0, |material| material.len(is_second_stage));
        (self.pairs.len() + scenes) as u64
    }

    /// Adds all pairs and scenes to what is learned. Each is one step of progress.
    fn add_to(
        &self,
        learner: &mut dyn Learner,
        camera: &Camera,
        settings: &TrainingSettings,
        progress: &dyn Progress,
    ) -> Result<Vec<PairAlignment>, E> {
        let mut alignments = Vec::with_capacity(self.pairs.len());
        for TrainingPair { name, align, read } in &self.pairs {
            ensure_running(progress)?;
            progress.begin(name);
            alignments.push(add_pair(learner, camera, name, read()?, *align)?);
            progress.done();
        }
        if let Some(material) = self.material() {
            add_scenes(camera, &camera.description().name, settings, &material, learner, progress)?;
        }
        Ok(alignments)
    }
}

/// Gathers the statistics of a camera from all sources. Each pair and each scene is one step of progress. Raw files contain noise and
/// scenes do not, so that either can be given. `memory_bytes` is the memory limit, if there is one.
///
/// # Errors
/// When the camera has no mosaic, a setting is invalid, memory does not suffice, a source does not match, reading fails, or the work
/// is stopped.
pub fn gather<E: From<ExperimentError>>(
    camera: &Camera,
    settings: &TrainingSettings,
    sources: &TrainingSources<'_, E>,
    progress: &dyn Progress,
    memory_bytes: Option<u64>,
) -> Result<Gathered, E> {
    let TrainingSources { scenes, pairs, saved, .. } = sources;
    if !pairs.is_empty() && scenes.as_ref().is_some_and(|scenes| !scenes.is_empty()) {
        return Err(ExperimentError::PairsAndScenes.into());
    }
    if !pairs.is_empty() && (settings.target != TrainingTarget::Xyz || settings.target_light.is_some()) {
        return Err(ExperimentError::TargetOfPairs.into());
    }
    let material = sources.material();
    let mut statistics = fresh_statistics(camera, settings, &sources.light(camera)?, memory_bytes)?;
    if !pairs.is_empty() {
        statistics = pair_statistics(&statistics)?;
    }
    if !saved.is_empty() {
        let adds_more = material.is_some() || !pairs.is_empty();
        statistics = continue_statistics(saved, &statistics, adds_more)?;
    }
    progress.expect(sources.steps(false));
    let alignments = sources.add_to(&mut statistics, camera, settings, progress)?;
    for (pair, alignment) in pairs.iter().zip(&alignments) {
        alignment.doubts().iter().for_each(|doubt| progress.note(&format!("{}: {doubt}", pair.name)));
    }
    let mut names: Vec<String> = saved.iter().map(|(name, _)| format!("statistics {name}")).collect();
    names.extend(pairs.iter().map(|pair| pair.name.clone()));
    names.extend(material.iter().flat_map(TrainingMaterial::names));
    Ok(Gathered { statistics, record: TrainingRecord::new(camera, settings, names), alignments })
}

/// Learns the second stage of a pipeline from pairs and scenes, those that the first stage was learned from or others. Each is one step
/// of progress. Saved statistics are those of a first stage and add nothing.
///
/// # Errors
/// When the outputs of the pipeline are not X, Y, Z, there is neither pair nor scene, a source does not match, reading fails, or the work
/// is stopped.
pub fn refine<E: From<ExperimentError>>(
    camera: &Camera,
    settings: &TrainingSettings,
    pipeline: &Pipeline,
    sources: &TrainingSources<'_, E>,
    progress: &dyn Progress,
) -> Result<Pipeline, E> {
    if sources.steps(true) == 0 {
        return Err(ExperimentError::NothingToRefineFrom.into());
    }
    progress.expect(sources.steps(true));
    let light = sources.light(camera)?;
    let white = sources.mean_of_white(progress)?.map_or(WhiteIn::Light(&light), WhiteIn::Samples);
    let mut stage = second_stage(camera, white, pipeline)?;
    sources.add_to(&mut stage, camera, settings, progress)?;
    Ok(stage.solve().map_err(ExperimentError::from)?)
}

/// Learns a pipeline: [`gather`], then [`solve`], which is one further step of progress, then [`refine`] for best quality.
///
/// # Errors
/// As all of them.
pub fn learn<E: From<ExperimentError>>(
    camera: &Camera,
    settings: &TrainingSettings,
    training: &Training,
    sources: &TrainingSources<'_, E>,
    progress: &dyn Progress,
    memory_bytes: Option<u64>,
) -> Result<Learned, E> {
    progress.expect(1);
    let Gathered { statistics, record, alignments } =
        gather(camera, settings, sources, progress, memory_bytes)?;
    progress.begin("solving");
    let mut pipeline = solve(&statistics, training, Some(&record))?;
    progress.done();
    if training.quality == Quality::Best {
        pipeline = refine(camera, settings, &pipeline, sources, progress)?;
    }
    Ok(Learned { statistics, pipeline, alignments })
}

/// The provenance of a pipeline, as stored in its file.
#[derive(Serialize)]
struct Provenance<'a> {
    smalti_version: &'a str,
    camera: Option<&'a CameraDescription>,
    settings: Option<&'a TrainingSettings>,
    training: &'a Training,
    scenes: &'a [String],
    patches: u64,
}

/// Solves the kernels of every class. The provenance of the pipeline holds the record of its training, if there is one, and the
/// settings of the solver.
///
/// # Errors
/// When a setting is invalid or the statistics are empty.
pub fn solve(
    statistics: &Statistics,
    training: &Training,
    record: Option<&TrainingRecord>,
) -> Result<Pipeline, ExperimentError> {
    let provenance = stable_text(&Provenance {
        smalti_version: env!("CARGO_PKG_VERSION"),
        camera: record.map(|r| &r.camera),
        settings: record.map(|r| &r.settings),
        training,
        scenes: record.map_or(&[], |r| &r.sources),
        patches: statistics.count(),
    })
    .in_context(|| "provenance".into())?;
    Ok(training.solve(statistics, provenance)?)
}
