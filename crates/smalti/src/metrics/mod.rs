//! What a picture is worth, in numbers: plain functions on images. They know nothing of cameras, so they score
//! a photograph as well as a simulation.
//!
//! | question | module |
//! |---|---|
//! | are the colours right? | [`color_accuracy`], [`visual_snr`] |
//! | how fine is the detail? | [`esfr`] |
//! | what was added that is not there? | [`aliasing`] |
//! | how noisy is it? | [`luminance_noise`], [`snr`], [`visual_snr`] |
//! | how far from a reference? | [`psnr`] |
//! | what is the sensor itself? | [`photon_transfer`], [`dynamic_range`] |
//!
//! Sums run in one fixed order, so a result has the same bits whatever the number of threads.

pub mod aliasing;
mod catalog;
pub mod color_accuracy;
pub mod dynamic_range;
mod error;
pub mod esfr;
pub mod luminance_noise;
mod patch;
pub mod photon_transfer;
pub mod psnr;
pub mod snr;
pub mod visual_snr;

pub use catalog::{Better, CATALOG, MetricInfo};
pub use error::MetricError;
pub use patch::patch_means;

pub use crate::numeric::Rect;
