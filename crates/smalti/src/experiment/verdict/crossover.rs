//! The luminance at which one camera overtakes another.

use serde::Serialize;

use crate::numeric::bootstrap::{Estimate, Resamples, weighted};

/// Two contenders, each significantly better than the other at one of two adjacent luminances.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Crossover {
    /// The name of the metric.
    pub metric: &'static str,
    /// The contender that is better in less light.
    pub below: usize,
    /// The contender that is better in more light.
    pub above: usize,
    /// Where they are equal, cd/m²: the difference is interpolated linearly in the logarithm of the luminance.
    pub luminance_cd_m2: Estimate,
    /// The two luminances that were compared, cd/m².
    pub between_cd_m2: [f64; 2],
}

/// The luminance at which two contenders are equal, between two luminances. `leads` are the leads of the first over the second in
/// each picture at these luminances.
pub(super) fn equal_at(
    leads: &[Vec<f64>; 2],
    [dim, bright]: [f64; 2],
    resamples: Option<&Resamples>,
) -> Estimate {
    let equal = |weights: &[f64]| {
        let [low, high] = leads.each_ref().map(|lead| weighted(weights, lead));
        // Resamples without a change of the lead end at one of the luminances.
        dim * (bright / dim).powf((low / (low - high)).clamp(0.0, 1.0))
    };
    let count = leads[0].len();
    let value = equal(&vec![1.0 / count.max(1) as f64; count]);
    Estimate { value, interval: resamples.and_then(|r| r.interval(equal)) }
}
