//! The learned second stage, and how it refines a picture.

use super::super::L3Error;
use super::super::blocks::LANES;
use super::axes::RefinementAxes;
use super::classes::{Scratch, classify};
use super::highlights::{self, correct};
use super::inputs::{COUNT, LINEAR, OUTPUTS};
use super::layout::{Kernels, RowInputs, arranged, weights_of};
use super::products::products;
use super::samples::RefinementSamples;
use super::stages::{ROWS_BEYOND, RollingStages, copy_row};
use super::strips::{Strip, each_strip};
use crate::numeric::Planes;

/// Number of inputs of the second stage: Y of the 5 × 5 pixels around the pixel, X and Z of 3 × 3, in row order, then X, Y, Z of the five
/// smooth pictures, the finest first, of which the last two have every second row and column, then √(r g), √(g b) and √(b r) of the third, in
/// linear BT.2020.
pub const REFINEMENT_INPUTS: usize = COUNT;
/// Number of those inputs that are linear in the picture. Tables of earlier versions have no others.
pub const REFINEMENT_LINEAR_INPUTS: usize = LINEAR;

/// A class of the second stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefinementClass {
    /// Number of training pixels.
    pub count: u64,
    /// Whether its kernels were learned from its own pixels.
    pub is_learned: bool,
}

/// The second stage of a pipeline: it refines pictures in X, Y, Z.
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
    axes: RefinementAxes,
    classes: Vec<RefinementClass>,
    kernels: Vec<Kernels>,
    /// Class × output.
    offsets: Vec<f32>,
}

impl Refinement {
    /// From its parts: `weights` in the order class, output (X, Y, Z), input ([`REFINEMENT_INPUTS`]), `offsets` in the order class, output.
    ///
    /// # Errors
    /// When their numbers do not fit the axes, or a value is not finite.
    pub fn new(
        axes: RefinementAxes,
        classes: Vec<RefinementClass>,
        weights: Vec<f32>,
        offsets: Vec<f32>,
    ) -> Result<Self, L3Error> {
        let count = axes.count();
        let fits = classes.len() == count
            && weights.len() == count * OUTPUTS * COUNT
            && offsets.len() == count * OUTPUTS;
        if !fits {
            let reason = format!("the second stage needs {count} classes of {OUTPUTS} × {COUNT} weights");
            return Err(L3Error::Table(reason));
        }
        if !weights.iter().chain(&offsets).all(|v| v.is_finite()) {
            return Err(L3Error::Table("a kernel of the second stage is not finite".into()));
        }
        let weights = weights.chunks_exact(OUTPUTS * COUNT);
        let kernels = weights.zip(offsets.chunks_exact(OUTPUTS)).map(|(w, o)| arranged(w, o)).collect();
        Ok(Self { axes, classes, kernels, offsets })
    }

    /// The class axes.
    #[must_use]
    pub fn axes(&self) -> &RefinementAxes {
        &self.axes
    }

    /// The classes: levels (slowest), then structures.
    #[must_use]
    pub fn classes(&self) -> &[RefinementClass] {
        &self.classes
    }

    /// The kernels in the layout of the inner loop.
    pub(super) fn kernels(&self) -> &[Kernels] {
        &self.kernels
    }

    /// The weights, in the order class, output, input.
    pub fn weights(&self) -> impl Iterator<Item = f32> {
        self.kernels.iter().flat_map(weights_of)
    }

    /// The offsets, in the order class, output.
    #[must_use]
    pub fn offsets(&self) -> &[f32] {
        &self.offsets
    }

    /// Refines a picture of the first stage in place. Beside highlights, it compares Y with `samples`, those of the raw image that the picture was rendered
    /// from, if they are given ([`Pipeline::refinement_samples`](super::super::Pipeline::refinement_samples)). Results have the same bits for any number of threads and any instruction set.
    ///
    /// # Errors
    /// When the picture does not have the three planes X, Y, Z, or its size differs from that of the raw image. Samples of another pipeline are not
    /// recognised.
    pub fn apply(&self, picture: &mut Planes, samples: Option<RefinementSamples<'_>>) -> Result<(), L3Error> {
        if picture.count() != OUTPUTS {
            return Err(L3Error::NotAPicture(picture.count()));
        }
        if let Some(samples) = samples {
            samples.ensure_size([picture.rows(), picture.cols()])?;
        }
        each_strip(picture, ROWS_BEYOND, |strip| self.refine(strip));
        let dark = self.axes.dark_noise();
        each_strip(picture, highlights::REACH, |strip| correct(strip, dark, samples));
        Ok(())
    }

    /// Refines a strip.
    fn refine(&self, mut strip: Strip<'_>) {
        let (first, [rows, cols]) = (strip.rows.start, strip.size);
        let mut rolling = RollingStages::new(first, rows, cols, self.axes.noise());
        let (mut scratch, mut classes) = (Scratch::default(), Vec::new());
        let mut inputs = RowInputs::default();
        for start in strip.rows.clone().step_by(RollingStages::ROWS) {
            let group = start..(start + RollingStages::ROWS).min(strip.rows.end);
            rolling.advance(group.end, |row, planes| copy_row(strip.line(row), planes));
            let stages = &rolling.stages;
            classify(&self.axes, stages.smooth(0), group.clone(), cols, &mut scratch, &mut classes);
            for (row, classes) in group.zip(classes.chunks_exact(cols.next_multiple_of(LANES))) {
                inputs.read(stages, row, cols);
                if let Some(out) = strip.line_mut(row) {
                    products(&self.kernels, classes, &inputs, out);
                }
            }
        }
    }
}
