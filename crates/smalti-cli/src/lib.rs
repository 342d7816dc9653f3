//! The `smalti` command: parses arguments, resolves names and files, calls the library and prints the results. No physics.
//!
//! It is a library, so that the Python package provides the same command.
#![forbid(unsafe_code)]

mod args;
mod cache;
mod cli;
mod compare;
mod complete;
mod contest;
mod convert;
mod design;
mod evaluate;
mod exposure_args;
mod keys;
mod learning_args;
mod list;
mod man;
mod numbers;
mod output;
mod pairs;
mod progress;
mod rate;
mod raw_args;
mod render;
mod report;
mod resolve;
mod scene_args;
mod show;
mod simulate;
mod studio;
mod sweep;
mod table;
mod terminal;
mod train;

use std::ffi::OsString;

use clap::{CommandFactory, Parser};
use cli::{Cli, Command};
use output::print;
use raw_args::naming_the_option;
use smalti::names::in_one_line;
use smalti_io::{IoError, UnstatedProperty};

const DONE: u8 = 0;
const FAILED: u8 = 1;
const WRONG_USAGE: u8 = 2;

/// Runs a command line, whose first argument is the name of the program, and returns the exit code: 0 success, 1 failure, 2 wrong
/// usage. Results are written to standard output, everything else to standard error.
pub fn command(args: impl IntoIterator<Item = OsString>) -> u8 {
    let args: Vec<OsString> = args.into_iter().collect();
    if !args.is_empty() && complete::answer(Cli::command, &args) {
        return DONE;
    }
    let words: Vec<String> = args.iter().skip(1).map(|a| a.to_string_lossy().into_owned()).collect();
    let done = match Cli::try_parse_from(args) {
        Ok(cli) => run(cli, &words),
        Err(e) if e.use_stderr() => {
            // The message repeats words of the command line. Nothing can be done about a closed standard error.
            let clean = words.iter().map(|word| in_one_line(word).into_owned());
            let clean = Cli::try_parse_from(std::iter::once("smalti".to_owned()).chain(clean)).err();
            match clean {
                Some(e) => drop(e.print()),
                None => output::tell(&e.to_string()),
            }
            return WRONG_USAGE;
        }
        // Help and version.
        Err(e) => e.print().map_err(anyhow::Error::from),
    };
    match done {
        // A closed pipe, as in `smalti list cfas | head`, is no failure.
        Err(e) if !is_broken_pipe(&e) => {
            let hint = option_for(&e).map_or_else(String::new, |option| format!(" ({option})"));
            output::error(e.as_ref(), &hint);
            FAILED
        }
        _ => DONE,
    }
}

fn run(cli: Cli, words: &[String]) -> anyhow::Result<()> {
    if let Some(threads) = cli.common.threads {
        rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads)).build_global()?;
    }
    match cli.command {
        Command::Compare(a) => compare::run(&a, words, &cli.common),
        Command::Train(a) => train::run(&a, &cli.common).map_err(naming_the_option),
        Command::Render(a) => render::run(&a, &cli.common).map_err(naming_the_option),
        Command::Rate(a) => rate::run(&a, words, &cli.common),
        Command::Simulate(a) => simulate::run(&a, &cli.common),
        Command::Evaluate(a) => evaluate::run(&a, words, &cli.common),
        Command::Studio(a) => studio::run(&a, &cli.common),
        Command::Sweep(a) => sweep::run(&a, &cli.common),
        Command::Design(a) => design::run(&a, &cli.common),
        Command::Report(a) => report::run(&a, &cli.common),
        Command::List(a) => list::run(&a),
        Command::Show(a) => show::run(&a, &cli.common),
        Command::Convert(a) => convert::run(&a, &cli.common),
        Command::Cache(a) => cache::run(&a),
        Command::Completions { shell } => print(&complete::script(shell)?),
        Command::Man { dir } => print(&man::write_pages(Cli::command(), &dir)?),
    }
}

/// The option that states what a file does not.
fn option_for(error: &anyhow::Error) -> Option<&'static str> {
    match error.chain().find_map(|e| e.downcast_ref::<IoError>())? {
        IoError::Unstated { property: UnstatedProperty::Wavelengths, .. } => Some("--wavelengths"),
        IoError::Unstated { property: UnstatedProperty::Quantity, .. } => Some("--quantity"),
        IoError::Unstated { property: UnstatedProperty::Variable, .. } => Some("--variable"),
        _ => None,
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let io = error.chain().find_map(|e| e.downcast_ref::<std::io::Error>());
    io.is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
