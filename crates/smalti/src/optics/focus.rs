//! Being out of focus: the same for all wavelengths, or growing with wavelength.

use serde::Serialize;

use super::error::OpticsError;
use crate::numeric::require;
use crate::spectrum::{Spectrum, SpectrumError};

/// How far the image is from focus, for all wavelengths alike. All three ways give a wavefront error W₂₀ ρ² over
/// the pupil (ρ = 1 at the rim).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub enum Defocus {
    /// In focus.
    #[default]
    None,
    /// Error of the lens power, 1/m: W₂₀ = D a² / 2 with a the pupil's radius, f / (2N).
    Dioptres(f64),
    /// Zernike coefficient of defocus (Noll 4, the RMS wavefront error), µm: W₂₀ = 2√3 c.
    ZernikeUm(f64),
    /// The sensor stands this far, µm, from the plane of focus: W₂₀ = δ / (8 N²), N the working f-number.
    SensorShiftUm(f64),
}

/// Focus as a function of wavelength (longitudinal chromatic aberration), as an error of power in dioptres.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub enum ChromaticFocus {
    /// All wavelengths focus in one plane.
    #[default]
    None,
    /// Dioptres that grow linearly with wavelength.
    Linear {
        /// In focus here, nm.
        reference_nm: f64,
        /// Slope.
        dioptres_per_nm: f64,
    },
    /// A single thin lens of one glass with Cauchy's index n(λ) = a + b / λ²: D = (n(λ) − n₀) / ((n₀ − 1) f).
    Cauchy {
        /// In focus here, nm; n₀ is the index here.
        reference_nm: f64,
        /// Index for long waves.
        a: f64,
        /// Dispersion, µm².
        b_um2: f64,
    },
    /// Dioptres as measured. Must cover the wavelengths of the scene.
    Measured(Spectrum),
}

impl Defocus {
    fn rim_m(self, pupil_radius_m: f64, working_f_number: f64) -> Result<f64, OpticsError> {
        let (name, value, w20) = match self {
            Self::None => return Ok(0.0),
            Self::Dioptres(d) => ("defocus (dioptres)", d, rim_from_dioptres(d, pupil_radius_m)),
            Self::ZernikeUm(c) => ("defocus (Zernike, µm)", c, 2.0 * 3f64.sqrt() * c * 1e-6),
            Self::SensorShiftUm(s) => {
                ("defocus (sensor shift, µm)", s, s * 1e-6 / (8.0 * working_f_number * working_f_number))
            }
        };
        require(w20.is_finite(), name, value, "a finite number")?;
        Ok(w20)
    }
}

impl ChromaticFocus {
    fn dioptres(&self, wavelength_nm: f64, focal_length_m: f64) -> Result<f64, OpticsError> {
        let (name, value) = match self {
            Self::None => return Ok(0.0),
            Self::Linear { reference_nm, dioptres_per_nm } => {
                ("chromatic focus (dioptres)", (wavelength_nm - reference_nm) * dioptres_per_nm)
            }
            Self::Cauchy { reference_nm, a, b_um2 } => {
                let index = |nm: f64| a + b_um2 * 1e6 / (nm * nm);
                let n0 = index(*reference_nm);
                require(n0 > 1.0, "the index of the lens", n0, "more than 1")?;
                ("chromatic focus (dioptres)", (index(wavelength_nm) - n0) / ((n0 - 1.0) * focal_length_m))
            }
            Self::Measured(table) => {
                let missing = SpectrumError::coverage(table.grid(), wavelength_nm, wavelength_nm);
                return Ok(table.at(wavelength_nm).ok_or(missing)?);
            }
        };
        require(value.is_finite(), name, value, "a finite number")?;
        Ok(value)
    }
}

/// Wavefront error at the rim of the pupil, W₂₀, m.
pub(super) fn rim_error_m(
    defocus: Defocus,
    chromatic: &ChromaticFocus,
    wavelength_nm: f64,
    (focal_length_m, f_number, working_f_number): (f64, f64, f64),
) -> Result<f64, OpticsError> {
    let pupil_radius_m = focal_length_m / (2.0 * f_number);
    let dioptres = chromatic.dioptres(wavelength_nm, focal_length_m)?;
    Ok(defocus.rim_m(pupil_radius_m, working_f_number)? + rim_from_dioptres(dioptres, pupil_radius_m))
}

fn rim_from_dioptres(dioptres: f64, pupil_radius_m: f64) -> f64 {
    dioptres * pupil_radius_m * pupil_radius_m / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: (f64, f64, f64) = (0.05, 4.0, 4.0);

    #[test]
    fn the_three_ways_agree() {
        // A lens focused at infinity whose sensor stands δ too far back sees a power error of δ/f² to first order.
        let shift = rim_error_m(Defocus::SensorShiftUm(10.0), &ChromaticFocus::None, 550.0, LENS).unwrap();
        let dioptres =
            rim_error_m(Defocus::Dioptres(10e-6 / (0.05 * 0.05)), &ChromaticFocus::None, 550.0, LENS)
                .unwrap();
        assert!((shift - dioptres).abs() < 1e-15);
        let zernike = Defocus::ZernikeUm(shift * 1e6 / (2.0 * 3f64.sqrt()));
        assert!((rim_error_m(zernike, &ChromaticFocus::None, 550.0, LENS).unwrap() - shift).abs() < 1e-15);
    }

    #[test]
    fn a_crown_singlet_has_its_abbe_number() {
        // BK7, Cauchy's a = 1.5046, b = 0.00420 µm²: Abbe number near 64, so f changes by about f/64 from F to C.
        let glass = ChromaticFocus::Cauchy { reference_nm: 587.6, a: 1.5046, b_um2: 0.00420 };
        let d = |nm| glass.dioptres(nm, 0.05).unwrap();
        let spread = (d(486.1) - d(656.3)) * 0.05;
        assert!((1.0 / spread - 64.0).abs() < 2.0, "{}", 1.0 / spread);
        assert_eq!(d(587.6), 0.0);
    }

    #[test]
    fn nonsense_is_refused() {
        for d in [Defocus::Dioptres(f64::NAN), Defocus::ZernikeUm(f64::INFINITY)] {
            assert!(rim_error_m(d, &ChromaticFocus::None, 550.0, LENS).is_err());
        }
        let air = ChromaticFocus::Cauchy { reference_nm: 550.0, a: 1.0, b_um2: 0.0 };
        assert!(rim_error_m(Defocus::None, &air, 550.0, LENS).is_err());
    }
}
