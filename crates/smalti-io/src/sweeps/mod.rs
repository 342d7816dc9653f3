//! Sweeps: the plan and the columns of a study, scoring of its trials, and reading of its results.
//!
//! The command and the Python package both use this module, so that they write identical files.

mod columns;
mod results;

pub use columns::{columns, schema};
pub use results::{ResultsError, read_results, read_trials};

use std::ops::Range;
use std::path::Path;
use std::sync::mpsc::sync_channel;
use std::thread;
use std::time::Instant;

use serde_json::json;
use smalti::design::{Metric, MetricTarget, SCORES_REVISION, Sweep, TrialProcessing, Trials};
use smalti::experiment::{self, ExperimentError, Progress};
use smalti::numeric::arithmetic;
use thiserror::Error;

use crate::dataset::{self, Column, Dataset, DatasetError, MAX_CHUNK, MAX_PARTS, Manifest, Plan, Run, Shard};

/// Approximate number of parts of a large study.
const PARTS: u64 = 256;
/// Minimum and maximum number of trials in a part. A killed run loses at most two parts: one being computed and one being written.
const CHUNK: std::ops::RangeInclusive<u64> = 512..=1 << 14;
/// Factor by which parts of slow trials are smaller.
const SLOWER: u64 = 8;

/// Why a sweep did not finish.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SweepError {
    /// A condition cannot be prepared, or a trial cannot be constructed.
    #[error(transparent)]
    Experiment(Box<ExperimentError>),
    /// The results cannot be written.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// The caller stopped the work. The finished parts are kept, and the next run computes the others.
    #[error("stopped; finished parts are kept, and the next run computes the others")]
    Stopped,
    /// The study cannot be converted to JSON.
    #[error("cannot convert the study to JSON: {0}")]
    Study(#[from] serde_json::Error),
}

impl From<ExperimentError> for SweepError {
    fn from(source: ExperimentError) -> Self {
        match source {
            ExperimentError::Stopped => Self::Stopped,
            source => Self::Experiment(source.into()),
        }
    }
}

/// The plan for the results of a study in the folder `dir`. `about` is the description of the study. The chunk size is `part_size`, else
/// that of existing results in the folder, else a value for the number and the speed of the trials.
///
/// # Errors
/// [`SweepError::Study`]; when the plan is invalid.
pub fn plan(trials: &Trials, about: String, part_size: Option<u64>, dir: &Path) -> Result<Plan, SweepError> {
    plan_after(trials, about, part_size, || Some(Dataset::open(dir).ok()?.manifest().plan.clone()))
}

/// As [`plan`], but `there` returns the plan of existing results.
///
/// # Errors
/// [`SweepError::Study`]; when the plan is invalid.
pub fn plan_after(
    trials: &Trials,
    about: String,
    part_size: Option<u64>,
    there: impl FnOnce() -> Option<Plan>,
) -> Result<Plan, SweepError> {
    let study = trials.study();
    let begun = || there().filter(|p| p.trials == trials.len()).map(|p| p.chunk);
    let pictures = |m: &Metric| matches!(m.target(), MetricTarget::ZonePlate | MetricTarget::Scenes);
    let learned = |p: &TrialProcessing| *p != TrialProcessing::Classic;
    let slow = study.metrics.iter().any(pictures) || study.processing.iter().any(learned);
    let even = (trials.len() / PARTS).next_power_of_two().clamp(*CHUNK.start(), *CHUNK.end());
    let least = trials.len().div_ceil(MAX_PARTS);
    let by_size = if slow { even / SLOWER } else { even };
    let chunk = part_size.or_else(begun).unwrap_or(by_size).max(least).min(MAX_CHUNK);
    let mut resolved = serde_json::to_value(study)?;
    if let Some(into) = resolved.as_object_mut() {
        into.insert("about".into(), about.into());
        into.insert("scores_revision".into(), SCORES_REVISION.into());
        // Parts of machines whose last bits differ would not be the same, byte for byte.
        into.insert("arithmetic".into(), arithmetic().into());
    }
    let plan = Plan { study: resolved, schema: schema(study), trials: trials.len(), chunk };
    // An impossible study is refused before the first trial is scored.
    Manifest::new(&plan)?;
    Ok(plan)
}

/// What a [`SweepRun`] did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweepSummary {
    /// Number of trials that it scored.
    pub scored: u64,
    /// Time for scoring and writing, s.
    pub seconds: f64,
    /// Number of parts that the folder still lacks: those of other shards.
    pub parts_missing: u64,
}

