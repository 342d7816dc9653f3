//! Why the engine has no answer.

use std::fmt;

use smalti::camera::CameraError;
use smalti::camera::description::ExchangeError;
use smalti::design::DesignError;
use smalti::design::live::LiveLockError;
use smalti_io::studio::StudioAssetError;
use smalti_io::{Diagnostic, IoError};

/// Why the engine has no answer.
#[derive(Debug)]
#[non_exhaustive]
pub enum EngineError {
    /// The request cannot be read.
    Request(serde_json::Error),
    /// The request is too long.
    TooLong {
        /// Its bytes.
        bytes: usize,
        /// The most that are read.
        limit: usize,
    },
    /// A kind of file that the studio does not have.
    NoKind(u32),
    /// A part of the assets was not loaded, or a request comes before the one that it follows.
    Missing(&'static str),
    /// There is no such scene.
    NoScene(String),
    /// A filter or a cell is kept that the array does not have.
    NoLock(LiveLockError),
    /// A design cannot have a mosaic.
    Mosaic(ExchangeError),
    /// A photograph has a wrong size, or cannot become a scene.
    Photograph(String),
    /// A camera file or the JSON of a design is wrong.
    Text(Box<Diagnostic>),
    /// The design is impossible, or a stage refused.
    Camera(CameraError),
    /// A figure or a search refused.
    Design(DesignError),
    /// A file of the assets is damaged.
    File(IoError),
    /// The light behind a lens cannot be gathered.
    Light(Box<StudioAssetError>),
}

impl fmt::Display for EngineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Request(error) => write!(f, "the request cannot be read: {error}"),
            Self::TooLong { bytes, limit } => {
                write!(f, "the request has {bytes} bytes; expected at most {limit}")
            }
            Self::NoKind(kind) => {
                write!(f, "kind: {kind}; expected 0 (training), 1 (scene) or 2 (statistics)")
            }
            Self::Missing(what) => write!(f, "{what} is missing; expected before this request"),
            Self::NoScene(name) => write!(f, "scene: there is no scene '{name}'"),
            Self::NoLock(what) => write!(f, "locks: {what}"),
            Self::Mosaic(error) => write!(f, "mosaic: {error}"),
            Self::Photograph(what) => write!(f, "photograph: {what}"),
            Self::Text(diagnostic) => diagnostic.fmt(f),
            Self::Camera(error) => error.fmt(f),
            Self::Design(error) => error.fmt(f),
            Self::File(error) => error.fmt(f),
            Self::Light(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for EngineError {}

macro_rules! from {
    ($($source:ty => $variant:ident),*) => {
        $(impl From<$source> for EngineError {
            fn from(error: $source) -> Self {
                Self::$variant(error)
            }
        })*
    };
}

from!(
    serde_json::Error => Request,
    Box<Diagnostic> => Text,
    CameraError => Camera,
    DesignError => Design,
    IoError => File,
    LiveLockError => NoLock,
    ExchangeError => Mosaic
);

impl From<StudioAssetError> for EngineError {
    fn from(error: StudioAssetError) -> Self {
        Self::Light(Box::new(error))
    }
}
