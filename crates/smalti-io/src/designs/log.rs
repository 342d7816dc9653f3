//! The log of a search: what its parts have found so far, a line for each.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};
use smalti::design::light::LightStatistics;
use smalti::experiment::{DesignStore, DesignTask, KeptFind};

use crate::{IoError, text, write};

/// The name of the log in the folder of a design.
pub const SEARCH_LOG: &str = "search.jsonl";
const FORMAT: &str = "smalti-design-search 1";

/// The first line.
#[derive(Serialize, Deserialize)]
struct Header {
    format: String,
    /// The hash of all that the search depends on.
    task: String,
}

/// Every other line.
#[derive(Serialize, Deserialize)]
pub(super) struct Entry {
    pub(super) part: String,
    pub(super) found: Vec<KeptFind>,
}

/// All that a search depends on, as text for [`SearchLog::open`].
#[must_use]
pub fn task_text(task: &DesignTask, statistics: &[LightStatistics]) -> String {
    let light: Vec<_> = statistics.iter().map(|s| (s.source(), s.patches(), s.parts().energy)).collect();
    format!("{} {task:?} {light:?}", env!("CARGO_PKG_VERSION"))
}

/// The hash of a [`task_text`]: equal hashes mean that parts of one search fit the other.
#[must_use]
pub fn task_hash(task: &str) -> String {
    blake3::hash(task.as_bytes()).to_hex().to_string()
}

/// The log of the search for one task.
#[derive(Debug)]
pub struct SearchLog {
    known: HashMap<String, Vec<KeptFind>>,
    file: Mutex<File>,
}

impl SearchLog {
    /// Opens the log in a folder, which is made when it is absent. `task` is the [`task_text`]. What a log of another task
    /// holds, and a last line that is not whole, are not used.
    ///
    /// # Errors
    /// [`IoError::Write`].
    pub fn open(dir: &Path, task: &str) -> Result<Self, IoError> {
        let path = dir.join(SEARCH_LOG);
        let task = task_hash(task);
        let known = text::read_to_string(&path).map(|text| read(&text, &task)).unwrap_or_default();
        write::begin_folder(dir, &[])?;
        let header = Header { format: FORMAT.into(), task };
        let mut lines = line(&header);
        let mut parts: Vec<_> = known.iter().collect();
        parts.sort_by_key(|(part, _)| *part);
        for (part, found) in parts {
            lines += &line(&Entry { part: part.clone(), found: found.clone() });
        }
        write::bytes(&path, lines.as_bytes())?;
        let file = OpenOptions::new().append(true).open(&path).map_err(IoError::writing(&path))?;
        Ok(Self { known, file: Mutex::new(file) })
    }

    /// What an earlier run has found, by part.
    #[must_use]
    pub fn found(&self) -> &HashMap<String, Vec<KeptFind>> {
        &self.known
    }

    /// Number of parts that an earlier run has searched.
    #[must_use]
    pub fn known(&self) -> usize {
        self.known.len()
    }
}

pub(super) fn line(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default() + "\n"
}

fn read(text: &str, task: &str) -> HashMap<String, Vec<KeptFind>> {
    let mut lines = text.lines();
    let header = lines.next().and_then(|l| serde_json::from_str::<Header>(l).ok());
    if !header.is_some_and(|h| h.format == FORMAT && h.task == task) {
        return HashMap::new();
    }
    lines.map_while(|l| serde_json::from_str::<Entry>(l).ok()).map(|e| (e.part, e.found)).collect()
}

impl DesignStore for SearchLog {
    fn find(&self, part: &str) -> Option<Vec<KeptFind>> {
        self.known.get(part).cloned()
    }

    fn keep(&self, part: &str, found: &[KeptFind]) {
        let entry = line(&Entry { part: part.to_owned(), found: found.to_vec() });
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        // A line that cannot be written costs a search of this part at the next run.
        let _ = file.write_all(entry.as_bytes()).and_then(|()| file.flush());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_keeps_what_was_found_for_the_same_task_alone() {
        let dir = tempfile::tempdir().unwrap();
        let found = vec![KeptFind {
            cells: vec![0, 1],
            parameters: vec![vec![0.1 + 0.2, -1e-300], Vec::new()],
            cost: 1.0 / 3.0,
            start: 4,
        }];
        let log = SearchLog::open(dir.path(), "a").unwrap();
        assert_eq!((log.known(), log.find("1")), (0, None));
        log.keep("1", &found);
        log.keep("2", &[]);
        drop(log);
        // The last line was cut short by a crash.
        let path = dir.path().join(SEARCH_LOG);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text + "{\"part\":\"3\",\"fou").unwrap();
        let log = SearchLog::open(dir.path(), "a").unwrap();
        assert_eq!((log.known(), log.find("1"), log.find("3")), (2, Some(found), None));
        log.keep("3", &[]);
        drop(log);
        assert_eq!(SearchLog::open(dir.path(), "a").unwrap().known(), 3);
        assert_eq!(SearchLog::open(dir.path(), "b").unwrap().known(), 0);
    }
}
