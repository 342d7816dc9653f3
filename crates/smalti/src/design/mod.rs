//! Families of designs: sets of filters and mosaics that a study searches.
//!
//! A design is a set of N filters, ascending in wavelength, and a [`Mosaic`](crate::sensor::Mosaic) whose channel i has
//! filter i. [`FilterFamily`] and [`MosaicFamily`] are written in the file of a study. Each tells how many members it has
//! for a number of colours, and gives any of them; of a [`FilterFamily`], by its number and alone, so that a
//! [`Permutation`] of the numbers is a sample without replacement that needs no memory.

mod combinations;
mod error;
mod filters;
mod learned;
mod lessons;
mod mosaics;
mod permutation;
mod prepared;
mod preview;
mod scenes;
mod scores;
mod shown;
pub mod statistics;
mod study;
mod sweep;
mod targets;

pub use combinations::{binomial, combination, combination_rank};
pub use error::DesignError;
pub use filters::{
    Dye, Dyes, FilterFamily, FilterFigures, FilterSet, GaussianGrid, Library, ListedSet, Rule, RuleName,
    RuleTarget, Series,
};
pub use learned::{LessonSettings, Lessons};
pub use mosaics::{MosaicFamily, Symmetry, Tile, published};
pub use permutation::Permutation;
pub use preview::{PixelLight, ReadoutModel, metered_electrons};
pub use scenes::StudyScene;
pub use scores::{AliasingScores, Asked, ColorScores, EdgeScores, Metric, SceneFigures, Scores, Sight};
pub use study::{Condition, ConditionValue, Design, Designs, Processing, Study};
pub use sweep::{SCORES_REVISION, Scored, Sweep};
pub use targets::Targets;
