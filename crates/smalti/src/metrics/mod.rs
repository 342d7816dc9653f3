//! Image quality metrics: plain functions on images. They do not depend on the simulator, so that photographs can be scored as
//! well.
//!
//! | quantity | module |
//! |---|---|
//! | colour accuracy | [`color_accuracy`], [`visual_snr`] |
//! | resolution | [`esfr`] |
//! | aliasing | [`aliasing`] |
//! | noise | [`luminance_noise`], [`snr`], [`visual_snr`] |
//! | difference from a reference | [`psnr`] |
//! | sensor characteristics | [`photon_transfer`], [`dynamic_range`] |
//! | colorimetry of the spectral sensitivities of a sensor | [`vora1993`], [`iso17321`], [`logvinenko2014`] |
//!
//! Sums are evaluated in a fixed order, so that results have the same bits for any number of threads.

pub mod aliasing;
mod catalog;
mod channels;
pub mod color_accuracy;
pub mod dynamic_range;
mod error;
pub mod esfr;
pub mod iso17321;
pub mod logvinenko2014;
pub mod luminance_noise;
mod patch;
pub mod photon_transfer;
pub mod psnr;
mod relevance;
pub mod snr;
pub mod visual_snr;
pub mod vora1993;

pub use catalog::{Better, CATALOG, MetricInfo, metric_info};
pub use error::MetricError;
pub use patch::patch_means;
pub use relevance::{Relevance, smallest_relevant};

pub use crate::numeric::Rect;
