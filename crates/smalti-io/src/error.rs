//! What can go wrong with a file.

use std::path::{Path, PathBuf};
use std::{fmt, io};

use smalti::color::ImageError;
use smalti::color::jakob_hanika2019::UpliftError;
use smalti::design::DesignError;
use smalti::l3::L3Error;
use smalti::numeric::ShapeError;
use smalti::scene::SceneError;
use smalti::sensor::{CfaError, RawError};
use smalti::spectrum::SpectrumError;
use thiserror::Error;

/// A file that cannot be read or written. Every message names the file, and the place in it where there is one.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the message of an error says what its fields are")]
pub enum IoError {
    /// The operating system refused to read.
    #[error("cannot read {}: {source}", path.display())]
    Read { path: PathBuf, source: io::Error },
    /// The operating system refused to write.
    #[error("cannot write {}: {source}", path.display())]
    Write { path: PathBuf, source: io::Error },
    /// The file, or what it declares to hold, is larger than allowed.
    #[error("{}: {what} takes {bytes} bytes; at most {limit} are allowed", path.display())]
    TooLarge { path: PathBuf, what: &'static str, bytes: u64, limit: u64 },
    /// What is to be done with the file takes more memory than is available.
    #[error("{}: {what} takes {} MB of memory, and {} MB are available", path.display(), bytes / 1_000_000, available / 1_000_000)]
    Memory { path: PathBuf, what: &'static str, bytes: u64, available: u64 },
    /// The file ends before what it declares; lengths in bytes.
    #[error("{}: {what} needs {need} bytes, but the file has {have}; it is cut short or mislabelled", path.display())]
    Truncated { path: PathBuf, what: &'static str, need: u64, have: u64 },
    /// A text file is not UTF-8. The line is that of the first bad byte, from 1.
    #[error("{}: line {line} is not UTF-8 text", path.display())]
    NotUtf8 { path: PathBuf, line: usize },
    /// The format is not one that is read or written here.
    #[error("{}: expected {expected}", path.display())]
    UnknownFormat { path: PathBuf, expected: &'static str },
    /// This build of Smalti was made without the format.
    #[error("{}: this build of Smalti leaves out {format}; expected one with the feature {feature}, which is on by default", path.display())]
    LeftOut { path: PathBuf, format: &'static str, feature: &'static str },
    /// A path-traced scene cannot have another light.
    #[error(
        "{name}: the scene keeps its own light, since its lamps have different spectra and surfaces reflect light on each other; expected no illuminant"
    )]
    Lamps { name: String },
    /// A decoder found the file malformed.
    #[error("{}: not a valid {format} file: {message}", path.display())]
    Decode { path: PathBuf, format: &'static str, message: String },
    /// A line of a text file is wrong; the first is 1.
    #[error("{}: line {line}: found {found}; expected {expected}", path.display())]
    Line { path: PathBuf, line: usize, found: String, expected: String },
    /// A field (tag, attribute, channel, key) is missing, unsupported or out of range.
    #[error("{}: {field} is {found}; expected {expected}", path.display())]
    Field { path: PathBuf, field: String, found: String, expected: String },
    /// The file does not state a property that [`ReadOptions`](crate::ReadOptions) can state in its place.
    #[error("{}: {field} is {found}; expected {expected}, or {property} given with the file", path.display())]
    Unstated { path: PathBuf, field: String, found: String, expected: String, property: UnstatedProperty },
    /// A sample is NaN, infinite, or negative where that has no meaning. Rows and columns count from 0.
    #[error("{}: channel {channel}, row {row}, column {col} (counted from 0) is {value}; expected {expected}", path.display())]
    Pixel { path: PathBuf, channel: String, row: usize, col: usize, value: f64, expected: &'static str },
    /// The content makes no value of the library.
    #[error("{}: {source}", path.display())]
    Content { path: PathBuf, source: ContentError },
    /// A light that is neither a name nor a file.
    #[error(transparent)]
    Light(SpectrumError),
    /// A built-in scene (its name with the parameters) that is not there, or cannot be as asked.
    #[error("{}{source}", unnamed(name, source))]
    Catalog { name: String, source: SceneError },
    /// The file was written by a later (or other) version of its format.
    #[error("{}: it is version {found} of the {format} format; version {expected} is read here", path.display())]
    Version { path: PathBuf, format: &'static str, found: String, expected: String },
    /// A variable of the environment states nothing that it can mean.
    #[error("the variable {variable} is '{found}'; expected {expected}")]
    Environment { variable: &'static str, found: String, expected: &'static str },
    /// The content has another hash (hexadecimal) than the file states.
    #[error("{}: it is damaged: its content has the hash {found}, but {stated} is stated", path.display())]
    Damaged { path: PathBuf, found: String, stated: String },
}

/// A property of a file that the options of reading can state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum UnstatedProperty {
    /// [`ReadOptions::grid`](crate::ReadOptions::grid).
    Wavelengths,
    /// [`ReadOptions::quantity`](crate::ReadOptions::quantity).
    Quantity,
    /// [`ReadOptions::variable`](crate::ReadOptions::variable).
    Variable,
}

impl fmt::Display for UnstatedProperty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Wavelengths => "the wavelengths",
            Self::Quantity => "the quantity",
            Self::Variable => "the name of the array",
        })
    }
}

