//! What the designs of one condition with one processing say.

use std::collections::BTreeMap;
use std::ops::Range;

use smalti::design::Design;
use smalti::design::statistics::{Objective, Rule, Summary, best_per_group, pareto_front, summarize_groups};

use super::results::{Results, plain};

/// Of each interval by itself.
pub(crate) const CONFIDENCE: f64 = 0.95;
/// Best designs kept for each number of colours.
const BEST: usize = 3;
/// Most designs of a rule family that are told apart by name.
const MAX_NAMED: usize = 20_000;
/// Most names in a table.
const MAX_LABELS: usize = 40;

/// What makes the best design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Choice {
    /// Least ΔE with MTF50 not below the median.
    Color,
    /// Largest MTF50, as the paper chose mosaics: with the same filters in each, ΔE differs by rounding.
    Sharpness,
}

impl Choice {
    fn of(results: &Results) -> Self {
        let mut groups = results.designs.groups().filter(|(_, sets, mosaics)| sets * *mosaics as u64 > 0);
        if groups.all(|(_, sets, _)| sets == 1) { Self::Sharpness } else { Self::Color }
    }

    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Color => "least ΔE with MTF50 not below the median",
            Self::Sharpness => "largest MTF50, since the filters are the same in every mosaic",
        }
    }
}

/// The designs of one condition with one processing; rows are those of the results.
pub(crate) struct Section<'a> {
    pub(crate) results: &'a Results,
    pub(crate) setup: u64,
    /// Condition and processing in words; empty where the study has one of each.
    pub(crate) name: String,
    pub(crate) rows: Range<usize>,
    pub(crate) choice: Choice,
    pub(crate) groups: Vec<Group>,
    /// Designs that none beats in ΔE, MTF50 and luminance noise at once; from the sharpest down.
    pub(crate) front: Vec<usize>,
    /// Designs by what their filters are called and number of colours; empty where they have no names.
    pub(crate) labels: BTreeMap<String, BTreeMap<u8, Vec<usize>>>,
}

/// Designs of one number of colours.
pub(crate) struct Group {
    pub(crate) colors: u8,
    pub(crate) delta_e: Summary,
    pub(crate) mtf50: Summary,
    pub(crate) noise: Summary,
    pub(crate) aliasing: Option<Summary>,
    /// The best designs by the choice of the section, best first.
    pub(crate) best: Vec<usize>,
    /// The design of largest ΔE.
    pub(crate) worst: Option<usize>,
}

impl<'a> Section<'a> {
    /// The sections of a folder of results.
    pub(crate) fn all(results: &'a Results) -> anyhow::Result<Vec<Self>> {
        let mut sections = Vec::new();
        let mut start = 0;
        while let Some(&first) = results.number.get(start) {
            let setup = results.designs.setup_of(first);
            // Numbers ascend, so those of a setup are neighbours.
            let rest = results.number.get(start..).unwrap_or_default();
            let end = start + rest.partition_point(|&n| results.designs.setup_of(n) == setup);
            sections.push(Self::new(results, setup, start..end)?);
            start = end;
        }
        Ok(sections)
    }

