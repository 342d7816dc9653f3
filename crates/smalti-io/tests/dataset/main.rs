//! Folders of results: content, independence from the order of writing, interruptions and invalid input.
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
