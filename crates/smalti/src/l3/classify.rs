//! Classification of pixels, row by row, in vectors of columns.
//!
//! Sums over a patch run down its columns first and then along the row, so that neighbouring patches share
//! the column sums.

use std::ops::Range;

use super::blocks::{Columns, LANES, add_taps, each, run_of, values, values_mut};
use super::orientation::{Orientation, Tensor};
use super::window::{Strip, Window};
use super::{Axes, ContrastPairs, MAX_SIDE, Textures};
use crate::numeric::simd::{Kernel, dispatch};

/// The classification of a row, one value per column.
#[derive(Debug, Default)]
pub(super) struct RowClasses {
    /// Level × number of textures + texture.
    pub(super) local: Vec<u32>,
    /// Bit mask of the channels that are clipped in the patch; all 0 where `clipped` is false.
    pub(super) saturation: Vec<u32>,
    /// Whether any sample near the row is clipped.
    pub(super) clipped: bool,
    /// Mean response of the patch.
    pub(super) mean: Vec<f32>,
    scratch: Scratch,
}

#[derive(Debug, Default)]
struct Scratch {
    sums: Vec<f32>,
    differences: [Vec<f32>; 2],
    tensor: Tensor,
    bits: Vec<u32>,
}

/// Class axes, prepared for the rows of an image.
#[derive(Debug, Clone)]
pub(super) struct Classifier {
    axes: Axes,
    half: usize,
    /// Differences between samples of equal channels: the shift, and the rows and columns (inclusive,
    /// relative to the centre of the patch) of their first samples.
    pairs: [ContrastPairs; 2],
    /// Coefficients of 1, x, x² in the threshold for the square of the summed differences.
    contrast_limit: [f32; 3],
    orientation: Option<Orientation>,
    /// Cut points of each row of the tile.
    cuts: Vec<Cuts>,
    /// Number of columns, in whole blocks and whole tiles, after which the phase of the vectors repeats.
    run: usize,
    /// For each row of the tile, the channel bits of this many columns.
    bits: Vec<Vec<u32>>,
}

/// Cut points between levels, for one row of the tile.
#[derive(Debug, Clone)]
struct Cuts {
    /// Concatenated cuts, each for a run of columns plus one tile, so that a run can start at any phase.
    columns: Vec<f32>,
    /// Number of cuts.
    count: usize,
    /// Columns stored per cut.
    period: usize,
}

impl Cuts {
    fn new(axes: &Axes, row: usize, run: usize) -> Self {
        let cols = axes.mosaic().cols();
        let cut = |j: usize, col: usize| axes.levels_at(row * cols + col % cols).cuts()[j];
        let columns = |j| (0..run + cols).map(move |col| cut(j, col));
        let count = axes.level_count() - 1;
        Self { columns: (0..count).flat_map(columns).collect(), count, period: run + cols }
    }

    /// The levels of means; the first mean has the phase of `column`. `below` is the number of cuts below all
    /// previous means. Neighbouring means are similar, so the search starts there and few cuts need to be
    /// tested.
    #[inline(always)]
    fn levels<const W: usize>(&self, means: &[f32; W], column: usize, below: &mut usize) -> [u32; W] {
        let cut = |j: usize| values::<f32, W>(&self.columns, j * self.period + column);
        while *below > 0 {
            let Some(cut) = cut(*below - 1) else { break };
            let mut all = true;
            for i in 0..W {
                all &= means[i] >= cut[i];
            }
            if all {
                break;
            }
            *below -= 1;
        }
        let mut levels = [*below as u32; W];
        for j in *below..self.count {
            let Some(cut) = cut(j) else { break };
            let (mut any, mut all) = (false, true);
            for i in 0..W {
                let above = means[i] >= cut[i];
                levels[i] += u32::from(above);
                any |= above;
                all &= above;
            }
            *below += usize::from(all);
            if !any {
                break;
            }
        }
        levels
    }
}

impl Classifier {
    pub(super) fn new(axes: &Axes) -> Self {
        let half = axes.side() / 2;
        let pairs = axes.contrast_pairs();
        let shifts = pairs.map(|p| p.shift);
        let (tile_rows, tile_cols) = (axes.mosaic().rows(), axes.mosaic().cols());
        let run = run_of(tile_cols);
        let bits_of = |row: usize| {
            (0..run + tile_cols).map(|col| 1 << (axes.mosaic().channel_at(row, col) as u32)).collect()
        };
        Self {
            half,
            pairs,
            contrast_limit: axes.summed_contrast_limit(),
            orientation: (axes.textures() == Textures::Oriented).then(|| Orientation::new(shifts, half)),
            cuts: (0..tile_rows).map(|row| Cuts::new(axes, row, run)).collect(),
            run,
            bits: (0..tile_rows).map(bits_of).collect(),
            axes: axes.clone(),
        }
    }

