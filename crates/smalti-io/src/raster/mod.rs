//! A cube of samples in a file: any type, byte order and order of axes, contiguous or in blocks, read by parts.
//!
//! Reading is divided into units of about a mebibyte, or of the blocks that are unpacked at once. One thread reads, transposes and
//! checks a unit while it is in the cache.

mod blocks;
mod copy;
mod filters;
mod kind;
mod memory;
mod part;
mod run;
mod source;
mod stream;
mod values;

use std::collections::BTreeMap;
use std::io;
use std::mem::MaybeUninit;
use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;

pub(crate) use blocks::{Blocks, Place, Unpack};
use copy::Target;
use filters::Scratch;
pub(crate) use filters::{Filter, add_differences, restore_floats};
pub(crate) use kind::{Kind, Sample};
pub(crate) use memory::zeros;
use memory::{filled, room};
pub(crate) use part::{Axis, Bad, Part};
pub(crate) use run::Raster;
use run::UNIT_BYTES;
pub(crate) use source::{FileSource, Shared, Source, Span, bytes_at, part};
pub(crate) use stream::Stream;
pub(crate) use values::Values;

use crate::{IoError, Limits};

/// Samples, and where they are.
#[derive(Clone)]
pub(crate) struct Cube<'a> {
    pub(crate) source: Shared<'a>,
    pub(crate) raster: Raster,
    pub(crate) storage: Storage,
}

/// How samples lie in a file.
#[derive(Debug, Clone)]
pub(crate) enum Storage {
    /// One after another.
    Run {
        /// Of the first.
        offset: u64,
    },
    Blocks(Blocks),
}

impl Cube<'_> {
    /// Compares what is declared with the length of the file and with the limits; `what` is how a message calls the samples,
    /// or a block of them.
    pub(crate) fn check(&self, path: &Path, what: &'static str, limits: Limits) -> Result<(), IoError> {
        let have = self.source.len();
        match &self.storage {
            Storage::Run { offset } => {
                let need = self.raster.bytes().and_then(|n| n.checked_add(*offset)).unwrap_or(u64::MAX);
                if need > have {
                    return Err(IoError::truncated(path, what, need, have));
                }
                Ok(())
            }
            Storage::Blocks(blocks) => blocks.check(&self.raster, &*self.source, (path, what), limits),
        }
    }

    /// The rows that are unpacked at once; where rows run fastest, as many as make reading them worth while; of a stream in which
    /// they do not follow one another, all; else 1.
    pub(crate) fn rows_at_once(&self) -> usize {
        // A quarter of a page: fewer would have the disk read each page many times.
        const PIECE_BYTES: usize = 1 << 10;
        let raster = &self.raster;
        match &self.storage {
            _ if self.source.is_stream() => {
                let slowest = raster.order.into_iter().find(|axis| raster.len(*axis) > 1);
                if slowest == Some(Axis::Row) { 1 } else { raster.rows.max(1) }
            }
            Storage::Blocks(blocks) if blocks.packed() => blocks.size[1],
            _ if self.raster.order[2] == Axis::Row => PIECE_BYTES / self.raster.kind.size(),
            _ => 1,
        }
    }

    /// How many bands, counted from the first, come from the same place; and how many rows of `cols` samples are best read
    /// together, counted from the first row of the cube where they are unpacked together.
    fn unit(&self, cols: usize) -> (usize, usize, bool) {
        let (together, packed) = match &self.storage {
            Storage::Blocks(blocks) if blocks.packed() => (blocks.size[0], Some(blocks.size[1])),
            Storage::Blocks(blocks) => (blocks.size[0], None),
            Storage::Run { .. } => (self.raster.bands, None),
        };
        // Bands that lie apart are read one by one.
        let together = if packed.is_none() && self.raster.order[0] == Axis::Band { 1 } else { together };
        let row_bytes =
            |bands: usize| bands.saturating_mul(cols).saturating_mul(self.raster.kind.size()).max(1);
        match packed {
            Some(rows) => (together, rows, true),
            // In the order of the stream, so that it is unpacked once.
            None if self.source.is_stream() && !self.raster.by_rows() => {
                (together, self.raster.rows.max(1), false)
            }
            // Where rows run fastest, a few of them would be read in small pieces: bands are shared out instead.
            None if self.raster.order[2] == Axis::Row => (1, self.raster.rows.max(1), false),
            None => (together, (UNIT_BYTES / row_bytes(together)).max(1), false),
        }
    }

    fn read_into<S: Sample>(
        &self,
        part: &Part<'_>,
        target: Target<'_, '_, S>,
        (scratch, shared): (&mut Scratch, bool),
    ) -> Result<(), Bad> {
        match &self.storage {
            Storage::Run { offset } => {
                self.raster.read_into((&*self.source, *offset), part, target, &mut scratch.window)
            }
            Storage::Blocks(blocks) => {
                blocks.read_into(&self.raster, &*self.source, part, target, (scratch, shared))
            }
        }
    }
}

