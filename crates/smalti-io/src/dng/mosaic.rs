//! The mosaic of a DNG: its fields, and what the user states where they are absent or wrong.

use std::path::Path;
use std::str::FromStr;

use smalti::sensor::{Mosaic, Sampling, cfa};

use super::samples::Shape;
use super::{Facts, LINEAR_RAW};
use crate::IoError;
use crate::error::At;
use crate::tiff::{Directory, tags};

/// Letters of the colour codes 0 to 6 of `CFAPlaneColor`.
const COLOR_LETTERS: [&str; 7] = ["R", "G", "B", "C", "M", "Y", "W"];
const CYAN: u8 = 3;
const WHITE: u8 = 6;

/// The mosaic of a raw file in the words of the user, for files that state none or a wrong one. Telephones label the samples of a
/// Quad Bayer sensor as Bayer, and so do tools for the RCCB sensors of cars.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StatedMosaic {
    /// The tile that begins at the first pixel of the active area.
    pub mosaic: Mosaic,
    /// Names of its channels.
    pub names: Vec<String>,
}

impl FromStr for StatedMosaic {
    type Err = String;

    /// From a name of the catalogue, or from rows of letters, one for each cell, as in `GR/BG`.
    fn from_str(text: &str) -> Result<Self, String> {
        let rows = match text.contains('/') {
            true => text.split('/').map(str::to_owned).collect(),
            false => cfa::pattern(text).map_err(|e| {
                format!("{e}; expected a name (smalti list cfas) or rows of letters such as GR/BG")
            })?,
        };
        let (mosaic, letters) = Mosaic::from_letters(&rows)
            .map_err(|e| format!("{e}; expected rows of equally many letters, such as GR/BG"))?;
        Ok(Self { mosaic, names: letters.into_iter().map(String::from).collect() })
    }
}

/// The code of every channel for `CFAPattern`: that of its letter where it has one of its own, else the next free
/// from 7 on. C is cyan beside green, magenta or yellow; otherwise it is clear, as in RCCB, which is DNG's white. `None`
/// when the codes, a byte each, do not suffice.
pub(super) fn color_codes(names: &[String]) -> Option<Vec<u8>> {
    let is_cyan = names.iter().any(|n| ["G", "M", "Y", "W"].contains(&n.as_str()));
    codes_with(names, if is_cyan { CYAN } else { WHITE })
}

/// As [`color_codes`], with the code of C.
fn codes_with(names: &[String], of_c: u8) -> Option<Vec<u8>> {
    let mut codes: Vec<u8> = Vec::with_capacity(names.len());
    let mut free = COLOR_LETTERS.len() as u8..=u8::MAX;
    for name in names {
        let known = COLOR_LETTERS.iter().position(|l| *l == name).map(|c| c as u8);
        let known = known.map(|c| if c == CYAN { of_c } else { c });
        codes.push(match known.filter(|c| !codes.contains(c)) {
            Some(code) => code,
            None => free.next()?,
        });
    }
    Some(codes)
}

/// The channels in the order of the planes in `CFAPlaneColor`. That is the order of the codes: LibRaw takes red,
/// green, blue in no other.
pub(super) fn plane_order(codes: &[u8]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..codes.len()).collect();
    order.sort_by_key(|&c| codes.get(c));
    order
}

