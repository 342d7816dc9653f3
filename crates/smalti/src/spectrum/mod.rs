//! Spectra on a uniform wavelength grid, observers, illuminants, reflectances and spectral image cubes.
//!
//! Integrals over wavelength are plain sums times the step, as in ISETCam and in CIE 15's summation method.

mod components;
mod cube;
mod curve;
pub mod generated;
mod grid;
mod illuminant;
mod observer;
pub mod reflectance;
pub mod units;

pub use components::Components;
pub use cube::SpectralCube;
pub use curve::{Extrapolation, Spectrum};
pub use grid::{SpectrumError, WavelengthGrid};
pub use illuminant::Illuminant;
pub use observer::Observer;
