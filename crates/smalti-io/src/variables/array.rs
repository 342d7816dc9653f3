//! Arrays of numbers as files declare them, before it is known which axis is which.

use std::path::Path;
use std::sync::Arc;

use crate::raster::{self, Axis, Blocks, Cube, Filter, Kind, Place, Raster, Shared, Storage};
use crate::scene_file::cube_file::bad_to_error;
use crate::{IoError, Limits};

/// The name of the format in messages about chunks: no other format has them.
pub(super) const FORMAT: &str = "HDF5";

/// An array that is not read yet. Its axes are ordered as MATLAB does, the fastest first.
#[derive(Clone)]
pub(crate) struct Array {
    /// Length of every axis.
    pub(crate) dims: Vec<usize>,
    pub(crate) kind: Kind,
    pub(crate) big_endian: bool,
    pub(crate) source: Shared<'static>,
    pub(crate) layout: Layout,
}

/// Where the numbers are.
#[derive(Clone)]
pub(crate) enum Layout {
    /// One after another, from `offset` on.
    Run { offset: u64 },
    /// In chunks.
    Chunks(Chunks),
}

/// The chunks of an array of at most three axes.
#[derive(Clone)]
pub(crate) struct Chunks {
    /// Numbers of a chunk along every axis.
    dims: [usize; 3],
    /// In the order of the axes.
    places: Arc<[Place]>,
    filters: Vec<Filter>,
}

impl Chunks {
    /// Chunks by the places of their first numbers. `None` where one is missing, so that some numbers were never written.
    pub(crate) fn new(
        of: [usize; 3],
        dims: [usize; 3],
        filters: Vec<Filter>,
        stored: impl IntoIterator<Item = ([usize; 3], Place)>,
    ) -> Option<Self> {
        if dims.contains(&0) {
            return None;
        }
        let counts = [0, 1, 2].map(|a| of[a].div_ceil(dims[a]));
        let expected = counts[0].checked_mul(counts[1])?.checked_mul(counts[2])?;
        let mut places = vec![None; expected];
        for (start, place) in stored {
            let [x, y, z] = [0, 1, 2].map(|a| start[a] / dims[a]);
            if x < counts[0] && y < counts[1] && z < counts[2] {
                *places.get_mut((z * counts[1] + y) * counts[0] + x)? = Some(place);
            }
        }
        let places = places.into_iter().collect::<Option<Arc<[Place]>>>()?;
        Some(Self { dims, places, filters })
    }
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

impl Array {
    /// Bytes that it declares to hold.
    pub(crate) fn bytes(&self) -> u64 {
        self.dims.iter().fold(self.kind.size() as u64, |n, &d| n.saturating_mul(d as u64))
    }

    /// How many numbers.
    pub(crate) fn count(&self) -> u64 {
        self.dims.iter().fold(1, |n: u64, &d| n.saturating_mul(d as u64))
    }

    /// Length of an axis; those that are not there have one element.
    pub(crate) fn dim(&self, axis: usize) -> usize {
        self.dims.get(axis).copied().unwrap_or(1)
    }

    /// Its numbers in the order of the file, where they are as few as a list of wavelengths has.
    pub(crate) fn numbers(&self, path: &Path, limits: Limits) -> Result<Vec<f64>, IoError> {
        // Beside an axis without an element, another may have any length.
        if self.count() == 0 {
            return Ok(Vec::new());
        }
        limits.check(path, "the array", self.count().saturating_mul(8), self.source.len())?;
        let cube = self.cube(Axes::AS_STORED, path, limits)?;
        doubles(&cube, 0..cube.raster.bands, path)
    }

    /// As a cube, compared with the length of the file.
    pub(crate) fn cube(&self, axes: Axes, path: &Path, limits: Limits) -> Result<Cube<'static>, IoError> {
        if self.dims.iter().skip(3).any(|&d| d != 1) {
            let found = format!("of {} axes", self.dims.len());
            return Err(IoError::field(path, "the array", found, "at most three axes"));
        }
        let places = [axes.band, axes.row, axes.col];
        let axis = |i: usize| match places.iter().position(|p| *p == i) {
            Some(0) => Axis::Band,
            Some(1) => Axis::Row,
            _ => Axis::Col,
        };
        let raster = Raster {
            kind: self.kind,
            big_endian: self.big_endian,
            bands: self.dim(axes.band),
            rows: self.dim(axes.row),
            cols: self.dim(axes.col),
            order: [axis(2), axis(1), axis(0)],
        };
        let (storage, what) = match &self.layout {
            Layout::Run { offset } => (Storage::Run { offset: *offset }, "the array"),
            Layout::Chunks(Chunks { dims, places: chunks, filters }) => {
                let along = |a: usize| self.dim(a).div_ceil(dims[a]);
                let distances = [1, along(0), along(0) * along(1)];
                let blocks = Blocks {
                    size: places.map(|a| dims[a]),
                    strides: places.map(|a| distances[a]),
                    places: Arc::clone(chunks),
                    filters: filters.clone(),
                    heads: Arc::default(),
                    unpack: None,
                    cut: false,
                };
                (Storage::Blocks(blocks), "a chunk")
            }
        };
        let cube = Cube { source: Arc::clone(&self.source), raster, storage };
        cube.check(path, what, limits)?;
        Ok(cube)
    }
}

/// Planes of some bands in double precision, whatever their values.
pub(super) fn doubles(
    cube: &Cube<'_>,
    bands: std::ops::Range<usize>,
    path: &Path,
) -> Result<Vec<f64>, IoError> {
    let bands: Vec<(usize, usize)> = bands.map(|band| (0, band)).collect();
    let whole = (0..cube.raster.rows, 0..cube.raster.cols);
    raster::read(std::slice::from_ref(cube), &bands, whole, |_, _, _| Ok(()))
        .map_err(|bad| bad_to_error(bad, (path, FORMAT), |band| format!("band {band}")))
}
