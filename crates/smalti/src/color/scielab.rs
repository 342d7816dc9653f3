//! S-CIELAB: a colour difference that accounts for the spatial resolution of the eye.
//!
//! X. Zhang and B. A. Wandell (1997), "A spatial extension of CIELAB for digital color-image reproduction",
//! *Journal of the SID* 5(1). Both images are separated into luminance, red-green and blue-yellow planes.
//! Each plane is blurred with the kernel of the eye for it. CIELAB then compares the blurred images.
//!
//! Grey is neutral in these planes only under light such as D65. Under a warm lamp an edge between light and dark would be one of colour, which
//! the kernels of different width would turn into coloured fringes that nobody sees. X, Y, Z are therefore scaled from their white to that of
//! D65 before the separation and back after the blur, as the eye adapts, and as iCAM does ([fairchild2004]). The scaling is that of CIELAB, so that
//! uniform images still differ as their colours.
//!
//! [fairchild2004]: https://doi.org/10.1117/1.1635368

use rayon::prelude::*;
use thiserror::Error;

use super::difference::{DeltaE, DifferenceMap, LabReference, check_pair};
use super::matrix::{Matrix3, diagonal, inverse, known, product};
use super::{Image, ImageError};
use crate::numeric::mirror::about_border;
use crate::numeric::simd::{Kernel, dispatch};

/// Errors of S-CIELAB.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ScielabError {
    /// The images cannot be compared.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The kernels cannot be sampled at this resolution.
    #[error("samples_per_degree is {0}; expected 1 to 2000")]
    SamplesPerDegree(f64),
    /// CIELAB is undefined relative to this white.
    #[error("white is X, Y, Z = {0:?}; expected three finite numbers above 0")]
    White([f64; 3]),
}

/// The interpretation of the kernel widths, which are in degrees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum KernelWidth {
    /// As printed in the paper: exp(−r²/σ²), luminance σ 0.0283°, 0.133°, 4.336°; red-green 0.0392°, 0.494°;
    /// blue-yellow 0.0536°, 0.386°.
    #[default]
    ZhangWandell1997,
    /// As in ISETCam (2021): the full widths at half maximum of the first S-CIELAB program (0.05°, 0.225°,
    /// 7°; 0.0685°, 0.826°; 0.092°, 0.6451°), taken as half widths. These kernels are twice as wide as those
    /// of the paper.
    Isetcam,
}

/// The matrix from XYZ to opponent colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Opponent {
    /// From XYZ of a 2° observer, as in the paper, except that Z contributes +0.077 to red-green, as in the
    /// authors' program. With the printed value of −0.077, white would be far from neutral.
    #[default]
    Degrees2,
    /// From XYZ of the 10° observer (the first S-CIELAB program's).
    Degrees10,
}

impl Opponent {
    /// Luminance, red-green and blue-yellow from X, Y, Z.
    pub(crate) const fn matrix(self) -> Matrix3 {
        match self {
            Self::Degrees2 => [
                [0.2787336, 0.7218031, -0.1065520],
                [-0.4487736, 0.2898056, 0.0771569],
                [0.0859513, -0.5899859, 0.5011089],
            ],
            Self::Degrees10 => [
                [0.2885613, 0.6597617, -0.1305654],
                [-0.4648864, 0.3262702, 0.0624200],
                [0.0798787, -0.5547976, 0.4814746],
            ],
        }
    }

    /// X, Y, Z from luminance, red-green and blue-yellow.
    pub(crate) const fn inverse_matrix(self) -> Matrix3 {
        const DEGREES_2: Matrix3 = known(inverse(&Opponent::Degrees2.matrix()));
        const DEGREES_10: Matrix3 = known(inverse(&Opponent::Degrees10.matrix()));
        match self {
            Self::Degrees2 => DEGREES_2,
            Self::Degrees10 => DEGREES_10,
        }
    }
}

/// The white that is neutral in the opponent planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Adaptation {
    /// That of the images: X, Y, Z are scaled from it to D65 before the separation.
    #[default]
    White,
    /// None, as in the paper and in ISETCam: X, Y, Z as they are. Under D65 the results are the same.
    None,
}

/// X, Y, Z of D65 for the 2° observer, Y = 1 (CIE 15).
const D65: [f64; 3] = [0.95047, 1.0, 1.08883];

/// Extension of the images beyond their borders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Extension {
    /// Reflection, with the border pixel repeated.
    #[default]
    Mirror,
    /// Periodic continuation.
    Periodic,
}

