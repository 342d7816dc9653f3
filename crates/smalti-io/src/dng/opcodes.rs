//! Opcode lists (DNG 1.4, chapter 7): corrections that a developer carries out. Gain maps for lens shading are applied to the linear
//! raw image, because the picture of the camera is free of shading; other opcodes are named in a note.

use std::ops::Range;

use smalti::sensor::RawSamples;

use crate::tiff::{Directory, tags};

/// Names of the opcodes from 1 on.
const NAMES: [&str; 14] = [
    "WarpRectilinear",
    "WarpFisheye",
    "FixVignetteRadial",
    "FixBadPixelsConstant",
    "FixBadPixelsList",
    "TrimBounds",
    "MapTable",
    "MapPolynomial",
    GAIN_MAP,
    "DeltaPerRow",
    "DeltaPerColumn",
    "ScalePerRow",
    "ScalePerColumn",
    "WarpRectilinear2",
];
const GAIN_MAP: &str = "GainMap";

/// Applies the gain maps of the linear raw image to `samples` (of the active area, ordered plane, row, column, of the size
/// `(rows, cols, planes)`, with one black level). Notes tell what is applied and what is ignored.
pub(super) fn apply(
    ifd: &Directory,
    (rows, cols, planes): (usize, usize, usize),
    samples: &mut RawSamples,
    black: f64,
    notes: &mut Vec<String>,
) {
    for (tag, name, when) in [
        (tags::OPCODE_LIST_1, "OpcodeList1", "the samples as stored"),
        (tags::OPCODE_LIST_2, "OpcodeList2", "the linear raw image"),
        (tags::OPCODE_LIST_3, "OpcodeList3", "the demosaicked image"),
    ] {
        let Some(list) = ifd.bytes(tag) else { continue };
        let Some(opcodes) = opcodes(list) else {
            notes.push(format!("{name} is damaged and ignored"));
            continue;
        };
        let (mut ignored, mut maps) = (Vec::new(), Vec::new());
        for (opcode, data) in opcodes {
            match GainMap::of(data).filter(|_| opcode == GAIN_MAP && tag == tags::OPCODE_LIST_2) {
                Some(map) => maps.push(map),
                None if ignored.contains(&opcode) => {}
                None => ignored.push(opcode),
            }
        }
        if !maps.is_empty() {
            let count = maps.len();
            notes.push(format!(
                "{name}: {count} gain map(s) for the shading of the lens are applied to the samples"
            ));
        }
        for map in &maps {
            match samples {
                RawSamples::Digital(v) => map.multiply(v, [rows, cols, planes], |v, gain| {
                    *v = (black + (f64::from(*v) - black) * gain).round() as u16;
                }),
                RawSamples::Analog(v) => map.multiply(v, [rows, cols, planes], |v, gain| {
                    *v = (black + (f64::from(*v) - black) * gain) as f32;
                }),
            }
        }
        if !ignored.is_empty() {
            let opcodes = ignored.join(", ");
            notes.push(format!("{name} is ignored, corrections of {when}: {opcodes}"));
        }
    }
}

/// The opcodes of a list, each by its name, with its parameters. `None` where the list ends too early.
fn opcodes(list: &[u8]) -> Option<Vec<(String, &[u8])>> {
    let mut bytes = Bytes(list);
    let count = bytes.integer()?;
    // Each opcode takes 16 bytes and its parameters.
    let mut found = Vec::new();
    for _ in 0..count {
        let [number, _version, _flags, len] =
            [bytes.integer()?, bytes.integer()?, bytes.integer()?, bytes.integer()?];
        let name = (number as usize).checked_sub(1).and_then(|i| NAMES.get(i));
        let name = name.map_or_else(|| format!("opcode {number}"), |n| (*n).to_owned());
        found.push((name, bytes.take(len as usize)?));
    }
    Some(found)
}

/// Parameters of an opcode, which are big-endian in every file.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, len: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(len)?;
        self.0 = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    fn integer(&mut self) -> Option<u32> {
        self.array().map(u32::from_be_bytes)
    }

    fn double(&mut self) -> Option<f64> {
        self.array().map(f64::from_be_bytes)
    }
}

