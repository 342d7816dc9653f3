//! The luminance at which one camera overtakes another.

use serde::Serialize;

use super::{Estimate, LightVerdict, Scores};
use crate::camera::PICTURE_METRICS;
use crate::numeric::bootstrap::{Resamples, weighted};

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

/// All crossovers of the contenders that are the best at adjacent luminances.
pub(super) fn crossovers(scores: &Scores<'_>, lights: &[LightVerdict]) -> Vec<Crossover> {
    let mut order: Vec<usize> = (0..lights.len()).collect();
    order.sort_by(|a, b| lights[*a].luminance_cd_m2.total_cmp(&lights[*b].luminance_cd_m2));
    let mut found = Vec::new();
    for (metric, &name) in PICTURE_METRICS.iter().enumerate() {
        for pair in order.windows(2) {
            let &[dim, bright] = pair else { continue };
            let [low, high] = [dim, bright].map(|light| &lights[light].metrics[metric]);
            let (below, above) = (low.best, high.best);
            if !low.is_among_best(above) && !high.is_among_best(below) {
                let between = [dim, bright].map(|light| lights[light].luminance_cd_m2);
                let luminance_cd_m2 = equal_at(scores, [below, above], [dim, bright], metric, between);
                found.push(Crossover { metric: name, below, above, luminance_cd_m2, between_cd_m2: between });
            }
        }
    }
    found
}

/// The luminance at which two contenders are equal, between two luminances.
fn equal_at(
    scores: &Scores<'_>,
    [below, above]: [usize; 2],
    lights: [usize; 2],
    metric: usize,
    [dim, bright]: [f64; 2],
) -> Estimate {
    let leads = lights.map(|light| -> Vec<f64> {
        let [a, b] = [below, above].map(|contender| scores.figures(contender, light, metric));
        a.iter().zip(&b).map(|(a, b)| a - b).collect()
    });
    let equal = |weights: &[f64]| {
        let [low, high] = leads.each_ref().map(|lead| weighted(weights, lead));
        // Resamples without a change of the lead end at one of the luminances.
        dim * (bright / dim).powf((low / (low - high)).clamp(0.0, 1.0))
    };
    let count = leads[0].len();
    let value = equal(&vec![1.0 / count.max(1) as f64; count]);
    Estimate { value, interval: scores.resamples.as_ref().and_then(|r: &Resamples| r.interval(equal)) }
}