/// The settings of a comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scielab {
    /// Pixels per degree of visual angle.
    pub samples_per_degree: f64,
    /// The colour difference formula for the blurred images.
    pub formula: DeltaE,
    /// The widths of the kernels.
    pub kernels: KernelWidth,
    /// The matrix to opponent colours.
    pub opponent: Opponent,
    /// The white that is neutral in the opponent planes.
    pub adaptation: Adaptation,
    /// Extension of the images beyond their borders.
    pub extension: Extension,
}

/// S-CIELAB of two images in XYZ (CIE 1931) relative to a white in the same scale. The kernels are those of
/// the paper, white is neutral for them, and the images are reflected at their borders. [`Scielab`] offers the alternatives.
///
/// # Errors
/// When an image is not in XYZ, the sizes differ, `white` is not positive, or `samples_per_degree` is not within 1–2000.
pub fn scielab(
    reference: &Image,
    test: &Image,
    white: [f64; 3],
    samples_per_degree: f64,
    formula: DeltaE,
) -> Result<DifferenceMap, ScielabError> {
    Scielab::new(samples_per_degree, formula).compare(reference, test, white)
}

impl Scielab {
    /// The settings of the paper, with an eye that is adapted to white.
    #[must_use]
    pub fn new(samples_per_degree: f64, formula: DeltaE) -> Self {
        Self {
            samples_per_degree,
            formula,
            kernels: KernelWidth::default(),
            opponent: Opponent::default(),
            adaptation: Adaptation::default(),
            extension: Extension::default(),
        }
    }

    /// The difference at every pixel, relative to a white in the scale of the images.
    ///
    /// # Errors
    /// As [`scielab`].
    pub fn compare(
        &self,
        reference: &Image,
        test: &Image,
        white: [f64; 3],
    ) -> Result<DifferenceMap, ScielabError> {
        check_pair(reference, test)?;
        self.difference_from(&self.reference(reference, white)?, test)
    }

    /// A reference after the blur of the eye, to which several images of its size are compared.
    pub(crate) fn reference(&self, reference: &Image, white: [f64; 3]) -> Result<LabReference, ScielabError> {
        let filtered = self.filtered(reference, white)?;
        let size = (reference.rows(), reference.cols());
        Ok(LabReference::new(size, filtered.each_ref().map(Vec::as_slice), white))
    }

    /// The difference of an image from a reference of its size.
    pub(crate) fn difference_from(
        &self,
        reference: &LabReference,
        test: &Image,
    ) -> Result<DifferenceMap, ScielabError> {
        let filtered = self.filtered(test, reference.white())?;
        Ok(reference.map(filtered.each_ref().map(Vec::as_slice), self.formula))
    }

    /// The matrices from X, Y, Z relative to a white to the opponent colours, and back.
    ///
    /// # Errors
    /// When the white is not positive.
    pub(crate) fn opponent_matrices(&self, white: [f64; 3]) -> Result<[Matrix3; 2], ScielabError> {
        if !white.iter().all(|v| v.is_finite() && *v > 0.0) {
            return Err(ScielabError::White(white));
        }
        let [to, from] = [self.opponent.matrix(), self.opponent.inverse_matrix()];
        Ok(match self.adaptation {
            Adaptation::None => [to, from],
            Adaptation::White => {
                let scale: [f64; 3] = std::array::from_fn(|i| D65[i] * white[1] / white[i]);
                [product(&to, &diagonal(scale)), product(&diagonal(scale.map(f64::recip)), &from)]
            }
        })
    }

    /// The X, Y, Z planes of an image after the blur of the eye, which sees `white` as neutral.
    pub(crate) fn filtered(&self, image: &Image, white: [f64; 3]) -> Result<[Vec<f32>; 3], ScielabError> {
        let kernels = self.kernels()?;
        let [opponent_from_xyz, xyz_from_opponent] = self.opponent_matrices(white)?;
        let opponent = transformed(&opponent_from_xyz, image.channels());
        let shape = (image.rows(), image.cols());
        let blurred = [0, 1, 2].map(|c| blur(&opponent[c], shape, &kernels[c], self.extension));
        Ok(transformed(&xyz_from_opponent, blurred.each_ref().map(Vec::as_slice)))
    }

