//! A learned table as a C99 header: its tables in integers or in single precision, and a reference implementation that reads them.

mod contrast;
mod fixed;
mod float;
mod operations;
mod refinement;

use std::fmt::{Display, Write};
use std::path::Path;

use smalti::l3::{Pipeline, Textures};

use crate::{IoError, write};
pub use operations::{Operations, operations};

/// Types and functions that read a raw image. `@p@` and `@P@` stand for the prefix.
const RAW: &str = include_str!("c/raw.h");
/// Width of lines of numbers.
const LINE: usize = 110;

/// The numbers with which a header computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CArithmetic {
    /// Integers alone: kernels of 16 bits, sums of 32.
    Integers,
    /// `float`, with the order of operations and so the bits of [`Pipeline::render_raw`].
    SinglePrecision,
}

/// Writes a pipeline as a header that needs nothing but C99's `stdint.h` and `stddef.h`: its tables, and `static inline` functions that
/// classify and render a pixel or a whole image. They are the reference to check firmware against, not fast code.
///
/// - In integers: kernels of 16 bits, the thresholds of classes in digital numbers. Its sums are those of [`Pipeline::render_fixed`]. A comment
///   states the operations per pixel ([`operations`]).
/// - In single precision: results have the bits of [`Pipeline::render_raw`], where the compiler evaluates `float` as such and does not
///   contract products and sums, which the header forbids as far as C99 can.
///
/// The header of a pipeline of best quality has both stages. The second one keeps the latest rows of its pictures in memory that the caller
/// gives: `WORK(cols)` numbers. In integers it is that of [`FixedRefinement`](smalti::l3::FixedRefinement), bit for bit, on the sums of the first
/// stage.
///
/// All names begin with `prefix`, constants with the same in capitals.
///
/// # Errors
/// When the prefix is no identifier of C, the pipeline is for raw images in volts, its kernels or thresholds have no place in the
/// integers used (which takes values beyond any sensor's), or the file cannot be written.
pub fn write_c_header(
    path: &Path,
    pipeline: &Pipeline,
    prefix: &str,
    arithmetic: CArithmetic,
) -> Result<(), IoError> {
    write::bytes(path, text(path, pipeline, prefix, arithmetic)?.as_bytes())
}

/// The prefix of names in a header: the name of its file.
#[must_use]
pub fn c_prefix(path: &Path) -> String {
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let plain: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if plain.starts_with(|c: char| c.is_ascii_alphabetic()) { plain } else { format!("l3_{plain}") }
}

fn text(path: &Path, pipeline: &Pipeline, prefix: &str, arithmetic: CArithmetic) -> Result<String, IoError> {
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
    let pairs = pipeline.axes().contrast_pairs();
    if pairs.iter().flat_map(|p| p.shift).any(|s| s.unsigned_abs() > contrast::MAX_SHIFT) {
        let found = format!("{:?} pixels", pairs.map(|p| p.shift));
        return Err(IoError::field(path, "the shift of the mosaic to itself", found, "at most 1000 pixels"));
    }
    let mut header = Header { out: String::new(), upper: prefix.to_ascii_uppercase(), lower: prefix };
    match arithmetic {
        CArithmetic::Integers => header.integers(path, pipeline)?,
        CArithmetic::SinglePrecision => header.single_precision(pipeline),
    }
    header.line("\n#endif");
    Ok(header.out)
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

    /// Functions that read what is written before them.
    fn code(&mut self, code: &str) {
        self.out.push_str(&code.replace("@p@", self.lower).replace("@P@", &self.upper));
    }

    fn define(&mut self, name: &str, value: impl Display, what: &str) {
        let upper = self.upper.clone();
        let what = if what.is_empty() { String::new() } else { format!(" /* {what} */") };
        self.line(format!("#define {upper}_{name} {value}{what}"));
    }

    /// What a table is for: the beginning of the comment that a header begins with.
    fn about(&mut self, pipeline: &Pipeline, numbers: &str) {
        let axes = pipeline.axes();
        let names = |of: &[String]| of.iter().map(|n| plain(n)).collect::<Vec<_>>().join(", ");
        let (outputs, channels) = (names(pipeline.outputs()), names(pipeline.channel_names()));
        let (black, white, side) = (pipeline.black_level(), pipeline.white_level(), axes.side());
        let textures = axes.textures().names().join(", ").replace('°', " degrees");
        let quality = pipeline.quality().name();
        let upper = self.upper.clone();
        self.line(format!(
            "\
#ifndef {upper}_H
#define {upper}_H

/* A learned image pipeline in {numbers}, of quality {quality}, written by Smalti.

   Outputs: {outputs}. Channels of the mosaic, from 0: {channels}.
   Raw images: black level {black}, white level {white}. Patch: {side} x {side} pixels.
   Class = ((position * {upper}_SATURATIONS + saturation) * {upper}_LEVELS + level) * {upper}_TEXTURES + texture;
   textures: {textures}."
        ));
    }

    /// The sizes of the axes.
    fn axes(&mut self, pipeline: &Pipeline) {
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
        if axes.level_count() > 1 {
            self.define("CUT_SETS", axes.levels().len(), "1, or one for each position");
        }
    }

    /// The tile and the clipped channels.
    fn mosaic(&mut self, pipeline: &Pipeline) {
        let upper = self.upper.clone();
        self.line("\n/* The channel of every cell. */");
        let cells = pipeline.axes().mosaic().cells();
        self.table("uint8_t", "tile", &format!("[{upper}_TILE_ROWS * {upper}_TILE_COLS]"), cells);
        self.line("/* Bit c: channel c is clipped somewhere in the patch. */");
        let masks: Vec<String> = pipeline.saturations().iter().map(|m| format!("{m}u")).collect();
        self.table("uint32_t", "saturation_masks", &format!("[{upper}_SATURATIONS]"), &masks);
    }

    /// The cuts between levels, each as a constant of C.
    fn cuts(&mut self, pipeline: &Pipeline, of: &str, constant: impl Fn(f32) -> String) {
        let levels = pipeline.axes().levels();
        let sets: Vec<String> = levels
            .iter()
            .map(|l| braced(l.cuts().iter().map(|&c| constant(c)).collect::<Vec<_>>()))
            .collect();
        let upper = self.upper.clone();
        self.table(of, "cuts", &format!("[{upper}_CUT_SETS][{upper}_LEVELS - 1]"), &sets);
    }

    /// Which samples are compared for the texture.
    fn pairs(&mut self, pipeline: &Pipeline) {
        let (textures, pairs) = (pipeline.axes().textures(), pipeline.axes().contrast_pairs());
        if textures == Textures::None {
            return;
        }
        self.line(
            "/* Differences between samples of like channels: shift, then first and last row and column they start from. */",
        );
        let rows = pairs.map(|p| braced([p.shift, p.rows, p.cols].concat()));
        self.table("int16_t", "pairs", "[2][6]", &rows);
        if textures == Textures::Oriented {
            self.line(
                "/* Of gradients: both ends of two differences around a pixel, and how rows and columns follow. */",
            );
            self.table("int16_t", "edge_ends", "[2][4]", &contrast::ends(&pairs).map(braced));
        }
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
