//! Pictures of learned kernels.

use smalti::camera::Camera;
use smalti::color::{ColorSpace, Image};
use smalti::l3::{Origin, Pipeline};
use smalti::numeric::Planes;

use crate::pictures::{add, filter_color};
use crate::{ReportError, Sheet};

/// Pixels of a tap in pictures of kernels, and of the frame that shows its filter's colour.
const TAP_PX: usize = 28;
const FRAME_PX: usize = 3;

/// The kernels of two classes: a dark flat class above, a bright textured class below, and an output in each column. Positive weights
/// are orange, negative weights blue, relative to the largest weight of the kernel. Frames have the colours of the filters.
pub(super) fn sheet(camera: &Camera, name: &str, pipeline: &Pipeline) -> Result<Sheet, ReportError> {
    let (axes, outputs) = (pipeline.axes(), pipeline.outputs());
    let side = axes.side();
    // The colours of daylight behind the filters.
    let colors = camera.sensor.cfa.channels().iter().map(|c| filter_color(&c.transmittance));
    let colors: Vec<[f32; 3]> = colors.collect::<Result<_, _>>()?;
    let mut sheet = Sheet::new(outputs.len()).title(format!("Learned kernels of {name}"));
    for class in dark_and_bright(pipeline) {
        let key = pipeline.key(class);
        let position = key.position as usize;
        for (output, output_name) in outputs.iter().enumerate() {
            let weights = weights(pipeline, class, output)?;
            let largest = weights.iter().fold(f32::MIN_POSITIVE, |m, w| m.max(w.abs()));
            let mut canvas = Planes::zeros(side * TAP_PX, side * TAP_PX, 3);
            for (tap, &weight) in weights.iter().enumerate() {
                let (row, col) = (tap / side * TAP_PX, tap % side * TAP_PX);
                fill(&mut canvas, row, col, TAP_PX, colors[axes.channel_of(position, tap)]);
                let (row, col) = (row + FRAME_PX, col + FRAME_PX);
                fill(&mut canvas, row, col, TAP_PX - 2 * FRAME_PX, diverging(weight / largest));
            }
            let caption = format!(
                "{output_name} at {}, level {} of {}, {}",
                pipeline.channel_names()[axes.channel_of(position, side * side / 2)],
                key.level + 1,
                axes.level_count(),
                axes.textures().names()[usize::from(key.texture)],
            );
            sheet = add(sheet, caption, &Image::new(ColorSpace::Srgb, canvas)?);
        }
    }
    Ok(sheet.note("Orange: positive weights. Blue: negative weights. Both are relative to the largest weight. Frames: colours of the filters."))
}

/// The weights of a class for an output.
pub(super) fn weights(pipeline: &Pipeline, class: usize, output: usize) -> Result<&[f32], ReportError> {
    pipeline.weights(class, output).ok_or(ReportError::Missing { what: "class of the pipeline" })
}

/// A dark flat and a bright textured class at the first cell of the first channel. Learned classes are preferred.
pub(super) fn dark_and_bright(pipeline: &Pipeline) -> [usize; 2] {
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

/// From blue over white to orange for −1 to 1, which all colour vision distinguishes.
fn diverging(value: f32) -> [f32; 3] {
    let end = if value < 0.0 { [0.13, 0.40, 0.67] } else { [0.90, 0.38, 0.0] };
    let share = value.abs().min(1.0);
    end.map(|e| 1.0 + share * (e - 1.0))
}

/// Fills a square.
fn fill(canvas: &mut Planes, row: usize, col: usize, size: usize, color: [f32; 3]) {
    let cols = canvas.cols();
    for (plane, value) in canvas.planes_mut().zip(color) {
        for r in row..row + size {
            plane[r * cols + col..r * cols + col + size].fill(value);
        }
    }
}
