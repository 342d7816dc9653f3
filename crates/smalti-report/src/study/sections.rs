//! The designs of one condition with one processing: groups, best designs, front.

use std::collections::BTreeMap;
use std::ops::Range;

use smalti::design::statistics::{Objective, Rule, Summary, best_per_group, pareto_front, summarize_groups};
use smalti::design::{ColumnValues, Design};
use smalti::metrics::Better;
use smalti::metrics::esfr::{Mtf50Reliability, NYQUIST_CY_PER_PX};

use super::results::{MAIN, Measure, Results};
use crate::ReportError;
use crate::words::{plain, time_ms};

/// The confidence of each interval alone.
pub(super) const CONFIDENCE: f64 = 0.95;
/// Number of best designs for each number of colours.
const BEST: usize = 3;
/// The largest number of designs of a rule family that are grouped by name.
const MAX_NAMED: usize = 20_000;
/// The largest number of names in a table.
const MAX_LABELS: usize = 40;

pub(super) const ALIASING: &str = "aliasing_percent";

/// The columns of the exposure of a target.
struct TargetColumns {
    name: &'static str,
    time_s: &'static str,
    saturated_percent: &'static str,
}

const TARGETS: [TargetColumns; 2] = [
    TargetColumns {
        name: "ColorChecker",
        time_s: "macbeth_time_s",
        saturated_percent: "macbeth_saturated_percent",
    },
    TargetColumns { name: "edge", time_s: "edge_time_s", saturated_percent: "edge_saturated_percent" },
];

/// The least and the greatest of values as text, or the only one; `None` without values.
fn range(values: impl Iterator<Item = f64>, text: impl Fn(f64) -> String, between: &str) -> Option<String> {
    let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let ends = (least <= most).then(|| [least, most].map(text))?;
    Some(if ends[0] == ends[1] { ends[1].clone() } else { ends.join(between) })
}

fn percent(share: f64) -> String {
    format!("{share:.2}")
}

/// The rule that selects the best designs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Choice {
    /// Least ΔE with MTF50 not below the median.
    Color,
    /// Largest MTF50, as in the paper: mosaics with the same filters differ in ΔE by rounding alone.
    Sharpness,
    /// Least aliasing, where it is scored and all mosaics have the same filters.
    Aliasing,
    /// By the metrics of the study in their order, where it does not score both colour and resolution, or names another one first.
    Order,
}

impl Choice {
    fn of(results: &Results) -> Self {
        if !results.ranks_by_color() {
            return Self::Order;
        }
        let mut groups = results.data.trials.groups().filter(|(_, sets, mosaics)| sets * *mosaics as u64 > 0);
        match (groups.all(|(_, sets, _)| sets == 1), results.measure(ALIASING)) {
            (true, Some(_)) => Self::Aliasing,
            (true, None) => Self::Sharpness,
            (false, _) => Self::Color,
        }
    }

    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Color => "least ΔE with MTF50 not below the median",
            Self::Sharpness => "largest MTF50, since the filters are the same in every mosaic",
            Self::Aliasing => "least aliasing, since the filters are the same in every mosaic",
            Self::Order => "by the first metric of the study; equal designs by the next metric",
        }
    }
}

/// The designs of one condition with one processing. Rows are counted as in the results.
pub(super) struct Section<'a> {
    pub(super) results: &'a Results,
    pub(super) setup: u64,
    /// Condition and processing in words; empty where the study has one of each.
    pub(super) name: String,
    pub(super) rows: Range<usize>,
    pub(super) choice: Choice,
    pub(super) groups: Vec<Group>,
    /// The Pareto front of ΔE, MTF50 and luminance noise, or of all metrics where fewer than two of these are scored. Sorted by
    /// falling MTF50.
    pub(super) front: Vec<usize>,
    /// Designs by the name of their filters and their number of colours. Empty where filters have no names.
    pub(super) labels: BTreeMap<String, BTreeMap<u8, Vec<usize>>>,
}

