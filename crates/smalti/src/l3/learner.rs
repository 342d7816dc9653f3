//! What learns from pairs.

use super::{Axes, L3Error, Pair, Pipeline, RefinementStatistics, Share, Statistics};

/// Accumulates what a stage of a pipeline is learned from.
pub trait Learner: Send {
    /// The class axes of the first stage.
    fn axes(&self) -> &Axes;

    /// Adds a pair.
    ///
    /// # Errors
    /// When sizes, mosaics or levels do not match, or a value is not finite.
    fn add(&mut self, pair: &Pair<'_>) -> Result<(), L3Error> {
        self.add_share(pair, Share::WHOLE)
    }

    /// Adds a share of a pair. A learner may use more tiles, and may count every pair once.
    ///
    /// # Errors
    /// As [`Learner::add`].
    fn add_share(&mut self, pair: &Pair<'_>, share: Share) -> Result<(), L3Error>;

    /// Whether it is the second stage, which has a default training set of its own ([`crate::camera::refinement_scenes`]).
    fn is_second_stage(&self) -> bool {
        false
    }
}

impl Learner for Statistics {
    fn axes(&self) -> &Axes {
        Self::axes(self)
    }

    /// Every pair counts once.
    fn add_share(&mut self, pair: &Pair<'_>, share: Share) -> Result<(), L3Error> {
        self.add_tiles(pair, share.tiles)
    }
}

/// Learns the second stage of a pipeline from pictures that the first stage renders of noisy raw images.
#[derive(Debug, Clone)]
pub struct SecondStage<'a> {
    /// The first stage.
    pub pipeline: &'a Pipeline,
    /// What is learned so far.
    pub statistics: RefinementStatistics,
}

impl SecondStage<'_> {
    /// The pipeline of both stages.
    ///
    /// # Errors
    /// When nothing was learned, the moments of a class have no solution, or the outputs of the pipeline are not X, Y, Z.
    pub fn solve(&self) -> Result<Pipeline, L3Error> {
        let mosaic = self.pipeline.axes().mosaic();
        let second = self.statistics.solve([mosaic.rows(), mosaic.cols()])?;
        self.pipeline.clone().with_refinement(Some(second))
    }
}

impl Learner for SecondStage<'_> {
    fn axes(&self) -> &Axes {
        self.pipeline.axes()
    }

    /// All tiles are learned from: the classes are many, and half of the pixels would cost up to 0.05 dB.
    fn add_share(&mut self, pair: &Pair<'_>, share: Share) -> Result<(), L3Error> {
        let picture = self.pipeline.render_raw(pair.seen.unwrap_or(pair.raw))?.planes;
        self.statistics.add(&picture, pair.target, share.times)
    }

    fn is_second_stage(&self) -> bool {
        true
    }
}
