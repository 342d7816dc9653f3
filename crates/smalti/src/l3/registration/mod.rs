//! A picture laid onto the raw image of the same shot, to a fraction of a pixel, so that the two make a [`Pair`].
//!
//! Learning from a real camera ([jiang2017]) needs raw and picture pixel by pixel, but a camera's own picture is cropped,
//! sometimes scaled, and its lens corrected. Here the luminance of both is compared: once at low resolution over all
//! places the picture may have, then in patches at full resolution by the phase of their cross-power spectrum, whose
//! peak is found to a hundredth of a pixel by a Fourier sum around it ([guizarsicairos2008]). The median of the patches is
//! the shift; what each quadrant is off by tells of distortion, which a shift cannot undo.
//!
//! [jiang2017]: https://doi.org/10.1109/TIP.2017.2713942
//! [guizarsicairos2008]: https://doi.org/10.1364/OL.33.000156

mod correlate;
mod resample;

use thiserror::Error;

use super::Pair;
use crate::isp::{Demosaic, IspError};
use crate::numeric::{Planes, ShapeError};
use crate::sensor::{RawError, RawImage, RawSamples, Sampling};
use correlate::{Plane, Shift};

/// Why a picture cannot be laid onto a raw image.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RegistrationError {
    /// The raw image cannot be interpolated.
    #[error(transparent)]
    Isp(#[from] IspError),
    /// An image has not the size that it should.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The part that is left makes no raw image.
    #[error(transparent)]
    Raw(#[from] RawError),
    /// One of the images is too small to be compared.
    #[error("{rows} × {cols} pixels are too few to align by; at least {least} × {least} are needed")]
    TooSmall {
        /// Rows.
        rows: usize,
        /// Columns.
        cols: usize,
        /// Pixels needed along each side.
        least: usize,
    },
    /// The scale is not one that can be.
    #[error("a pixel of the picture is {value} pixels of the raw image; expected 0.25 to 8")]
    Scale {
        /// Pixels of the raw image per pixel of the picture.
        value: f64,
    },
    /// Nothing in the picture is where the raw image has it.
    #[error(
        "the picture does not match the raw image: their correlation is {correlation:.2}, expected at least {least}"
    )]
    NoMatch {
        /// The best correlation found.
        correlation: f64,
        /// The least that is taken for a match.
        least: f64,
    },
}

/// Sides below this hold too little to be compared.
pub const LEAST_SIDE: usize = 32;
/// A picture that is correlated less with the raw image is not of the same shot.
pub const LEAST_CORRELATION: f64 = 0.5;
/// Below this the raw and picture differ by more than tones and noise: other processing, movement, or little structure.
pub const GOOD_CORRELATION: f64 = 0.9;
/// Shifts smaller than this cannot be told from none, pixels: errors on pairs of known shift, with noise, reach 0.06.
pub const RESOLVED_SHIFT_PX: f64 = 0.1;
/// Residual shift in a quadrant that makes a pair doubtful, pixels.
pub const GOOD_RESIDUAL_PX: f64 = 0.25;

/// Where a picture lies on a raw image.
#[derive(Debug, Clone, PartialEq)]
pub struct Registration {
    /// Rows from the upper edge of the raw image to that of the picture, in pixels of the raw image; negative where
    /// the picture reaches beyond.
    pub row_shift_px: f64,
    /// Columns likewise, from the left edges.
    pub col_shift_px: f64,
    /// Pixels of the raw image per pixel of the picture.
    pub scale: f64,
    /// Correlation of the aligned luminances after smoothing over 4 × 4 pixels, −1 to 1 (Pearson).
    pub correlation: f64,
    /// What is left of the shift in each quadrant of the common part (upper left, upper right, lower left, lower right), rows
    /// and columns in pixels of the raw image; `None` where a quadrant has too little structure or is too small.
    pub residuals_px: [Option<[f64; 2]>; 4],
}

/// The part of a raw image that its picture covers, and the picture on its grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Aligned {
    /// The raw image, cropped by whole tiles of its mosaic.
    pub raw: RawImage,
    /// The picture, of the same size.
    pub target: Planes,
    /// First row of the raw image that is left.
    pub row: usize,
    /// First column.
    pub col: usize,
}

impl Aligned {
    /// What to learn from.
    #[must_use]
    pub fn pair(&self) -> Pair<'_> {
        Pair { raw: &self.raw, seen: None, target: &self.target }
    }
}

impl Registration {
    /// Finds where a picture lies on the raw image of the same shot. `luminance` is one plane, linear in light; each of its
    /// pixels is `scale` pixels of the raw image, known from their sizes or found by trying ([`Registration::best`]).
    ///
    /// # Errors
    /// When one of the two is too small, the scale is out of range, the raw image cannot be interpolated, or no place
    /// matches.
    pub fn find(raw: &RawImage, luminance: &Planes, scale: f64) -> Result<Self, RegistrationError> {
        Self::best(raw, luminance, &[scale])
    }

