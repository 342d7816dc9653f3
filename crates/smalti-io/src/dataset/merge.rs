//! Merging of the folders of shards.

use std::path::{Path, PathBuf};

use super::error::DatasetError;
use super::read::Dataset;
use super::run::Run;
use super::{folder, part};
use crate::file;

/// Merges the folders of one plan into the folder `into`. The result equals that of a whole run, except for the runs in the manifest. An
/// interrupted merge can be resumed, and `into` may be one of the folders.
///
/// # Errors
/// When the folders have different plans, lack a chunk or hold different values for one; when a part to be copied is damaged; when
/// `into` cannot be opened, as for [`Run::open`].
pub fn merge(from: &[PathBuf], into: &Path) -> Result<(), DatasetError> {
    let sources = from.iter().map(|dir| Dataset::open(dir)).collect::<Result<Vec<_>, _>>()?;
    let Some((first, others)) = sources.split_first() else { return Err(DatasetError::NothingToMerge) };
    let manifest = first.manifest();
    for other in others {
        if other.manifest().hash() != manifest.hash() {
            let differences = manifest.differences(other.manifest());
            return Err(DatasetError::OtherStudy { dir: first.dir().to_owned(), differences });
        }
    }
    let chunks = manifest.plan.chunks();
    let holds = |dataset: &Dataset, chunk: u64| dataset.chunks().binary_search(&chunk).is_ok();
    // Checked before anything is written.
    let mut absent = (0..chunks).filter(|c| !sources.iter().any(|s| holds(s, *c)));
    if let Some(first) = absent.next() {
        return Err(DatasetError::Incomplete { missing: 1 + absent.count() as u64, chunks, first });
    }

    let mut clean = manifest.clone();
    clean.runs.clear();
    let run = Run::open_as(into, clean, None)?;
    let mut todo = run.missing().iter().copied().peekable();
    for chunk in 0..chunks {
        let target = folder::part(into, chunk);
        let mut holders = sources.iter().filter(|s| holds(s, chunk)).map(|s| s.path(chunk));
        let kept = if todo.next_if_eq(&chunk).is_some() {
            let Some(path) = holders.next() else { continue };
            run.put(chunk, &read(&path, manifest, chunk)?)?;
            path
        } else {
            target
        };
        let hash = part::stated_hash(&kept, manifest)?;
        if let Some(second) = find_other(holders, &hash, manifest)? {
            return Err(DatasetError::Conflict { first: kept, second });
        }
    }
    let there = super::run::read_manifest(into)?.runs;
    let mut records = Vec::new();
    for record in sources.iter().flat_map(|s| &s.manifest().runs) {
        if !there.contains(record) && !records.contains(record) {
            records.push(record.clone());
        }
    }
    run.finish_with(records).map(drop)
}

/// Reads the bytes of a part and checks them.
fn read(path: &Path, manifest: &super::Manifest, chunk: u64) -> Result<Vec<u8>, DatasetError> {
    let bytes = file::read(path, part::LIMIT)?;
    part::part_from_bytes(bytes.clone(), path, manifest, chunk, &[])?;
    Ok(bytes)
}

/// The first file that states a hash other than `hash`.
fn find_other(
    paths: impl Iterator<Item = PathBuf>,
    hash: &str,
    manifest: &super::Manifest,
) -> Result<Option<PathBuf>, DatasetError> {
    for path in paths {
        if part::stated_hash(&path, manifest)? != hash {
            return Ok(Some(path));
        }
    }
    Ok(None)
}
