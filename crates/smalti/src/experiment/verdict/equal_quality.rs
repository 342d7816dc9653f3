//! How much more light a camera needs for the mean CPSNR of another.

use serde::Serialize;

use crate::camera::STEP_STOPS;
use crate::numeric::bootstrap::{Resamples, mean};
use crate::numeric::crossing::{Differences, Places, narrowed};

/// The largest number of stops that is tried.
const REACH_STOPS: usize = 4;
/// A smaller rise of the mean per stop, dB, counts as none: CPSNR has reached a plateau or falls because the sensor saturates.
const LEAST_RISE_DB: f64 = 0.1;

/// How much more light a contender needs for the mean CPSNR of the best one, at the same exposure time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MoreLight {
    /// The light at which the means are equal.
    Stops(LightStops),
    /// More than this number of stops. CPSNR still rises there.
    MoreThan(f64),
    /// No light suffices: CPSNR stops rising below that of the best contender.
    Unreachable {
        /// The largest rise of the mean CPSNR that more light brings, dB.
        rise_db: f64,
    },
}

/// Light in stops, that is powers of two, with its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LightStops {
    /// The light.
    pub value: f64,
    /// Its interval, which excludes 0 if and only if that of the lead does; `None` for a single picture.
    pub interval: Option<StopsInterval>,
}

/// An interval of light in stops.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StopsInterval {
    /// Lower end.
    pub low: f64,
    /// Upper end; `None` if it lies beyond the light that was measured.
    pub high: Option<f64>,
}

/// CPSNR of a contender with more light, picture by picture, less that of another to be equalled.
pub(in super::super) struct QualityAtMoreLight<'a> {
    resamples: Option<&'a Resamples>,
    /// The differences at 0, 1, 2 … stops more light.
    at_stops: Vec<Vec<f64>>,
    /// The differences at the eighths of a stop between which the mean reaches the target, as in a light gain.
    nearest: Vec<(f64, Vec<f64>)>,
}

impl<'a> QualityAtMoreLight<'a> {
    /// Measures until the mean is not below that of `target` with certainty, and at most one stop more than its mean needs, four in
    /// all, and none after CPSNR has stopped rising. Then narrows the stop in which the mean reaches the target, as a light gain does. `quality` gives the CPSNR of each picture with its light multiplied by a factor;
    /// `own` is that for the factor 1. All are in the order of `resamples`.
    ///
    /// # Errors
    /// Those of `quality`.
    pub(in super::super) fn measure<E>(
        own: &[f64],
        target: &[f64],
        resamples: Option<&'a Resamples>,
        mut quality: impl FnMut(f64) -> Result<Vec<f64>, E>,
    ) -> Result<Self, E> {
        let from = |quality: &[f64]| quality.iter().zip(target).map(|(q, t)| q - t).collect::<Vec<f64>>();
        let mut measured = Self { resamples, at_stops: vec![from(own)], nearest: Vec::new() };
        while measured.is_open() {
            let more = quality((measured.at_stops.len() as f64).exp2())?;
            measured.at_stops.push(from(&more));
        }
        let means: Vec<f64> = measured.at_stops.iter().map(|d| mean(d)).collect();
        if let Some(above) = means.iter().position(|m| *m >= 0.0).filter(|above| *above > 0) {
            let [near, far] = [above - 1, above].map(|stops| (stops as f64, means[stops]));
            narrowed(near, far, STEP_STOPS, |stops| {
                let there = from(&quality(stops.exp2())?);
                let lead = mean(&there);
                measured.nearest.push((stops, there));
                Ok(lead)
            })?;
        }
        Ok(measured)
    }

    /// Whether a further stop tells more.
    fn is_open(&self) -> bool {
        let stops = self.at_stops.len() - 1;
        let reached = self.at_stops.iter().position(|d| mean(d) >= 0.0);
        let is_certain = self.at_stops.last().is_some_and(|d| match self.resamples {
            Some(resamples) => resamples.interval(d).is_none_or(|i| i.low > 0.0),
            None => reached.is_some(),
        });
        !is_certain && stops < reached.map_or(REACH_STOPS, |r| REACH_STOPS.min(r + 1)) && self.rises()
    }

    /// Whether the mean rose in the last stop.
    fn rises(&self) -> bool {
        let [.., before, last] = &self.at_stops[..] else { return true };
        mean(last) - mean(before) >= LEAST_RISE_DB
    }

