//! Heavy work of the studio: the page asks over a WebSocket, the library works with all processors.
//!
//! The experiments are those of the command: a table is that of `smalti train`, a capture that of `smalti simulate`, a search that of `smalti design`, a
//! report that of `smalti compare`. The page sends designs and names of scenes; no message names a file.

mod capture;
mod design;
mod message;
mod report;
mod search;
mod socket;
mod watch;

use std::sync::Arc;

use axum::Router;
use axum::routing::any;
use serde_json::Value;
use smalti::camera::CameraError;
use smalti::design::DesignError;
use smalti::experiment::{ExperimentError, Progress as _, Resources};
use smalti_io::cache::Cache;
use smalti_io::rendered::TrainingSet;
use smalti_io::{Diagnostic, IoError, memory, studio};
use smalti_report::ReportError;
use thiserror::Error;
use tokio::sync::Semaphore;

use message::ensure_luminances;
pub use message::{Capture, Family, Job, MOST_MESSAGE_BYTES, MessageError, Report, Request, Search};
use watch::Watch;

/// The path of the connection, below the token.
pub(super) const PATH: &str = "native";

/// What jobs draw on.
pub struct Native {
    cache: Cache,
    /// The job that is at work.
    turn: Semaphore,
}

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

/// A result: JSON, and files with what they are.
struct Found {
    said: Value,
    files: Vec<(&'static str, Vec<u8>)>,
}

impl Native {
    /// Jobs that keep slow results in a cache.
    #[must_use]
    pub fn new(cache: Cache) -> Self {
        Self { cache, turn: Semaphore::new(1) }
    }

    fn resources<'a>(&'a self, watch: &'a Watch) -> Resources<'a> {
        Resources {
            store: &self.cache,
            training_scenes: TrainingSet::All.stored(),
            progress: watch,
            memory_bytes: memory::available_bytes(),
        }
    }

    fn run(&self, job: &Job, watch: &Watch) -> Result<Found, JobError> {
        if watch.is_stopped() {
            return Err(JobError::Stopped);
        }
        job.check()?;
        let found = match job {
            Job::Table { design, quality } => capture::table(self, design, *quality, watch),
            Job::Capture(capture) => capture::capture(self, capture, watch),
            Job::Search(search) => search::search(self, search, watch),
            Job::Report(wanted) => report::report(self, wanted, watch),
        };
        // A result that comes after the wish to end it is none.
        if watch.is_stopped() { Err(JobError::Stopped) } else { found }
    }
}

impl Request {
    /// Checks everything that is known before the work begins: that designs are cameras, scenes those of the studio, and luminances within their range.
    ///
    /// # Errors
    /// With the first that is wrong.
    pub fn check(&self) -> Result<(), JobError> {
        match self {
            Self::Start { job, .. } => job.check(),
            Self::Cancel { .. } => Ok(()),
        }
    }
}

impl Job {
    fn check(&self) -> Result<(), JobError> {
        let scene = |id: &str| match studio::catalogue_name(id) {
            Some(_) => Ok(()),
            None => Err(JobError::Wrong(format!("there is no scene {id:?} in the studio"))),
        };
        match self {
            Self::Table { design, .. } => design::camera(design).map(drop),
            Self::Capture(capture) => {
                scene(&capture.scene)?;
                ensure_luminances(&[capture.luminance_cd_m2])?;
                design::camera(&capture.design).map(drop)
            }
            Self::Search(search) => {
                ensure_luminances(&search.luminances_cd_m2)?;
                search::ensure_locks(&design::camera(&search.design)?, search)
            }
            Self::Report(report) => {
                report.scene.as_deref().map_or(Ok(()), scene)?;
                ensure_luminances(&report.luminances_cd_m2)?;
                std::iter::once(&report.design)
                    .chain(&report.rival)
                    .try_for_each(|design| design::camera(design).map(drop))
            }
        }
    }
}

/// The connection, for pages below the token.
pub(super) fn routes(native: Arc<Native>) -> Router {
    Router::new().route(&format!("/{PATH}"), any(socket::connect)).with_state(native)
}
