//! Progress reports of an experiment, and stopping it.

use super::ExperimentError;
use crate::color::Image;
use crate::isp::{Isp, IspError};
use crate::sensor::RawImage;

/// Receives the steps of an experiment, from any thread, and can stop it.
pub trait Progress: Sync {
    /// Announces further steps of the work. Steps are announced before the first of them begins.
    fn expect(&self, _steps: u64) {}

    /// A step with this name begins.
    fn begin(&self, _step: &str) {}

    /// A step is done.
    fn done(&self) {}

    /// A picture was rendered. A step may have several pictures; pictures are not steps.
    fn picture(&self) {}

    /// A note for the user that is not an error.
    fn note(&self, _text: &str) {}

    /// The results so far in words, a table of one or more lines. It replaces the previous one.
    fn preliminary(&self, _table: &str) {}

    /// Whether the work should stop. The experiment checks this between steps and pictures, and then ends with
    /// [`ExperimentError::Stopped`].
    fn is_stopped(&self) -> bool {
        false
    }
}

/// Ignores all reports and never stops the work.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {}

/// An error if the work should stop.
pub(super) fn ensure_running(progress: &dyn Progress) -> Result<(), ExperimentError> {
    if progress.is_stopped() { Err(ExperimentError::Stopped) } else { Ok(()) }
}

/// A pipeline that fails once the work should stop.
pub(super) struct Stoppable<'a> {
    pub(super) isp: Box<dyn Isp + 'a>,
    pub(super) progress: &'a dyn Progress,
}

impl Isp for Stoppable<'_> {
    fn render(&self, raw: &RawImage) -> Result<Image, IspError> {
        if self.progress.is_stopped() {
            return Err(IspError::Stopped);
        }
        let picture = self.isp.render(raw)?;
        self.progress.picture();
        Ok(picture)
    }
}
