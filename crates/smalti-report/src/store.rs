//! How the files of a report reach the caller, since this crate opens none.

use std::error::Error;

/// Stores a file of a report: its path relative to the folder of the report, with `/` between folders, and its content.
pub type Store<'a> = dyn FnMut(&str, &[u8]) -> Result<(), Box<dyn Error + Send + Sync>> + 'a;
