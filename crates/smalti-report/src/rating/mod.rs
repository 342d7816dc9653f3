//! The report of a rating experiment: a page, tables and one JSON document, from plain data.

mod document;
mod figures;
mod page;
mod tables;
mod text;

use smalti::experiment::{AnsweredObserver, JudgedObserver, RatingAnalysis, RatingAnswers};

pub use page::page;

/// The page of an experiment.
pub const PAGE: &str = "report.html";

/// The results of an experiment.
#[derive(Debug, Clone, Copy)]
pub struct RatingReport<'a> {
    /// The command that made the experiment, without the name of the program.
    pub command: &'a [String],
    /// The folder of the experiment, for the command that is shown.
    pub folder: &'a str,
    /// The experiment with its answers.
    pub answers: &'a RatingAnswers,
    /// What they show.
    pub analysis: &'a RatingAnalysis,
}

impl<'a> RatingReport<'a> {
    /// The names of the conditions.
    fn conditions(&self) -> Vec<String> {
        self.answers.conditions.iter().map(|c| c.name.clone()).collect()
    }

    /// The observers with what was found about each.
    fn observers(&self) -> impl Iterator<Item = (&'a AnsweredObserver, &'a JudgedObserver)> + use<'a> {
        self.answers.observers.iter().zip(&self.analysis.observers)
    }

    /// The observers whose choices count.
    fn kept(&self) -> impl Iterator<Item = &'a AnsweredObserver> + use<'a> {
        self.observers().filter(|(_, judged)| judged.is_kept).map(|(observer, _)| observer)
    }
}
