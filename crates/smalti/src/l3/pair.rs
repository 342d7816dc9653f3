//! What pipelines learn from.

use crate::numeric::Planes;
use crate::sensor::RawImage;

/// A raw image and its target.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// The samples for training: noise-free where the noise is added analytically ([`Statistics::new`](super::Statistics::new)),
    /// otherwise as captured.
    pub raw: &'a RawImage,
    /// The image that classifies patches, of the same size: noisy, like the images to render later. `None`
    /// stands for `raw`.
    pub seen: Option<&'a RawImage>,
    /// One plane per output, of the size of the raw image, with finite values.
    pub target: &'a Planes,
}
