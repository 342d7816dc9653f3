//! Options that several commands share, and options whose words mean values of the library.

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use smalti_io::Override;

/// A word of an option, its help and the value that it means.
pub(crate) type Choice<T> = (&'static str, &'static str, T);

/// Parses one of several words.
pub(crate) fn choice<T: Copy + Send + Sync + 'static>(
    known: &'static [Choice<T>],
) -> impl TypedValueParser<Value = T> {
    let words = known.iter().map(|(word, help, _)| PossibleValue::new(*word).help(*help));
    let value = |typed: &str| known.iter().find(|(word, ..)| *word == typed).map(|(_, _, value)| *value);
    PossibleValuesParser::new(words).try_map(move |typed| value(&typed).ok_or("unknown word"))
}

/// The word of a value.
pub(crate) fn word_of<T: PartialEq>(known: &[Choice<T>], value: &T) -> Option<&'static str> {
    known.iter().find(|(.., known)| known == value).map(|(word, ..)| *word)
}

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
    /// Another mosaic for every camera, with the filters of the camera: a name (smalti list cfas) or a TOML file with [sensor.cfa].
    /// CAMERA@MOSAIC is the same for one camera
    #[arg(long, value_name = "MOSAIC")]
    pub(crate) cfa: Option<String>,
    /// Seed of the noise that varies between captures
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
}
