//! Experiments as functions of plain values: simulate, train, evaluate, compare, light gain, sweep, and ratings: their pictures
//! and their analysis.
//!
//! The command and the Python package only call these functions, so that both give the same results for the same settings. No
//! function opens a file: the caller passes scenes, raw images and pipelines. A [`Store`] caches slow results, and a
//! [`Progress`] receives the steps and can stop the work.

mod comparison;
mod contender;
mod default_set;
mod default_training;
mod design;
mod design_analysis;
mod design_search;
mod design_store;
mod design_task;
mod differences;
mod entrants;
mod error;
mod exposure;
mod labels;
mod learning;
mod light_gain;
mod light_notes;
mod light_statistics;
mod lights;
mod material;
mod order;
mod outcome;
mod pairs;
mod picture_figures;
mod pipelines;
mod prepared;
mod processing;
mod progress;
mod proof;
mod rating;
mod rating_analysis;
mod robustness;
mod simulation;
mod store;
mod sweep;
mod tolerance;
mod training_statistics;
mod verdict;

pub use comparison::{Compared, ComparisonSettings, compare, compare_while_learning};
pub use contender::{Contender, ScoredScene, contenders, ensure_any_defined, score_scene};
pub use default_set::DefaultTraining;
pub use default_training::learn_default;
pub use design::{design, screens};
pub use design_analysis::{DesignAnalysis, Sensitivity, analyse_design};
pub use design_store::{DesignStore, ForgetfulStore, KeptFind};
pub use design_task::{DesignTask, DesignedCfa, Designs, FrontPoint};
pub use differences::{CameraDifference, FIELD_OF_VIEW, IspKeys, camera_differences};
pub use entrants::{Entrant, score_entrants};
pub use error::ExperimentError;
pub use exposure::{ComparedPictures, EqualExposure, ExposurePlan, ExposurePolicy, LimitingCamera};
pub use labels::numbered;
pub use learning::{
    Gathered, Learned, TrainingPair, TrainingRecord, TrainingSources, gather, learn, refine, solve,
};
pub use light_gain::{PairwiseLightGain, light_gain_between, light_gains_to_first};
pub use light_notes::{light_notes, other_wavelengths_note, without_infrared};
pub use light_statistics::{light_gatherer, light_statistics};
pub use lights::{LitPipeline, PipelineSet, SceneLight, ensure_lights_suffice, scene_lights};
pub use material::NamedScene;
pub use outcome::Outcome;
pub use pairs::{PairAlignment, RawAndPicture};
pub use picture_figures::{LightFigures, PictureFigures};
pub use pipelines::{PipelineTask, Pipelines, pipelines};
pub use prepared::{FieldOfView, PreparedCapture, displayed};
pub use processing::Processing;
pub use progress::{Progress, Silent};
pub use proof::{Proof, ProofResult, ProvedLead, Rival, Scored, prove};
pub use rating::{RatedCondition, RatedPicture, RatedScene, rated_scenes};
pub use rating_analysis::{
    AnsweredCondition, AnsweredObserver, JudgedObserver, RatingAnalysis, RatingAnswers, RatingResult,
    analyse_ratings,
};
pub use robustness::{RobustnessCase, RobustnessRow, RobustnessScenes, robustness, robustness_cases};
pub use simulation::{ScoredWindow, Simulation, SimulationSettings, capture, score_capture, simulate};
pub use store::{NoStore, Resources, Store};
pub use sweep::sweep;
pub use tolerance::{ToleranceRow, tolerances};
pub use verdict::{
    Crossover, Estimate, Finding, Lead, LightStops, LightVerdict, MetricVerdict, MoreLight, StopsInterval,
    Verdict,
};
