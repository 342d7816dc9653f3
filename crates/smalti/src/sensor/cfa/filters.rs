//! Analytic filter curves on any wavelength grid.

use serde::{Deserialize, Serialize};

use super::shapes::{gaussian, logistic};
use super::{CfaError, named};
use crate::numeric::{OutOfRange, require};
use crate::spectrum::{Extrapolation, Spectrum, WavelengthGrid};

/// The shape of a filter's transmittance. Wavelengths are in nanometres; `peak` is the maximum transmittance,
/// 0 to 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Filter {
    /// A constant transmittance.
    Flat(f64),
    /// `peak exp(−½ ((λ − center) / sigma)²)`, sampled at the wavelengths of the grid.
    Gaussian {
        /// Wavelength of the peak.
        center_nm: f64,
        /// Standard deviation.
        sigma_nm: f64,
        /// Largest transmittance.
        #[serde(default = "one")]
        peak: f64,
    },
    /// `peak` from `low_nm` to `high_nm`, zero elsewhere. Each sample is the mean over an interval of one
    /// grid step, so that the integral is `peak (high_nm − low_nm)` wherever the edges lie.
    Box {
        /// Lower edge.
        low_nm: f64,
        /// Upper edge, above the lower one.
        high_nm: f64,
        /// Transmittance between the edges.
        #[serde(default = "one")]
        peak: f64,
    },
    /// One period of a raised cosine, `peak (1 + cos(π (λ − center) / fwhm)) / 2`, zero beyond `fwhm` from
    /// the centre. Two such filters one `fwhm` apart add up to `peak` at every wavelength between their
    /// centres.
    RaisedCosine {
        /// Wavelength of the peak.
        center_nm: f64,
        /// Full width at half maximum.
        fwhm_nm: f64,
        /// Largest transmittance.
        #[serde(default = "one")]
        peak: f64,
    },
    /// Long-pass filter: `peak / (1 + exp(−(λ − edge) / width))`. The rise from 10 % to 90 % of the peak
    /// takes 4.4 widths.
    LongPass {
        /// Wavelength of half the peak.
        edge_nm: f64,
        /// Width of the edge.
        width_nm: f64,
        /// Transmittance far above the edge.
        #[serde(default = "one")]
        peak: f64,
    },
    /// Short-pass filter: `peak` minus the long-pass filter with the same edge.
    ShortPass {
        /// Wavelength of half the peak.
        edge_nm: f64,
        /// Width of the edge.
        width_nm: f64,
        /// Transmittance far below the edge.
        #[serde(default = "one")]
        peak: f64,
    },
    /// Band-pass filter with the magnitude response of a Butterworth filter, `peak / (1 + (2 (λ − center) /
    /// fwhm)^(2 order))`. A higher order gives a flatter top and steeper edges.
    Butterworth {
        /// Middle of the band.
        center_nm: f64,
        /// Full width at half maximum.
        fwhm_nm: f64,
        /// Largest transmittance.
        #[serde(default = "one")]
        peak: f64,
        /// Order.
        order: u32,
    },
    /// A mixture of dyes by the Beer–Lambert law, `leakage + (peak − leakage) 10^(−A(λ))`. The absorbance A
    /// is the sum over the bands of `absorbance exp(−4 ln 2 ((ν − ν₀) / Δν)²)`, Gaussians in frequency ν ∝
    /// 1/λ ([verhoeven1996]). `leakage` is light that no concentration absorbs: it is scattered or passes
    /// beside the pigment.
    ///
    /// [verhoeven1996]: https://doi.org/10.1351/pac199668122223
    Dye {
        /// Absorption bands of all dyes of the mixture.
        bands: Vec<AbsorptionBand>,
        /// Transmittance where no dye absorbs.
        #[serde(default = "one")]
        peak: f64,
        /// Transmittance in the limit of full absorption, at most `peak`.
        #[serde(default)]
        leakage: f64,
    },
    /// A built-in filter by name; [`builtin_filters`](super::builtin_filters) lists them.
    Builtin(String),
    /// A file of wavelengths and values.
    ///
    /// This library opens no file: the caller reads it and substitutes [`Filter::Samples`].
    File(String),
    /// Samples on a uniform grid with linear interpolation.
    Samples {
        /// First wavelength.
        start_nm: f64,
        /// Step.
        step_nm: f64,
        /// One value per wavelength, 0 to 1.
        values: Vec<f64>,
    },
}

/// An absorption band of a dye, see [`Filter::Dye`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AbsorptionBand {
    /// Wavelength of the largest absorbance.
    pub center_nm: f64,
    /// Full width at half the absorbance, above 0. In frequency, Δν is `ν₀ fwhm_nm / center_nm`.
    pub fwhm_nm: f64,
    /// Maximum absorbance, −log₁₀ of the transmittance, 0 to 100. It is proportional to concentration and
    /// thickness.
    pub absorbance: f64,
}

impl AbsorptionBand {
    fn at(&self, nm: f64) -> f64 {
        // (ν − ν₀) / Δν
        let x = (self.center_nm / nm - 1.0) * self.center_nm / self.fwhm_nm;
        self.absorbance * libm::exp(-4.0 * std::f64::consts::LN_2 * x * x)
    }
}

