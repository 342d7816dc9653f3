//! Results in a location that only the caller can access, such as an object store. The caller lists, reads and writes the files.

use std::path::{Path, PathBuf};

use super::error::DatasetError;
use super::folder;
use super::manifest::{Manifest, Plan, RunRecord};

/// Results in a location that the caller fills. There is no lock, but concurrent runs of one plan write identical parts.
#[derive(Debug, Clone)]
pub struct RemoteDataset {
    place: PathBuf,
    manifest: Manifest,
}

impl RemoteDataset {
    /// Prepares a location for the results of a plan. It is empty or holds results of the same plan. `place` is used in error messages,
    /// `names` are the names of the files there, and `manifest` is the content of `manifest.json`, if it exists.
    ///
    /// # Errors
    /// When the plan or the manifest is invalid, or the location holds other files or the results of another plan.
    pub fn open(
        place: &Path,
        plan: &Plan,
        names: &[String],
        manifest: Option<&[u8]>,
    ) -> Result<Self, DatasetError> {
        let now = Manifest::new(plan)?;
        match manifest {
            None => folder::check_names(place, names.iter().cloned())?,
            Some(bytes) => {
                Manifest::from_bytes(bytes, &place.join(super::manifest::FILE))?.check_same(&now, place)?
            }
        }
        Ok(Self { place: place.to_owned(), manifest: now })
    }

    /// The manifest, without runs.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The missing chunks, ascending. `names` are the names of the files among the parts.
    ///
    /// # Errors
    /// [`DatasetError::Stray`].
    pub fn missing(&self, names: &[String]) -> Result<Vec<u64>, DatasetError> {
        let chunks = self.manifest.plan.chunks();
        let mut there = Vec::new();
        for name in names {
            match folder::chunk_of(name).filter(|c| *c < chunks) {
                Some(chunk) => there.push(chunk),
                None if name.starts_with(['.', '_']) => {}
                None => return Err(DatasetError::Stray { path: folder::parts_dir(&self.place).join(name) }),
            }
        }
        there.sort_unstable();
        there.dedup();
        Ok(folder::missing(chunks, &there).collect())
    }

    /// Decodes the stored manifest and adds a run.
    ///
    /// # Errors
    /// When the manifest is invalid or belongs to another plan.
    pub fn with_run(&self, manifest: &[u8], record: RunRecord) -> Result<Manifest, DatasetError> {
        let mut there = Manifest::from_bytes(manifest, &self.place.join(super::manifest::FILE))?;
        there.check_same(&self.manifest, &self.place)?;
        there.runs.push(record);
        Ok(there)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::super::{ColumnKind, ColumnSpec, part_name};
    use super::*;

    fn plan(trials: u64) -> Plan {
        let column =
            ColumnSpec { name: "n".into(), kind: ColumnKind::Int, unit: String::new(), doc: String::new() };
        Plan { study: json!({"seed": 1}), schema: vec![column], trials, chunk: 2 }
    }

    fn names(of: &[&str]) -> Vec<String> {
        of.iter().map(|n| (*n).to_owned()).collect()
    }

    #[test]
    fn a_place_is_continued_by_its_own_plan_alone() {
        let place = Path::new("memory://out");
        let new = RemoteDataset::open(place, &plan(9), &[], None).unwrap();
        let record = RunRecord { shard: None, parts: 5, timings: json!({}) };
        let text = new.manifest().to_json().unwrap();
        let later = new.with_run(text.as_bytes(), record.clone()).unwrap();
        assert_eq!(later.runs, [record]);
        let text = later.to_json().unwrap();
        let again =
            RemoteDataset::open(place, &plan(9), &names(&["manifest.json", "trials"]), Some(text.as_bytes()));
        assert!(again.unwrap().manifest().runs.is_empty());
        let other = RemoteDataset::open(place, &plan(8), &[], Some(text.as_bytes())).unwrap_err();
        assert!(matches!(other, DatasetError::OtherStudy { .. }), "{other}");
        let foreign = RemoteDataset::open(place, &plan(9), &names(&["mine.txt"]), None).unwrap_err();
        assert!(matches!(foreign, DatasetError::NotResults { .. }), "{foreign}");
        assert!(RemoteDataset::open(place, &plan(9), &[], Some(b"{}")).is_err());
    }

    #[test]
    fn missing_parts_follow_from_names() {
        let place = RemoteDataset::open(Path::new("x"), &plan(9), &[], None).unwrap();
        let there = names(&["part-000003.parquet", ".part-000001.parquet.7-0.tmp", "part-000000.parquet"]);
        assert_eq!(place.missing(&there).unwrap(), [1, 2, 4]);
        for stray in ["part-000005.parquet", "mine.txt", "part-1.parquet"] {
            assert!(matches!(place.missing(&names(&[stray])), Err(DatasetError::Stray { .. })), "{stray}");
        }
        assert_eq!(part_name(12), "trials/part-000012.parquet");
    }
}
