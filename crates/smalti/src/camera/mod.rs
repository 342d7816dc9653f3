//! The whole camera: optics, sensor and processing composed, its description, its evaluation; comparison of cameras with
//! any processing.

pub(crate) mod chart;
pub(crate) mod compare;
pub mod description;
mod error;
pub(crate) mod evaluate;
mod light_gain;
mod photograph;
mod reference;
mod resolve;
mod score;
pub(crate) mod target;
mod training;
mod training_set;

pub use compare::{SceneScores, Setup, TEST_SAMPLES_PER_PX, compare_on, test_scenes};
pub use description::CameraDescription;
pub use error::CameraError;
pub use evaluate::{
    Evaluation, EvaluationPictures, EvaluationSettings, ExposureTimes, GreyScores, IspFor, OpticalImages,
    PatchScores, evaluate, evaluate_with,
};
pub use light_gain::{
    Contender, LightGain, LightGainSettings, LightGains, MetricGain, light_gain, light_gains,
};
pub use photograph::{Camera, Photograph};
pub use resolve::ExposureTime;
pub use score::{PictureScores, ScoreSettings, score_picture};
pub use training::{LevelRule, TrainingSettings, TrainingTarget};
pub use training_set::{TrainingScene, training_reflectances, training_scenes};
