//! Reading results.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::error::DatasetError;
use super::folder::missing;
use super::manifest::Manifest;
use super::run::read_manifest;
use super::schema::Column;
use super::{folder, part};

/// A folder of results, complete or not. Reading takes no lock: the parts of a run that is still at work are whole.
#[derive(Debug, Clone)]
pub struct Dataset {
    dir: PathBuf,
    manifest: Manifest,
    chunks: Vec<u64>,
}

/// Some columns of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Its chunk.
    pub chunk: u64,
    /// Its trials; row `i` is trial `trials.start + i`.
    pub trials: Range<u64>,
    /// The columns, in the order they were asked for.
    pub columns: Vec<Column>,
}

impl Dataset {
    /// Opens a folder: reads the manifest and lists the parts.
    ///
    /// # Errors
    /// When the folder cannot be read, has no manifest or one that is damaged or of another revision, or has a file among the
    /// parts that is none.
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

    /// The chunks that are there, ascending.
    #[must_use]
    pub fn chunks(&self) -> &[u64] {
        &self.chunks
    }

    /// The chunks that are not there, ascending.
    pub fn missing(&self) -> impl Iterator<Item = u64> {
        missing(self.manifest.plan.chunks(), &self.chunks)
    }

    /// Whether every part is there.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.chunks.len() as u64 == self.manifest.plan.chunks()
    }

    /// Number of trials that are there.
    #[must_use]
    pub fn trials(&self) -> u64 {
        let count = |&c: &u64| self.manifest.plan.trials_of(c);
        self.chunks.iter().map(count).map(|r| r.end - r.start).sum()
    }

    /// The rows of some columns, part by part.
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

    /// Reads every part that is there and checks its hash.
    ///
    /// # Errors
    /// The first part that is damaged or of other results.
    pub fn verify(&self) -> Result<(), DatasetError> {
        self.columns(&[])?.try_for_each(|part| part.map(drop))
    }

    pub(super) fn path(&self, chunk: u64) -> PathBuf {
        folder::part(&self.dir, chunk)
    }
}

/// The parts of a dataset, read one at a time. Each is checked against its hash.
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
