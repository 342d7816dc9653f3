//! From the wavelengths a file states to the uniform grid of the library.

use smalti::spectrum::{SpectrumError, WavelengthGrid};

// Files state wavelengths in decimals: differences below this are rounding, not another grid.
const SLACK_NM: f64 = 1e-3;

/// Where a sample of the uniform grid lies among the samples of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Between {
    /// Index of the lower neighbour.
    pub(crate) index: usize,
    /// Weight of the upper neighbour, 0 to 1; 0 where there is none.
    pub(crate) weight: f64,
}

impl Between {
    /// The value at this place, linear between the values of the file.
    pub(crate) fn of(self, values: &[f64]) -> f64 {
        let at = |i: usize| values.get(i).copied().unwrap_or(0.0);
        if self.weight > 0.0 {
            at(self.index) * (1.0 - self.weight) + at(self.index + 1) * self.weight
        } else {
            at(self.index)
        }
    }
}

/// The uniform grid for ascending wavelengths (at least two): from the first to the last, with their smallest distance (rounded down
/// to fit) as step and at most `max_count` samples.
pub(crate) fn uniform_grid(
    wavelengths_nm: &[f64],
    max_count: usize,
) -> Result<WavelengthGrid, SpectrumError> {
    let (first, last) = match wavelengths_nm {
        [first, .., last] => (*first, *last),
        _ => return Err(SpectrumError::Grid { start_nm: 0.0, step_nm: 0.0, count: wavelengths_nm.len() }),
    };
    let smallest = wavelengths_nm.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
    if !(smallest > 0.0 && first > 0.0 && last.is_finite()) {
        return Err(SpectrumError::Grid { start_nm: first, step_nm: smallest, count: wavelengths_nm.len() });
    }
    let mean = (last - first) / (wavelengths_nm.len() - 1) as f64;
    let uniform =
        wavelengths_nm.iter().enumerate().all(|(i, w)| (first + i as f64 * mean - w).abs() < SLACK_NM);
    let steps = if uniform {
        wavelengths_nm.len() - 1
    } else {
        (((last - first) / smallest - 1e-3).ceil() as usize).clamp(1, max_count.max(2) - 1)
    };

    let step = (last - first) / steps as f64;
    // A grid that was written comes back to the last bit: its step has few decimals, or is that of the first pair.
    let exact =
        |step: &f64| uniform && wavelengths_nm.iter().enumerate().all(|(i, w)| first + i as f64 * step == *w);
    let decimals = (step * 1e6).round() / 1e6;
    let second = wavelengths_nm.get(1).map_or(step, |w| w - first);
    let step = [decimals, step, second].into_iter().find(exact).unwrap_or(step);
    WavelengthGrid::new(first, step, steps + 1)
}

/// For every sample of the grid, its place among `wavelengths_nm`. On a grid that is already uniform every place
/// is a sample itself, so values pass unchanged.
pub(crate) fn places(wavelengths_nm: &[f64], grid: WavelengthGrid) -> Vec<Between> {
    let mut index = 0;
    let last = wavelengths_nm.len().saturating_sub(1);
    grid.wavelengths_nm()
        .map(|nm| {
            while index < last && wavelengths_nm[index + 1] <= nm + SLACK_NM {
                index += 1;
            }
            let below = wavelengths_nm[index];
            let weight = match wavelengths_nm.get(index + 1) {
                Some(above) if (nm - below) > SLACK_NM => ((nm - below) / (above - below)).clamp(0.0, 1.0),
                _ => 0.0,
            };
            Between { index, weight }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uniform_grid_is_kept() {
        let nm: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * f64::from(i)).collect();
        let grid = uniform_grid(&nm, 31).unwrap();
        assert_eq!(grid, WavelengthGrid::VISIBLE);
        assert!(places(&nm, grid).iter().enumerate().all(|(i, p)| *p == Between { index: i, weight: 0.0 }));
    }

    #[test]
    fn the_smallest_distance_sets_the_step() {
        let nm = [400.0, 405.0, 420.0];
        let grid = uniform_grid(&nm, 100).unwrap();
        assert_eq!((grid.step_nm(), grid.len()), (5.0, 5));
        let p = places(&nm, grid);
        assert_eq!(p[1], Between { index: 1, weight: 0.0 });
        assert!((p[2].weight - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(p[4], Between { index: 2, weight: 0.0 });
    }

    #[test]
    fn a_tiny_distance_asks_for_no_more_than_allowed() {
        assert_eq!(uniform_grid(&[400.0, 400.01, 1000.0], 6).unwrap().len(), 6);
    }
}
