//! The cache of experiments, and the resources that they may use.

use std::sync::{Mutex, MutexGuard, PoisonError};

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

/// The latest optical images of a store in memory, for several cameras that ask for the same ones in turn: the store may be slow, or keep
/// nothing. Statistics, pipelines and scores of the store are not seen through it.
pub(super) struct ImagesInMemory<'a> {
    store: &'a dyn Store,
    images: Mutex<Vec<(String, OpticalImage)>>,
}

impl<'a> ImagesInMemory<'a> {
    /// Images that are kept: those of the targets of one camera, so that memory does not grow with the number of cameras.
    const KEPT: usize = 4;

    /// Without images, which come from a store.
    pub(super) fn new(store: &'a dyn Store) -> Self {
        Self { store, images: Mutex::default() }
    }

    fn images(&self) -> MutexGuard<'_, Vec<(String, OpticalImage)>> {
        // A list is whole between its operations, even where a thread that held it has failed.
        self.images.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Store for ImagesInMemory<'_> {
    fn optical_image(
        &self,
        key: &str,
        make: &dyn Fn() -> Result<OpticalImage, CameraError>,
    ) -> Result<OpticalImage, CameraError> {
        if let Some((_, image)) = self.images().iter().find(|(known, _)| known == key) {
            return Ok(image.clone());
        }
        let image = self.store.optical_image(key, make)?;
        let mut images = self.images();
        images.push((key.to_owned(), image.clone()));
        let surplus = images.len().saturating_sub(Self::KEPT);
        images.drain(..surplus);
        Ok(image)
    }
}

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

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::numeric::Planes;
    use crate::spectrum::{SpectralCube, WavelengthGrid};

    #[test]
    fn images_in_memory_are_made_once() {
        let made = Cell::new(0.0);
        let make = || {
            made.set(made.get() + 1.0);
            let grid = WavelengthGrid::VISIBLE;
            let planes = Planes::new(1, 1, grid.len(), vec![made.get(); grid.len()])?;
            Ok(OpticalImage::new(SpectralCube::new(grid, planes)?, 1e-6)?)
        };
        let store = ImagesInMemory::new(&NoStore);
        let sample = |key| store.optical_image(key, &make).unwrap().irradiance().planes().data()[0];
        assert_eq!(["a", "b", "a", "b", "a"].map(sample), [1.0, 2.0, 1.0, 2.0, 1.0]);
        // The first ones give way.
        assert_eq!(["c", "d", "b", "e", "b", "a"].map(sample), [3.0, 4.0, 2.0, 5.0, 2.0, 6.0]);
    }
}
