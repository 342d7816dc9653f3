//! A search that several processes share: each searches some of its parts, and a coordinator sends what was found around.

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use smalti::experiment::{DesignStore, KeptFind};

use super::log::{Entry, line};
use crate::IoError;

/// The store of one of several processes that share a search. Parts travel as text, a line of JSON for each, as in the
/// [log](super::SearchLog) of a search.
#[derive(Debug, Default)]
pub struct SharedSearch {
    known: Mutex<HashMap<String, Vec<KeptFind>>>,
    /// The parts that this process searches.
    own: Vec<String>,
    open: Mutex<Vec<String>>,
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl SharedSearch {
    /// The store of a process that searches its `own` parts and leaves all others. `known` is what was found before.
    #[must_use]
    pub fn new(known: HashMap<String, Vec<KeptFind>>, own: Vec<String>) -> Self {
        Self { known: Mutex::new(known), own, open: Mutex::default() }
    }

    /// Adds what another process found, in the form of [`SharedSearch::line`]. Returns the part and what it found.
    ///
    /// # Errors
    /// When the text is no such line.
    pub fn add(&self, text: &str) -> Result<(String, Vec<KeptFind>), IoError> {
        let place = Path::new("a part of a search");
        let entry: Entry =
            serde_json::from_str(text.trim_end()).map_err(|e| IoError::decode(place, "search log", e))?;
        locked(&self.known).insert(entry.part.clone(), entry.found.clone());
        Ok((entry.part, entry.found))
    }

    /// All that is known, by part.
    #[must_use]
    pub fn found(&self) -> HashMap<String, Vec<KeptFind>> {
        locked(&self.known).clone()
    }

    /// All that is known, as lines of JSON.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let known = locked(&self.known);
        let mut parts: Vec<_> = known.iter().collect();
        parts.sort_by_key(|(part, _)| *part);
        parts
            .into_iter()
            .map(|(part, found)| line(&Entry { part: part.clone(), found: found.clone() }))
            .collect()
    }

    /// What a part found, as a line of JSON; `None` while it is not known.
    #[must_use]
    pub fn line(&self, part: &str) -> Option<String> {
        let found = self.find(part)?;
        Some(line(&Entry { part: part.to_owned(), found }))
    }

    /// Forgets which parts were left to others, and returns them in the order in which the search asked for them.
    #[must_use]
    pub fn take_open(&self) -> Vec<String> {
        std::mem::take(&mut *locked(&self.open))
    }
}

impl DesignStore for SharedSearch {
    fn find(&self, part: &str) -> Option<Vec<KeptFind>> {
        locked(&self.known).get(part).cloned()
    }

    fn keep(&self, part: &str, found: &[KeptFind]) {
        locked(&self.known).insert(part.to_owned(), found.to_vec());
    }

    fn takes(&self, part: &str) -> bool {
        let is_own = self.own.iter().any(|own| own == part);
        if !is_own {
            locked(&self.open).push(part.to_owned());
        }
        is_own
    }
}
