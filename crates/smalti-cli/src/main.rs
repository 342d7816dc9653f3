//! The `smalti` command.

fn main() {}
