//! Filters by rule instead of search: [cfaresolution], section 3.5.

mod fit;
mod target;

use serde::{Deserialize, Serialize};

pub use target::RuleTarget;

use self::fit::{Bounds, Curve, FreeParameters, Gaussian};
use super::figures::FWHM_PER_SIGMA;
use super::set::{FilterSet, index_checked};
use crate::design::error::{DesignError, colors_checked};
use crate::sensor::Filter;

/// Smallest standard deviation of a fitted filter, nm: half a step of the default wavelength grid. A narrower filter would
/// fall between samples.
const MIN_SIGMA_NM: f64 = 5.0;

/// A rule of `[cfaresolution]`, section 3.5.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum RuleName {
    /// Evenly spaced centres, one width, peaks of 1.
    Uniform,
    /// Uniform centres and widths, with the heights of least squared error from the target.
    HeightScaled,
    /// Heights, centres and widths of least squared error from the target, starting at the height-scaled filters.
    AllScaled,
}

/// `[filters.rule]`: one set of Gaussian filters for each rule, target and width.
///
/// The range is divided into N equal parts, with a centre in the middle of each. Errors are squared differences over
/// the range at 1 nm. Heights are scaled so that the largest is 1. The uniform rule has no target and counts once.
///
/// The all-scaled fit descends from the height-scaled filters and ends when the sum is within 1 % root mean square of the
/// target, because many sets of Gaussians, down to a single filter, sum to a Gaussian. Without constraints, filters crowd
/// where the target is high, as the paper found. Maximum width, minimum spacing and minimum height are the constraints that
/// the paper proposes; with them the fit may end in a local minimum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Rule {
    /// The rules.
    pub rules: Vec<RuleName>,
    /// The targets: `"cones"`, or `{ gaussian = { center_nm = 550, sigma_nm = 80 } }`.
    pub targets: Vec<RuleTarget>,
    /// Standard deviations of the uniform filters, nm, one set for each. When empty, the full width at half maximum equals the
    /// spacing, limited by `max_sigma_nm`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sigmas_nm: Vec<f64>,
    /// First and last wavelength of the range, nm.
    pub range_nm: [f64; 2],
    /// Largest standard deviation, nm. The default is the width of the range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_sigma_nm: Option<f64>,
    /// Smallest distance between neighbouring centres, nm.
    pub min_spacing_nm: f64,
    /// Smallest height as a fraction of the largest, 0 to 1.
    pub min_height: f64,
}

impl Default for Rule {
    fn default() -> Self {
        Self {
            rules: vec![RuleName::Uniform, RuleName::HeightScaled, RuleName::AllScaled],
            targets: vec![RuleTarget::default()],
            sigmas_nm: vec![],
            range_nm: [400.0, 700.0],
            max_sigma_nm: None,
            min_spacing_nm: 0.0,
            min_height: 0.0,
        }
    }
}

const WHAT: &str = "the family rule";

impl std::fmt::Display for RuleName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Uniform => "uniform",
            Self::HeightScaled => "height-scaled",
            Self::AllScaled => "all-scaled",
        })
    }
}

impl Rule {
    /// Rule, target and standard deviation of every set.
    fn sets(&self) -> impl Iterator<Item = (RuleName, Option<RuleTarget>, Option<f64>)> {
        let targets = |&rule: &RuleName| match rule {
            RuleName::Uniform => vec![(rule, None)],
            _ => self.targets.iter().map(|&t| (rule, Some(t))).collect(),
        };
        let sigmas = || match self.sigmas_nm.as_slice() {
            [] => vec![None],
            given => given.iter().copied().map(Some).collect(),
        };
        self.rules
            .iter()
            .flat_map(targets)
            .flat_map(move |(r, t)| sigmas().into_iter().map(move |s| (r, t, s)))
    }

    pub(super) fn count(&self, colors: usize) -> Result<u128, DesignError> {
        self.check(colors)?;
        Ok(self.sets().count() as u128)
    }

    pub(super) fn set(&self, colors: usize, index: u128) -> Result<FilterSet, DesignError> {
        let count = self.count(colors)?;
        index_checked(WHAT, colors, index, count)?;
        let missing = DesignError::Index { what: WHAT, colors, index, count };
        let (rule, target, sigma_nm) = self.sets().nth(index as usize).ok_or(missing)?;
        let unit = self.spacing_nm(colors);
        let start = self.uniform(colors, sigma_nm);
        let gaussians = match target {
            None => start,
            Some(target) => {
                let (curve, bounds) = (self.curve(target, unit)?, self.bounds(unit, &start));
                let heights = curve.fitted(&curve.scaled(&start), FreeParameters::Heights, &bounds);
                if rule == RuleName::AllScaled {
                    curve.fitted(&heights, FreeParameters::All, &bounds)
                } else {
                    heights
                }
            }
        };
        let largest = gaussians.iter().map(|b| b.height).fold(0.0, f64::max);
        // Narrow filters can lie far from a narrow target.
        if largest < 1e-6 {
            return Err(DesignError::key("rule.targets", "no filter of the rule reaches the target"));
        }
        let filter = |b: &Gaussian| Filter::Gaussian {
            center_nm: self.range_nm[0] + b.center * unit,
            sigma_nm: b.sigma * unit,
            peak: (b.height / largest).min(1.0),
        };
        let parts = [
            Some(rule.to_string()),
            target.map(|t| t.to_string()),
            sigma_nm.map(|s| format!("sigma {s}")),
            Some(colors.to_string()),
        ];
        let label = parts.into_iter().flatten().collect::<Vec<_>>().join(", ");
        Ok(FilterSet { label, filters: gaussians.iter().map(filter).collect() })
    }

