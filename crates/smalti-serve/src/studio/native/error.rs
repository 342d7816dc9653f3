//! Why jobs have no result.

use smalti::camera::CameraError;
use smalti::design::DesignError;
use smalti::design::live::LiveLockError;
use smalti::experiment::ExperimentError;
use smalti::spectrum::SpectrumError;
use smalti_io::{Diagnostic, IoError};
use smalti_report::ReportError;
use thiserror::Error;

/// Why a job has no result.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum JobError {
    /// The page ended it.
    #[error("the work was stopped")]
    Stopped,
    /// The request cannot be met.
    #[error("{0}")]
    Wrong(String),
    /// The camera is impossible.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The description of the camera cannot be read.
    #[error("{0}")]
    Description(#[from] Box<Diagnostic>),
    /// Something is to stay that the array does not have.
    #[error(transparent)]
    Lock(#[from] LiveLockError),
    /// The search is impossible.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// A stage failed.
    #[error(transparent)]
    Experiment(ExperimentError),
    /// A scene cannot be read, or a file not be made.
    #[error(transparent)]
    File(#[from] IoError),
    /// The page of the report cannot be made.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// A defect of the program.
    #[error("the job ended without a result; this is a defect of the program")]
    Broken,
}

impl From<ExperimentError> for JobError {
    fn from(error: ExperimentError) -> Self {
        match error {
            ExperimentError::Stopped => Self::Stopped,
            other => Self::Experiment(other),
        }
    }
}

impl From<SpectrumError> for JobError {
    fn from(error: SpectrumError) -> Self {
        Self::Camera(CameraError::from(error))
    }
}