    /// Rows and columns of margin that a window needs around the classified pixels.
    pub(super) fn margin(&self) -> [usize; 2] {
        let [a, b] = self.pairs.map(|p| p.reach());
        let c = self.orientation.as_ref().map_or([0, 0], Orientation::reach);
        [0, 1].map(|i| self.half.max(a[i]).max(b[i]).max(c[i]))
    }

    /// Classifies columns of row `row` of a window. `phase` is the position of the row's first pixel in the
    /// tile. The output begins with the first of the columns and is padded to whole vectors.
    pub(super) fn row(
        &self,
        window: &Window,
        row: usize,
        phase: [usize; 2],
        cols: Range<usize>,
        out: &mut RowClasses,
    ) {
        let tile = self.axes.mosaic();
        let phase = [phase[0] % tile.rows(), (phase[1] + cols.start) % tile.cols()];
        let len = cols.len().next_multiple_of(LANES);
        let strip = Strip { window, row: row as isize, phase, first: cols.start, len };
        dispatch(Job { classifier: self, strip, out });
    }
}

struct Job<'a> {
    classifier: &'a Classifier,
    strip: Strip<'a>,
    out: &'a mut RowClasses,
}

impl Kernel for Job<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { classifier: c, strip, out } = self;
        out.local.resize(strip.len, 0);
        out.saturation.resize(strip.len, 0);
        out.mean.resize(strip.len, 0.0);
        out.clipped = c.clipped(strip.window, strip.row);
        let s = &mut out.scratch;
        sums(&strip, c.half, &mut s.sums);
        if c.axes.textures() != Textures::None {
            for (pairs, sums) in c.pairs.iter().zip(&mut s.differences) {
                differences(&strip, pairs, sums);
            }
        }
        let cuts = &c.cuts[strip.phase[0]];
        let spans = c.pairs.map(|p| (p.cols[1] - p.cols[0] + 1) as usize);
        let (mean, local) = (&mut out.mean, &mut out.local);
        each(
            strip.len,
            &mut Levels {
                classifier: c,
                strip,
                cuts,
                spans,
                limits: c.contrast_limit,
                below: 0,
                scratch: s,
                mean,
                local,
            },
        );
        if let Some(orientation) = &c.orientation {
            let kinds = Textures::Oriented.count() as u32;
            orientation.row(&strip, &mut s.tensor, kinds, &mut out.local);
        }
        if out.clipped {
            saturations(c, &strip, &mut s.bits, &mut out.saturation);
        } else {
            out.saturation.fill(0);
        }
    }
}

impl Classifier {
    /// Whether any sample in the patches of a row is clipped.
    fn clipped(&self, window: &Window, row: isize) -> bool {
        let from = (row + window.margin[0] as isize) as usize - self.half;
        let lines = window.highest.iter().skip(from).take(self.axes.side());
        lines.fold(f32::MIN, |a, &b| a.max(b)) >= self.axes.clip() as f32
    }
}

/// Sums down the columns of the patches, from the first column of the first patch.
#[inline(always)]
fn sums(strip: &Strip<'_>, half: usize, out: &mut Vec<f32>) {
    struct Sums<'a> {
        lines: &'a [&'a [f32]],
        from: usize,
        out: &'a mut [f32],
    }
    impl Columns for Sums<'_> {
        #[inline(always)]
        fn columns<const W: usize>(&mut self, at: usize) {
            let mut total = [0.0; W];
            for line in self.lines {
                add_taps(&mut total, line, self.from + at, 1);
            }
            if let Some(out) = values_mut(self.out, at) {
                *out = total;
            }
        }
    }
    let mut lines = [&[] as &[f32]; MAX_SIDE];
    let (half, lines) = (half as isize, &mut lines[..2 * half + 1]);
    for (line, r) in lines.iter_mut().zip(-half..) {
        *line = strip.window.line(strip.row + r);
    }
    out.resize((strip.len + 2 * half as usize).next_multiple_of(LANES), 0.0);
    each(out.len(), &mut Sums { lines, from: strip.at(-half), out });
}

/// Differences between the samples of a pair, summed down the rows; the first column belongs to the first
/// pixel.
#[inline(always)]
fn differences(strip: &Strip<'_>, pairs: &ContrastPairs, out: &mut Vec<f32>) {
    struct Differences<'a> {
        lines: &'a [[&'a [f32]; 2]],
        from: [usize; 2],
        out: &'a mut [f32],
    }
    impl Columns for Differences<'_> {
        #[inline(always)]
        fn columns<const W: usize>(&mut self, at: usize) {
            let mut total = [0.0; W];
            for [a, b] in self.lines {
                let ends = (values::<f32, W>(a, self.from[0] + at), values::<f32, W>(b, self.from[1] + at));
                let (Some(a), Some(b)) = ends else { return };
                for i in 0..W {
                    total[i] += (a[i] - b[i]).abs();
                }
            }
            if let Some(out) = values_mut(self.out, at) {
                *out = total;
            }
        }
    }
    let mut lines = [[&[] as &[f32]; 2]; MAX_SIDE];
    let count = (pairs.rows[1] - pairs.rows[0] + 1) as usize;
    let lines = &mut lines[..count.min(MAX_SIDE)];
    for (ends, r) in lines.iter_mut().zip(strip.row + pairs.rows[0]..) {
        *ends = [strip.window.line(r), strip.window.line(r + pairs.shift[0])];
    }
    let from = [strip.at(pairs.cols[0]), strip.at(pairs.cols[0] + pairs.shift[1])];
    out.resize((strip.len + (pairs.cols[1] - pairs.cols[0]) as usize).next_multiple_of(LANES), 0.0);
    each(out.len(), &mut Differences { lines, from, out });
}

