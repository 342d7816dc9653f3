//! Processing from raw image to picture.
//!
//! The stages are black level, [demosaicking](Demosaic), [colour matrix](ColorFit) and [white balance](WhiteBalance);
//! [`Classic`] combines them. Simulated raw images and those of camera files are processed alike.

mod camera_from_xyz;
mod classic;
mod color_matrix;
pub mod demosaic;
mod error;
pub(crate) mod source;
pub(crate) mod tile_filter;
mod white_balance;

pub use camera_from_xyz::camera_from_xyz;
pub use classic::Classic;
pub(crate) use color_matrix::BLIND;
pub use color_matrix::{ColorConstraint, ColorFit, ColorMatrix};
pub use demosaic::Demosaic;
pub use error::IspError;
pub use white_balance::WhiteBalance;

use crate::color::Image;
use crate::sensor::RawImage;

/// A pipeline that renders raw images.
pub trait Isp: Send + Sync {
    /// The picture of a raw image.
    ///
    /// # Errors
    /// When the pipeline does not match the image.
    fn render(&self, raw: &RawImage) -> Result<Image, IspError>;
}

impl<T: Isp + ?Sized> Isp for &T {
    fn render(&self, raw: &RawImage) -> Result<Image, IspError> {
        (**self).render(raw)
    }
}
