//! The two ICC profiles that pictures are written with: sRGB and Display P3.

use smalti::color::ColorSpace;

/// The profile (ICC.1:2022, version 4.4) of an encoded space; `None` for the others. The tests state how the files are made.
pub(crate) fn profile(space: ColorSpace) -> Option<&'static [u8]> {
    match space {
        ColorSpace::Srgb => Some(include_bytes!("../profiles/srgb.icc")),
        ColorSpace::DisplayP3 => Some(include_bytes!("../profiles/display-p3.icc")),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
