//! Learning of pipelines from scenes, from pairs of raw images and pictures, and from saved statistics.

use serde::Serialize;

use super::error::StageContext;
use super::material::{NamedScene, TrainingMaterial, add_scenes, first_light};
use super::pairs::{PairAlignment, RawAndPicture, add_pair};
use super::progress::ensure_running;
use super::training_statistics::{continue_statistics, fresh_statistics, pair_statistics};
use super::{ExperimentError, Progress};
use crate::camera::stable_text::stable_text;
use crate::camera::{Camera, CameraDescription, StoredTrainingScenes, TrainingSettings, TrainingTarget};
use crate::l3::{Pipeline, Statistics, Training};
use crate::spectrum::Illuminant;

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

/// A pair of a raw image and its target picture, which is read when its turn comes.
pub struct TrainingPair<'a, E> {
    /// Its name in progress, messages and provenance.
    pub name: String,
    /// Whether to align the picture with the raw image; see [`PairAlignment`].
    pub align: bool,
    /// Reads the pair.
    pub read: Box<dyn FnOnce() -> Result<RawAndPicture, E> + Send + 'a>,
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

/// Gathers the statistics of a camera from all sources. Each pair and each scene is one step of progress. Raw files contain noise and
/// scenes do not, so that either can be given. `memory_bytes` is the memory limit, if there is one.
///
/// # Errors
/// When the camera has no mosaic, a setting is invalid, memory does not suffice, a source does not match, reading fails, or the work
/// is stopped.
pub fn gather<E: From<ExperimentError>>(
    camera: &Camera,
    settings: &TrainingSettings,
    sources: TrainingSources<'_, E>,
    progress: &dyn Progress,
    memory_bytes: Option<u64>,
) -> Result<Gathered, E> {
    let TrainingSources { scenes, illuminants, stored_scenes, pairs, saved } = sources;
    let first = scenes.as_ref().and_then(|scenes| scenes.first());
    if !pairs.is_empty() && first.is_some() {
        return Err(ExperimentError::PairsAndScenes.into());
    }
    if !pairs.is_empty() && (settings.target != TrainingTarget::Xyz || settings.target_light.is_some()) {
        return Err(ExperimentError::TargetOfPairs.into());
    }
    let light = match first {
        Some(first) => first.scene.illuminant().clone(),
        None => first_light(&illuminants, camera)?,
    };
    let material = match scenes {
        Some(scenes) => Some(TrainingMaterial::Scenes(scenes)),
        None if pairs.is_empty() && saved.is_empty() => {
            Some(TrainingMaterial::DefaultSet(illuminants, stored_scenes))
        }
        None => None,
    };
    let label = &camera.description().name;
    let mut statistics = fresh_statistics(camera, settings, &light, memory_bytes)?;
    if !pairs.is_empty() {
        statistics = pair_statistics(&statistics)?;
    }
    let mut names: Vec<String> = saved.iter().map(|(name, _)| format!("statistics {name}")).collect();
    if !saved.is_empty() {
        let adds_more = material.is_some() || !pairs.is_empty();
        statistics = continue_statistics(saved, &statistics, adds_more)?;
    }
    progress.expect((pairs.len() + material.as_ref().map_or(0, TrainingMaterial::len)) as u64);
    let mut alignments = Vec::with_capacity(pairs.len());
    for TrainingPair { name, align, read } in pairs {
        ensure_running(progress)?;
        progress.begin(&name);
        alignments.push(add_pair(&mut statistics, camera, &name, read()?, align, progress)?);
        names.push(name);
        progress.done();
    }
    if let Some(material) = &material {
        add_scenes(camera, label, settings, material, &mut statistics, progress)?;
        names.extend(material.names());
    }
    Ok(Gathered { statistics, record: TrainingRecord::new(camera, settings, names), alignments })
}

/// Learns a pipeline: [`gather`], then [`solve`], which is one further step of progress.
///
/// # Errors
/// As both of them.
pub fn learn<E: From<ExperimentError>>(
    camera: &Camera,
    settings: &TrainingSettings,
    training: &Training,
    sources: TrainingSources<'_, E>,
    progress: &dyn Progress,
    memory_bytes: Option<u64>,
) -> Result<Learned, E> {
    progress.expect(1);
    let Gathered { statistics, record, alignments } =
        gather(camera, settings, sources, progress, memory_bytes)?;
    progress.begin("solving");
    let pipeline = solve(&statistics, training, Some(&record))?;
    progress.done();
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
