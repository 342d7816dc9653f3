//! A cube of samples as it lies in a file: any type, byte order and order of axes, read by windows.
//!
//! [`Raster`] is one block of samples; ENVI, NumPy and the strips and tiles of TIFF are made of them. What is read is spread over
//! units of about a mebibyte, each read, transposed and checked by one thread while it is in the cache.

mod kind;
mod memory;
mod source;
mod values;

use std::io;
use std::ops::Range;

use rayon::prelude::*;

pub(crate) use kind::{Kind, Strides, Target, gather};
pub(crate) use memory::zeros;
pub(crate) use source::{FileSource, Source, part};
pub(crate) use values::{BadSample, Values};

/// Axes of a cube.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Axis {
    Band,
    Row,
    Col,
}

/// A part of a cube: the bands of the file that are wanted, in the order of the planes they become, its rows and columns.
#[derive(Debug, Clone)]
pub(crate) struct Part<'a> {
    pub(crate) bands: &'a [usize],
    pub(crate) rows: Range<usize>,
    pub(crate) cols: Range<usize>,
}

/// Why a part cannot be had.
#[derive(Debug)]
pub(crate) enum Bad {
    /// The file cannot be read.
    Io(io::Error),
    /// A sample is not what it should be.
    Sample(BadSample),
    /// A compressed block is not what it should be.
    Block(String),
}

impl From<io::Error> for Bad {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Samples of a block, one after another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Raster {
    /// Of the first sample in the file.
    pub(crate) offset: u64,
    pub(crate) kind: Kind,
    pub(crate) big_endian: bool,
    pub(crate) bands: usize,
    pub(crate) rows: usize,
    pub(crate) cols: usize,
    /// The axes, slowest first.
    pub(crate) order: [Axis; 3],
}

/// Bytes that a thread reads, transposes and checks at once.
const UNIT_BYTES: usize = 1 << 20;

impl Raster {
    /// Bytes of all samples; `None` where that is no number.
    pub(crate) fn bytes(&self) -> Option<u64> {
        let samples = (self.bands as u64).checked_mul(self.rows as u64)?.checked_mul(self.cols as u64)?;
        samples.checked_mul(self.kind.size() as u64)
    }

    fn len(&self, axis: Axis) -> usize {
        match axis {
            Axis::Band => self.bands,
            Axis::Row => self.rows,
            Axis::Col => self.cols,
        }
    }

    /// Planes of a part: band, row, column. It lies within the raster, and that within the source.
    pub(crate) fn read(
        &self,
        source: &dyn Source,
        part: &Part<'_>,
        values: &Values<'_>,
    ) -> Result<Vec<f32>, Bad> {
        let (rows, cols) = (part.rows.len(), part.cols.len());
        let mut data = zeros(part.bands.len() * rows * cols);
        let row_bytes = (self.bands * cols * self.kind.size()).max(1);
        // Where rows run fastest, a few of them would be read in small pieces: bands are shared out instead.
        let fastest_is_row = self.order[2] == Axis::Row;
        let group = if fastest_is_row { rows } else { (UNIT_BYTES / row_bytes).clamp(1, rows.max(1)) };
        let mut units = split(&mut data, rows, cols, group, fastest_is_row);
        let read = |buffer: &mut Vec<u8>, unit: &mut Unit<'_>| {
            let bands = part.bands.get(unit.bands.clone()).unwrap_or_default();
            let first = part.rows.start + unit.first_row;
            let rows = first..first + unit.rows;
            let target = Target { bands: &mut unit.planes, width: cols, col: 0 };
            self.read_into(
                source,
                &Part { bands, rows: rows.clone(), cols: part.cols.clone() },
                target,
                buffer,
            )?;
            for (band, plane) in bands.iter().zip(&mut unit.planes) {
                values.check(*band, plane, (first, part.cols.start, cols)).map_err(Bad::Sample)?;
            }
            Ok(())
        };
        // All are done before the first error in their order is told: the same for any number of threads.
        let done: Vec<Result<(), Bad>> = units.par_iter_mut().map_init(Vec::new, read).collect();
        done.into_iter().collect::<Result<(), Bad>>()?;
        Ok(data)
    }

    /// Reads a part to where it belongs, without checking its values.
    pub(crate) fn read_into(
        &self,
        source: &dyn Source,
        part: &Part<'_>,
        target: Target<'_, '_>,
        buffer: &mut Vec<u8>,
    ) -> Result<(), Bad> {
        if let Some(first) = self.lies_as_planes(part, &target) {
            for (band, plane) in part.bands.iter().zip(target.bands) {
                let len = part.rows.len() * self.cols;
                let out = plane.get_mut(..len).unwrap_or_default();
                let at = first + (*band as u64 * self.rows as u64 * self.cols as u64) * 4;
                source.read_at(at, bytemuck::cast_slice_mut(out))?;
            }
            return Ok(());
        }
        if self.order[0] == Axis::Band {
            // Each band by itself: those that are not wanted are not read.
            for (band, plane) in part.bands.iter().zip(target.bands) {
                let of_band =
                    Target { bands: std::slice::from_mut(plane), width: target.width, col: target.col };
                self.read_block(source, *band..band + 1, (&[0], part), of_band, buffer)?;
            }
            return Ok(());
        }
        self.read_block(source, 0..self.bands, (part.bands, part), target, buffer)
    }

