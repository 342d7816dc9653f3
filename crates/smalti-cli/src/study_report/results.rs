//! The columns of a folder of results that a report is made of, and the designs behind its rows.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, bail, ensure};
use serde::Deserialize;
use serde_json::Value;
use smalti::design::statistics::Objective;
use smalti::design::{
    Condition, ConditionValue, Design, Designs, FilterFamily, MosaicFamily, Processing, Study, published,
};
use smalti::metrics::{Better, CATALOG, MetricInfo};
use smalti_io::dataset::{Column, ColumnKind, ColumnSpec, Dataset};
use smalti_io::sweeps::processing;

use crate::names;

/// Problems told apart; of more only the number is kept.
const MAX_PROBLEMS: usize = 100;
/// Colour, resolution, noise: what figures are drawn over, where a study scores it.
pub(crate) const MAIN: [&str; 3] = ["delta_e_76", "mtf50_cy_per_mm", "luminance_noise_percent"];
/// Metrics that say again what another says, which is shown in their place where it is there.
const VARIANTS: [(&str, &str); 2] = [("delta_e_2000", "delta_e_76"), ("mtf50_cy_per_px", "mtf50_cy_per_mm")];

/// A metric that the study scores.
pub(crate) struct Measure {
    /// The name of its column.
    pub(crate) name: String,
    /// What it is called above a column of a table.
    pub(crate) header: String,
    /// Digits after the point.
    pub(crate) digits: usize,
    pub(crate) better: Better,
    /// One a row; NaN where a design has no such score.
    pub(crate) values: Vec<f64>,
}

impl Measure {
    fn new(column: &str) -> Option<Self> {
        // Of scenes: the metric, then the scene.
        let of = |m: &&MetricInfo| column == m.name || column.starts_with(&format!("{}_", m.name));
        let info = CATALOG.iter().filter(of).max_by_key(|m| m.name.len())?;
        let scene = column.strip_prefix(info.name).unwrap_or_default().replace('_', " ");
        let (header, digits) = match info.name {
            "delta_e_76" => ("ΔE", 2),
            "delta_e_2000" => ("ΔE2000", 2),
            "mtf50_cy_per_mm" => ("MTF50 cy/mm", 1),
            "mtf50_cy_per_px" => ("MTF50 cy/px", 3),
            "luminance_noise_percent" => ("noise %", 2),
            "aliasing_percent" => ("aliasing %", 1),
            "color_aliasing_percent" => ("colour aliasing %", 1),
            "cpsnr_db" => ("CPSNR dB", 2),
            "pixel_delta_e_2000_mean" => ("ΔE2000", 2),
            "scielab_mean" => ("S-CIELAB", 2),
            other => (other, 2),
        };
        Some(Self {
            name: column.to_owned(),
            header: format!("{header}{scene}"),
            digits,
            better: info.better,
            values: Vec::new(),
        })
    }

    /// What makes a design better, of a part of the rows.
    pub(crate) fn objective<'a>(&self, values: &'a [f64]) -> Objective<'a> {
        match self.better {
            Better::Higher => Objective::higher(values),
            Better::Lower | Better::Neither => Objective::lower(values),
        }
    }

    pub(crate) fn at(&self, row: usize) -> f64 {
        self.values.get(row).copied().unwrap_or(f64::NAN)
    }

    /// The value of a row in words.
    pub(crate) fn text(&self, row: usize) -> String {
        let value = self.at(row);
        if value.is_finite() { format!("{value:.*}", self.digits) } else { "–".into() }
    }
}

/// A folder of results in memory: some numbers a row.
pub(crate) struct Results {
    pub(crate) dataset: Dataset,
    pub(crate) designs: Designs,
    /// Number of the design of each row, ascending.
    pub(crate) number: Vec<u64>,
    pub(crate) colors: Vec<u8>,
    /// What the study scores: [`MAIN`] first.
    pub(crate) measures: Vec<Measure>,
    /// Why designs have no scores, and how many.
    pub(crate) problems: BTreeMap<String, u64>,
}

impl Results {
    pub(crate) fn read(dir: &Path) -> anyhow::Result<Self> {
        let dataset = Dataset::open(dir)?;
        let designs = designs(&dataset).with_context(|| format!("{}", dir.display()))?;
        ensure!(
            dataset.designs() > 0,
            "{} holds no design yet: run `smalti sweep` until some are scored",
            dir.display()
        );
        let mut results = Self {
            designs,
            number: Vec::new(),
            colors: Vec::new(),
            measures: measures(&dataset.manifest().plan.schema),
            problems: BTreeMap::new(),
            dataset: dataset.clone(),
        };
        let measured = results.measures.iter().map(|m| m.name.clone()).collect::<Vec<_>>();
        let names: Vec<&str> =
            ["colors", "problem"].into_iter().chain(measured.iter().map(String::as_str)).collect();
        for part in dataset.columns(&names)? {
            let part = part?;
            results.number.extend(part.designs.clone());
            results.add(part.columns).with_context(|| format!("{}", dir.display()))?;
        }
        Ok(results)
    }

