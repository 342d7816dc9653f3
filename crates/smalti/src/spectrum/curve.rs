//! A sampled spectral function.

use serde::{Serialize, Serializer};

use super::{SpectrumError, WavelengthGrid};

/// The value of a spectrum outside its measured range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extrapolation {
    /// Unknown: asking for it is an error.
    Error,
    /// Zero, as for a sensitivity or a colour matching function.
    Zero,
    /// The value at the nearer end, as for a reflectance.
    Hold,
}

/// One value per wavelength of a grid. The unit is that of the quantity it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    grid: WavelengthGrid,
    values: Vec<f64>,
}

/// First wavelength and step in nm, then the values.
impl Serialize for Spectrum {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        (self.grid.start_nm(), self.grid.step_nm(), &self.values).serialize(to)
    }
}

impl Spectrum {
    /// A spectrum from its samples.
    ///
    /// # Errors
    /// When the number of values is not that of the grid, or one is not finite.
    pub fn new(grid: WavelengthGrid, values: Vec<f64>) -> Result<Self, SpectrumError> {
        if values.len() != grid.len() {
            return Err(SpectrumError::Length { expected: grid.len(), got: values.len() });
        }
        let spectrum = Self { grid, values };
        spectrum.check("the spectrum", f64::is_finite, "a finite number was expected")?;
        Ok(spectrum)
    }

    /// Checks that every value is 0 to 1. A thousandth beyond is accepted, for rounding in measured curves.
    pub(crate) fn check_fraction(&self, quantity: &'static str) -> Result<(), SpectrumError> {
        self.check(quantity, |v| (-1e-3..=1.001).contains(&v), "expected 0 to 1")
    }

    /// Checks every value.
    pub(crate) fn check(
        &self,
        quantity: &'static str,
        good: impl Fn(f64) -> bool,
        expected: &'static str,
    ) -> Result<(), SpectrumError> {
        match self.grid.wavelengths_nm().zip(&self.values).find(|(_, v)| !good(**v)) {
            Some((wavelength_nm, &value)) => {
                Err(SpectrumError::Value { quantity, wavelength_nm, value, expected })
            }
            None => Ok(()),
        }
    }

    /// The function `f(wavelength_nm)` sampled on a grid.
    ///
    /// # Errors
    /// When a value is NaN or infinite; the error names the wavelength.
    pub fn from_fn(grid: WavelengthGrid, f: impl FnMut(f64) -> f64) -> Result<Self, SpectrumError> {
        Self::new(grid, grid.wavelengths_nm().map(f).collect())
    }

    /// The same value at every wavelength.
    ///
    /// # Errors
    /// When the value is NaN or infinite.
    pub fn constant(grid: WavelengthGrid, value: f64) -> Result<Self, SpectrumError> {
        Self::from_fn(grid, |_| value)
    }

    /// The wavelengths.
    #[must_use]
    pub fn grid(&self) -> WavelengthGrid {
        self.grid
    }

    /// The samples, in the order of the grid.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The value at a wavelength by linear interpolation; `None` outside the grid.
    #[must_use]
    pub fn at(&self, wavelength_nm: f64) -> Option<f64> {
        // A thousandth of a nanometre forgives rounding in grids that should coincide.
        const SLACK_NM: f64 = 1e-3;
        let x = (wavelength_nm - self.grid.start_nm()) / self.grid.step_nm();
        let last = (self.values.len() - 1) as f64;
        let slack = SLACK_NM / self.grid.step_nm();
        if !(x >= -slack && x <= last + slack) {
            return None;
        }
        let x = x.clamp(0.0, last);
        let i = (x.floor() as usize).min(self.values.len().saturating_sub(2));
        let t = x - i as f64;
        let next = self.values.get(i + 1).copied().unwrap_or(self.values[i]);
        Some(if t == 0.0 { self.values[i] } else { self.values[i] * (1.0 - t) + next * t })
    }

    /// The spectrum on another grid, by linear interpolation.
    ///
    /// # Errors
    /// When the new grid reaches beyond this one and `extrapolation` is [`Extrapolation::Error`].
    pub fn resampled(
        &self,
        grid: WavelengthGrid,
        extrapolation: Extrapolation,
    ) -> Result<Self, SpectrumError> {
        if grid == self.grid {
            return Ok(self.clone());
        }
        let values = grid
            .wavelengths_nm()
            .map(|nm| match (self.at(nm), extrapolation) {
                (Some(v), _) => Ok(v),
                (None, Extrapolation::Zero) => Ok(0.0),
                (None, Extrapolation::Hold) if nm < self.grid.start_nm() => Ok(self.values[0]),
                (None, Extrapolation::Hold) => Ok(self.values[self.values.len() - 1]),
                (None, Extrapolation::Error) => {
                    Err(SpectrumError::coverage(self.grid, grid.start_nm(), grid.end_nm()))
                }
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { grid, values })
    }

    /// Every value changed by `f(wavelength_nm, value)`.
    ///
    /// # Errors
    /// When a changed value is NaN or infinite; the error names the wavelength.
    pub fn map(&self, mut f: impl FnMut(f64, f64) -> f64) -> Result<Self, SpectrumError> {
        let values = self.grid.wavelengths_nm().zip(&self.values).map(|(nm, &v)| f(nm, v)).collect();
        Self::new(self.grid, values)
    }

    /// Every value times a factor.
    ///
    /// # Errors
    /// When a product is NaN or infinite; the error names the wavelength.
    pub fn scaled(&self, factor: f64) -> Result<Self, SpectrumError> {
        self.map(|_, v| v * factor)
    }

    /// The product, wavelength by wavelength.
    ///
    /// # Errors
    /// When the grids differ.
    pub fn times(&self, other: &Self) -> Result<Self, SpectrumError> {
        if self.grid != other.grid {
            return Err(SpectrumError::GridMismatch { left: self.grid, right: other.grid });
        }
        let values = self.values.iter().zip(&other.values).map(|(a, b)| a * b).collect();
        Self::new(self.grid, values)
    }

    /// Sum of the values times the step, in the unit of the values times nm.
    #[must_use]
    pub fn integral(&self) -> f64 {
        self.values.iter().sum::<f64>() * self.grid.step_nm()
    }

    /// The largest value.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

    fn refused(made: Result<Spectrum, SpectrumError>, at_nm: f64) -> bool {
        matches!(made, Err(SpectrumError::Value { wavelength_nm, value, .. })
            if wavelength_nm == at_nm && !value.is_finite())
    }

    #[test]
    fn a_value_that_is_not_finite_is_an_error_with_its_wavelength() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(refused(Spectrum::new(GRID, [vec![0.0; 30], vec![bad]].concat()), 700.0));
            assert!(refused(Spectrum::constant(GRID, bad), 400.0));
            assert!(refused(Spectrum::from_fn(GRID, |nm| if nm == 550.0 { bad } else { 1.0 }), 550.0));
        }
        let ramp = Spectrum::from_fn(GRID, |nm| nm - 550.0).unwrap();
        assert!(refused(ramp.map(|_, v| 1.0 / v), 550.0));
        assert!(refused(ramp.scaled(f64::NAN), 400.0));
        // Products overflow beyond 1.8e308.
        assert_eq!(ramp.scaled(1e306).unwrap().values()[30], 1.5e308);
        assert!(refused(ramp.scaled(2e306), 400.0));
        assert_eq!(ramp.map(|nm, v| nm - v).unwrap(), Spectrum::constant(GRID, 550.0).unwrap());
    }
}
