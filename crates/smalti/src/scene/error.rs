//! Errors of scenes and of their specifications.

use thiserror::Error;

use crate::names::did_you_mean;
use crate::numeric::OutOfRange;
use crate::spectrum::SpectrumError;

/// Errors of a scene.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A parameter is out of its range.
    #[error(transparent)]
    Parameter(#[from] OutOfRange),
    /// The spectral image would be larger than [`MAX_VALUES`](super::MAX_VALUES).
    #[error(
        "a scene of {rows} × {cols} pixels at {bands} wavelengths is too large; expected at most {limit} values"
    )]
    TooLarge {
        /// Requested rows.
        rows: usize,
        /// Requested columns.
        cols: usize,
        /// Wavelengths of the grid.
        bands: usize,
        /// Maximum number of values of a scene.
        limit: usize,
    },
    /// The scene has no luminance, so it cannot be scaled to a given luminance.
    #[error(
        "the scene has no luminance on the grid {start_nm}–{end_nm} nm, so it cannot be scaled to a chosen one; expected light between 360 and 830 nm"
    )]
    Dark {
        /// First wavelength of the scene.
        start_nm: f64,
        /// Last wavelength of the scene.
        end_nm: f64,
    },
    /// The illuminant of a scene cannot be replaced: it has (almost) no power where the new one has some.
    #[error(
        "the scene's light has {fraction:.1e} of its maximum at {wavelength_nm} nm, so what the scene reflects there is unknown; expected a light with power wherever the new one has some"
    )]
    NoLightToDivideBy {
        /// The wavelength.
        wavelength_nm: f64,
        /// Power of the old illuminant there, relative to its maximum.
        fraction: f64,
    },
    /// The number of reflectances does not suit the pattern.
    #[error("got {got} reflectances; expected {expected}")]
    Reflectances {
        /// Number given.
        got: usize,
        /// Number needed, in words.
        expected: &'static str,
    },
    /// No built-in scene has this name.
    #[error("there is no scene named '{name}'{}; known scenes: {known}", did_you_mean(*suggestion))]
    UnknownScene {
        /// The name.
        name: String,
        /// The closest built-in name, if there is one.
        suggestion: Option<&'static str>,
        /// All names, separated by commas.
        known: String,
    },
    /// The scene has no parameter of this name.
    #[error(
        "the scene '{scene}' has no parameter '{name}'{}; its parameters: {known}",
        did_you_mean(*suggestion)
    )]
    UnknownParameter {
        /// The scene.
        scene: &'static str,
        /// The name.
        name: String,
        /// The closest parameter name, if there is one.
        suggestion: Option<&'static str>,
        /// All parameters of the scene, separated by commas.
        known: String,
    },
    /// The value of a parameter cannot be parsed or is out of range.
    #[error("{name}={value} for the scene '{scene}'; expected {expected}")]
    BadValue {
        /// The scene.
        scene: &'static str,
        /// The parameter.
        name: &'static str,
        /// The text given.
        value: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A part of the specification is not `name=value`, or a parameter is given twice.
    #[error("'{piece}' in the parameters of the scene '{scene}'; expected {expected}")]
    Syntax {
        /// The scene.
        scene: &'static str,
        /// The part.
        piece: String,
        /// What was expected.
        expected: &'static str,
    },
    /// Spectral data are invalid.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
}
