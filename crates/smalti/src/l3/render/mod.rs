//! Rendering of raw images with a learned table.
//!
//! For each row: classify the pixels ([`super::classify`]); look up their kernels ([`index`]); interleave the
//! rows of the patches column by column ([`interleave`](simd::Rendering::interleave)), which makes the patch of
//! every pixel contiguous; and multiply ([`products`](simd::Rendering::products)). The arithmetic is in single
//! precision or, as in camera firmware, in 16-bit fixed point ([`FixedKernels`]).

mod engine;
mod fixed;
mod index;
mod portable;
mod simd;
mod table;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use fixed::FixedKernels;
pub use index::OutsideCounts;

use super::classify::Classifier;
use super::refine::{FixedRefinement, REACH, RefinementSamples};
use super::statistics::{check_size, listed, phase_in};
use super::{L3Error, Pipeline, Refinement};
use crate::color::{ColorSpace, Image};
use crate::isp::{Isp, IspError};
use crate::numeric::{Planes, ShapeError};
use crate::sensor::{Cfa, RawImage, RawSamples};
use engine::Engine;
use fixed::Digital;

/// Tolerance of the black and white level of a digital raw image against those of the pipeline, digital
/// numbers.
const LEVEL_TOLERANCE_DN: f64 = 0.5;

/// The result of rendering a raw image.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// One plane per output.
    pub planes: Planes,
    /// The numbers of pixels outside the range of the training data.
    pub outside: OutsideCounts,
}

/// A pipeline that is prepared to render any number of images in single precision.
#[derive(Debug, Clone)]
pub struct Renderer<'a>(Engine<'a, f32>);

impl Renderer<'_> {
    /// Renders a raw image.
    ///
    /// # Errors
    /// When its mosaic, size or levels do not match the pipeline.
    pub fn render(&self, raw: &RawImage) -> Result<Rendered, L3Error> {
        rendered(self.0.pipeline, raw, |planes| self.render_into(raw, planes))
    }

    /// Like [`Renderer::render`], into existing planes.
    ///
    /// # Errors
    /// As for [`Renderer::render`], and when there is not one plane of the image's size per output.
    pub fn render_into(&self, raw: &RawImage, planes: &mut Planes) -> Result<OutsideCounts, L3Error> {
        let phase = check(self.0.pipeline, raw, planes)?;
        let outside = self.0.render(raw, &(), phase, planes);
        if let Some(refinement) = self.0.pipeline.refinement() {
            let samples = RefinementSamples::of(raw, self.0.pipeline.axes());
            refinement.apply(planes, Some(samples))?;
        }
        Ok(outside)
    }
}

/// A pipeline that is prepared to render any number of images with given levels in fixed point.
#[derive(Debug, Clone)]
pub struct FixedRenderer<'a> {
    engine: Engine<'a, i16>,
    kernels: FixedKernels,
    refinement: Option<FixedRefinement>,
    levels: [f64; 2],
}

impl FixedRenderer<'_> {
    /// Renders a raw image.
    ///
    /// # Errors
    /// [`L3Error::NotDigital`] when its samples are volts; otherwise when its mosaic, size or levels do not
    /// match.
    pub fn render(&self, raw: &RawImage) -> Result<Rendered, L3Error> {
        rendered(self.engine.pipeline, raw, |planes| self.render_into(raw, planes))
    }

    /// Like [`FixedRenderer::render`], into existing planes.
    ///
    /// # Errors
    /// As for [`FixedRenderer::render`], and when there is not one plane of the image's size per output.
    pub fn render_into(&self, raw: &RawImage, planes: &mut Planes) -> Result<OutsideCounts, L3Error> {
        let RawSamples::Digital(samples) = raw.samples() else { return Err(L3Error::NotDigital) };
        let phase = check(self.engine.pipeline, raw, planes)?;
        let (expected, got) = (self.levels, [raw.black_level(), raw.white_level()]);
        if got != expected {
            return Err(L3Error::RawLevels { expected, got });
        }
        let digital = Digital::new(samples, raw.cols(), &self.kernels);
        let outside = self.engine.render(raw, &digital, phase, planes);
        if let Some(refinement) = &self.refinement {
            let samples = RefinementSamples::of(raw, self.engine.pipeline.axes());
            refinement.apply_to(planes, Some(samples))?;
        }
        Ok(outside)
    }
}

