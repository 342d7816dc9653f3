//! The scores of a contender at one luminance.

use super::contender::ScoredScene;
use crate::camera::{Evaluation, PICTURE_METRICS};
use crate::metrics::esfr::EdgeSfr;

/// The scores of a contender at one luminance.
pub struct Outcome {
    /// Mean luminance of the scenes, cd/m².
    pub luminance_cd_m2: f64,
    /// The scores on the targets of [`evaluate`](crate::camera::evaluate()).
    pub targets: Evaluation,
    /// The edge response; `None` when the picture shows no edge.
    pub edge: Option<EdgeSfr>,
    /// The scores on each scene, with its name.
    pub scenes: Vec<(String, ScoredScene)>,
}

impl Outcome {
    /// Means of [`PICTURE_METRICS`] over all scenes and seeds.
    #[must_use]
    pub fn means(&self) -> [f64; PICTURE_METRICS.len()] {
        means(self.scenes.iter().map(|(_, scored)| scored))
    }

    /// One of [`PICTURE_METRICS`] for every scene and seed, scene by scene.
    pub(super) fn figures(&self, metric: usize) -> Vec<f64> {
        self.scenes.iter().flat_map(|(_, s)| s.by_seed.iter().map(move |f| f[metric])).collect()
    }
}

/// Means of [`PICTURE_METRICS`] over scenes and seeds.
pub(super) fn means<'a>(
    scenes: impl ExactSizeIterator<Item = &'a ScoredScene> + Clone,
) -> [f64; PICTURE_METRICS.len()] {
    let count = scenes.len().max(1) as f64;
    std::array::from_fn(|metric| scenes.clone().map(|s| s.means()[metric]).sum::<f64>() / count)
}
