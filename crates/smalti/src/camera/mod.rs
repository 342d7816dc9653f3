//! The camera: optics, sensor and processing combined, its description, its evaluation and training, and comparisons of cameras.

mod array_figures;
// The file of the type that gives the module its name.
#[allow(clippy::module_inception)]
mod camera;
pub(crate) mod chart;
mod chart_in_light;
mod clear_channel;
mod colorimetry;
pub(crate) mod compare;
mod dark_channel;
mod deferred_scene;
pub mod description;
mod error;
pub(crate) mod evaluate;
mod explained;
mod exposure_fault;
mod grey_noise;
mod identity;
mod light_gain;
mod patch_scores;
mod photograph;
mod ranges;
mod reference;
mod resolve;
mod saturation;
mod scene_noise;
pub(crate) mod score;
pub(crate) mod stable_text;
pub(crate) mod target;
mod test_scene;
mod training;
mod training_image;
pub(crate) mod training_set;
mod training_settings;

pub use array_figures::ArrayFigures;
pub use camera::Camera;
pub use clear_channel::{NOTABLE_INFRARED_SHARE, NOTABLE_UNSHARED_SHARE, UnsharedLight};
pub use colorimetry::{ColorimetricObserver, SensorColorimetry};
pub use compare::{SceneScores, Setup, TEST_SAMPLES_PER_PX, compare_on, test_scenes};
pub use dark_channel::DarkChannel;
pub use deferred_scene::DeferredScene;
pub use description::CameraDescription;
pub use error::CameraError;
pub use evaluate::{
    Evaluation, EvaluationPictures, EvaluationSettings, ExposureTimes, IspFor, OpticalImages, PatchColors,
    evaluate, evaluate_with,
};
pub use exposure_fault::ExposureFault;
pub use grey_noise::COMPARED_NOISE_CAPTURES;
pub(crate) use light_gain::STEP_STOPS;
pub use light_gain::{
    CameraAndIsp, GainInterval, LightGain, LightGainSettings, LightGains, MetricGain, light_gain, light_gains,
};
pub use patch_scores::{GreyScores, PatchScores};
pub use photograph::Photograph;
pub use ranges::{KEY_RANGES, KeyRange};
pub(crate) use scene_noise::SceneNoise;
pub(crate) use score::picture_cpsnr_db;
pub use score::{PICTURE_METRICS, PictureScores, ScoreSettings, score_picture};
pub use test_scene::TestScene;
pub use training::TrainingItem;
pub(crate) use training::{HIGHEST_CUT, Stand};
pub(crate) use training_image::ImageSampling;
pub use training_set::{
    DEFAULT_TRAINING_LIGHT, NoStoredScenes, StoredTrainingScenes, SurfaceReflectances, Surfaces,
    TRAINING_SET_REVISION, TrainingContent, TrainingScene, refinement_scenes, training_reflectances,
    training_scenes,
};
pub use training_settings::{LevelRule, TrainingSettings, TrainingTarget};
