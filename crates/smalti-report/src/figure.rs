//! A finished figure.

use std::sync::{Arc, LazyLock};

use resvg::{tiny_skia, usvg};

use crate::FigureError;
use crate::svg::Svg;
use crate::text::{REGULAR, SEMI_BOLD};

/// The longest side of a figure or its PNG, in pixels.
pub const SIDE_LIMIT: f64 = 16_384.0;
/// The most pixels of a PNG.
const PIXEL_LIMIT: f64 = 1e8;

/// The fonts of all figures.
static FONTS: LazyLock<Arc<usvg::fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = usvg::fontdb::Database::new();
    fonts.load_font_data(REGULAR.to_vec());
    fonts.load_font_data(SEMI_BOLD.to_vec());
    fonts.set_sans_serif_family("Inter");
    Arc::new(fonts)
});

/// Methods that set fields of a value and return it.
macro_rules! setters {
    ($($(#[$doc:meta])* $name:ident($($arg:ident: $of:ty),*) { $($($field:ident).+ = $value:expr);+ })+) => {$(
        $(#[$doc])*
        #[must_use]
        pub fn $name(mut self, $($arg: $of),*) -> Self {
            $(self.$($field).+ = $value;)+
            self
        }
    )+};
}
pub(crate) use setters;

/// A finished figure as an SVG document, which can be rendered as PNG. Equal inputs give equal bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    svg: String,
    width: f64,
    height: f64,
    /// How its PNG is compressed.
    compression: Compression,
}

/// A trade of size against time for a PNG.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Compression {
    /// For drawings, which have large even areas.
    Small,
    /// For pictures: a noisy one is 8 % larger than with [`Compression::Small`] and takes a twentieth of the time.
    Fast,
}

impl Figure {
    pub(crate) fn new(
        svg: Svg,
        width: f64,
        height: f64,
        title: &str,
        description: &str,
    ) -> Result<Self, FigureError> {
        check_size(width, height)?;
        let svg = svg.finish(width, height, title, description);
        Ok(Self { svg, width, height, compression: Compression::Small })
    }

    /// The figure as one of pictures.
    pub(crate) fn of_pictures(self) -> Self {
        Self { compression: Compression::Fast, ..self }
    }

    /// The SVG document in UTF-8, with a title and a description for screen readers.
    #[must_use]
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// Width and height in pixels at scale 1.
    #[must_use]
    pub fn size(&self) -> (f64, f64) {
        (self.width, self.height)
    }

    /// The figure as an 8-bit RGB PNG with `scale` pixels per pixel of the SVG; 2 suits print and high-resolution displays. The
    /// text is set in the font of this crate, so that all machines draw the same bytes.
    ///
    /// # Errors
    /// [`FigureError::Size`] for a scale that is not positive or gives too many pixels.
    pub fn png(&self, scale: f64) -> Result<Vec<u8>, FigureError> {
        let (rgb, size) = self.pixels(scale)?;
        self.encoded(&rgb, size)
    }

    /// Pixels of this figure as PNG.
    pub(crate) fn encoded(&self, rgb: &[u8], size: [u32; 2]) -> Result<Vec<u8>, FigureError> {
        encode(rgb, size, png::ColorType::Rgb, self.compression)
    }

    /// The pixels of [`png`](Self::png), and their width and height.
    pub(crate) fn pixels(&self, scale: f64) -> Result<(Vec<u8>, [u32; 2]), FigureError> {
        let (width, height) = ((self.width * scale).round(), (self.height * scale).round());
        check_size(width, height)?;
        if width * height > PIXEL_LIMIT {
            let reason = format!("a PNG has at most {PIXEL_LIMIT:e} pixels");
            return Err(FigureError::Size { width, height, reason });
        }
        let options = usvg::Options {
            font_family: "Inter".to_owned(),
            fontdb: Arc::clone(&FONTS),
            ..usvg::Options::default()
        };
        let tree = usvg::Tree::from_str(&self.svg, &options)?;
        let Some(mut pixels) = tiny_skia::Pixmap::new(width as u32, height as u32) else {
            let reason = "no memory for its pixels".to_owned();
            return Err(FigureError::Size { width, height, reason });
        };
        pixels.fill(tiny_skia::Color::WHITE);
        let transform = tiny_skia::Transform::from_scale(scale as f32, scale as f32);
        resvg::render(&tree, transform, &mut pixels.as_mut());
        let rgb = pixels.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
        Ok((rgb, [width as u32, height as u32]))
    }
}

/// Refuses sizes that cannot be drawn.
pub(crate) fn check_size(width: f64, height: f64) -> Result<(), FigureError> {
    if [width, height].iter().all(|side| (1.0..=SIDE_LIMIT).contains(side)) {
        return Ok(());
    }
    let reason = format!("sides must lie between 1 and {SIDE_LIMIT} pixels");
    Err(FigureError::Size { width, height, reason })
}

/// Encodes pixels as PNG of a width and height.
pub(crate) fn encode(
    pixels: &[u8],
    [width, height]: [u32; 2],
    color: png::ColorType,
    compression: Compression,
) -> Result<Vec<u8>, FigureError> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(match compression {
        Compression::Small => png::Compression::Balanced,
        Compression::Fast => png::Compression::Fast,
    });
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(out)
}
