//! A header in integers.

use std::path::Path;

use smalti::l3::{
    FixedKernels, FixedRefinement, L3Error, Pipeline, Polynomial, REFINEMENT_INPUTS, Refinement,
    RefinementSamples, Textures,
};
use smalti::sensor::{RawImage, RawSamples, Sampling};

use super::contrast::{self, Flat};
use super::operations::{Operations, operations};
use super::refinement::{OUTPUTS, of_stage};
use super::{Header, RAW, braced};
use crate::IoError;
use crate::error::At;

/// The functions that compute in integers.
const FIXED: &str = include_str!("c/fixed.h");
/// Those of the second stage.
const SECOND: &str = include_str!("c/refinement_fixed.h");
/// Least power of two of the factor from sums to pictures: the bits of single precision fit it.
const UNIT_BITS: i32 = 29;

impl Header<'_> {
    /// The whole header but its end.
    pub(super) fn integers(&mut self, path: &Path, pipeline: &Pipeline) -> Result<(), IoError> {
        let fixed = pipeline.fixed_kernels(pipeline.black_level(), pipeline.white_level()).at(path)?;
        let flat = contrast::flat(pipeline).ok_or_else(|| {
            IoError::field(path, "the contrast that is flat", "too large", "a limit within 64 bits")
        })?;
        let clip = first_clipped(pipeline).at(path)?;
        self.comment(pipeline, &fixed);
        self.constants(pipeline, &fixed, &flat, clip);
        self.tables(pipeline, &fixed);
        let second = pipeline.refinement();
        if let Some(refinement) = second {
            self.fixed_refinement(refinement, &refinement.fixed().at(path)?, fixed.scale);
            self.fixed_responses(pipeline);
        }
        self.code(RAW);
        self.code(&of_stage(FIXED, second.is_some()));
        if second.is_some() {
            self.refined_image(SECOND, "int32_t", "first_pixel");
        }
        Ok(())
    }

    fn comment(&mut self, pipeline: &Pipeline, fixed: &FixedKernels) {
        self.about(pipeline, "fixed point");
        let reduced =
            if fixed.sample_shift == 0 { "" } else { ", half of that rounded down from the middle" };
        let [coarse, fine] = shifts(fixed).map(|shift| f64::from(fixed.scale) / f64::from(1u32 << shift));
        let Operations { kernel_multiplications, multiplications, additions, comparisons, table_bytes } =
            operations(pipeline);
        let (upper, second) = (self.upper.clone(), self.about_refinement(pipeline.refinement()));
        let places = FixedRefinement::PLACES;
        let (of_first, second) = if second.is_empty() {
            ("", second)
        } else {
            let more = format!(
                "\n   Its pictures and outputs have {places} binary places (2^{places} is white) and saturate at 8 times white. Its kernels have 16 bits, and each\n   \
                 class the binary places that they allow; sums have 64 bits and are rounded once, halves away from zero."
            );
            (" of the first stage", second + &more)
        };
        self.line(format!(
            "   \
   Output = {upper}_SCALE * (offset + sum of kernel * d) / 2^shift, white = 1, d = sample - {upper}_BLACK{reduced}, of 16 bits;
   kernels are row by row; each class has the shift that uses their 16 bits, the same for all outputs.
   A step of the sum is {fine:.3e} to {coarse:.3e} of white.

   Operations per pixel{of_first} as written below, indexing apart:
     {multiplications} multiplications ({kernel_multiplications} for the kernels), {additions} additions, {comparisons} comparisons; tables of {table_bytes} bytes.
   Neighbouring pixels share most sums of the classification.{second} */

#include <stddef.h>
#include <stdint.h>
"
        ));
    }

    fn constants(&mut self, pipeline: &Pipeline, fixed: &FixedKernels, flat: &Flat, clip: u32) {
        let axes = pipeline.axes();
        self.axes(pipeline);
        self.define("BLACK", fixed.black, "what kernels take from samples");
        self.define("CLIP", format!("{clip}u"), "the least sample that counts as clipped");
        self.define("SAMPLE_SHIFT", fixed.sample_shift, "bits that samples lose after that");
        let [least_shift, most_shift] = shifts(fixed);
        self.define("MIN_SHIFT", least_shift, "binary places of the kernels that have the fewest");
        self.define("MAX_SHIFT", most_shift, "and the most");
        self.define("SCALE", format!("{:e}f", fixed.scale), "from sums / 2^shift to outputs");
        if axes.textures() != Textures::None {
            let black_sum = (axes.taps() as f64 * pipeline.black_level()).round();
            self.line(
                "/* A patch is texture when 2^FLAT_BITS times the square of its summed differences is above\n   \
                 FLAT_0 + light * (FLAT_1 + light * FLAT_2 / 2^FLAT_2_BITS), light: the sum of its samples above black. */",
            );
            self.define("BLACK_SUM", format!("{black_sum}u"), "");
            for (name, value) in ["FLAT_0", "FLAT_1", "FLAT_2"].iter().zip(flat.coefficients) {
                self.define(name, format!("UINT64_C({value})"), "");
            }
            self.define("FLAT_BITS", flat.bits, "");
            self.define("FLAT_2_BITS", flat.more_bits, "");
        }
    }

    fn tables(&mut self, pipeline: &Pipeline, fixed: &FixedKernels) {
        let axes = pipeline.axes();
        self.mosaic(pipeline);
        if axes.level_count() > 1 {
            self.line("/* A patch is above a level when the sum of its samples reaches the cut. */");
            self.cuts(pipeline, "uint32_t", |cut| {
                let mean = f64::from(cut) * (pipeline.white_level() - pipeline.black_level());
                // A conversion to an integer saturates.
                format!("{}u", ((mean + pipeline.black_level()) * axes.taps() as f64).ceil() as u32)
            });
        }
        self.pairs(pipeline);
        if axes.textures() == Textures::Oriented {
            let gradient = contrast::gradient(&axes.contrast_pairs());
            self.table("int16_t", "edge_gradient", "[2][2]", &gradient.map(braced));
        }
        let (upper, taps, outputs) = (self.upper.clone(), axes.taps(), pipeline.outputs().len());
        let of_outputs = |rows: Vec<String>| rows.chunks(outputs).map(braced).collect::<Vec<_>>();
        let kernels = of_outputs(fixed.weights.chunks(taps).map(braced).collect());
        let shape = format!("[{upper}_CLASSES][{upper}_OUTPUTS][{upper}_TAPS]");
        self.table("int16_t", "kernels", &shape, &kernels);
        let offsets = fixed.offsets.chunks(outputs).map(braced).collect::<Vec<_>>();
        self.table("int32_t", "offsets", &format!("[{upper}_CLASSES][{upper}_OUTPUTS]"), &offsets);
        self.line("/* Binary places of kernels and offsets. */");
        self.table("uint8_t", "shifts", &format!("[{upper}_CLASSES]"), &fixed.shifts);
    }

    /// From samples to the responses that the second stage compares Y with.
    fn fixed_responses(&mut self, pipeline: &Pipeline) {
        let [black, factor] = RefinementSamples::scale(pipeline.black_level(), pipeline.white_level());
        self.line("/* Responses: (256 * sample - RESPONSE_BLACK) * RESPONSE / 2^24, with the binary places of pictures. */");
        self.define("RESPONSE_BLACK", format!("INT64_C({black})"), "");
        self.define("RESPONSE", format!("INT64_C({factor})"), "");
    }

    /// The numbers of the second stage; `scale` is that of sums of the first one without binary places.
    fn fixed_refinement(&mut self, refinement: &Refinement, fixed: &FixedRefinement, scale: f32) {
        let upper = self.upper.clone();
        self.refinement_axes(refinement);
        self.define("INPUTS", REFINEMENT_INPUTS, "of a pixel");
        self.define("PLACES", FixedRefinement::PLACES, "binary places of pictures");
        self.define("MOST", FixedRefinement::MOST, "where they saturate");
        self.define("DARK", fixed.dark, "noise at Y = 0");
        self.define(
            "TENSOR_SHIFT",
            FixedRefinement::TENSOR_SHIFT,
            "bits that sums of squares of gradients lose",
        );
        // The exponent of a normal number; the scale is at least 2^-17 and at most 1.
        let exponent = (scale.to_bits() >> 23) as i32 - 127;
        let unit_places = UNIT_BITS - FixedRefinement::PLACES as i32 - exponent;
        let unit = f64::from(scale) * f64::from(FixedRefinement::PLACES as i32 + unit_places).exp2();
        self.line("/* From sums of the first stage to pictures: a factor with binary places. */");
        self.define("UNIT", unit, "");
        self.define("UNIT_PLACES", unit_places, "");
        let polynomial = |p: &Polynomial| {
            let [a, b] = p.places.map(i64::from);
            let [c0, c1, c2] = p.coefficients;
            braced([c0, c1, c2, a, b].map(|v| format!("INT64_C({v})")))
        };
        self.line(
            "/* Of each picture: coefficients of 1, Y, Y * Y in the difference beyond which neighbours do not count, binary places of the\n   \
             second beyond those of the first and of the third beyond those of the second. */",
        );
        let squares: Vec<String> = fixed.squares.iter().map(polynomial).collect();
        self.table("int64_t", "squares", &format!("[{upper}_PICTURES][5]"), &squares);
        self.line("/* The same for the noise that sums of squares of gradients are compared with, of sums of Y of 16 pixels. */");
        let noise = polynomial(&fixed.noise);
        self.table("int64_t", "noise", "[5]", &[noise.trim_matches(['{', '}'])]);
        self.line("/* Red, green and blue of ITU-R BT.2020 from X, Y, Z, with 30 binary places. */");
        let row = |row: [i64; 3]| braced(row.map(|v| format!("INT64_C({v})")));
        self.table("int64_t", "rgb_from_xyz", "[3][3]", &fixed.rgb_from_xyz.map(row));
        if !fixed.cuts.is_empty() {
            let cuts: Vec<String> = fixed.cuts.iter().map(|c| format!("INT64_C({c})")).collect();
            self.table("int64_t", "refined_cuts", &format!("[{upper}_REFINED_LEVELS - 1]"), &cuts);
        }
        self.line("/* Factor of the noise, and its binary places. */");
        let strengths: Vec<String> = fixed.strengths.iter().map(braced).collect();
        self.table("int64_t", "strengths", &format!("[{upper}_STRENGTHS][2]"), &strengths);
        self.line("/* Y of 5 x 5 pixels row by row, X of 3 x 3, Z of 3 x 3, X, Y, Z of the smooth pictures, then the roots. */");
        let kernels: Vec<String> = fixed.weights.chunks_exact(REFINEMENT_INPUTS).map(braced).collect();
        let classes: Vec<String> = kernels.chunks_exact(OUTPUTS).map(braced).collect();
        let shape = format!("[{upper}_REFINED_CLASSES][3][{upper}_INPUTS]");
        self.table("int16_t", "refined_kernels", &shape, &classes);
        let offset = |offset: &i64| format!("INT64_C({offset})");
        let offsets: Vec<String> = fixed
            .offsets
            .chunks_exact(OUTPUTS)
            .map(|of| braced(of.iter().map(offset).collect::<Vec<_>>()))
            .collect();
        self.table("int64_t", "refined_offsets", &format!("[{upper}_REFINED_CLASSES][3]"), &offsets);
        self.line("/* Binary places of kernels; offsets have PLACES more. */");
        self.table("uint8_t", "refined_shifts", &format!("[{upper}_REFINED_CLASSES]"), &fixed.shifts);
    }
}

/// The least digital number that counts as clipped, by the very arithmetic of the library; 65536 when none does.
fn first_clipped(pipeline: &Pipeline) -> Result<u32, L3Error> {
    let names = vec![String::new()];
    let samples = RawSamples::Digital((0..=u16::MAX).collect());
    let mosaic = smalti::sensor::Mosaic::new(1, 1, vec![0]);
    let Ok(mosaic) = mosaic else { return Err(L3Error::NoMosaic) };
    let (black, white) = (pipeline.black_level(), pipeline.white_level());
    let raw = RawImage::new(256, 256, samples, Sampling::Mosaic(mosaic), names, black, white)
        .map_err(|e| L3Error::Table(e.to_string()))?;
    let clip = pipeline.axes().clip() as f32;
    Ok(raw.normalized().partition_point(|&v| v < clip) as u32)
}

/// The least shift and the largest.
fn shifts(fixed: &FixedKernels) -> [u8; 2] {
    [fixed.shifts.iter().min(), fixed.shifts.iter().max()].map(|shift| shift.copied().unwrap_or(0))
}
