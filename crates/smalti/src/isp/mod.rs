//! Processing: from raw samples to a picture.

pub mod demosaic;
mod error;

pub use demosaic::Demosaic;
pub use error::IspError;
