//! The `smalti` command.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use mimalloc::MiMalloc;

/// Images are allocated and freed by the thousand on several threads. The allocator of musl, which static programs have, takes a lock and
/// returns every image to the system: with it, a comparison takes three times as long.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    smalti_cli::command(std::env::args_os()).into()
}