/// Designs of one number of colours.
pub(super) struct Group {
    pub(super) colors: u8,
    /// Summaries of colour, resolution and noise. One that the study does not score has no designs.
    pub(super) delta_e: Summary,
    pub(super) mtf50: Summary,
    pub(super) noise: Summary,
    /// Summaries of all metrics of the study.
    pub(super) summaries: Vec<Summary>,
    /// The best designs by the rule of the section, best first.
    pub(super) best: Vec<usize>,
    /// The design of largest ΔE, or the worst by the first metric.
    pub(super) worst: Option<usize>,
}

impl Group {
    /// The numbers of designs with and without scores.
    pub(super) fn counts(&self) -> (usize, usize) {
        self.summaries.first().map_or((0, 0), |s| (s.count, s.left_out))
    }
}

impl<'a> Section<'a> {
    /// A number of a row; `None` where the results or the trial lack it.
    fn number(&self, column: &str, row: usize) -> Option<f64> {
        match &self.results.data.column(column)?.values {
            ColumnValues::Numbers(values) => values.get(row).copied().filter(|v| v.is_finite()),
            _ => None,
        }
    }

    /// The exposure times of the targets in rows, ms, and the larger share of saturated samples of each row, percent. A dash where
    /// nothing is known.
    pub(super) fn exposure_cells(&self, rows: &[usize]) -> [String; 2] {
        let times = rows.iter().flat_map(|row| TARGETS.map(|t| self.number(t.time_s, *row)));
        let times = times.flatten().map(|time_s| time_s * 1e3);
        let larger = |row: &usize| {
            TARGETS.iter().filter_map(|t| self.number(t.saturated_percent, *row)).reduce(f64::max)
        };
        [range(times, time_ms, "–"), range(rows.iter().filter_map(larger), percent, "–")]
            .map(|range| range.unwrap_or_else(|| "–".into()))
    }

    /// The exposure of the targets, which automatic exposure chooses for each design, as a sentence; `None` where the results have none.
    pub(super) fn exposure_in_words(&self) -> Option<String> {
        let of_target = |target: &TargetColumns| {
            let of = |column| self.rows.clone().filter_map(move |row| self.number(column, row));
            let times = range(of(target.time_s).map(|time_s| time_s * 1e3), time_ms, " to ")?;
            let share = match range(of(target.saturated_percent), percent, " to ") {
                Some(share) => format!("{share} % of the samples saturated"),
                None => "share of saturated samples not in these results".into(),
            };
            Some(format!("{} {times} ms ({share})", target.name))
        };
        let targets: Vec<String> = TARGETS.iter().filter_map(of_target).collect();
        (!targets.is_empty()).then(|| format!("Exposure: {}.", targets.join(", ")))
    }

    /// Whether the MTF50 of a row can be trusted as a resolution. Results without this judgement have the sampling limit alone.
    pub(super) fn reliability(&self, row: usize) -> Mtf50Reliability {
        use Mtf50Reliability::{BeyondNyquist, Plateau, Reliable};
        if let Some(ColumnValues::Texts(names)) =
            self.results.data.column("mtf50_reliability").map(|c| &c.values)
        {
            let name = names.get(row).map_or("", |name| &**name);
            return [BeyondNyquist, Plateau].into_iter().find(|r| r.name() == name).unwrap_or(Reliable);
        }
        let limits = [(MAIN[1], self.nyquist_cy_per_mm()), ("mtf50_cy_per_px", Some(NYQUIST_CY_PER_PX))];
        let is_beyond = |(name, limit): (&str, Option<f64>)| {
            limit.zip(self.number(name, row)).is_some_and(|(limit, mtf50)| mtf50 > limit)
        };
        if limits.into_iter().any(is_beyond) { BeyondNyquist } else { Reliable }
    }

