//! Other programs, by way of Python.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// Runs a script of `tests/python`; one JSON value per line of its output. `None`, with a message, when the
/// packages it needs are not there. The interpreter is `$SMALTI_PYTHON`, else `python3`.
pub(crate) fn python(script: &str, packages: &str, arguments: &[&Path]) -> Option<Vec<Value>> {
    let interpreter = std::env::var("SMALTI_PYTHON").unwrap_or_else(|_| "python3".into());
    let here = Command::new(&interpreter).args(["-c", &format!("import {packages}")]).output();
    if !here.is_ok_and(|o| o.status.success()) {
        eprintln!("skipped: no Python with {packages}");
        return None;
    }
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/python").join(script);
    let output = Command::new(&interpreter).arg(path).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(
        String::from_utf8(output.stdout).unwrap().lines().map(|l| serde_json::from_str(l).unwrap()).collect(),
    )
}
