//! Sweeps: scoring the trials of a study.

use std::ops::Range;

use super::progress::ensure_running;
use super::{ExperimentError, Progress};
use crate::design::{ScoredTrial, Sweep};

/// Scores a range of trials of a sweep, in their order. Each trial is one step of progress. A stop is noticed after each trial, so that at
/// most one trial per thread is scored after it.
///
/// # Errors
/// [`ExperimentError::Design`] when a condition cannot be prepared or a design cannot be built; [`ExperimentError::Stopped`]. A trial
/// without scores is not an error.
pub fn sweep(
    sweep: &Sweep<'_>,
    trials: Range<u64>,
    progress: &dyn Progress,
) -> Result<Vec<ScoredTrial>, ExperimentError> {
    ensure_running(progress)?;
    let done = || {
        progress.done();
        !progress.is_stopped()
    };
    Ok(sweep.score(trials, &done)?)
}
