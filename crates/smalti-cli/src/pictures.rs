//! Pictures of a comparison: the renderings side by side, and what was learned.

use smalti::camera::Camera;
use smalti::color::{ColorSpace, Image};
use smalti::l3::{Origin, Pipeline};
use smalti::numeric::Planes;
use smalti::spectrum::{Illuminant, Observer, Outside, Spectrum, WavelengthGrid};
use smalti_report::Sheet;

/// Pixels of a tap in pictures of kernels, and of the frame that shows its filter's colour.
const TAP_PX: usize = 28;
const FRAME_PX: usize = 3;
/// A sheet with one more picture, in sRGB, and what stands below it.
pub(crate) fn add(sheet: Sheet, caption: impl Into<String>, picture: &Image) -> Sheet {
    sheet.picture(caption, picture.cols(), picture.rows(), &bytes(picture))
}

/// A picture of 8-bit sRGB: three bytes a pixel, row by row.
pub(crate) struct Pixels {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) rgb: Vec<u8>,
}

impl Pixels {
    /// Of an image in sRGB.
    pub(crate) fn of(image: &Image) -> Self {
        Self { width: image.cols(), height: image.rows(), rgb: bytes(image) }
    }
}

/// A picture in sRGB as three bytes a pixel, row by row.
pub(crate) fn bytes(picture: &Image) -> Vec<u8> {
    let [r, g, b] = [0, 1, 2].map(|c| picture.planes().plane(c));
    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
    r.iter().zip(g).zip(b).flat_map(|((&r, &g), &b)| [r, g, b].map(byte)).collect()
}

/// The kernels of two classes, as on the slides: a dark flat one above, a bright textured one below, an output in each
/// column. Positive weights are orange, negative ones blue, relative to the largest of the kernel; frames have the
/// colours of the filters.
pub(crate) fn kernels(camera: &Camera, name: &str, pipeline: &Pipeline) -> anyhow::Result<Sheet> {
    let (axes, outputs) = (pipeline.axes(), pipeline.outputs());
    let side = axes.side();
    let colors = filter_colors(camera)?;
    let mut sheet = Sheet::new(outputs.len()).title(format!("Learned kernels of {name}"));
    for class in dark_and_bright(pipeline) {
        let key = pipeline.key(class);
        let position = key.position as usize;
        for (output, output_name) in outputs.iter().enumerate() {
            let weights = pipeline.weights(class, output);
            let largest = weights.iter().fold(f32::MIN_POSITIVE, |m, w| m.max(w.abs()));
            let mut canvas = Canvas::new(side * TAP_PX, side * TAP_PX);
            for (tap, &weight) in weights.iter().enumerate() {
                let (row, col) = (tap / side * TAP_PX, tap % side * TAP_PX);
                canvas.fill(row, col, TAP_PX, colors[axes.channel_of(position, tap)]);
                canvas.fill(
                    row + FRAME_PX,
                    col + FRAME_PX,
                    TAP_PX - 2 * FRAME_PX,
                    diverging(weight / largest),
                );
            }
            let caption = format!(
                "{output_name} at {}, level {} of {}, {}",
                pipeline.channel_names()[axes.channel_of(position, side * side / 2)],
                key.level + 1,
                axes.level_count(),
                axes.textures().names()[usize::from(key.texture)],
            );
            sheet = add(sheet, caption, &canvas.image()?);
        }
    }
    Ok(sheet.note("Orange: positive weights, blue: negative, relative to the largest. Frames: the filters."))
}

/// A dark flat and a bright textured class at the first cell of the first channel, learned ones where there are.
pub(crate) fn dark_and_bright(pipeline: &Pipeline) -> [usize; 2] {
    let axes = pipeline.axes();
    let position = axes.mosaic().cells().iter().position(|&c| c == 0).unwrap_or(0);
    let (levels, textures) = (axes.level_count(), axes.textures().count());
    let class = |level, texture| pipeline.index(position, 0, level, texture);
    let learned =
        |&level: &usize, texture| pipeline.classes()[class(level, texture)].origin == Origin::Learned;
    let texture = textures.min(2) - 1;
    let dark = (0..levels).find(|l| learned(l, 0)).unwrap_or(0);
    let bright = (0..levels).rev().find(|l| learned(l, texture)).unwrap_or(levels - 1);
    [class(dark, 0), class(bright, texture)]
}

/// From blue over white to orange for −1 to 1: distinct for the colour-blind.
fn diverging(value: f32) -> [f32; 3] {
    let end = if value < 0.0 { [0.13, 0.40, 0.67] } else { [0.90, 0.38, 0.0] };
    let share = value.abs().min(1.0);
    end.map(|e| 1.0 + share * (e - 1.0))
}

/// What the filters look like in daylight.
fn filter_colors(camera: &Camera) -> anyhow::Result<Vec<[f32; 3]>> {
    camera.sensor.cfa.channels().iter().map(|c| filter_color(&c.transmittance)).collect()
}

/// What a filter looks like in daylight, in sRGB; a dark one (infrared) grey.
pub(crate) fn filter_color(filter: &Spectrum) -> anyhow::Result<[f32; 3]> {
    // Daylight is not tabulated as far as sensors see.
    let filter = filter.resampled(WavelengthGrid::VISIBLE, Outside::Zero)?;
    let light = Illuminant::D65.photons(filter.grid())?;
    let xyz = Observer::Cie1931.xyz_from_photons(&filter.times(&light)?)?;
    let white = Observer::Cie1931.xyz_from_photons(&light)?[1].max(f64::MIN_POSITIVE);
    let planes = Planes::new(1, 1, 3, xyz.map(|v| (v / white) as f32).to_vec())?;
    let rgb = Image::new(ColorSpace::Xyz, planes)?.converted(ColorSpace::Srgb)?;
    Ok([0, 1, 2].map(|c| rgb.planes().plane(c)[0].clamp(0.25, 1.0)))
}

struct Canvas(Planes);

impl Canvas {
    fn new(rows: usize, cols: usize) -> Self {
        Self(Planes::zeros(rows, cols, 3))
    }

    fn fill(&mut self, row: usize, col: usize, size: usize, color: [f32; 3]) {
        let cols = self.0.cols();
        for (c, value) in color.into_iter().enumerate() {
            let plane = self.0.plane_mut(c);
            for r in row..row + size {
                plane[r * cols + col..r * cols + col + size].fill(value);
            }
        }
    }

    fn image(self) -> anyhow::Result<Image> {
        Ok(Image::new(ColorSpace::Srgb, self.0)?)
    }
}
