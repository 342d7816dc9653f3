//! Studies of many designs, and their results.

use std::path::PathBuf;
use std::str::FromStr;

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use smalti::design::{Sweep, Trials};
use smalti_io::TomlSource;
use smalti_io::dataset::{self, Column, Dataset, Shard};
use smalti_io::studies::{self, LoadedStudy};
use smalti_io::sweeps::{self, SweepRun};
use smalti_report::study::camera_toml;

use crate::camera::{PyCamera, diagnosed};
use crate::cfa::PyCfa;
use crate::error::OrRaise;
use crate::evaluate::cache;
use crate::json::dict_of;
use crate::spectrum::warn;
use crate::work::{Told, watched};

/// A study: families of filters and mosaics, conditions, metrics.
///
/// Args:
///     source: a built-in study (`smalti.studies()`) or a TOML file; or the manifest.json of results.
///
/// Raises:
///     FileNotFoundError: when there is no such file.
///     SmaltiError: when there is no such study, a key or value is invalid, or it has no design.
#[pyclass(name = "Study", module = "smalti", frozen)]
#[derive(Debug)]
pub(crate) struct PyStudy {
    pub(crate) trials: Trials,
    pub(crate) about: String,
}

#[pymethods]
impl PyStudy {
    #[new]
    fn py_new(py: Python<'_>, source: PathBuf) -> PyResult<Self> {
        let name = source.to_string_lossy().into_owned();
        let LoadedStudy { trials, about, notes } = watched(py, None, |_| {
            studies::load_with_notes(&name).map_err(|e| diagnosed(&name, &e.to_string()))
        })?;
        warn(py, notes)?;
        Ok(Self { trials, about })
    }

    /// A study from the text of a TOML file.
    ///
    /// Args:
    ///     text: the study.
    ///     folder: folder of the files that the text names.
    #[staticmethod]
    #[pyo3(signature = (text, folder=None))]
    fn from_toml(py: Python<'_>, text: String, folder: Option<PathBuf>) -> PyResult<Self> {
        let source = TomlSource { name: "study".into(), folder: folder.unwrap_or_default(), text };
        let LoadedStudy { trials, about, notes } =
            watched(py, None, |_| studies::from_source_with_notes(&source).or_raise())?;
        warn(py, notes)?;
        Ok(Self { trials, about })
    }

    /// The name.
    #[getter]
    fn name(&self) -> &str {
        &self.trials.study().name
    }

    /// The description in words.
    #[getter]
    fn about(&self) -> &str {
        &self.about
    }

    /// The study with all its keys.
    #[getter]
    fn description<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        dict_of(py, self.trials.study())
    }

    /// The colour filter array of a trial, by its number from 0.
    fn cfa(&self, trial: u64) -> PyResult<PyCfa> {
        let trial = self.trials.trial(trial).or_raise()?;
        let condition = self.trials.study().conditions.get(trial.condition);
        let grid = condition.map(|c| c.camera.grid()).transpose().or_raise()?.unwrap_or_default();
        Ok(PyCfa(trial.design.cfa(grid).or_raise()?))
    }

    /// Number of trials.
    fn __len__(&self) -> usize {
        usize::try_from(self.trials.len()).unwrap_or(usize::MAX)
    }

    fn __repr__(&self) -> String {
        let study = self.trials.study();
        format!(
            "<smalti.Study '{}': {} trials, {} condition(s), metrics {}>",
            study.name,
            self.trials.len(),
            study.conditions.len(),
            study.metrics.iter().map(|m| m.name()).collect::<Vec<_>>().join(", "),
        )
    }
}