    fn new(results: &'a Results, setup: u64, rows: Range<usize>) -> anyhow::Result<Self> {
        let part = |column: &'a [f64]| column.get(rows.clone()).unwrap_or_default();
        let colors = results.colors.get(rows.clone()).unwrap_or_default();
        let [delta_e, mtf50, noise] = [&results.delta_e, &results.mtf50, &results.noise].map(|c| part(c));
        let summaries = |column| summarize_groups(colors, column, CONFIDENCE);
        let choice = Choice::of(results);
        let rule = match choice {
            Choice::Color => {
                Rule::Keeping { best: Objective::lower(delta_e), keep: Objective::higher(mtf50) }
            }
            Choice::Sharpness => {
                Rule::Lexicographic(vec![Objective::higher(mtf50), Objective::lower(delta_e)])
            }
        };
        let best = best_per_group(colors, &rule, BEST)?;
        let worst = best_per_group(colors, &Rule::Lexicographic(vec![Objective::higher(delta_e)]), 1)?;
        let mut aliasing = match &results.aliasing {
            Some(column) => summaries(part(column))?.into_iter().map(|(_, s)| Some(s)).collect(),
            None => Vec::new(),
        }
        .into_iter();
        let absolute = |r: &usize| rows.start + r;
        let groups = summaries(delta_e)?
            .into_iter()
            .zip(summaries(mtf50)?)
            .zip(summaries(noise)?)
            .zip(best.iter().zip(&worst))
            .map(|((((colors, delta_e), (_, mtf50)), (_, noise)), ((_, best), (_, worst)))| Group {
                colors,
                delta_e,
                mtf50,
                noise,
                aliasing: aliasing.next().flatten(),
                best: best.iter().map(absolute).collect(),
                worst: worst.first().map(absolute),
            })
            .collect();
        let mut front =
            pareto_front(&[Objective::lower(delta_e), Objective::higher(mtf50), Objective::lower(noise)])?
                .rows;
        front.iter_mut().for_each(|r| *r += rows.start);
        let mtf50_of = |r: &usize| results.mtf50.get(*r).copied().unwrap_or(f64::NAN);
        front.sort_by(|a, b| mtf50_of(b).total_cmp(&mtf50_of(a)));
        let labels = labels(results, rows.clone())?;
        Ok(Self { results, setup, name: results.setup_name(setup), rows, choice, groups, front, labels })
    }

    /// Study, condition and processing in words.
    pub(crate) fn title(&self) -> String {
        if self.name.is_empty() {
            self.results.name()
        } else {
            format!("{}: {}", self.results.name(), self.name)
        }
    }

    /// The rows of a number of colours.
    pub(crate) fn rows_of(&self, colors: u8) -> impl Iterator<Item = usize> {
        self.rows.clone().filter(move |&r| self.results.colors.get(r) == Some(&colors))
    }

    /// ΔE, MTF50 in cy/mm and luminance noise in percent of a row.
    pub(crate) fn scores(&self, row: usize) -> [f64; 3] {
        let r = self.results;
        [&r.delta_e, &r.mtf50, &r.noise].map(|c| c.get(row).copied().unwrap_or(f64::NAN))
    }

    /// Aliasing of a row, percent.
    pub(crate) fn aliasing(&self, row: usize) -> Option<f64> {
        self.results.aliasing.as_ref()?.get(row).copied().filter(|v| v.is_finite())
    }

    /// At most `count` designs of the front, from the sharpest to the last, evenly spread.
    pub(crate) fn some_of_front(&self, count: usize) -> Vec<usize> {
        let last = self.front.len().saturating_sub(1);
        let shown = count.min(self.front.len());
        let place = |i: usize| if shown > 1 { i * last / (shown - 1) } else { 0 };
        (0..shown).filter_map(|i| self.front.get(place(i)).copied()).collect()
    }
}

/// Rows by what the filters are called, where they have names.
fn labels(
    results: &Results,
    rows: Range<usize>,
) -> anyhow::Result<BTreeMap<String, BTreeMap<u8, Vec<usize>>>> {
    let mut labels: BTreeMap<String, BTreeMap<u8, Vec<usize>>> = BTreeMap::new();
    if !results.is_named() || rows.len() > MAX_NAMED {
        return Ok(labels);
    }
    for row in rows {
        let colors = results.colors.get(row).copied().unwrap_or_default();
        let label = label(&results.design(row)?);
        labels.entry(label).or_default().entry(colors).or_default().push(row);
        if labels.len() > MAX_LABELS {
            return Ok(BTreeMap::new());
        }
    }
    Ok(labels)
}

/// What the filters of a design are called, without their number, which stands beside it.
pub(crate) fn label(design: &Design) -> String {
    let label = plain(&design.filters.label);
    let number = format!(", {}", design.filters.filters.len());
    label.strip_suffix(&number).unwrap_or(&label).to_owned()
}
