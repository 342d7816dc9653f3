//! Classification of a row of pixels at a time, in vectors of columns.

use super::lattice::{self, Shift};
use super::window::{LANES, Window};
use super::{Axes, Textures};
use crate::numeric::simd::{Kernel, dispatch};

/// Edges count as such when their structure tensor is this coherent: (λ₁ − λ₂) / (λ₁ + λ₂) of its eigenvalues.
const COHERENT: f32 = 0.5;

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
    sum: Vec<f32>,
    differences: [Vec<f32>; 2],
    tensor: [Vec<f32>; 3],
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
    /// From differences along the two shifts to those along rows and columns, per pixel.
    gradient: [[f32; 2]; 2],
    /// Per row of the tile and cut: the cut for each column of a run that repeats with tile and lanes.
    cuts: Vec<Vec<Vec<f32>>>,
    run: usize,
    /// Per row of the tile, the bit of each column's channel.
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

impl Classifier {
    pub(super) fn new(axes: &Axes) -> Self {
        let half = axes.side() / 2;
        let shifts = lattice::basis(axes.mosaic());
        let [[a, b], [c, d]] = shifts.map(|s| s.map(|v| v as f32));
        let det = a * d - b * c;
        let (tile_rows, tile_cols) = (axes.mosaic().rows(), axes.mosaic().cols());
        // The least common multiple of tile width and lanes, which are a power of two.
        let run =
            tile_cols << (LANES.trailing_zeros() - tile_cols.trailing_zeros().min(LANES.trailing_zeros()));
        let cut =
            |row: usize, j: usize, col: usize| axes.levels_at(row * tile_cols + col % tile_cols).cuts()[j];
        let cuts_of =
            |row| (0..axes.level_count() - 1).map(move |j| (0..run).map(|col| cut(row, j, col)).collect());
        let bits_of = |row| {
            (0..tile_cols).map(|col| 1 << (axes.mosaic().channel_at(row, col) as u32)).collect::<Vec<u32>>()
        };
        Self {
            half,
            pairs: shifts.map(|s| Pairs::new(s, half)),
            // The shifts are the rows of a matrix that takes gradients to differences; this is its inverse.
            gradient: [[d / det, -b / det], [-c / det, a / det]],
            cuts: (0..tile_rows).map(|row| cuts_of(row).collect()).collect(),
            run,
            bits: (0..tile_rows).map(bits_of).collect(),
            axes: axes.clone(),
        }
    }

    /// Rows and columns that a window must reach beyond the pixels that are classified.
    pub(super) fn margin(&self) -> [usize; 2] {
        let [a, b] = self.pairs.map(|p| p.reach());
        // Starting columns of pairs may lie left of the patch's by as much again.
        [self.half.max(a[0]).max(b[0]), self.half.max(a[1]).max(b[1])]
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
        let cols = window.cols;
        let padded = cols.next_multiple_of(LANES);
        let row = row as isize;
        for v in [&mut out.local, &mut out.saturation] {
            v.resize(padded, 0);
        }
        out.mean.resize(padded, 0.0);
        c.means(window, row, &mut out.scratch.sum, &mut out.mean);
        c.levels(&out.mean, phase, &mut out.local);
        c.textures(window, row, &mut out.scratch, &out.mean, &mut out.local);
        out.clipped = c.saturations(window, row, phase, &mut out.scratch.bits, &mut out.saturation);
    }
}

impl Classifier {
    #[inline(always)]
    fn means(&self, window: &Window, row: isize, sum: &mut Vec<f32>, mean: &mut [f32]) {
        let (half, left) = (self.half as isize, window.margin[1] - self.half);
        sum.clear();
        sum.resize(window.stride, 0.0);
        for r in -half..=half {
            sum.iter_mut().zip(window.line(row + r)).for_each(|(s, &v)| *s += v);
        }
        mean.fill(0.0);
        for at in left..=left + 2 * self.half {
            mean.iter_mut().zip(&sum[at..]).for_each(|(m, &s)| *m += s);
        }
        let share = 1.0 / self.axes.taps() as f32;
        mean.iter_mut().for_each(|m| *m *= share);
    }

