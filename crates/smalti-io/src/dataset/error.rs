//! Errors in writing, resuming, reading and merging results.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::difference::Differences;
use super::shard::Shard;
use crate::IoError;

/// An error in writing, resuming, reading or merging results.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// A file cannot be read or written, or the manifest is invalid.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A file cannot be written because of missing space or permission. Finished parts are kept.
    #[error(
        "cannot write {} (finished parts are kept, and the same command resumes when it can be written): {source}",
        path.display()
    )]
    NoSpace {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// A plan has an invalid value.
    #[error("{what} is {found}; expected {expected}")]
    Plan {
        /// Name of the value.
        what: String,
        /// The value.
        found: String,
        /// Description of valid values.
        expected: String,
    },
    /// The folder is a file.
    #[error("{} is a file; expected a folder for the results", .0.display())]
    NotFolder(PathBuf),
    /// The folder holds other files and no manifest.
    #[error(
        "{} holds {found} but no manifest.json; expected a new or empty folder, or results to resume",
        dir.display()
    )]
    NotResults {
        /// The folder.
        dir: PathBuf,
        /// The first of the other files by name.
        found: String,
    },
    /// The folder has no manifest.
    #[error("{} holds no results of a sweep: it has no manifest.json", dir.display())]
    NoResults {
        /// The folder.
        dir: PathBuf,
    },
    /// The folder holds the results of a comparison or an evaluation.
    #[error(
        "{} holds a comparison or an evaluation, whose page is {}; expected a folder that `smalti sweep` wrote",
        dir.display(), dir.join("report.html").display()
    )]
    Comparison {
        /// The folder.
        dir: PathBuf,
    },
    /// An unknown file is among the parts. Programs that read the whole folder would read it as a part.
    #[error("{} is not a part of these results; move it out of the folder", path.display())]
    Stray {
        /// The file.
        path: PathBuf,
    },
    /// The folder holds the results of another plan.
    #[error(
        "{} holds the results of another study or version:\n{differences}\nChoose another folder, or undo the change.",
        dir.display()
    )]
    OtherStudy {
        /// The folder.
        dir: PathBuf,
        /// The differences.
        differences: Differences,
    },
    /// Another run has locked the folder.
    #[error("another run is using {} ({by}); wait until it ends, or choose another folder", dir.display())]
    Busy {
        /// The folder.
        dir: PathBuf,
        /// Process of the other run, and its shard if any.
        by: String,
    },
    /// A file cannot be locked, so that a second run in the folder would not be noticed.
    #[error(
        "cannot lock {} (write to a local disk; with shards, one folder each, and merge them): {source}",
        path.display()
    )]
    Lock {
        /// The lock file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// A part is invalid.
    #[error("{} {problem}; delete it and run the sweep again to recompute its trials", path.display())]
    Part {
        /// The file.
        path: PathBuf,
        /// Why it is invalid.
        problem: PartProblem,
    },
    /// The chunk does not exist or belongs to another shard.
    #[error("part {chunk} does not belong to this run (parts: {chunks}, shard: {shard})", shard = shard.map_or_else(|| "none".to_owned(), |s| s.to_string()))]
    NotOwn {
        /// The chunk.
        chunk: u64,
        /// Number of chunks.
        chunks: u64,
        /// The shard of the run.
        shard: Option<Shard>,
    },
    /// The columns to be written do not match the plan.
    #[error("part {chunk}: {what} is {found}; expected {expected}")]
    Columns {
        /// The chunk.
        chunk: u64,
        /// The property that does not match.
        what: String,
        /// Its value.
        found: String,
        /// The expected value.
        expected: String,
    },
    /// The Parquet library cannot encode a part.
    #[error("part {chunk} cannot be encoded: {message}")]
    Encode {
        /// The chunk.
        chunk: u64,
        /// Message of the library.
        message: String,
    },
    /// A requested column does not exist.
    #[error("{}: unknown column {name:?}; the columns are {known}", dir.display())]
    UnknownColumn {
        /// The folder.
        dir: PathBuf,
        /// The requested name.
        name: String,
        /// The existing names.
        known: String,
    },
    /// There is no folder to merge.
    #[error("expected at least one folder to merge")]
    NothingToMerge,
    /// The folders to merge lack parts.
    #[error(
        "{missing} of {chunks} parts are in none of the folders, the first being part {first}; finish their shards first"
    )]
    Incomplete {
        /// Number of missing chunks.
        missing: u64,
        /// Number of chunks in the plan.
        chunks: u64,
        /// The first missing chunk.
        first: u64,
    },
    /// Two folders hold different values for the same trials.
    #[error("{} and {} hold different values for the same trials", first.display(), second.display())]
    Conflict {
        /// One file.
        first: PathBuf,
        /// The other file.
        second: PathBuf,
    },
}

/// Why a part is invalid.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PartProblem {
    /// The Parquet magic number is missing at the start or the end.
    #[error("is truncated or not a Parquet file ({bytes} bytes)")]
    Truncated {
        /// Length of the file, bytes.
        bytes: u64,
    },
    /// The metadata of a part are missing.
    #[error("is a Parquet file that Smalti did not write: it has no {key}")]
    NotOurs {
        /// The missing key.
        key: &'static str,
    },
    /// The hash of the content differs from the stated hash.
    #[error("is damaged: its content has the hash {found}, but {stated} is stated")]
    Damaged {
        /// Hash of the content, hexadecimal.
        found: String,
        /// The stated hash.
        stated: String,
    },
    /// It belongs to other results.
    #[error("is a part of other results: its {key} is {found}; expected {expected}")]
    Foreign {
        /// The key that differs.
        key: &'static str,
        /// Its value.
        found: String,
        /// Its value in these results.
        expected: String,
    },
    /// Its Parquet content is invalid.
    #[error("is malformed: {message}")]
    Malformed {
        /// The cause.
        message: String,
    },
}

impl PartProblem {
    pub(super) fn malformed(message: impl ToString) -> Self {
        Self::Malformed { message: message.to_string() }
    }

    pub(super) fn at(self, path: &Path) -> DatasetError {
        DatasetError::Part { path: path.to_owned(), problem: self }
    }
}

/// Converts a write error. Those that the user can remedy become [`DatasetError::NoSpace`], which explains how to resume.
pub(super) fn writing(error: IoError) -> DatasetError {
    use io::ErrorKind::{FileTooLarge, PermissionDenied, QuotaExceeded, ReadOnlyFilesystem, StorageFull};
    match error {
        IoError::Write { path, source }
            if matches!(
                source.kind(),
                StorageFull | QuotaExceeded | ReadOnlyFilesystem | PermissionDenied | FileTooLarge
            ) =>
        {
            DatasetError::NoSpace { path, source }
        }
        error => DatasetError::Io(error),
    }
}
