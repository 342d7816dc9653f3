//! Samples that lie one after another.

use std::io;
use std::ops::Range;

use super::copy::{Strides, Target, gather};
use super::kind::{Kind, Sample};
use super::source::Source;
use super::{Axis, Bad, Part};

/// A cube of contiguous samples: their type, number and order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Raster {
    pub(crate) kind: Kind,
    pub(crate) big_endian: bool,
    pub(crate) bands: usize,
    pub(crate) rows: usize,
    pub(crate) cols: usize,
    /// The axes, slowest first.
    pub(crate) order: [Axis; 3],
}

/// Bytes that a thread reads, transposes and checks at once.
pub(super) const UNIT_BYTES: usize = 1 << 20;
/// Gaps up to this length are read rather than skipped.
const GAP_BYTES: usize = 1 << 12;

impl Raster {
    /// Bytes of all samples; `None` where that is no number.
    pub(crate) fn bytes(&self) -> Option<u64> {
        let samples = (self.bands as u64).checked_mul(self.rows as u64)?.checked_mul(self.cols as u64)?;
        samples.checked_mul(self.kind.size() as u64)
    }

    pub(super) fn len(&self, axis: Axis) -> usize {
        match axis {
            Axis::Band => self.bands,
            Axis::Row => self.rows,
            Axis::Col => self.cols,
        }
    }

    /// Whether rows run slower than columns.
    pub(super) fn by_rows(&self) -> bool {
        self.order.iter().find(|axis| **axis != Axis::Band) == Some(&Axis::Row)
    }

    /// Reads a part of the samples, which begin at `offset`, to where it belongs. It lies within them, and they within the
    /// source.
    pub(super) fn read_into<S: Sample>(
        &self,
        (source, offset): (&dyn Source, u64),
        part: &Part<'_>,
        mut target: Target<'_, '_, S>,
        buffer: &mut Vec<u8>,
    ) -> Result<(), Bad> {
        if let Some(memory) = source.memory() {
            let samples = usize::try_from(offset).ok().and_then(|at| memory.get(at..)).unwrap_or_default();
            let [_, len_b, len_c] = self.order.map(|axis| self.len(axis));
            let mut strides = self.strides([len_b * len_c, len_c, 1]);
            strides.first = strides.row * part.rows.start + strides.col * part.cols.start;
            let extent = (part.bands, part.rows.len(), part.cols.len());
            return gathered(gather(samples, (self.kind, self.big_endian), strides, extent, &mut target));
        }
        if let Some(first) = self.lies_as_planes(offset, part, &target) {
            for (band, plane) in part.bands.iter().zip(target.bands) {
                let len = part.rows.len() * self.cols;
                let out = plane.get_mut(..len).unwrap_or_default();
                let at = first + *band as u64 * (self.rows * self.cols * self.kind.size()) as u64;
                source.read_at(at, bytemuck::cast_slice_mut(out))?;
            }
            return Ok(());
        }
        // Bands that lie apart are read one by one: those that are not wanted are not read.
        let each = if self.order[0] == Axis::Band { 1 } else { part.bands.len().max(1) };
        for (bands, planes) in part.bands.chunks(each).zip(target.bands.chunks_mut(each)) {
            let part = Part { bands, rows: part.rows.clone(), cols: part.cols.clone() };
            let target = Target { bands: planes, width: target.width, col: target.col };
            self.read_windows((source, offset), &part, target, buffer)?;
        }
        Ok(())
    }

    /// Whether whole rows of planes lie in the file as they do in memory; then where those of the first band begin.
    fn lies_as_planes<S: Sample>(
        &self,
        offset: u64,
        part: &Part<'_>,
        target: &Target<'_, '_, S>,
    ) -> Option<u64> {
        let as_is = self.kind == S::KIND && self.big_endian == cfg!(target_endian = "big");
        let planes = self.order == [Axis::Band, Axis::Row, Axis::Col]
            || (self.bands == 1 && self.order == [Axis::Row, Axis::Col, Axis::Band]);
        let whole = target.width == self.cols && target.col == 0 && part.cols == (0..self.cols);
        let first = offset + (part.rows.start * self.cols * self.kind.size()) as u64;
        (as_is && planes && whole).then_some(first)
    }

