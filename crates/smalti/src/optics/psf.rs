//! Point spread functions that were measured, or computed by a lens design program.

use serde::Serialize;

use super::error::OpticsError;
use super::otf::FrequencyGrid;
use crate::numeric::Planes;
use crate::numeric::fft::{RealFft2, fast_len};
use crate::numeric::require;

/// Largest side of a point spread function, samples.
const MAX_SIDE: usize = 2048;

/// Point spread functions on the sensor, one per wavelength, or one for all.
///
/// The axis is at row `rows / 2`, column `cols / 2` (integer division, counted from 0). Each is scaled to a sum of 1. Its
/// samples are read as those of a band-limited function, so its transform carries no blur of an interpolation, and
/// the energy stays 1; detail beyond half its sampling rate is not there.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PsfStack {
    /// Ascending; empty when one serves for all wavelengths.
    wavelengths_nm: Vec<f64>,
    planes: Planes,
    spacing_m: f64,
}

impl PsfStack {
    /// One point spread function per wavelength (ascending, nm). Between two the transfer is interpolated
    /// linearly; beyond the ends it is unknown.
    ///
    /// # Errors
    /// When numbers of planes and wavelengths differ, wavelengths do not ascend, the spacing is not positive, or a
    /// plane has a negative or non-finite value, no energy, or a side that is zero or above 2048.
    pub fn new(wavelengths_nm: Vec<f64>, planes: Planes, spacing_m: f64) -> Result<Self, OpticsError> {
        if wavelengths_nm.len() != planes.count() || wavelengths_nm.is_empty() {
            return Err(OpticsError::PsfCount { wavelengths: wavelengths_nm.len(), planes: planes.count() });
        }
        for &nm in &wavelengths_nm {
            require(nm > 0.0, "wavelength of a point spread function (nm)", nm, "more than 0")?;
        }
        if let Some(i) = wavelengths_nm.windows(2).position(|w| w[0] >= w[1]) {
            let problem = "its wavelength should be above that of the one before";
            return Err(OpticsError::Psf { index: i + 1, problem });
        }
        Self::checked(wavelengths_nm, planes, spacing_m)
    }

    /// One point spread function for all wavelengths. `values` are `rows` × `cols`, in row order.
    ///
    /// # Errors
    /// As [`PsfStack::new`], and when the number of values is not `rows * cols`.
    pub fn achromatic(
        rows: usize,
        cols: usize,
        values: Vec<f32>,
        spacing_m: f64,
    ) -> Result<Self, OpticsError> {
        Self::checked(Vec::new(), Planes::new(rows, cols, 1, values)?, spacing_m)
    }

    fn checked(wavelengths_nm: Vec<f64>, mut planes: Planes, spacing_m: f64) -> Result<Self, OpticsError> {
        require(spacing_m > 0.0, "spacing of the point spread function (m)", spacing_m, "more than 0")?;
        for index in 0..planes.count() {
            let sides = 1..=MAX_SIDE;
            if !(sides.contains(&planes.rows()) && sides.contains(&planes.cols())) {
                return Err(OpticsError::Psf { index, problem: "its sides should be 1 to 2048 samples" });
            }
            let plane = planes.plane_mut(index)?;
            if plane.iter().any(|&v| !(0.0..=f32::MAX).contains(&v)) {
                return Err(OpticsError::Psf {
                    index,
                    problem: "its values should be finite and not negative",
                });
            }
            let sum: f64 = plane.iter().map(|&v| f64::from(v)).sum();
            if sum <= 0.0 {
                return Err(OpticsError::Psf { index, problem: "it should hold some light, all is zero" });
            }
            plane.iter_mut().for_each(|v| *v = (f64::from(*v) / sum) as f32);
        }
        Ok(Self { wavelengths_nm, planes, spacing_m })
    }

    /// Half the sampling rate, cycles/m.
    pub(super) fn nyquist_cy_per_m(&self) -> f64 {
        0.5 / self.spacing_m
    }

    /// How far it spreads light, m.
    pub(super) fn reach_m(&self) -> f64 {
        self.planes.rows().max(self.planes.cols()) as f64 / 2.0 * self.spacing_m
    }

