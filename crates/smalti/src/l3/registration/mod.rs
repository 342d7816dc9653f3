//! Registration of an image with the raw image of the same shot, to subpixel accuracy, so that the two form a
//! [`Pair`].
//!
//! Training for a real camera ([jiang2017]) needs raw image and target pixel by pixel, but the camera's own
//! image is cropped, sometimes scaled, and corrected for lens distortion. The method compares the luminances
//! of both. An exhaustive search at low resolution finds the approximate position. Phase correlation of
//! patches at full resolution refines it; a Fourier sum around the peak locates it to a hundredth of a pixel
//! ([guizarsicairos2008]). The median of the patches is the shift. The residual shifts of the quadrants
//! indicate distortion, which a shift cannot correct.
//!
//! [jiang2017]: https://doi.org/10.1109/TIP.2017.2713942
//! [guizarsicairos2008]: https://doi.org/10.1364/OL.33.000156

mod correlate;
mod error;
mod resample;

pub use error::{MIN_CORRELATION, RegistrationError};

use super::Pair;
use crate::isp::{Demosaic, IspError};
use crate::numeric::{Planes, first_invalid};
use crate::sensor::{RawError, RawImage, RawSamples, Sampling};
use correlate::{Plane, Shift};

/// Minimum side of an image, pixels.
pub const MIN_SIDE: usize = 32;
/// Below this correlation, raw image and target differ by more than tone curve and noise: other processing,
/// motion, or little structure.
pub const GOOD_CORRELATION: f64 = 0.9;
/// Resolution of the shift, pixels: on pairs with known shift and noise, errors reach 0.06.
pub const RESOLVED_SHIFT_PX: f64 = 0.1;
/// Residual shift of a quadrant above which a pair is doubtful, pixels.
pub const GOOD_RESIDUAL_PX: f64 = 0.25;

/// The position of an image on a raw image.
#[derive(Debug, Clone, PartialEq)]
pub struct Registration {
    /// Rows from the upper edge of the raw image to that of the image, in pixels of the raw image. Negative
    /// where the image extends beyond the raw image.
    pub row_shift_px: f64,
    /// Columns from the left edge of the raw image to that of the image.
    pub col_shift_px: f64,
    /// Pixels of the raw image per pixel of the image.
    pub scale: f64,
    /// Correlation of the aligned luminances after smoothing over 4 × 4 pixels, −1 to 1 (Pearson).
    pub correlation: f64,
    /// Residual shift in each quadrant of the common part (upper left, upper right, lower left, lower right):
    /// rows and columns in pixels of the raw image. `None` where a quadrant has too little structure or is
    /// too small.
    pub residuals_px: [Option<[f64; 2]>; 4],
}

/// The part of a raw image that its target covers, and the target on the grid of the raw image.
#[derive(Debug, Clone, PartialEq)]
pub struct Aligned {
    /// The raw image, cropped by whole tiles of its mosaic.
    pub raw: RawImage,
    /// The target, of the same size.
    pub target: Planes,
    /// First row of the remaining raw image.
    pub row: usize,
    /// First column of the remaining raw image.
    pub col: usize,
}

impl Aligned {
    /// The pair for training.
    #[must_use]
    pub fn pair(&self) -> Pair<'_> {
        Pair { raw: &self.raw, seen: None, target: &self.target }
    }
}

