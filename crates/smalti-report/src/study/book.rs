//! The figures of a report on their way to the caller, who stores them.

use smalti::experiment::Progress;

use super::sections::Section;
use crate::words::plain;
use crate::{Figure, FileSink, ReportError, in_one_line};

/// Conditions and processings that have figures and pictures of their own.
pub(super) const DRAWN: usize = 8;
/// Bytes of a PNG above which it is drawn with fewer pixels: a cloud of a million dots compresses badly.
const LARGE: usize = 1_000_000;
/// Pixels of a large PNG for each pixel of the SVG.
const LARGE_SCALE: f64 = 1.5;

/// The figures that have been stored, and notes about those that could not be drawn.
pub(super) struct Book<'a> {
    progress: &'a dyn Progress,
    store: &'a mut FileSink<'a>,
    /// Folder of the figures that follow, with a `/` at its end; empty for the folder of the report.
    part: String,
    pub(super) files: Vec<String>,
    pub(super) notes: Vec<String>,
}

impl<'a> Book<'a> {
    pub(super) fn new(store: &'a mut FileSink<'a>, progress: &'a dyn Progress) -> Self {
        Self { progress, store, part: String::new(), files: Vec::new(), notes: Vec::new() }
    }

    /// Puts the figures that follow into a folder below that of the report.
    pub(super) fn enter(&mut self, part: &str) {
        self.part = format!("{part}/");
    }

    /// Stores a figure as SVG, and as PNG with `scale` pixels for each of the SVG. A PNG that would be large has fewer pixels.
    pub(super) fn save(&mut self, name: &str, figure: &Figure, scale: f64) -> Result<(), ReportError> {
        ensure_running(self.progress)?;
        let draw = |scale: f64| {
            figure.png(scale).map_err(|source| ReportError::Named { name: name.to_owned(), source })
        };
        let mut png = draw(scale)?;
        if png.len() > LARGE && scale > LARGE_SCALE {
            png = draw(LARGE_SCALE)?;
        }
        for (extension, bytes) in [("svg", figure.svg().as_bytes()), ("png", &png)] {
            let file = format!("{}{name}.{extension}", self.part);
            (self.store)(&file, bytes).map_err(ReportError::Sink)?;
            self.files.push(file);
        }
        self.progress.picture();
        Ok(())
    }

    /// Notes a figure that cannot be drawn: the others are. The error is returned where the caller asked to stop.
    pub(super) fn note(
        &mut self,
        about: &Section<'_>,
        what: &str,
        error: &ReportError,
    ) -> Result<(), ReportError> {
        ensure_running(self.progress)?;
        self.notes.push(format!("{}: no {what}: {}", about.title(), plain(&in_one_line(error))));
        Ok(())
    }
}

/// An error once the caller asks to stop.
pub(super) fn ensure_running(progress: &dyn Progress) -> Result<(), ReportError> {
    if progress.is_stopped() { Err(ReportError::Stopped) } else { Ok(()) }
}
