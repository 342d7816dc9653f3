//! Spectral upsampling: sRGB images to smooth reflectance spectra.
//!
//! W. Jakob and J. Hanika (2019), "A low-dimensional function space for efficient spectral upsampling",
//! *Computer Graphics Forum* 38(2). A reflectance is a sigmoid of a quadratic polynomial in wavelength. Least
//! squares in CIELAB under D65 yields its three coefficients. The reflectance lies between 0 and 1 at every
//! wavelength, so any illuminant can be applied to it.

use rayon::prelude::*;
use thiserror::Error;

use super::sigmoid::{Fit, minus, polynomial, position, sigmoid, square};
use super::{ColorSpace, Image, ImageError};
use crate::numeric::Planes;
use crate::spectrum::{Observer, SpectralCube, Spectrum, SpectrumError, WavelengthGrid};

/// Errors of spectral upsampling.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum UpliftError {
    /// The image is not suitable.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A channel of this colour is NaN.
    #[error("the linear sRGB colour {0:?} has a channel that is not a number")]
    Color([f64; 3]),
    /// The wavelength grid does not cover the observer's sensitivity, or a reflectance is not finite.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
}

/// Spectral upsampling of sRGB colours to reflectances on a wavelength grid.
#[derive(Debug, Clone)]
pub struct Uplift {
    grid: WavelengthGrid,
    fit: Fit,
    /// Coefficients over the index of the largest channel, its value, and the ratios of the next two channels
    /// to it. The last index varies fastest.
    table: Vec<[f64; 3]>,
}

/// Table nodes along each ratio, evenly spaced.
const RATIOS: usize = 24;
/// Table nodes along the value of the largest channel.
const VALUES: usize = 32;
/// The smallest value of the largest channel. No sigmoid is 0 or 1 at every wavelength; these limits cost
/// less than 0.1 ΔE.
const DARKEST: f64 = 1e-4;
const LIGHTEST: f64 = 0.9995;
/// Convergence tolerance for a single colour, ΔE*ab.
const TOLERANCE: f64 = 1e-5;
/// Convergence tolerance for a pixel, ΔE*ab: far below visibility, and met by table interpolation for most
/// pixels.
const IMAGE_TOLERANCE: f64 = 0.2;
/// Pixels per task.
const CHUNK: usize = 4096;

impl Uplift {
    /// Computes the table for an observer and a grid that covers the visible range; the white is D65.
    ///
    /// # Errors
    /// When the grid does not overlap the observer's sensitivity.
    pub fn new(grid: WavelengthGrid, observer: Observer) -> Result<Self, UpliftError> {
        let mut uplift = Self { grid, fit: Fit::new(grid, observer)?, table: Vec::new() };
        uplift.table = uplift.tabulate();
        Ok(uplift)
    }

    /// The reflectance, 0 to 1, of a linear sRGB colour: ½ + x / (2 √(1 + x²)) with x = a p² + b p + c and
    /// p = (λ − 550 nm) / 150 nm. Channels are clipped to 0–1.
    ///
    /// # Errors
    /// When a channel is NaN.
    pub fn reflectance(&self, rgb: [f64; 3]) -> Result<Spectrum, UpliftError> {
        if rgb.iter().any(|v| v.is_nan()) {
            return Err(UpliftError::Color(rgb));
        }
        let cell = Cell::of(rgb);
        let start = cell.interpolate(&self.table);
        let coefficients = self.fit.solved(self.fit.target(&cell.rgb), start, TOLERANCE);
        Ok(Spectrum::from_fn(self.grid, |nm| sigmoid(polynomial(coefficients, position(nm))))?)
    }

