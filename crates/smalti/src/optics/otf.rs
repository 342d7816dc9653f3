//! The optical transfer function of one wavelength.

use super::diffraction::diffraction_limit;
use super::olpf::BirefringentLowPass;
use crate::numeric::elementary::whole_part_f32;
use crate::numeric::fft::{Complex32, bin_frequency};
use crate::numeric::simd::{Kernel, dispatch};

/// The optical transfer function of a lens and its low-pass filter at one wavelength, 1 at frequency zero.
/// Frequencies are in cycles per metre on the sensor: `fx` to the right, `fy` *down* the rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Otf {
    cutoff_cy_per_m: f64,
    lens: LensTransfer,
    low_pass: Option<BirefringentLowPass>,
}

/// The transfer function of the lens alone.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum LensTransfer {
    /// No blur.
    Unity,
    /// A table over frequency from 0 to the cut-off, for rotationally symmetric functions.
    Radial(Vec<f32>),
    /// The mean phase factor over the pupil, which multiplies the diffraction limit.
    Pupil {
        /// Over two-dimensional frequency.
        mean_phase: FrequencyGrid,
        /// Table of the diffraction limit.
        limit: Vec<f32>,
    },
    /// Transform of a point spread function.
    Sampled(FrequencyGrid),
}

impl Otf {
    pub(super) fn new(
        cutoff_cy_per_m: f64,
        lens: LensTransfer,
        low_pass: Option<BirefringentLowPass>,
    ) -> Self {
        Self { cutoff_cy_per_m, lens, low_pass }
    }

    /// The cut-off frequency in x and y, cycles/m; infinite for a pinhole.
    #[must_use]
    pub fn cutoff_cy_per_m(&self) -> f64 {
        self.cutoff_cy_per_m
    }

    /// The transfer function at a frequency.
    #[must_use]
    pub fn at(&self, fx_cy_per_m: f64, fy_cy_per_m: f64) -> Complex32 {
        let (fx, fy) = (fx_cy_per_m, fy_cy_per_m);
        let nu = fx.hypot(fy) / self.cutoff_cy_per_m;
        let lens = match &self.lens {
            LensTransfer::Unity => Complex32::ONE,
            LensTransfer::Radial(table) => lookup(table, nu as f32).into(),
            LensTransfer::Pupil { mean_phase, .. } => mean_phase.at(fx, fy) * diffraction_limit(nu) as f32,
            LensTransfer::Sampled(grid) if fx.abs().max(fy.abs()) < self.cutoff_cy_per_m => grid.at(fx, fy),
            LensTransfer::Sampled(_) => Complex32::ZERO,
        };
        lens * self.low_pass.map_or(1.0, |f| f.transfer(fx, fy)) as f32
    }

    /// The function on the frequencies of a transform.
    pub(super) fn on_grid(&self, rows: usize, cols: usize, spacing_m: f64) -> OtfOnGrid<'_> {
        let low_pass_rows = self
            .low_pass
            .map(|f| (0..rows).map(|k| f.transfer(0.0, bin_frequency(k, rows) / spacing_m) as f32).collect());
        OtfOnGrid { otf: self, rows, col_step: 1.0 / (cols as f64 * spacing_m), spacing_m, low_pass_rows }
    }
}

/// An [`Otf`] bound to the size and spacing of an image.
pub(super) struct OtfOnGrid<'a> {
    otf: &'a Otf,
    rows: usize,
    col_step: f64,
    spacing_m: f64,
    low_pass_rows: Option<Vec<f32>>,
}

impl OtfOnGrid<'_> {
    /// The number of horizontal bins below the cut-off.
    pub(super) fn passing(&self) -> usize {
        // A value too large for an integer, such as that of a pinhole, becomes the largest integer.
        (self.otf.cutoff_cy_per_m / self.col_step).ceil() as usize
    }

    /// Multiplies the spectrum at horizontal bin `kx`.
    pub(super) fn apply(&self, kx: usize, column: &mut [Complex32]) {
        let (otf, rows) = (self.otf, self.rows);
        let fx = kx as f64 * self.col_step;
        let fy = |ky: usize| bin_frequency(ky, rows) / self.spacing_m;
        match &otf.lens {
            LensTransfer::Unity => {}
            LensTransfer::Radial(table) => {
                let x = (fx / otf.cutoff_cy_per_m) as f32;
                let step = (1.0 / (rows as f64 * self.spacing_m * otf.cutoff_cy_per_m)) as f32;
                dispatch(RadialColumn { table, x, step, column });
            }
            LensTransfer::Pupil { mean_phase, limit } => {
                let mean_phase = mean_phase.at_column(fx);
                for (ky, v) in column.iter_mut().enumerate() {
                    let fy = fy(ky);
                    let limit = lookup(limit, ((fx * fx + fy * fy).sqrt() / otf.cutoff_cy_per_m) as f32);
                    *v = if limit > 0.0 { *v * mean_phase.at(fy) * limit } else { Complex32::ZERO };
                }
            }
            LensTransfer::Sampled(grid) => {
                let grid = grid.at_column(fx);
                for (ky, v) in column.iter_mut().enumerate() {
                    let fy = fy(ky);
                    *v = if fy.abs() < otf.cutoff_cy_per_m { *v * grid.at(fy) } else { Complex32::ZERO };
                }
            }
        }
        if let (Some(filter), Some(factors)) = (&otf.low_pass, &self.low_pass_rows) {
            let along_x = filter.transfer(fx, 0.0) as f32;
            for (v, k) in column.iter_mut().zip(factors) {
                *v *= along_x * k;
            }
        }
    }
}

