//! `smalti rate`: experiments in which people judge pictures.

mod analyse;
mod init;
mod serve;

use clap::{Args, Subcommand};

use crate::args::Common;

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti rate init bayer rgbw clarity --luminance 1 -o trial     render the pictures of an experiment\n  \
    smalti rate serve trial                                        run it in the browser, for one observer or several\n  \
    smalti rate analyse trial                                      the scale, with intervals: a page, CSV and JSON\n  \
    smalti rate init --experiment bayer-light -o light             how much light does Bayer need to look like RGBW?")]
pub(crate) struct Rate {
    #[command(subcommand)]
    pub(crate) step: Step,
}

#[derive(Debug, Clone, Subcommand)]
pub(crate) enum Step {
    /// Render the pictures of an experiment into a folder
    Init(Box<init::Init>),
    /// Show the pairs to observers in their browsers and record their answers
    Serve(serve::Serve),
    /// Scale the answers and compare them with the metrics
    Analyse(analyse::Analyse),
}

/// `words` are the command line, for the manifest.
pub(crate) fn run(args: &Rate, words: &[String], common: &Common) -> anyhow::Result<()> {
    match &args.step {
        Step::Init(args) => init::run(args, words, common),
        Step::Serve(args) => serve::run(args, common),
        Step::Analyse(args) => analyse::run(args),
    }
}