    /// The sums over all pixels of the product of the kernel of one opponent plane and that of another, displaced by 0 to `reach` rows
    /// (slowest) and columns: what white noise that reaches two pixels keeps in common after the blur. The planes are in the order of
    /// a packed symmetric matrix: (0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2).
    ///
    /// # Errors
    /// When `samples_per_degree` is not within 1–2000.
    pub(crate) fn overlaps(&self, reach: usize) -> Result<Vec<[f64; 6]>, ScielabError> {
        let kernels = self.kernels()?;
        let at = |g: &Gaussian, i: isize| g.half.get(i.unsigned_abs()).map_or(0.0, |v| f64::from(*v));
        let along = |a: &Gaussian, b: &Gaussian, by: usize| -> f64 {
            let radius = a.half.len() as isize - 1;
            (-radius..=radius).map(|i| at(a, i) * at(b, i + by as isize)).sum()
        };
        let mut out = vec![[0.0; 6]; (reach + 1) * (reach + 1)];
        let mut entry = 0;
        for first in 0..3 {
            for second in 0..=first {
                for a in &kernels[first] {
                    for b in &kernels[second] {
                        let line: Vec<f64> = (0..=reach).map(|by| along(a, b, by)).collect();
                        let weight = f64::from(a.weight) * f64::from(b.weight);
                        for (place, sums) in out.iter_mut().enumerate() {
                            sums[entry] += weight * line[place / (reach + 1)] * line[place % (reach + 1)];
                        }
                    }
                }
                entry += 1;
            }
        }
        Ok(out)
    }

    /// The Gaussians of each opponent plane with their weights and samples; every kernel sums to one.
    ///
    /// Each Gaussian is truncated to a support of one degree, normalised, and then weighted.
    fn kernels(&self) -> Result<[Vec<Gaussian>; 3], ScielabError> {
        let per_degree = self.samples_per_degree;
        if !(1.0..=2000.0).contains(&per_degree) {
            return Err(ScielabError::SamplesPerDegree(per_degree));
        }
        // The widest odd support within one degree, with at least three samples.
        let radius = ((per_degree / 2.0).ceil() as usize - 1).max(1);
        let parts: [&[(f64, f64, f64)]; 3] = [
            // Weight, σ of the paper, and half width of ISETCam, in degrees. The weights are those of the
            // first program, which sum to one. The paper prints them multiplied by 0.918, 0.861 and 0.859,
            // with three decimals.
            &[(1.00327, 0.0283, 0.05), (0.114416, 0.133, 0.225), (-0.117686, 4.336, 7.0)],
            &[(0.616725, 0.0392, 0.0685), (0.383275, 0.494, 0.826)],
            &[(0.567885, 0.0536, 0.092), (0.432115, 0.386, 0.6451)],
        ];
        Ok(parts.map(|gaussians| {
            let total: f64 = gaussians.iter().map(|g| g.0).sum();
            gaussians
                .iter()
                .map(|&(weight, sigma, half_width)| {
                    let sigma = match self.kernels {
                        KernelWidth::ZhangWandell1997 => sigma,
                        KernelWidth::Isetcam => half_width / std::f64::consts::LN_2.sqrt(),
                    };
                    Gaussian::new(weight / total, sigma * per_degree, radius)
                })
                .collect()
        }))
    }
}

/// One separable part of a kernel: its weight and its samples from the centre outwards.
struct Gaussian {
    weight: f32,
    half: Vec<f32>,
}

impl Gaussian {
    fn new(weight: f64, sigma_samples: f64, radius: usize) -> Self {
        let value = |i: usize| (-(i as f64 / sigma_samples).powi(2)).exp();
        let sum = 1.0 + 2.0 * (1..=radius).map(value).sum::<f64>();
        let mut half: Vec<f32> = (0..=radius).map(|i| (value(i) / sum) as f32).collect();
        // Negligible samples would only cost time.
        while half.len() > 1 && half.last().is_some_and(|&v| v < 1e-9) {
            half.pop();
        }
        Self { weight: weight as f32, half }
    }
}

/// The planes after multiplication by a matrix.
fn transformed(m: &Matrix3, planes: [&[f32]; 3]) -> [Vec<f32>; 3] {
    [0, 1, 2].map(|row| {
        let w = m[row].map(|v| v as f32);
        let mut out = vec![0.0; planes[0].len()];
        out.par_chunks_mut(CHUNK).enumerate().for_each(|(k, out)| {
            let at = k * CHUNK;
            let [a, b, c] = planes.map(|p| &p[at..at + out.len()]);
            for (((o, a), b), c) in out.iter_mut().zip(a).zip(b).zip(c) {
                *o = w[0] * a + w[1] * b + w[2] * c;
            }
        });
        out
    })
}