    /// Reads a part by windows that fit into the cache.
    fn read_windows<S: Sample>(
        &self,
        from: (&dyn Source, u64),
        part: &Part<'_>,
        target: Target<'_, '_, S>,
        buffer: &mut Vec<u8>,
    ) -> Result<(), Bad> {
        let row = part.bands.len().max(1) * part.cols.len() * self.kind.size();
        // Cut across the slower of rows and columns.
        let by_rows = self.by_rows();
        let (len, line) = if by_rows {
            (part.rows.len(), row)
        } else {
            (part.cols.len(), part.bands.len().max(1) * part.rows.len() * self.kind.size())
        };
        let step = (UNIT_BYTES / line.max(1)).clamp(1, len.max(1));
        for first in (0..len).step_by(step) {
            let count = step.min(len - first);
            let (mut rows, mut cols, mut below, mut col) =
                (part.rows.clone(), part.cols.clone(), 0, target.col);
            if by_rows {
                rows = part.rows.start + first..part.rows.start + first + count;
                below = first * target.width;
            } else {
                cols = part.cols.start + first..part.cols.start + first + count;
                col += first;
            }
            let mut planes: Vec<&mut [S]> =
                target.bands.iter_mut().map(|p| p.get_mut(below..).unwrap_or_default()).collect();
            let window = Target { bands: &mut planes, width: target.width, col };
            self.read_window(from, &Part { bands: part.bands, rows, cols }, window, buffer)?;
        }
        Ok(())
    }

    fn read_window<S: Sample>(
        &self,
        (source, offset): (&dyn Source, u64),
        part: &Part<'_>,
        mut target: Target<'_, '_, S>,
        buffer: &mut Vec<u8>,
    ) -> Result<(), Bad> {
        let least = part.bands.iter().copied().min().unwrap_or(0);
        let bands = least..part.bands.iter().max().map_or(0, |b| b + 1);
        let size = self.kind.size();
        let wanted = |axis: Axis| match axis {
            Axis::Band => bands.clone(),
            Axis::Row => part.rows.clone(),
            Axis::Col => part.cols.clone(),
        };
        let [a, mut b, mut c] = self.order.map(wanted);
        let [_, len_b, len_c] = self.order.map(|axis| self.len(axis));
        if len_c * size <= GAP_BYTES {
            c = 0..len_c;
            if len_b * len_c * size <= GAP_BYTES {
                b = 0..len_b;
            }
        }
        buffer.resize(a.len() * b.len() * c.len() * size, 0);
        let at = |i: usize, j: usize, k: usize| {
            // Within the source, whose length is a number.
            let sample = (i as u64 * len_b as u64 + j as u64) * len_c as u64 + k as u64;
            offset + sample * size as u64
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
        let mut strides = self.strides([b.len() * c.len(), c.len(), 1]);
        let read = |axis: Axis| {
            let range = self.order.iter().zip([&a, &b, &c]).find(|(o, _)| **o == axis);
            range.map_or(0, |(_, r): (_, &Range<usize>)| r.start)
        };
        strides.first = (part.rows.start - read(Axis::Row)) * strides.row
            + (part.cols.start - read(Axis::Col)) * strides.col;
        let places: Vec<usize> = part.bands.iter().map(|band| band - read(Axis::Band)).collect();
        let extent = (places.as_slice(), part.rows.len(), part.cols.len());
        gathered(gather(buffer, (self.kind, self.big_endian), strides, extent, &mut target))
    }

    /// Distances along bands, rows and columns, from those along the axes as they lie.
    fn strides(&self, distances: [usize; 3]) -> Strides {
        let of = |axis: Axis| {
            self.order.iter().zip(distances).find(|(o, _)| **o == axis).map_or(0, |(_, distance)| distance)
        };
        Strides { first: 0, band: of(Axis::Band), row: of(Axis::Row), col: of(Axis::Col) }
    }
}

pub(super) fn gathered(done: Option<()>) -> Result<(), Bad> {
    done.ok_or_else(|| Bad::Io(io::ErrorKind::UnexpectedEof.into()))
}
