//! A header in single precision.

use smalti::l3::{Pipeline, REFINEMENT_LANES, REFINEMENT_RGB_FROM_XYZ, Refinement, Textures};

use super::refinement::{OUTPUTS, of_stage};
use super::{Header, RAW, braced, contrast};

/// The functions of the first stage.
const FIRST: &str = include_str!("c/float.h");
/// Those of the second stage.
const SECOND: &str = include_str!("c/refinement_float.h");

impl Header<'_> {
    /// The whole header but its end.
    pub(super) fn single_precision(&mut self, pipeline: &Pipeline) {
        self.about(pipeline, "single precision");
        let refinement = pipeline.refinement();
        let second = self.about_refinement(refinement);
        let math = if refinement.is_some() { "#include <math.h>\n" } else { "" };
        self.line(format!(
            "   \
   Output = the product of a kernel and the patch, white = 1; kernels are column by column, and the offset follows.

   The order of operations is that of Smalti. Results have the bits of its pictures where `float` is evaluated as such and
   products are rounded before they are added, as GCC does with -std=c99 on processors with SSE, NEON or the like.{second} */

{math}#include <stddef.h>
#include <stdint.h>

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif
"
        ));
        self.float_constants(pipeline);
        self.float_tables(pipeline);
        if let Some(refinement) = refinement {
            self.float_refinement(refinement);
        }
        self.code(RAW);
        self.code(&of_stage(FIRST, refinement.is_some()));
        if refinement.is_some() {
            self.refined_image(SECOND, "float", "pixel");
        }
    }

    fn float_constants(&mut self, pipeline: &Pipeline) {
        let axes = pipeline.axes();
        self.axes(pipeline);
        let (black, white) = (pipeline.black_level(), pipeline.white_level());
        self.define("BLACK", float(black as f32), "");
        self.define("GAIN", float((1.0 / (white - black)) as f32), "1 / (white level - black level)");
        self.define("CLIP", float(axes.clip() as f32), "the least response that counts as clipped");
        if axes.textures() != Textures::None {
            self.line(
                "/* A patch is texture when the square of its summed differences is above\n   \
                 FLAT_0 + light * (FLAT_1 + light * FLAT_2), light: its mean, if that is above black. */",
            );
            for (name, value) in ["FLAT_0", "FLAT_1", "FLAT_2"].iter().zip(axes.summed_contrast_limit()) {
                self.define(name, float(value), "");
            }
        }
    }

    fn float_tables(&mut self, pipeline: &Pipeline) {
        let axes = pipeline.axes();
        self.mosaic(pipeline);
        if axes.level_count() > 1 {
            self.line("/* A patch is above a level when its mean reaches the cut. */");
            self.cuts(pipeline, "float", float);
        }
        self.pairs(pipeline);
        if axes.textures() == Textures::Oriented {
            let pairs = axes.contrast_pairs();
            let factor = contrast::determinant(&pairs) as f32;
            let gradient =
                contrast::gradient(&pairs).map(|row| braced(row.map(|v| float(v as f32 / factor))));
            self.table("float", "edge_gradient", "[2][2]", &gradient);
        }
        let (upper, side, outputs) = (self.upper.clone(), axes.side(), pipeline.outputs().len());
        let kernels = pipeline.kernels();
        let kernel = |(weights, offset): (&[f32], &f32)| {
            let tap = |i: usize| weights.get(i % side * side + i / side).copied().unwrap_or(0.0);
            let all = (0..axes.taps()).map(tap).chain([*offset]);
            braced(all.map(float).collect::<Vec<_>>())
        };
        let all: Vec<String> =
            kernels.weights.chunks_exact(axes.taps()).zip(&kernels.offsets).map(kernel).collect();
        let shape = format!("[{upper}_CLASSES][{upper}_OUTPUTS][{upper}_TAPS + 1]");
        self.table("float", "kernels", &shape, &all.chunks(outputs).map(braced).collect::<Vec<_>>());
    }

    /// The numbers of the second stage.
    fn float_refinement(&mut self, refinement: &Refinement) {
        let (axes, upper) = (refinement.axes(), self.upper.clone());
        self.refinement_axes(refinement);
        self.define("LANES", REFINEMENT_LANES, "inputs of a pixel, zeros included");
        self.define("TANGENT", float(std::f32::consts::SQRT_2 - 1.0), "of 22.5 degrees");
        self.line("/* The variance of the noise of a sample is NOISE_0 + Y * (NOISE_1 + Y * NOISE_2). */");
        for (name, value) in ["NOISE_0", "NOISE_1", "NOISE_2"].iter().zip(axes.noise()) {
            self.define(name, float(value), "");
        }
        self.define("DARK", float(axes.dark_noise()), "noise at Y = 0");
        self.line("/* Of each picture: coefficients of 1, Y, Y * Y in the difference beyond which neighbours do not count. */");
        let squares = axes.pictures().map(|p| braced(p.squares.map(float)));
        self.table("float", "squares", &format!("[{upper}_PICTURES][3]"), &squares);
        self.line("/* Red, green and blue of ITU-R BT.2020 from X, Y, Z. */");
        let rgb = REFINEMENT_RGB_FROM_XYZ.map(|row| braced(row.map(float)));
        self.table("float", "rgb_from_xyz", "[3][3]", &rgb);
        if axes.levels().count() > 1 {
            let cuts: Vec<String> = axes.levels().cuts().iter().map(|&c| float(c)).collect();
            self.table("float", "refined_cuts", &format!("[{upper}_REFINED_LEVELS - 1]"), &cuts);
        }
        let strengths: Vec<String> = axes.strengths().iter().map(|&s| float(s)).collect();
        self.table("float", "strengths", &format!("[{upper}_STRENGTHS]"), &strengths);
        self.line(
            "/* Y of 5 x 5 pixels column by column; for each of 3 columns X of 3 rows, then Z; the roots; zeros; X, Y, Z of the smooth pictures; offset. */",
        );
        let numbers: Vec<String> = refinement.lanes().map(float).collect();
        let kernels: Vec<String> = numbers.chunks_exact(REFINEMENT_LANES).map(braced).collect();
        let shape = format!("[{upper}_REFINED_CLASSES][3][{upper}_LANES]");
        let classes: Vec<String> = kernels.chunks_exact(OUTPUTS).map(braced).collect();
        self.table("float", "refined_kernels", &shape, &classes);
    }
}

