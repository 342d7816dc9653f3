//! Classification of a row of pixels at a time, in vectors of columns.
//!
//! What is summed over a patch is summed down its columns first and then along the row, so that neighbours share the
//! first half of the work.

use super::lattice::{self, Shift};
use super::orientation::{Orientation, Tensor};
use super::window::{LANES, Window};
use super::{Axes, MAX_SIDE, Textures};
use crate::numeric::simd::{Kernel, dispatch};

/// What classification of a row gives, one value per column.
#[derive(Debug, Default)]
pub(super) struct RowClasses {
    /// Level × textures + texture.
    pub(super) local: Vec<u32>,
    /// Channels that are clipped in the patch; all 0 where `clipped` is false.
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

/// Axes made ready for rows of an image.
#[derive(Debug, Clone)]
pub(super) struct Classifier {
    axes: Axes,
    half: usize,
    /// Differences between samples of like channels: the shift, and the rows and columns (inclusive, relative to
    /// the centre) of the patch that they start from.
    pairs: [Pairs; 2],
    orientation: Option<Orientation>,
    /// Per row of the tile, cut by cut, the cuts of `run` columns and a tile more: a run that starts at any phase.
    cuts: Vec<Vec<f32>>,
    /// Columns, whole vectors and whole tiles, after which phases of vectors repeat.
    run: usize,
    /// Per row of the tile, the bits of the channels of as many columns.
    bits: Vec<Vec<u32>>,
}

#[derive(Debug, Clone, Copy)]
struct Pairs {
    shift: Shift,
    rows: [isize; 2],
    cols: [isize; 2],
}

impl Pairs {
    fn new(shift: Shift, half: usize) -> Self {
        // Both ends within the patch; where the shift is longer than the patch, in the middle of it.
        let span = |s: isize| {
            let half = half as isize;
            let (from, to) = ((-half).max(-half - s), half.min(half - s));
            if from <= to { [from, to] } else { [-s.div_euclid(2), -s.div_euclid(2)] }
        };
        Self { shift, rows: span(shift[0]), cols: span(shift[1]) }
    }

    fn count(&self) -> usize {
        ((self.rows[1] - self.rows[0] + 1) * (self.cols[1] - self.cols[0] + 1)) as usize
    }

    /// How far beyond the centre samples are read, in rows and columns.
    fn reach(&self) -> [usize; 2] {
        let far = |span: [isize; 2], s: isize| {
            [span[0], span[1], span[0] + s, span[1] + s]
                .map(isize::unsigned_abs)
                .into_iter()
                .max()
                .unwrap_or(0)
        };
        [far(self.rows, self.shift[0]), far(self.cols, self.shift[1])]
    }
}

/// Columns after which a tile repeats at whole vectors: the least common multiple of its width and the lanes, which are a
/// power of two.
pub(super) fn run_of(tile_cols: usize) -> usize {
    tile_cols << (LANES.trailing_zeros() - tile_cols.trailing_zeros().min(LANES.trailing_zeros()))
}

impl Classifier {
    pub(super) fn new(axes: &Axes) -> Self {
        let half = axes.side() / 2;
        let shifts = lattice::basis(axes.mosaic());
        let (tile_rows, tile_cols) = (axes.mosaic().rows(), axes.mosaic().cols());
        let run = run_of(tile_cols);
        let cuts_of = |row: usize| {
            let cut = |j: usize, col: usize| axes.levels_at(row * tile_cols + col % tile_cols).cuts()[j];
            let columns = |j| (0..run + tile_cols).map(move |col| cut(j, col));
            (0..axes.level_count() - 1).flat_map(columns).collect()
        };
        let bits_of = |row: usize| {
            (0..run + tile_cols).map(|col| 1 << (axes.mosaic().channel_at(row, col) as u32)).collect()
        };
        Self {
            half,
            pairs: shifts.map(|s| Pairs::new(s, half)),
            orientation: (axes.textures() == Textures::Oriented).then(|| Orientation::new(shifts, half)),
            cuts: (0..tile_rows).map(cuts_of).collect(),
            run,
            bits: (0..tile_rows).map(bits_of).collect(),
            axes: axes.clone(),
        }
    }

    /// Rows and columns that a window must reach beyond the pixels that are classified.
    pub(super) fn margin(&self) -> [usize; 2] {
        let [a, b] = self.pairs.map(|p| p.reach());
        let c = self.orientation.as_ref().map_or([0, 0], Orientation::reach);
        [0, 1].map(|i| self.half.max(a[i]).max(b[i]).max(c[i]))
    }

