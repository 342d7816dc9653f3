//! A file of the studio.

use smalti::camera::CameraError;
use smalti::experiment::ExperimentError;
use thiserror::Error;

use crate::IoError;

/// A file of the studio.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StudioAsset {
    /// Its name, without a folder.
    pub name: String,
    /// Its content, as it is served.
    pub bytes: Vec<u8>,
}

/// Why there are no files.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StudioAssetError {
    /// The camera is invalid, or does not image a scene.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The statistics cannot be gathered.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// A scene cannot be read, or a file not be made.
    #[error(transparent)]
    Io(#[from] IoError),
    /// There is no such scene.
    #[error("there is no scene '{0}'")]
    NoScene(String),
    /// A scene that needs its source came without it.
    #[error("scene '{0}': its source is missing; expected the file that the manifest names")]
    NoSource(String),
}