    #[inline(always)]
    fn levels(&self, mean: &[f32], phase: [usize; 2], local: &mut [u32]) {
        let tile = self.axes.mosaic();
        let cuts = &self.cuts[phase[0] % tile.rows()];
        let (first, textures) = (phase[1] % tile.cols(), self.axes.textures().count() as u32);
        // The first run starts at the image's first column, whose phase is `first`; runs begin at whole vectors, so that
        // columns of a run have to be turned by it.
        local.fill(0);
        for (mean, local) in mean.chunks(self.run).zip(local.chunks_mut(self.run)) {
            for cut in cuts {
                let (head, tail) = cut.split_at(first);
                let turned = tail.iter().chain(head);
                if first == 0 {
                    for ((l, &m), &cut) in local.iter_mut().zip(mean).zip(cut) {
                        *l += u32::from(m >= cut);
                    }
                } else {
                    for ((l, &m), &cut) in local.iter_mut().zip(mean).zip(turned) {
                        *l += u32::from(m >= cut);
                    }
                }
            }
        }
        local.iter_mut().for_each(|l| *l *= textures);
    }

    #[inline(always)]
    fn textures(&self, window: &Window, row: isize, s: &mut Scratch, mean: &[f32], local: &mut [u32]) {
        let kinds = self.axes.textures();
        if kinds == Textures::None {
            return;
        }
        let mut contrast = std::mem::take(&mut s.sum);
        contrast.clear();
        contrast.resize(mean.len(), 0.0);
        for (pairs, sums) in self.pairs.iter().zip(&mut s.differences) {
            sums.clear();
            sums.resize(window.stride, 0.0);
            let right = pairs.shift[1];
            for r in pairs.rows[0]..=pairs.rows[1] {
                let (a, b) = (window.line(row + r), window.line(row + r + pairs.shift[0]));
                add_differences(sums, a, b, right);
            }
            let left = window.margin[1] as isize;
            for c in pairs.cols[0]..=pairs.cols[1] {
                let from = &sums[(left + c) as usize..];
                contrast.iter_mut().zip(from).for_each(|(o, &d)| *o += d);
            }
        }
        let count = self.pairs.iter().map(Pairs::count).sum::<usize>() as f32;
        let noise = self.axes.noise();
        let (over_noise, fraction) = self.axes.contrast();
        // Of the difference of two normal numbers of variance σ² the mean is 2σ / √π.
        let scale = (over_noise * over_noise * 4.0 / std::f64::consts::PI) as f32 * count * count;
        let [v0, v1] =
            [noise.constant + noise.row + noise.column, noise.per_signal].map(|v| v as f32 * scale);
        let v2 = noise.per_signal_squared as f32 * scale + (fraction * fraction) as f32 * count * count;
        for ((l, &d), &m) in local.iter_mut().zip(&contrast).zip(mean) {
            let x = m.max(0.0);
            *l += u32::from(d * d > v0 + (v1 + v2 * x) * x);
        }
        if kinds == Textures::Oriented {
            self.orientations(window, row, s, kinds.count() as u32, local);
        }
        s.sum = contrast;
    }

