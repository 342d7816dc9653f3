//! Lanczos resampling along rows and columns.

use rayon::prelude::*;

/// Lobes of the kernel on either side.
const LOBES: f64 = 3.0;

/// The mapping between an axis of the image and that of the raw image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    shift: f64,
    scale: f64,
    len: usize,
}

/// Kernel weights at a position, for the samples from `first`.
struct Taps {
    first: usize,
    weights: Vec<f32>,
}

impl Axis {
    /// The `len` pixels of the image span `scale` pixels of the raw image each; the first begins at `shift`.
    pub(super) fn new(shift: f64, scale: f64, len: usize) -> Self {
        Self { shift, scale, len }
    }

    /// Centre of pixel `i` of the raw image, in pixels of the image.
    fn place(&self, i: usize) -> f64 {
        (i as f64 + 0.5 - self.shift) / self.scale - 0.5
    }

    /// Half the width of the kernel, in pixels of the image. It widens where the image is finer than the raw
    /// image.
    fn reach(&self) -> f64 {
        LOBES * (1.0 / self.scale).max(1.0)
    }

    /// The first pixel of the raw image (a multiple of `step`) and the number of pixels whose kernels lie
    /// within the image.
    pub(super) fn covered(&self, raw_len: usize, step: usize) -> (usize, usize) {
        let inside = |i: usize| {
            let (at, reach) = (self.place(i), self.reach());
            // At an integer position the kernel has a single weight; only pixels of equal size all have
            // integer positions.
            let reach = if at.fract() == 0.0 && self.scale == 1.0 { 0.0 } else { reach };
            at - reach >= -1e-9 && at + reach <= self.len as f64 - 1.0 + 1e-9
        };
        let Some(first) = (0..raw_len).find(|&i| i.is_multiple_of(step) && inside(i)) else { return (0, 0) };
        let end = (first..raw_len).find(|&i| !inside(i)).unwrap_or(raw_len);
        (first, end - first)
    }

    fn taps(&self, i: usize) -> Taps {
        let (at, reach) = (self.place(i), self.reach());
        let first = (at - reach).ceil().max(0.0) as usize;
        let last = ((at + reach).floor().max(0.0) as usize).min(self.len.saturating_sub(1));
        let stretch = reach / LOBES;
        let weights: Vec<f64> = (first..=last).map(|k| lanczos((k as f64 - at) / stretch)).collect();
        let sum: f64 = weights.iter().sum();
        Taps { first, weights: weights.iter().map(|w| (w / sum) as f32).collect() }
    }
}

fn lanczos(x: f64) -> f64 {
    let sinc = |x: f64| {
        let t = std::f64::consts::PI * x;
        if x == 0.0 { 1.0 } else { libm::sin(t) / t }
    };
    if x.abs() < LOBES { sinc(x) * sinc(x / LOBES) } else { 0.0 }
}

/// Rows and columns (first, number) of the grid of the raw image, from a plane of the image.
pub(super) fn plane(
    values: &[f32],
    rows: &Axis,
    cols: &Axis,
    (row, height): (usize, usize),
    (col, width): (usize, usize),
) -> Vec<f32> {
    let mut out = vec![0f32; height * width];
    let across: Vec<Taps> = (col..col + width).map(|c| cols.taps(c)).collect();
    out.par_chunks_mut(width.max(1)).enumerate().for_each(|(r, out)| {
        let down = rows.taps(row + r);
        let mut line = vec![0f32; cols.len];
        for (source, w) in values.chunks(cols.len.max(1)).skip(down.first).zip(&down.weights) {
            line.iter_mut().zip(source).for_each(|(l, v)| *l += w * v);
        }
        for (out, taps) in out.iter_mut().zip(&across) {
            let from = line.iter().skip(taps.first).zip(&taps.weights);
            *out = from.map(|(v, w)| v * w).sum();
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_wave_is_moved_by_fractions_and_scaled() {
        let n = 64;
        for (shift, scale) in [(0.0, 1.0), (0.37, 1.0), (-5.21, 1.0), (2.5, 2.0), (10.5, 1.5), (3.0, 0.5)] {
            let axis = Axis::new(shift, scale, n);
            // A wave of 16 pixels of the raw image.
            let wave = |x: f64| libm::sin(x / 16.0 * std::f64::consts::TAU);
            let picture: Vec<f32> =
                (0..n).map(|k| wave((k as f64 + 0.5) * scale + shift - 0.5) as f32).collect();
            let (first, count) = axis.covered(64, 4);
            assert!(first.is_multiple_of(4) && count >= 20, "{shift} {scale}: {first} {count}");
            let one = Axis::new(0.0, 1.0, 1);
            let moved = plane(&picture, &one, &axis, (0, 1), (first, count));
            for (i, v) in moved.iter().enumerate() {
                assert!(
                    (f64::from(*v) - wave((first + i) as f64)).abs() < 0.01,
                    "{shift} {scale} at {i}: {v}"
                );
            }
        }
    }

    /// A mirrored image covers the mirrored pixels.
    #[test]
    fn both_ends_of_an_image_cover_alike() {
        for (shift, scale, len) in
            [(0.0, 1.0, 40), (7.0, 1.0, 40), (7.5, 1.0, 40), (9.25, 1.0, 30), (3.5, 2.0, 20), (8.25, 0.5, 60)]
        {
            const RAW: usize = 64;
            let (first, count) = Axis::new(shift, scale, len).covered(RAW, 1);
            let mirrored = RAW as f64 - (shift + scale * len as f64);
            let found = Axis::new(mirrored, scale, len).covered(RAW, 1);
            assert!(count > 10);
            assert_eq!(found, (RAW - first - count, count), "{shift} {scale} {len}: from {first}");
        }
    }
}
