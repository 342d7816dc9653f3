//! How much more light a camera needs for the mean CPSNR of another.

use serde::Serialize;

use crate::numeric::bootstrap::{Estimate, Resamples, weighted};

/// The largest number of stops that is tried.
const REACH_STOPS: usize = 4;

/// How much more light a contender needs for the mean CPSNR of the best one, at the same exposure time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MoreLight {
    /// Stops, that is powers of two.
    Stops(Estimate),
    /// More than this number of stops.
    MoreThan(f64),
}

/// CPSNR of a contender with more light, scene by scene, and that of another to be equalled.
pub(in super::super) struct QualityAtMoreLight {
    /// The figures to be equalled.
    target: Vec<f64>,
    /// The figures at 0, 1, 2 … stops more light.
    at_stops: Vec<Vec<f64>>,
}

impl QualityAtMoreLight {
    /// Measures until the mean reaches that of `target`, and at most four stops. `quality` gives the CPSNR on each scene with its light
    /// multiplied by a factor; `own` is that for the factor 1.
    ///
    /// # Errors
    /// Those of `quality`.
    pub(in super::super) fn measure<E>(
        own: Vec<f64>,
        target: Vec<f64>,
        mut quality: impl FnMut(f64) -> Result<Vec<f64>, E>,
    ) -> Result<Self, E> {
        let sum = |values: &[f64]| values.iter().sum::<f64>();
        let (mut at_stops, aim) = (vec![own], sum(&target));
        while at_stops.last().is_some_and(|last| sum(last) < aim) && at_stops.len() <= REACH_STOPS {
            at_stops.push(quality((at_stops.len() as f64).exp2())?);
        }
        Ok(Self { target, at_stops })
    }

    /// The light, with its interval over the scenes.
    pub(super) fn more_light(&self, seed: u64) -> MoreLight {
        let count = self.target.len();
        let equal = vec![1.0 / count.max(1) as f64; count];
        let value = self.stops(&equal);
        if value.is_infinite() {
            return MoreLight::MoreThan(REACH_STOPS as f64);
        }
        let interval = (count > 1)
            .then(|| Resamples::new(count, 1, seed).interval(|weights| self.stops(weights)))
            .flatten();
        MoreLight::Stops(Estimate { value, interval })
    }

    /// The light in stops at which the weighted mean equals that of the target, linear between the luminances that were measured and
    /// continued beyond them; infinite if it does not rise.
    fn stops(&self, weights: &[f64]) -> f64 {
        let target = weighted(weights, &self.target);
        let at: Vec<f64> = self.at_stops.iter().map(|figures| weighted(weights, figures)).collect();
        let above = at.iter().position(|v| *v >= target);
        let segment = match above {
            Some(place) => place.max(1),
            None if self.at_stops.len() > REACH_STOPS => return f64::INFINITY,
            None => at.len() - 1,
        };
        match at.get(segment.saturating_sub(1)).zip(at.get(segment)) {
            Some((low, high)) if high > low => (segment - 1) as f64 + (target - low) / (high - low),
            _ => f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scenes whose CPSNR rises by 3 dB a stop, and a target some stops above.
    fn measured(lead_stops: f64) -> QualityAtMoreLight {
        let own: Vec<f64> = (0..8).map(|i| 20.0 + f64::from(i)).collect();
        let target =
            own.iter().enumerate().map(|(i, v)| v + 3.0 * lead_stops + 0.1 * (i as f64 - 3.5)).collect();
        let at = |factor: f64| Ok::<_, ()>(own.iter().map(|v| v + 3.0 * factor.log2()).collect());
        QualityAtMoreLight::measure(own.clone(), target, at).unwrap()
    }

    #[test]
    fn the_light_of_a_linear_quality_is_exact() {
        for expected in [0.2, 1.0, 1.7, 3.9] {
            let MoreLight::Stops(found) = measured(expected).more_light(1) else { panic!("{expected}") };
            assert!((found.value - expected).abs() < 1e-9, "{} is not {expected}", found.value);
            let interval = found.interval.unwrap();
            // The scenes differ by ±0.35 dB, a ninth of a stop.
            assert!(interval.contains(expected) && interval.high - interval.low < 0.3, "{interval:?}");
        }
    }

    #[test]
    fn no_more_is_measured_than_needed_and_out_of_reach_is_said() {
        assert_eq!(measured(0.2).at_stops.len(), 2);
        assert_eq!(measured(5.0).more_light(1), MoreLight::MoreThan(4.0));
    }
}
