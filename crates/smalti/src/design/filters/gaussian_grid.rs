//! Sets of Gaussian filters on a fine grid of centres and widths: the exhaustive search of [cfaresolution], section 3.4.

use serde::{Deserialize, Serialize};

use super::set::{FilterSet, index_checked};
use super::steps::Steps;
use crate::design::combinations::{binomial, combination};
use crate::design::error::{DesignError, colors_checked};
use crate::sensor::Filter;

const WHAT: &str = "the family gaussian_grid";

/// `[filters.gaussian_grid]`: every set of different Gaussian filters of peak 1 with centres and standard
/// deviations on a grid.
///
/// The paper states that the grid was fine, but not its values. By default the centres cover the visible range. Standard
/// deviations range from 10 nm, the step of the default wavelength grid, below which sampling would distort the curve, to
/// 60 nm (141 nm full width at half maximum), wider than common colour filters. With steps of 2.5 nm, even the narrowest
/// neighbouring filters have a correlation of 98 %, so that the grid does not affect results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct GaussianGrid {
    /// Centres: first, step and last, nm.
    #[serde(deserialize_with = "super::steps::first_step_last")]
    pub centers_nm: [f64; 3],
    /// Standard deviations: first, step and last, nm.
    #[serde(deserialize_with = "super::steps::first_step_last")]
    pub sigmas_nm: [f64; 3],
    /// Smallest distance between two centres, nm; 0: filters may share a centre and differ in width.
    pub min_spacing_nm: f64,
}

impl Default for GaussianGrid {
    fn default() -> Self {
        Self { centers_nm: [400.0, 2.5, 700.0], sigmas_nm: [10.0, 2.5, 60.0], min_spacing_nm: 0.0 }
    }
}

/// The grid with its values checked.
struct Grid {
    centers: Steps,
    sigmas: Steps,
    /// Smallest distance between centres in steps; `None` when centres may coincide.
    apart: Option<u64>,
}

impl GaussianGrid {
    fn grid(&self) -> Result<Grid, DesignError> {
        let centers = Steps::new("gaussian_grid.centers_nm", self.centers_nm)?;
        let sigmas = Steps::new("gaussian_grid.sigmas_nm", self.sigmas_nm)?;
        let spacing = self.min_spacing_nm;
        if !(0.0..=1e5).contains(&spacing) {
            let message = format!("{spacing} is out of range; expected 0 to 100000");
            return Err(DesignError::key("gaussian_grid.min_spacing_nm", message));
        }
        // The margin keeps rounding from adding a step when the spacing is a whole number of steps.
        let steps = (spacing / centers.step - 1e-9).ceil();
        Ok(Grid { centers, sigmas, apart: (spacing > 0.0).then_some((steps as u64).max(1)) })
    }

    pub(super) fn count(&self, colors: usize) -> Result<u128, DesignError> {
        let (k, grid) = (colors_checked(colors)?, self.grid()?);
        let uncountable = DesignError::Uncountable { what: WHAT, colors };
        let all = match grid.apart {
            None => binomial(u128::from(grid.centers.len) * u128::from(grid.sigmas.len), k),
            Some(apart) => {
                let widths = u128::from(grid.sigmas.len).checked_pow(k);
                let places = binomial(grid.slack(k, apart).into(), k);
                places.and_then(|p| if p == 0 { Some(0) } else { p.checked_mul(widths?) })
            }
        };
        all.ok_or(uncountable)
    }

    pub(super) fn set(&self, colors: usize, index: u128) -> Result<FilterSet, DesignError> {
        let count = self.count(colors)?;
        index_checked(WHAT, colors, index, count)?;
        let (k, grid) = (colors_checked(colors)?, self.grid()?);
        let missing = DesignError::Index { what: WHAT, colors, index, count };
        let filters: Vec<(f64, f64)> = match grid.apart {
            None => {
                // At most 10⁶ of each, so the product fits.
                let all = combination(grid.centers.len * grid.sigmas.len, k, index).ok_or(missing)?;
                let at = |i: u64| (grid.centers.at(i / grid.sigmas.len), grid.sigmas.at(i % grid.sigmas.len));
                all.into_iter().map(at).collect()
            }
            Some(apart) => {
                let widths = u128::from(grid.sigmas.len).checked_pow(k).ok_or(missing.clone())?;
                let places = combination(grid.slack(k, apart), k, index / widths).ok_or(missing)?;
                let mut rest = index % widths;
                let mut filter = |(i, place): (u64, u64)| {
                    let width = (rest % u128::from(grid.sigmas.len)) as u64;
                    rest /= u128::from(grid.sigmas.len);
                    (grid.centers.at(place + i * (apart - 1)), grid.sigmas.at(width))
                };
                (0..).zip(places).map(&mut filter).collect()
            }
        };
        let label: Vec<String> = filters.iter().map(|(c, s)| format!("{c}/{s}")).collect();
        let gaussian = |(center_nm, sigma_nm)| Filter::Gaussian { center_nm, sigma_nm, peak: 1.0 };
        Ok(FilterSet { label: label.join(" "), filters: filters.into_iter().map(gaussian).collect() })
    }
}

impl Grid {
    /// Number of centres from which `k` can be chosen after removing the mandatory gaps between them.
    fn slack(&self, k: u32, apart: u64) -> u64 {
        self.centers.len.saturating_sub(u64::from(k - 1).saturating_mul(apart - 1))
    }
}
