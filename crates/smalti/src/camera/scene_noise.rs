//! Random numbers that the cameras before a training scene share.

use std::sync::OnceLock;

use crate::sensor::{Sensor, TemporalNoise};

/// More than the default exposures, at most 13. The numbers of each take 12 bytes for a photodiode, 0.8 MB at 256 × 256, while a scene is learned
/// from.
const SHARED_EXPOSURES: usize = 24;

/// The random numbers of the noise of a scene: one set for each exposure. Cameras before the same scene share them, because their seeds are
/// equal.
#[derive(Debug)]
pub(crate) struct SceneNoise([OnceLock<Option<TemporalNoise>>; SHARED_EXPOSURES]);

impl SceneNoise {
    pub(crate) fn new() -> Self {
        Self([const { OnceLock::new() }; SHARED_EXPOSURES])
    }

    /// The numbers at exposure number `i`, drawn when they are needed first.
    pub(super) fn at(&self, i: u64, sensor: &Sensor, seed: u64) -> Option<&TemporalNoise> {
        self.0.get(i as usize)?.get_or_init(|| TemporalNoise::new(sensor, seed)).as_ref()
    }
}