/// A number in hexadecimal, which compilers take over exactly.
fn float(value: f32) -> String {
    let bits = value.to_bits();
    let (sign, exponent, mantissa) =
        (if bits >> 31 == 1 { "-" } else { "" }, bits >> 23 & 0xff, bits & 0x7f_ffff);
    // A number below the least normal one has no leading 1.
    let (lead, exponent) = match (exponent, mantissa) {
        (0, 0) => return format!("{sign}0.0f"),
        (0, _) => (0, -126),
        (e, _) => (1, e as i32 - 127),
    };
    // 23 bits and a zero are six hexadecimal digits.
    let digits = format!("{:06x}", mantissa << 1);
    let digits = digits.trim_end_matches('0');
    let point = if digits.is_empty() { "" } else { "." };
    format!("{sign}0x{lead}{point}{digits}p{exponent}f")
}

#[cfg(test)]
mod tests {
    use super::float;

    /// From C99, 6.4.4.2: a significand in hexadecimal times a power of two.
    #[test]
    fn numbers_in_hexadecimal_are_exact() {
        for (value, text) in [
            (0.0, "0.0f"),
            (-0.0, "-0.0f"),
            (1.0, "0x1p0f"),
            (-0.15625, "-0x1.4p-3f"),
            (f32::MAX, "0x1.fffffep127f"),
            (f32::MIN_POSITIVE, "0x1p-126f"),
            (f32::from_bits(1), "0x0.000002p-126f"),
            (0.1, "0x1.99999ap-4f"),
        ] {
            assert_eq!(float(value), text, "{value}");
        }
    }
}
