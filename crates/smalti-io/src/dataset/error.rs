//! What can go wrong with a folder of results.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::difference::Differences;
use super::shard::Shard;
use crate::IoError;

/// Results that cannot be written, continued, read or merged. Every message names the file or folder.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// A file cannot be read or written, or the manifest is not one.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A file cannot be written for want of space or of the right to. What was written before is kept.
    #[error(
        "cannot write {}: {source}; what is finished is kept: once it can be written, the same command continues",
        path.display()
    )]
    NoSpace {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A plan that cannot be carried out.
    #[error("{what} is {found}; expected {expected}")]
    Plan {
        /// What is wrong: `trials`, `chunk`, a column.
        what: String,
        /// What it is.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// A folder that holds other things and no results.
    #[error(
        "{} holds {found} but no manifest.json; expected a new or empty folder, or results to be continued",
        dir.display()
    )]
    NotResults {
        /// The folder.
        dir: PathBuf,
        /// One of the things in it.
        found: String,
    },
    /// A folder without results.
    #[error("{} holds no results: it has no manifest.json", dir.display())]
    NoResults {
        /// The folder.
        dir: PathBuf,
    },
    /// A file among the parts that is not a part; readers of the whole folder would take it for one.
    #[error("{} is no part of these results; move it elsewhere", path.display())]
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
        /// What differs.
        differences: Differences,
    },
    /// Another run is at work in the folder.
    #[error("another run is at work in {} ({by}); wait for it, or choose another folder", dir.display())]
    Busy {
        /// The folder.
        dir: PathBuf,
        /// Who is at work.
        by: String,
    },
    /// The file system cannot lock files, so that two runs in one folder could not be told.
    #[error(
        "cannot lock {}: {source}; write to a folder on a local disk (shards: one each, then merge them)",
        path.display()
    )]
    Lock {
        /// The lock file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A part that cannot be used.
    #[error("{} {problem}; delete it and run the sweep again: its trials are computed anew", path.display())]
    Part {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: PartProblem,
    },
    /// A chunk that is not there or belongs to another shard.
    #[error("part {chunk} is not one of this run: there are {chunks}, shard {shard}", shard = shard.map_or_else(|| "none".to_owned(), |s| s.to_string()))]
    NotOwn {
        /// The chunk.
        chunk: u64,
        /// Number of chunks.
        chunks: u64,
        /// The shard of the run.
        shard: Option<Shard>,
    },
    /// Columns to be written are not those of the plan.
    #[error("part {chunk}: {what} is {found}; expected {expected}")]
    Columns {
        /// The chunk.
        chunk: u64,
        /// What is wrong.
        what: String,
        /// What it is.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// The Parquet library refuses to encode.
    #[error("part {chunk} cannot be encoded: {message}")]
    Encode {
        /// The chunk.
        chunk: u64,
        /// What the library says.
        message: String,
    },
    /// A column is asked for that is not in the results.
    #[error("{}: no column is called {name:?}; there are {known}", dir.display())]
    UnknownColumn {
        /// The folder.
        dir: PathBuf,
        /// The name.
        name: String,
        /// The names that are known.
        known: String,
    },
    /// Nothing to merge.
    #[error("no folders to merge are named")]
    NothingToMerge,
    /// Shards that do not make a whole.
    #[error(
        "{missing} of {chunks} parts are in none of the folders, the first of them {first}; finish their shards first"
    )]
    Incomplete {
        /// Chunks that are missing.
        missing: u64,
        /// Chunks there should be.
        chunks: u64,
        /// The first that is missing.
        first: u64,
    },
    /// Two folders hold the same chunk with other values.
    #[error("{} and {} hold the same trials with other values", first.display(), second.display())]
    Conflict {
        /// One file.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
}

/// What is wrong with a part.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PartProblem {
    /// It lacks the mark at its begin or end.
    #[error("is cut short or no Parquet file ({bytes} bytes)")]
    Truncated {
        /// Bytes there are.
        bytes: u64,
    },
    /// It does not carry the marks of a part.
    #[error("is a Parquet file that Smalti did not write: it has no {key}")]
    NotOurs {
        /// The key that is missing.
        key: &'static str,
    },
    /// Its content has another hash than it states.
    #[error("is damaged: its content has the hash {found}, but {stated} is stated")]
    Damaged {
        /// Hash of the content, hexadecimal.
        found: String,
        /// Hash that is stated.
        stated: String,
    },
    /// It belongs to other results.
    #[error("is a part of other results: its {key} is {found}; expected {expected}")]
    Foreign {
        /// The key that differs.
        key: &'static str,
        /// What it is.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// The Parquet library cannot read it.
    #[error("is malformed: {message}")]
    Malformed {
        /// What is wrong.
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

/// A failure to write, classified by whether a later attempt can succeed.
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