/// A sweep into a folder, which stays locked. The parts are computed by [`run`](SweepRun::run), or by other processes that write them with
/// [`dataset::write_part`] and are counted by [`adopt`](SweepRun::adopt).
pub struct SweepRun {
    run: Run,
}

impl SweepRun {
    /// Creates or resumes the folder `dir` with the [`plan`] of the trials, for all of them or for a shard.
    ///
    /// # Errors
    /// As [`plan`] and [`Run::open`].
    pub fn open(
        trials: &Trials,
        about: String,
        part_size: Option<u64>,
        dir: &Path,
        shard: Option<Shard>,
    ) -> Result<Self, SweepError> {
        let plan = plan(trials, about, part_size, dir)?;
        Ok(Self { run: Run::open(dir, &plan, shard)? })
    }

    /// The manifest of the plan, without runs.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        self.run.manifest()
    }

    /// The parts that were missing when the folder was opened, ascending.
    #[must_use]
    pub fn missing(&self) -> &[u64] {
        self.run.missing()
    }

    /// Number of trials in the missing parts.
    #[must_use]
    pub fn trials(&self) -> u64 {
        self.manifest().plan.trials_in(self.missing().iter().copied())
    }

    /// Scores the trials of the missing parts, writes each part while the next is computed, and records the run with its timings in the
    /// manifest. Each trial is one step of progress. `sweep` has the trials that the folder was opened for.
    ///
    /// # Errors
    /// When a condition cannot be prepared, a file cannot be written, or the work is stopped.
    pub fn run(self, sweep: &Sweep<'_>, progress: &dyn Progress) -> Result<SweepSummary, SweepError> {
        let start = Instant::now();
        progress.expect(self.trials());
        score_and_write(sweep, &self.run, progress)?;
        Ok(self.finish(start.elapsed().as_secs_f64(), rayon::current_num_threads())?)
    }

    /// Counts a part that another process has written; see [`Run::adopt`].
    ///
    /// # Errors
    /// When the part does not belong to this run.
    pub fn adopt(&self, part: u64) -> Result<(), DatasetError> {
        self.run.adopt(part)
    }

    /// Records the run with its timings in the manifest and unlocks the folder.
    ///
    /// # Errors
    /// When the folder cannot be read or the manifest cannot be written.
    pub fn finish(self, seconds: f64, threads: usize) -> Result<SweepSummary, DatasetError> {
        let scored = self.trials();
        let parts_missing = self.run.finish(timings(seconds, scored, threads))?;
        Ok(SweepSummary { scored, seconds, parts_missing })
    }
}

/// The timings of a run in the manifest.
#[must_use]
pub fn timings(seconds: f64, trials: u64, threads: usize) -> serde_json::Value {
    json!({"seconds": seconds, "trials": trials, "threads": threads})
}

/// Scores the missing parts of a run, and writes each part while the next is computed.
fn score_and_write(sweep: &Sweep<'_>, run: &Run, progress: &dyn Progress) -> Result<(), SweepError> {
    let plan = &run.manifest().plan;
    thread::scope(|scope| {
        let (sender, receiver) = sync_channel(0);
        let writer = scope.spawn(move || {
            receiver.iter().try_for_each(|(chunk, columns): (u64, Vec<Column>)| run.write(chunk, &columns))
        });
        let mut scored = Ok(());
        for &chunk in run.missing() {
            match score(sweep, plan.trials_of(chunk), progress) {
                // If sending fails, the writer has ended with an error, which is returned below.
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

/// Scores and encodes one part, for machines that share the parts of a study. The bytes are the same on every machine. `manifest` is that
/// of the trials of `sweep`. Each trial is one step of progress.
///
/// # Errors
/// When a condition cannot be prepared, the part does not exist, or the work is stopped.
pub fn encode_part(
    sweep: &Sweep<'_>,
    manifest: &Manifest,
    chunk: u64,
    progress: &dyn Progress,
) -> Result<Vec<u8>, SweepError> {
    let chunks = manifest.plan.chunks();
    if chunk >= chunks {
        return Err(DatasetError::NotOwn { chunk, chunks, shard: None }.into());
    }
    Ok(dataset::encode(manifest, chunk, &score(sweep, manifest.plan.trials_of(chunk), progress)?)?)
}

/// The columns of a range of trials.
fn score(sweep: &Sweep<'_>, range: Range<u64>, progress: &dyn Progress) -> Result<Vec<Column>, SweepError> {
    let rows = experiment::sweep(sweep, range, progress)?;
    Ok(columns(sweep.trials(), &rows).map_err(ExperimentError::from)?)
}