    /// As [`Registration::find`], with the scale of `scales` that matches best.
    ///
    /// # Errors
    /// As [`Registration::find`], where none of the scales succeeds.
    pub fn best(raw: &RawImage, luminance: &Planes, scales: &[f64]) -> Result<Self, RegistrationError> {
        let fixed = Plane::new(raw.rows(), raw.cols(), raw_luminance(raw)?);
        let moving = Plane::new(luminance.rows(), luminance.cols(), even_noise(luminance.plane(0)));
        for p in [&fixed, &moving] {
            if p.rows.min(p.cols) < LEAST_SIDE {
                return Err(RegistrationError::TooSmall { rows: p.rows, cols: p.cols, least: LEAST_SIDE });
            }
        }
        let mut best: Result<Self, RegistrationError> =
            Err(RegistrationError::NoMatch { correlation: 0.0, least: LEAST_CORRELATION });
        for &scale in scales {
            let found = at_scale(&fixed, &moving, scale);
            let better = match (&found, &best) {
                (Ok(a), Ok(b)) => a.correlation > b.correlation,
                (found, best) => found.is_ok() || best.is_err(),
            };
            if better {
                best = found;
            }
        }
        best
    }

    /// Whether the picture lies on the raw image already, as nearly as can be told.
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

    /// The common part of both: `target`, the planes of the picture, on the grid of the raw image (Lanczos, three
    /// lobes). A picture that lies on it already stays as it is.
    ///
    /// # Errors
    /// When less than [`LEAST_SIDE`] pixels are common, or the raw image samples every channel at every pixel and
    /// cannot be cropped.
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
        if height.min(width) < LEAST_SIDE {
            return Err(RegistrationError::TooSmall { rows: height, cols: width, least: LEAST_SIDE });
        }
        let planes: Vec<f32> = target
            .planes()
            .flat_map(|p| resample::plane(p, &rows, &cols, (row, height), (col, width)))
            .collect();
        let target = Planes::new(height, width, target.count(), planes)?;
        Ok(Aligned { raw: cropped(raw, (row, height), (col, width))?, target, row, col })
    }
}

/// A part that begins with a whole tile, so that the mosaic stays.
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

/// Mean of the channels, interpolated. All methods but the bilinear one follow edges and could move them.
fn raw_luminance(raw: &RawImage) -> Result<Vec<f32>, IspError> {
    let planes = Demosaic::Bilinear.apply(raw)?;
    let mut sum = vec![0f32; planes.plane_len()];
    for plane in planes.planes() {
        sum.iter_mut().zip(plane).for_each(|(s, v)| *s += v.clamp(0.0, 1.0));
    }
    Ok(even_noise(&sum))
}

/// The square root: noise of photons becomes even, and most of a tone curve linear.
fn even_noise(values: &[f32]) -> Vec<f32> {
    values.iter().map(|v| v.max(0.0).sqrt()).collect()
}

fn at_scale(fixed: &Plane, moving: &Plane, scale: f64) -> Result<Registration, RegistrationError> {
    if !(0.25..=8.0).contains(&scale) {
        return Err(RegistrationError::Scale { value: scale });
    }
    let mut shift = correlate::coarse(fixed, moving, scale);
    // A patch that is shifted against its window is seen as shifted a little less: what is left is found again.
    for _ in 0..3 {
        let placed = placed(moving, shift, scale, fixed);
        let Some(step) = correlate::middle(&correlate::patches(fixed, &placed)) else { break };
        shift = Shift { row: shift.row + step.row, col: shift.col + step.col };
    }
    let placed = placed(moving, shift, scale, fixed);
    let correlation = correlate::pearson(fixed, &placed);
    if correlation < LEAST_CORRELATION {
        return Err(RegistrationError::NoMatch { correlation, least: LEAST_CORRELATION });
    }
    let last = correlate::patches(fixed, &placed);
    Ok(Registration {
        row_shift_px: shift.row,
        col_shift_px: shift.col,
        scale,
        correlation,
        residuals_px: correlate::quadrants(&placed, &last),
    })
}

/// The picture's luminance on the grid of the raw image, and the part that it covers.
fn placed(moving: &Plane, shift: Shift, scale: f64, fixed: &Plane) -> correlate::Placed {
    let rows = resample::Axis::new(shift.row, scale, moving.rows);
    let cols = resample::Axis::new(shift.col, scale, moving.cols);
    let (row, col) = (rows.covered(fixed.rows, 1), cols.covered(fixed.cols, 1));
    let plane = Plane::new(row.1, col.1, resample::plane(&moving.values, &rows, &cols, row, col));
    correlate::Placed { plane, row: row.0, col: col.0 }
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