    /// Classifies row `row` of a window, whose phase in the tile is `phase` (row and column of its first pixel).
    pub(super) fn row(&self, window: &Window, row: usize, phase: [usize; 2], out: &mut RowClasses) {
        dispatch(Row { classifier: self, window, row, phase, out });
    }
}

struct Row<'a> {
    classifier: &'a Classifier,
    window: &'a Window,
    row: usize,
    phase: [usize; 2],
    out: &'a mut RowClasses,
}

impl Kernel for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { classifier: c, window, row, phase, out } = self;
        let (padded, row) = (window.cols.next_multiple_of(LANES), row as isize);
        for v in [&mut out.local, &mut out.saturation] {
            v.resize(padded, 0);
        }
        out.mean.resize(padded, 0.0);
        let highest = c.sums(window, row, &mut out.scratch.sums);
        if c.axes.textures() != Textures::None {
            for (pairs, sums) in c.pairs.iter().zip(&mut out.scratch.differences) {
                differences(pairs, window, row, sums);
            }
        }
        c.levels(window, phase, &out.scratch, &mut out.mean, &mut out.local);
        if let Some(orientation) = &c.orientation {
            let kinds = Textures::Oriented.count() as u32;
            orientation.row(window, row, &mut out.scratch.tensor, kinds, &mut out.local);
        }
        out.clipped = highest >= c.axes.clip() as f32;
        if out.clipped {
            c.saturations(window, row, phase, &mut out.scratch.bits, &mut out.saturation);
        } else {
            out.saturation.fill(0);
        }
    }
}

/// A vector of a line, which lies within it: what is beyond the end would be zero.
#[inline(always)]
pub(super) fn vector<T: Copy + Default>(line: &[T], at: usize) -> [T; LANES] {
    line.get(at..).and_then(|l| l.first_chunk()).copied().unwrap_or([T::default(); LANES])
}

/// The vectors of a buffer that is made long enough for `len` columns.
#[inline(always)]
pub(super) fn vectors_of<T: Copy + Default>(
    buffer: &mut Vec<T>,
    len: usize,
) -> impl Iterator<Item = (usize, &mut [T; LANES])> {
    buffer.resize(len.next_multiple_of(LANES), T::default());
    buffer.as_chunks_mut().0.iter_mut().enumerate().map(|(i, v)| (i * LANES, v))
}

impl Classifier {
    /// Sums down the columns of the patches, from the first patch's first column on. Returns the highest sample; NaN is
    /// not high.
    #[inline(always)]
    fn sums(&self, window: &Window, row: isize, sums: &mut Vec<f32>) -> f32 {
        let (half, from) = (self.half as isize, window.margin[1] - self.half);
        let mut lines = [&[] as &[f32]; MAX_SIDE];
        let lines = &mut lines[..self.axes.side()];
        for (line, r) in lines.iter_mut().zip(-half..=half) {
            *line = window.line(row + r);
        }
        let mut highest = [f32::MIN; LANES];
        for (at, sum) in vectors_of(sums, window.cols.next_multiple_of(LANES) + 2 * self.half) {
            let mut total = [0.0; LANES];
            for line in lines.iter() {
                let v = vector(line, from + at);
                for i in 0..LANES {
                    total[i] += v[i];
                    highest[i] = if v[i] > highest[i] { v[i] } else { highest[i] };
                }
            }
            *sum = total;
        }
        highest.into_iter().fold(f32::MIN, f32::max)
    }

    /// Means, levels, and whether there is texture.
    #[inline(always)]
    fn levels(&self, window: &Window, phase: [usize; 2], s: &Scratch, mean: &mut [f32], local: &mut [u32]) {
        let (tile, kinds) = (self.axes.mosaic(), self.axes.textures());
        let cuts = &self.cuts[phase[0] % tile.rows()];
        let (first, period) = (phase[1] % tile.cols(), self.run + tile.cols());
        let share = 1.0 / self.axes.taps() as f32;
        let textures = kinds.count() as u32;
        let [v0, v1, v2] = self.contrast_limits();
        let spans = self.pairs.map(|p| (p.cols[1] - p.cols[0] + 1) as usize);
        debug_assert!(s.sums.len() >= window.cols + 2 * self.half);
        let vectors = mean.as_chunks_mut().0.iter_mut().zip(local.as_chunks_mut().0).enumerate();
        let (mut at, mut column) = (0, first);
        for (_, (mean, local)) in vectors {
            let mut total = [0.0; LANES];
            for tap in 0..=2 * self.half {
                let v = vector(&s.sums, at + tap);
                for i in 0..LANES {
                    total[i] += v[i];
                }
            }
            let mut level = [0u32; LANES];
            for i in 0..LANES {
                total[i] *= share;
            }
            let mut place = column;
            while place < cuts.len() {
                let cut: [f32; LANES] = vector(cuts, place);
                for i in 0..LANES {
                    level[i] += u32::from(total[i] >= cut[i]);
                }
                place += period;
            }
            for l in &mut level {
                *l *= textures;
            }
            if kinds != Textures::None {
                let mut contrast = [0.0; LANES];
                for (sums, span) in s.differences.iter().zip(spans) {
                    for tap in 0..span {
                        let v = vector(sums, at + tap);
                        for i in 0..LANES {
                            contrast[i] += v[i];
                        }
                    }
                }
                for i in 0..LANES {
                    let x = if total[i] > 0.0 { total[i] } else { 0.0 };
                    level[i] += u32::from(contrast[i] * contrast[i] > v0 + (v1 + v2 * x) * x);
                }
            }
            *mean = total;
            *local = level;
            at += LANES;
            column += LANES;
            if column >= first + self.run {
                column = first;
            }
        }
    }