/// Pixels per task.
const CHUNK: usize = 16_384;
/// Rows per task.
const ROWS: usize = 16;

/// The weighted sum of separable blurs of a plane.
fn blur(plane: &[f32], (rows, cols): (usize, usize), kernel: &[Gaussian], extension: Extension) -> Vec<f32> {
    let mut out = vec![0.0f32; plane.len()];
    if plane.is_empty() {
        return out;
    }
    let mut across = vec![0.0f32; plane.len()];
    for gaussian in kernel {
        let (half, radius) = (gaussian.half.as_slice(), gaussian.half.len() - 1);
        across.par_chunks_mut(cols * ROWS).zip(plane.par_chunks(cols * ROWS)).for_each(|(out, rows)| {
            let mut padded = vec![0.0; cols + 2 * radius];
            for (out, row) in out.chunks_exact_mut(cols).zip(rows.chunks_exact(cols)) {
                padded[radius..radius + cols].copy_from_slice(row);
                for i in 0..radius {
                    padded[i] = row[outside(i as isize - radius as isize, cols, extension)];
                    padded[radius + cols + i] = row[outside((cols + i) as isize, cols, extension)];
                }
                let lines: Vec<&[f32]> = padded.windows(cols).collect();
                dispatch(SymmetricSum { half, lines: &lines, out });
            }
        });
        out.par_chunks_mut(cols * ROWS).enumerate().for_each(|(block, out)| {
            let mut sum = vec![0.0; cols];
            for (r, out) in out.chunks_exact_mut(cols).enumerate() {
                let first = (block * ROWS + r) as isize - radius as isize;
                let source = |i: usize| {
                    let r = outside(first + i as isize, rows, extension);
                    &across[r * cols..(r + 1) * cols]
                };
                let lines: Vec<&[f32]> = (0..=2 * radius).map(source).collect();
                dispatch(SymmetricSum { half, lines: &lines, out: &mut sum });
                for (o, &s) in out.iter_mut().zip(&sum) {
                    *o += gaussian.weight * s;
                }
            }
        });
    }
    out
}

/// Values that are summed in registers at a time: four of 16.
const WIDE: usize = 4 * LANES;
const LANES: usize = 16;

/// The middle line times the first weight, plus the sums of the lines at equal distances from it times the other weights. All
/// lines are as long as `out`; there is one for each weight and its mirror image.
struct SymmetricSum<'a> {
    half: &'a [f32],
    lines: &'a [&'a [f32]],
    out: &'a mut [f32],
}

impl Kernel for SymmetricSum<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (len, middle) = (self.out.len(), self.half.len() - 1);
        if len < WIDE {
            for (i, out) in self.out.iter_mut().enumerate() {
                *out = self.half[0] * self.lines[middle][i];
                for (k, &w) in self.half.iter().enumerate().skip(1) {
                    *out += w * (self.lines[middle - k][i] + self.lines[middle + k][i]);
                }
            }
            return;
        }
        for at in (0..len).step_by(WIDE) {
            // The last values may be computed twice.
            let at = at.min(len - WIDE);
            let part = |line: usize| self.lines[line][at..at + WIDE].as_chunks::<LANES>().0;
            let centre = part(middle);
            // Four variables, since compilers keep the sums of an array in memory.
            let [mut a, mut b, mut c, mut d] = [0, 1, 2, 3].map(|r| centre[r].map(|v| self.half[0] * v));
            for (k, &w) in self.half.iter().enumerate().skip(1) {
                let (left, right) = (part(middle - k), part(middle + k));
                a = plus_pair(a, w, left[0], right[0]);
                b = plus_pair(b, w, left[1], right[1]);
                c = plus_pair(c, w, left[2], right[2]);
                d = plus_pair(d, w, left[3], right[3]);
            }
            self.out[at..at + WIDE].copy_from_slice([a, b, c, d].as_flattened());
        }
    }
}

#[inline(always)]
fn plus_pair(mut sums: [f32; LANES], weight: f32, left: [f32; LANES], right: [f32; LANES]) -> [f32; LANES] {
    for i in 0..LANES {
        sums[i] += weight * (left[i] + right[i]);
    }
    sums
}

/// The index inside 0..n that replaces one outside.
fn outside(i: isize, n: usize, extension: Extension) -> usize {
    match extension {
        Extension::Periodic => i.rem_euclid(n as isize) as usize,
        Extension::Mirror => about_border(i, n),
    }
}

#[cfg(test)]
mod tests;
