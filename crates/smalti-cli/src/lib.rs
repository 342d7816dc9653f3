//! The `smalti` command: parses, resolves, calls the library, prints. The physics is not here.
//!
//! It is a library so that the Python package has the same command, and what the command makes of results.

mod args;
mod columns;
mod compare;
mod compare_page;
mod compare_report;
mod complete;
mod convert;
mod evaluate;
mod keys;
mod learn;
mod learning_args;
mod list;
mod man;
mod names;
mod pairs;
mod pictures;
mod progress;
mod render;
mod resolve;
mod scene_args;
mod show;
mod simulate;
mod study_report;
mod sweep;
mod table;
mod terminal;
mod train;

use std::error::Error;
use std::ffi::OsString;
use std::io::Write;
use std::path::Path;

use args::{Cli, Command, Compare, Evaluate};
use clap::{CommandFactory, Parser};

pub use args::ReportOptions;
use progress::Progress;

/// What long work asks and tells, from any thread.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Asked before each picture and figure; after a no, the work ends with an error.
    pub go_on: &'a (dyn Fn() -> bool + Sync),
    /// Told of each picture and figure that is made.
    pub done: &'a (dyn Fn() + Sync),
}

impl Watch<'static> {
    /// Nobody asks or listens.
    pub(crate) const NOBODY: Self = Self { go_on: &|| true, done: &|| () };
}

impl Watch<'_> {
    pub(crate) fn ask(&self) -> anyhow::Result<()> {
        anyhow::ensure!((self.go_on)(), "stopped");
        Ok(())
    }
}

const DONE: u8 = 0;
const FAILED: u8 = 1;
const WRONG_USAGE: u8 = 2;

/// What `smalti report` makes of results of sweeps; its files are written. The report as JSON, that of `--json`.
///
/// # Errors
/// When results cannot be read, or files not written; when it is asked to stop: then there is no page, and no `report.json`.
pub fn report(of: &ReportOptions, watch: &Watch<'_>) -> anyhow::Result<String> {
    Ok(study_report::report(of, &Progress::new(0, true), watch)?.document)
}

/// The camera of a design of a folder of results, as TOML.
///
/// # Errors
/// When the folder holds no results, or no such design.
pub fn design_camera(results: &Path, number: u64) -> anyhow::Result<String> {
    study_report::camera::toml(results, number)
}

/// Does what a command line says; the first argument is the name of the program. Results go to standard output, all else to
/// standard error. The exit code: 0 done, 1 failed, 2 wrong usage.
pub fn command(args: impl IntoIterator<Item = OsString>) -> u8 {
    let args: Vec<OsString> = args.into_iter().collect();
    if !args.is_empty() && complete::answer(Cli::command, &args) {
        return DONE;
    }
    let words = args.iter().skip(1).map(|a| a.to_string_lossy().into_owned()).collect();
    let done = match Cli::try_parse_from(args) {
        Ok(cli) => run(cli, words),
        Err(e) => {
            // What cannot be printed has nobody to read it.
            let _ = e.print();
            return if e.use_stderr() { WRONG_USAGE } else { DONE };
        }
    };
    match done {
        // A reader that has seen enough, as in `smalti list cfas | head`, is no failure.
        Err(e) if !is_broken_pipe(&e) => {
            eprintln!("error: {}", in_one_line(e.as_ref()));
            FAILED
        }
        _ => DONE,
    }
}

fn run(cli: Cli, words: Vec<String>) -> anyhow::Result<()> {
    if let Some(threads) = cli.common.threads {
        rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads)).build_global()?;
    }
    match cli.command {
        Command::Compare(a) => compare::run(&Compare { words, ..*a }, &cli.common),
        Command::Train(a) => train::run(&a, &cli.common),
        Command::Render(a) => render::run(&a, &cli.common),
        Command::Simulate(a) => simulate::run(&a, &cli.common),
        Command::Evaluate(a) => evaluate::run(&Evaluate { words, ..a }, &cli.common),
        Command::Sweep(a) => sweep::run(&a, &cli.common),
        Command::Report(a) => study_report::run(&a, &cli.common),
        Command::List(a) => list::run(&a),
        Command::Show(a) => show::run(&a),
        Command::Convert(a) => convert::run(&a, &cli.common),
        Command::Completions { shell } => print(&complete::script(shell)?),
        Command::Man { dir } => print(&man::write_pages(Cli::command(), &dir)?),
    }
}

/// Writes results to standard output.
fn print(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(())
}

/// An error and its causes, each once: a cause whose words end the error's is left out, and so is an error (a context) whose words begin
/// its cause's.
pub fn in_one_line(error: &(dyn Error + 'static)) -> String {
    let mut told = error.to_string();
    let mut cause = error.source();
    while let Some(e) = cause {
        let text = e.to_string();
        told = match (told.ends_with(&text), text.starts_with(&told)) {
            (true, _) => told,
            (_, true) => text,
            _ => format!("{told}: {text}"),
        };
        cause = e.source();
    }
    told
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let io = error.chain().find_map(|e| e.downcast_ref::<std::io::Error>());
    io.is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_told_once() {
        let told = |e: anyhow::Error| in_one_line(e.as_ref());
        assert_eq!(told(anyhow::anyhow!("b").context("a")), "a: b");
        assert_eq!(told(anyhow::anyhow!("x.toml: no key").context("x.toml")), "x.toml: no key");
        assert_eq!(told(anyhow::anyhow!("no key").context("x.toml: no key")), "x.toml: no key");
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