/// Rows of planes that come from the same place, filled by one thread.
struct Unit<'a, S> {
    cube: usize,
    rows: Range<usize>,
    /// The plane, and its band in the cube.
    bands: Vec<(usize, usize)>,
    planes: Vec<&'a mut [S]>,
}

/// Planes of a part of an image: band, row, column. `bands` names for each plane the cube and the band in it; the part lies
/// within the cubes, and they within their sources. `check` is given rows of a plane, its number and the first row.
pub(crate) fn read<S: Sample>(
    cubes: &[Cube<'_>],
    bands: &[(usize, usize)],
    (rows, cols): (Range<usize>, Range<usize>),
    check: impl Fn(usize, &mut [S], usize) -> Result<(), Bad> + Sync,
) -> Result<Vec<S>, Bad> {
    let len = bands.len() * rows.len() * cols.len();
    let mut data: Vec<S> = room(len);
    let empty = data.spare_capacity_mut().get_mut(..len).unwrap_or_default();
    let mut tasks = tasks(units(empty, cubes, bands, rows, cols.len()), cubes);
    let shared = tasks.len() < 2 * rayon::current_num_threads();
    let read = |scratch: &mut Scratch, unit: &mut Unit<'_, MaybeUninit<S>>| {
        let mut planes: Vec<&mut [S]> = unit.planes.iter_mut().map(|p| filled(p)).collect();
        let count: usize = planes.iter().map(|p| p.len()).sum();
        let Some(cube) = cubes.get(unit.cube) else { return Ok(count) };
        let wanted: Vec<usize> = unit.bands.iter().map(|(_, band)| *band).collect();
        let part = Part { bands: &wanted, rows: unit.rows.clone(), cols: cols.clone() };
        let target = Target { bands: &mut planes, width: cols.len(), col: 0 };
        cube.read_into(&part, target, (scratch, shared))?;
        for ((plane, _), samples) in unit.bands.iter().zip(planes) {
            check(*plane, samples, unit.rows.start)?;
        }
        Ok(count)
    };
    // The first error in the order of the units is reported: the same for any number of threads.
    let all = |scratch: &mut Scratch, task: &mut Vec<Unit<'_, MaybeUninit<S>>>| {
        task.iter_mut().map(|unit| read(scratch, unit)).sum::<Result<usize, Bad>>()
    };
    let done: Vec<Result<usize, Bad>> = tasks.par_iter_mut().map_init(Scratch::default, all).collect();
    drop(tasks);
    let count: usize = done.into_iter().sum::<Result<usize, Bad>>()?;
    if count != len {
        return Err(Bad::Io(io::ErrorKind::UnexpectedEof.into()));
    }
    // SAFETY: the units are parts of the room that do not overlap, they have written `count` elements of it, and that is all.
    unsafe { data.set_len(len) };
    Ok(data)
}

/// A plane, its band in the cube, and what is left of it to read.
type Rest<'a, S> = (usize, usize, &'a mut [S]);

/// Divides the samples to read into independent units.
fn units<'d, S>(
    data: &'d mut [S],
    cubes: &[Cube<'_>],
    bands: &[(usize, usize)],
    rows: Range<usize>,
    cols: usize,
) -> Vec<Unit<'d, S>> {
    let plane_len = rows.len() * cols;
    let mut stacks: BTreeMap<(usize, usize), Vec<Rest<'d, S>>> = BTreeMap::new();
    for ((plane, (cube, band)), samples) in bands.iter().enumerate().zip(data.chunks_mut(plane_len.max(1))) {
        let together = cubes.get(*cube).map_or(1, |c| c.unit(cols).0);
        stacks.entry((*cube, band / together.max(1))).or_default().push((plane, *band, samples));
    }
    let mut units = Vec::new();
    for ((cube, _), mut stack) in stacks {
        let (_, step, aligned) = cubes.get(cube).map_or((1, 1, false), |c| c.unit(cols));
        let mut row = rows.start;
        while row < rows.end {
            let last = if aligned { (row / step + 1).saturating_mul(step) } else { row.saturating_add(step) };
            let last = last.min(rows.end);
            let mut unit = Unit { cube, rows: row..last, bands: Vec::new(), planes: Vec::new() };
            for (plane, band, rest) in &mut stack {
                let len = ((last - row) * cols).min(rest.len());
                let (now, later) = std::mem::take(rest).split_at_mut(len);
                *rest = later;
                unit.bands.push((*plane, *band));
                unit.planes.push(now);
            }
            units.push(unit);
            row = last;
        }
    }
    units
}

/// Units that one thread reads one after another: those of a stream, each other alone.
fn tasks<'d, S>(units: Vec<Unit<'d, S>>, cubes: &[Cube<'_>]) -> Vec<Vec<Unit<'d, S>>> {
    let mut tasks: Vec<Vec<Unit<'d, S>>> = Vec::new();
    for unit in units {
        let stream = cubes.get(unit.cube).is_some_and(|c| c.source.is_stream());
        match tasks.last_mut().filter(|task| stream && task.last().is_some_and(|u| u.cube == unit.cube)) {
            Some(task) => task.push(unit),
            None => tasks.push(vec![unit]),
        }
    }
    tasks
}

#[cfg(test)]
mod tests;
