//! Errors of experiments.

use thiserror::Error;

use crate::camera::CameraError;
use crate::design::DesignError;
use crate::isp::IspError;
use crate::l3::{L3Error, RegistrationError};
use crate::numeric::OutOfRange;

/// The reason why an experiment has no result.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// A stage failed.
    #[error("{context}: {source}")]
    Stage {
        /// The camera, scene and luminance.
        context: String,
        /// The error of the stage.
        source: Box<CameraError>,
    },
    /// The pipeline of a camera of a comparison cannot be learned.
    #[error("{label}: {source}")]
    Learning {
        /// The label of the camera.
        label: String,
        /// The reason.
        source: Box<ExperimentError>,
    },
    /// A camera cannot be scored at the equal exposure times that another camera limits.
    #[error(
        "{reason}; {limiting} saturates first and limits the equal exposure times, which could be {factor:.1} times as long without it: compare \
         without it, or with the own exposure times of the cameras"
    )]
    UnequalExposure {
        /// The reason, which is part of the message and not its source.
        reason: Box<ExperimentError>,
        /// The label of the camera that limits the times.
        limiting: String,
        /// By how much the times could be longer without it.
        factor: f64,
    },
    /// The caller stopped the work.
    #[error("stopped")]
    Stopped,
    /// A search that several processes share needs parts that this process leaves to others.
    #[error("the search needs parts that other processes search")]
    OpenParts,
    /// A condition of a study cannot be prepared, or a trial cannot be constructed.
    #[error(transparent)]
    Design(DesignError),
    /// Pipelines can be learned for mosaics only.
    #[error(
        "{camera}: `sensor.architecture` is {architecture}: every pixel sees every channel; learned pipelines are for mosaics"
    )]
    NotMosaic {
        /// The camera's name.
        camera: String,
        /// Its architecture.
        architecture: &'static str,
    },
    /// A camera of a comparison has no pipeline.
    #[error(
        "{camera}: a comparison with learned pipelines needs one for each camera, in the light of each scene"
    )]
    NoPipeline {
        /// The camera's name.
        camera: String,
    },
    /// No kind of processing of a comparison is defined for the mosaic of any camera.
    #[error("nothing is left to compare: the processing is not defined for these mosaics")]
    NothingToCompare,
    /// Nobody has answered a pair of a rating experiment.
    #[error("the experiment has no answers yet; smalti rate serve records them")]
    NoAnswers,
    /// No observer of a rating experiment is kept.
    #[error(
        "no observer with ratings is left after screening; to analyse the ratings nevertheless, keep all observers"
    )]
    NoObserver,
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] OutOfRange),
    /// There is no training scene.
    #[error("there is no scene to learn from")]
    NoScene,
    /// Raw files and scenes are given together.
    #[error("raw files contain noise and scenes do not: give either pairs or scenes")]
    PairsAndScenes,
    /// A target is stated for pairs.
    #[error(
        "the targets of pairs are their pictures: neither another target nor its illuminant can be stated"
    )]
    TargetOfPairs,
    /// The second stage needs pictures to learn from.
    #[error(
        "quality best needs scenes or pairs to learn from; saved statistics are those of the first stage alone"
    )]
    NothingToRefineFrom,
    /// Only pictures can be refined, not these outputs.
    #[error("quality best refines pictures in X, Y, Z; the outputs are {0}; expected quality fast")]
    NotRefined(String),
    /// A capture would not fit into memory.
    #[error(
        "`sensor.rows` × `sensor.cols`: a picture of {rows} × {cols} pixels needs {need_mib} MiB of memory; {available_mib} MiB are available"
    )]
    CaptureMemory {
        /// Rows that are read out.
        rows: usize,
        /// Columns that are read out.
        cols: usize,
        /// Required memory, MiB.
        need_mib: u64,
        /// Available memory, MiB.
        available_mib: u64,
    },
    /// The table of classes would not fit into memory.
    #[error(
        "a table of {positions} positions × {levels} levels × {textures} textures with patches of {side} × {side} takes {need_mib} MiB of memory \
         to learn; {available_mib} are available: a smaller patch, fewer levels or fewer texture classes take less"
    )]
    Memory {
        /// Positions of the tile.
        positions: usize,
        /// Response levels.
        levels: usize,
        /// Texture classes.
        textures: usize,
        /// Side of the patch, pixels.
        side: usize,
        /// Required memory, MiB.
        need_mib: u64,
        /// Available memory, MiB.
        available_mib: u64,
    },
    /// Saved statistics do not match the settings.
    #[error("{name}: {reason}")]
    Statistics {
        /// The source of the statistics.
        name: String,
        /// The difference.
        reason: String,
    },
    /// A raw image and its picture cannot be aligned.
    #[error("{pair}: {source}")]
    Registration {
        /// The name of the pair.
        pair: String,
        /// The error of the registration.
        source: RegistrationError,
    },
}

impl ExperimentError {
    /// The error of a stage with its context. [`IspError::Stopped`] becomes [`ExperimentError::Stopped`].
    pub(super) fn stage(context: impl Into<String>, source: impl Into<CameraError>) -> Self {
        match source.into() {
            CameraError::Isp(IspError::Stopped) => Self::Stopped,
            source => Self::Stage { context: context.into(), source: Box::new(source) },
        }
    }

    /// The error with the label of the camera whose pipeline was to be learned. [`ExperimentError::Stopped`] stays.
    pub(super) fn of_camera(self, label: &str) -> Self {
        match self {
            Self::Stopped => Self::Stopped,
            source => Self::Learning { label: label.to_owned(), source: Box::new(source) },
        }
    }
}

/// Adds the context to the error of a stage.
pub(super) trait StageContext<T> {
    fn in_context(self, context: impl FnOnce() -> String) -> Result<T, ExperimentError>;
}

impl<T, E: Into<CameraError>> StageContext<T> for Result<T, E> {
    fn in_context(self, context: impl FnOnce() -> String) -> Result<T, ExperimentError> {
        self.map_err(|e| ExperimentError::stage(context(), e))
    }
}

/// Checks that moments and kernels of these axes fit into memory. Combinations of clipped channels, which depend on the scenes,
/// may need more.
pub(super) fn ensure_memory(
    axes: &crate::l3::Axes,
    outputs: usize,
    memory_bytes: Option<u64>,
) -> Result<(), ExperimentError> {
    let (positions, levels, textures) = (axes.positions(), axes.level_count(), axes.textures().count());
    let size = 1 + axes.taps() + outputs;
    let each = size * (size + 1) / 2 * size_of::<f64>() + outputs * axes.taps() * size_of::<f32>();
    let classes = positions.saturating_mul(levels * textures);
    let need = (classes as u64).saturating_mul(each as u64);
    match memory_bytes {
        Some(available) if need > available => Err(ExperimentError::Memory {
            positions,
            levels,
            textures,
            side: axes.side(),
            need_mib: need >> 20,
            available_mib: available >> 20,
        }),
        _ => Ok(()),
    }
}

impl From<DesignError> for ExperimentError {
    fn from(source: DesignError) -> Self {
        match source {
            DesignError::Stopped => Self::Stopped,
            source => Self::Design(source),
        }
    }
}

impl From<L3Error> for ExperimentError {
    fn from(source: L3Error) -> Self {
        Self::stage("learning", source)
    }
}
