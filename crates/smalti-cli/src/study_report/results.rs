//! The columns of a folder of results that a report is made of, and the designs behind its rows.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, bail, ensure};
use serde::Deserialize;
use serde_json::Value;
use smalti::design::{Condition, ConditionValue, Design, Designs, FilterFamily, Processing, Study};
use smalti_io::dataset::{Column, Dataset};

use crate::design_columns::processing;

/// Problems told apart; of more only the number is kept.
const MAX_PROBLEMS: usize = 100;
const ALIASING: &str = "aliasing_percent";

/// A folder of results in memory: some numbers a row. A design without scores has NaN in each of them.
pub(crate) struct Results {
    pub(crate) dataset: Dataset,
    pub(crate) designs: Designs,
    /// Number of the design of each row, ascending.
    pub(crate) number: Vec<u64>,
    pub(crate) colors: Vec<u8>,
    pub(crate) delta_e: Vec<f64>,
    pub(crate) mtf50: Vec<f64>,
    pub(crate) noise: Vec<f64>,
    pub(crate) aliasing: Option<Vec<f64>>,
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
            delta_e: Vec::new(),
            mtf50: Vec::new(),
            noise: Vec::new(),
            aliasing: dataset.manifest().plan.schema.iter().any(|c| c.name == ALIASING).then(Vec::new),
            problems: BTreeMap::new(),
            dataset: dataset.clone(),
        };
        let mut names = vec!["colors", "delta_e_76", "mtf50_cy_per_mm", "luminance_noise_percent", "problem"];
        names.extend(results.aliasing.is_some().then_some(ALIASING));
        for part in dataset.columns(&names)? {
            let part = part?;
            results.number.extend(part.designs.clone());
            results.add(part.columns).with_context(|| format!("{}", dir.display()))?;
        }
        Ok(results)
    }

    fn add(&mut self, columns: Vec<Column>) -> anyhow::Result<()> {
        let mut columns = columns.into_iter();
        let (
            Some(Column::Int(colors)),
            Some(Column::Float(mut delta_e)),
            Some(Column::Float(mut mtf50)),
            Some(Column::Float(mut noise)),
            Some(Column::Text(problems)),
        ) = (columns.next(), columns.next(), columns.next(), columns.next(), columns.next())
        else {
            bail!("its columns hold other things than a sweep writes");
        };
        // A design is scored or not: what counts in one mean counts in all.
        for ((d, m), n) in delta_e.iter_mut().zip(&mut mtf50).zip(&mut noise) {
            if ![*d, *m, *n].iter().all(|v| v.is_finite()) {
                (*d, *m, *n) = (f64::NAN, f64::NAN, f64::NAN);
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
        self.delta_e.append(&mut delta_e);
        self.mtf50.append(&mut mtf50);
        self.noise.append(&mut noise);
        match (&mut self.aliasing, columns.next()) {
            (Some(all), Some(Column::Float(mut here))) => all.append(&mut here),
            (Some(_), _) => bail!("its column {ALIASING} holds other things than a sweep writes"),
            (None, _) => {}
        }
        Ok(())
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

    /// Condition and processing of a setup.
    pub(crate) fn setup(&self, setup: u64) -> Option<(&Condition, Processing)> {
        let (condition, processing) = self.designs.setup(setup)?;
        Some((self.study().conditions.get(condition)?, processing))
    }

    /// What sets a setup apart from the others of the study, in words; empty where there is but one.
    pub(crate) fn setup_name(&self, setup: u64) -> String {
        let Some((condition, way)) = self.setup(setup) else { return String::new() };
        let mut parts: Vec<String> = condition.values.iter().map(|(k, v)| plain(&value(k, v))).collect();
        if self.study().processing.len() > 1 {
            parts.push(processing(way));
        }
        parts.join(", ")
    }

    /// Whether the designs follow rules or lists, so that what they are called says more than their number.
    pub(crate) fn is_named(&self) -> bool {
        matches!(self.study().filters, FilterFamily::Rule(_) | FilterFamily::List(_))
    }
}

fn value(key: &str, value: &ConditionValue) -> String {
    match value {
        ConditionValue::Number(v) => format!("{key} {v}"),
        ConditionValue::Text(v) => format!("{key} {v}"),
    }
}

/// The designs of the study in the manifest.
fn designs(dataset: &Dataset) -> anyhow::Result<Designs> {
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