    /// Coefficients of 1, x, x² in what the square of the summed differences must exceed to be texture.
    #[inline(always)]
    fn contrast_limits(&self) -> [f32; 3] {
        let count = self.pairs.iter().map(Pairs::count).sum::<usize>() as f32;
        let noise = self.axes.noise();
        let (over_noise, fraction) = self.axes.contrast();
        // Of the difference of two normal numbers of variance σ² the mean is 2σ / √π.
        let scale = (over_noise * over_noise * 4.0 / std::f64::consts::PI) as f32 * count * count;
        let [v0, v1] =
            [noise.constant + noise.row + noise.column, noise.per_signal].map(|v| v as f32 * scale);
        let v2 = noise.per_signal_squared as f32 * scale + (fraction * fraction) as f32 * count * count;
        [v0, v1, v2]
    }

    #[inline(always)]
    fn saturations(
        &self,
        window: &Window,
        row: isize,
        phase: [usize; 2],
        bits: &mut Vec<u32>,
        out: &mut [u32],
    ) {
        let (half, clip) = (self.half as isize, self.axes.clip() as f32);
        let (tile, from) = (self.axes.mosaic(), window.margin[1] - self.half);
        // The phase of the first patch's first column.
        let first = (phase[1] + tile.cols() * self.half - self.half) % tile.cols();
        let mut rows = [(&[] as &[f32], &[] as &[u32]); MAX_SIDE];
        let rows = &mut rows[..self.axes.side()];
        for (entry, r) in rows.iter_mut().zip(-half..=half) {
            let down = (phase[0] as isize + r).rem_euclid(tile.rows() as isize) as usize;
            *entry = (window.line(row + r), &self.bits[down]);
        }
        for (at, bits) in vectors_of(bits, out.len() + 2 * self.half) {
            let mut found = [0; LANES];
            for (line, channels) in rows.iter() {
                let (v, channel) = (vector(line, from + at), vector(channels, first + at % self.run));
                for i in 0..LANES {
                    found[i] |= if v[i] >= clip { channel[i] } else { 0 };
                }
            }
            *bits = found;
        }
        for (x, out) in out.as_chunks_mut().0.iter_mut().enumerate() {
            let mut found = [0; LANES];
            for tap in 0..=2 * self.half {
                let v = vector(bits, x * LANES + tap);
                for i in 0..LANES {
                    found[i] |= v[i];
                }
            }
            *out = found;
        }
    }
}

/// Sums down the rows that pairs start from of the differences between their ends, from their first column for the first
/// pixel on.
#[inline(always)]
fn differences(pairs: &Pairs, window: &Window, row: isize, sums: &mut Vec<f32>) {
    let mut lines = [(&[] as &[f32], &[] as &[f32]); MAX_SIDE];
    let count = (pairs.rows[1] - pairs.rows[0] + 1) as usize;
    let lines = &mut lines[..count.min(MAX_SIDE)];
    for (entry, r) in lines.iter_mut().zip(pairs.rows[0]..) {
        *entry = (window.line(row + r), window.line(row + r + pairs.shift[0]));
    }
    // The window's margin is as wide as the reach of the pairs, so that neither is negative.
    let from = (window.margin[1] as isize + pairs.cols[0]).max(0) as usize;
    let other = (window.margin[1] as isize + pairs.cols[0] + pairs.shift[1]).max(0) as usize;
    let span = (pairs.cols[1] - pairs.cols[0]) as usize;
    for (at, sum) in vectors_of(sums, window.cols.next_multiple_of(LANES) + span) {
        let mut total = [0.0; LANES];
        for (a, b) in lines.iter() {
            let (a, b): ([f32; LANES], [f32; LANES]) = (vector(a, from + at), vector(b, other + at));
            for i in 0..LANES {
                total[i] += (a[i] - b[i]).abs();
            }
        }
        *sum = total;
    }
}
