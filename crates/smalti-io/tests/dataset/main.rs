//! Folders of results: what they hold, whoever wrote them, in whatever order and after whatever interruption.
#![allow(clippy::unwrap_used)]

#[path = "../support/python.rs"]
mod python;

mod files;
mod fixtures;
mod hostile;
mod judges;
mod merging;
mod processes;
mod refusals;
