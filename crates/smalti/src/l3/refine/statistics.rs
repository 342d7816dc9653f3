//! Moments of inputs and targets for every class of the second stage.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::super::error::{ensure_finite, ensure_same_size};
use super::super::solve::{Solution, regularised};
use super::super::{L3Error, Moments, blocks};
use super::axes::RefinementAxes;
use super::classes::{Scratch, classify};
use super::inputs::{COUNT, LINEAR, Lines, OUTPUTS, OWN};
use super::refinement::{Refinement, RefinementClass};
use super::stages::Stages;
use super::tile_pattern::TilePattern;
use crate::numeric::Planes;
use crate::numeric::products::{LANES, add_products};
use crate::numeric::simd::{Kernel, dispatch};

/// Raised when learning the second stage gives other kernels for equal pictures: stages that were kept under another revision are not used.
pub const REFINEMENT_REVISION: u32 = 11;

/// Length of z = (1, inputs, targets), in whole registers.
const STRIDE: usize = (1 + COUNT + OUTPUTS).next_multiple_of(LANES);
/// Vectors that are summed at once: they stay in the L1 cache.
const BATCH: usize = 32;
/// Rows that are classified at once.
const BAND_ROWS: usize = 64;
/// Pixels that a class needs to have kernels of its own, for each input.
const PIXELS_PER_INPUT: u64 = 10;
/// Variance that is added to that of every input, relative to their mean, because inputs resemble each other.
const LOAD: f64 = 1e-6;

/// The same for the roots, so that few colours do not teach corrections that no other colour needs.
const ROOTS_LOAD: f64 = 1e-4;

/// The variance that is added to that of an input.
fn load(input: usize) -> f64 {
    if input < LINEAR { LOAD } else { ROOTS_LOAD }
}

/// Moments of the inputs and targets of every class, gathered in one pass in constant memory.
#[derive(Debug, Clone, PartialEq)]
pub struct RefinementStatistics {
    axes: RefinementAxes,
    classes: BTreeMap<u32, Moments>,
}

impl RefinementStatistics {
    /// Statistics without a picture.
    #[must_use]
    pub fn new(axes: RefinementAxes) -> Self {
        Self { axes, classes: BTreeMap::new() }
    }

    /// The class axes.
    #[must_use]
    pub fn axes(&self) -> &RefinementAxes {
        &self.axes
    }

