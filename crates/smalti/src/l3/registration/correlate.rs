//! Shifts between planes, by phase correlation.

use rayon::prelude::*;

use super::error::RegistrationError;
use crate::numeric::ShapeError;
use crate::numeric::fft::{Complex32, FftError, RealFft2, bin_frequency, fast_len};

/// Maximum side of the plane in the exhaustive search.
const COARSE_SIDE: usize = 512;
/// Side of the patches at full resolution, and the maximum number of patches along each side.
const PATCH_SIDE: usize = 256;
const MAX_PATCHES: usize = 6;
/// Standard deviation of the frequency weight, cycles per pixel. At higher frequencies the channels of a
/// mosaic alias, and noise dominates.
const BAND: f64 = 0.12;
/// Minimum fraction of the spectrum of a patch that agrees with its shift. Noise alone reaches 0.01.
const MIN_AGREEMENT: f64 = 0.1;
/// Finest step of the peak search, pixels.
const FINEST: f64 = 0.005;
/// Side of the squares over which the planes are averaged before they are correlated, pixels.
const SMOOTHED: usize = 4;

/// A plane of values, row by row.
#[derive(Debug, Clone)]
pub(super) struct Plane {
    pub(super) rows: usize,
    pub(super) cols: usize,
    pub(super) values: Vec<f32>,
}

/// A plane on the grid of another, at this row and column.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    pub(super) plane: Plane,
    pub(super) row: usize,
    pub(super) col: usize,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shift {
    pub(super) row: f64,
    pub(super) col: f64,
}

/// The shift of one patch.
#[derive(Debug, Clone, Copy)]
pub(super) struct PatchShift {
    /// Centre of the patch in the placed plane, pixels.
    row: usize,
    col: usize,
    shift: Shift,
}

impl Plane {
    pub(super) fn new(rows: usize, cols: usize, values: Vec<f32>) -> Result<Self, ShapeError> {
        if values.len() != rows * cols {
            return Err(ShapeError { count: 1, rows, cols, expected: rows * cols, got: values.len() });
        }
        Ok(Self { rows, cols, values })
    }

    /// Whether all values are equal.
    pub(super) fn is_uniform(&self) -> bool {
        self.values.windows(2).all(|w| w[0] == w[1])
    }

    /// Rows and columns (first, number) of the plane.
    fn part(&self, (row, high): (usize, usize), (col, wide): (usize, usize)) -> Result<Self, ShapeError> {
        let rows = self.values.chunks_exact(self.cols.max(1)).skip(row).take(high);
        Self::new(high, wide, rows.flat_map(|r| r.iter().skip(col).take(wide).copied()).collect())
    }

    /// Means over squares of `step` × `step` pixels of another plane, whose pixels span `scale` pixels of
    /// this one. `step` is at least 1, so that every square contains a pixel.
    fn reduced(&self, step: f64) -> Self {
        let (rows, cols) = ((self.rows as f64 / step) as usize, (self.cols as f64 / step) as usize);
        let range = |i: usize, len: usize| {
            let from = (i as f64 * step).round() as usize;
            from..(((i + 1) as f64 * step).round() as usize).clamp(from + 1, len.max(from + 1))
        };
        let mut values = vec![0f32; rows * cols];
        values.par_chunks_mut(cols.max(1)).enumerate().for_each(|(r, out)| {
            for (c, v) in out.iter_mut().enumerate() {
                let span = range(c, self.cols);
                let (mut sum, mut n) = (0f64, 0usize);
                for y in range(r, self.rows) {
                    let line = &self.values[y * self.cols..][span.clone()];
                    line.iter().for_each(|x| sum += f64::from(*x));
                    n += line.len();
                }
                *v = (sum / n as f64) as f32;
            }
        });
        Self { rows, cols, values }
    }