    /// The light.
    pub(super) fn more_light(&self) -> MoreLight {
        let whole = self.at_stops.iter().enumerate().map(|(stops, d)| (stops as f64, d.clone()));
        let mut places: Vec<(f64, Vec<f64>)> = whole.chain(self.nearest.iter().cloned()).collect();
        places.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let differences = Differences::new(places);
        let Some(value) = differences.zero() else {
            let means: Vec<f64> = self.at_stops.iter().map(|d| mean(d)).collect();
            let own = means.first().copied().unwrap_or_default();
            let rise_db = means.iter().fold(0.0, |most: f64, m| most.max(m - own));
            return if self.rises() {
                MoreLight::MoreThan((self.at_stops.len() - 1) as f64)
            } else {
                MoreLight::Unreachable { rise_db }
            };
        };
        let interval = self.resamples.and_then(|r| differences.interval(r));
        let interval = interval.map(|Places { low, high }| StopsInterval { low: low.unwrap_or(0.0), high });
        MoreLight::Stops(LightStops { value, interval })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENES: usize = 8;

    /// The light for a target above scenes whose CPSNR changes with light by `rise`, and the number of lights that were measured.
    fn light(lead_db: f64, rise: impl Fn(f64) -> f64) -> (MoreLight, usize) {
        let own: Vec<f64> = (0..SCENES).map(|i| 20.0 + i as f64).collect();
        let target: Vec<f64> =
            own.iter().enumerate().map(|(i, v)| v + lead_db + 0.1 * (i as f64 - 3.5)).collect();
        let resamples = Resamples::new(SCENES, 1, 1);
        let at = |factor: f64| Ok::<_, ()>(own.iter().map(|v| v + rise(factor.log2())).collect());
        let measured = QualityAtMoreLight::measure(&own, &target, Some(&resamples), at).unwrap();
        (measured.more_light(), measured.at_stops.len() + measured.nearest.len())
    }

    #[test]
    fn the_light_of_a_linear_quality_is_exact() {
        for expected in [0.2, 1.0, 1.7, 3.5] {
            let (MoreLight::Stops(found), _) = light(3.0 * expected, |stops| 3.0 * stops) else {
                panic!("{expected}")
            };
            assert!((found.value - expected).abs() < 1e-9, "{} is not {expected}", found.value);
            // The scenes differ by ±0.35 dB, a ninth of a stop.
            let StopsInterval { low, high } = found.interval.unwrap();
            let high = high.unwrap();
            assert!(low < expected && expected < high && high - low < 0.3, "{low} to {high}");
        }
    }

    #[test]
    fn no_more_is_measured_than_needed() {
        // 0 and 1 stop, and three halvings.
        assert_eq!(light(0.6, |stops| 3.0 * stops).1, 5);
        // The mean is reached after one stop, but not with certainty.
        assert_eq!(light(2.95, |stops| 3.0 * stops).1, 6);
    }

    /// Light that suffices, light out of reach, and light that does not help are three results.
    #[test]
    fn a_plateau_is_not_a_long_way() {
        assert_eq!(light(15.0, |stops| 3.0 * stops), (MoreLight::MoreThan(4.0), 5));
        let (plateau, measured) = light(2.0, |stops| 0.8 * stops.min(1.0));
        let MoreLight::Unreachable { rise_db } = plateau else { panic!("{plateau:?}") };
        assert!((rise_db - 0.8).abs() < 1e-9 && measured == 3, "{rise_db} after {measured}");
        // The sensor saturates.
        let (falls, measured) = light(2.0, |stops| -1.5 * stops);
        assert_eq!((falls, measured), (MoreLight::Unreachable { rise_db: 0.0 }, 2));
    }

    #[test]
    fn a_contender_that_is_not_behind_needs_no_light() {
        let (MoreLight::Stops(found), 1) = light(-2.0, |_| f64::NAN) else { panic!("behind") };
        assert_eq!(found.value, 0.0);
    }

    /// The upper end of an interval that more light does not reach is open, not infinite.
    #[test]
    fn an_end_beyond_the_plateau_is_open() {
        let (MoreLight::Stops(found), _) = light(1.95, |stops| (2.5 * stops).min(2.0)) else { panic!() };
        let interval = found.interval.unwrap();
        assert!(found.value < 1.0 && interval.low > 0.5 && interval.high.is_none(), "{found:?}");
        assert!(serde_json::to_string(&found).unwrap().contains("\"high\":null"));
    }
}
