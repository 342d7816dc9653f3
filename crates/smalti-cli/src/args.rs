//! Options that several commands share.

use clap::Args;
use smalti_io::Override;

/// Options of every command.
#[derive(Debug, Clone, Args)]
pub(crate) struct Common {
    /// Number of threads, which does not affect results [default: one per core]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// Print only results and errors
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
}

/// Options that change the camera.
#[derive(Debug, Clone, Args)]
pub(crate) struct CameraOptions {
    /// Replace a key of every camera; its name contains the unit. May be given more than once
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) overrides: Vec<Override>,
    /// Seed of the noise that varies between captures
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
}
