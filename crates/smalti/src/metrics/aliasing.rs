//! Aliasing: structures of a picture that its scene does not contain.
//!
//! A camera may blur, sharpen, shift or scale a pattern. This is a linear transfer and not aliasing. The residual of the best
//! such transfer of an alias-free reference is energy that is not in the reference: frequencies folded by sampling, false
//! colour, and zipper artefacts of demosaicking.
//!
//! The transfer is fitted by least squares in blocks of about 16 × 16 pixels: a constant and a filter of 3 × 3 taps from the
//! reference to the picture. A block of a zone plate contains nearly one frequency, and such a filter can give it any gain and
//! phase, including their change across the block. Residual energies are divided by the fraction of degrees of freedom that
//! the fit leaves, so that a pattern unrelated to the reference counts in full.
//!
//! Aliasing is stated as the share that the residual has in the energy of the picture: 0 % for a picture that is a linear transfer of
//! its reference, 100 % for one that has nothing to do with it. The ratio of the residual to the energy of the *reference*, which was
//! reported before, has no upper limit: a colour matrix with large coefficients of opposite sign, which filters with much overlap
//! need, amplifies the moiré of its channels to several times the contrast of the pattern. 971 % was false colour of 3.1
//! times the contrast of the zone plate, and is a share of about nine tenths of such a picture.

use rayon::prelude::*;

use super::MetricError;
use super::error::{at_least, finite};
use super::psnr::same_size;
use crate::numeric::Planes;

/// Side of the blocks, pixels. The last blocks of an image include the remainder and are up to twice as long.
const BLOCK: usize = 16;
/// A constant and 3 × 3 taps.
const UNKNOWNS: usize = 10;
/// Fraction of its energy that an unknown must explain beyond the others; otherwise its weight is 0.
const RANK_TOLERANCE: f64 = 1e-7;

/// Aliasing of a picture against an alias-free reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Aliasing {
    /// Luminance energy that is not in the reference, percent of the energy of the picture.
    pub luminance_percent: f64,
    /// Chromatic energy that is not in the reference, percent of the energy of the picture.
    pub color_percent: f64,
    /// Their sum, 0 to 100 %.
    pub total_percent: f64,
    /// The residual of each plane, signed, in the unit of the picture.
    pub difference: Planes,
}

/// Measures a picture against a reference of the same scene without mosaic and without frequencies beyond the Nyquist limit of
/// the pixel grid. A zone plate is best; any scene with fine detail will do. Both must be linear in light and free of noise,
/// because noise counts as aliasing.
///
/// With e the residual of a plane and weights w that sum to 1, luminance energy is that of Σ w e, colour energy is
/// Σ w (e − Σ w e)², both per pixel and relative to Σ w (picture − its mean)². A picture without any structure has no aliasing.
/// `luminance_weights` are the Y of the planes' primaries (0.2126, 0.7152, 0.0722 for linear sRGB); they are scaled to sum to 1.
///
/// # Errors
/// When the sizes differ or are below 16 × 16 pixels, a weight is negative or all are 0 or their number is not that
/// of the planes, a value is not finite, or the reference is uniform.
pub fn aliasing(
    picture: &Planes,
    reference: &Planes,
    luminance_weights: &[f64],
) -> Result<Aliasing, MetricError> {
    same_size(picture, reference)?;
    let (rows, cols) = (picture.rows(), picture.cols());
    at_least("pixels along the shorter side of the picture", BLOCK, rows.min(cols))?;
    finite("the picture", picture.data().iter().copied())?;
    finite("the reference", reference.data().iter().copied())?;
    let weights = shares(luminance_weights, picture.count())?;

    let bands: Vec<Vec<Residual>> = spans(rows)
        .into_par_iter()
        .map(|(top, height)| {
            let block = |(left, width)| residual(picture, reference, Block { top, left, height, width });
            spans(cols).into_iter().map(block).collect()
        })
        .collect();
    let energy_of = |all: &Planes| all.planes().zip(&weights).map(|(p, w)| w * energy(p)).sum::<f64>();
    if energy_of(reference) <= 0.0 {
        let reason = "the reference is uniform: it has no energy to compare with";
        return Err(MetricError::Undefined { quantity: "aliasing", reason });
    }
    let mut difference = Planes::zeros(rows, cols, picture.count());
    let (mut luminance, mut color) = (0.0, 0.0);
    for Residual { block, planes } in bands.iter().flatten() {
        for (p, (values, _)) in planes.iter().enumerate() {
            let out = difference.plane_mut(p)?;
            for (r, line) in values.chunks(block.width).enumerate() {
                let at = (block.top + r) * cols + block.left;
                for (o, v) in out.iter_mut().skip(at).zip(line) {
                    *o = *v as f32;
                }
            }
        }
        for i in 0..block.height * block.width {
            // Scaled by the remaining degrees of freedom, so that energies do not depend on the number of unknowns.
            let e = |p: usize| planes.get(p).map_or(0.0, |(v, scale)| v[i] * scale);
            let y: f64 = weights.iter().enumerate().map(|(p, w)| w * e(p)).sum();
            luminance += y * y;
            color += weights.iter().enumerate().map(|(p, w)| w * (e(p) - y).powi(2)).sum::<f64>();
        }
    }
    // The scale for the degrees of freedom is right on average: by chance, residuals may exceed the picture a little.
    let energy = energy_of(picture).max(luminance + color);
    let percent = |part: f64| if energy > 0.0 { 100.0 * part / energy } else { 0.0 };
    let (luminance_percent, color_percent) = (percent(luminance), percent(color));
    let total_percent = luminance_percent + color_percent;
    Ok(Aliasing { luminance_percent, color_percent, total_percent, difference })
}