    /// How many designs have an MTF50 that is no resolution, as a sentence; `None` if none.
    pub(super) fn unreliable_in_words(&self) -> Option<String> {
        let count = |of| self.rows.clone().filter(|row| self.reliability(*row) == of).count();
        let [beyond, plateau] = [Mtf50Reliability::BeyondNyquist, Mtf50Reliability::Plateau].map(count);
        let designs = |count: usize| format!("{count} design{}", if count == 1 { "" } else { "s" });
        let beyond = (beyond > 0).then(|| format!("{} beyond the Nyquist frequency", designs(beyond)));
        let plateau = (plateau > 0)
            .then(|| format!("{} whose edge response stays near one half or rises again", designs(plateau)));
        let found: Vec<String> = beyond.into_iter().chain(plateau).collect();
        (!found.is_empty()).then(|| format!("Means contain the MTF50 of {}.", found.join(" and ")))
    }

    /// All sections of the results of a study.
    pub(super) fn all(results: &'a Results) -> Result<Vec<Self>, ReportError> {
        let mut sections = Vec::new();
        let mut start = 0;
        while let Some(&first) = results.data.numbers.get(start) {
            let setup = results.data.trials.setup_of(first);
            // Numbers ascend, so the designs of a setup are consecutive.
            let rest = results.data.numbers.get(start..).unwrap_or_default();
            let end = start + rest.partition_point(|&n| results.data.trials.setup_of(n) == setup);
            sections.push(Self::new(results, setup, start..end)?);
            start = end;
        }
        Ok(sections)
    }

