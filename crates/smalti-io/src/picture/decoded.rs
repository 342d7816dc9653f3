//! The picture that decoders return, and the checks that they share.

use std::path::Path;

use smalti::color::{ColorSpace, Image};
use smalti::numeric::Planes;

use crate::error::At;
use crate::{IoError, Orientation};

/// A picture and what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// The picture; integers are scaled so that the largest is 1.
    ///
    /// | in the file | space |
    /// |---|---|
    /// | integers (PNG, TIFF, JPEG) | [`ColorSpace::Srgb`] |
    /// | PNG with `cICP` or profile of Display P3 as written here | [`ColorSpace::DisplayP3`] |
    /// | PNG with `gAMA` other than 1/2.2 and no `sRGB` | [`ColorSpace::LinearSrgb`], the gamma undone |
    /// | floating point (TIFF, OpenEXR) | [`ColorSpace::LinearSrgb`] |
    pub image: Image,
    /// Bits per sample in the file.
    pub bits: u8,
    /// How it is to be turned for viewing (TIFF, and Exif in JPEG). The image is as stored.
    pub orientation: Orientation,
    /// What is ignored: alpha channels, profiles of other spaces.
    pub notes: Vec<String>,
}

/// Three planes from interleaved samples of 1 (grey), 2 (grey, alpha), 3 or 4 (alpha) channels.
pub(super) fn from_interleaved(
    path: &Path,
    (rows, cols, channels): (usize, usize, usize),
    samples: &[f32],
    space: ColorSpace,
) -> Result<Image, IoError> {
    let pixels = rows * cols;
    if channels == 0 || samples.len() != pixels.saturating_mul(channels) {
        let (need, have) = (pixels.saturating_mul(channels) as u64, samples.len() as u64);
        return Err(IoError::truncated(path, "the picture", need, have));
    }
    let mut data = Vec::with_capacity(3 * pixels);
    for c in 0..3 {
        let c = if channels < 3 { 0 } else { c };
        data.extend(samples.iter().skip(c).step_by(channels));
    }
    let planes = Planes::new(rows, cols, 3, data).at(path)?;
    Image::new(space, planes).at(path)
}

pub(super) fn alpha_note(notes: &mut Vec<String>, alpha: bool) {
    if alpha {
        notes.push("the alpha channel is ignored".to_owned());
    }
}

pub(super) const PROFILE_NOTE: &str = "the embedded colour profile is ignored: the picture is taken as sRGB";
