//! The metrics and rows of the results of a study, as reports use them.

use std::collections::BTreeMap;

use smalti::design::statistics::Objective;
use smalti::design::{
    ColumnValues, Condition, ConditionValue, Design, FilterFamily, MetricTarget, MosaicFamily, ResultColumn,
    Study, StudyResults, Trial, TrialProcessing, published,
};
use smalti::metrics::{Better, CATALOG, MetricInfo};

use crate::words::plain;
use crate::{ReportError, names};

/// Different problems that are listed. Further ones are counted together.
const MAX_PROBLEMS: usize = 100;
/// Colour, resolution and noise: the axes of figures, where a study scores them.
pub(super) const MAIN: [&str; 3] = ["delta_e_76", "mtf50_cy_per_mm", "luminance_noise_percent"];
/// The share of saturated samples, which is shown but decides nothing: what it costs is in the other metrics.
const SATURATED: &str = "saturated_percent";
/// Metrics that are left out where the study scores the metric beside them, which measures the same.
const VARIANTS: [(&str, &str); 2] = [("delta_e_2000", "delta_e_76"), ("mtf50_cy_per_px", "mtf50_cy_per_mm")];

/// A metric that the study scores.
#[derive(Debug, Clone)]
pub(super) struct Measure {
    /// The name of its column.
    pub(super) name: String,
    /// Its name, with the scene that it is measured on.
    pub(super) title: String,
    /// The heading of its column in tables: the title with the unit.
    pub(super) header: String,
    /// Digits after the decimal point.
    pub(super) digits: usize,
    pub(super) better: Better,
    /// Its place among the columns, which have the order of the metrics of the study.
    pub(super) place: usize,
    /// One per row; NaN where a trial has no such score.
    pub(super) values: Vec<f64>,
}

impl Measure {
    /// The metric of a column; `None` for columns that hold none.
    fn new((place, ResultColumn { name: column, values, .. }): (usize, &ResultColumn)) -> Option<Self> {
        let ColumnValues::Numbers(values) = values else { return None };
        // The metrics of a scene are named after the metric, then the scene.
        let of = |m: &&MetricInfo| column == m.name || column.starts_with(&format!("{}_", m.name));
        let info = CATALOG.iter().filter(of).max_by_key(|m| m.name.len())?;
        let scene = column.strip_prefix(info.name).unwrap_or_default().replace('_', " ");
        let (title, unit, digits) = match info.name {
            "delta_e_76" => ("ΔE", "", 2),
            "delta_e_2000" => ("ΔE2000", "", 2),
            "mtf50_cy_per_mm" => ("MTF50", " cy/mm", 1),
            "mtf50_cy_per_px" => ("MTF50", " cy/px", 3),
            "luminance_noise_percent" => ("noise", " %", 2),
            "aliasing_percent" => ("aliasing", " %", 1),
            "color_aliasing_percent" => ("colour aliasing", " %", 1),
            "vora_value" => ("Vora value", "", 3),
            "sensitivity_metamerism_index" => ("SMI", "", 1),
            "metamer_mismatch_percent" => ("metamer mismatch", " %", 1),
            "cpsnr_db" => ("CPSNR", " dB", 2),
            "pixel_delta_e_2000_mean" => ("ΔE2000", "", 2),
            "scielab_mean" => ("S-CIELAB", "", 2),
            SATURATED => ("saturated", " %", 2),
            other => (other, "", 2),
        };
        Some(Self {
            name: column.clone(),
            title: format!("{title}{scene}"),
            header: format!("{title}{unit}{scene}"),
            digits,
            better: info.better,
            place,
            values: values.clone(),
        })
    }

    /// Whether designs are compared by it.
    pub(super) fn decides(&self) -> bool {
        !self.name.starts_with(SATURATED)
    }

    /// The objective of the metric over some of its values.
    pub(super) fn objective<'a>(&self, values: &'a [f64]) -> Objective<'a> {
        match self.better {
            Better::Higher => Objective::higher(values),
            Better::Lower | Better::Neither => Objective::lower(values),
        }
    }

    pub(super) fn at(&self, row: usize) -> f64 {
        self.values.get(row).copied().unwrap_or(f64::NAN)
    }

    /// The value of a row as text.
    pub(super) fn text(&self, row: usize) -> String {
        let value = self.at(row);
        if value.is_finite() { format!("{value:.*}", self.digits) } else { "–".into() }
    }
}

/// The results of a study with its metrics prepared for a report.
#[derive(Debug)]
pub struct Results {
    pub(super) data: StudyResults,
    /// Number of colours of each row.
    pub(super) colors: Vec<u8>,
    /// The metrics that the study scores: [`MAIN`] first.
    pub(super) measures: Vec<Measure>,
    /// Why trials have no scores, with the number of trials.
    pub(super) problems: BTreeMap<String, u64>,
}

impl Results {
    /// Prepares the results of a study.
    ///
    /// # Errors
    /// [`ReportError::Column`] and [`ReportError::Colors`] where columns are not those that a sweep writes.
    pub fn new(data: StudyResults) -> Result<Self, ReportError> {
        let wrong = |column: &str| ReportError::Column { origin: data.origin.clone(), column: column.into() };
        let Some(ColumnValues::Integers(colors)) = data.column("colors").map(|c| &c.values) else {
            return Err(wrong("colors"));
        };
        let Some(ColumnValues::Texts(texts)) = data.column("problem").map(|c| &c.values) else {
            return Err(wrong("problem"));
        };
        let color = |&c: &i64| {
            let known = u8::try_from(c).ok().filter(|c| (1..=26).contains(c));
            known.ok_or_else(|| ReportError::Colors { origin: data.origin.clone(), colors: c })
        };
        let colors = colors.iter().map(color).collect::<Result<Vec<u8>, _>>()?;
        let mut problems: BTreeMap<String, u64> = BTreeMap::new();
        for problem in texts.iter().filter(|p| !p.is_empty()) {
            let known = problems.len() < MAX_PROBLEMS || problems.contains_key(&**problem);
            *problems
                .entry(if known { problem.to_string() } else { "other problems".into() })
                .or_default() += 1;
        }
        let mut measures = measures(&data.columns);
        mask(&mut measures, data.numbers.len());
        Ok(Self { colors, measures, problems, data })
    }

