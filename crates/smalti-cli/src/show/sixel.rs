//! Pictures as sixels, the graphics of DEC's VT340 terminal.

use icy_sixel::{EncodeOptions, QuantizeMethod, SixelImage};

use super::picture::Pixels;

/// Pixels in the width of a character, as terminals are usually set; the sixel format has no unit of characters.
pub(super) const COLUMN_PX: usize = 8;

/// Encodes a picture with a palette of its own 256 colours. Without dithering, areas of one colour stay so.
pub(super) fn encode(picture: &Pixels) -> anyhow::Result<String> {
    let rgba = picture.rgb.iter().flat_map(|&[r, g, b]| [r, g, b, u8::MAX]).collect();
    let image = SixelImage::try_from_rgba(rgba, picture.width, picture.height)?;
    let quantize_method = QuantizeMethod::kmeans();
    let options = EncodeOptions { diffusion: 0.0, quantize_method, ..EncodeOptions::default() };
    Ok(image.encode_with(&options)? + "\n")
}