/// The sampling of the image, and names for its channels: those that are stated, else those of DNG's own fields.
pub(super) fn sampling(
    ifd: &Directory,
    shape: Shape,
    stated: Option<&StatedMosaic>,
    path: &Path,
    notes: &mut Vec<String>,
) -> Result<(Sampling, Vec<String>), IoError> {
    let name = |code: &u8| match COLOR_LETTERS.get(usize::from(*code)) {
        Some(letter) => (*letter).to_owned(),
        None => format!("code {code}"),
    };
    let is_mosaic = ifd.integer(tags::PHOTOMETRIC) != Some(u64::from(LINEAR_RAW));
    if shape.planes != 1 && (is_mosaic || stated.is_some()) {
        let found = format!("{} samples a pixel", shape.planes);
        return Err(IoError::field(path, "the mosaic", found, "1"));
    }
    if let Some(StatedMosaic { mosaic, names }) = stated {
        return Ok((Sampling::Mosaic(mosaic.clone()), names.clone()));
    }
    if !is_mosaic {
        let names = match shape.planes {
            3 => (0..3).map(|c| name(&c)).collect(),
            n => (1..=n).map(|i| i.to_string()).collect(),
        };
        return Ok((Sampling::Full { channels: shape.planes }, names));
    }
    let layout = ifd.size(tags::CFA_LAYOUT).unwrap_or(1);
    if layout != 1 {
        return Err(IoError::field(path, "CFALayout", layout.to_string(), "1 (rectangular)"));
    }
    let dim = ifd.numbers(tags::CFA_REPEAT_PATTERN_DIM).unwrap_or_default();
    let (rows, cols) = match dim.as_slice() {
        [rows, cols] => (*rows as usize, *cols as usize),
        _ => return Err(IoError::field(path, "CFARepeatPatternDim", format!("{dim:?}"), "rows and columns")),
    };
    let pattern = ifd.bytes(tags::CFA_PATTERN).unwrap_or_default();
    let plane_colors = ifd.bytes(tags::CFA_PLANE_COLOR).unwrap_or(&[0, 1, 2]);
    // Planes that no cell has would be channels without samples. Some writers leave white out of the planes, or all of them.
    let mut used: Vec<u8> = plane_colors.iter().copied().filter(|c| pattern.contains(c)).collect();
    let mut unlisted: Vec<u8> = pattern.iter().copied().filter(|c| !plane_colors.contains(c)).collect();
    unlisted.sort_unstable();
    unlisted.dedup();
    if ifd.has(tags::CFA_PLANE_COLOR) && !unlisted.is_empty() {
        let letters = unlisted.iter().map(name).collect::<Vec<_>>().join(", ");
        notes.push(format!("CFAPattern has colours that CFAPlaneColor does not list: {letters}"));
    }
    used.extend(unlisted);
    let channel = |code: &u8| used.iter().position(|c| c == code).map_or(0, |c| c as u8);
    let mosaic = Mosaic::new(rows, cols, pattern.iter().map(channel).collect()).at(path)?;
    Ok((Sampling::Mosaic(mosaic), used.iter().map(name).collect()))
}

/// The sampling in the words of the description, and its channels in the order of DNG's planes. `None` where the
/// description is not of this mosaic: left behind by a program that changed the image.
pub(super) fn described(
    facts: Facts,
    stated: &Sampling,
    ifd: &Directory,
) -> Option<(Facts, Sampling, Vec<usize>)> {
    if facts.channels.len() != stated.channels() {
        return None;
    }
    match (stated, &facts.mosaic) {
        (Sampling::Full { channels }, None) => Some((facts, stated.clone(), (0..*channels).collect())),
        (Sampling::Mosaic(m), Some(rows)) => {
            let cells = rows.concat();
            let is_pattern = |codes: &Vec<u8>| {
                let pattern: Option<Vec<u8>> =
                    cells.iter().map(|c| codes.get(usize::from(*c)).copied()).collect();
                pattern.as_deref() == ifd.bytes(tags::CFA_PATTERN)
            };
            // Earlier versions wrote clear as cyan.
            let written = [color_codes(&facts.channels), codes_with(&facts.channels, CYAN)];
            let codes = written.into_iter().flatten().find(is_pattern)?;
            let same_tile = rows.len() == m.rows() && rows.iter().all(|r| r.len() == m.cols());
            let mosaic = same_tile.then(|| Mosaic::new(m.rows(), m.cols(), cells).ok())??;
            Some((facts, Sampling::Mosaic(mosaic), plane_order(&codes)))
        }
        _ => None,
    }
}