    pub(super) fn study(&self) -> &Study {
        self.data.trials.study()
    }

    /// A metric by the name of its column, where the study scores it.
    pub(super) fn measure(&self, name: &str) -> Option<&Measure> {
        self.measures.iter().find(|m| m.name == name)
    }

    /// Whether no trial has any score.
    pub(super) fn has_no_scores(&self) -> bool {
        !self.measures.iter().any(|m| m.values.iter().any(|v| v.is_finite()))
    }

    /// The metrics that designs are compared by, in the order of the study.
    pub(super) fn in_order(&self) -> Vec<&Measure> {
        let mut all: Vec<&Measure> = self.measures.iter().filter(|m| m.decides()).collect();
        all.sort_by_key(|m| m.place);
        all
    }

    /// Whether designs are ranked by the rules for colour and resolution: the study scores both, and colour comes first.
    pub(super) fn ranks_by_color(&self) -> bool {
        let first = self.study().metrics.first();
        self.has_plane() && first.is_none_or(|m| m.target() == MetricTarget::ColorPatches)
    }

    /// Whether designs can be drawn as colour over resolution.
    pub(super) fn has_plane(&self) -> bool {
        self.measure(MAIN[0]).is_some() && self.measure(MAIN[1]).is_some()
    }

    pub(super) fn name(&self) -> String {
        plain(&self.study().name)
    }

    /// What the study investigates, in the words of its file.
    pub(super) fn about(&self) -> String {
        plain(&self.data.about)
    }

    /// The trial of a row.
    pub(super) fn trial(&self, row: usize) -> Result<Trial, ReportError> {
        let number = self.data.numbers.get(row).ok_or(ReportError::Missing { what: "row" })?;
        Ok(self.data.trials.trial(*number)?)
    }

    /// The mosaic of a design: its name where it is from the catalogue, and its tile.
    pub(super) fn mosaic(&self, design: &Design) -> String {
        let tile = design.tile();
        if self.study().mosaics != MosaicFamily::Catalogue {
            return tile;
        }
        let known = published(design.filters.filters.len()).unwrap_or_default();
        match known.into_iter().find(|(_, mosaic)| *mosaic == design.mosaic) {
            Some((info, _)) => format!("{} {tile}", info.name),
            None => tile,
        }
    }

    /// Index of the condition, and processing, of a setup.
    pub(super) fn condition(&self, setup: u64) -> Option<(usize, TrialProcessing)> {
        self.data.trials.setup(setup)
    }

    /// Condition and processing of a setup.
    pub(super) fn setup(&self, setup: u64) -> Option<(&Condition, TrialProcessing)> {
        let (condition, processing) = self.data.trials.setup(setup)?;
        Some((self.study().conditions.get(condition)?, processing))
    }

    /// The condition and processing of a setup in words, as far as they differ within the study. Empty where the study has one setup.
    pub(super) fn setup_name(&self, setup: u64) -> String {
        let Some((condition, way)) = self.setup(setup) else { return String::new() };
        let keys = || condition.values.iter().map(|(key, _)| key.as_str());
        let part = |(key, value): &(String, ConditionValue)| {
            let (name, unit) = names::said(key, keys());
            let number = matches!(value, ConditionValue::Number(_)) && !unit.is_empty();
            plain(&if number { format!("{name} {value} {unit}") } else { format!("{name} {value}") })
        };
        let mut parts: Vec<String> = condition.values.iter().map(part).collect();
        if self.study().processing.len() > 1 {
            parts.push(way.name().to_owned());
        }
        parts.join(", ")
    }

    /// The keys and values of the condition of a setup, as the study states them.
    pub(super) fn setup_keys(&self, setup: u64) -> String {
        let Some((condition, _)) = self.setup(setup) else { return String::new() };
        condition.values.iter().map(|(key, value)| format!("{key} {value}")).collect::<Vec<_>>().join(", ")
    }

    /// Whether the sets of filters come from rules or lists, so that they have names.
    pub(super) fn is_named(&self) -> bool {
        matches!(self.study().filters, FilterFamily::Rule(_) | FilterFamily::List(_))
    }
}

/// The metrics among columns, in the order in which they are shown.
fn measures(columns: &[ResultColumn]) -> Vec<Measure> {
    let has = |name: &str| columns.iter().any(|c| c.name == name);
    let mut all: Vec<Measure> = columns
        .iter()
        .enumerate()
        .filter(|(_, c)| !VARIANTS.iter().any(|(variant, of)| c.name == *variant && has(of)))
        .filter_map(Measure::new)
        .collect();
    all.sort_by_key(|m| MAIN.iter().position(|n| *n == m.name).unwrap_or(MAIN.len()));
    all
}

/// A trial counts in the means of all main metrics or of none: where it lacks one of them, all become NaN.
fn mask(measures: &mut [Measure], rows: usize) {
    let mut main: Vec<&mut Measure> =
        measures.iter_mut().filter(|m| MAIN.contains(&m.name.as_str())).collect();
    for row in 0..rows {
        if main.iter().any(|m| !m.at(row).is_finite()) {
            main.iter_mut().filter_map(|m| m.values.get_mut(row)).for_each(|v| *v = f64::NAN);
        }
    }
}
