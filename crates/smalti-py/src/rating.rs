//! The analysis of rating experiments.

use std::path::PathBuf;

use pyo3::prelude::*;
use smalti::experiment::analyse_ratings as analyse;
use smalti_io::ratings::{read, read_observers};
use smalti_report::rating::RatingReport;

use crate::error::OrRaise;
use crate::json::dict_of;
use crate::work::watched;

/// Scales the answers to a rating experiment and compares them with the metrics, as `smalti rate analyse` does, without writing a file.
///
/// Args:
///     folder: the experiment, with answers (`smalti rate serve`).
///     keep_all: keep all observers who have rated, also those who fail the screening.
///
/// Returns:
///     the results.json of the command: the observers and `result`, which has a scale in JOD with the agreement of each metric, or the
///     light of equal appearance in stops.
///
/// Raises:
///     FileNotFoundError: when there is no such experiment.
///     SmaltiError: when a file is damaged, there are no answers, or no observer is kept.
#[pyfunction]
#[pyo3(signature = (folder, *, keep_all=false))]
pub(crate) fn analyse_ratings(py: Python<'_>, folder: PathBuf, keep_all: bool) -> PyResult<Bound<'_, PyAny>> {
    let document = watched(py, None, |_| {
        let manifest = read(&folder, false).or_raise()?;
        let answers = manifest.answers(&read_observers(&folder, &manifest).or_raise()?);
        let about = folder.display().to_string();
        let analysis = analyse(&answers, keep_all).or_raise_about(&about)?;
        let report = RatingReport {
            command: &manifest.command,
            folder: &about,
            answers: &answers,
            analysis: &analysis,
        };
        report.document().or_raise()
    })?;
    dict_of(py, &document)
}
