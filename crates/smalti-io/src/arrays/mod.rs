//! Arrays of numbers that lie in a file in one run or in chunks, and how they become the planes of a cube.

pub(crate) mod chunks;
pub(crate) mod element;
pub(crate) mod source;

use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use self::chunks::ChunkTable;
use self::element::{Element, Sample, Strided};
use self::source::{Source, bytes_at};
use crate::{IoError, Limits};

/// An array that is not read yet. Its axes are ordered as MATLAB does, the fastest first.
#[derive(Clone)]
pub(crate) struct Array {
    /// Length of every axis.
    pub(crate) dims: Vec<usize>,
    pub(crate) element: Element,
    pub(crate) storage: Storage,
}

/// Where the numbers are.
#[derive(Clone)]
pub(crate) enum Storage {
    /// One after another, from `offset` on.
    Run { source: Source, offset: u64 },
    /// In chunks, which may be compressed.
    Chunks(Arc<ChunkTable>),
}

/// Which axis of an array is which of a cube.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Axes {
    pub(crate) row: usize,
    pub(crate) col: usize,
    pub(crate) band: usize,
}

impl Axes {
    /// Rows × columns × bands, as MATLAB counts axes.
    pub(crate) const MATLAB: Self = Self { row: 0, col: 1, band: 2 };
    /// The numbers as they lie in the file.
    const AS_STORED: Self = Self { row: 1, col: 0, band: 2 };
}

// Blocks of a run that is not cut by bands: large enough for the disk, small enough for the cache.
const RUN_BYTES: usize = 1 << 20;

impl Array {
    /// Bytes that it declares to hold.
    pub(crate) fn bytes(&self) -> u64 {
        self.dims.iter().fold(self.element.size() as u64, |n, &d| n.saturating_mul(d as u64))
    }

    /// Its elements, if there are as few as a list of wavelengths or a number has. In the order of the file.
    pub(crate) fn values(&self, path: &Path, limits: Limits) -> Result<Vec<f64>, IoError> {
        self.planes(Axes::AS_STORED, path, limits, |_, _| Ok(()))
    }

    /// Length of an axis; those that are not there have one element.
    pub(crate) fn dim(&self, axis: usize) -> usize {
        self.dims.get(axis).copied().unwrap_or(1)
    }

    /// The planes of a cube, one band after another, in row order. Every plane is handed to `check`, with its number,
    /// as soon as it is complete.
    pub(crate) fn planes<S: Sample>(
        &self,
        axes: Axes,
        path: &Path,
        limits: Limits,
        check: impl Fn(usize, &mut [S]) -> Result<(), IoError> + Sync,
    ) -> Result<Vec<S>, IoError> {
        if self.dims.iter().skip(3).any(|&d| d != 1) {
            let found = format!("of {} axes", self.dims.len());
            return Err(IoError::field(path, "the array", found, "at most three axes"));
        }
        let dims = [self.dim(0), self.dim(1), self.dim(2)];
        if self.bytes() == 0 {
            return Ok(Vec::new());
        }
        let file_len = match &self.storage {
            Storage::Run { source, .. } => source.len(),
            Storage::Chunks(table) => table.source_len(),
        };
        // As it lies in the file, and as it is kept.
        let bytes = self
            .bytes()
            .max((self.bytes() / self.element.size() as u64).saturating_mul(size_of::<S>() as u64));
        limits.check(path, "the array", bytes, file_len)?;
        if let Storage::Run { source, offset } = &self.storage {
            let have = source.len().saturating_sub(*offset);
            if self.bytes() > have {
                let need = self.bytes();
                return Err(IoError::Truncated { path: path.to_owned(), what: "the array", need, have });
            }
        }
        let plane_len = dims[axes.row] * dims[axes.col];
        let mut planes = vec![S::default(); plane_len * dims[axes.band]];
        let blocks = self.blocks(dims, axes, path);
        // Where a block has bands for itself, they are filled by one thread while they are in its cache.
        let groups = dims[axes.band].div_ceil(blocks.dims[axes.band]);
        if groups >= rayon::current_num_threads() {
            planes.par_chunks_mut(plane_len * blocks.dims[axes.band]).enumerate().try_for_each_init(
                Vec::new,
                |buffer, (group, planes)| {
                    for index in blocks.indices(Some((axes.band, group))) {
                        let block = blocks.read(index, buffer)?;
                        for (k, plane) in planes.chunks_mut(plane_len).enumerate() {
                            block.copy(k, axes, dims, plane);
                        }
                    }
                    for (k, plane) in planes.chunks_mut(plane_len).enumerate() {
                        check(group * blocks.dims[axes.band] + k, plane)?;
                    }
                    Ok(())
                },
            )?;
            return Ok(planes);
        }
        let indices: Vec<[usize; 3]> = blocks.indices(None).collect();
        let mut buffers: Vec<Vec<u8>> = vec![Vec::new(); 4 * rayon::current_num_threads()];
        for indices in indices.chunks(buffers.len()) {
            let read: Vec<Block> = buffers
                .par_iter_mut()
                .zip(indices)
                .map(|(buffer, &index)| blocks.read(index, buffer))
                .collect::<Result<_, _>>()?;
            planes.par_chunks_mut(plane_len).enumerate().for_each(|(band, plane)| {
                for block in &read {
                    if let Some(k) = band.checked_sub(block.start[axes.band]) {
                        block.copy(k, axes, dims, plane);
                    }
                }
            });
        }
        planes.par_chunks_mut(plane_len).enumerate().try_for_each(|(band, plane)| check(band, plane))?;
        Ok(planes)
    }