    /// The reflectances of an image in [`ColorSpace::LinearSrgb`]. Under D65 they reproduce the colours of
    /// the image relative to white. Negative channels count as 0. A pixel whose largest channel exceeds 1 is
    /// divided by that channel before the fit and multiplied by it afterwards; its "reflectance" exceeds 1,
    /// like that of a lamp.
    ///
    /// # Errors
    /// When the image is in another colour space, or contains a value that is not finite.
    pub fn uplift_image(&self, image: &Image) -> Result<SpectralCube, UpliftError> {
        image.check_space(ColorSpace::LinearSrgb)?;
        image.check_finite()?;
        let n = image.planes().plane_len();
        let source = image.channels();
        // a, b, c and the scale of each pixel, chunk by chunk.
        let fitted: Vec<[Vec<f32>; 4]> = (0..n.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let pixels = chunk * CHUNK..n.min((chunk + 1) * CHUNK);
                let mut out = [(); 4].map(|()| Vec::with_capacity(CHUNK));
                for at in pixels {
                    let rgb = source.map(|p| f64::from(p[at]));
                    let scale = rgb.iter().copied().fold(1.0, f64::max);
                    let cell = Cell::of(rgb.map(|v| v / scale));
                    let target = self.fit.target(&cell.rgb);
                    let start = cell.interpolate(&self.table);
                    let near = square(minus(self.fit.lab(start), target)) < IMAGE_TOLERANCE * IMAGE_TOLERANCE;
                    let [a, b, c] =
                        if near { start } else { self.fit.solved(target, start, IMAGE_TOLERANCE) };
                    for (o, v) in out.iter_mut().zip([a, b, c, scale]) {
                        o.push(v as f32);
                    }
                }
                out
            })
            .collect();
        let mut planes = Planes::zeros(image.rows(), image.cols(), self.grid.len());
        if n > 0 {
            let wavelengths: Vec<f64> = self.grid.wavelengths_nm().collect();
            planes.data_mut().par_chunks_mut(n).zip(&wavelengths).for_each(|(plane, &nm)| {
                let p = position(nm) as f32;
                plane.par_chunks_mut(CHUNK).zip(&fitted).for_each(|(out, [a, b, c, scale])| {
                    for ((((o, a), b), c), scale) in out.iter_mut().zip(a).zip(b).zip(c).zip(scale) {
                        let x = (a * p + b) * p + c;
                        *o = scale * (0.5 + 0.5 * x / (1.0 + x * x).sqrt());
                    }
                });
            });
        }
        Ok(SpectralCube::new(self.grid, planes)?)
    }

    fn tabulate(&self) -> Vec<[f64; 3]> {
        let lines: Vec<Vec<[f64; 3]>> = (0..3 * RATIOS * RATIOS)
            .into_par_iter()
            .map(|line| {
                let (channel, second, third) =
                    (line / (RATIOS * RATIOS), line / RATIOS % RATIOS, line % RATIOS);
                let ratio = |i: usize| i as f64 / (RATIOS - 1) as f64;
                let solve = |value: usize, start| {
                    let v = value_of_node(value);
                    let mut rgb = [v, v * ratio(second), v * ratio(third)];
                    rgb.rotate_right(channel);
                    self.fit.solved(self.fit.target(&rgb), start, TOLERANCE)
                };
                // Start at middle grey and continue from node to neighbouring node: a fixed start is too far
                // from the extremes.
                let middle = VALUES / 2;
                let mut column = vec![[0.0; 3]; VALUES];
                column[middle] = solve(middle, [0.0; 3]);
                for v in (0..middle).rev() {
                    column[v] = solve(v, column[v + 1]);
                }
                for v in middle + 1..VALUES {
                    column[v] = solve(v, column[v - 1]);
                }
                column
            })
            .collect();
        let mut table = vec![[0.0; 3]; 3 * VALUES * RATIOS * RATIOS];
        for (line, column) in lines.iter().enumerate() {
            let (channel, ratios) = (line / (RATIOS * RATIOS), line % (RATIOS * RATIOS));
            for (v, c) in column.iter().enumerate() {
                table[(channel * VALUES + v) * RATIOS * RATIOS + ratios] = *c;
            }
        }
        table
    }
}

/// Value of the largest channel at a node. Nodes are dense near black and white, where the coefficients
/// diverge.
fn value_of_node(node: usize) -> f64 {
    let t = node as f64 / (VALUES - 1) as f64;
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    DARKEST + (LIGHTEST - DARKEST) * smooth(smooth(t))
}

/// Position of a colour in the table.
struct Cell {
    /// The colour, clipped to the limits of the table.
    rgb: [f64; 3],
    /// Index of the corner nearest to black.
    corner: usize,
    /// Fractions along the value and along the second and third channel.
    fraction: [f64; 3],
}

impl Cell {
    fn of(rgb: [f64; 3]) -> Self {
        // NaN compares false and becomes 0.
        let rgb = rgb.map(|v| if v > 0.0 { v.min(1.0) } else { 0.0 });
        let channel = if rgb[0] >= rgb[1] && rgb[0] >= rgb[2] {
            0
        } else if rgb[1] >= rgb[2] {
            1
        } else {
            2
        };
        let largest = rgb[channel];
        let value = largest.clamp(DARKEST, LIGHTEST);
        // Black has no ratios; it counts as grey.
        let ratio = |i: usize| if largest > 0.0 { rgb[(channel + i) % 3] / largest } else { 1.0 };
        let split = |r: f64| {
            let x = r * (RATIOS - 1) as f64;
            let i = (x as usize).min(RATIOS - 2);
            (i, x - i as f64)
        };
        let (second, third) = (ratio(1), ratio(2));
        let ((i, fi), (j, fj)) = (split(second), split(third));
        let (mut low, mut high) = (0, VALUES - 1);
        while high - low > 1 {
            let middle = (low + high) / 2;
            if value_of_node(middle) <= value {
                low = middle;
            } else {
                high = middle;
            }
        }
        let (a, b) = (value_of_node(low), value_of_node(high));
        let mut limited = [value, value * second, value * third];
        limited.rotate_right(channel);
        Self {
            rgb: limited,
            corner: ((channel * VALUES + low) * RATIOS + i) * RATIOS + j,
            fraction: [(value - a) / (b - a), fi, fj],
        }
    }

    fn interpolate(&self, table: &[[f64; 3]]) -> [f64; 3] {
        let [fv, fi, fj] = self.fraction;
        let mut sum = [0.0; 3];
        for (value, wv) in [(0, 1.0 - fv), (RATIOS * RATIOS, fv)] {
            for (second, wi) in [(0, 1.0 - fi), (RATIOS, fi)] {
                for (third, wj) in [(0, 1.0 - fj), (1, fj)] {
                    let node = table[self.corner + value + second + third];
                    let w = wv * wi * wj;
                    sum = [sum[0] + w * node[0], sum[1] + w * node[1], sum[2] + w * node[2]];
                }
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests;
