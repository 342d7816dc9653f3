//! File locks, which the operating system releases when their process ends.
//!
//! A run without shards locks `.lock` exclusively. Shards share this lock, and each locks `.lock-shard-I-of-N` exclusively. The lock
//! file contains the process that holds the lock, for error messages. The file itself does not lock anything.

use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::error::{DatasetError, writing};
use super::shard::Shard;
use crate::IoError;

const WHOLE: &str = ".lock";
const MANIFEST: &str = ".lock-manifest";
const SHARD: &str = ".lock-shard-";

/// Held locks. Dropping the value releases them.
#[derive(Debug)]
pub(super) struct Locks {
    _files: Vec<File>,
}

pub(super) fn is_lock(name: &str) -> bool {
    name == WHOLE || name == MANIFEST || name.starts_with(SHARD)
}

/// Locks a folder for a whole run or a shard. Returns [`DatasetError::Busy`] if another run holds the lock.
pub(super) fn acquire(dir: &Path, shard: Option<Shard>) -> Result<Locks, DatasetError> {
    let busy = |by: String| DatasetError::Busy { dir: dir.to_owned(), by };
    let path = dir.join(WHOLE);
    let mut whole = open(&path)?;
    let Some(shard) = shard else {
        if !attempt(&path, || whole.try_lock())? {
            return Err(busy(holders(dir)));
        }
        sign(&mut whole);
        // No shard holds its lock now, since shards also share `.lock`.
        shard_locks(dir).for_each(|(path, _)| drop(fs::remove_file(path)));
        return Ok(Locks { _files: vec![whole] });
    };
    if !attempt(&path, || whole.try_lock_shared())? {
        return Err(busy(signature(&path)));
    }
    let path = dir.join(format!("{SHARD}{}-of-{}", shard.index(), shard.of()));
    let mut own = open(&path)?;
    if !attempt(&path, || own.try_lock())? {
        return Err(busy(format!("shard {shard}, {}", signature(&path))));
    }
    sign(&mut own);
    // Shards of another division would write the same chunks.
    for (path, other) in shard_locks(dir).filter(|(_, other)| other.of() != shard.of()) {
        if is_held(&path) {
            return Err(busy(format!("shard {other}, {}", signature(&path))));
        }
    }
    Ok(Locks { _files: vec![own, whole] })
}

/// Waits for the lock of the manifest, which is held only briefly.
pub(super) fn manifest(dir: &Path) -> Result<Locks, DatasetError> {
    let path = dir.join(MANIFEST);
    let file = open(&path)?;
    file.lock().map_err(|source| DatasetError::Lock { path, source })?;
    Ok(Locks { _files: vec![file] })
}

fn open(path: &Path) -> Result<File, DatasetError> {
    File::options()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(path)
        .map_err(|e| writing(IoError::writing(path)(e)))
}

/// Tries to take a lock and returns whether it succeeded. Retries, since [`is_held`] in another process takes the lock for a moment.
fn attempt(path: &Path, lock: impl Fn() -> Result<(), TryLockError>) -> Result<bool, DatasetError> {
    for wait_ms in [0, 10, 20, 40] {
        std::thread::sleep(Duration::from_millis(wait_ms));
        match lock() {
            Ok(()) => return Ok(true),
            Err(TryLockError::WouldBlock) => {}
            Err(TryLockError::Error(source)) => {
                return Err(DatasetError::Lock { path: path.to_owned(), source });
            }
        }
    }
    Ok(false)
}

fn is_held(path: &Path) -> bool {
    File::open(path).is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

/// The lock files of shards.
fn shard_locks(dir: &Path) -> impl Iterator<Item = (PathBuf, Shard)> {
    fs::read_dir(dir).into_iter().flatten().flatten().filter_map(|entry| {
        let name = entry.file_name();
        let (index, of) = name.to_str()?.strip_prefix(SHARD)?.split_once("-of-")?;
        Some((entry.path(), Shard::new(index.parse().ok()?, of.parse().ok()?).ok()?))
    })
}

/// Writes the process and the host into a lock file. Errors are ignored, since the text is only for messages.
fn sign(file: &mut File) {
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let (pid, host) = (std::process::id(), host.trim());
    let on = if host.is_empty() { String::new() } else { format!(" on {host}") };
    let _ = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| write!(file, "process {pid}{on}"));
}

fn signature(path: &Path) -> String {
    let read = || -> io::Result<String> {
        let mut text = String::new();
        File::open(path)?.take(256).read_to_string(&mut text)?;
        Ok(text)
    };
    read().ok().filter(|text| !text.is_empty()).unwrap_or_else(|| "unknown process".to_owned())
}

/// Describes the runs whose locks block a whole run.
fn holders(dir: &Path) -> String {
    let mut shards: Vec<(Shard, PathBuf)> =
        shard_locks(dir).filter(|(path, _)| is_held(path)).map(|(path, shard)| (shard, path)).collect();
    shards.sort_by_key(|(shard, _)| (shard.of(), shard.index()));
    match shards.first() {
        None => signature(&dir.join(WHOLE)),
        Some((shard, path)) => {
            let more = shards.len() - 1;
            let more = if more > 0 { format!(", and {more} more") } else { String::new() };
            format!("shard {shard}, {}{more}", signature(path))
        }
    }
}
