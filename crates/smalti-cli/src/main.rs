//! The `smalti` command: parses, resolves, calls the library, prints. The physics is not here.

mod args;
mod brightness;
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

use std::io::Write;
use std::process::ExitCode;

use args::{Cli, Command};
use clap::{CommandFactory, Parser};

fn main() -> ExitCode {
    complete::answer(Cli::command);
    let cli = Cli::parse();
    match run(cli) {
        Ok(()) => ExitCode::SUCCESS,
        // A reader that has seen enough, as in `smalti list cfas | head`, is no failure.
        Err(e) if is_broken_pipe(&e) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {}", in_one_line(&e));
            ExitCode::FAILURE
        }
    }
}

fn run(cli: Cli) -> anyhow::Result<()> {
    if let Some(threads) = cli.common.threads {
        rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads)).build_global()?;
    }
    match cli.command {
        Command::Compare(a) => compare::run(&a, &cli.common),
        Command::Train(a) => train::run(&a, &cli.common),
        Command::Render(a) => render::run(&a, &cli.common),
        Command::Simulate(a) => simulate::run(&a, &cli.common),
        Command::Evaluate(a) => evaluate::run(&a, &cli.common),
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

/// An error and its causes, but for those whose words the error before already holds.
fn in_one_line(error: &anyhow::Error) -> String {
    let mut told = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if told.is_empty() {
            told = cause;
        } else if !told.ends_with(&cause) {
            told = format!("{told}: {cause}");
        }
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
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
