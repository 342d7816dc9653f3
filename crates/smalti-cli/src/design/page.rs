//! The page of a design.

use std::path::Path;

use anyhow::Context;
use serde_json::Value;
use smalti_io::write;
use smalti_report::design::{Document, Proved, page};

/// The name of the page in the folder of a design.
pub(super) const PAGE: &str = "design.html";

/// Writes the page of the results of a search, and of its proof if there is one.
pub(super) fn write(dir: &Path, results: &Value, proved: Option<&Proved<'_>>) -> anyhow::Result<()> {
    let document: Document = serde_json::from_value(results.clone()).context("the results of a search")?;
    Ok(write::bytes(&dir.join(PAGE), page(&document, proved, &dir.to_string_lossy())?.as_bytes())?)
}
