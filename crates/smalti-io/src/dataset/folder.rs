//! Names and listing of the files in a folder of results.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::error::DatasetError;
use super::manifest;
use super::shard::Shard;
use crate::IoError;

/// Folder of the parts.
const PARTS: &str = "trials";

pub(super) fn parts_dir(dir: &Path) -> PathBuf {
    dir.join(PARTS)
}

pub(super) fn part(dir: &Path, chunk: u64) -> PathBuf {
    dir.join(PARTS).join(name(chunk))
}

fn name(chunk: u64) -> String {
    format!("part-{chunk:06}.parquet")
}

/// The chunk in the file name of a part.
pub(super) fn chunk_of(file: &str) -> Option<u64> {
    let chunk = file.strip_prefix("part-")?.strip_suffix(".parquet")?.parse().ok()?;
    // Refuses other spellings of the number, such as `part-1.parquet` and `part-+00001.parquet`.
    (name(chunk) == file).then_some(chunk)
}

/// The path of a part relative to the folder of results, such as `trials/part-000012.parquet`.
#[must_use]
pub fn part_name(chunk: u64) -> String {
    part(Path::new(""), chunk).to_string_lossy().replace('\\', "/")
}

/// Writes the bytes of a part into a folder that a [`Run`](super::Run) has opened, possibly on another machine. The write is atomic, and
/// the part is on disk on return.
///
/// # Errors
/// When the file cannot be written.
pub fn write_part(dir: &Path, chunk: u64, bytes: &[u8]) -> Result<(), DatasetError> {
    crate::write::durable(&part(dir, chunk), bytes).map_err(super::error::writing)
}

/// The numbers below `chunks` that are not in the ascending list `there`.
pub(super) fn missing(chunks: u64, there: &[u64]) -> impl Iterator<Item = u64> {
    let mut there = there.iter().copied().peekable();
    (0..chunks).filter(move |chunk| there.next_if_eq(chunk).is_none())
}

/// The final name of a temporary file of [`crate::write::atomic`]; `None` for other files.
fn temporary(file: &str) -> Option<&str> {
    let (of, number) = file.strip_prefix('.')?.strip_suffix(".tmp")?.rsplit_once('.')?;
    number.bytes().all(|b| b.is_ascii_digit() || b == b'-').then_some(of)
}

/// Refuses a folder that holds files but no results. A folder that does not exist is accepted.
pub(super) fn check_ours(dir: &Path) -> Result<(), DatasetError> {
    let listing = match fs::read_dir(dir) {
        Ok(listing) => listing,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(IoError::reading(dir)(error).into()),
    };
    let name = |entry: fs::DirEntry| entry.file_name().to_string_lossy().into_owned();
    let names: Vec<String> =
        listing.map(|entry| entry.map(name)).collect::<Result<_, _>>().map_err(IoError::reading(dir))?;
    check_names(dir, names.into_iter())
}

/// As [`check_ours`], for the names of the files in a folder.
pub(super) fn check_names(dir: &Path, names: impl Iterator<Item = String>) -> Result<(), DatasetError> {
    let mut foreign = None;
    for name in names {
        if name == manifest::FILE {
            return Ok(());
        }
        let own = super::lock::is_lock(&name) || temporary(&name) == Some(manifest::FILE);
        // The first by name, so that the message does not depend on the order of the listing.
        if !own && foreign.as_ref().is_none_or(|f| name < *f) {
            foreign = Some(name);
        }
    }
    match foreign {
        Some(found) => Err(DatasetError::NotResults { dir: dir.to_owned(), found }),
        None => Ok(()),
    }
}

/// Removes temporary manifests of killed runs. The caller holds the lock of the manifest.
pub(super) fn sweep_manifest(dir: &Path) -> Result<(), DatasetError> {
    for entry in fs::read_dir(dir).map_err(IoError::reading(dir))? {
        let entry = entry.map_err(IoError::reading(dir))?;
        if temporary(&entry.file_name().to_string_lossy()) == Some(manifest::FILE) {
            remove(&entry.path())?;
        }
    }
    Ok(())
}

/// The existing chunks, ascending. With `sweep`, removes the temporary files of killed runs, either all or those of one shard. Those of
/// other shards may be in use.
pub(super) fn list(dir: &Path, chunks: u64, sweep: Option<Option<Shard>>) -> Result<Vec<u64>, DatasetError> {
    let parts = parts_dir(dir);
    let listing = match fs::read_dir(&parts) {
        Ok(listing) => listing,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(IoError::reading(&parts)(error).into()),
    };
    let mut found = Vec::new();
    for entry in listing {
        let entry = entry.map_err(IoError::reading(&parts))?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if let Some(chunk) = chunk_of(&name).filter(|c| *c < chunks) {
            found.push(chunk);
        } else if let Some(chunk) = temporary(&name).and_then(chunk_of) {
            if sweep.is_some_and(|shard| shard.is_none_or(|s| s.owns(chunk))) {
                remove(&entry.path())?;
            }
        } else if !name.starts_with(['.', '_']) {
            // Arrow and Spark ignore names that start with a dot or an underscore, but would read this file.
            return Err(DatasetError::Stray { path: entry.path() });
        }
    }
    found.sort_unstable();
    Ok(found)
}

fn remove(path: &Path) -> Result<(), DatasetError> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => {
            Err(super::error::writing(IoError::writing(path)(source)))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_parts_are_read_back_and_no_others() {
        for chunk in [0, 7, 999_999] {
            assert_eq!(chunk_of(&name(chunk)), Some(chunk));
        }
        for other in ["part-1.parquet", "part-+00001.parquet", "part-000001.parquet.bak", "part-.parquet"] {
            assert_eq!(chunk_of(other), None, "{other}");
        }
        assert_eq!(temporary(".part-000012.parquet.77-0.tmp").and_then(chunk_of), Some(12));
        for other in [".part-000012.parquet", "part-000012.parquet.77-0.tmp", ".part-000012.parquet.a.tmp"] {
            assert_eq!(temporary(other), None, "{other}");
        }
    }
}
