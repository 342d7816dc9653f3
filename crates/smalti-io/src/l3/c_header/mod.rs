//! A learned table as a C99 header: fixed-point tables, and a reference implementation that reads them.

mod contrast;
mod operations;

use std::fmt::{Display, Write};
use std::path::Path;

use smalti::l3::{FixedKernels, L3Error, Pipeline, Textures};
use smalti::sensor::{RawImage, RawSamples, Sampling};

use crate::error::At;
use crate::{IoError, write};
use contrast::Flat;
pub use operations::{Operations, operations};

/// The functions, which read the tables that are written before them. `@p@` and `@P@` stand for the prefix.
const REFERENCE: &str = include_str!("reference.h");
/// Width of lines of numbers.
const LINE: usize = 110;

/// Writes a pipeline as a header that needs nothing but C99's `stdint.h` and `stddef.h`: kernels of 16 bits, the thresholds of its
/// classes in digital numbers, and `static inline` functions that classify and render a pixel or a whole image by integers
/// alone. They are the reference to check firmware against, not fast code. A comment states the operations per pixel
/// ([`operations`]).
///
/// All names begin with `prefix`, constants with the same in capitals.
///
/// # Errors
/// When the prefix is no identifier of C, the pipeline is for raw images in volts, its kernels or thresholds have no place in the
/// numbers used (which takes values beyond any sensor's), or the file cannot be written.
pub fn write_c_header(path: &Path, pipeline: &Pipeline, prefix: &str) -> Result<(), IoError> {
    write::bytes(path, text(path, pipeline, prefix)?.as_bytes())
}

/// The prefix of names in a header: the name of its file.
#[must_use]
pub fn c_prefix(path: &Path) -> String {
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let plain: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if plain.starts_with(|c: char| c.is_ascii_alphabetic()) { plain } else { format!("l3_{plain}") }
}

fn text(path: &Path, pipeline: &Pipeline, prefix: &str) -> Result<String, IoError> {
    let letters = prefix.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_');
    if !letters || !prefix.starts_with(|c: char| c.is_ascii_lowercase()) || prefix.len() > 40 {
        let expected = "up to 40 small letters, digits and underscores, the first a letter";
        return Err(IoError::field(path, "the prefix of names", format!("'{prefix}'"), expected));
    }
    let (black, white) = (pipeline.black_level(), pipeline.white_level());
    if !(black >= 0.0 && white <= 65535.0 && white - black >= 1.0) {
        let found = format!("from {black} to {white}");
        return Err(IoError::field(path, "the range of samples", found, "digital numbers of 16 bits"));
    }
    let fixed = pipeline.fixed_kernels(black, white).at(path)?;
    let flat = contrast::flat(pipeline).ok_or_else(|| {
        IoError::field(path, "the contrast that is flat", "too large", "a limit within 64 bits")
    })?;
    let pairs = pipeline.axes().contrast_pairs();
    if pairs.iter().flat_map(|p| p.shift).any(|s| s.unsigned_abs() > contrast::MAX_SHIFT) {
        let found = format!("{:?} pixels", pairs.map(|p| p.shift));
        return Err(IoError::field(path, "the shift of the mosaic to itself", found, "at most 1000 pixels"));
    }
    let clip = first_clipped(pipeline).at(path)?;
    let mut out = Header { out: String::new(), upper: prefix.to_ascii_uppercase(), lower: prefix };
    out.comment(pipeline, &fixed);
    out.constants(pipeline, &fixed, &flat, clip);
    out.tables(pipeline, &fixed);
    out.out.push_str(&REFERENCE.replace("@p@", prefix).replace("@P@", &out.upper));
    out.line("\n#endif");
    Ok(out.out)
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

/// A header as it grows.
struct Header<'a> {
    out: String,
    lower: &'a str,
    upper: String,
}