/// Weights that sum to 1.
fn shares(weights: &[f64], count: usize) -> Result<Vec<f64>, MetricError> {
    if weights.len() != count {
        return Err(MetricError::Count { what: "luminance weights", expected: count, got: weights.len() });
    }
    let sum: f64 = weights.iter().sum();
    match weights.iter().find(|w| !(**w >= 0.0 && w.is_finite())) {
        None if sum > 0.0 => Ok(weights.iter().map(|w| w / sum).collect()),
        bad => {
            let expected = "finite, not below 0, not all 0";
            Err(MetricError::Parameter { name: "luminance_weights", value: *bad.unwrap_or(&0.0), expected })
        }
    }
}

/// Sum of squares about the mean.
fn energy(plane: &[f32]) -> f64 {
    let mean = plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64;
    plane.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum()
}

/// Starts and lengths of the blocks along a side of at least one block.
fn spans(length: usize) -> Vec<(usize, usize)> {
    let count = length / BLOCK;
    (0..count).map(|i| (i * BLOCK, if i + 1 == count { length - i * BLOCK } else { BLOCK })).collect()
}

#[derive(Clone, Copy)]
struct Block {
    top: usize,
    left: usize,
    height: usize,
    width: usize,
}

/// The residual of a block: for each plane the values in row order, and the scale for the degrees of freedom of the fit.
struct Residual {
    block: Block,
    planes: Vec<(Vec<f64>, f64)>,
}

fn residual(picture: &Planes, reference: &Planes, block: Block) -> Residual {
    let plane = |(target, reference_plane): (&[f32], &[f32])| {
        let n = (block.height * block.width) as f64;
        let taps = taps(reference_plane, (reference.rows(), reference.cols()), block);
        let at = |i: usize| (block.top + i / block.width) * picture.cols() + block.left + i % block.width;
        let values: Vec<f64> = (0..taps.len()).map(|i| f64::from(target[at(i)])).collect();
        let (weights, rank) = least_squares(&taps, &values);
        let fitted = |t: &[f64; UNKNOWNS]| t.iter().zip(&weights).map(|(a, b)| a * b).sum::<f64>();
        let left = taps.iter().zip(&values).map(|(t, v)| v - fitted(t)).collect();
        (left, (n / (n - rank as f64)).sqrt())
    };
    Residual { block, planes: picture.planes().zip(reference.planes()).map(plane).collect() }
}

/// For every pixel of a block: 1 and the 3 × 3 pixels of the reference around it, with border pixels repeated outside. The mean
/// of the block is subtracted, which the constant absorbs, to reduce rounding errors.
fn taps(plane: &[f32], (rows, cols): (usize, usize), block: Block) -> Vec<[f64; UNKNOWNS]> {
    let value = |row: usize, col: usize| f64::from(plane[row.min(rows - 1) * cols + col.min(cols - 1)]);
    let pixels = || (0..block.height).flat_map(move |r| (0..block.width).map(move |c| (r, c)));
    let n = (block.height * block.width) as f64;
    let mean = pixels().map(|(r, c)| value(block.top + r, block.left + c)).sum::<f64>() / n;
    pixels()
        .map(|(r, c)| {
            let mut line = [1.0; UNKNOWNS];
            for (k, slot) in line.iter_mut().skip(1).enumerate() {
                let row = (block.top + r + k / 3).saturating_sub(1);
                let col = (block.left + c + k % 3).saturating_sub(1);
                *slot = value(row, col) - mean;
            }
            line
        })
        .collect()
}

/// The least-squares weights of the taps, and the number of weights in use. The normal equations are solved by Cholesky's
/// method; an unknown that earlier ones already explain gets weight 0.
fn least_squares(taps: &[[f64; UNKNOWNS]], values: &[f64]) -> ([f64; UNKNOWNS], usize) {
    let mut gram = [[0.0; UNKNOWNS]; UNKNOWNS];
    let mut right = [0.0; UNKNOWNS];
    for (t, v) in taps.iter().zip(values) {
        for i in 0..UNKNOWNS {
            right[i] += t[i] * v;
            for j in 0..=i {
                gram[i][j] += t[i] * t[j];
            }
        }
    }
    let mut used = [false; UNKNOWNS];
    for i in 0..UNKNOWNS {
        let whole = gram[i][i];
        for j in 0..=i {
            let inner: f64 = (0..j).map(|k| gram[i][k] * gram[j][k]).sum();
            let rest = gram[i][j] - inner;
            gram[i][j] = if i == j {
                used[i] = rest > RANK_TOLERANCE * whole;
                if used[i] { rest.sqrt() } else { 0.0 }
            } else if used[j] {
                rest / gram[j][j]
            } else {
                0.0
            };
        }
    }
    let mut solution = [0.0; UNKNOWNS];
    for i in 0..UNKNOWNS {
        let inner: f64 = (0..i).map(|k| gram[i][k] * solution[k]).sum();
        solution[i] = if used[i] { (right[i] - inner) / gram[i][i] } else { 0.0 };
    }
    for i in (0..UNKNOWNS).rev() {
        let inner: f64 = (i + 1..UNKNOWNS).map(|k| gram[k][i] * solution[k]).sum();
        solution[i] = if used[i] { (solution[i] - inner) / gram[i][i] } else { 0.0 };
    }
    (solution, used.iter().filter(|u| **u).count())
}
