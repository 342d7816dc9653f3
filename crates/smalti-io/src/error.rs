//! What can go wrong with a file.

use std::io;
use std::path::PathBuf;

use smalti::color::ImageError;
use smalti::color::jakob_hanika2019::UpliftError;
use smalti::l3::L3Error;
use smalti::numeric::ShapeError;
use smalti::scene::SceneError;
use smalti::sensor::{CfaError, RawError};
use smalti::spectrum::SpectrumError;
use thiserror::Error;

/// A file that cannot be read or written. Every message names the file, and the place in it where there is one.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum IoError {
    /// The operating system refused to read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The operating system refused to write.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file, or what it declares to hold, is larger than allowed.
    #[error("{}: {what} takes {bytes} bytes; at most {limit} are allowed", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What takes the memory.
        what: &'static str,
        /// Bytes it takes.
        bytes: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// The file ends before what it declares.
    #[error("{}: {what} needs {need} bytes, but the file has {have}; it is cut short or mislabelled", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// What is missing.
        what: &'static str,
        /// Bytes needed.
        need: u64,
        /// Bytes there are.
        have: u64,
    },
    /// A text file is not UTF-8.
    #[error("{}: line {line} is not UTF-8 text", path.display())]
    NotUtf8 {
        /// The file.
        path: PathBuf,
        /// Line of the first bad byte, from 1.
        line: usize,
    },
    /// The format is not one that is read or written here.
    #[error("{}: expected {expected}", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The formats that are known.
        expected: &'static str,
    },
    /// A decoder found the file malformed.
    #[error("{}: not a valid {format} file: {message}", path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// The format.
        format: &'static str,
        /// What the decoder says.
        message: String,
    },
    /// A line of a text file is wrong.
    #[error("{}: line {line}: found {found}; expected {expected}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is there.
        found: String,
        /// What should be.
        expected: String,
    },
    /// A field (tag, attribute, channel, key) is missing, unsupported or out of range.
    #[error("{}: {field} is {found}; expected {expected}", path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// The field.
        field: String,
        /// What it is.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// A sample is NaN, infinite, or negative where that has no meaning.
    #[error("{}: channel {channel}, row {row}, column {col} is {value}; expected {expected}", path.display())]
    Pixel {
        /// The file.
        path: PathBuf,
        /// The channel or band.
        channel: String,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        col: usize,
        /// The value.
        value: f64,
        /// What was expected.
        expected: &'static str,
    },
    /// The spectral content does not fit.
    #[error("{}: {source}", path.display())]
    Spectrum {
        /// The file.
        path: PathBuf,
        /// Why.
        source: SpectrumError,
    },
    /// A light that is neither a name nor a file.
    #[error(transparent)]
    Light(SpectrumError),
    /// The colours of a picture cannot be lifted to spectra.
    #[error("{}: {source}", path.display())]
    Uplift {
        /// The file.
        path: PathBuf,
        /// Why.
        source: UpliftError,
    },
    /// A built-in scene that is not there, or cannot be as asked.
    #[error("{}{source}", unnamed(name, source))]
    Catalog {
        /// What was asked for: the scene and its parameters.
        name: String,
        /// Why.
        source: SceneError,
    },
    /// The content makes no scene.
    #[error("{}: {source}", path.display())]
    Scene {
        /// The file.
        path: PathBuf,
        /// Why.
        source: SceneError,
    },
    /// The content makes no raw image.
    #[error("{}: {source}", path.display())]
    Raw {
        /// The file.
        path: PathBuf,
        /// Why.
        source: RawError,
    },
    /// The content makes no mosaic.
    #[error("{}: {source}", path.display())]
    Mosaic {
        /// The file.
        path: PathBuf,
        /// Why.
        source: CfaError,
    },
    /// The content makes no picture.
    #[error("{}: {source}", path.display())]
    Image {
        /// The file.
        path: PathBuf,
        /// Why.
        source: ImageError,
    },
    /// The file was written by a later (or other) version of its format.
    #[error("{}: it is version {found} of the {format} format; version {expected} is read here", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// The format.
        format: &'static str,
        /// Its version.
        found: String,
        /// The version that is known.
        expected: &'static str,
    },
    /// The content has another hash than the file states.
    #[error("{}: it is damaged: its content has the hash {found}, but {stated} is stated", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Hash of the content, hexadecimal.
        found: String,
        /// Hash that the file states.
        stated: String,
    },
    /// The content makes no learned pipeline or statistics.
    #[error("{}: {source}", path.display())]
    Learned {
        /// The file.
        path: PathBuf,
        /// Why.
        source: L3Error,
    },
    /// The shape does not match the data.
    #[error("{}: {source}", path.display())]
    Shape {
        /// The file.
        path: PathBuf,
        /// Why.
        source: ShapeError,
    },
}

/// The name of a scene and a colon, where the error does not name it itself.
fn unnamed(name: &str, error: &SceneError) -> String {
    use SceneError::{BadValue, Syntax, UnknownParameter, UnknownScene};
    match error {
        UnknownScene { .. } | UnknownParameter { .. } | BadValue { .. } | Syntax { .. } => String::new(),
        _ => format!("{name}: "),
    }
}

/// Puts the file's name before an error of the library.
pub(crate) trait At<T> {
    /// The same result, with the file named.
    fn at(self, path: &std::path::Path) -> Result<T, IoError>;
}

macro_rules! at {
    ($($error:ty => $variant:ident),*) => {$(
        impl<T> At<T> for Result<T, $error> {
            fn at(self, path: &std::path::Path) -> Result<T, IoError> {
                self.map_err(|source| IoError::$variant { path: path.to_owned(), source })
            }
        }
    )*};
}
at!(SpectrumError => Spectrum, SceneError => Scene, RawError => Raw, CfaError => Mosaic, ImageError => Image, ShapeError => Shape, L3Error => Learned);

impl IoError {
    /// A field that is not what it should be.
    pub(crate) fn field(
        path: &std::path::Path,
        field: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self::Field {
            path: path.to_owned(),
            field: field.into(),
            found: found.into(),
            expected: expected.into(),
        }
    }
}
