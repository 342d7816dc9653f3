//! How often each condition was preferred to each other one.

/// Counts of choices between `n` conditions.
#[derive(Debug, Clone, PartialEq)]
pub struct Counts {
    conditions: usize,
    wins: Vec<f64>,
}

impl Counts {
    /// No choices between a number of conditions.
    #[must_use]
    pub fn new(conditions: usize) -> Self {
        Self { conditions, wins: vec![0.0; conditions * conditions] }
    }

    /// The number of conditions.
    #[must_use]
    pub fn conditions(&self) -> usize {
        self.conditions
    }

    /// Adds choices of `preferred` over `other`. Conditions out of range, and a condition against itself, are ignored.
    pub fn add(&mut self, preferred: usize, other: usize, times: f64) {
        if preferred < self.conditions && other < self.conditions && preferred != other {
            self.wins[preferred * self.conditions + other] += times;
        }
    }

    /// Adds the choices of others, each `times`, between the same conditions.
    pub fn merge(&mut self, other: &Self, times: f64) {
        for (own, more) in self.wins.iter_mut().zip(&other.wins) {
            *own += times * more;
        }
    }

    /// How often `preferred` was preferred to `other`.
    #[must_use]
    pub fn wins(&self, preferred: usize, other: usize) -> f64 {
        self.wins.get(preferred * self.conditions + other).copied().unwrap_or_default()
    }

    /// How often two conditions were compared.
    #[must_use]
    pub fn compared(&self, a: usize, b: usize) -> f64 {
        self.wins(a, b) + self.wins(b, a)
    }

    /// The number of choices.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.wins.iter().sum()
    }

    /// All pairs of different conditions `(a, b)`, `a < b`.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let n = self.conditions;
        (0..n).flat_map(move |a| (a + 1..n).map(move |b| (a, b)))
    }

    /// The first condition that no chain of comparisons connects with the first one.
    #[must_use]
    pub fn unconnected(&self) -> Option<usize> {
        let mut reached = vec![false; self.conditions];
        let mut open: Vec<usize> = (self.conditions > 0).then_some(0).into_iter().collect();
        while let Some(at) = open.pop() {
            if std::mem::replace(&mut reached[at], true) {
                continue;
            }
            open.extend((0..self.conditions).filter(|&next| !reached[next] && self.compared(at, next) > 0.0));
        }
        reached.iter().position(|r| !r)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_condition_without_a_chain_of_comparisons_is_found() {
        let mut counts = Counts::new(4);
        counts.add(0, 1, 1.0);
        counts.add(3, 2, 1.0);
        assert_eq!(counts.unconnected(), Some(2));
        counts.add(1, 3, 2.0);
        assert_eq!((counts.unconnected(), counts.total(), counts.compared(3, 1)), (None, 4.0, 2.0));
        counts.add(4, 1, 1.0);
        counts.add(1, 1, 1.0);
        assert_eq!(counts.total(), 4.0);
        assert_eq!(Counts::new(0).unconnected(), None);
        assert_eq!(counts.pairs().collect::<Vec<_>>(), [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]);
    }
}
