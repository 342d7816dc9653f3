//! From the array of a cube and its wavelengths to the cube.

use std::path::Path;

use smalti::numeric::Planes;
use smalti::spectrum::{SpectralCube, WavelengthGrid};

use super::Numbers;
use crate::arrays::Axes;
use crate::error::At;
use crate::file::{Negative, sample};
use crate::scene_file::facts::Facts;
use crate::wavelengths::{places, uniform_grid};
use crate::{IoError, ReadOptions};

/// An array of which it is known what its axes are and which wavelengths its bands have.
pub(super) struct Placed {
    pub(super) numbers: Numbers,
    pub(super) axes: Axes,
    pub(super) wavelengths_nm: Vec<f64>,
    /// Values are `gain · number + offset`, where they were packed into whole numbers.
    pub(super) packed: Option<(f64, f64)>,
}

impl Placed {
    /// The cube, on the grid that was written where the facts of the file tell it.
    pub(super) fn read(
        &self,
        facts: Option<&Facts>,
        path: &Path,
        options: &ReadOptions,
    ) -> Result<SpectralCube, IoError> {
        let array = &self.numbers.array;
        let (rows, cols) = (array.dim(self.axes.row), array.dim(self.axes.col));
        let check = |band: usize, plane: &mut [f32]| {
            if let Some((gain, offset)) = self.packed {
                plane.iter_mut().for_each(|v| *v = (f64::from(*v) * gain + offset) as f32);
            }
            let nm = self.wavelengths_nm.get(band).copied().unwrap_or_default();
            check(plane, nm, cols, options.clamp_negative, path)
        };
        let samples = array.planes(self.axes, path, options.limits, check)?;
        on_grid(samples, rows, cols, &self.wavelengths_nm, facts, path)
    }
}

/// Refuses what is no radiance; minus zero becomes zero, and negative numbers where that is asked for.
pub(super) fn check(
    plane: &mut [f32],
    nm: f64,
    cols: usize,
    clamp_negative: bool,
    path: &Path,
) -> Result<(), IoError> {
    let mut good = true;
    for v in plane.iter_mut() {
        // Two equal scenes have equal bits.
        *v += 0.0;
        good &= *v >= 0.0 && *v <= f32::MAX;
    }
    if good {
        return Ok(());
    }
    let negative = if clamp_negative { Negative::Clamp } else { Negative::Refuse };
    for (i, v) in plane.iter_mut().enumerate() {
        *v = sample(*v, negative).map_err(|expected| IoError::Pixel {
            path: path.to_owned(),
            channel: format!("{nm} nm"),
            row: i / cols.max(1),
            col: i % cols.max(1),
            value: f64::from(*v),
            expected,
        })?;
    }
    Ok(())
}

/// Planes at the wavelengths of the file, on a uniform grid.
pub(super) fn on_grid(
    samples: Vec<f32>,
    rows: usize,
    cols: usize,
    wavelengths_nm: &[f64],
    facts: Option<&Facts>,
    path: &Path,
) -> Result<SpectralCube, IoError> {
    let count = wavelengths_nm.len();
    let stated = facts.and_then(|f| WavelengthGrid::new(f.start_nm, f.step_nm, count).ok());
    let same = |g: &WavelengthGrid| g.wavelengths_nm().zip(wavelengths_nm).all(|(a, b)| (a - b).abs() < 1e-6);
    let grid = match stated.filter(same) {
        Some(grid) => grid,
        None => uniform_grid(wavelengths_nm, 2 * count).at(path)?,
    };
    let places = places(wavelengths_nm, grid);
    let as_stored =
        places.len() == count && places.iter().enumerate().all(|(i, p)| p.index == i && p.weight == 0.0);
    let samples = if as_stored {
        samples
    } else {
        let plane = |i: usize| samples.get(i * rows * cols..(i + 1) * rows * cols).unwrap_or_default();
        let mut resampled = Vec::with_capacity(places.len() * rows * cols);
        for place in places {
            let t = place.weight as f32;
            let below = plane(place.index);
            if t > 0.0 {
                let above = plane(place.index + 1);
                resampled.extend(below.iter().zip(above).map(|(a, b)| a * (1.0 - t) + b * t));
            } else {
                resampled.extend_from_slice(below);
            }
        }
        resampled
    };
    SpectralCube::new(grid, Planes::new(rows, cols, grid.len(), samples).at(path)?).at(path)
}
