//! The `smalti` command.

use std::ffi::OsString;

use pyo3::prelude::*;

use crate::work::detached;

/// Runs the command, which may end the process.
#[pyfunction]
pub(crate) fn run_command(py: Python<'_>, args: Vec<OsString>) -> PyResult<u8> {
    let line = std::iter::once(OsString::from("smalti")).chain(args);
    detached(py, || Ok(smalti_cli::command(line)))
}