/// Why the content of a file makes no value of the library.
#[derive(Debug, Error)]
#[error(transparent)]
#[non_exhaustive]
pub enum ContentError {
    /// No spectrum or spectral cube.
    Spectrum(#[from] SpectrumError),
    /// A picture whose colours cannot be converted to spectra.
    Uplift(#[from] UpliftError),
    /// No scene.
    Scene(#[from] SceneError),
    /// No raw image.
    Raw(#[from] RawError),
    /// No mosaic.
    Mosaic(#[from] CfaError),
    /// No picture.
    Image(#[from] ImageError),
    /// No learned pipeline and no statistics.
    Learned(#[from] L3Error),
    /// No statistics of light.
    Light(#[from] Box<DesignError>),
    /// The shape does not match the data.
    Shape(#[from] ShapeError),
}

/// The name of a scene and a colon, where the error does not name it itself.
fn unnamed(name: &str, error: &SceneError) -> String {
    use SceneError::{BadValue, Syntax, UnknownParameter, UnknownScene};
    match error {
        UnknownScene { .. } | UnknownParameter { .. } | BadValue { .. } | Syntax { .. } => String::new(),
        _ => format!("{name}: "),
    }
}

/// Names the file in an error of the library.
pub(crate) trait At<T> {
    /// The same result, with the file named.
    fn at(self, path: &Path) -> Result<T, IoError>;
}

impl<T, E: Into<ContentError>> At<T> for Result<T, E> {
    fn at(self, path: &Path) -> Result<T, IoError> {
        self.map_err(|source| IoError::Content { path: path.to_owned(), source: source.into() })
    }
}

impl IoError {
    /// Names the file that the system cannot read.
    pub(crate) fn reading(path: &Path) -> impl Fn(io::Error) -> Self + Copy {
        move |source| Self::Read { path: path.to_owned(), source }
    }

    /// Names the file or folder that the system cannot write.
    pub(crate) fn writing(path: &Path) -> impl Fn(io::Error) -> Self + Copy {
        move |source| Self::Write { path: path.to_owned(), source }
    }

    /// A file that is not valid in its format.
    pub(crate) fn decode(path: &Path, format: &'static str, message: impl ToString) -> Self {
        Self::Decode { path: path.to_owned(), format, message: message.to_string() }
    }

    /// A file that ends before what it declares.
    pub(crate) fn truncated(path: &Path, what: &'static str, need: u64, have: u64) -> Self {
        Self::Truncated { path: path.to_owned(), what, need, have }
    }

    /// A file of another format.
    pub(crate) fn unknown(path: &Path, expected: &'static str) -> Self {
        Self::UnknownFormat { path: path.to_owned(), expected }
    }

    /// A line of a text file, from 1, that is not what it should be.
    pub(crate) fn line(path: &Path, line: usize, found: impl Into<String>, expected: &str) -> Self {
        Self::Line { path: path.to_owned(), line, found: found.into(), expected: expected.to_owned() }
    }

    /// A sample in a row and column, from 0.
    pub(crate) fn pixel(
        path: &Path,
        channel: impl Into<String>,
        [row, col]: [usize; 2],
        value: f32,
        expected: &'static str,
    ) -> Self {
        let (path, channel) = (path.to_owned(), channel.into());
        Self::Pixel { path, channel, row, col, value: value.into(), expected }
    }

    /// A field that is not what it should be.
    pub(crate) fn field(
        path: &Path,
        field: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        let (path, field) = (path.to_owned(), field.into());
        Self::Field { path, field, found: found.into(), expected: expected.into() }
    }

    /// The error of a field, whose property the options of reading can state.
    pub(crate) fn or_given(self, property: UnstatedProperty) -> Self {
        match self {
            Self::Field { path, field, found, expected } => {
                Self::Unstated { path, field, found, expected, property }
            }
            other => other,
        }
    }
}
