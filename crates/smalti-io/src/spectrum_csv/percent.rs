//! Transmittances as fractions, from files in fractions or in percent.

use smalti::spectrum::Spectrum;

use super::SpectrumTable;
use crate::IoError;
use crate::error::At;

/// The largest fraction; the margin is noise of a measurement.
const LARGEST_FRACTION: f64 = 1.001;
/// The largest percentage.
const LARGEST_PERCENT: f64 = 100.1;
/// Columns without a unit whose largest value is above this one are in percent. Those between it and [`LARGEST_FRACTION`] can be
/// fractions that are not normalised.
const LEAST_PERCENT: f64 = 5.0;

/// Columns of a table as transmittances.
#[derive(Debug, Clone, PartialEq)]
pub struct Transmittances {
    /// Name and values, 0 to 1, of each column.
    pub columns: Vec<(String, Spectrum)>,
    /// What was recognised about the file, and is to be told; `None` for commas, decimal points and fractions.
    pub note: Option<String>,
}

impl SpectrumTable {
    /// Columns with transmittances or quantum efficiencies, as fractions. They are in percent if a heading states it, or if their
    /// largest values are above 5.
    ///
    /// # Errors
    /// When a column is absent, a value is above 100 % (with its line and column), a column is neither in fractions nor in percent, or
    /// columns differ in their unit.
    pub fn transmittances(&self, names: &[&str]) -> Result<Transmittances, IoError> {
        let chosen = names.iter().map(|name| self.index(name)).collect::<Result<Vec<_>, IoError>>()?;
        let is_percent = |&&i: &&usize| self.facts[i].is_percent || self.facts[i].largest.0 > LEAST_PERCENT;
        let percent = chosen.iter().find(is_percent).copied();
        // The largest first: what is above 100 % is no percentage that others could be compared with.
        let mut descending = chosen.clone();
        descending.sort_by(|&a, &b| self.facts[b].largest.0.total_cmp(&self.facts[a].largest.0));
        descending.iter().try_for_each(|&i| self.check(i, percent))?;
        let scale = if percent.is_some() { 0.01 } else { 1.0 };
        let column = |&i: &usize| {
            let (name, values) = &self.columns[i];
            Ok((
                name.clone(),
                if scale == 1.0 { values.clone() } else { values.scaled(scale).at(&self.path)? },
            ))
        };
        let columns = chosen.iter().map(column).collect::<Result<_, IoError>>()?;
        let note = self.note(percent.map(|_| "values in percent, divided by 100"));
        Ok(Transmittances { columns, note })
    }

    /// What is to be told about the file of a column of relative values, whose scale has no meaning.
    ///
    /// # Errors
    /// When the heading states percent and a value is above 100 %.
    pub(super) fn relative(&self, column: usize) -> Result<Option<String>, IoError> {
        let is_percent = self.facts[column].is_percent;
        if is_percent {
            self.check(column, Some(column))?;
        }
        Ok(self.note(is_percent.then_some("values in percent")))
    }

    /// What was recognised about the file, with something about its values.
    fn note(&self, values: Option<&'static str>) -> Option<String> {
        let mut facts = self.recognised();
        facts.extend(values);
        (!facts.is_empty()).then(|| format!("{}: {}", self.path.display(), facts.join(", ")))
    }

    /// Checks the largest value of a column. `percent` is a column in percent, if there is one.
    fn check(&self, i: usize, percent: Option<usize>) -> Result<(), IoError> {
        let (value, line) = self.facts[i].largest;
        let wrong = |expected: String| {
            let found = format!("{value} in column '{}'", self.columns[i].0);
            Err(IoError::line(&self.path, line, found, &expected))
        };
        match percent {
            None if value > LARGEST_FRACTION => wrong(
                "a transmittance from 0 to 1, or percent, which a heading such as 'R (%)' states for values as low as these"
                    .into(),
            ),
            None => Ok(()),
            Some(_) if value > LARGEST_PERCENT => wrong(
                "at most 100 %; divide values in another unit, such as digital numbers, by their maximum"
                    .into(),
            ),
            Some(_) if self.facts[i].is_percent || value > LEAST_PERCENT => Ok(()),
            Some(other) => {
                let ((largest, at), name) = (self.facts[other].largest, &self.columns[other].0);
                wrong(format!(
                    "percent as in column '{name}' ({largest} in line {at}): columns are all in percent or all from 0 to 1; \
                     headings such as 'R (%)' state percent for values as low as these"
                ))
            }
        }
    }
}
