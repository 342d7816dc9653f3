//! What learns from pairs.

use super::{Axes, L3Error, Pair, Pipeline, RefinementStatistics, Statistics, Tiles};

/// Accumulates what a stage of a pipeline is learned from.
pub trait Learner: Send {
    /// The class axes of the first stage.
    fn axes(&self) -> &Axes;

    /// Adds a pair.
    ///
    /// # Errors
    /// When sizes, mosaics or levels do not match, or a value is not finite.
    fn add(&mut self, pair: &Pair<'_>) -> Result<(), L3Error> {
        self.add_tiles(pair, Tiles::All)
    }

    /// Adds a pair of which some tiles suffice. A learner may use all of them.
    ///
    /// # Errors
    /// As [`Learner::add`].
    fn add_tiles(&mut self, pair: &Pair<'_>, tiles: Tiles) -> Result<(), L3Error>;

    /// States how many times the pairs that follow count. A learner may ignore it.
    fn weigh(&mut self, _times: u32) {}

    /// Whether it is to learn from scenes in their local light, which differs from that of the whole scene in colour.
    fn learns_local_light(&self) -> bool {
        false
    }
}

impl Learner for Statistics {
    fn axes(&self) -> &Axes {
        Self::axes(self)
    }

    fn add_tiles(&mut self, pair: &Pair<'_>, tiles: Tiles) -> Result<(), L3Error> {
        Self::add_tiles(self, pair, tiles)
    }
}

/// Learns the second stage of a pipeline from pictures that the first stage renders of noisy raw images.
#[derive(Debug, Clone)]
pub struct SecondStage<'a> {
    /// The first stage.
    pub pipeline: &'a Pipeline,
    /// What is learned so far.
    pub statistics: RefinementStatistics,
    times: u32,
}

impl<'a> SecondStage<'a> {
    /// Without a picture.
    #[must_use]
    pub fn new(pipeline: &'a Pipeline, statistics: RefinementStatistics) -> Self {
        Self { pipeline, statistics, times: 1 }
    }

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

    /// Its classes are many, and half of the pixels would cost up to 0.05 dB.
    fn add_tiles(&mut self, pair: &Pair<'_>, _: Tiles) -> Result<(), L3Error> {
        let picture = self.pipeline.render_raw(pair.seen.unwrap_or(pair.raw))?.planes;
        self.statistics.add(&picture, pair.target, self.times)
    }

    fn weigh(&mut self, times: u32) {
        self.times = times;
    }

    fn learns_local_light(&self) -> bool {
        true
    }
}
