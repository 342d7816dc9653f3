//! Cut points of the response levels.

use serde::{Deserialize, Serialize};

use super::L3Error;
use super::error::within;
use crate::sensor::SignalNoise;

/// Maximum number of levels.
const MAX_LEVELS: usize = 256;

/// Cut points between the levels of a patch's mean response, normalised (1 at the white level), in ascending
/// order. Level `i` lies between cuts `i − 1` and `i`. The first and the last level are unbounded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<f32>", into = "Vec<f32>")]
pub struct Levels(Vec<f32>);

impl Levels {
    /// Levels with given cut points; there is one level more than there are cuts.
    ///
    /// # Errors
    /// When a cut is not finite, the cuts do not ascend, or there are more than 255.
    pub fn new(cuts: Vec<f32>) -> Result<Self, L3Error> {
        let wrong = |reason: String| Err(L3Error::Levels(reason));
        if cuts.len() >= MAX_LEVELS {
            return wrong(format!("{} of them; at most {} are possible", cuts.len(), MAX_LEVELS - 1));
        }
        if let Some(cut) = cuts.iter().find(|c| !c.is_finite()) {
            return wrong(format!("{cut} is not a finite number"));
        }
        match cuts.windows(2).find(|w| w[0] >= w[1]) {
            Some(w) => wrong(format!("{} comes before {}; they must ascend", w[0], w[1])),
            None => Ok(Self(cuts)),
        }
    }

    /// `count` levels with geometrically spaced cuts from `least` to `most`. The first level contains
    /// everything below `least`, the last everything above `most`.
    ///
    /// # Errors
    /// When the number is zero or too large, or the range is empty.
    pub fn logarithmic(count: usize, least: f64, most: f64) -> Result<Self, L3Error> {
        check_count(count)?;
        within(
            "the lowest cut between levels",
            least,
            f64::MIN_POSITIVE..=most / 1.001,
            "above 0 and below the highest",
        )?;
        let last = count.saturating_sub(2).max(1) as f64;
        let cut = |i: usize| (least * (most / least).powf(i as f64 / last)) as f32;
        Self::new((0..count - 1).map(cut).collect())
    }

    /// `count` levels of equal width in standard deviations of the noise: the integral ∫ dx / σ(x) from 0 to
    /// `most` is divided into equal parts. Levels are narrow where the noise is low and wide where it is
    /// high.
    ///
    /// # Errors
    /// As for [`Levels::logarithmic`], and when the noise has no variance.
    pub fn noise_steps(count: usize, noise: &SignalNoise, most: f64) -> Result<Self, L3Error> {
        check_count(count)?;
        within("the highest cut between levels", most, 1e-6..=1e3, "1e-6 to 1000")?;
        if noise.variance(0.0) <= 0.0 {
            return Err(L3Error::Levels("equal steps of noise need noise in the dark".into()));
        }
        // Midpoint rule on a grid that is fine near zero.
        const STEPS: usize = 4096;
        let at = |i: usize| most * (i as f64 / STEPS as f64).powi(2);
        let mut sums = vec![0.0];
        for i in 0..STEPS {
            let (a, b) = (at(i), at(i + 1));
            let total = sums[i] + (b - a) / noise.variance(f64::midpoint(a, b)).sqrt();
            sums.push(total);
        }
        let total = sums[STEPS];
        let cut = |i: usize| {
            let wanted = total * i as f64 / count as f64;
            let j = sums.partition_point(|&s| s < wanted).clamp(1, STEPS);
            let share = (wanted - sums[j - 1]) / (sums[j] - sums[j - 1]);
            (at(j - 1) + share * (at(j) - at(j - 1))) as f32
        };
        Self::new((1..count).map(cut).collect())
    }

    /// Number of levels.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.len() + 1
    }

    /// The cuts, ascending.
    #[must_use]
    pub fn cuts(&self) -> &[f32] {
        &self.0
    }

    /// The level of a mean response.
    #[must_use]
    pub fn level_of(&self, mean: f32) -> usize {
        self.0.partition_point(|&cut| cut <= mean)
    }

    /// A response that represents a level: the geometric mean of its cuts, or the arithmetic mean where the
    /// lower cut is not above 0. For the first level it is half the first cut; for the last, one and a half
    /// times the last cut.
    #[must_use]
    pub fn middle(&self, level: usize) -> f64 {
        let cut = |i: usize| self.0.get(i).copied().map(f64::from);
        match (level.checked_sub(1).and_then(cut), cut(level)) {
            (Some(low), Some(high)) if low > 0.0 => (low * high).sqrt(),
            (Some(low), Some(high)) => f64::midpoint(low, high),
            (None, Some(first)) => first - first.abs() / 2.0,
            (Some(last), None) => last + last.abs() / 2.0,
            // A single level, or an index that does not exist.
            (None, None) => 0.5,
        }
    }
}

fn check_count(count: usize) -> Result<(), L3Error> {
    within("levels", count as f64, 1.0..=MAX_LEVELS as f64, "1 to 256").map(|_| ())
}

impl TryFrom<Vec<f32>> for Levels {
    type Error = L3Error;

    fn try_from(cuts: Vec<f32>) -> Result<Self, L3Error> {
        Self::new(cuts)
    }
}

impl From<Levels> for Vec<f32> {
    fn from(levels: Levels) -> Self {
        levels.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_is_stood_for_by_a_response_within_it() {
        let sets: [&[f32]; 5] = [&[], &[0.1], &[0.01, 0.5], &[0.0, 0.2, 0.4], &[0.001, 0.002, 0.004, 0.9]];
        for cuts in sets {
            let levels = Levels::new(cuts.to_vec()).unwrap();
            for level in 0..levels.count() {
                let middle = levels.middle(level);
                // Below a first cut of 0 there is nothing but that cut.
                let expected = if cuts.first() == Some(&0.0) && level == 0 { 1 } else { level };
                assert_eq!(levels.level_of(middle as f32), expected, "{cuts:?}: {middle}");
            }
        }
        assert_eq!(Levels::new(vec![0.1, 0.4]).unwrap().middle(0), f64::from(0.1f32) / 2.0);
    }

    #[test]
    fn a_response_between_two_cuts_lies_apart_from_both() {
        for cuts in [[-0.4, -0.1, 0.0], [-0.1, 0.0, 0.2], [0.0, 0.2, 0.4], [1e-6, 0.1, 0.9]] {
            let levels = Levels::new(cuts.to_vec()).unwrap();
            for (level, cut) in (1..).zip(cuts.windows(2)) {
                let (middle, width) = (levels.middle(level), f64::from(cut[1] - cut[0]));
                let apart = (middle - f64::from(cut[0])).min(f64::from(cut[1]) - middle);
                assert!(apart > 1e-3 * width, "{cuts:?}: {middle}");
            }
        }
    }
}
