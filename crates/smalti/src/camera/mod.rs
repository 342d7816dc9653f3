//! The whole camera: optics, sensor and processing composed, its description, its evaluation.

pub mod description;
mod error;
mod evaluate;
mod photograph;
mod resolve;
mod training;

pub use description::CameraDescription;
pub use error::CameraError;
pub use evaluate::{
    Evaluation, EvaluationPictures, EvaluationSettings, ExposureTimes, OpticalImages, PatchScores, evaluate,
};
pub use photograph::{Camera, Photograph};
pub use resolve::ExposureTime;
pub use training::{
    LevelRule, TrainingScene, TrainingSettings, TrainingTarget, training_reflectances, training_scenes,
};
