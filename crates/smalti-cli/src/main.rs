//! The `smalti` command.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    smalti_cli::command(std::env::args_os()).into()
}
