//! The command line: its commands and the options that they share.

use std::path::PathBuf;

use clap::{Parser, Subcommand};

use crate::args::Common;
use crate::cache::CacheArgs;
use crate::compare::Compare;
use crate::convert::Convert;
use crate::design::DesignArgs;
use crate::evaluate::Evaluate;
use crate::list::List;
use crate::rate::Rate;
use crate::render::Render;
use crate::report::ReportArgs;
use crate::show::Show;
use crate::simulate::Simulate;
use crate::studio::Studio;
use crate::sweep::SweepArgs;
use crate::train::Train;

/// A camera simulator that designs colour filter arrays and their image processing together.
#[derive(Debug, Parser)]
#[command(
    name = "smalti",
    version,
    arg_required_else_help = true,
    after_help = "Examples:\n  \
        smalti compare bayer rgbw --luminance 1,80            train, render and score: a table and pictures\n  \
        smalti simulate bayer -o out                          a picture of the default scene\n  \
        smalti simulate my.toml --scene zone-plate -o out     your own camera and another scene\n  \
        smalti evaluate bayer rgbw                            scores of colour, resolution, noise and aliasing\n  \
        smalti sweep table2 -o study && smalti report study   score 5000 colour filter arrays and report them\n  \
        smalti design pigments-4 -o best                      find the best colour filter array of four pigments\n  \
        smalti studio rgbw                                    change its mosaic and filters in the browser\n  \
        smalti rate init bayer rgbw -o trial                  an experiment in which people judge the pictures\n  \
        smalti list cfas                                      the built-in colour filter arrays\n  \
        smalti show rgbw                                      a camera with its mosaic and its spectra\n\n\
        Results are written to standard output or to the path of -o, progress and messages to standard error.\n\
        Exit code: 0 success, 1 failure, 2 wrong usage."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) common: Common,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Train the pipelines of cameras, render the same scenes with them and score the pictures
    Compare(Box<Compare>),
    /// Train the pipeline of a camera on scenes, or on pairs of a raw file and a picture
    Train(Box<Train>),
    /// Render a raw file with a learned pipeline
    Render(Render),
    /// Simulate one capture: raw.dng, rendered.png, metrics.json
    Simulate(Simulate),
    /// Score cameras on built-in targets: colour, resolution, noise, aliasing
    Evaluate(Evaluate),
    /// Score all trials of a study; resumes an interrupted run
    Sweep(SweepArgs),
    /// Find the best filters and mosaic for a camera and its light, without simulating pictures
    Design(Box<DesignArgs>),
    /// Report the results of a study: tables, best designs, figures
    Report(ReportArgs),
    /// Draw a mosaic and its filters in the browser and see their picture at once
    Studio(Studio),
    /// Let people judge: make an experiment, run it in the browser, scale the answers
    Rate(Box<Rate>),
    /// List built-in cameras, scenes, colour filter arrays, metrics and more
    List(List),
    /// Draw a camera, a colour filter array, a scene or a curve in the terminal
    Show(Box<Show>),
    /// Convert a scene between formats, or write a built-in scene to a file
    Convert(Convert),
    /// Show or empty the cache, which keeps slow results between runs
    Cache(CacheArgs),
    /// Print a script for tab completion
    #[command(after_help = "Examples:\n  \
        echo 'source <(smalti completions bash)' >> ~/.bashrc\n  \
        echo 'source <(smalti completions zsh)' >> ~/.zshrc               after compinit\n  \
        smalti completions fish > ~/.config/fish/completions/smalti.fish\n\n\
        The script calls smalti, which completes the names of cameras, scenes, illuminants and studies as well as files.")]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write a manual page for each command
    #[command(hide = true, after_help = "Examples:\n  smalti man ~/.local/share/man/man1")]
    Man {
        /// Folder for the pages, created if needed
        dir: PathBuf,
    },
}
