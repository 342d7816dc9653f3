//! Families of designs: sets of filters and mosaics that a study searches.
//!
//! A design is a set of N filters, ascending in wavelength, and a [`Mosaic`](crate::sensor::Mosaic) whose channel i has
//! filter i. A [`Trial`] is a design under a condition, with a processing. The file of a study states a [`FilterFamily`] and a [`MosaicFamily`]. Each counts its members for a number of
//! colours. A [`FilterFamily`] computes any member from its number alone, so that a [`Permutation`] of the numbers draws
//! without replacement and without memory.

mod class_light;
mod combinations;
mod deviation;
mod error;
mod filters;
mod imaged_scene;
mod latest;
mod learning_settings;
pub mod light;
mod light_trainer;
pub mod live;
mod mosaics;
mod patch_light;
mod patch_products;
mod permutation;
mod pipeline_trainer;
mod pixel_light;
mod preview;
mod results;
mod scenes;
mod scores;
pub mod screen;
pub mod search;
pub mod statistics;
mod study;
mod sweep;
mod targets;
mod training_data;
mod training_scene;
mod trial_picture;

pub use combinations::{binomial, combination};
pub use deviation::Deviation;
pub use error::DesignError;
pub use filters::{
    Dye, Dyes, FilterFamily, FilterFigures, FilterSet, GaussianGrid, Library, ListedSet, Rule, RuleName,
    RuleTarget, Series,
};
pub use learning_settings::{LearningSettings, LearningStatistics};
pub(crate) use mosaics::published_filters;
pub use mosaics::{MosaicFamily, Symmetry, Tile, published};
pub use permutation::Permutation;
pub use pipeline_trainer::PipelineTrainer;
pub use pixel_light::{PixelLight, QuantizedLight, QuantizedPlanes};
pub use preview::{Preview, PreviewDesign, PreviewLight, PreviewScene, PreviewTraining, metered};
pub use results::{ColumnValues, ResultColumn, StudyResults, column_of_key};
pub use scenes::StudyScene;
pub use scores::{
    AliasingScores, ColorScores, EdgeScores, Metric, MetricResult, MetricTarget, SceneFigures, Scores,
};
pub use study::{Condition, ConditionValue, Design, Study, Trial, TrialProcessing, Trials};
pub use sweep::{SCORES_REVISION, ScoredTrial, Sweep};
pub use targets::Targets;
pub use trial_picture::{TrialPhotographer, TrialScene};