/// A rotationally symmetric function on a column of the spectrum, which it multiplies.
struct RadialColumn<'a> {
    table: &'a [f32],
    /// Horizontal frequency, and the step of the vertical one, relative to the cut-off.
    x: f32,
    step: f32,
    column: &'a mut [Complex32],
}

impl Kernel for RadialColumn<'_> {
    type Output = ();

    /// Positive and negative frequencies have the same value: one look-up serves two samples.
    #[inline(always)]
    fn run(self) {
        const BLOCK: usize = 16;
        let Self { table, x, step, column } = self;
        let rows = column.len();
        for first in (0..=rows / 2).step_by(BLOCK) {
            let mut nu = [0.0f32; BLOCK];
            for (i, nu) in nu.iter_mut().enumerate() {
                let y = (first + i) as f32 * step;
                *nu = (x * x + y * y).sqrt();
            }
            let factors = lookup_all(table, &nu);
            let count = BLOCK.min(rows / 2 + 1 - first);
            let passing = nu[..count].iter().take_while(|nu| **nu < 1.0).count();
            let multiply = |(v, h): (&mut Complex32, &f32)| *v *= h;
            column[first..first + passing].iter_mut().zip(&factors).for_each(multiply);
            // Frequency zero and the Nyquist frequency have no negative counterpart.
            let own = first.max(1)..(first + passing).min(rows.div_ceil(2));
            if !own.is_empty() {
                let negative = &mut column[rows + 1 - own.end..=rows - own.start];
                negative.iter_mut().rev().zip(&factors[own.start - first..]).for_each(multiply);
            }
            if passing < count {
                let stopped = first + passing;
                column[stopped..=rows - stopped.max(1)].fill(Complex32::ZERO);
                return;
            }
        }
    }
}

/// [`lookup`] at several places. Those from 1 on, and those that are not finite, give arbitrary numbers.
#[inline(always)]
fn lookup_all<const N: usize>(table: &[f32], nu: &[f32; N]) -> [f32; N] {
    let last = table.len() - 1;
    let at = nu.map(|nu| nu * last as f32);
    let place = at.map(|at| whole_part_f32(at).min(last as u32 - 1));
    let (mut below, mut above) = ([0.0; N], [0.0; N]);
    for i in 0..N {
        if let Some(&[a, b]) = table.get(place[i] as usize..place[i] as usize + 2) {
            (below[i], above[i]) = (a, b);
        }
    }
    let mut found = [0.0; N];
    for i in 0..N {
        found[i] = below[i] + (at[i] - place[i] as f32) * (above[i] - below[i]);
    }
    found
}

/// A table over 0 to 1 at `nu`, by linear interpolation; 0 from 1 on.
pub(super) fn lookup(table: &[f32], nu: f32) -> f32 {
    let at = nu * (table.len() - 1) as f32;
    let i = at as usize;
    match table.get(i..i + 2) {
        Some(&[a, b]) => a + (at - i as f32) * (b - a),
        _ => 0.0,
    }
}

/// A Hermitian, periodic function of frequency on a square grid, in the order of the half spectrum of
/// [`RealFft2`].
///
/// [`RealFft2`]: crate::numeric::fft::RealFft2
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FrequencyGrid {
    side: usize,
    step_cy_per_m: f64,
    half: Vec<Complex32>,
}

/// A [`FrequencyGrid`] at one horizontal frequency.
struct GridColumn {
    side: i64,
    step_cy_per_m: f64,
    /// One period, followed by its first three values.
    values: Vec<Complex32>,
}

impl FrequencyGrid {
    /// `half` holds `side * (side / 2 + 1)` values.
    pub(super) fn new(side: usize, step_cy_per_m: f64, half: Vec<Complex32>) -> Self {
        Self { side, step_cy_per_m, half }
    }