impl Registration {
    /// Registers an image with the raw image of the same shot. `luminance` is one plane in linear light; each
    /// of its pixels spans as many pixels of the raw image as the best of `scales`.
    ///
    /// # Errors
    /// When an image is too small, is uniform or contains NaN or infinity, the raw image cannot be interpolated,
    /// a scale is out of range, or no scale matches at any position.
    pub fn best(raw: &RawImage, luminance: &Planes, scales: &[f64]) -> Result<Self, RegistrationError> {
        ensure_finite(raw, luminance)?;
        let fixed = Plane::new(raw.rows(), raw.cols(), raw_luminance(raw)?)?;
        let moving = Plane::new(luminance.rows(), luminance.cols(), even_noise(luminance.data()))?;
        for (what, p) in [("the raw image", &fixed), ("the image", &moving)] {
            if p.rows.min(p.cols) < MIN_SIDE {
                return Err(RegistrationError::too_small(p.rows, p.cols, MIN_SIDE));
            }
            if p.is_uniform() {
                return Err(RegistrationError::Uniform(what));
            }
        }
        let correlation = |found: &Result<Self, RegistrationError>| match found {
            Ok(found) => found.correlation,
            Err(RegistrationError::NoMatch(correlation)) => *correlation,
            Err(_) => f64::NEG_INFINITY,
        };
        let mut best = Err(RegistrationError::NoScale);
        for &scale in scales {
            let found = at_scale(&fixed, &moving, scale);
            if let Err(error) = &found
                && !error.is_of_this_scale()
            {
                return found;
            }
            if best == Err(RegistrationError::NoScale) || correlation(&found) > correlation(&best) {
                best = found;
            }
        }
        best
    }

    /// Whether the image is aligned with the raw image within the resolution of the method.
    #[must_use]
    pub fn is_identity(&self) -> bool {
        self.scale == 1.0
            && self.row_shift_px.abs() < RESOLVED_SHIFT_PX
            && self.col_shift_px.abs() < RESOLVED_SHIFT_PX
    }

    /// The largest residual shift of the quadrants, pixels.
    #[must_use]
    pub fn largest_residual_px(&self) -> f64 {
        self.residuals_px.iter().flatten().map(|[r, c]| r.hypot(*c)).fold(0.0, f64::max)
    }

    /// The common part of both: `target`, the planes of the image, is resampled (Lanczos, three lobes) to the
    /// grid of the raw image. A target that is aligned already stays unchanged.
    ///
    /// # Errors
    /// When the common part is smaller than [`MIN_SIDE`] pixels, or the raw image samples every channel at
    /// every pixel and cannot be cropped.
    pub fn apply(&self, raw: &RawImage, target: &Planes) -> Result<Aligned, RegistrationError> {
        if self.is_identity() && (raw.rows(), raw.cols()) == (target.rows(), target.cols()) {
            return Ok(Aligned { raw: raw.clone(), target: target.clone(), row: 0, col: 0 });
        }
        let tile = match raw.sampling() {
            Sampling::Mosaic(m) => (m.rows(), m.cols()),
            Sampling::Full { .. } => (1, 1),
        };
        let rows = resample::Axis::new(self.row_shift_px, self.scale, target.rows());
        let cols = resample::Axis::new(self.col_shift_px, self.scale, target.cols());
        let (row, height) = rows.covered(raw.rows(), tile.0);
        let (col, width) = cols.covered(raw.cols(), tile.1);
        if height.min(width) < MIN_SIDE {
            return Err(RegistrationError::too_small(height, width, MIN_SIDE));
        }
        let planes: Vec<f32> = target
            .planes()
            .flat_map(|p| resample::plane(p, &rows, &cols, (row, height), (col, width)))
            .collect();
        let target = Planes::new(height, width, target.count(), planes)?;
        Ok(Aligned { raw: cropped(raw, (row, height), (col, width))?, target, row, col })
    }
}

/// A crop that begins with a whole tile, so that the mosaic is unchanged.
fn cropped(
    raw: &RawImage,
    (row, rows): (usize, usize),
    (col, cols): (usize, usize),
) -> Result<RawImage, RawError> {
    let places = move || {
        (0..raw.sampling().planes())
            .flat_map(move |p| (row..row + rows).map(move |r| (p * raw.rows() + r) * raw.cols() + col))
    };
    let samples = match raw.samples() {
        RawSamples::Digital(v) => {
            RawSamples::Digital(places().flat_map(|at| v.iter().skip(at).take(cols).copied()).collect())
        }
        RawSamples::Analog(v) => {
            RawSamples::Analog(places().flat_map(|at| v.iter().skip(at).take(cols).copied()).collect())
        }
    };
    let (sampling, names) = (raw.sampling().clone(), raw.channel_names().to_vec());
    RawImage::new(rows, cols, samples, sampling, names, raw.black_level(), raw.white_level())
}