    /// Squared difference between a target and the sum of Gaussian filters at its best scale, as a fraction of the
    /// squared target. Filters of another kind are ignored.
    ///
    /// # Errors
    /// When the range is impossible or the target vanishes within it.
    pub fn relative_error(&self, target: RuleTarget, filters: &[Filter]) -> Result<f64, DesignError> {
        self.check(1)?;
        let gaussian = |f: &Filter| match *f {
            Filter::Gaussian { center_nm, sigma_nm, peak } => {
                Some(Gaussian { center: center_nm - self.range_nm[0], sigma: sigma_nm, height: peak })
            }
            _ => None,
        };
        Ok(self.curve(target, 1.0)?.relative_error(&filters.iter().filter_map(gaussian).collect::<Vec<_>>()))
    }

    fn spacing_nm(&self, colors: usize) -> f64 {
        (self.range_nm[1] - self.range_nm[0]) / colors as f64
    }

    fn uniform(&self, colors: usize, sigma_nm: Option<f64>) -> Vec<Gaussian> {
        let widest = self.max_sigma_nm.map_or(f64::INFINITY, |s| s / self.spacing_nm(colors));
        let sigma = match sigma_nm {
            Some(nm) => nm / self.spacing_nm(colors),
            None => (1.0 / FWHM_PER_SIGMA).min(widest),
        };
        (0..colors).map(|i| Gaussian { center: i as f64 + 0.5, sigma, height: 1.0 }).collect()
    }

    /// The target over the range, at 1 nm.
    fn curve(&self, target: RuleTarget, unit_nm: f64) -> Result<Curve, DesignError> {
        let [low, high] = self.range_nm;
        let steps = (high - low).ceil();
        let nm: Vec<f64> = (0..=steps as usize).map(|i| low + i as f64 * (high - low) / steps).collect();
        let values = target.at(&nm).map_err(|e| DesignError::key("rule.targets", e))?;
        if !values.iter().any(|&v| v > 1e-6) {
            let message = format!("the target {target} has nothing between {low} and {high} nm");
            return Err(DesignError::key("rule.targets", message));
        }
        Ok(Curve { at: nm.iter().map(|nm| (nm - low) / unit_nm).collect(), values })
    }

    fn bounds(&self, unit_nm: f64, start: &[Gaussian]) -> Bounds {
        let width = self.range_nm[1] - self.range_nm[0];
        let sigma = start.first().map_or(1.0, |b| b.sigma);
        Bounds {
            center: [0.0, width / unit_nm],
            sigma: [
                sigma.min(MIN_SIGMA_NM / unit_nm),
                sigma.max(self.max_sigma_nm.unwrap_or(width) / unit_nm),
            ],
            spacing: self.min_spacing_nm / unit_nm,
            height: self.min_height,
        }
    }

    fn check(&self, colors: usize) -> Result<(), DesignError> {
        colors_checked(colors)?;
        let wrong = |key: &str, message: String| Err(DesignError::key(format!("rule.{key}"), message));
        let [low, high] = self.range_nm;
        if !((100.0..=1e5).contains(&low)
            && (100.0..=1e5).contains(&high)
            && (50.0..=1e4).contains(&(high - low)))
        {
            return wrong(
                "range_nm",
                format!("[{low}, {high}]; expected two wavelengths in nm, 50 to 10000 apart"),
            );
        }
        let width = |v: f64| (1.0..=1e4).contains(&v);
        if let Some(s) = self.max_sigma_nm.filter(|&s| !width(s)) {
            return wrong("max_sigma_nm", format!("{s}; expected a width of 1 nm or more"));
        }
        let widest = self.max_sigma_nm.unwrap_or(1e4);
        if let Some(s) = self.sigmas_nm.iter().find(|&&s| !width(s) || s > widest) {
            return wrong("sigmas_nm", format!("{s}; expected widths from 1 nm to max_sigma_nm"));
        }
        let spacing = self.spacing_nm(colors);
        if !(0.0..=spacing).contains(&self.min_spacing_nm) {
            let message = format!(
                "{}; {colors} colours over {low}–{high} nm are {spacing:.4} nm apart, expected 0 to that",
                self.min_spacing_nm
            );
            return wrong("min_spacing_nm", message);
        }
        if !(0.0..=1.0).contains(&self.min_height) {
            return wrong("min_height", format!("{}; expected 0 to 1", self.min_height));
        }
        for target in &self.targets {
            match *target {
                RuleTarget::Gaussian { center_nm, sigma_nm }
                    if !(center_nm.is_finite() && width(sigma_nm)) =>
                {
                    return wrong(
                        "targets",
                        format!("{target}; expected a centre and a width of 1 nm or more"),
                    );
                }
                _ => {}
            }
        }
        Ok(())
    }
}