    /// Cubic interpolation (Keys 1981).
    pub(super) fn at(&self, fx: f64, fy: f64) -> Complex32 {
        let (first, weights) = keys1981(fy / self.step_cy_per_m);
        let nodes = (first..).zip(weights);
        nodes.map(|(ky, w)| self.along_x(fx, ky) * w).sum()
    }

    /// Interpolates along x at every vertical node, so that a column costs four products per sample instead
    /// of sixteen.
    fn at_column(&self, fx: f64) -> GridColumn {
        let side = self.side as i64;
        let values = (0..side + 3).map(|ky| self.along_x(fx, ky)).collect();
        GridColumn { side, step_cy_per_m: self.step_cy_per_m, values }
    }

    fn along_x(&self, fx: f64, ky: i64) -> Complex32 {
        let (first, weights) = keys1981(fx / self.step_cy_per_m);
        let nodes = (first..).zip(weights);
        nodes.map(|(kx, w)| self.node(kx, ky) * w).sum()
    }

    fn node(&self, kx: i64, ky: i64) -> Complex32 {
        let side = self.side as i64;
        let (x, y) = (kx.rem_euclid(side), ky.rem_euclid(side));
        if x <= side / 2 {
            self.half[(x * side + y) as usize]
        } else {
            self.half[((side - x) * side + (side - y) % side) as usize].conj()
        }
    }
}

impl GridColumn {
    fn at(&self, fy: f64) -> Complex32 {
        let (first, weights) = keys1981(fy / self.step_cy_per_m);
        // Frequencies lie within half a period of zero.
        let first = if first < 0 { first + self.side } else { first };
        let nodes = self.values.get(first as usize..).unwrap_or(&[]);
        nodes.iter().zip(weights).map(|(v, w)| v * w).sum()
    }
}

/// First node and weights of the cubic that interpolates at `x` (Keys 1981, a = −1/2).
fn keys1981(x: f64) -> (i64, [f32; 4]) {
    // `floor` is a call into libm on x86-64 without SSE4.1.
    let toward_zero = x as i64;
    let base = toward_zero - i64::from(toward_zero as f64 > x);
    let t = (x - base as f64) as f32;
    let weights = [
        ((-0.5 * t + 1.0) * t - 0.5) * t,
        (1.5 * t - 2.5) * t * t + 1.0,
        ((-1.5 * t + 2.0) * t + 0.5) * t,
        (0.5 * t - 0.5) * t * t,
    ];
    (base.saturating_sub(1), weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn applying_to_a_grid_is_multiplying_by_the_function() {
        let spread: Vec<_> = (0..16 * 9).map(|i| Complex32::new((i % 7) as f32, 0.0)).collect();
        let lenses = [
            LensTransfer::Unity,
            LensTransfer::Radial(super::super::diffraction::in_focus()),
            LensTransfer::Sampled(FrequencyGrid::new(16, 0.05, spread.clone())),
            LensTransfer::Pupil {
                mean_phase: FrequencyGrid::new(16, 0.05, spread),
                limit: super::super::diffraction::in_focus(),
            },
        ];
        let low_pass = BirefringentLowPass { horizontal_separation_m: 0.7, vertical_separation_m: 1.1 };
        for lens in lenses {
            for (rows, cols) in [(24, 20), (15, 9), (1, 1), (2, 2), (32, 12), (33, 12), (80, 12), (71, 12)] {
                // Below and above the Nyquist frequency: with the latter, all samples pass.
                for cutoff in [0.37, 0.9] {
                    let otf = Otf::new(cutoff, lens.clone(), Some(low_pass));
                    let grid = otf.on_grid(rows, cols, 1.0);
                    for kx in 0..grid.passing().min(cols / 2 + 1) {
                        let mut column = vec![Complex32::ONE; rows];
                        grid.apply(kx, &mut column);
                        for (ky, v) in column.iter().enumerate() {
                            let want = otf.at(bin_frequency(kx, cols), bin_frequency(ky, rows));
                            assert!((v - want).norm() < 1e-5, "{cutoff} {rows} {kx} {ky} {v} {want}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn cubic_weights_sum_to_one_and_reproduce_lines() {
        for i in 0..20 {
            let x = f64::from(i) * 0.17 - 1.3;
            let (first, w) = keys1981(x);
            let line: f64 = (0..4).map(|k| (first + k as i64) as f64 * f64::from(w[k])).sum();
            assert!((w.iter().sum::<f32>() - 1.0).abs() < 1e-6 && (line - x).abs() < 1e-6);
        }
    }
}