impl Pipeline {
    /// Checks that digital raw images with this black and white level are those of the pipeline.
    ///
    /// # Errors
    /// [`L3Error::RawLevels`].
    pub fn ensure_levels(&self, black_and_white: [f64; 2]) -> Result<(), L3Error> {
        check_levels(self, black_and_white)
    }

    /// The samples of a raw image, with which the second stage compares Y beside highlights.
    ///
    /// # Errors
    /// As for [`Pipeline::render_raw`].
    pub fn refinement_samples<'a>(&self, raw: &'a RawImage) -> Result<RefinementSamples<'a>, L3Error> {
        check_image(self, raw)?;
        Ok(RefinementSamples::of(raw, self.axes()))
    }

    /// Renders a raw image in single precision: one plane per output.
    ///
    /// The value of a pixel is offset + Σ weight · sample over its patch, with the kernels of its class. A pipeline of best quality refines
    /// this picture ([`super::Refinement`]).
    /// Samples are normalised (0 at the black level, 1 at the white level) and are reflected at the border,
    /// with the phase of the tile. Results have the same bits for any number of threads and any instruction
    /// set. A NaN sample makes every pixel NaN whose patch contains it.
    ///
    /// # Errors
    /// When the mosaic or the size of the image does not match, or the levels of a digital image differ from
    /// those of the pipeline by more than 0.5 DN.
    pub fn render_raw(&self, raw: &RawImage) -> Result<Rendered, L3Error> {
        self.renderer().render(raw)
    }

    /// Renders in fixed point: products of 16-bit samples and 16-bit kernels, scaled per class
    /// ([`FixedKernels`]), are summed in 32 bits. Pixels have the same classes as in single precision. The second stage of a pipeline of best
    /// quality computes in integers as well ([`FixedRefinement`]), with the picture of the first one rounded to them.
    ///
    /// # Errors
    /// As for [`Pipeline::render_raw`]; also when the samples are volts, or the kernels are too large for 16
    /// bits.
    pub fn render_fixed(&self, raw: &RawImage) -> Result<Rendered, L3Error> {
        if matches!(raw.samples(), RawSamples::Analog(_)) {
            return Err(L3Error::NotDigital);
        }
        check_image(self, raw)?;
        self.fixed_renderer(raw.black_level(), raw.white_level())?.render(raw)
    }

    /// Checks that the pipeline renders pictures (X, Y, Z) of captures with a colour filter array: the mosaic, at any phase, and the
    /// channels by their names.
    ///
    /// # Errors
    /// [`L3Error::Mosaic`] or [`L3Error::NoPicture`].
    pub fn ensure_renders(&self, cfa: &Cfa) -> Result<(), L3Error> {
        self.ensure_picture()?;
        let names: Vec<String> = cfa.channels().iter().map(|c| c.name.clone()).collect();
        let (own, got) = (self.axes().mosaic(), cfa.mosaic());
        let mut shifts = (0..own.rows()).flat_map(|r| (0..own.cols()).map(move |c| own.shifted(r, c)));
        if names == self.channel_names() && shifts.any(|shifted| shifted == *got) {
            return Ok(());
        }
        Err(L3Error::Mosaic { expected: listed(own, self.channel_names()), got: listed(got, &names) })
    }

    /// Distance in rows of the farthest sample on which an output pixel depends, including the samples that
    /// determine its class.
    #[must_use]
    pub fn reach(&self) -> usize {
        Classifier::new(self.axes()).margin()[0] + self.refinement().map_or(0, |_| REACH)
    }

    /// Prepares the pipeline for rendering. [`Pipeline::render_raw`] does so for every image.
    #[must_use]
    pub fn renderer(&self) -> Renderer<'_> {
        Renderer(Engine::float(self))
    }

    /// Prepares the pipeline for fixed-point rendering of raw images with these levels, digital numbers.
    ///
    /// # Errors
    /// As [`Pipeline::fixed_kernels`].
    pub fn fixed_renderer(&self, black_level: f64, white_level: f64) -> Result<FixedRenderer<'_>, L3Error> {
        let kernels = self.fixed_kernels(black_level, white_level)?;
        let engine = Engine::fixed(self, &kernels)?;
        let refinement = self.refinement().map(Refinement::fixed).transpose()?;
        Ok(FixedRenderer { engine, kernels, refinement, levels: [black_level, white_level] })
    }

    /// The 16-bit kernels of the first stage for raw images with these levels, digital numbers.
    ///
    /// # Errors
    /// When the white level is not above the black level, and [`L3Error::NoFixedPoint`] when the kernels are too
    /// large.
    pub fn fixed_kernels(&self, black_level: f64, white_level: f64) -> Result<FixedKernels, L3Error> {
        FixedKernels::new(self, black_level, white_level)
    }
}

