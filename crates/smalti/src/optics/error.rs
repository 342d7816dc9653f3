//! Errors of image formation, from the scene to the sensor plane.

use thiserror::Error;

use crate::numeric::fft::FftError;
use crate::numeric::{OutOfRange, ShapeError};
use crate::spectrum::SpectrumError;

/// Errors of the optics, or of a scene that they cannot image.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum OpticsError {
    /// A parameter is out of its range.
    #[error(transparent)]
    Parameter(#[from] OutOfRange),
    /// The scene is within the focal length, so there is no real image.
    #[error(
        "the scene is {distance_m} m from the lens; expected more than the focal length of {focal_length_m} m"
    )]
    SceneTooNear {
        /// Distance of the scene.
        distance_m: f64,
        /// Focal length.
        focal_length_m: f64,
    },
    /// No Zernike mode has this number.
    #[error("there is no Zernike mode {number}; expected {expected}")]
    ZernikeNumber {
        /// The requested number.
        number: usize,
        /// The available numbers.
        expected: &'static str,
    },
    /// The wavefront is too steep for a sampled pupil; such a blur is geometrical, not wave-optical.
    #[error(
        "the wavefront error changes by {waves_per_radius:.1} waves per pupil radius; expected at most {limit}, which can be sampled"
    )]
    WavefrontTooSteep {
        /// Largest slope.
        waves_per_radius: f64,
        /// Largest slope that can be sampled.
        limit: f64,
    },
    /// The blur is far wider than the image.
    #[error(
        "the radius of the blur is {radius_m:.3e} m, and the image is {image_m:.3e} m wide; expected a radius of at most four times the width"
    )]
    BlurTooWide {
        /// Radius of the blur on the sensor.
        radius_m: f64,
        /// Longer side of the image.
        image_m: f64,
    },
    /// A point spread function cannot be used.
    #[error("point spread function {index} (counted from 0): {problem}")]
    Psf {
        /// Index in the stack, from 0.
        index: usize,
        /// The problem and the expected value.
        problem: &'static str,
    },
    /// The number of point spread functions differs from the number of wavelengths.
    #[error("{wavelengths} wavelengths for {planes} point spread functions; expected one for each")]
    PsfCount {
        /// Wavelengths given.
        wavelengths: usize,
        /// Point spread functions given.
        planes: usize,
    },
    /// The point spread functions do not cover a wavelength of the scene.
    #[error("the point spread functions cover {have_start_nm}–{have_end_nm} nm, but {need_nm} nm is needed")]
    PsfCoverage {
        /// First wavelength of the stack.
        have_start_nm: f64,
        /// Last wavelength of the stack.
        have_end_nm: f64,
        /// The wavelength that is not covered.
        need_nm: f64,
    },
    /// Spectral data are invalid.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// The image cannot be transformed.
    #[error(transparent)]
    Fft(#[from] FftError),
    /// The shape of the planes is invalid.
    #[error(transparent)]
    Shape(#[from] ShapeError),
}