/// Checks that raw image and luminance are finite, because the steps that follow would take NaN as darkness.
fn ensure_finite(raw: &RawImage, luminance: &Planes) -> Result<(), RegistrationError> {
    let analog: &[f32] = match raw.samples() {
        RawSamples::Analog(v) => v,
        RawSamples::Digital(_) => &[],
    };
    for (what, values, rows, cols) in [
        ("the raw image", analog, raw.rows(), raw.cols()),
        ("the luminance of the image", luminance.data(), luminance.rows(), luminance.cols()),
    ] {
        if let Some(at) = first_invalid(values, f32::is_finite) {
            let (row, col, value) = (at / cols % rows, at % cols, values[at]);
            return Err(RegistrationError::Value { what, row, col, value });
        }
    }
    Ok(())
}

/// Mean of the bilinearly interpolated channels. Other methods follow edges and could shift them.
fn raw_luminance(raw: &RawImage) -> Result<Vec<f32>, IspError> {
    let planes = Demosaic::Bilinear.apply(raw)?;
    let mut sum = vec![0f32; planes.plane_len()];
    for plane in planes.planes() {
        sum.iter_mut().zip(plane).for_each(|(s, v)| *s += v.clamp(0.0, 1.0));
    }
    Ok(even_noise(&sum))
}

/// The square root makes photon noise uniform and is close to a tone curve.
fn even_noise(values: &[f32]) -> Vec<f32> {
    values.iter().map(|v| v.max(0.0).sqrt()).collect()
}

fn at_scale(fixed: &Plane, moving: &Plane, scale: f64) -> Result<Registration, RegistrationError> {
    if !(0.25..=8.0).contains(&scale) {
        return Err(RegistrationError::Scale(scale));
    }
    let mut shift = correlate::coarse(fixed, moving, scale)?;
    // A shift of a patch relative to its window is slightly underestimated; the iteration finds the
    // remainder.
    for _ in 0..3 {
        let placed = placed(moving, shift, scale, fixed)?;
        let Some(step) = correlate::middle(&correlate::patches(fixed, &placed)?) else { break };
        shift = Shift { row: shift.row + step.row, col: shift.col + step.col };
    }
    let placed = placed(moving, shift, scale, fixed)?;
    let correlation = correlate::pearson(fixed, &placed)?;
    if correlation < MIN_CORRELATION {
        return Err(RegistrationError::NoMatch(correlation));
    }
    let last = correlate::patches(fixed, &placed)?;
    Ok(Registration {
        row_shift_px: shift.row,
        col_shift_px: shift.col,
        scale,
        correlation,
        residuals_px: correlate::quadrants(&placed, &last),
    })
}

/// The luminance of the image on the grid of the raw image, and the part that it covers.
fn placed(
    moving: &Plane,
    shift: Shift,
    scale: f64,
    fixed: &Plane,
) -> Result<correlate::Placed, RegistrationError> {
    let rows = resample::Axis::new(shift.row, scale, moving.rows);
    let cols = resample::Axis::new(shift.col, scale, moving.cols);
    let (row, col) = (rows.covered(fixed.rows, 1), cols.covered(fixed.cols, 1));
    if row.1 == 0 || col.1 == 0 {
        return Err(RegistrationError::NoOverlap);
    }
    let plane = Plane::new(row.1, col.1, resample::plane(&moving.values, &rows, &cols, row, col))?;
    Ok(correlate::Placed { plane, row: row.0, col: col.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::Mosaic;

    #[test]
    fn a_crop_keeps_rows_and_columns() {
        let mosaic = Sampling::Mosaic(Mosaic::new(1, 1, vec![0]).unwrap());
        let samples = RawSamples::Digital((0..24).collect());
        let raw = RawImage::new(4, 6, samples, mosaic, vec!["W".into()], 0.0, 99.0).unwrap();
        let part = cropped(&raw, (1, 2), (2, 3)).unwrap();
        assert_eq!(part.samples(), &RawSamples::Digital(vec![8, 9, 10, 14, 15, 16]));
    }
}