    /// Adds 1 to 4 to textures whose structure tensor has a direction.
    #[inline(always)]
    fn orientations(&self, window: &Window, row: isize, s: &mut Scratch, kinds: u32, local: &mut [u32]) {
        let half = self.half as isize;
        let [p, q] = self.pairs.map(|p| p.shift);
        let [[g00, g01], [g10, g11]] = self.gradient;
        // Tensor entries (down·down, down·right, right·right), summed down the patch first.
        for t in &mut s.tensor {
            t.clear();
            t.resize(window.stride, 0.0);
        }
        let [dd, dr, rr] = &mut s.tensor;
        let margin = window.margin[1] as isize;
        let from = (margin - half).max(0) as usize;
        // The end up to which every shifted sample is within the line.
        let reach = p[1].max(q[1]).max(0) as usize;
        let until = window.stride.saturating_sub(reach);
        for r in -half..=half {
            // Differences start so that the pair lies around the row it stands for.
            let start = |v: Shift| (row + r - v[0].div_euclid(2), -v[1].div_euclid(2));
            let ((ra, ca), (rb, cb)) = (start(p), start(q));
            let line = |r: isize| {
                window.line(r.clamp(-(window.margin[0] as isize), row + window.margin[0] as isize))
            };
            let (a0, a1) = (line(ra), line(ra + p[0]));
            let (b0, b1) = (line(rb), line(rb + q[0]));
            let at = |line: &[f32], col: isize| line.get(col.max(0) as usize).copied().unwrap_or(0.0);
            for x in from..until {
                let c = x as isize;
                let first = at(a1, c + ca + p[1]) - at(a0, c + ca);
                let second = at(b1, c + cb + q[1]) - at(b0, c + cb);
                let (down, right) = (g00 * first + g01 * second, g10 * first + g11 * second);
                dd[x] += down * down;
                dr[x] += down * right;
                rr[x] += right * right;
            }
        }
        let first = (margin - half) as usize;
        for (x, l) in local.iter_mut().enumerate() {
            if *l % kinds == 0 {
                continue;
            }
            let span = first + x..(first + x + 2 * self.half + 1).min(dd.len());
            let sum = |t: &[f32]| t.get(span.clone()).map_or(0.0, |t| t.iter().sum::<f32>());
            let (dd, dr, rr) = (sum(dd), sum(dr), sum(rr));
            let (difference, twice) = (rr - dd, 2.0 * dr);
            let spread = (difference * difference + twice * twice).sqrt();
            if spread > COHERENT * (dd + rr) {
                // The gradient's direction is half the angle of (difference, twice).
                *l += 1 + direction(difference, twice);
            }
        }
    }

    #[inline(always)]
    fn saturations(
        &self,
        window: &Window,
        row: isize,
        phase: [usize; 2],
        bits: &mut Vec<u32>,
        out: &mut [u32],
    ) -> bool {
        let (half, clip) = (self.half as isize, self.axes.clip() as f32);
        let tile = self.axes.mosaic();
        let highest = |line: &[f32]| line.iter().copied().fold(f32::MIN, f32::max);
        if (-half..=half).all(|r| highest(window.line(row + r)) < clip) {
            out.fill(0);
            return false;
        }
        bits.clear();
        bits.resize(window.stride, 0);
        // The phase of the first sample of a line, which lies a margin to the left of the image.
        let left = tile.cols() * window.margin[1] + phase[1] - window.margin[1];
        for r in -half..=half {
            let down = (phase[0] as isize + r).rem_euclid(tile.rows() as isize) as usize;
            let channels = &self.bits[down];
            for (x, (b, &v)) in bits.iter_mut().zip(window.line(row + r)).enumerate() {
                if v >= clip {
                    *b |= channels[(left + x) % tile.cols()];
                }
            }
        }
        out.fill(0);
        let first = window.margin[1] - self.half;
        for at in first..=first + 2 * self.half {
            out.iter_mut().zip(&bits[at..]).for_each(|(o, &b)| *o |= b);
        }
        true
    }
}

/// `sums[x] += |a[x] − b[x + right]|` wherever both are there.
#[inline(always)]
fn add_differences(sums: &mut [f32], a: &[f32], b: &[f32], right: isize) {
    let skip = right.unsigned_abs();
    if right >= 0 {
        let b = b.get(skip..).unwrap_or(&[]);
        sums.iter_mut().zip(a).zip(b).for_each(|((s, x), y)| *s += (x - y).abs());
    } else if let (Some(sums), Some(a)) = (sums.get_mut(skip..), a.get(skip..)) {
        sums.iter_mut().zip(a).zip(b).for_each(|((s, x), y)| *s += (x - y).abs());
    }
}

/// Which of the four directions 0°, 45°, 90°, 135° is nearest to half the angle of (`cos`, `sin`).
#[inline(always)]
fn direction(cos: f32, sin: f32) -> u32 {
    // Doubled, the directions lie at 0°, 90°, 180° and 270°.
    if cos.abs() >= sin.abs() {
        if cos >= 0.0 { 0 } else { 2 }
    } else if sin > 0.0 {
        1
    } else {
        3
    }
}
