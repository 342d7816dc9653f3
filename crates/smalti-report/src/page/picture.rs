//! Pictures in a page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};

use super::markup::{Element, el};
use crate::FigureError;
use crate::figure::{Compression, encode as png};

/// A picture as a data URI.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DataUri(String);

impl DataUri {
    /// A JPEG of 8-bit sRGB, three bytes a pixel, row by row. `quality` is 1 to 100. Colour has the full resolution:
    /// false colour at edges is what such a picture is looked at for.
    ///
    /// # Errors
    /// [`FigureError::Picture`] when there are not three bytes for each pixel, or none; [`FigureError::Size`] beyond 65 535
    /// pixels a side.
    pub fn jpeg(width: usize, height: usize, rgb: &[u8], quality: u8) -> Result<Self, FigureError> {
        encode(width, height, rgb, 3, quality)
    }

    /// A JPEG of one byte a pixel, row by row: numbers that the script of a page reads, and colours as it shows them.
    ///
    /// # Errors
    /// As [`jpeg`](Self::jpeg), with one byte for each pixel.
    pub fn grey_jpeg(width: usize, height: usize, bytes: &[u8], quality: u8) -> Result<Self, FigureError> {
        encode(width, height, bytes, 1, quality)
    }

    /// A PNG of 8-bit sRGB, three bytes a pixel, row by row: every pixel as it is.
    ///
    /// # Errors
    /// As [`jpeg`](Self::jpeg).
    pub fn png(width: usize, height: usize, rgb: &[u8]) -> Result<Self, FigureError> {
        let (w, h) = checked("PNG", width, height, rgb, 3)?;
        let file = png(rgb, [w.into(), h.into()], png::ColorType::Rgb, Compression::Small)?;
        Ok(Self(format!("data:image/png;base64,{}", STANDARD.encode(file))))
    }

    /// The URI.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The picture in a page; `alternative` describes it.
    #[must_use]
    pub fn image(&self, width: usize, height: usize, alternative: &str) -> Element {
        el("img")
            .attr("src", &self.0)
            .attr("width", width.to_string())
            .attr("height", height.to_string())
            .attr("alt", alternative)
    }
}

fn encode(
    width: usize,
    height: usize,
    samples: &[u8],
    each: usize,
    quality: u8,
) -> Result<DataUri, FigureError> {
    let (w, h) = checked("JPEG", width, height, samples, each)?;
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, quality.clamp(1, 100));
    encoder.set_sampling_factor(SamplingFactor::F_1_1);
    encoder.set_optimized_huffman_tables(true);
    let color = if each == 1 { ColorType::Luma } else { ColorType::Rgb };
    encoder.encode(samples, w, h, color).map_err(|_| size("JPEG", width, height))?;
    Ok(DataUri(format!("data:image/jpeg;base64,{}", STANDARD.encode(bytes))))
}

/// Width and height of samples, `each` a pixel, that are as many as there should be.
fn checked(
    kind: &str,
    width: usize,
    height: usize,
    samples: &[u8],
    each: usize,
) -> Result<(u16, u16), FigureError> {
    let expected = width.saturating_mul(height).saturating_mul(each);
    if expected == 0 || samples.len() != expected {
        let (caption, got) = (kind.into(), samples.len());
        return Err(FigureError::Picture { caption, width, height, expected, got });
    }
    let side = |n: usize| u16::try_from(n).map_err(|_| size(kind, width, height));
    Ok((side(width)?, side(height)?))
}

fn size(kind: &str, width: usize, height: usize) -> FigureError {
    let reason = format!("a {kind} has at most 65535 pixels a side");
    FigureError::Size { width: width as f64, height: height as f64, reason }
}
