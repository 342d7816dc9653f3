//! The cache of experiments, and the resources that they may use.

use super::picture_figures::PictureFigures;
use super::{Progress, Silent};
use crate::camera::{CameraError, NoStoredScenes, StoredTrainingScenes};
use crate::l3::{Pipeline, Statistics};
use crate::optics::OpticalImage;

/// A cache of slow results. A key contains everything that its result was computed from. A store may lose entries at any time; by
/// default it caches nothing.
pub trait Store: Sync {
    /// The optical image of a key, computed by `make` when it is not cached.
    ///
    /// # Errors
    /// Those of `make`.
    fn optical_image(
        &self,
        _key: &str,
        make: &dyn Fn() -> Result<OpticalImage, CameraError>,
    ) -> Result<OpticalImage, CameraError> {
        make()
    }

    /// The training statistics of a key; `None` when they are not cached.
    fn statistics(&self, _key: &str) -> Option<Statistics> {
        None
    }

    /// Caches training statistics.
    fn keep_statistics(&self, _key: &str, _statistics: &Statistics) {}

    /// The pipeline of best quality of a key; `None` when it is not cached.
    fn pipeline(&self, _key: &str) -> Option<Pipeline> {
        None
    }

    /// Caches a pipeline of best quality.
    fn keep_pipeline(&self, _key: &str, _pipeline: &Pipeline) {}

    /// The scores of a key; `None` when they are not cached.
    fn scores(&self, _key: &str) -> Option<PictureFigures> {
        None
    }

    /// Caches scores.
    fn keep_scores(&self, _key: &str, _scores: &PictureFigures) {}
}

/// Caches nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoStore;

impl Store for NoStore {}

/// Resources that the caller provides for an experiment.
#[derive(Clone, Copy)]
pub struct Resources<'a> {
    /// The cache.
    pub store: &'a dyn Store,
    /// Scenes of the default training set that come from files.
    pub training_scenes: &'a dyn StoredTrainingScenes,
    /// The receiver of progress.
    pub progress: &'a dyn Progress,
    /// Memory limit of training, bytes; `None` for no limit.
    pub memory_bytes: Option<u64>,
}

impl Resources<'_> {
    /// The optical images of the store, as evaluations ask for them.
    pub(super) fn images(
        &self,
    ) -> impl Fn(&str, &dyn Fn() -> Result<OpticalImage, CameraError>) -> Result<OpticalImage, CameraError> + Sync
    {
        |key, make| self.store.optical_image(key, make)
    }
}

impl Default for Resources<'_> {
    /// No cache, no training scenes from files, no progress reports, no memory limit.
    fn default() -> Self {
        Self { store: &NoStore, training_scenes: &NoStoredScenes, progress: &Silent, memory_bytes: None }
    }
}
