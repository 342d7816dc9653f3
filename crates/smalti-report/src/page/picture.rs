//! Pictures in a page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};

use super::markup::{Element, el};
use crate::FigureError;

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
        let expected = width.saturating_mul(height).saturating_mul(3);
        if expected == 0 || rgb.len() != expected {
            return Err(FigureError::Picture {
                caption: "JPEG".into(),
                width,
                height,
                expected,
                got: rgb.len(),
            });
        }
        let size = || FigureError::Size {
            width: width as f64,
            height: height as f64,
            reason: "a JPEG has at most 65535 pixels a side".into(),
        };
        let (w, h) = (u16::try_from(width).map_err(|_| size())?, u16::try_from(height).map_err(|_| size())?);
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, quality.clamp(1, 100));
        encoder.set_sampling_factor(SamplingFactor::F_1_1);
        encoder.set_optimized_huffman_tables(true);
        encoder.encode(rgb, w, h, ColorType::Rgb).map_err(|_| size())?;
        Ok(Self(format!("data:image/jpeg;base64,{}", STANDARD.encode(bytes))))
    }

    /// A PNG file.
    #[must_use]
    pub fn png(file: &[u8]) -> Self {
        Self(format!("data:image/png;base64,{}", STANDARD.encode(file)))
    }

    /// The URI.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The picture in a page; `alternative` says what is on it.
    #[must_use]
    pub fn image(&self, width: usize, height: usize, alternative: &str) -> Element {
        el("img")
            .attr("src", &self.0)
            .attr("width", width.to_string())
            .attr("height", height.to_string())
            .attr("alt", alternative)
    }
}
