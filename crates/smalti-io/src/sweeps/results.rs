//! Reading of the results of a study as plain data.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;
use serde_json::Value;
use smalti::design::{ColumnValues, DesignError, ResultColumn, Study, StudyResults, Trials};
use thiserror::Error;

use crate::dataset::{Column, ColumnKind, ColumnSpec, Dataset, DatasetError};
use crate::studies;

/// The column of the trial numbers, which results hold separately.
const NUMBER: &str = "trial";

/// Why the results of a study cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ResultsError {
    /// The folder cannot be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// This version cannot read the study in the manifest.
    #[error("{}: manifest.json: this version of Smalti cannot read `study`", dir.display())]
    Study {
        /// The folder.
        dir: PathBuf,
        /// The cause.
        source: serde_json::Error,
    },
    /// The study in the manifest has invalid values.
    #[error("{}: manifest.json: `study` is invalid", dir.display())]
    Trials {
        /// The folder.
        dir: PathBuf,
        /// The cause.
        source: Box<DesignError>,
    },
    /// In this version, the study has another number of trials than the manifest states.
    #[error(
        "{}: manifest.json states {stated} trials, but its study has {here} in this version; read it with Smalti {smalti}",
        dir.display()
    )]
    Count {
        /// The folder.
        dir: PathBuf,
        /// Number of trials in this version.
        here: u64,
        /// Number of trials in the manifest.
        stated: u64,
        /// The version that wrote the manifest.
        smalti: String,
    },
    /// The folder has no part.
    #[error("{} holds no trial yet; run `smalti sweep` until it has written a part", dir.display())]
    Empty {
        /// The folder.
        dir: PathBuf,
    },
    /// The values of a column have another type than the manifest states.
    #[error("{}: the values of column {column} have another type than manifest.json states", dir.display())]
    Column {
        /// The folder.
        dir: PathBuf,
        /// The column.
        column: String,
    },
}

/// The trials of the study in the manifest of a folder of results.
///
/// # Errors
/// [`ResultsError::Study`], [`ResultsError::Trials`] and [`ResultsError::Count`].
pub fn read_trials(dataset: &Dataset) -> Result<Trials, ResultsError> {
    let (plan, dir) = (&dataset.manifest().plan, || dataset.dir().to_owned());
    let study =
        Study::deserialize(&plan.study).map_err(|source| ResultsError::Study { dir: dir(), source })?;
    let trials = Trials::new(study).map_err(|e| ResultsError::Trials { dir: dir(), source: Box::new(e) })?;
    if trials.len() != plan.trials {
        let smalti = smalti::names::in_one_line(&dataset.manifest().smalti).into_owned();
        return Err(ResultsError::Count { dir: dir(), here: trials.len(), stated: plan.trials, smalti });
    }
    Ok(trials)
}

/// Reads a folder of results, complete or not, and checks the hash of every part. Columns of lists are omitted.
///
/// # Errors
/// When the folder cannot be read, has no part, or holds the results of a study that this version cannot read.
pub fn read_results(dir: &Path) -> Result<StudyResults, ResultsError> {
    let dataset = Dataset::open(dir)?;
    let trials = read_trials(&dataset)?;
    if dataset.trials() == 0 {
        return Err(ResultsError::Empty { dir: dir.to_owned() });
    }
    let manifest = dataset.manifest();
    let name = &trials.study().name;
    let is_built_in = studies::names().iter().any(|s| s.name == name)
        && studies::load(name).is_ok_and(|(built_in, _)| built_in.study() == trials.study());
    let mut results = StudyResults {
        is_built_in,
        about: manifest.plan.study.get("about").and_then(Value::as_str).unwrap_or_default().to_owned(),
        study_json: format!("{:#}", manifest.plan.study),
        smalti_version: manifest.smalti.clone(),
        plan_blake3: manifest.hash().to_owned(),
        origin: dir.display().to_string(),
        parts: manifest.plan.chunks(),
        parts_missing: dataset.missing().count() as u64,
        numbers: Vec::new(),
        columns: manifest.plan.schema.iter().filter_map(empty).collect(),
        trials,
    };
    let names: Vec<String> = results.columns.iter().map(|c| c.name.clone()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut known: Vec<HashSet<Arc<str>>> = vec![HashSet::new(); names.len()];
    for part in dataset.columns(&names)? {
        let part = part?;
        results.numbers.extend(part.trials);
        for ((whole, more), known) in results.columns.iter_mut().zip(part.columns).zip(&mut known) {
            append(&mut whole.values, more, known)
                .ok_or_else(|| ResultsError::Column { dir: dir.to_owned(), column: whole.name.clone() })?;
        }
    }
    Ok(results)
}

/// A column without rows; `None` for columns that are omitted.
fn empty(spec: &ColumnSpec) -> Option<ResultColumn> {
    let values = match spec.kind {
        ColumnKind::Int if spec.name != NUMBER => ColumnValues::Integers(Vec::new()),
        ColumnKind::Float => ColumnValues::Numbers(Vec::new()),
        ColumnKind::Text => ColumnValues::Texts(Vec::new()),
        ColumnKind::Int | ColumnKind::Floats => return None,
    };
    Some(ResultColumn { name: spec.name.clone(), unit: spec.unit.clone(), doc: spec.doc.clone(), values })
}

/// Appends the rows of a part; `None` if their type differs.
fn append(whole: &mut ColumnValues, more: Column, known: &mut HashSet<Arc<str>>) -> Option<()> {
    match (whole, more) {
        (ColumnValues::Integers(whole), Column::Int(more)) => whole.extend(more),
        (ColumnValues::Numbers(whole), Column::Float(more)) => whole.extend(more),
        (ColumnValues::Texts(whole), Column::Text(more)) => whole.extend(more.into_iter().map(|text| {
            if let Some(there) = known.get(text.as_str()) {
                return Arc::clone(there);
            }
            let text: Arc<str> = text.into();
            known.insert(Arc::clone(&text));
            text
        })),
        _ => return None,
    }
    Some(())
}
