//! The whole camera: optics, sensor and processing composed, its description, its evaluation.

mod photograph;
pub mod description;
mod error;
mod evaluate;
mod resolve;

pub use photograph::{Camera, Photograph};
pub use description::CameraDescription;
pub use error::CameraError;
pub use evaluate::{Evaluation, EvaluationPictures, EvaluationSettings, ExposureTimes, OpticalImages, PatchScores, evaluate};
pub use resolve::ExposureTime;
