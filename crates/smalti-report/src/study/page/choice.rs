//! The trials that a page shows.

use std::collections::BTreeSet;

use super::sources::Sources;
use crate::ReportError;

/// The largest number of trials on a page. More would load slowly and could not be distinguished.
const MAX_TRIALS: usize = 100_000;

/// A trial on the page.
pub(super) struct Row {
    /// Index of the study, and row of its results.
    pub(super) study: usize,
    pub(super) row: usize,
    /// Number of the trial in its study.
    pub(super) number: u64,
    /// Index of the section among all.
    pub(super) section: usize,
    /// Whether it is on the front of its section.
    pub(super) front: bool,
}

/// The trials on a page.
pub(super) struct Choice {
    pub(super) rows: Vec<Row>,
    /// The number of all trials, where the page shows some of them.
    pub(super) of: Option<usize>,
}

impl Choice {
    pub(super) fn of(sources: &Sources<'_>) -> Result<Self, ReportError> {
        Self::among(sources, MAX_TRIALS)
    }

    /// At most about `most` designs, apart from the marked ones.
    pub(super) fn among(sources: &Sources<'_>, most: usize) -> Result<Self, ReportError> {
        if let Some((results, _)) = sources.all.first() {
            for number in sources.requested {
                if results.data.numbers.binary_search(number).is_err() {
                    return Err(ReportError::NoSuchPicture { number: *number, study: results.name() });
                }
            }
        }
        let all: usize = sources.all.iter().map(|(r, _)| r.data.numbers.len()).sum();
        let step = all.div_ceil(most).max(1);
        let mut rows = Vec::new();
        let mut index = 0;
        for (study, (results, sections)) in sources.all.iter().enumerate() {
            let step = if sources.is_marked(results) { 1 } else { step };
            for section in sections {
                let front: BTreeSet<usize> = section.front.iter().copied().collect();
                let named: BTreeSet<usize> = section
                    .groups
                    .iter()
                    .flat_map(|g| g.best.iter().copied().chain(g.worst))
                    .chain(front.iter().copied().take(most / 10))
                    .collect();
                let requested = |n: &u64| study == 0 && sources.requested.contains(n);
                for row in section.rows.clone() {
                    let Some(number) = results.data.numbers.get(row) else { continue };
                    if row % step == 0 || named.contains(&row) || requested(number) {
                        let front = front.contains(&row);
                        rows.push(Row { study, row, number: *number, section: index, front });
                    }
                }
                index += 1;
            }
        }
        Ok(Self { of: (rows.len() < all).then_some(all), rows })
    }

    /// The place in the page of a row of the results of a study.
    pub(super) fn place(&self, study: usize, row: usize) -> Option<usize> {
        self.rows.binary_search_by_key(&(study, row), |r| (r.study, r.row)).ok()
    }
}
