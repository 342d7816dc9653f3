//! The `smalti` command, and what it makes of results.

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;
use smalti_cli::ReportOptions;

use crate::error::of_command;
use crate::work::{detached, watched};

/// The command, in a process that does nothing else: it may end the process.
#[pyfunction]
pub(crate) fn run_command(py: Python<'_>, args: Vec<OsString>) -> PyResult<u8> {
    let line = std::iter::once(OsString::from("smalti")).chain(args);
    detached(py, || Ok(smalti_cli::command(line)))
}

#[pyfunction]
pub(crate) fn write_report<'py>(
    py: Python<'py>,
    results: Vec<PathBuf>,
    output: Option<PathBuf>,
    pictures: u16,
    picture: Vec<u64>,
    draw: Vec<String>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let of = ReportOptions { results, output, pictures, picture, draw };
    let document = watched(py, progress, |watch| {
        let of_report = smalti_cli::Watch { go_on: &|| watch.check().is_ok(), done: &|| watch.step() };
        smalti_cli::report(&of, &of_report).map_err(|e| of_command(e.as_ref()))
    })?;
    py.import("json")?.call_method1("loads", (document,))
}