/// Scores the missing trials of a study or of a shard; see `smalti.sweep`.
///
/// Returns:
///     number of trials scored, seconds, number of parts that are still missing.
#[pyfunction]
#[pyo3(signature = (study, out, shard, part_size, cache, progress))]
pub(crate) fn run_sweep(
    py: Python<'_>,
    study: &PyStudy,
    out: PathBuf,
    shard: Option<(u32, u32)>,
    part_size: Option<u64>,
    cache: bool,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(u64, f64, u64)> {
    let shard = shard.map(|(index, of)| Shard::new(index, of)).transpose().or_raise()?;
    watched(py, progress.map(Told::Steps), |watch| {
        let run = SweepRun::open(&study.trials, study.about.clone(), part_size, &out, shard).or_raise()?;
        let cache = self::cache(cache)?;
        let images = |key: &str, make: &dyn Fn() -> _| cache.optical_image(key, make);
        let sweep = Sweep::new(&study.trials, &images);
        let done = run.run(&sweep, watch).or_raise()?;
        Ok((done.scored, done.seconds, done.parts_missing))
    })
}

/// Merges the results of shards into one folder, which is then identical to that of a single run.
///
/// Args:
///     folders: the results of the shards, which must contain all parts.
///     out: the folder for the merged results.
#[pyfunction]
pub(crate) fn merge(py: Python<'_>, folders: Vec<PathBuf>, out: PathBuf) -> PyResult<()> {
    watched(py, None, |_| dataset::merge(&folders, &out).or_raise())
}

/// A folder of results: one row for each trial.
///
/// Args:
///     dir: a folder that `sweep` or the command wrote.
#[pyclass(name = "Results", module = "smalti", frozen)]
#[derive(Debug)]
pub(crate) struct PyResults(Dataset);

#[pymethods]
impl PyResults {
    #[new]
    fn py_new(dir: PathBuf) -> PyResult<Self> {
        Ok(Self(Dataset::open(&dir).or_raise()?))
    }

    /// The folder.
    #[getter]
    fn dir(&self) -> PathBuf {
        self.0.dir().to_owned()
    }

    /// Whether all trials have been scored.
    #[getter]
    fn complete(&self) -> bool {
        self.0.is_complete()
    }

    /// The study with all its keys.
    #[getter]
    fn study<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        dict_of(py, &self.0.manifest().plan.study)
    }

    /// The camera of a trial, for `smalti.evaluate` or `smalti.train`.
    ///
    /// Args:
    ///     trial: number of the trial.
    fn camera(&self, trial: u64) -> PyResult<PyCamera> {
        let trials = sweeps::read_trials(&self.0).or_raise()?;
        let text = camera_toml(&trials, trial).or_raise_about(self.0.dir().display())?;
        PyCamera::from_text(text, self.0.dir().to_owned(), &[], None)
    }

    /// Unit and meaning of each column, by name.
    #[getter]
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let columns = PyDict::new(py);
        for c in &self.0.manifest().plan.schema {
            columns.set_item(&c.name, (&c.unit, &c.doc))?;
        }
        Ok(columns)
    }

    /// The values of columns, by name, in the order of the trials: float64 or int64 [trials], or a list of texts or of arrays.
    /// The hash of every part is checked.
    ///
    /// Args:
    ///     names: default all columns.
    #[pyo3(signature = (names=None))]
    fn read<'py>(&self, py: Python<'py>, names: Option<Vec<String>>) -> PyResult<Bound<'py, PyDict>> {
        let schema = &self.0.manifest().plan.schema;
        let names = names.unwrap_or_else(|| schema.iter().map(|c| c.name.clone()).collect());
        let wanted: Vec<&str> = names.iter().map(String::as_str).collect();
        let columns = watched(py, None, |watch| {
            let mut all: Option<Vec<Column>> = None;
            for part in self.0.columns(&wanted).or_raise()? {
                watch.check()?;
                let part = part.or_raise()?;
                match &mut all {
                    None => all = Some(part.columns),
                    Some(all) => {
                        all.iter_mut().zip(part.columns).for_each(|(whole, more)| extend(whole, more))
                    }
                }
            }
            Ok(all.unwrap_or_default())
        })?;
        let found = PyDict::new(py);
        for (name, column) in names.iter().zip(columns) {
            let values = match column {
                Column::Int(v) => v.into_pyarray(py).into_any(),
                Column::Float(v) => v.into_pyarray(py).into_any(),
                Column::Text(v) => PyList::new(py, v)?.into_any(),
                Column::Floats(v) => PyList::new(py, v.into_iter().map(|v| v.into_pyarray(py)))?.into_any(),
            };
            found.set_item(name, values)?;
        }
        Ok(found)
    }

    /// The values of columns as a pandas.DataFrame, a row for each trial. (`pandas.read_parquet(dir / "trials")` reads them too.)
    ///
    /// Args:
    ///     names: default all columns.
    #[pyo3(signature = (names=None))]
    fn to_pandas<'py>(&self, py: Python<'py>, names: Option<Vec<String>>) -> PyResult<Bound<'py, PyAny>> {
        py.import("pandas")?.call_method1("DataFrame", (self.read(py, names)?,))
    }

    /// Reads every part and checks its hash.
    ///
    /// Raises:
    ///     SmaltiError: names the first damaged part.
    fn verify(&self, py: Python<'_>) -> PyResult<()> {
        watched(py, None, |_| self.0.verify().or_raise())
    }

    /// Number of scored trials.
    fn __len__(&self) -> usize {
        usize::try_from(self.0.trials()).unwrap_or(usize::MAX)
    }

    fn __repr__(&self) -> String {
        let plan = &self.0.manifest().plan;
        format!(
            "<smalti.Results in {}: {} of {} trials>",
            self.0.dir().display(),
            self.0.trials(),
            plan.trials
        )
    }
}

/// Names of the built-in studies with their summaries.
#[pyfunction(name = "studies")]
pub(crate) fn study_names() -> std::collections::BTreeMap<&'static str, &'static str> {
    studies::names().iter().map(|s| (s.name, s.summary)).collect()
}

/// Parses a shard such as `3/16`.
#[pyfunction]
pub(crate) fn parse_shard(text: &str) -> PyResult<(u32, u32)> {
    let shard = Shard::from_str(text).or_raise()?;
    Ok((shard.index(), shard.of()))
}

fn extend(whole: &mut Column, more: Column) {
    match (whole, more) {
        (Column::Int(a), Column::Int(b)) => a.extend(b),
        (Column::Float(a), Column::Float(b)) => a.extend(b),
        (Column::Text(a), Column::Text(b)) => a.extend(b),
        (Column::Floats(a), Column::Floats(b)) => a.extend(b),
        // Parts of one dataset have columns of one kind.
        _ => {}
    }
}