fn one() -> f64 {
    1.0
}

impl Filter {
    /// A transmittance as samples on its own grid.
    #[must_use]
    pub fn sampled(transmittance: &Spectrum) -> Self {
        let grid = transmittance.grid();
        Self::Samples {
            start_nm: grid.start_nm(),
            step_nm: grid.step_nm(),
            values: transmittance.values().to_vec(),
        }
    }

    /// The transmittance on a grid.
    ///
    /// # Errors
    /// When a parameter is out of range or not finite, no built-in filter has the name, or a measured curve
    /// does not cover the grid and cannot be taken as zero outside it.
    pub fn spectrum(&self, grid: WavelengthGrid) -> Result<Spectrum, CfaError> {
        let sampled = |f: &dyn Fn(f64) -> f64| Ok(Spectrum::from_fn(grid, f)?);
        match *self {
            Self::Flat(value) => {
                within("the transmittance of a flat filter", value, 0.0, 1.0, "0 to 1")?;
                Ok(Spectrum::constant(grid, value)?)
            }
            Self::Gaussian { center_nm, sigma_nm, peak } => {
                band(center_nm, "sigma_nm", sigma_nm, peak)?;
                sampled(&|nm| peak * gaussian(nm, center_nm, sigma_nm))
            }
            Self::Box { low_nm, high_nm, peak } => {
                wavelength("low_nm", low_nm)?;
                wavelength("high_nm", high_nm)?;
                require(high_nm > low_nm, "high_nm", high_nm, "a wavelength above low_nm")?;
                within("peak", peak, 0.0, 1.0, "0 to 1")?;
                let half = grid.step_nm() / 2.0;
                sampled(&|nm| {
                    let covered = high_nm.min(nm + half) - low_nm.max(nm - half);
                    peak * covered.max(0.0) / grid.step_nm()
                })
            }
            Self::RaisedCosine { center_nm, fwhm_nm, peak } => {
                band(center_nm, "fwhm_nm", fwhm_nm, peak)?;
                sampled(&|nm| {
                    let x = ((nm - center_nm) / fwhm_nm).clamp(-1.0, 1.0);
                    peak * 0.5 * (1.0 + libm::cos(std::f64::consts::PI * x))
                })
            }
            Self::LongPass { edge_nm, width_nm, peak } => {
                band(edge_nm, "width_nm", width_nm, peak)?;
                sampled(&|nm| peak * logistic((nm - edge_nm) / width_nm))
            }
            Self::ShortPass { edge_nm, width_nm, peak } => {
                band(edge_nm, "width_nm", width_nm, peak)?;
                sampled(&|nm| peak * logistic((edge_nm - nm) / width_nm))
            }
            Self::Butterworth { center_nm, fwhm_nm, peak, order } => {
                band(center_nm, "fwhm_nm", fwhm_nm, peak)?;
                within("order", f64::from(order), 1.0, 100.0, "1 to 100")?;
                let power = 2.0 * f64::from(order);
                sampled(&|nm| peak / (1.0 + libm::pow((2.0 * (nm - center_nm) / fwhm_nm).abs(), power)))
            }
            Self::Dye { ref bands, peak, leakage } => {
                for b in bands {
                    band(b.center_nm, "fwhm_nm", b.fwhm_nm, peak)?;
                    within("absorbance", b.absorbance, 0.0, 100.0, "0 to 100")?;
                }
                within("peak", peak, 0.0, 1.0, "0 to 1")?;
                within("leakage", leakage, 0.0, peak, "0 to the peak")?;
                sampled(&|nm| {
                    let absorbance: f64 = bands.iter().map(|b| b.at(nm)).sum();
                    leakage + (peak - leakage) * libm::exp(-std::f64::consts::LN_10 * absorbance)
                })
            }
            Self::Builtin(ref name) => named::spectrum(name, grid),
            Self::File(ref name) => Err(CfaError::UnreadFile { name: name.clone() }),
            Self::Samples { start_nm, step_nm, ref values } => {
                wavelength("start_nm", start_nm)?;
                width("step_nm", step_nm)?;
                let own = WavelengthGrid::new(start_nm, step_nm, values.len())?;
                Ok(Spectrum::new(own, values.clone())?.resampled(grid, Extrapolation::Error)?)
            }
        }
    }
}

fn within(name: &str, value: f64, low: f64, high: f64, expected: &'static str) -> Result<(), OutOfRange> {
    require((low..=high).contains(&value), name, value, expected)
}

fn wavelength(name: &str, nm: f64) -> Result<(), OutOfRange> {
    // The range of photodiodes. A value of 0.61 is probably a wavelength in µm.
    within(name, nm, 100.0, 1e5, "a wavelength in nm, 100 to 100000")
}

fn band(center_nm: f64, width: &str, width_nm: f64, peak: f64) -> Result<(), OutOfRange> {
    wavelength("the wavelength of the filter", center_nm)?;
    self::width(width, width_nm)?;
    within("peak", peak, 0.0, 1.0, "0 to 1")
}

fn width(name: &str, nm: f64) -> Result<(), OutOfRange> {
    within(name, nm, 1e-6, 1e5, "a width in nm, 0.000001 to 100000")
}
