//! Intervals by resampling observers.

use serde::Serialize;

use crate::numeric::bootstrap::{Interval, LEAST_GROUPS, tail_probability};
use crate::numeric::philox::Stream;

/// Separates these random numbers from others of the same seed.
const PURPOSE: u32 = 0x6f62_7376;

/// What intervals describe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum IntervalBasis {
    /// Other observers like these: observers were resampled.
    Observers,
    /// Other answers of these observers: there are too few of them to be resampled.
    Answers,
}

/// How often each observer is in each resample.
#[derive(Debug, Clone, PartialEq)]
pub struct ObserverResamples {
    observers: usize,
    times: Vec<u32>,
}

impl ObserverResamples {
    /// `resamples` of observers, drawn with replacement. `None` with fewer than [`LEAST_GROUPS`] observers, whose resamples would be
    /// too few and too alike. Equal arguments give equal resamples.
    #[must_use]
    pub fn new(observers: usize, resamples: usize, seed: u64) -> Option<Self> {
        if observers < LEAST_GROUPS {
            return None;
        }
        let mut times = vec![0; observers * resamples];
        for (resample, times) in times.chunks_exact_mut(observers).enumerate() {
            let mut random = Stream::new(seed, PURPOSE, resample as u32);
            (0..observers).for_each(|_| times[random.below(observers as u32) as usize] += 1);
        }
        Some(Self { observers, times })
    }

    /// The resamples: for each how often it has each observer.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.times.chunks_exact(self.observers)
    }
}

/// The interval of a statistic that was computed for resamples of observers: percentiles, wider with few observers
/// ([`bootstrap`](crate::numeric::bootstrap)). `None` without values, or where one is not finite.
#[must_use]
pub fn percentiles(mut values: Vec<f64>, observers: usize) -> Option<Interval> {
    if observers < 2 || values.iter().any(|v| !v.is_finite()) {
        return None;
    }
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    let tail = (tail_probability(observers) * last as f64).floor() as usize;
    Some(Interval { low: values[tail], high: values[last - tail] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_resample_has_as_many_observers() {
        let resamples = ObserverResamples::new(7, 50, 3).unwrap();
        assert_eq!(resamples.iter().len(), 50);
        assert!(resamples.iter().all(|times| times.len() == 7 && times.iter().sum::<u32>() == 7));
        assert_eq!(Some(resamples), ObserverResamples::new(7, 50, 3));
        assert_eq!(ObserverResamples::new(LEAST_GROUPS - 1, 50, 3), None);
    }

    #[test]
    fn percentiles_are_wider_with_few_observers() {
        let values: Vec<f64> = (0..=1000).map(f64::from).collect();
        let many = percentiles(values.clone(), 1000).unwrap();
        assert!((many.low - 25.0).abs() < 1.5 && (many.high - 975.0).abs() < 1.5, "{many:?}");
        let few = percentiles(values, 6).unwrap();
        assert!(few.low < many.low && few.high > many.high);
        assert_eq!(percentiles(vec![1.0, f64::NAN], 6), None);
        assert_eq!(percentiles(Vec::new(), 6), None);
    }
}
