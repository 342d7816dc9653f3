//! From the classes of a row to the kernels of its pixels.

use super::super::Pipeline;
use super::super::blocks::run_of;
use super::super::classify::RowClasses;
use crate::numeric::simd::{Kernel, dispatch};

/// The numbers of pixels outside the range of the training data. They are rendered with the nearest class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct OutsideCounts {
    /// Pixels whose patch has a mean response below all training patches of their position.
    pub darker: u64,
    /// Pixels whose patch has a mean response above all training patches of their position.
    pub brighter: u64,
    /// Pixels whose patch has a combination of clipped channels that is not on the saturation axis.
    pub saturation: u64,
}

impl std::ops::Add for OutsideCounts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            darker: self.darker + other.darker,
            brighter: self.brighter + other.brighter,
            saturation: self.saturation + other.saturation,
        }
    }
}

/// Maximum number of channels for which a table lists every combination of clipped channels.
const MAX_LISTED: usize = 12;
/// Minimum number of columns processed together.
const MIN_RUN: usize = 256;

/// The kernels of a pixel, and whether the pixel lies within the range of the training data.
#[derive(Debug, Clone)]
pub(super) struct Index {
    /// References to the kernels of each class, for the inner loops.
    kernels: Vec<u32>,
    /// Registers per class, if every class has its own kernels, stored in order.
    step: Option<u32>,
    /// Per row of the tile, for the columns of a run plus one tile: first class of the position, trained
    /// range.
    columns: Vec<Columns>,
    /// Period of these columns.
    run: usize,
    tile: [usize; 2],
    /// Classes per combination of clipped channels at a position.
    per_saturation: usize,
    /// The index on the saturation axis of every combination of clipped channels, if there are few channels.
    listed: Vec<u32>,
}

#[derive(Debug, Clone, Default)]
struct Columns {
    base: Vec<u32>,
    least: Vec<f32>,
    most: Vec<f32>,
}

impl Index {
    pub(super) fn new(pipeline: &Pipeline, kernels: Vec<u32>) -> Self {
        let axes = pipeline.axes();
        let tile = [axes.mosaic().rows(), axes.mosaic().cols()];
        let vectors = run_of(tile[1]);
        let run = vectors * MIN_RUN.div_ceil(vectors);
        let columns_of = |row: usize| {
            let mut columns = Columns::default();
            for col in 0..run + tile[1] {
                let position = row * tile[1] + col % tile[1];
                let [least, most] = pipeline.trained()[position];
                columns.base.push(pipeline.index(position, 0, 0, 0) as u32);
                columns.least.push(least);
                columns.most.push(most);
            }
            columns
        };
        let channels = axes.mosaic().channels();
        let listed = if channels <= MAX_LISTED { 1u32 << channels } else { 0 };
        let step = kernels.get(1).copied().filter(|&step| {
            kernels.iter().enumerate().all(|(class, &from)| class as u64 * u64::from(step) == u64::from(from))
        });
        Self {
            kernels,
            step,
            columns: (0..tile[0]).map(columns_of).collect(),
            run,
            tile,
            per_saturation: axes.level_count() * axes.textures().count(),
            listed: (0..listed).map(|mask| pipeline.saturation_place(mask) as u32).collect(),
        }
    }

    /// Finds the kernels of `cols` classified pixels; `phase` is that of the first one. `out` is padded to
    /// whole vectors.
    pub(super) fn row(
        &self,
        pipeline: &Pipeline,
        classes: &RowClasses,
        phase: [usize; 2],
        cols: usize,
        out: &mut [u32],
    ) -> OutsideCounts {
        let mut outside = dispatch(Row { index: self, classes, phase, cols, out });
        if classes.clipped {
            outside.saturation = self.saturations(pipeline, classes, &mut out[..cols]);
        }
        if let Some(step) = self.step {
            out[..cols].iter_mut().for_each(|class| *class *= step);
        } else {
            for class in &mut out[..cols] {
                *class = self.kernels.get(*class as usize).copied().unwrap_or(0);
            }
        }
        out[cols..].fill(0);
        outside
    }

    /// Moves classes to the index of their clipped channels. Returns the number of pixels whose combination
    /// is not on the axis.
    fn saturations(&self, pipeline: &Pipeline, classes: &RowClasses, out: &mut [u32]) -> u64 {
        let (mut missing, mut last, mut place, mut known) = (0, 0, 0, true);
        for (class, &mask) in out.iter_mut().zip(&classes.saturation) {
            // Neighbouring pixels mostly have the same clipped channels.
            if mask != last {
                last = mask;
                let listed = self.listed.get(mask as usize);
                place = listed.map_or_else(|| pipeline.saturation_place(mask) as u32, |&place| place);
                known = pipeline.saturations().get(place as usize) == Some(&mask);
            }
            *class += place * self.per_saturation as u32;
            missing += u64::from(!known);
        }
        missing
    }
}

struct Row<'a> {
    index: &'a Index,
    classes: &'a RowClasses,
    phase: [usize; 2],
    cols: usize,
    out: &'a mut [u32],
}

impl Kernel for Row<'_> {
    type Output = OutsideCounts;

    #[inline(always)]
    fn run(self) -> OutsideCounts {
        let Self { index, classes, phase, cols, out } = self;
        let columns = &index.columns[phase[0] % index.tile[0]];
        let first = phase[1] % index.tile[1];
        let run = first..first + index.run;
        let (base, least, most) =
            (&columns.base[run.clone()], &columns.least[run.clone()], &columns.most[run]);
        let mut outside = OutsideCounts::default();
        let runs = classes.local[..cols].chunks(index.run).zip(classes.mean[..cols].chunks(index.run));
        for ((local, mean), out) in runs.zip(out[..cols].chunks_mut(index.run)) {
            for ((out, &local), &base) in out.iter_mut().zip(local).zip(base) {
                *out = base + local;
            }
            let (mut darker, mut brighter) = (0u32, 0u32);
            for ((&mean, &least), &most) in mean.iter().zip(least).zip(most) {
                darker += u32::from(mean < least);
                brighter += u32::from(mean > most);
            }
            outside.darker += u64::from(darker);
            outside.brighter += u64::from(brighter);
        }
        outside
    }
}