/// Gains on a grid of points, for some samples of an area.
struct GainMap {
    rows: Range<usize>,
    cols: Range<usize>,
    planes: Range<usize>,
    /// Every how many rows, and columns, there is a sample to multiply.
    pitch: [usize; 2],
    /// Points down, across and in the planes of the map.
    points: [usize; 3],
    /// Distance of points, and place of the first, down and across in heights and widths of the image.
    spacing: [f64; 2],
    origin: [f64; 2],
    /// Ordered row, column, plane.
    gains: Vec<f64>,
}

impl GainMap {
    /// `None` where the parameters are damaged.
    fn of(data: &[u8]) -> Option<Self> {
        let mut bytes = Bytes(data);
        let mut size = || bytes.integer().map(|n| n as usize);
        let [top, left, bottom, right, plane, planes] =
            [size()?, size()?, size()?, size()?, size()?, size()?];
        let (pitch, [down, across]) = ([size()?, size()?], [size()?, size()?]);
        let (spacing, origin) = ([bytes.double()?, bytes.double()?], [bytes.double()?, bytes.double()?]);
        let points = [down, across, bytes.integer()? as usize];
        let count = points.iter().try_fold(1usize, |n, &k| n.checked_mul(k))?;
        let gains: Vec<f64> =
            bytes.0.as_chunks().0.iter().map(|b| f64::from(f32::from_be_bytes(*b))).collect();
        let is_whole = count > 0 && gains.len() == count && gains.iter().all(|g| g.is_finite() && *g >= 0.0);
        let is_grid = pitch.iter().all(|p| *p > 0)
            && spacing.iter().zip(&points).all(|(s, n)| s.is_finite() && (*s > 0.0 || *n == 1))
            && origin.iter().all(|o| o.is_finite());
        (is_whole && is_grid).then(|| Self {
            rows: top..bottom,
            cols: left..right,
            planes: plane..plane.saturating_add(planes),
            pitch,
            points,
            spacing,
            origin,
            gains,
        })
    }

    /// Calls `multiply(sample, gain)` for every sample that the map is for, of an image of the size `[rows, cols, planes]`.
    fn multiply<T>(
        &self,
        samples: &mut [T],
        [rows, cols, planes]: [usize; 3],
        multiply: impl Fn(&mut T, f64),
    ) {
        let down: Vec<Between> = (0..rows).map(|r| self.between(0, r, rows)).collect();
        let across: Vec<Between> = (0..cols).map(|c| self.between(1, c, cols)).collect();
        let is_meant = |at: usize, range: &Range<usize>, pitch: usize| {
            range.contains(&at) && (at - range.start).is_multiple_of(pitch)
        };
        for (i, line) in samples.chunks_exact_mut(cols).enumerate().take(rows * planes) {
            let (plane, row) = (i / rows, i % rows);
            if !self.planes.contains(&plane) || !is_meant(row, &self.rows, self.pitch[0]) {
                continue;
            }
            let of_map = (plane - self.planes.start).min(self.points[2] - 1);
            for (col, (sample, across)) in line.iter_mut().zip(&across).enumerate() {
                if is_meant(col, &self.cols, self.pitch[1]) {
                    multiply(sample, self.gain(&down[row], across, of_map));
                }
            }
        }
    }

    /// The points beside a row, or column, of an image with `len` of them; those at the edges also hold beyond.
    fn between(&self, axis: usize, at: usize, len: usize) -> Between {
        let place = ((at as f64 + 0.5) / len as f64 - self.origin[axis]) / self.spacing[axis];
        let last = self.points[axis] - 1;
        // A single point has no spacing.
        let place = if last == 0 { 0.0 } else { place.clamp(0.0, last as f64) };
        let first = (place as usize).min(last.saturating_sub(1));
        Between { points: [first, (first + 1).min(last)], share: place - first as f64 }
    }

    fn gain(&self, down: &Between, across: &Between, plane: usize) -> f64 {
        let [_, points_across, planes] = self.points;
        let point = |r: usize, c: usize| {
            self.gains.get((r * points_across + c) * planes + plane).copied().unwrap_or(1.0)
        };
        let along = |r: usize| across.mix(across.points.map(|c| point(r, c)));
        down.mix(down.points.map(along))
    }
}

/// A place between two points.
struct Between {
    points: [usize; 2],
    /// The share of the second.
    share: f64,
}

impl Between {
    fn mix(&self, [first, second]: [f64; 2]) -> f64 {
        first + self.share * (second - first)
    }
}
