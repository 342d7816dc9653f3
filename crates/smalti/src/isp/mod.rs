//! Processing: from raw samples to a picture.
//!
//! Black level, [demosaicking](Demosaic), [colour matrix](color_matrix()), [white balance](WhiteBalance); [`Classic`]
//! joins them. Nothing here knows where the raw image comes from: a simulated one and one from a camera's file are
//! treated alike.

mod classic;
mod color_matrix;
pub mod demosaic;
mod error;
pub(crate) mod source;
pub(crate) mod tile_filter;
mod white_balance;

pub use classic::Classic;
pub use color_matrix::{ColorConstraint, ColorFit, ColorMatrix, color_matrix};
pub use demosaic::Demosaic;
pub use error::IspError;
pub use white_balance::WhiteBalance;

use crate::color::Image;
use crate::sensor::RawImage;

/// A pipeline that makes a picture of a raw image.
pub trait Isp: Send + Sync {
    /// The picture.
    ///
    /// # Errors
    /// When the pipeline is not made for such an image.
    fn render(&self, raw: &RawImage) -> Result<Image, IspError>;
}

impl<T: Isp + ?Sized> Isp for &T {
    fn render(&self, raw: &RawImage) -> Result<Image, IspError> {
        (**self).render(raw)
    }
}
