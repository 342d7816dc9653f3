//! Target curves for the sum of the filters of a rule.

use serde::{Deserialize, Serialize};

use crate::spectrum::{Observer, Spectrum, SpectrumError, WavelengthGrid};

/// The target for the sum of the filters, up to a factor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum RuleTarget {
    /// A Gaussian, which the paper uses for the sensitivity of the eye. In the paper it peaks near 550 nm and is low at 380 and
    /// 710 nm, which lie two standard deviations away with the default width.
    Gaussian {
        /// Centre, nm.
        #[serde(default = "center_nm")]
        center_nm: f64,
        /// Standard deviation, nm.
        #[serde(default = "sigma_nm")]
        sigma_nm: f64,
    },
    /// The sum of the cone fundamentals of the CIE 2° observer (`[cie170]`), each with its maximum at 1, per photon.
    Cones,
}

fn center_nm() -> f64 {
    550.0
}

fn sigma_nm() -> f64 {
    80.0
}

impl Default for RuleTarget {
    fn default() -> Self {
        Self::Gaussian { center_nm: center_nm(), sigma_nm: sigma_nm() }
    }
}

impl std::fmt::Display for RuleTarget {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Gaussian { center_nm, sigma_nm } => write!(f, "gaussian {center_nm}/{sigma_nm}"),
            Self::Cones => f.write_str("cones"),
        }
    }
}

impl RuleTarget {
    /// The curve at the given wavelengths.
    pub(super) fn at(self, wavelengths_nm: &[f64]) -> Result<Vec<f64>, SpectrumError> {
        match self {
            Self::Gaussian { center_nm, sigma_nm } => Ok(wavelengths_nm
                .iter()
                .map(|nm| {
                    let x = (nm - center_nm) / sigma_nm;
                    libm::exp(-0.5 * x * x)
                })
                .collect()),
            Self::Cones => {
                let sum = cones()?;
                Ok(wavelengths_nm.iter().map(|&nm| sum.at(nm).unwrap_or(0.0)).collect())
            }
        }
    }
}

/// The cone fundamentals l, m, s of the CIE 2° observer per unit of energy, 390 to 830 nm.
fn fundamentals() -> Result<[Spectrum; 3], SpectrumError> {
    let grid = WavelengthGrid::new(390.0, 1.0, 441)?;
    let [x, y, z] = Observer::Cie2015.matching_functions(grid)?;
    // CIE 170-2:2015: x = X_L l + X_M m + X_S s, y = Y_L l + Y_M m, z = Z_S s.
    const X_L: f64 = 1.947_354_69;
    const X_M: f64 = -1.414_451_23;
    const X_S: f64 = 0.364_763_27;
    const Y_L: f64 = 0.689_902_72;
    const Y_M: f64 = 0.348_321_89;
    const Z_S: f64 = 1.934_853_43;
    let mut cones = [vec![], vec![], vec![]];
    for ((x, y), z) in x.values().iter().zip(y.values()).zip(z.values()) {
        let s = z / Z_S;
        let x = x - X_S * s;
        let determinant = X_L * Y_M - X_M * Y_L;
        cones[0].push((x * Y_M - y * X_M) / determinant);
        cones[1].push((y * X_L - x * Y_L) / determinant);
        cones[2].push(s);
    }
    let [l, m, s] = cones.map(|values| Spectrum::new(grid, values));
    Ok([l?, m?, s?])
}

/// l + m + s per photon, each with its maximum at 1.
fn cones() -> Result<Spectrum, SpectrumError> {
    // The energy of a photon is proportional to 1/λ. Rounding in the table leaves negative values where the cones are blind.
    let [l, m, s] = fundamentals()?.map(|f| {
        let per_photon = f.map(|nm, v| v.max(0.0) / nm)?;
        per_photon.scaled(1.0 / per_photon.max())
    });
    let (l, m, s) = (l?, m?, s?);
    let others = m.values().iter().zip(s.values()).map(|(m, s)| m + s);
    let values = l.values().iter().zip(others).map(|(l, sum)| l + sum).collect();
    Spectrum::new(l.grid(), values)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [cie170] gives each fundamental a maximum of 1; those of Stockman and Sharpe lie at 570.2, 542.8 and 442.1 nm.
    #[test]
    fn cones_are_those_of_the_cie() {
        for (cone, peak_nm) in fundamentals().unwrap().iter().zip([570.2, 542.8, 442.1]) {
            assert!((cone.max() - 1.0).abs() < 1e-3, "{}", cone.max());
            let at = cone.grid().wavelengths_nm().find(|&nm| cone.at(nm) == Some(cone.max())).unwrap();
            assert!((at - peak_nm).abs() <= 1.0, "{at}");
            assert!(cone.values().iter().all(|&v| v > -1e-4));
        }
        // Two cones at full sensitivity near 555 nm, the short one at its own maximum with little from the others.
        let sum = cones().unwrap();
        assert!(sum.at(555.0).unwrap() > 1.85 && (1.0..1.3).contains(&sum.at(441.0).unwrap()));
    }
}
