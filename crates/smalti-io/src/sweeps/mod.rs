//! Sweeps as folders of results: the parts and columns of a study, the scoring of its trials, and the reading of its results.
//!
//! The command and the Python package write the same bytes, since both write here.

mod columns;
mod results;

pub use columns::{columns, schema};
pub use results::{ResultsError, read_results, read_trials};

use std::path::Path;
use std::sync::mpsc::sync_channel;
use std::thread;
use std::time::{Duration, Instant};

use smalti::design::{
    DesignError, Metric, MetricTarget, Processing, SCORES_REVISION, ScoredTrial, Sweep, Trials,
};
use thiserror::Error;

use crate::dataset::{self, Column, Dataset, DatasetError, MAX_CHUNK, MAX_PARTS, Manifest, Plan, Run};

/// Parts that a large study is cut into, about.
const PARTS: u64 = 256;
/// Fewest and most trials of a part. A run that is killed loses at most two: one that is computed, one that is written.
const CHUNK: std::ops::RangeInclusive<u64> = 512..=1 << 14;
/// Trials that a part of slow ones has fewer, by this factor.
const SLOWER: u64 = 8;
/// How long trials are scored before `go_on` is asked again.
const PATIENCE: Duration = Duration::from_millis(200);
/// Trials of a thread in the first such time.
const FIRST: u64 = 4;

/// A sweep that ended before its end.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SweepError {
    /// A condition cannot be prepared, or a trial cannot be made.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The results cannot be written.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// It was asked to stop. The finished parts are kept, and the next run continues with the others.
    #[error("stopped; what is finished is kept, and the next run goes on from there")]
    Stopped,
    /// The study cannot be stated as JSON.
    #[error("the study: {0}")]
    Study(#[from] serde_json::Error),
}

/// What the results of a study in a folder will be, and how they are cut: in parts of `part_size` trials, else in those that results
/// in the folder have, else by the number and the speed of the trials.
///
/// # Errors
/// [`SweepError::Study`].
pub fn plan(trials: &Trials, about: String, part_size: Option<u64>, dir: &Path) -> Result<Plan, SweepError> {
    plan_after(trials, about, part_size, || Some(Dataset::open(dir).ok()?.manifest().plan.clone()))
}

/// As [`plan`], where what is begun is known otherwise.
///
/// # Errors
/// [`SweepError::Study`].
pub fn plan_after(
    trials: &Trials,
    about: String,
    part_size: Option<u64>,
    there: impl FnOnce() -> Option<Plan>,
) -> Result<Plan, SweepError> {
    let study = trials.study();
    let begun = || there().filter(|p| p.trials == trials.len()).map(|p| p.chunk);
    let pictures = |m: &Metric| matches!(m.target(), MetricTarget::ZonePlate | MetricTarget::Scenes);
    let learned = |p: &Processing| *p != Processing::Classic;
    let slow = study.metrics.iter().any(pictures) || study.processing.iter().any(learned);
    let even = (trials.len() / PARTS).next_power_of_two().clamp(*CHUNK.start(), *CHUNK.end());
    // A million parts at most.
    let least = trials.len().div_ceil(MAX_PARTS);
    let by_size = if slow { even / SLOWER } else { even };
    let chunk = part_size.or_else(begun).unwrap_or(by_size).max(least).min(MAX_CHUNK);
    let mut resolved = serde_json::to_value(study)?;
    if let Some(into) = resolved.as_object_mut() {
        into.insert("about".into(), about.into());
        into.insert("scores_revision".into(), SCORES_REVISION.into());
    }
    Ok(Plan { study: resolved, schema: schema(study), trials: trials.len(), chunk })
}

/// Scores the trials of a run's missing parts and writes them, one part while the next is computed. Calls `done` after each
/// trial, from any thread, and asks `go_on` a few times a second.
///
/// # Errors
/// When a condition cannot be prepared, a part cannot be written, or `go_on` says no.
pub fn score_and_write(
    sweep: &Sweep<'_>,
    trials: &Trials,
    run: &Run,
    done: &(dyn Fn() + Sync),
    go_on: &dyn Fn() -> bool,
) -> Result<(), SweepError> {
    let plan = &run.manifest().plan;
    thread::scope(|scope| {
        let (sender, receiver) = sync_channel(0);
        let writer = scope.spawn(move || {
            receiver.iter().try_for_each(|(chunk, columns): (u64, Vec<Column>)| run.write(chunk, &columns))
        });
        let mut pace = FIRST * rayon::current_num_threads() as u64;
        let mut scored = Ok(());
        for &chunk in run.missing() {
            let part = score(sweep, plan.trials_of(chunk), &mut pace, done, go_on)
                .and_then(|rows| Ok(columns(trials, &rows)?));
            match part {
                // The result of the writer below says why it ended.
                Ok(columns) => {
                    if sender.send((chunk, columns)).is_err() {
                        break;
                    }
                }
                Err(e) => {
                    scored = Err(e);
                    break;
                }
            }
        }
        drop(sender);
        let written = writer.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        written?;
        scored
    })
}

/// The bytes of one part, the same whoever computes them: for machines that share the parts of a study. `manifest` is that of the
/// trials of `sweep`. Asks `go_on` a few times a second.
///
/// # Errors
/// When a condition cannot be prepared, there is no such part, or `go_on` says no.
pub fn encode_part(
    sweep: &Sweep<'_>,
    manifest: &Manifest,
    chunk: u64,
    go_on: &dyn Fn() -> bool,
) -> Result<Vec<u8>, SweepError> {
    let chunks = manifest.plan.chunks();
    if chunk >= chunks {
        return Err(DatasetError::NotOwn { chunk, chunks, shard: None }.into());
    }
    let mut pace = FIRST * rayon::current_num_threads() as u64;
    let rows = score(sweep, manifest.plan.trials_of(chunk), &mut pace, &|| {}, go_on)?;
    Ok(dataset::encode(manifest, chunk, &columns(sweep.trials(), &rows)?)?)
}

/// Scores a range some trials at a time: the rows are the same however many.
fn score(
    sweep: &Sweep<'_>,
    range: std::ops::Range<u64>,
    pace: &mut u64,
    done: &(dyn Fn() + Sync),
    go_on: &dyn Fn() -> bool,
) -> Result<Vec<ScoredTrial>, SweepError> {
    let (mut rows, mut at) = (Vec::new(), range.start);
    while at < range.end {
        if !go_on() {
            return Err(SweepError::Stopped);
        }
        let (start, end) = (Instant::now(), at.saturating_add(*pace).min(range.end));
        rows.extend(sweep.score(at..end, done)?);
        match start.elapsed() {
            short if short < PATIENCE / 2 => *pace = pace.saturating_mul(2).min(MAX_CHUNK),
            long if long > PATIENCE * 2 => *pace = (*pace / 2).max(1),
            _ => {}
        }
        at = end;
    }
    Ok(rows)
}
