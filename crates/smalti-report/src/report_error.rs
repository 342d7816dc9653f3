//! Errors of reports, and errors as one line of text.

use std::error::Error;

use smalti::camera::CameraError;
use smalti::color::ImageError;
use smalti::design::DesignError;
use smalti::design::statistics::StatisticsError;
use smalti::numeric::ShapeError;
use smalti::spectrum::SpectrumError;
use thiserror::Error;

use crate::FigureError;

/// A report that cannot be made from the given data.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The caller asked to stop.
    #[error("stopped")]
    Stopped,
    /// A column that every study has is absent, or holds values of another kind.
    #[error("{origin}: its column {column} is absent or holds values that a sweep does not write")]
    Column {
        /// Where the results were read.
        origin: String,
        /// The column.
        column: String,
    },
    /// A design has an impossible number of colours.
    #[error("{origin}: a design has {colors} colours; expected 1 to 26")]
    Colors {
        /// Where the results were read.
        origin: String,
        /// The number.
        colors: i64,
    },
    /// The number of a row, setup or condition is beyond the last.
    #[error("no such {what}")]
    Missing {
        /// What was requested.
        what: &'static str,
    },
    /// The number of a trial is beyond the last.
    #[error("it has trials 0 to {last}, not {number}")]
    NoSuchTrial {
        /// The requested number.
        number: u64,
        /// The largest number.
        last: u64,
    },
    /// Pictures of a trial are requested that the results do not hold.
    #[error("the pictures of trial {number} cannot be embedded: {study} holds no such trial")]
    NoSuchPicture {
        /// The number of the trial.
        number: u64,
        /// The study.
        study: String,
    },
    /// Figures of a condition are requested that no study has.
    #[error("no condition has '{text}' in its name; the conditions are {known}")]
    NoSuchCondition {
        /// What was requested.
        text: String,
        /// The names of the conditions.
        known: String,
    },
    /// A figure cannot be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// A named figure cannot be drawn.
    #[error("{name}")]
    Named {
        /// The name of its file, without extension.
        name: String,
        /// Why.
        source: FigureError,
    },
    /// A design cannot be made.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// A camera cannot be made, or its pictures cannot be computed.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// Statistics cannot be computed.
    #[error(transparent)]
    Statistics(#[from] StatisticsError),
    /// A picture cannot be converted.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// Spectral data do not fit.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// The values of a picture do not fit its shape.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// A value cannot be written as JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// A camera cannot be written as TOML.
    #[error(transparent)]
    Toml(#[from] toml::ser::Error),
    /// The caller could not store a file of the report.
    #[error(transparent)]
    Sink(Box<dyn Error + Send + Sync>),
}

/// An error with its causes as one line. A cause whose text the error already ends with is left out, and so is an error whose text its
/// cause begins with.
#[must_use]
pub fn in_one_line(error: &(dyn Error + 'static)) -> String {
    let mut told = error.to_string();
    let mut cause = error.source();
    while let Some(e) = cause {
        let text = e.to_string();
        told = match (told.ends_with(&text), text.starts_with(&told)) {
            (true, _) => told,
            (_, true) => text,
            _ => format!("{told}: {text}"),
        };
        cause = e.source();
    }
    told
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Error)]
    #[error("{text}")]
    struct Link {
        text: &'static str,
        source: Option<Box<Link>>,
    }

    #[test]
    fn causes_are_repeated_once() {
        let told = |text, cause| {
            in_one_line(&Link { text, source: Some(Box::new(Link { text: cause, source: None })) })
        };
        assert_eq!(told("a", "b"), "a: b");
        assert_eq!(told("x.toml", "x.toml: no key"), "x.toml: no key");
        assert_eq!(told("x.toml: no key", "no key"), "x.toml: no key");
    }
}
