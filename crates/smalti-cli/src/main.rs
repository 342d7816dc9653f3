//! The `smalti` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    smalti_cli::command(std::env::args_os()).into()
}
