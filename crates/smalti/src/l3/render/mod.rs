//! Rendering of raw images with a learned table.
//!
//! Per row: classify its pixels ([`super::classify`]), look up which kernels they take ([`index`]), lay the rows of the
//! patches column by column in one line ([`interleave`](table::Sample::interleave)), so that the patch of a pixel is one run of
//! it, and multiply ([`products`](table::Sample::products)). In single precision, or in 16-bit numbers as the firmware of a
//! camera would ([`FixedKernels`]).

mod engine;
mod fixed;
mod index;
mod portable;
mod table;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use fixed::FixedKernels;

use super::classify::Classifier;
use super::statistics::{check_size, phase_in};
use super::{L3Error, Pipeline};
use crate::color::{ColorSpace, Image};
use crate::isp::{Isp, IspError};
use crate::numeric::{Planes, ShapeError};
use crate::sensor::{RawImage, RawSamples};
use engine::Engine;
use fixed::Digital;

/// How far levels of a digital raw image may lie from those of the pipeline, digital numbers.
const LEVEL_TOLERANCE_DN: f64 = 0.5;

/// What comes of a raw image.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// One plane for each output.
    pub planes: Planes,
    /// How many pixels were unlike what was trained with.
    pub outside: Outside,
}

/// How many pixels were unlike what was trained with. They are rendered with the nearest class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outside {
    /// Pixels whose patch has a mean response below all that were trained with at their position.
    pub darker: u64,
    /// Pixels whose patch has a mean response above all that were trained with at their position.
    pub brighter: u64,
    /// Pixels whose patch has a combination of clipped channels that is not on the saturation axis.
    pub saturation: u64,
}

impl std::ops::Add for Outside {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            darker: self.darker + other.darker,
            brighter: self.brighter + other.brighter,
            saturation: self.saturation + other.saturation,
        }
    }
}

/// A pipeline made ready to render any number of images in single precision.
#[derive(Debug, Clone)]
pub struct Renderer<'a>(Engine<'a, f32>);

impl Renderer<'_> {
    /// The picture of a raw image.
    ///
    /// # Errors
    /// When its mosaic, size or levels are not those of the pipeline.
    pub fn render(&self, raw: &RawImage) -> Result<Rendered, L3Error> {
        rendered(self.0.pipeline(), raw, |planes| self.render_into(raw, planes))
    }

    fn picture(&self, raw: &RawImage) -> Result<Image, IspError> {
        let learned = |error: L3Error| match error {
            L3Error::Isp(error) => error,
            other => IspError::Learned { reason: other.to_string() },
        };
        let outputs = self.0.pipeline().outputs().len();
        if outputs != 3 {
            return Err(learned(L3Error::NotAPicture { got: outputs }));
        }
        Ok(Image::new(ColorSpace::Xyz, self.render(raw).map_err(learned)?.planes)?)
    }

    /// The same, written over planes that are there already.
    ///
    /// # Errors
    /// As [`Renderer::render`], and when there is not one plane of the image's size for each output.
    pub fn render_into(&self, raw: &RawImage, planes: &mut Planes) -> Result<Outside, L3Error> {
        let phase = check(self.0.pipeline(), raw, planes)?;
        Ok(self.0.render(raw, &(), phase, planes))
    }
}

/// A pipeline made ready to render any number of images of given levels in fixed point.
#[derive(Debug, Clone)]
pub struct FixedRenderer<'a> {
    engine: Engine<'a, i16>,
    kernels: FixedKernels,
    levels: [f64; 2],
}

impl FixedRenderer<'_> {
    /// The kernels it multiplies with.
    #[must_use]
    pub fn kernels(&self) -> &FixedKernels {
        &self.kernels
    }

    /// The picture of a raw image.
    ///
    /// # Errors
    /// [`L3Error::NotDigital`] when its samples are volts, and when its mosaic, size or levels do not fit.
    pub fn render(&self, raw: &RawImage) -> Result<Rendered, L3Error> {
        rendered(self.engine.pipeline(), raw, |planes| self.render_into(raw, planes))
    }

    /// The same, written over planes that are there already.
    ///
    /// # Errors
    /// As [`FixedRenderer::render`], and when there is not one plane of the image's size for each output.
    pub fn render_into(&self, raw: &RawImage, planes: &mut Planes) -> Result<Outside, L3Error> {
        let RawSamples::Digital(samples) = raw.samples() else { return Err(L3Error::NotDigital) };
        let phase = check(self.engine.pipeline(), raw, planes)?;
        let [black, white] = self.levels;
        if [raw.black_level(), raw.white_level()] != self.levels {
            let (got_black, got_white) = (raw.black_level(), raw.white_level());
            return Err(L3Error::RawLevels { black, white, got_black, got_white });
        }
        let digital = Digital::new(samples, raw.cols(), &self.kernels);
        Ok(self.engine.render(raw, &digital, phase, planes))
    }
}

impl Pipeline {
    /// The picture of a raw image, in single precision: one plane for each output.
    ///
    /// A pixel's value is offset + Σ weight · sample over its patch, with the kernels of its class; samples are normalised (0 at
    /// black, 1 at white level), those beyond the border are mirrored ones of the same place in the tile. Every number of
    /// threads and every instruction set gives the same bits. NaN in a raw image makes the pixels NaN whose patch holds it.
    ///
    /// # Errors
    /// When mosaic or size of the image do not fit, or the levels of a digital one are not within 0.5 DN of the pipeline's.
    pub fn render_raw(&self, raw: &RawImage) -> Result<Rendered, L3Error> {
        self.renderer().render(raw)
    }