    fn blocks<'a>(&'a self, dims: [usize; 3], axes: Axes, path: &'a Path) -> Blocks<'a> {
        let block = match &self.storage {
            Storage::Chunks(table) => table.chunk_dims,
            Storage::Run { .. } if axes.band == 2 => [dims[0], dims[1], 1],
            Storage::Run { .. } => {
                let slab = (dims[0] * dims[1] * self.element.size()).max(1);
                [dims[0], dims[1], (RUN_BYTES / slab).clamp(1, dims[2])]
            }
        };
        Blocks { array: self, of: dims, dims: block, path }
    }
}

/// An array cut into equal blocks; the last along an axis may be shorter.
struct Blocks<'a> {
    array: &'a Array,
    of: [usize; 3],
    dims: [usize; 3],
    path: &'a Path,
}

impl Blocks<'_> {
    /// Their places; where `only` says so, those at one place along an axis.
    fn indices(&self, only: Option<(usize, usize)>) -> impl Iterator<Item = [usize; 3]> {
        let range = |axis: usize| match only {
            Some((a, at)) if a == axis => at..at + 1,
            _ => 0..self.of[axis].div_ceil(self.dims[axis]),
        };
        let (x, y, z) = (range(0), range(1), range(2));
        z.flat_map(move |k| {
            let x = x.clone();
            y.clone().flat_map(move |j| x.clone().map(move |i| [i, j, k]))
        })
    }

    fn read<'b>(&'b self, index: [usize; 3], buffer: &'b mut Vec<u8>) -> Result<Block<'b>, IoError> {
        let start = [0, 1, 2].map(|a| index[a] * self.dims[a]);
        let extents = [0, 1, 2].map(|a| self.dims[a].min(self.of[a] - start[a]));
        let element = self.array.element;
        let (bytes, stored) = match &self.array.storage {
            // Chunks at the end of an axis are stored whole.
            Storage::Chunks(table) => (table.read(index, element, buffer, self.path)?, self.dims),
            Storage::Run { source, offset } => {
                // Blocks of a run span the two fast axes.
                let slab = self.of[0] * self.of[1] * element.size();
                let (from, len) = (offset + (start[2] * slab) as u64, extents[2] * slab);
                let bytes = match source.slice(from, len) {
                    Some(bytes) => bytes,
                    None => {
                        if buffer.len() != len {
                            *buffer = bytes_at(&**source, from, len as u64, "the array", self.path)?;
                        } else {
                            let io = |source| IoError::Read { path: self.path.to_owned(), source };
                            source.read_at(from, buffer).map_err(io)?;
                        }
                        &buffer[..]
                    }
                };
                (bytes, extents)
            }
        };
        Ok(Block { bytes, element, start, extents, stored })
    }
}

/// A part of an array, read.
struct Block<'a> {
    bytes: &'a [u8],
    element: Element,
    /// Its first place along every axis, and how many there are.
    start: [usize; 3],
    extents: [usize; 3],
    /// Elements along every axis as they lie in `bytes`.
    stored: [usize; 3],
}

impl Block<'_> {
    /// Copies its `k`th band, if it has one, to where it belongs in a plane.
    fn copy<S: Sample>(&self, k: usize, axes: Axes, of: [usize; 3], plane: &mut [S]) {
        if k >= self.extents[axes.band] {
            return;
        }
        let strides = [1, self.stored[0], self.stored[0] * self.stored[1]];
        let cols = of[axes.col];
        let from = Strided {
            start: k * strides[axes.band],
            strides: [strides[axes.row], strides[axes.col]],
            extents: [self.extents[axes.row], self.extents[axes.col]],
            to: [cols, 1],
        };
        let at = self.start[axes.row] * cols + self.start[axes.col];
        self.element.copy(self.bytes, from, plane.get_mut(at..).unwrap_or_default());
    }
}
