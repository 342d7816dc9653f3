//! Writing results into a locked folder.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use serde_json::Value;

use super::error::{DatasetError, writing};
use super::lock::{self, Locks};
use super::manifest::{Manifest, Plan, RunRecord};
use super::schema::Column;
use super::shard::Shard;
use super::{folder, part};
use crate::write;

/// The file that marks the results of a comparison or an evaluation.
const COMPARISON: &str = "results.json";

/// A locked folder of results, which this run fills alone or as one of several shards. The lock is released when the value is dropped or
/// the process ends.
#[derive(Debug)]
pub struct Run {
    dir: PathBuf,
    manifest: Manifest,
    shard: Option<Shard>,
    missing: Vec<u64>,
    written: AtomicU64,
    _locks: Locks,
}

impl Run {
    /// Creates a folder of results, or resumes one of the same plan, as a whole run or as a shard. Checks the last bytes of the existing
    /// parts, which show whether a part is complete and belongs to the plan. Removes the temporary files of killed runs.
    ///
    /// # Errors
    /// When the plan is invalid; when `dir` is a file; when the folder holds other files, other results (the error lists the differences), a
    /// truncated part or an unknown file among the parts; when another run has locked it; when it cannot be read, locked or written.
    pub fn open(dir: &Path, plan: &Plan, shard: Option<Shard>) -> Result<Self, DatasetError> {
        let manifest = Manifest::new(plan)?;
        if dir.is_file() {
            return Err(DatasetError::NotFolder(dir.to_owned()));
        }
        Self::open_as(dir, manifest, shard)
    }

    /// As [`Run::open`], for a manifest that may come from another version of Smalti.
    pub(super) fn open_as(
        dir: &Path,
        manifest: Manifest,
        shard: Option<Shard>,
    ) -> Result<Self, DatasetError> {
        part::check_supported(dir)?;
        folder::check_ours(dir)?;
        write::begin_folder(dir, &[])?;
        let locks = lock::acquire(dir, shard)?;
        settle_manifest(dir, &manifest)?;
        write::create_folder(&folder::parts_dir(dir)).map_err(writing)?;
        let chunks = manifest.plan.chunks();
        let own = |chunk: &u64| shard.is_none_or(|s| s.owns(*chunk));
        let mut there = folder::list(dir, chunks, Some(shard))?;
        there.retain(own);
        for &chunk in &there {
            part::quick_check(&folder::part(dir, chunk), &manifest, chunk)?;
        }
        let missing = folder::missing(chunks, &there).filter(own).collect();
        Ok(Self { dir: dir.to_owned(), manifest, shard, missing, written: AtomicU64::new(0), _locks: locks })
    }

    /// The chunks of this run that were missing when it was opened, ascending.
    #[must_use]
    pub fn missing(&self) -> &[u64] {
        &self.missing
    }

    /// The manifest of the plan, without runs.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Writes a chunk, given one value per trial in each column, in the order of the trials. Chunks may be written in any order and from
    /// any thread. The part is on disk on return.
    ///
    /// # Errors
    /// When the chunk does not belong to this run, the columns do not match the plan, or the file cannot be written.
    pub fn write(&self, chunk: u64, columns: &[Column]) -> Result<(), DatasetError> {
        self.check_own(chunk)?;
        self.put(chunk, &part::encode(&self.manifest, chunk, columns)?)
    }

    /// Writes the bytes of a part and counts it.
    pub(super) fn put(&self, chunk: u64, bytes: &[u8]) -> Result<(), DatasetError> {
        folder::write_part(&self.dir, chunk, bytes)?;
        self.written.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }

    /// Counts a part that another process has written with [`write_part`](super::write_part). The file is not checked, since a shared file
    /// system may show it late.
    ///
    /// # Errors
    /// When the chunk does not belong to this run.
    pub fn adopt(&self, chunk: u64) -> Result<(), DatasetError> {
        self.check_own(chunk)?;
        self.written.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }

    fn check_own(&self, chunk: u64) -> Result<(), DatasetError> {
        let chunks = self.manifest.plan.chunks();
        if chunk < chunks && self.shard.is_none_or(|s| s.owns(chunk)) {
            Ok(())
        } else {
            Err(DatasetError::NotOwn { chunk, chunks, shard: self.shard })
        }
    }

    /// Ends the run and, if it wrote any part, records it in the manifest. Returns the number of missing chunks, including those of other
    /// shards.
    ///
    /// # Errors
    /// When the folder cannot be read or the manifest cannot be written.
    pub fn finish(self, timings: Value) -> Result<u64, DatasetError> {
        let parts = self.written.load(Ordering::Relaxed);
        let record = RunRecord { shard: self.shard.map(|s| s.to_string()), parts, timings };
        self.finish_with(if parts > 0 { vec![record] } else { Vec::new() })
    }

    /// Ends the run and adds `records` to the manifest.
    pub(super) fn finish_with(self, records: Vec<RunRecord>) -> Result<u64, DatasetError> {
        // A part whose name is lost is computed again.
        write::sync_folder(&folder::parts_dir(&self.dir));
        if !records.is_empty() {
            let _lock = lock::manifest(&self.dir)?;
            let mut manifest = read_manifest(&self.dir)?;
            manifest.runs.extend(records);
            manifest.write(&self.dir).map_err(writing)?;
        }
        let chunks = self.manifest.plan.chunks();
        Ok(chunks.saturating_sub(folder::list(&self.dir, chunks, None)?.len() as u64))
    }
}

pub(super) fn read_manifest(dir: &Path) -> Result<Manifest, DatasetError> {
    Manifest::read(dir)?.ok_or_else(|| {
        let dir = dir.to_owned();
        let is_comparison = dir.join(COMPARISON).is_file();
        if is_comparison { DatasetError::Comparison { dir } } else { DatasetError::NoResults { dir } }
    })
}

/// Writes the manifest into a new folder, or compares it with the existing one.
fn settle_manifest(dir: &Path, manifest: &Manifest) -> Result<(), DatasetError> {
    // Two shards may start at the same time.
    let _lock = lock::manifest(dir)?;
    folder::sweep_manifest(dir)?;
    match Manifest::read(dir)? {
        None => Ok(manifest.write(dir).map_err(writing)?),
        Some(was) => was.check_same(manifest, dir),
    }
}