    /// Whether whole rows of planes lie in the file as they do in memory; then where those of the first band begin.
    fn lies_as_planes(&self, part: &Part<'_>, target: &Target<'_, '_>) -> Option<u64> {
        let as_is = self.kind == Kind::F32 && self.big_endian == cfg!(target_endian = "big");
        let planes = self.order == [Axis::Band, Axis::Row, Axis::Col]
            || (self.bands == 1 && self.order == [Axis::Row, Axis::Col, Axis::Band]);
        let whole = target.width == self.cols && target.col == 0 && part.cols == (0..self.cols);
        let first = self.offset + part.rows.start as u64 * self.cols as u64 * 4;
        (as_is && planes && whole).then_some(first)
    }

    fn read_block(
        &self,
        source: &dyn Source,
        bands: Range<usize>,
        (places, part): (&[usize], &Part<'_>),
        mut target: Target<'_, '_>,
        buffer: &mut Vec<u8>,
    ) -> Result<(), Bad> {
        let range = |axis: Axis| match axis {
            Axis::Band => bands.clone(),
            Axis::Row => part.rows.clone(),
            Axis::Col => part.cols.clone(),
        };
        let [a, b, c] = self.order.map(range);
        let [_, len_b, len_c] = self.order.map(|axis| self.len(axis));
        let size = self.kind.size();
        buffer.resize(a.len() * b.len() * c.len() * size, 0);
        let at = |i: usize, j: usize, k: usize| {
            // Within the source, whose length is a number.
            let sample = (i as u64 * len_b as u64 + j as u64) * len_c as u64 + k as u64;
            self.offset + sample * size as u64
        };
        // Runs that lie together are read together.
        if c.len() == len_c && b.len() == len_b {
            source.read_at(at(a.start, 0, 0), buffer)?;
        } else if c.len() == len_c {
            let run = b.len() * c.len() * size;
            for (i, out) in a.clone().zip(buffer.chunks_mut(run.max(1))) {
                source.read_at(at(i, b.start, 0), out)?;
            }
        } else {
            let runs = a.clone().flat_map(|i| b.clone().map(move |j| (i, j)));
            for ((i, j), out) in runs.zip(buffer.chunks_mut((c.len() * size).max(1))) {
                source.read_at(at(i, j, c.start), out)?;
            }
        }
        let stride = |axis: Axis| match self.order.iter().position(|o| *o == axis) {
            Some(0) => b.len() * c.len(),
            Some(1) => c.len(),
            _ => 1,
        };
        let strides = Strides { band: stride(Axis::Band), row: stride(Axis::Row), col: stride(Axis::Col) };
        let extent = (places, part.rows.len(), part.cols.len());
        gather(buffer, (self.kind, self.big_endian), strides, extent, &mut target)
            .ok_or_else(|| Bad::Io(io::ErrorKind::UnexpectedEof.into()))
    }
}

/// Rows of some planes that one thread fills.
pub(crate) struct Unit<'a> {
    pub(crate) bands: Range<usize>,
    pub(crate) first_row: usize,
    pub(crate) rows: usize,
    pub(crate) planes: Vec<&'a mut [f32]>,
}

/// Planes of `rows` × `cols` by groups of rows: of all bands, or each band by itself.
pub(crate) fn split(
    data: &mut [f32],
    rows: usize,
    cols: usize,
    group: usize,
    by_band: bool,
) -> Vec<Unit<'_>> {
    let (group, plane) = (group.max(1), rows * cols);
    let mut units: Vec<Unit<'_>> = Vec::new();
    let groups = rows.div_ceil(group);
    for (band, plane) in data.chunks_mut(plane.max(1)).enumerate() {
        for (i, part) in plane.chunks_mut((group * cols).max(1)).enumerate() {
            let rows = part.len() / cols.max(1);
            match units.get_mut(i).filter(|_| !by_band) {
                Some(unit) => {
                    unit.bands.end = band + 1;
                    unit.planes.push(part);
                }
                None => units.push(Unit {
                    bands: band..band + 1,
                    first_row: (i % groups.max(1)) * group,
                    rows,
                    planes: vec![part],
                }),
            }
        }
    }
    units
}

#[cfg(test)]
mod tests;
