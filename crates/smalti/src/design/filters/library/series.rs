//! Series of filters of one kind in a library.

use serde::{Deserialize, Serialize};

use super::super::steps::Steps;
use crate::design::combinations::{binomial, combination};
use crate::design::error::DesignError;
use crate::sensor::Filter;
use crate::sensor::cfa::AbsorptionBand;

/// A series of filters, an entry of `library.series`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Series {
    /// The measured channels of cameras among the [`builtin_filters`](crate::sensor::cfa::builtin_filters).
    Measured,
    /// Raised cosines: every centre with every width.
    RaisedCosine {
        /// Centres: first, step and last, nm.
        #[serde(deserialize_with = "super::super::steps::first_step_last")]
        centers_nm: [f64; 3],
        /// Full widths at half maximum: first, step and last, nm.
        #[serde(deserialize_with = "super::super::steps::first_step_last")]
        fwhms_nm: [f64; 3],
        /// Largest transmittance, 0 to 1.
        #[serde(default = "peak")]
        peak: f64,
    },
    /// Bands with Butterworth edges, as interference filters have them: every centre with every width.
    Butterworth {
        /// Centres: first, step and last, nm.
        #[serde(deserialize_with = "super::super::steps::first_step_last")]
        centers_nm: [f64; 3],
        /// Full widths at half maximum: first, step and last, nm.
        #[serde(deserialize_with = "super::super::steps::first_step_last")]
        fwhms_nm: [f64; 3],
        /// Order, 1 to 100.
        order: u32,
        /// Largest transmittance, 0 to 1.
        #[serde(default = "peak")]
        peak: f64,
    },
    /// Mixtures of dyes.
    Dyes(Dyes),
}

/// Mixtures of a few dyes, each at a few concentrations: [`Filter::Dye`].
///
/// The default is five dyes with adjacent bands over the visible range and mixtures of at most two dyes, like pigment
/// filters (yellow and magenta make red): 50 filters. Absorbances of 1 and 2 pass 10 % and 1 % at the centre of a band.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Dyes {
    /// The dyes.
    pub dyes: Vec<Dye>,
    /// Absorbances at the centre of the band that each dye of a mixture can have, above 0.
    pub absorbances: Vec<f64>,
    /// Largest number of dyes in a mixture.
    pub at_most: usize,
    /// Transmittance where no dye absorbs, 0 to 1.
    pub peak: f64,
    /// Lower limit of the transmittance, at most `peak`.
    pub leakage: f64,
}

/// A dye, by its absorption band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Dye {
    /// Centre of the band, nm.
    pub center_nm: f64,
    /// Full width of the band at half its absorbance, nm.
    pub fwhm_nm: f64,
}

impl Default for Dyes {
    fn default() -> Self {
        let dye = |center_nm| Dye { center_nm, fwhm_nm: 80.0 };
        Self {
            dyes: [420.0, 480.0, 540.0, 600.0, 660.0].map(dye).into(),
            absorbances: vec![1.0, 2.0],
            at_most: 2,
            peak: peak(),
            leakage: 0.01,
        }
    }
}

fn peak() -> f64 {
    0.9
}

/// Names of the measured channels; a test compares them with the built-in filters.
pub(super) const MEASURED: [&str; 6] = [
    "nikon-d5100/R",
    "nikon-d5100/G",
    "nikon-d5100/B",
    "sigma-sd-merrill/R",
    "sigma-sd-merrill/G",
    "sigma-sd-merrill/B",
];

impl Series {
    /// Number of filters; `key` is the path of the series in the study file.
    pub(super) fn len(&self, key: &str) -> Result<u64, DesignError> {
        match self {
            Self::Measured => Ok(MEASURED.len() as u64),
            Self::RaisedCosine { centers_nm, fwhms_nm, .. }
            | Self::Butterworth { centers_nm, fwhms_nm, .. } => {
                let (centers, widths) = bands(key, *centers_nm, *fwhms_nm)?;
                Ok(centers.len * widths.len)
            }
            Self::Dyes(dyes) => dyes.len(key),
        }
    }

