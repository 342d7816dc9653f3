//! What the parts of a search found, kept so that a search that was stopped goes on.

use serde::{Deserialize, Serialize};

/// Filters that a part of a search found, or a layout with its filters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KeptFind {
    /// The cells of a layout that was found; none when the mosaic was known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cells: Vec<u8>,
    /// Parameters of each filter.
    pub parameters: Vec<Vec<f64>>,
    /// The cost.
    pub cost: f64,
    /// The number of the start.
    pub start: usize,
}

/// Keeps what the parts of one search found. A part has the same name in every run of the same task.
pub trait DesignStore: Sync {
    /// What a part found in an earlier run.
    fn find(&self, part: &str) -> Option<Vec<KeptFind>>;

    /// Keeps what a part found. A store that cannot keep it loses time and nothing else.
    fn keep(&self, part: &str, found: &[KeptFind]);

    /// Whether this run searches a part that [`DesignStore::find`] does not know. The store of one of several processes that share a search
    /// leaves the parts of the others to them. The search then ends with [`ExperimentError::OpenParts`](super::ExperimentError::OpenParts)
    /// where it needs them.
    fn takes(&self, _part: &str) -> bool {
        true
    }
}

/// Keeps nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct ForgetfulStore;

impl DesignStore for ForgetfulStore {
    fn find(&self, _part: &str) -> Option<Vec<KeptFind>> {
        None
    }

    fn keep(&self, _part: &str, _found: &[KeptFind]) {}
}
