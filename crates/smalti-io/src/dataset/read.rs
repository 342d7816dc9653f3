//! Reading results.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::error::DatasetError;
use super::folder::missing;
use super::manifest::Manifest;
use super::run::read_manifest;
use super::schema::Column;
use super::{folder, part};

/// A folder of results, complete or not. Reading takes no lock, since the parts of an active run are complete.
#[derive(Debug, Clone)]
pub struct Dataset {
    dir: PathBuf,
    manifest: Manifest,
    chunks: Vec<u64>,
}

/// Some columns of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// The number of the chunk.
    pub chunk: u64,
    /// The trials of the chunk. Row `i` is trial `trials.start + i`.
    pub trials: Range<u64>,
    /// The columns in the requested order.
    pub columns: Vec<Column>,
}

impl Dataset {
    /// Opens a folder: reads the manifest and lists the parts.
    ///
    /// # Errors
    /// When the folder cannot be read, has no manifest, has a manifest that is damaged or of another revision, or has an unknown file
    /// among the parts.
    pub fn open(dir: &Path) -> Result<Self, DatasetError> {
        let manifest = read_manifest(dir)?;
        let chunks = folder::list(dir, manifest.plan.chunks(), None)?;
        Ok(Self { dir: dir.to_owned(), manifest, chunks })
    }

    /// The manifest.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The folder.
    #[must_use]
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// The existing chunks, ascending.
    #[must_use]
    pub fn chunks(&self) -> &[u64] {
        &self.chunks
    }

    /// The missing chunks, ascending.
    pub fn missing(&self) -> impl Iterator<Item = u64> {
        missing(self.manifest.plan.chunks(), &self.chunks)
    }

    /// Whether all parts exist.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.chunks.len() as u64 == self.manifest.plan.chunks()
    }

    /// Number of trials in the existing parts.
    #[must_use]
    pub fn trials(&self) -> u64 {
        let count = |&c: &u64| self.manifest.plan.trials_of(c);
        self.chunks.iter().map(count).map(|r| r.end - r.start).sum()
    }

    /// Iterates over the parts and reads the columns with these names.
    ///
    /// # Errors
    /// [`DatasetError::UnknownColumn`].
    pub fn columns(&self, names: &[&str]) -> Result<Rows<'_>, DatasetError> {
        let schema = &self.manifest.plan.schema;
        let index = |name: &&str| {
            schema.iter().position(|c| c.name == *name).ok_or_else(|| DatasetError::UnknownColumn {
                dir: self.dir.clone(),
                name: (*name).to_owned(),
                known: schema.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", "),
            })
        };
        let indices = names.iter().map(index).collect::<Result<_, _>>()?;
        Ok(Rows { dataset: self, indices, next: 0 })
    }

    /// Reads every existing part and checks its hash.
    ///
    /// # Errors
    /// For the first part that cannot be read, is damaged or belongs to other results.
    pub fn verify(&self) -> Result<(), DatasetError> {
        self.columns(&[])?.try_for_each(|part| part.map(drop))
    }

    pub(super) fn path(&self, chunk: u64) -> PathBuf {
        folder::part(&self.dir, chunk)
    }
}

/// Iterator over the parts of a dataset. It reads one part at a time and checks its hash.
#[derive(Debug, Clone)]
pub struct Rows<'a> {
    dataset: &'a Dataset,
    indices: Vec<usize>,
    next: usize,
}

impl Iterator for Rows<'_> {
    type Item = Result<Part, DatasetError>;

    fn next(&mut self) -> Option<Self::Item> {
        let dataset = self.dataset;
        let chunk = *dataset.chunks.get(self.next)?;
        self.next += 1;
        let trials = dataset.manifest.plan.trials_of(chunk);
        let columns = part::read(&dataset.path(chunk), &dataset.manifest, chunk, &self.indices);
        Some(columns.map(|columns| Part { chunk, trials, columns }))
    }
}
