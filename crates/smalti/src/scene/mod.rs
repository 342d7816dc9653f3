//! Scenes: spectral radiance with an absolute luminance, a distance and a field of view.
//!
//! Charts and patterns are functions of their own parameters and a [`Setting`]: illuminant, mean luminance,
//! distance and field of view. Pixels contain the mean over their area. [`PatternSampling`] offers ISETCam's
//! point samples as an alternative, for comparisons.

pub mod catalog;
mod checkerboard;
mod color_patches;
mod compose;
mod dead_leaves;
mod error;
mod frequency_orientation;
mod frequency_sweep;
mod glints;
mod glossy_balls;
mod gradients;
mod grey_steps;
mod hdr;
pub mod macbeth;
mod point_grid;
mod quadrature;
mod radiance;
mod raster;
mod resolution_chart;
mod setting;
mod siemens_star;
mod slanted_bar;
mod uniform;
mod zone_plate;

pub use self::checkerboard::{Checkerboard, checkerboard};
pub use self::color_patches::{ColorPatches, color_patches};
pub use self::compose::MAX_VALUES;
pub use self::dead_leaves::{DeadLeaves, dead_leaves};
pub use self::error::SceneError;
pub use self::frequency_orientation::{FrequencyOrientation, frequency_orientation};
pub use self::frequency_sweep::{FrequencySweep, frequency_sweep};
pub use self::glints::Glints;
pub use self::glossy_balls::{GlossyBalls, glossy_balls};
pub use self::gradients::{Gradients, gradients};
pub use self::grey_steps::{GreySteps, grey_steps};
pub use self::hdr::hdr;
pub use self::point_grid::{PointGrid, point_grid};
pub use self::radiance::Scene;
pub use self::resolution_chart::{ResolutionChart, resolution_chart};
pub(crate) use self::setting::MAX_FOV_DEG;
pub use self::setting::Setting;
pub use self::siemens_star::{SiemensStar, siemens_star};
pub use self::slanted_bar::{SlantedBar, slanted_bar};
pub use self::uniform::uniform;
pub use self::zone_plate::{ZonePlate, zone_plate, zone_plate_isetcam};

/// Sampling of a pattern.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PatternSampling {
    /// Point samples, with ISETCam's rules for clipping and ties.
    Isetcam,
    /// The mean over the area of each pixel.
    Area,
}
