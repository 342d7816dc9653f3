//! Folders of results: content, independence from the order of writing, interruptions and invalid input.

mod files;
mod fixtures;
mod hostile;
mod judges;
mod merging;
mod processes;
mod refusals;
