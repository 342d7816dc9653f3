//! Where a difference changes its sign.

use super::bootstrap::{Resamples, mean};

/// Halvings of the search for an end of an interval.
const HALVINGS: usize = 24;

/// The two neighbouring multiples of `step` between which a function changes its sign, with its values there. `near` and `far` are
/// multiples of `step` between which it does, with the values. The interval is halved.
///
/// # Errors
/// Those of `value`.
pub(crate) fn narrowed<E>(
    mut near: (f64, f64),
    mut far: (f64, f64),
    step: f64,
    mut value: impl FnMut(f64) -> Result<f64, E>,
) -> Result<[(f64, f64); 2], E> {
    loop {
        let steps = ((far.0 - near.0) / step).round();
        if steps.abs() < 1.5 {
            return Ok([near, far]);
        }
        let place = near.0 + (steps / 2.0).trunc() * step;
        let there = (place, value(place)?);
        *(if (there.1 < 0.0) == (near.1 < 0.0) { &mut near } else { &mut far }) = there;
    }
}

/// Paired differences of all members at several places, in ascending order. Between two places each is interpolated linearly.
pub(crate) struct Differences {
    places: Vec<f64>,
    members: Vec<Vec<f64>>,
}

/// The places at which the mean difference may be 0: those where its interval contains 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Places {
    /// The first of them; `None` if the difference is not below 0 with certainty at any place before it.
    pub(crate) low: Option<f64>,
    /// The last one; `None` if the difference is not above 0 with certainty at any place beyond it.
    pub(crate) high: Option<f64>,
}

impl Differences {
    /// The differences of all members at each place.
    pub(crate) fn new(at: impl IntoIterator<Item = (f64, Vec<f64>)>) -> Self {
        let (places, members) = at.into_iter().unzip();
        Self { places, members }
    }

    /// The first place at which the mean difference is not below 0.
    pub(crate) fn zero(&self) -> Option<f64> {
        let means: Vec<f64> = self.members.iter().map(|members| mean(members)).collect();
        let above = means.iter().position(|m| *m >= 0.0)?;
        let Some(before) = above.checked_sub(1) else { return self.places.first().copied() };
        let share = means[before] / (means[before] - means[above]);
        Some(self.places[before] + share * (self.places[above] - self.places[before]))
    }

    /// The interval of [`Differences::zero`] by inversion of the test: with 95 % confidence, the true place is one at which the
    /// measured differences do not contradict a mean of 0. Its lower end is known if and only if the difference at the first place is
    /// below 0 with certainty. `None` without intervals, and if the difference has the same sign with certainty everywhere.
    pub(crate) fn interval(&self, resamples: &Resamples) -> Option<Places> {
        let ends = |members: &[f64]| resamples.interval(members);
        let at: Vec<_> = self.members.iter().map(|members| ends(members)).collect::<Option<_>>()?;
        let first = at.iter().position(|i| i.high >= 0.0)?;
        let low = first
            .checked_sub(1)
            .map(|before| self.search(before, |members| ends(members).is_some_and(|i| i.high >= 0.0)));
        let last = at.iter().rposition(|i| i.low <= 0.0)?;
        let high = (last + 1 < at.len())
            .then(|| self.search(last, |members| ends(members).is_some_and(|i| i.low > 0.0)));
        Some(Places { low, high })
    }

    /// The place after the one with number `from` at which a property of the differences begins to hold.
    fn search(&self, from: usize, holds: impl Fn(&[f64]) -> bool) -> f64 {
        let [a, b] = [&self.members[from], &self.members[from + 1]];
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let share = f64::midpoint(low, high);
            let members: Vec<f64> = a.iter().zip(b).map(|(a, b)| a + share * (b - a)).collect();
            *(if holds(&members) { &mut high } else { &mut low }) = share;
        }
        self.places[from] + high * (self.places[from + 1] - self.places[from])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two scenes with differences x − 1 ± 0.01: Student's interval of the place is 1 ± 12.706 · 0.01.
    #[test]
    fn the_interval_of_a_straight_line_is_that_of_its_value() {
        let at = |x: f64| (x, vec![x - 1.01, x - 0.99]);
        let line = Differences::new([0.0, 0.5, 2.0].map(at));
        assert!((line.zero().unwrap() - 1.0).abs() < 1e-12);
        let Places { low, high } = line.interval(&Resamples::new(2, 1, 1)).unwrap();
        assert!(
            (low.unwrap() - 0.87294).abs() < 1e-6 && (high.unwrap() - 1.12706).abs() < 1e-6,
            "{low:?} {high:?}"
        );
        let short = Differences::new([0.0, 1.05].map(at)).interval(&Resamples::new(2, 1, 1)).unwrap();
        assert!((short.low.unwrap() - 0.87294).abs() < 1e-6 && short.high.is_none());
        let late = Differences::new([0.95, 2.0].map(at)).interval(&Resamples::new(2, 1, 1)).unwrap();
        assert!(late.low.is_none() && (late.high.unwrap() - 1.12706).abs() < 1e-6);
        let below = Differences::new([0.0, 0.5].map(at));
        assert_eq!((below.zero(), below.interval(&Resamples::new(2, 1, 1))), (None, None));
        assert_eq!(Differences::new([1.5, 2.0].map(at)).interval(&Resamples::new(2, 1, 1)), None);
    }
}