    /// Number of pixels, each as often as it was counted.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.classes.values().map(Moments::count).sum()
    }

    /// Adds a picture of a first stage, X, Y, Z, and its target, counted several times. Equal pictures in equal order give equal bits for
    /// any number of threads.
    ///
    /// # Errors
    /// When one of them does not have three planes, sizes differ, or a value is not finite.
    pub fn add(&mut self, picture: &Planes, target: &Planes, times: u32) -> Result<(), L3Error> {
        let size = [picture.rows(), picture.cols()];
        for planes in [picture, target] {
            if planes.count() != OUTPUTS {
                return Err(L3Error::Outputs { expected: OUTPUTS, got: planes.count() });
            }
            for plane in planes.planes() {
                ensure_finite("a picture to refine", plane, planes.cols())?;
            }
        }
        ensure_same_size("the target", size, [target.rows(), target.cols()])?;
        let stages = Stages::of(picture, self.axes.noise());
        let (mut scratch, mut classes) = (Scratch::default(), Vec::new());
        for first in (0..size[0]).step_by(BAND_ROWS) {
            let rows = first..(first + BAND_ROWS).min(size[0]);
            classify(&self.axes, stages.smooth(0), rows.clone(), size[1], &mut scratch, &mut classes);
            let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
            for (row, classes) in rows.zip(classes.chunks_exact(size[1].next_multiple_of(blocks::LANES))) {
                for (col, class) in classes[..size[1]].iter().enumerate() {
                    members.entry(*class).or_default().push((row * size[1] + col) as u32);
                }
            }
            for class in members.keys() {
                self.classes.entry(*class).or_insert_with(|| Moments::new(COUNT, OUTPUTS));
            }
            // Both lists are in the order of classes.
            let mut lists = members.into_iter().peekable();
            let all = self.classes.iter_mut();
            let found =
                all.filter_map(|(class, moments)| Some((moments, lists.next_if(|(c, _)| c == class)?.1)));
            let work: Vec<(&mut Moments, Vec<u32>)> = found.collect();
            work.into_par_iter().for_each(|(moments, pixels)| {
                let mut sums = dispatch(Sums { stages: &stages, target, pixels: &pixels });
                sums.iter_mut().for_each(|s| *s *= f64::from(times));
                moments.add_square(&sums, STRIDE);
            });
        }
        Ok(())
    }

    /// Adds other statistics of the same axes.
    ///
    /// # Errors
    /// [`L3Error::Mismatch`].
    pub fn merge(&mut self, other: &Self) -> Result<(), L3Error> {
        if self.axes != other.axes {
            return Err(L3Error::Mismatch("levels or noise of the second stage"));
        }
        for (class, moments) in &other.classes {
            self.classes.entry(*class).or_insert_with(|| Moments::new(COUNT, OUTPUTS)).merge(moments);
        }
        Ok(())
    }

    /// Solves the kernels of every class. A class with too few pixels shares those of its neighbours: the same texture or orientation at
    /// levels and strengths up to one step away, two steps, and so on, until they suffice. If they never do, its kernels leave the picture
    /// as it is. `tile` is that of the mosaic, rows and columns: in uniform areas, the kernels pass on no pattern of this period.
    ///
    /// # Errors
    /// When there is no picture, or the moments of a class have no solution.
    pub fn solve(&self, tile: [usize; 2]) -> Result<Refinement, L3Error> {
        let pattern = TilePattern::new(&self.axes, tile);
        let least = PIXELS_PER_INPUT * COUNT as u64;
        let solve = |class: u32| {
            let count = self.classes.get(&class).map_or(0, Moments::count);
            let solution = match self.pooled(class, least) {
                Some(moments) => {
                    let solution = regularised(&moments, COUNT, OUTPUTS, load, pattern.of_class(class));
                    solution.ok_or(L3Error::Singular(class as usize))?
                }
                None => identity(),
            };
            Ok((RefinementClass { count, is_learned: count >= least }, solution))
        };
        let all = (0..self.axes.count() as u32).into_par_iter().map(solve);
        let all: Vec<(RefinementClass, Solution)> = all.collect::<Result<_, L3Error>>()?;
        let weights = all.iter().flat_map(|(_, s)| s.weights.iter().map(|&w| w as f32)).collect();
        let offsets = all.iter().flat_map(|(_, s)| s.offsets.iter().map(|&o| o as f32)).collect();
        Refinement::new(self.axes.clone(), all.iter().map(|(class, _)| *class).collect(), weights, offsets)
    }

    /// The moments of a class, and of its nearest neighbours if they are needed for `least` pixels.
    fn pooled(&self, class: u32, least: u64) -> Option<Moments> {
        let steps = |other: u32| self.axes.steps_between(class, other);
        let near: Vec<(usize, &Moments)> =
            self.classes.iter().filter_map(|(other, m)| Some((steps(*other)?, m))).collect();
        let within = |reach: usize| near.iter().filter(move |(steps, _)| *steps <= reach).map(|(_, m)| *m);
        let reach = (0..=self.axes.longest())
            .find(|reach| within(*reach).map(Moments::count).sum::<u64>() >= least)?;
        let mut sum = Moments::new(COUNT, OUTPUTS);
        within(reach).for_each(|m| sum.merge(m));
        Some(sum)
    }
}

/// Kernels that leave the picture as it is.
fn identity() -> Solution {
    let mut weights = vec![0.0; OUTPUTS * COUNT];
    OWN.iter().enumerate().for_each(|(output, own)| weights[output * COUNT + own] = 1.0);
    Solution { weights, offsets: vec![0.0; OUTPUTS] }
}

/// Σ z zᵀ over pixels, upper triangle.
struct Sums<'a> {
    stages: &'a Stages,
    target: &'a Planes,
    pixels: &'a [u32],
}

impl Kernel for Sums<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn run(self) -> Vec<f64> {
        let cols = self.target.cols();
        let mut sums = vec![0.0; STRIDE * STRIDE];
        let mut batch = vec![0.0f64; BATCH * STRIDE];
        let mut inputs = [0.0f32; COUNT];
        // Pixels ascend, so that neighbours in the list mostly share their row.
        let (mut read, mut lines) = (0, Lines::of(self.stages, 0));
        for pixels in self.pixels.chunks(BATCH) {
            for (&pixel, z) in pixels.iter().zip(batch.chunks_exact_mut(STRIDE)) {
                let (row, col) = (pixel as usize / cols, pixel as usize % cols);
                if row != read {
                    (read, lines) = (row, Lines::of(self.stages, row));
                }
                lines.read(col, &mut inputs);
                z[0] = 1.0;
                z[1..=COUNT].iter_mut().zip(&inputs).for_each(|(z, &v)| *z = f64::from(v));
                let targets = z[1 + COUNT..].iter_mut().zip(self.target.planes());
                targets.for_each(|(z, plane)| *z = f64::from(plane[pixel as usize]));
            }
            add_products(&batch[..pixels.len() * STRIDE], STRIDE, &mut sums);
        }
        sums
    }
}