impl Header<'_> {
    fn line(&mut self, text: impl Display) {
        // Writing to a string does not fail.
        let _ = writeln!(self.out, "{text}");
    }

    fn define(&mut self, name: &str, value: impl Display, what: &str) {
        let upper = self.upper.clone();
        let what = if what.is_empty() { String::new() } else { format!(" /* {what} */") };
        self.line(format!("#define {upper}_{name} {value}{what}"));
    }

    fn comment(&mut self, pipeline: &Pipeline, fixed: &FixedKernels) {
        let axes = pipeline.axes();
        let names = |of: &[String]| of.iter().map(|n| plain(n)).collect::<Vec<_>>().join(", ");
        let (outputs, channels) = (names(pipeline.outputs()), names(pipeline.channel_names()));
        let (black, white, side) = (pipeline.black_level(), pipeline.white_level(), axes.side());
        let textures = axes.textures().names().join(", ").replace('°', " degrees");
        let reduced =
            if fixed.sample_shift == 0 { "" } else { ", half of that rounded down from the middle" };
        let [coarse, fine] = shifts(fixed).map(|shift| f64::from(fixed.scale) / f64::from(1u32 << shift));
        let Operations { kernel_multiplications, multiplications, additions, comparisons, table_bytes } =
            operations(pipeline);
        let upper = self.upper.clone();
        self.line(format!(
            "\
#ifndef {upper}_H
#define {upper}_H

/* A learned image pipeline in fixed point, written by Smalti.

   Outputs: {outputs}. Channels of the mosaic, from 0: {channels}.
   Raw images: black level {black}, white level {white}. Patch: {side} x {side} pixels.
   Class = ((position * {upper}_SATURATIONS + saturation) * {upper}_LEVELS + level) * {upper}_TEXTURES + texture;
   textures: {textures}.
   Output = {upper}_SCALE * (offset + sum of kernel * d) / 2^shift, white = 1, d = sample - {upper}_BLACK{reduced}, of 16 bits;
   kernels are row by row; each class has the shift that uses their 16 bits, the same for all outputs.
   A step of the sum is {fine:.3e} to {coarse:.3e} of white.

   Operations per pixel as written below, indexing apart:
     {multiplications} multiplications ({kernel_multiplications} for the kernels), {additions} additions, {comparisons} comparisons; tables of {table_bytes} bytes.
   Neighbouring pixels share most sums of the classification. */

#include <stddef.h>
#include <stdint.h>
"
        ));
    }

    fn constants(&mut self, pipeline: &Pipeline, fixed: &FixedKernels, flat: &Flat, clip: u32) {
        let axes = pipeline.axes();
        let (rows, cols, side) = (axes.mosaic().rows(), axes.mosaic().cols(), axes.side());
        self.define("SIDE", side, "of the patch");
        self.define("HALF", side / 2, "");
        self.define("TILE_ROWS", rows, "of the mosaic");
        self.define("TILE_COLS", cols, "");
        self.define("MIN_ROWS", rows.max(side), "of an image");
        self.define("MIN_COLS", cols.max(side), "");
        self.define("SATURATIONS", pipeline.saturations().len(), "combinations of clipped channels");
        self.define("LEVELS", axes.level_count(), "");
        self.define("TEXTURES", axes.textures().count(), "");
        self.define("OUTPUTS", pipeline.outputs().len(), "");
        self.define("CLASSES", pipeline.classes().len(), "");
        self.define("TAPS", axes.taps(), "");
        self.define("BLACK", fixed.black, "what kernels take from samples");
        self.define("CLIP", format!("{clip}u"), "the least sample that counts as clipped");
        self.define("SAMPLE_SHIFT", fixed.sample_shift, "bits that samples lose after that");
        let [least_shift, most_shift] = shifts(fixed);
        self.define("MIN_SHIFT", least_shift, "binary places of the kernels that have the fewest");
        self.define("MAX_SHIFT", most_shift, "and the most");
        self.define("SCALE", format!("{:e}f", fixed.scale), "from sums / 2^shift to outputs");
        if axes.level_count() > 1 {
            self.define("CUT_SETS", axes.levels().len(), "1, or one for each position");
        }
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
        let (upper, mosaic) = (self.upper.clone(), axes.mosaic());
        self.line("\n/* The channel of every cell. */");
        self.table("uint8_t", "tile", &format!("[{upper}_TILE_ROWS * {upper}_TILE_COLS]"), mosaic.cells());
        self.line("/* Bit c: channel c is clipped somewhere in the patch. */");
        let masks: Vec<String> = pipeline.saturations().iter().map(|m| format!("{m}u")).collect();
        self.table("uint32_t", "saturation_masks", &format!("[{upper}_SATURATIONS]"), &masks);
        if axes.level_count() > 1 {
            self.line("/* A patch is above a level when the sum of its samples reaches the cut. */");
            let threshold = |cut: f32| {
                let mean = f64::from(cut) * (pipeline.white_level() - pipeline.black_level());
                // A conversion to an integer saturates.
                format!("{}u", ((mean + pipeline.black_level()) * axes.taps() as f64).ceil() as u32)
            };
            let sets: Vec<String> = axes
                .levels()
                .iter()
                .map(|l| l.cuts().iter().map(|&c| threshold(c)).collect::<Vec<_>>())
                .map(|cuts| braced(&cuts))
                .collect();
            self.table("uint32_t", "cuts", &format!("[{upper}_CUT_SETS][{upper}_LEVELS - 1]"), &sets);
        }
        if axes.textures() != Textures::None {
            let pairs = axes.contrast_pairs();
            self.line(
                "/* Differences between samples of like channels: shift, then first and last row and column they start from. */",
            );
            let rows = pairs.map(|p| braced([p.shift, p.rows, p.cols].concat()));
            self.table("int16_t", "pairs", "[2][6]", &rows);
            if axes.textures() == Textures::Oriented {
                let (ends, gradient) = contrast::gradients(&pairs);
                self.line("/* Of gradients: both ends of two differences around a pixel, and how rows and columns follow. */");
                self.table("int16_t", "edge_ends", "[2][4]", &ends.map(braced));
                self.table("int16_t", "edge_gradient", "[2][2]", &gradient.map(braced));
            }
        }
        let (taps, outputs) = (axes.taps(), pipeline.outputs().len());
        let of_outputs = |rows: Vec<String>| rows.chunks(outputs).map(braced).collect::<Vec<_>>();
        let kernels = of_outputs(fixed.weights.chunks(taps).map(braced).collect());
        let shape = format!("[{upper}_CLASSES][{upper}_OUTPUTS][{upper}_TAPS]");
        self.table("int16_t", "kernels", &shape, &kernels);
        let offsets = fixed.offsets.chunks(outputs).map(braced).collect::<Vec<_>>();
        self.table("int32_t", "offsets", &format!("[{upper}_CLASSES][{upper}_OUTPUTS]"), &offsets);
        self.line("/* Binary places of kernels and offsets. */");
        self.table("uint8_t", "shifts", &format!("[{upper}_CLASSES]"), &fixed.shifts);
    }

    fn table<T: Display>(&mut self, of: &str, name: &str, shape: &str, entries: &[T]) {
        let lower = self.lower;
        self.line(format!("static const {of} {lower}_{name}{shape} = {{"));
        let mut width = 0;
        for entry in entries {
            let entry = entry.to_string();
            if width > 0 && width + entry.len() + 2 > LINE {
                self.out.push('\n');
                width = 0;
            }
            self.out.push_str(if width == 0 { "    " } else { " " });
            self.out.push_str(&entry);
            self.out.push(',');
            width += entry.len() + 2;
        }
        self.line("\n};");
    }
}

/// The least shift and the largest.
fn shifts(fixed: &FixedKernels) -> [u8; 2] {
    [fixed.shifts.iter().min(), fixed.shifts.iter().max()].map(|shift| shift.copied().unwrap_or(0))
}

/// `{a, b, c}`.
fn braced<T: Display>(entries: impl AsRef<[T]>) -> String {
    let entries: Vec<String> = entries.as_ref().iter().map(T::to_string).collect();
    format!("{{{}}}", entries.join(", "))
}

/// A name as it may stand in a comment: letters that cannot end it, nor start another.
fn plain(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || " -_.+'".contains(c) { c } else { '_' };
    name.chars().map(safe).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_leave_their_comment() {
        assert_eq!(plain("X */ int y; /* \\\n°"), "X __ int y_ __ ___");
    }
}