    fn add(&mut self, columns: Vec<Column>) -> anyhow::Result<()> {
        let mut columns = columns.into_iter();
        let (Some(Column::Int(colors)), Some(Column::Text(problems))) = (columns.next(), columns.next())
        else {
            bail!("its columns hold other things than a sweep writes");
        };
        let first = self.number.len() - colors.len();
        for (measure, column) in self.measures.iter_mut().zip(columns) {
            let Column::Float(mut values) = column else {
                bail!("its column {} holds other things than a sweep writes", measure.name)
            };
            measure.values.append(&mut values);
        }
        // A design is scored or not: what counts in one of the main means counts in all.
        let mut main: Vec<&mut Measure> =
            self.measures.iter_mut().filter(|m| MAIN.contains(&m.name.as_str())).collect();
        for row in first..self.number.len() {
            if main.iter().any(|m| !m.at(row).is_finite()) {
                main.iter_mut().filter_map(|m| m.values.get_mut(row)).for_each(|v| *v = f64::NAN);
            }
        }
        for problem in problems.into_iter().filter(|p| !p.is_empty()) {
            let known = self.problems.len() < MAX_PROBLEMS || self.problems.contains_key(&problem);
            *self.problems.entry(if known { problem } else { "other problems".into() }).or_default() += 1;
        }
        for c in colors {
            self.colors.push(
                u8::try_from(c)
                    .ok()
                    .filter(|c| (1..=26).contains(c))
                    .with_context(|| format!("a design has {c} colours; expected 1 to 26"))?,
            );
        }
        Ok(())
    }

    /// A metric by the name of its column, where the study scores it.
    pub(crate) fn measure(&self, name: &str) -> Option<&Measure> {
        self.measures.iter().find(|m| m.name == name)
    }

    /// Whether designs can be drawn as colour over resolution.
    pub(crate) fn has_plane(&self) -> bool {
        self.measure(MAIN[0]).is_some() && self.measure(MAIN[1]).is_some()
    }

    pub(crate) fn study(&self) -> &Study {
        self.designs.study()
    }

    pub(crate) fn name(&self) -> String {
        plain(&self.study().name)
    }

    /// What the study asks, as its file says.
    pub(crate) fn about(&self) -> String {
        let study = &self.dataset.manifest().plan.study;
        plain(study.get("about").and_then(Value::as_str).unwrap_or_default())
    }

    /// The design of a row.
    pub(crate) fn design(&self, row: usize) -> anyhow::Result<Design> {
        let number = self.number.get(row).context("no such row")?;
        Ok(self.designs.design(*number)?)
    }

    /// The mosaic of a design: its name in the catalogue where it is of it, and its tile.
    pub(crate) fn mosaic(&self, design: &Design) -> String {
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

    /// Condition and processing of a setup.
    pub(crate) fn setup(&self, setup: u64) -> Option<(&Condition, Processing)> {
        let (condition, processing) = self.designs.setup(setup)?;
        Some((self.study().conditions.get(condition)?, processing))
    }

    /// What sets a setup apart from the others of the study, in words; empty where there is but one.
    pub(crate) fn setup_name(&self, setup: u64) -> String {
        let Some((condition, way)) = self.setup(setup) else { return String::new() };
        let keys = || condition.values.iter().map(|(key, _)| key.as_str());
        let part = |(key, value): &(String, ConditionValue)| {
            let (name, unit) = names::said(key, keys());
            let number = matches!(value, ConditionValue::Number(_)) && !unit.is_empty();
            plain(&if number { format!("{name} {value} {unit}") } else { format!("{name} {value}") })
        };
        let mut parts: Vec<String> = condition.values.iter().map(part).collect();
        if self.study().processing.len() > 1 {
            parts.push(processing(way));
        }
        parts.join(", ")
    }

    /// The keys and values of a condition as the study has them.
    pub(crate) fn setup_keys(&self, setup: u64) -> String {
        let Some((condition, _)) = self.setup(setup) else { return String::new() };
        condition.values.iter().map(|(key, value)| format!("{key} {value}")).collect::<Vec<_>>().join(", ")
    }

    /// Whether the designs follow rules or lists, so that what they are called says more than their number.
    pub(crate) fn is_named(&self) -> bool {
        matches!(self.study().filters, FilterFamily::Rule(_) | FilterFamily::List(_))
    }
}

/// The metrics of a schema in the order in which they are shown.
fn measures(schema: &[ColumnSpec]) -> Vec<Measure> {
    let has = |name: &str| schema.iter().any(|c| c.name == name);
    let mut all: Vec<Measure> = schema
        .iter()
        .filter(|c| c.kind == ColumnKind::Float)
        .filter(|c| !VARIANTS.iter().any(|(variant, of)| c.name == *variant && has(of)))
        .filter_map(|c| Measure::new(&c.name))
        .collect();
    all.sort_by_key(|m| MAIN.iter().position(|n| *n == m.name).unwrap_or(MAIN.len()));
    all
}

/// The designs of the study in the manifest.
pub(super) fn designs(dataset: &Dataset) -> anyhow::Result<Designs> {
    let plan = &dataset.manifest().plan;
    let study =
        Study::deserialize(&plan.study).context("manifest.json: `study` is not one of this version")?;
    let designs = Designs::new(study).context("manifest.json: `study`")?;
    ensure!(
        designs.len() == plan.designs,
        "manifest.json: its study has {} designs in this version, {} are stated; report it with Smalti {}",
        designs.len(),
        plan.designs,
        plain(&dataset.manifest().smalti),
    );
    Ok(designs)
}

/// Text of a file without what would steer a terminal.
pub(crate) fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
