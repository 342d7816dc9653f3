//! The image sensor: colour filter array, pixel, exposure, noise, analog-to-digital conversion.
//!
//! [`Cfa`] and [`RawImage`] know nothing of the simulator: the raw file of a real camera is the same type.

pub mod cfa;
mod quantum_efficiency;
mod raw;

pub use cfa::{Cfa, CfaError, Channel, Filter, Mosaic};
pub use quantum_efficiency::{QuantumEfficiency, silicon_absorption_per_m};
pub use raw::{RawError, RawImage, RawSamples, Sampling};