    /// The same in fixed point: 16-bit samples times 16-bit kernels scaled by class ([`FixedKernels`]), summed in 32 bits. Pixels have the
    /// classes that they have in single precision.
    ///
    /// # Errors
    /// As [`Pipeline::render_raw`]; when the samples are volts, and when the kernels are too large for 16 bits.
    pub fn render_fixed(&self, raw: &RawImage) -> Result<Rendered, L3Error> {
        if matches!(raw.samples(), RawSamples::Analog(_)) {
            return Err(L3Error::NotDigital);
        }
        check_image(self, raw)?;
        self.fixed_renderer(raw.black_level(), raw.white_level())?.render(raw)
    }

    /// How many rows away samples lie at most that a pixel of a picture depends on, those that its class is told by included.
    #[must_use]
    pub fn reach(&self) -> usize {
        Classifier::new(self.axes()).margin()[0]
    }

    /// The pipeline made ready for rendering: what [`Pipeline::render_raw`] does first for every image, done once.
    #[must_use]
    pub fn renderer(&self) -> Renderer<'_> {
        Renderer(Engine::float(self))
    }

    /// The pipeline made ready for rendering in fixed point of raw images with these levels, digital numbers.
    ///
    /// # Errors
    /// As [`Pipeline::fixed_kernels`].
    pub fn fixed_renderer(&self, black_level: f64, white_level: f64) -> Result<FixedRenderer<'_>, L3Error> {
        let kernels = self.fixed_kernels(black_level, white_level)?;
        let engine = Engine::fixed(self, &kernels)?;
        Ok(FixedRenderer { engine, kernels, levels: [black_level, white_level] })
    }

    /// The kernels in 16 bits, for raw images with these levels, digital numbers.
    ///
    /// # Errors
    /// When the white level is not above the black level, or the kernels are too large.
    pub fn fixed_kernels(&self, black_level: f64, white_level: f64) -> Result<FixedKernels, L3Error> {
        FixedKernels::new(self, black_level, white_level)
    }
}

impl Isp for Pipeline {
    /// The picture in CIE XYZ of a pipeline with three outputs.
    fn render(&self, raw: &RawImage) -> Result<Image, IspError> {
        self.renderer().picture(raw)
    }
}

impl Isp for Renderer<'_> {
    /// The picture in CIE XYZ of a pipeline with three outputs.
    fn render(&self, raw: &RawImage) -> Result<Image, IspError> {
        self.picture(raw)
    }
}

/// How far a picture is from a reference, as a peak signal-to-noise ratio in decibels: 20 log₁₀ of the largest value of the
/// reference over the root mean square of the difference. Infinite when they are equal. `None` when the sizes differ, or
/// a value is not finite.
#[must_use]
pub fn peak_ratio_db(reference: &Planes, other: &Planes) -> Option<f64> {
    let shape = |p: &Planes| (p.rows(), p.cols(), p.count());
    if shape(reference) != shape(other) {
        return None;
    }
    let (mut peak, mut squares) = (0.0f64, 0.0);
    for (&a, &b) in reference.data().iter().zip(other.data()) {
        peak = peak.max(f64::from(a));
        squares += (f64::from(a) - f64::from(b)).powi(2);
    }
    let ratio = peak * peak / (squares / reference.data().len().max(1) as f64);
    (squares.is_finite() && peak > 0.0).then(|| 10.0 * ratio.log10())
}

fn rendered(
    pipeline: &Pipeline,
    raw: &RawImage,
    render: impl FnOnce(&mut Planes) -> Result<Outside, L3Error>,
) -> Result<Rendered, L3Error> {
    // Before memory is asked for.
    check_image(pipeline, raw)?;
    let mut planes = Planes::zeros(raw.rows(), raw.cols(), pipeline.outputs().len());
    let outside = render(&mut planes)?;
    Ok(Rendered { planes, outside })
}

/// The phase of the first pixel, when image and planes fit the pipeline.
fn check(pipeline: &Pipeline, raw: &RawImage, planes: &Planes) -> Result<[usize; 2], L3Error> {
    let phase = check_image(pipeline, raw)?;
    let (count, rows, cols) = (pipeline.outputs().len(), raw.rows(), raw.cols());
    if (planes.count(), planes.rows(), planes.cols()) != (count, rows, cols) {
        let (expected, got) = (count * rows * cols, planes.data().len());
        return Err(ShapeError { count, rows, cols, expected, got }.into());
    }
    Ok(phase)
}

fn check_image(pipeline: &Pipeline, raw: &RawImage) -> Result<[usize; 2], L3Error> {
    let phase = phase_in(pipeline.axes().mosaic(), pipeline.channel_names(), raw)?;
    check_size(pipeline.axes(), raw.rows(), raw.cols())?;
    // Volts have levels of their own; once normalised they are alike.
    if matches!(raw.samples(), RawSamples::Digital(_)) {
        let (black, white) = (pipeline.black_level(), pipeline.white_level());
        let (got_black, got_white) = (raw.black_level(), raw.white_level());
        let far = |a: f64, b: f64| (a - b).abs() > LEVEL_TOLERANCE_DN;
        if far(black, got_black) || far(white, got_white) {
            return Err(L3Error::RawLevels { black, white, got_black, got_white });
        }
    }
    Ok(phase)
}