    /// A window without its mean, tapered to zero at its edges (Hann) and placed in the corner of a plane of
    /// zeros.
    fn window(
        &self,
        (row, high): (usize, usize),
        (col, wide): (usize, usize),
        size: (usize, usize),
    ) -> Result<Vec<f32>, ShapeError> {
        let part = self.part((row, high), (col, wide))?;
        let mean = part.values.iter().map(|v| f64::from(*v)).sum::<f64>() / part.values.len().max(1) as f64;
        let hann =
            |i: usize, n: usize| 0.5 - 0.5 * libm::cos(std::f64::consts::TAU * (i as f64 + 0.5) / n as f64);
        let across: Vec<f64> = (0..wide).map(|c| hann(c, wide)).collect();
        let mut out = vec![0f32; size.0 * size.1];
        let lines = part.values.chunks_exact(wide.max(1)).zip(out.chunks_mut(size.1.max(1)));
        for (r, (values, out)) in lines.enumerate() {
            let down = hann(r, high);
            for ((v, w), out) in values.iter().zip(&across).zip(out) {
                *out = ((f64::from(*v) - mean) * w * down) as f32;
            }
        }
        Ok(out)
    }
}

/// The terms of the half spectrum of a correlation, partially whitened: the phase weighs more than the
/// amplitude, and frequencies without signal weigh little.
struct CrossPower {
    rows: usize,
    /// Vertical bin, horizontal frequency, real and imaginary part, column by column.
    terms: Vec<(usize, f64, f64, f64)>,
}

impl CrossPower {
    fn of(fft: &RealFft2, a: &[f32], b: &[f32]) -> Result<Self, FftError> {
        let rows = fft.rows();
        let (a, b) = (fft.forward(a)?, fft.forward(b)?);
        let term = |(i, (a, b)): (usize, (&Complex32, &Complex32))| {
            let (fx, fy) = (bin_frequency(i / rows, fft.cols()), bin_frequency(i % rows, rows));
            let weight = libm::exp(-(fx * fx + fy * fy) / (2.0 * BAND * BAND));
            let (ar, ai, br, bi) = (f64::from(a.re), f64::from(a.im), f64::from(b.re), f64::from(b.im));
            let (re, im) = (ar * br + ai * bi, ai * br - ar * bi);
            let size = re.hypot(im);
            // Every column except the first also represents the conjugate half of the spectrum.
            let weight = if i / rows == 0 { weight } else { 2.0 * weight } / size.sqrt();
            (size > 0.0 && weight.is_finite()).then_some((i % rows, fx, re * weight, im * weight))
        };
        Ok(Self { rows, terms: a.iter().zip(&b).enumerate().filter_map(term).collect() })
    }

    /// The correlation at given rows and columns.
    fn at(&self, rows: &[f64], cols: &[f64]) -> Vec<f64> {
        use std::f64::consts::TAU;
        let phases: Vec<Vec<(f64, f64)>> = rows
            .iter()
            .map(|r| (0..self.rows).map(|k| libm::sincos(TAU * bin_frequency(k, self.rows) * r)).collect())
            .collect();
        let mut out = vec![0.0; rows.len() * cols.len()];
        for column in self.terms.chunk_by(|a, b| a.1 == b.1) {
            let fx = column[0].1;
            for (phases, out) in phases.iter().zip(out.chunks_mut(cols.len().max(1))) {
                let (mut re, mut im) = (0.0, 0.0);
                for &(k, _, tr, ti) in column {
                    let (s, c) = phases[k];
                    re += tr * c - ti * s;
                    im += tr * s + ti * c;
                }
                for (x, out) in cols.iter().zip(out) {
                    let (s, c) = libm::sincos(TAU * fx * x);
                    *out += re * c - im * s;
                }
            }
        }
        out
    }

    /// The position of the peak near `at`, refined from this step on, and the fraction (0 to 1) of the
    /// spectrum that agrees with it. `None` when the planes have no frequency in common.
    fn peak(&self, mut at: Shift, mut step: f64) -> Option<(Shift, f64)> {
        let total: f64 = self.terms.iter().map(|t| t.2.hypot(t.3)).sum();
        if total <= 0.0 {
            return None;
        }
        let mut agrees = 0.0;
        while step >= FINEST {
            let along =
                |middle: f64| -> [f64; 9] { std::array::from_fn(|i| middle + (i as f64 - 4.0) * step) };
            let (rows, cols) = (along(at.row), along(at.col));
            let places = rows.iter().flat_map(|&row| cols.map(|col| Shift { row, col }));
            let values = self.at(&rows, &cols);
            let (best, value) = places.zip(values).max_by(|a, b| a.1.total_cmp(&b.1))?;
            (at, agrees) = (best, value / total);
            step /= 4.0;
        }
        Some((at, agrees))
    }
}

