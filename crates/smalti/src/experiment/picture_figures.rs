//! The figures of all pictures of a camera.

use serde::{Deserialize, Serialize};

use crate::camera::PICTURE_METRICS;

/// The values of [`PICTURE_METRICS`] for every picture of a camera with its pipeline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PictureFigures {
    /// For each luminance.
    pub lights: Vec<LightFigures>,
}

/// The values at one luminance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LightFigures {
    /// For each metric, the values of all seeds of the first scene, then of the next ones.
    pub metrics: [Vec<f64>; PICTURE_METRICS.len()],
    /// Mean exposure time over the scenes, s.
    pub time_s: f64,
}