impl Isp for Pipeline {
    /// Renders CIE XYZ with a pipeline of three outputs.
    fn render(&self, raw: &RawImage) -> Result<Image, IspError> {
        Isp::render(&self.renderer(), raw)
    }
}

impl Isp for Renderer<'_> {
    /// Renders CIE XYZ with a pipeline of three outputs.
    fn render(&self, raw: &RawImage) -> Result<Image, IspError> {
        let learned = |error: L3Error| match error {
            L3Error::Isp(error) => error,
            other => IspError::Learned(other.to_string()),
        };
        let outputs = self.0.pipeline.outputs().len();
        if outputs != 3 {
            return Err(learned(L3Error::NotAPicture(outputs)));
        }
        Ok(Image::new(ColorSpace::Xyz, self.render(raw).map_err(learned)?.planes)?)
    }
}

/// Peak signal-to-noise ratio in decibels between an image and a reference: 20 log₁₀ of the largest value of
/// the reference over the root mean square difference. Infinite for equal images. `None` when the sizes
/// differ or a value is not finite.
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
    render: impl FnOnce(&mut Planes) -> Result<OutsideCounts, L3Error>,
) -> Result<Rendered, L3Error> {
    // Checked before any allocation.
    check_image(pipeline, raw)?;
    let mut planes = Planes::zeros(raw.rows(), raw.cols(), pipeline.outputs().len());
    let outside = render(&mut planes)?;
    Ok(Rendered { planes, outside })
}

/// Checks that image and planes match the pipeline, and returns the phase of the first pixel.
fn check(pipeline: &Pipeline, raw: &RawImage, planes: &Planes) -> Result<[usize; 2], L3Error> {
    let phase = check_image(pipeline, raw)?;
    let (count, rows, cols) = (pipeline.outputs().len(), raw.rows(), raw.cols());
    if (planes.count(), planes.rows(), planes.cols()) != (count, rows, cols) {
        let (expected, got) = (count * rows * cols, planes.data().len());
        return Err(ShapeError { count, rows, cols, expected, got }.into());
    }
    Ok(phase)
}

fn check_levels(pipeline: &Pipeline, got: [f64; 2]) -> Result<(), L3Error> {
    let expected = [pipeline.black_level(), pipeline.white_level()];
    let differ = expected.iter().zip(got).any(|(a, b)| (a - b).abs() > LEVEL_TOLERANCE_DN);
    if differ { Err(L3Error::RawLevels { expected, got }) } else { Ok(()) }
}

fn check_image(pipeline: &Pipeline, raw: &RawImage) -> Result<[usize; 2], L3Error> {
    let phase = phase_in(pipeline.axes().mosaic(), pipeline.channel_names(), raw)?;
    check_size(pipeline.axes(), raw.rows(), raw.cols())?;
    // Volts have their own levels; after normalisation they are equivalent.
    if matches!(raw.samples(), RawSamples::Digital(_)) {
        check_levels(pipeline, [raw.black_level(), raw.white_level()])?;
    }
    Ok(phase)
}