/// The sum of the squares.
fn energy(values: &[f32]) -> f64 {
    values.iter().map(|x| f64::from(*x).powi(2)).sum()
}

/// Position of the moving plane's corner on the fixed plane, to about a pixel.
pub(super) fn coarse(fixed: &Plane, moving: &Plane, scale: f64) -> Result<Shift, RegistrationError> {
    let largest = fixed.rows.max(fixed.cols) as f64;
    let step = (largest / COARSE_SIDE as f64).max(1.0).max(scale);
    let reduced = |p: &Plane, step: f64| {
        let small = p.reduced(step);
        if small.values.is_empty() {
            return Err(RegistrationError::too_small(p.rows, p.cols, step.ceil() as usize));
        }
        Ok(small)
    };
    let (a, b) = (reduced(fixed, step)?, reduced(moving, step / scale)?);
    let size = (fast_len(a.rows + b.rows), fast_len(a.cols + b.cols));
    let fft = RealFft2::new(size.0, size.1)?;
    let window = |p: &Plane, what| {
        let window = p.window((0, p.rows), (0, p.cols), size)?;
        if energy(&window) > 0.0 { Ok(window) } else { Err(RegistrationError::Uniform(what)) }
    };
    let (wa, wb) = (window(&a, "the raw image")?, window(&b, "the image")?);
    let power = CrossPower::of(&fft, &wa, &wb)?;
    let mut spectrum = vec![Complex32::default(); size.0 * fft.half_cols()];
    for &(k, fx, re, im) in &power.terms {
        let bin = (fx * size.1 as f64).round() as usize;
        if let Some(s) = spectrum.get_mut(bin * size.0 + k) {
            // Terms of the first column count once, all others twice.
            let half = if bin == 0 { 1.0 } else { 0.5 };
            *s = Complex32::new((re * half) as f32, (im * half) as f32);
        }
    }
    let correlation = fft.inverse(&spectrum)?;
    // Indices beyond the extent of the fixed plane represent negative shifts.
    let signed = |i: usize, n: usize, limit: usize| if i > limit { i as f64 - n as f64 } else { i as f64 };
    let place =
        |i: usize| Shift { row: signed(i / size.1, size.0, a.rows), col: signed(i % size.1, size.1, a.cols) };
    // The image shows the scene of the raw image. Where only a corner is common, a high correlation is
    // coincidental.
    let common = |s: Shift| {
        let along = |shift: f64, a: usize, b: usize| (a as f64).min(shift + b as f64) - shift.max(0.0);
        along(s.row, a.rows, b.rows).max(0.0) * along(s.col, a.cols, b.cols).max(0.0)
    };
    let least = (a.values.len().min(b.values.len())) as f64 / 2.0;
    let candidates = correlation.iter().enumerate().filter(|(i, _)| common(place(*i)) >= least);
    let (best, _) = candidates.max_by(|a, b| a.1.total_cmp(b.1)).ok_or(RegistrationError::NoOverlap)?;
    // Planes without a common frequency have a correlation of 0 at every shift.
    let (at, _) = power.peak(place(best), 0.25).ok_or(RegistrationError::NoMatch(0.0))?;
    Ok(Shift { row: at.row * step, col: at.col * step })
}

/// The residual shift of each patch of the placed plane that has enough structure. A plane too small for patches
/// has none.
pub(super) fn patches(fixed: &Plane, placed: &Placed) -> Result<Vec<PatchShift>, RegistrationError> {
    let p = &placed.plane;
    // At least two patches along a side, so that every quadrant contains one.
    let side = |len: usize| PATCH_SIDE.min(len / 2) & !1;
    let (high, wide) = (side(p.rows), side(p.cols));
    if high.min(wide) < 12 {
        return Ok(Vec::new());
    }
    let fft = RealFft2::new(high, wide)?;
    let starts = |len: usize, side: usize| -> Vec<usize> {
        let n = (len / side).clamp(2, MAX_PATCHES);
        (0..n).map(|i| i * (len - side) / (n - 1)).collect()
    };
    let places: Vec<(usize, usize)> = starts(p.rows, high)
        .into_iter()
        .flat_map(|r| starts(p.cols, wide).into_iter().map(move |c| (r, c)))
        .collect();
    let one = |&(row, col): &(usize, usize)| -> Result<Option<PatchShift>, RegistrationError> {
        let a = fixed.window((placed.row + row, high), (placed.col + col, wide), (high, wide))?;
        let b = p.window((row, high), (col, wide), (high, wide))?;
        let peak = CrossPower::of(&fft, &a, &b)?.peak(Shift { row: 0.0, col: 0.0 }, 2.0);
        let found = peak.filter(|(_, agrees)| *agrees >= MIN_AGREEMENT);
        Ok(found.map(|(shift, _)| PatchShift { row: row + high / 2, col: col + wide / 2, shift }))
    };
    places.par_iter().filter_map(|place| one(place).transpose()).collect()
}