    /// A filter by its number, with its name; `None` when there is none.
    pub(super) fn at(&self, key: &str, index: u64) -> Result<Option<(String, Filter)>, DesignError> {
        let band = |kind: &str, centers_nm, fwhms_nm, filter: &dyn Fn(f64, f64) -> Filter| {
            let (centers, widths) = bands(key, centers_nm, fwhms_nm)?;
            let (center, width) = (centers.at(index / widths.len), widths.at(index % widths.len));
            let inside = index < centers.len * widths.len;
            Ok(inside.then(|| (format!("{kind} {center}/{width}"), filter(center, width))))
        };
        match *self {
            Self::Measured => {
                let name = usize::try_from(index).ok().and_then(|i| MEASURED.get(i));
                Ok(name.map(|&n| (n.to_owned(), Filter::Builtin(n.to_owned()))))
            }
            Self::RaisedCosine { centers_nm, fwhms_nm, peak } => {
                band("raised cosine", centers_nm, fwhms_nm, &|center_nm, fwhm_nm| Filter::RaisedCosine {
                    center_nm,
                    fwhm_nm,
                    peak,
                })
            }
            Self::Butterworth { centers_nm, fwhms_nm, order, peak } => {
                band("Butterworth", centers_nm, fwhms_nm, &|center_nm, fwhm_nm| Filter::Butterworth {
                    center_nm,
                    fwhm_nm,
                    peak,
                    order,
                })
            }
            Self::Dyes(ref dyes) => Ok(dyes.at(index)),
        }
    }
}

fn bands(key: &str, centers_nm: [f64; 3], fwhms_nm: [f64; 3]) -> Result<(Steps, Steps), DesignError> {
    let centers = Steps::new(&format!("{key}.centers_nm"), centers_nm)?;
    Ok((centers, Steps::new(&format!("{key}.fwhms_nm"), fwhms_nm)?))
}

impl Dyes {
    /// Number of mixtures of exactly `dyes` dyes: combinations of dyes times combinations of absorbances.
    fn mixtures(&self, dyes: usize) -> Option<u64> {
        let dyes = u32::try_from(dyes).ok()?;
        let choices = u64::try_from(binomial(self.dyes.len() as u128, dyes)?).ok()?;
        choices.checked_mul((self.absorbances.len() as u64).checked_pow(dyes)?)
    }

    fn len(&self, key: &str) -> Result<u64, DesignError> {
        let mixed = 1..=self.at_most.min(self.dyes.len());
        let sum = mixed.map(|n| self.mixtures(n)).try_fold(0u64, |sum, n| sum.checked_add(n?));
        sum.ok_or_else(|| DesignError::key(key, "more than 2^64 mixtures of dyes"))
    }

    fn at(&self, mut index: u64) -> Option<(String, Filter)> {
        for dyes in 1..=self.at_most.min(self.dyes.len()) {
            let count = self.mixtures(dyes)?;
            if index < count {
                return self.mixture(dyes as u32, index);
            }
            index -= count;
        }
        None
    }

    fn mixture(&self, dyes: u32, index: u64) -> Option<(String, Filter)> {
        let levels = self.absorbances.len() as u64;
        let all = levels.checked_pow(dyes)?;
        let chosen = combination(self.dyes.len() as u64, dyes, u128::from(index / all))?;
        let mut rest = index % all;
        let mut band = |dye: u64| {
            let Dye { center_nm, fwhm_nm } = *self.dyes.get(dye as usize)?;
            let absorbance = *self.absorbances.get((rest % levels) as usize)?;
            rest /= levels;
            Some(AbsorptionBand { center_nm, fwhm_nm, absorbance })
        };
        let bands: Vec<AbsorptionBand> = chosen.into_iter().map(&mut band).collect::<Option<_>>()?;
        let names: Vec<String> =
            bands.iter().map(|b| format!("{}/{}x{}", b.center_nm, b.fwhm_nm, b.absorbance)).collect();
        let filter = Filter::Dye { bands, peak: self.peak, leakage: self.leakage };
        Some((format!("dye {}", names.join("+")), filter))
    }
}