/// Means, levels and texture.
struct Levels<'a> {
    classifier: &'a Classifier,
    strip: Strip<'a>,
    cuts: &'a Cuts,
    /// Number of first columns of the pairs in a patch, per shift.
    spans: [usize; 2],
    limits: [f32; 3],
    /// Number of cuts below all means of the previous block.
    below: usize,
    scratch: &'a Scratch,
    mean: &'a mut [f32],
    local: &'a mut [u32],
}

impl Columns for Levels<'_> {
    #[inline(always)]
    fn columns<const W: usize>(&mut self, at: usize) {
        let axes = &self.classifier.axes;
        let outs = (values_mut::<f32, W>(self.mean, at), values_mut::<u32, W>(self.local, at));
        let (Some(mean), Some(local)) = outs else { return };
        let mut total = [0.0; W];
        add_taps(&mut total, &self.scratch.sums, at, axes.side());
        let share = 1.0 / axes.taps() as f32;
        for mean in &mut total {
            *mean *= share;
        }
        let kinds = axes.textures().count() as u32;
        let mut level =
            self.cuts.levels(&total, self.strip.phase[1] + at % self.classifier.run, &mut self.below);
        for level in &mut level {
            *level *= kinds;
        }
        if kinds > 1 {
            let mut contrast = [0.0; W];
            for (sums, span) in self.scratch.differences.iter().zip(self.spans) {
                add_taps(&mut contrast, sums, at, span);
            }
            let [v0, v1, v2] = self.limits;
            for i in 0..W {
                let x = if total[i] > 0.0 { total[i] } else { 0.0 };
                level[i] += u32::from(contrast[i] * contrast[i] > v0 + (v1 + v2 * x) * x);
            }
        }
        *mean = total;
        *local = level;
    }
}

/// Channels that are clipped in each patch.
#[inline(always)]
fn saturations(c: &Classifier, strip: &Strip<'_>, bits: &mut Vec<u32>, out: &mut [u32]) {
    struct Samples<'a> {
        /// Samples of a row and the bits of their channels.
        rows: &'a [(&'a [f32], &'a [u32])],
        from: usize,
        first: usize,
        run: usize,
        clip: f32,
        out: &'a mut [u32],
    }
    impl Columns for Samples<'_> {
        #[inline(always)]
        fn columns<const W: usize>(&mut self, at: usize) {
            let mut found = [0; W];
            for (line, channels) in self.rows {
                let samples = values::<f32, W>(line, self.from + at);
                let channels = values::<u32, W>(channels, self.first + at % self.run);
                let (Some(samples), Some(channels)) = (samples, channels) else { return };
                for i in 0..W {
                    found[i] |= if samples[i] >= self.clip { channels[i] } else { 0 };
                }
            }
            if let Some(out) = values_mut(self.out, at) {
                *out = found;
            }
        }
    }
    struct Patches<'a> {
        bits: &'a [u32],
        side: usize,
        out: &'a mut [u32],
    }
    impl Columns for Patches<'_> {
        #[inline(always)]
        fn columns<const W: usize>(&mut self, at: usize) {
            let mut found = [0; W];
            for tap in 0..self.side {
                let Some(bits) = values::<u32, W>(self.bits, at + tap) else { return };
                for i in 0..W {
                    found[i] |= bits[i];
                }
            }
            if let Some(out) = values_mut(self.out, at) {
                *out = found;
            }
        }
    }
    let (half, tile) = (c.half as isize, c.axes.mosaic());
    let mut rows = [(&[] as &[f32], &[] as &[u32]); MAX_SIDE];
    let rows = &mut rows[..c.axes.side()];
    for (entry, r) in rows.iter_mut().zip(-half..) {
        let down = (strip.phase[0] as isize + r).rem_euclid(tile.rows() as isize) as usize;
        *entry = (strip.window.line(strip.row + r), &c.bits[down]);
    }
    // The phase of the first column of the first patch.
    let first = (strip.phase[1] as isize - half).rem_euclid(tile.cols() as isize) as usize;
    bits.resize((strip.len + 2 * c.half).next_multiple_of(LANES), 0);
    let clip = c.axes.clip() as f32;
    each(bits.len(), &mut Samples { rows, from: strip.at(-half), first, run: c.run, clip, out: bits });
    each(strip.len, &mut Patches { bits, side: c.axes.side(), out });
}

#[cfg(test)]
mod tests;