/// The median shift of the patches, along rows and columns.
pub(super) fn middle(patches: &[PatchShift]) -> Option<Shift> {
    let median = |of: fn(&PatchShift) -> f64| {
        let mut values: Vec<f64> = patches.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        let (low, high) = (values.len().checked_sub(1)? / 2, values.len() / 2);
        Some((values.get(low)? + values.get(high)?) / 2.0)
    };
    Some(Shift { row: median(|p| p.shift.row)?, col: median(|p| p.shift.col)? })
}

/// The median in each quadrant of the placed plane.
pub(super) fn quadrants(placed: &Placed, patches: &[PatchShift]) -> [Option<[f64; 2]>; 4] {
    let p = &placed.plane;
    [(false, false), (false, true), (true, false), (true, true)].map(|(low, right)| {
        let of = |s: &&PatchShift| (2 * s.row >= p.rows) == low && (2 * s.col >= p.cols) == right;
        let own: Vec<PatchShift> = patches.iter().filter(of).copied().collect();
        middle(&own).map(|s| [s.row, s.col])
    })
}

/// Pearson correlation of the placed plane and the fixed plane below it, after smoothing over 4 × 4 pixels.
pub(super) fn pearson(fixed: &Plane, placed: &Placed) -> Result<f64, RegistrationError> {
    let p = &placed.plane;
    let under = fixed.part((placed.row, p.rows), (placed.col, p.cols))?;
    let (a, b) = (under.reduced(SMOOTHED as f64), p.reduced(SMOOTHED as f64));
    if b.values.is_empty() {
        return Err(RegistrationError::too_small(p.rows, p.cols, SMOOTHED));
    }
    let mean = |v: &[f32]| v.iter().map(|x| f64::from(*x)).sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(&a.values), mean(&b.values));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (x, y) in a.values.iter().zip(&b.values) {
        let (x, y) = (f64::from(*x) - ma, f64::from(*y) - mb);
        (ab, aa, bb) = (ab + x * y, aa + x * x, bb + y * y);
    }
    for (variance, what) in [(aa, "the common part of the raw image"), (bb, "the common part of the image")] {
        if variance <= 0.0 {
            return Err(RegistrationError::Uniform(what));
        }
    }
    Ok(ab / (aa * bb).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plane of pseudorandom values.
    fn noise(rows: usize, cols: usize) -> Plane {
        let mut stream = crate::numeric::philox::Stream::new(1, 2, 3);
        Plane::new(rows, cols, (0..rows * cols).map(|_| stream.uniform() as f32).collect()).unwrap()
    }

    #[test]
    fn a_failed_transform_is_an_error() {
        let fft = RealFft2::new(8, 8).unwrap();
        let error = CrossPower::of(&fft, &[0.0; 64], &[0.0; 63]).err();
        assert!(matches!(error, Some(FftError::Length { .. })), "{error:?}");
    }

    #[test]
    fn planes_that_cross_have_no_overlap() {
        let found = coarse(&noise(32, 320), &noise(320, 32), 1.0);
        assert_eq!(found, Err(RegistrationError::NoOverlap));
    }

    #[test]
    fn a_uniform_plane_has_no_position() {
        let (flat, structured) = (Plane::new(40, 40, vec![0.3; 1600]).unwrap(), noise(40, 40));
        assert!(flat.is_uniform() && !structured.is_uniform());
        assert_eq!(coarse(&flat, &structured, 1.0), Err(RegistrationError::Uniform("the raw image")));
        assert_eq!(coarse(&structured, &flat, 1.0), Err(RegistrationError::Uniform("the image")));
        let placed = Placed { plane: flat, row: 0, col: 0 };
        let expected = Err(RegistrationError::Uniform("the common part of the image"));
        assert_eq!(pearson(&structured, &placed), expected);
    }

    #[test]
    fn a_part_beyond_the_plane_is_an_error() {
        let placed = Placed { plane: noise(40, 40), row: 1, col: 0 };
        assert!(matches!(pearson(&noise(40, 40), &placed), Err(RegistrationError::Shape(_))));
        assert!(matches!(patches(&noise(40, 40), &placed), Err(RegistrationError::Shape(_))));
    }

    #[test]
    fn a_plane_narrower_than_a_step_of_the_search_is_an_error() {
        let found = coarse(&noise(2, 2048), &noise(2, 2048), 1.0);
        assert_eq!(found, Err(RegistrationError::TooSmall { rows: 2, cols: 2048, least: 4 }));
    }
    /// A part of a plane is found where it was taken from, whatever the unit of the values.
    #[test]
    fn a_part_is_found_at_its_place_in_any_light() {
        let whole = noise(40, 60);
        for (row, col, high, wide) in [(7, 13, 24, 32), (3, 20, 30, 36)] {
            let part = whole.part((row, high), (col, wide)).unwrap();
            for light in [1e-3, 1.0, 1e3] {
                let lit = |p: &Plane| {
                    Plane::new(p.rows, p.cols, p.values.iter().map(|v| v * light).collect()).unwrap()
                };
                let found = coarse(&lit(&whole), &lit(&part), 1.0).unwrap();
                let off = (found.row - row as f64).abs().max((found.col - col as f64).abs());
                // The tapered windows of whole and part differ.
                assert!(off < 0.1, "{found:?} for {row}, {col} in light {light}");
            }
        }
    }

    /// Patches cover a plane from edge to edge, and find no shift where the plane lies where it belongs.
    #[test]
    fn patches_reach_from_edge_to_edge() {
        let fixed = noise(40, 1100);
        for (rows, cols, across) in [(24, 60, 2), (30, 768, 3), (26, 1030, 4)] {
            let placed = Placed { plane: fixed.part((5, rows), (11, cols)).unwrap(), row: 5, col: 11 };
            let found = patches(&fixed, &placed).unwrap();
            let (high, wide) = (rows / 4 * 2, if cols < 512 { cols / 2 } else { 256 });
            assert_eq!(found.len(), 2 * across, "{rows} × {cols}");
            let range = |of: fn(&PatchShift) -> usize| {
                (found.iter().map(of).min().unwrap(), found.iter().map(of).max().unwrap())
            };
            assert_eq!(range(|p| p.row), (high / 2, rows - high / 2));
            assert_eq!(range(|p| p.col), (wide / 2, cols - wide / 2));
            let steps: Vec<usize> = found[..across].windows(2).map(|p| p[1].col - p[0].col).collect();
            assert!(steps.iter().all(|s| s.abs_diff(steps[0]) <= 1), "{steps:?}");
            // The finest step of the search.
            assert!(found.iter().all(|p| p.shift.row.abs().max(p.shift.col.abs()) < FINEST), "{found:?}");
        }
    }

    #[test]
    fn every_quadrant_has_the_median_of_its_own_patches() {
        let placed = Placed { plane: noise(9, 12), row: 0, col: 0 };
        // The middle row is above the middle of the plane, and column 6 is the first of its right half.
        let places = [([0, 4], [0, 5]), ([0, 4], [6, 11]), ([5, 8], [0, 5]), ([5, 8], [6, 11])];
        let mut all = Vec::new();
        for (quadrant, (rows, cols)) in places.into_iter().enumerate() {
            for (i, (row, col)) in [(0, 0), (0, 1), (1, 1)].into_iter().enumerate() {
                let shift = Shift { row: quadrant as f64, col: i as f64 - 10.0 * quadrant as f64 };
                all.push(PatchShift { row: rows[row], col: cols[col], shift });
            }
        }
        let expected = [0.0, 1.0, 2.0, 3.0].map(|q| Some([q, 1.0 - 10.0 * q]));
        assert_eq!(quadrants(&placed, &all), expected);
        assert_eq!(quadrants(&placed, &all[3..6]), [None, expected[1], None, None]);
    }
}
