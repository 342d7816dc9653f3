//! A part of a cube, and the errors of reading it.

use std::io;
use std::ops::Range;

use super::values::BadSample;

/// Axes of a cube.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Axis {
    Band,
    Row,
    Col,
}

/// A part of a cube: the bands that are wanted, in the order of the planes they become, its rows and columns.
#[derive(Debug, Clone)]
pub(crate) struct Part<'a> {
    pub(crate) bands: &'a [usize],
    pub(crate) rows: Range<usize>,
    pub(crate) cols: Range<usize>,
}

/// Why a part cannot be had.
#[derive(Debug)]
pub(crate) enum Bad {
    /// The file cannot be read.
    Io(io::Error),
    /// A sample is not what it should be.
    Sample(BadSample),
    /// A compressed block or stream is not what it should be.
    Block(String),
}

impl From<io::Error> for Bad {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::InvalidData => Self::Block(error.to_string()),
            _ => Self::Io(error),
        }
    }
}
