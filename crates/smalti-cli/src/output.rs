//! Results on standard output.

use std::io::Write;

use serde::Serialize;

use crate::args::Common;

/// Writes results to standard output.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(())
}

/// Prints a note to standard error, unless quiet. While work is in progress, [`Progress::note`] prints it above the bar.
///
/// [`Progress::note`]: smalti::experiment::Progress::note
pub(crate) fn note(text: &str, common: &Common) {
    if !common.quiet {
        eprintln!("note: {text}");
    }
}

/// Writes JSON to standard output.
pub(crate) fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    print(&(serde_json::to_string_pretty(value)? + "\n"))
}
