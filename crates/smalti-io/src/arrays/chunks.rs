//! Arrays in chunks, each of them deflated on its own.

use std::collections::HashMap;
use std::path::Path;

use flate2::{Decompress, FlushDecompress, Status};

use super::element::Element;
use super::source::Source;
use crate::IoError;

/// Where the chunks of an array are.
pub(crate) struct ChunkTable {
    source: Source,
    /// Elements of a chunk along every axis, fastest first.
    pub(crate) chunk_dims: [usize; 3],
    /// Chunks along the first two axes.
    counts: [usize; 2],
    chunks: HashMap<usize, StoredChunk>,
    filters: Vec<Filter>,
}

/// A chunk as it lies in the file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StoredChunk {
    pub(crate) address: u64,
    pub(crate) bytes: u64,
    /// Bit `i` says that the filter `i` was not used.
    pub(crate) skipped: u32,
}

/// What is done to a chunk when it is written, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Filter {
    /// All first bytes of its elements, then all second bytes, …
    Shuffle,
    /// zlib.
    Deflate,
}

impl ChunkTable {
    /// Chunks by the place of their first elements. `None` where one is missing or lies outside, so that the array has
    /// elements which were never written.
    pub(crate) fn new(
        source: Source,
        dims: [usize; 3],
        chunk_dims: [usize; 3],
        filters: Vec<Filter>,
        stored: impl IntoIterator<Item = ([usize; 3], StoredChunk)>,
    ) -> Option<Self> {
        if chunk_dims.contains(&0) {
            return None;
        }
        let counts = [0, 1, 2].map(|a| dims[a].div_ceil(chunk_dims[a]));
        let expected = counts[0].checked_mul(counts[1])?.checked_mul(counts[2])?;
        let mut table =
            Self { source, chunk_dims, counts: [counts[0], counts[1]], chunks: HashMap::new(), filters };
        for (start, chunk) in stored {
            let index = [0, 1, 2].map(|a| start[a] / chunk_dims[a]);
            if (0..3).all(|a| index[a] < counts[a]) {
                table.chunks.insert(table.key(index), chunk);
            }
        }
        (table.chunks.len() == expected).then_some(table)
    }

    pub(crate) fn source_len(&self) -> u64 {
        self.source.len()
    }

    fn key(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    fn chunk_bytes(&self, element: Element) -> u64 {
        self.chunk_dims.iter().fold(element.size() as u64, |n, &d| n.saturating_mul(d as u64))
    }

    /// The elements of a chunk, all of them.
    pub(crate) fn read<'b>(
        &'b self,
        index: [usize; 3],
        element: Element,
        buffer: &'b mut Vec<u8>,
        path: &Path,
    ) -> Result<&'b [u8], IoError> {
        let damaged = |message: &str| IoError::Decode {
            path: path.to_owned(),
            format: "HDF5",
            message: format!("the chunk {index:?} {message}"),
        };
        let chunk = self.chunks.get(&self.key(index)).ok_or_else(|| damaged("is missing"))?;
        let need = self.chunk_bytes(element) as usize;
        let have = self.source.len().saturating_sub(chunk.address);
        if chunk.bytes > have {
            let (what, need) = ("a chunk", chunk.bytes);
            return Err(IoError::Truncated { path: path.to_owned(), what, need, have });
        }
        let len = chunk.bytes as usize;
        let io = |source| IoError::Read { path: path.to_owned(), source };
        let (mut current, mut other) = (std::mem::take(buffer), Vec::new());
        current.resize(len, 0);
        self.source.read_at(chunk.address, &mut current).map_err(io)?;
        for (i, filter) in self.filters.iter().enumerate().rev() {
            if chunk.skipped >> i & 1 == 1 {
                continue;
            }
            other.resize(need, 0);
            match filter {
                Filter::Deflate => {
                    let mut stream = Decompress::new(true);
                    let status = stream.decompress(&current, &mut other, FlushDecompress::Finish);
                    if !matches!(status, Ok(Status::StreamEnd)) || stream.total_out() != need as u64 {
                        return Err(damaged("does not inflate to its size"));
                    }
                }
                Filter::Shuffle => {
                    if current.len() != need {
                        return Err(damaged("has not its size"));
                    }
                    unshuffle(&current, element.size(), &mut other);
                }
            }
            std::mem::swap(&mut current, &mut other);
        }
        if current.len() != need {
            return Err(damaged("has not its size"));
        }
        *buffer = current;
        Ok(buffer)
    }
}

fn unshuffle(shuffled: &[u8], size: usize, into: &mut [u8]) {
    fn sized<const N: usize>(shuffled: &[u8], into: &mut [u8]) {
        let count = shuffled.len() / N;
        let mut planes = shuffled.chunks_exact(count.max(1));
        let planes: [&[u8]; N] = std::array::from_fn(|_| planes.next().unwrap_or_default());
        for (i, element) in into.as_chunks_mut::<N>().0.iter_mut().enumerate().take(count) {
            for (byte, plane) in element.iter_mut().zip(planes) {
                *byte = plane.get(i).copied().unwrap_or_default();
            }
        }
    }
    match size {
        2 => sized::<2>(shuffled, into),
        4 => sized::<4>(shuffled, into),
        8 => sized::<8>(shuffled, into),
        _ => into.copy_from_slice(shuffled),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_put_back_in_order() {
        let mut out = [0; 8];
        unshuffle(&[1, 5, 2, 6, 3, 7, 4, 8], 4, &mut out);
        assert_eq!(out, [1, 2, 3, 4, 5, 6, 7, 8]);
        let mut out = [0; 4];
        unshuffle(&[1, 3, 2, 4], 2, &mut out);
        assert_eq!(out, [1, 2, 3, 4]);
        unshuffle(&[1, 3, 2, 4], 1, &mut out);
        assert_eq!(out, [1, 3, 2, 4]);
    }
}