    /// Its transform at a wavelength.
    pub(super) fn transfer(&self, wavelength_nm: f64) -> Result<FrequencyGrid, OpticsError> {
        let (index, t) = self.place(wavelength_nm)?;
        let (rows, cols) = (self.planes.rows(), self.planes.cols());
        // Padding makes the transform smooth enough to interpolate: the finer the more so, at a price in memory.
        let longest = rows.max(cols);
        let padding = match longest {
            0..=128 => 8,
            129..=512 => 4,
            _ => 2,
        };
        let side = fast_len(longest * padding);
        let mut square = vec![0.0f32; side * side];
        for (plane, weight) in [(index, 1.0 - t), (index + 1, t)] {
            if weight == 0.0 {
                continue;
            }
            for (r, row) in self.planes.plane(plane)?.chunks_exact(cols).enumerate() {
                let line = (r + side - rows / 2) % side * side;
                for (c, v) in row.iter().enumerate() {
                    square[line + (c + side - cols / 2) % side] += v * weight;
                }
            }
        }
        let half = RealFft2::new(side, side)?.forward(&square)?;
        Ok(FrequencyGrid::new(side, 1.0 / (side as f64 * self.spacing_m), half))
    }

    /// The plane at or below a wavelength, and the weight of the next.
    fn place(&self, wavelength_nm: f64) -> Result<(usize, f32), OpticsError> {
        let (Some(&first), Some(&last)) = (self.wavelengths_nm.first(), self.wavelengths_nm.last()) else {
            return Ok((0, 0.0));
        };
        // A thousandth of a nanometre forgives rounding in wavelengths that should coincide.
        if !(wavelength_nm >= first - 1e-3 && wavelength_nm <= last + 1e-3) {
            return Err(OpticsError::PsfCoverage {
                have_start_nm: first,
                have_end_nm: last,
                need_nm: wavelength_nm,
            });
        }
        let nm = wavelength_nm.clamp(first, last);
        let index = self.wavelengths_nm.partition_point(|&w| w <= nm).saturating_sub(1);
        let t = match self.wavelengths_nm.get(index..index + 2) {
            Some(&[a, b]) => (nm - a) / (b - a),
            _ => 0.0,
        };
        Ok((index, t as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_off_the_axis_is_a_shift() {
        let mut values = vec![0.0; 8 * 8];
        values[3 * 8 + 5] = 4.0; // one up, one right
        let grid = PsfStack::achromatic(8, 8, values, 0.5).unwrap().transfer(500.0).unwrap();
        for (fx, fy) in [(0.0, 0.0), (0.3, 0.0), (0.2, 0.4), (-0.1, 0.3)] {
            let turn = -std::f64::consts::TAU * 0.5 * (fx - fy);
            let got = grid.at(fx, fy);
            assert!(
                (f64::from(got.re) - turn.cos()).abs() < 1e-3
                    && (f64::from(got.im) - turn.sin()).abs() < 1e-3
            );
        }
    }

    #[test]
    fn wavelengths_mix_linearly() {
        let planes = Planes::new(1, 2, 2, vec![0.0, 1.0, 2.0, 0.0]).unwrap();
        let stack = PsfStack::new(vec![400.0, 500.0], planes, 1.0).unwrap();
        assert_eq!(stack.place(400.0).unwrap(), (0, 0.0));
        assert_eq!(stack.place(475.0).unwrap(), (0, 0.75));
        assert_eq!(stack.place(500.0).unwrap(), (1, 0.0));
        assert!(matches!(stack.place(510.0), Err(OpticsError::PsfCoverage { .. })));
        let at = |nm| stack.transfer(nm).unwrap().at(0.1, 0.0);
        assert!((at(425.0) - (at(400.0) * 0.75 + at(500.0) * 0.25)).norm() < 1e-6);
    }

    #[test]
    fn nonsense_is_refused() {
        let flat = |v: f32| PsfStack::achromatic(2, 2, vec![v; 4], 1e-6);
        assert!(flat(1.0).is_ok());
        for v in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(matches!(flat(v), Err(OpticsError::Psf { .. })));
        }
        assert!(PsfStack::achromatic(2, 2, vec![1.0; 3], 1e-6).is_err());
        assert!(PsfStack::achromatic(0, 2, vec![], 1e-6).is_err());
        assert!(PsfStack::achromatic(2, 2, vec![1.0; 4], 0.0).is_err());
        let planes = || Planes::new(1, 1, 2, vec![1.0; 2]).unwrap();
        for nm in [vec![500.0], vec![500.0, 500.0], vec![500.0, 400.0], vec![f64::NAN, 500.0], vec![]] {
            assert!(PsfStack::new(nm, planes(), 1e-6).is_err());
        }
    }
}
