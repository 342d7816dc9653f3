//! Files whose samples are cubes, read as they are needed.

use std::path::{Path, PathBuf};

use smalti::numeric::Planes;

use super::crop::Crop;
use super::spectral::ReadOptions;
use super::stated::Bands;
use super::tiles::{Header, Tiles};
use crate::error::At;
use crate::file::Negative;
use crate::raster::{self, Bad, Cube, Values};
use crate::{IoError, Quantity};

/// A file of one or several cubes, whose bands are counted through.
pub(crate) struct CubeFile<'a> {
    path: PathBuf,
    /// The name of the format in messages about its samples.
    format: &'static str,
    cubes: Vec<Cube<'a>>,
    /// The band for each wavelength of the header.
    bands: Vec<usize>,
    /// Cube, and band in it, for each wavelength.
    places: Vec<(usize, usize)>,
    /// Gain and offset of each band; where it is shorter, 1 and 0.
    pub(crate) gains: Vec<(f64, f64)>,
    /// Names of the bands in messages; for bands beyond its end, wavelength and number.
    pub(crate) channels: Vec<String>,
    /// The number that marks missing measurements.
    pub(crate) ignore: Option<f32>,
    negative: Negative,
    pub(crate) header: Header,
}

impl<'a> CubeFile<'a> {
    /// Cubes of equal rows and columns, at least one of them, that have been checked against the length of the file.
    pub(crate) fn new(
        (path, format): (&Path, &'static str),
        cubes: Vec<Cube<'a>>,
        (name, bands, quantity): (String, Bands, Quantity),
        options: &ReadOptions,
    ) -> Self {
        let size = cubes.first().map_or((0, 0), |c| (c.raster.rows, c.raster.cols));
        let of_cube = |(i, cube): (usize, &Cube<'_>)| (0..cube.raster.bands).map(move |band| (i, band));
        let all: Vec<(usize, usize)> = cubes.iter().enumerate().flat_map(of_cube).collect();
        Self {
            path: path.to_owned(),
            format,
            places: bands.order.iter().filter_map(|band| all.get(*band).copied()).collect(),
            bands: bands.order.clone(),
            cubes,
            gains: Vec::new(),
            channels: Vec::new(),
            ignore: None,
            negative: options.negative_or(Negative::Refuse),
            header: Header::plain(name, size, bands, quantity),
        }
    }
}

impl Tiles for CubeFile<'_> {
    fn header(&self) -> &Header {
        &self.header
    }

    fn read(&self, part: Crop) -> Result<Planes, IoError> {
        let part = part.within(self.header.rows, self.header.cols, &self.path)?;
        let values = Values { gains: &self.gains, ignore: self.ignore, negative: self.negative };
        let check = |plane: usize, samples: &mut [f32], row: usize| {
            let band = self.bands.get(plane).copied().unwrap_or(0);
            values.check(band, samples, (row, part.col, part.cols)).map_err(Bad::Sample)
        };
        let channel = |band: usize| {
            let nm =
                self.bands.iter().position(|b| *b == band).and_then(|i| self.header.wavelengths_nm.get(i));
            let number = format!("band {}", band + 1);
            let called = self.channels.get(band).cloned();
            called.unwrap_or_else(|| nm.map_or(number.clone(), |nm| format!("{nm} nm ({number})")))
        };
        let data = raster::read(&self.cubes, &self.places, part.ranges(), check)
            .map_err(|bad| bad_to_error(bad, (&self.path, self.format), channel))?;
        Planes::new(part.rows, part.cols, self.bands.len(), data).at(&self.path)
    }

    fn rows_at_once(&self) -> usize {
        self.cubes.iter().map(Cube::rows_at_once).max().unwrap_or(1)
    }
}

/// Names the file, and by `channel` the band of a sample.
pub(crate) fn bad_to_error(
    bad: Bad,
    (path, format): (&Path, &'static str),
    channel: impl FnOnce(usize) -> String,
) -> IoError {
    match bad {
        Bad::Io(source) => IoError::Read { path: path.to_owned(), source },
        Bad::Block(message) => IoError::decode(path, format, message),
        Bad::Sample(s) => IoError::pixel(path, channel(s.band), [s.row, s.col], s.value, s.expected),
    }
}
