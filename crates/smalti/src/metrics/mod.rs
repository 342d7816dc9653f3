//! What a picture is worth, in numbers: plain functions on images. They know nothing of cameras, so they score
//! a photograph as well as a simulation.
//!
//! | question | module |
//! |---|---|
//! | are the colours right? | [`color_accuracy`], [`visual`] |
//! | how fine is the detail? | [`esfr`] |
//! | what was added that is not there? | [`aliasing`] |
//! | how noisy is it? | [`luminance_noise`], [`snr`], [`visual`] |
//! | how far from a reference? | [`psnr`] |
//! | what is the sensor itself? | [`photon_transfer`], [`dynamic_range`] |
//!
//! Sums run in one fixed order, so a result has the same bits whatever the number of threads.

mod error;
pub mod esfr;
mod patch;

pub use error::MetricError;
pub use patch::{Rect, patch_means};
