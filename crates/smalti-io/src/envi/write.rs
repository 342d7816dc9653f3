//! Writing ENVI.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::read::{DATA_EXTENSIONS, header_beside};
use crate::scene_file::blocks::{by_line, by_pixel, row_blocks, write_planes};
use crate::scene_file::facts::Facts;
use crate::scene_file::tiles::{Header, Tiles};
use crate::text::ascii_json;
use crate::{IoError, Quantity, write};

/// The order of samples in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interleave {
    /// Band sequential: band, row, column.
    #[default]
    Bsq,
    /// Band interleaved by line: row, band, column.
    Bil,
    /// Band interleaved by pixel: row, column, band.
    Bip,
}

impl Interleave {
    /// How headers call it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Bsq => "bsq",
            Self::Bil => "bil",
            Self::Bip => "bip",
        }
    }
}

/// Writes 32-bit samples, little-endian, and their header. `path` is either: beside `NAME.hdr` the samples are `NAME.img`; beside
/// samples of any other name the header takes the extension `.hdr`. The image is read and written by rows, so that it need not
/// fit into memory.
///
/// Facts that ENVI has no key for are written as JSON in the key `smalti`, so that [`super::open`] returns an equal value.
///
/// # Errors
/// When a file cannot be written, or the image cannot be read.
pub fn write(path: &Path, image: &dyn Tiles, interleave: Interleave) -> Result<(), IoError> {
    let (header_path, data_path) = names(path);
    let header = image.header();
    write::atomic(&data_path, |out| {
        let io = IoError::writing(&data_path);
        let lines = match interleave {
            Interleave::Bsq => return write_planes(out, 0, image, &data_path, |_, _| {}),
            Interleave::Bil => by_line,
            Interleave::Bip => by_pixel,
        };
        for block in row_blocks(image) {
            let samples = lines(&image.read(block)?);
            out.write_all(bytemuck::cast_slice(&samples)).map_err(io)?;
        }
        Ok(())
    })?;
    write::bytes(&header_path, text(header, interleave).as_bytes())
}

/// Header and samples.
fn names(path: &Path) -> (PathBuf, PathBuf) {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("hdr")) {
        // The samples of an earlier file of this name are replaced, whatever they are called.
        let stem = path.with_extension("");
        let beside = DATA_EXTENSIONS.map(|e| path.with_extension(e)).into_iter();
        let mut there = std::iter::once(stem).chain(beside).filter(|p| p.is_file());
        let data = there.next().unwrap_or_else(|| path.with_extension("img"));
        return (path.to_owned(), data);
    }
    let header = header_beside(path).unwrap_or_else(|| path.with_extension("hdr"));
    (header, path.to_owned())
}

fn text(header: &Header, interleave: Interleave) -> String {
    let list = |items: Vec<String>| format!("{{\n {}}}", items.join(",\n "));
    let nm: Vec<String> = header.wavelengths_nm.iter().map(f64::to_string).collect();
    let names = nm.iter().map(|nm| format!("{nm} nm")).collect();
    let mut out = String::from("ENVI\n");
    // A string takes all that is written to it.
    let _ = write!(
        out,
        "samples = {}\nlines = {}\nbands = {}\nheader offset = 0\nfile type = ENVI Standard\ndata type = 4\n\
         interleave = {}\nbyte order = 0\n",
        header.cols,
        header.rows,
        header.wavelengths_nm.len(),
        interleave.name(),
    );
    if header.quantity == Quantity::Reflectance {
        out += "reflectance scale factor = 1\n";
    }
    let _ = write!(
        out,
        "data units = {}\nwavelength units = Nanometers\nwavelength = {}\nband names = {}\nsmalti = {}\n",
        header.quantity.name(),
        list(nm),
        list(names),
        ascii_json(&Facts::of(header)),
    );
    out
}
