//! What jobs draw on, and what they give.

use serde_json::Value;
use smalti::experiment::Resources;
use smalti_io::cache::Cache;
use smalti_io::memory;
use smalti_io::rendered::TrainingSet;
use tokio::sync::Semaphore;

use super::watch::Watch;

/// What jobs draw on.
pub struct Native {
    pub(super) cache: Cache,
    /// The job that is at work.
    pub(super) turn: Semaphore,
}

/// A result: JSON, and files with what they are.
pub(super) struct Found {
    pub(super) said: Value,
    pub(super) files: Vec<(&'static str, Vec<u8>)>,
}

impl Native {
    /// Jobs that keep slow results in a cache.
    #[must_use]
    pub fn new(cache: Cache) -> Self {
        Self { cache, turn: Semaphore::new(1) }
    }

    /// Resources of an experiment that reports to `watch`.
    pub(super) fn resources<'a>(&'a self, watch: &'a Watch) -> Resources<'a> {
        Resources {
            store: &self.cache,
            training_scenes: TrainingSet::All.stored(),
            progress: watch,
            memory_bytes: memory::available_bytes(),
        }
    }
}