    fn new(results: &'a Results, setup: u64, rows: Range<usize>) -> Result<Self, ReportError> {
        let colors = results.colors.get(rows.clone()).unwrap_or_default();
        let none = vec![f64::NAN; rows.len()];
        let part = |m: &'a Measure| m.values.get(rows.clone()).unwrap_or_default();
        let main: [&[f64]; 3] = MAIN.map(|name| match results.measure(name) {
            Some(measure) => part(measure),
            None => &none,
        });
        let [delta_e, mtf50, _] = main;
        let summaries = |column| summarize_groups(colors, column, CONFIDENCE);
        let objectives = |measures: &[&'a Measure]| -> Vec<Objective<'a>> {
            measures.iter().map(|m| m.objective(part(m))).collect()
        };
        let all = results.in_order();
        let choice = Choice::of(results);
        let rule = match choice {
            Choice::Color => {
                Rule::Keeping { best: Objective::lower(delta_e), keep: Objective::higher(mtf50) }
            }
            Choice::Sharpness => {
                Rule::Lexicographic(vec![Objective::higher(mtf50), Objective::lower(delta_e)])
            }
            Choice::Aliasing => {
                let aliasing = all.iter().copied().filter(|m| m.name == ALIASING).collect::<Vec<_>>();
                Rule::Lexicographic([objectives(&aliasing), vec![Objective::higher(mtf50)]].concat())
            }
            Choice::Order => Rule::Lexicographic(objectives(&all)),
        };
        let best = best_per_group(colors, &rule, BEST)?;
        let last = match (results.ranks_by_color(), all.first()) {
            (false, Some(m)) if m.better == Better::Higher => Objective::lower(part(m)),
            (false, Some(m)) => Objective::higher(part(m)),
            _ => Objective::higher(delta_e),
        };
        let worst = best_per_group(colors, &Rule::Lexicographic(vec![last]), 1)?;
        let absolute = |r: &usize| rows.start + r;
        let of_measures =
            results.measures.iter().map(|m| summaries(part(m))).collect::<Result<Vec<_>, _>>()?;
        let of = |name: &str| match results.measures.iter().position(|m| m.name == name) {
            Some(place) => Ok(of_measures.get(place).cloned().unwrap_or_default()),
            None => summaries(&none),
        };
        let groups = of(MAIN[0])?
            .into_iter()
            .zip(of(MAIN[1])?)
            .zip(of(MAIN[2])?)
            .zip(best.iter().zip(&worst))
            .enumerate()
            .map(|(i, ((((colors, delta_e), (_, mtf50)), (_, noise)), ((_, best), (_, worst))))| Group {
                colors,
                delta_e,
                mtf50,
                noise,
                summaries: of_measures.iter().filter_map(|s| Some(s.get(i)?.1)).collect(),
                best: best.iter().map(absolute).collect(),
                worst: worst.first().map(absolute),
            })
            .collect();
        let mut front = pareto_front(&objectives(&compared(results)))?.rows;
        front.iter_mut().for_each(|r| *r += rows.start);
        let order = results.measure(MAIN[1]).or(results.measures.first());
        let sharp = |r: &usize| order.map_or(f64::NAN, |m| m.at(*r));
        front.sort_by(|a, b| sharp(b).total_cmp(&sharp(a)));
        let labels = labels(results, rows.clone())?;
        Ok(Self { results, setup, name: results.setup_name(setup), rows, choice, groups, front, labels })
    }

    /// Study, condition and processing in words.
    pub(super) fn title(&self) -> String {
        if self.name.is_empty() {
            self.results.name()
        } else {
            format!("{}: {}", self.results.name(), self.name)
        }
    }

    /// The rows of a number of colours.
    pub(super) fn rows_of(&self, colors: u8) -> impl Iterator<Item = usize> {
        self.rows.clone().filter(move |&r| self.results.colors.get(r) == Some(&colors))
    }

    /// ΔE, MTF50 in cy/mm and luminance noise in percent of a row.
    pub(super) fn scores(&self, row: usize) -> [f64; 3] {
        MAIN.map(|name| self.results.measure(name).map_or(f64::NAN, |m| m.at(row)))
    }

    /// The Nyquist frequency of the samples.
    pub(super) fn nyquist_cy_per_mm(&self) -> Option<f64> {
        let (condition, _) = self.results.setup(self.setup)?;
        Some(0.5 / (condition.camera.sensor.sample_pitch_um()? * 1e-3))
    }

    /// The metrics that the front compares, in words.
    pub(super) fn compared_in_words(&self) -> String {
        let names: Vec<&str> = compared(self.results).iter().map(|m| m.title.as_str()).collect();
        match names.split_last() {
            Some((last, rest)) if !rest.is_empty() => format!("{} and {last} at once", rest.join(", ")),
            _ => names.concat(),
        }
    }

    /// At most `count` designs of the front at even distances in its order, from the first to the last.
    pub(super) fn some_of_front(&self, count: usize) -> Vec<usize> {
        let last = self.front.len().saturating_sub(1);
        let shown = count.min(self.front.len());
        let place = |i: usize| if shown > 1 { i * last / (shown - 1) } else { 0 };
        (0..shown).filter_map(|i| self.front.get(place(i)).copied()).collect()
    }
}

/// Colour, resolution and noise where at least two of them are scored; otherwise all metrics.
fn compared(results: &Results) -> Vec<&Measure> {
    let main: Vec<&Measure> = MAIN.iter().filter_map(|name| results.measure(name)).collect();
    if main.len() < 2 { results.in_order() } else { main }
}

/// Rows by the name of their filters, where filters have names.
fn labels(
    results: &Results,
    rows: Range<usize>,
) -> Result<BTreeMap<String, BTreeMap<u8, Vec<usize>>>, ReportError> {
    let mut labels: BTreeMap<String, BTreeMap<u8, Vec<usize>>> = BTreeMap::new();
    if !results.is_named() || rows.len() > MAX_NAMED {
        return Ok(labels);
    }
    for row in rows {
        let colors = results.colors.get(row).copied().unwrap_or_default();
        let label = label(&results.trial(row)?.design);
        labels.entry(label).or_default().entry(colors).or_default().push(row);
        if labels.len() > MAX_LABELS {
            return Ok(BTreeMap::new());
        }
    }
    Ok(labels)
}

/// The name of the filters of a design, without their number, which is stated beside it.
pub(super) fn label(design: &Design) -> String {
    let label = plain(&design.filters.label);
    let number = format!(", {}", design.filters.filters.len());
    label.strip_suffix(&number).unwrap_or(&label).to_owned()
}
