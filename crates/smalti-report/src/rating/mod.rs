//! The report of a rating experiment: a page, tables and one JSON document, from plain data.

mod document;
mod figures;
mod page;
mod text;

use smalti::rating::{Agreement, Level, ObserverChoices, PsychometricFit, Scales, Screening};

pub use page::page;

/// The page of an experiment.
pub const PAGE: &str = "report.html";

/// The results of an experiment.
#[derive(Debug, Clone, Copy)]
pub struct RatingReport<'a> {
    /// The title.
    pub title: &'a str,
    /// The command that made the experiment, without the name of the program.
    pub command: &'a [String],
    /// The folder of the experiment, for the command that is shown.
    pub folder: &'a str,
    /// The names of the conditions.
    pub conditions: &'a [String],
    /// The names of the scenes.
    pub scenes: &'a [String],
    /// The observers.
    pub observers: &'a [RatedObserver],
    /// What was found.
    pub result: &'a RatingResult,
}

/// An observer.
#[derive(Debug, Clone)]
pub struct RatedObserver {
    /// The number.
    pub number: u32,
    /// Pairs that were answered, and all.
    pub answered: [usize; 2],
    /// The choices.
    pub choices: ObserverChoices,
    /// What was found about them.
    pub screening: Screening,
    /// Whether the choices count.
    pub is_kept: bool,
    /// Device pixels per CSS pixel.
    pub device_pixel_ratio: f64,
    /// The exponent of the display.
    pub gamma: Option<f64>,
}

/// What an experiment found.
#[derive(Debug, Clone)]
pub enum RatingResult {
    /// The scale of all conditions, and the agreement with each metric by its name.
    Scale {
        /// The scales.
        scales: Scales,
        /// The agreement of each metric; `None` where it has no correlation.
        agreement: Vec<(String, Option<Agreement>)>,
    },
    /// How much light a camera needs to look like another.
    Light {
        /// The camera whose light varies, with its processing.
        varied: String,
        /// The standard, with its luminance.
        standard: String,
        /// The choices for the varied camera of all kept observers.
        levels: Vec<Level>,
        /// The psychometric function, if the choices have one.
        fit: Option<PsychometricFit>,
    },
}
