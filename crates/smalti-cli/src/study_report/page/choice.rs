//! Which designs a page holds.

use std::collections::BTreeSet;

use anyhow::ensure;

use super::{Sources, marks};

/// Most designs of a page: more would be slow to load and are not told apart.
pub(super) const MOST: usize = 100_000;

/// A design of the page.
pub(super) struct Row {
    /// Index of the study, and row of its results.
    pub(super) study: usize,
    pub(super) row: usize,
    /// Number of the design in its study.
    pub(super) number: u64,
    /// Index of the section among all.
    pub(super) section: usize,
    /// Whether none beats it in ΔE, MTF50 and noise at once.
    pub(super) front: bool,
}

/// The designs of a page.
pub(super) struct Choice {
    pub(super) rows: Vec<Row>,
    /// Of how many, where these are not all.
    pub(super) of: Option<usize>,
}

impl Choice {
    pub(super) fn of(sources: &Sources<'_>) -> anyhow::Result<Self> {
        Self::among(sources, MOST)
    }

    fn among(sources: &Sources<'_>, most: usize) -> anyhow::Result<Self> {
        if let Some((results, _)) = sources.all.first() {
            for number in sources.wanted {
                ensure!(
                    results.number.binary_search(number).is_ok(),
                    "--picture {number}: {} holds no such design",
                    results.name()
                );
            }
        }
        let all: usize = sources.all.iter().map(|(r, _)| r.number.len()).sum();
        let step = all.div_ceil(most).max(1);
        let mut rows = Vec::new();
        let mut index = 0;
        for (study, (results, sections)) in sources.all.iter().enumerate() {
            let step = if marks::is_marked(results, sources) { 1 } else { step };
            for section in sections {
                let front: BTreeSet<usize> = section.front.iter().copied().collect();
                let named: BTreeSet<usize> = section
                    .groups
                    .iter()
                    .flat_map(|g| g.best.iter().copied().chain(g.worst))
                    .chain(front.iter().copied().take(most / 10))
                    .collect();
                let wanted = |n: &u64| study == 0 && sources.wanted.contains(n);
                for row in section.rows.clone() {
                    let Some(number) = results.number.get(row) else { continue };
                    if row % step == 0 || named.contains(&row) || wanted(number) {
                        let front = front.contains(&row);
                        rows.push(Row { study, row, number: *number, section: index, front });
                    }
                }
                index += 1;
            }
        }
        Ok(Self { of: (rows.len() < all).then_some(all), rows })
    }

    /// Place in the page of a row of the results of a study.
    pub(super) fn place(&self, study: usize, row: usize) -> Option<usize> {
        self.rows.binary_search_by_key(&(study, row), |r| (r.study, r.row)).ok()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::Watch;
    use crate::study_report::answers::Section;
    use crate::study_report::results::Results;

    fn scored(dir: &Path, name: &str, filters: &str) -> Results {
        let (study, out) = (dir.join(format!("{name}.toml")), dir.join(name));
        let text = format!(
            "name = \"{name}\"\ncamera = \"table1\"\ncolors = [3]\nmosaics = {{ given = [[\"bc\", \"ab\"]] }}\n{filters}"
        );
        std::fs::write(&study, text).unwrap();
        let words = ["smalti", "sweep", study.to_str().unwrap(), "-o", out.to_str().unwrap()];
        let words = words.iter().chain(&["--no-cache", "--quiet"]).map(Into::into);
        assert_eq!(crate::command(words), 0);
        Results::read(&out).unwrap()
    }

    #[test]
    fn of_more_designs_than_a_page_holds_all_marked_ones_are_there() {
        let dir = tempfile::tempdir().unwrap();
        let cloud = scored(
            dir.path(),
            "cloud",
            "[sample]\nfilters = 90\n[filters.gaussian_grid]\ncenters_nm = [430, 10, 660]\nsigmas_nm = [20, 5, 55]\n",
        );
        let few = scored(
            dir.path(),
            "few",
            "[filters.rule]\nrules = [\"uniform\", \"height-scaled\"]\ntargets = [\"cones\"]\n",
        );
        let all = [(&cloud, Section::all(&cloud).unwrap()), (&few, Section::all(&few).unwrap())];
        let sources = Sources { all: &all, dirs: &[], pictures: 0, wanted: &[], watch: &Watch::NOBODY };
        assert_eq!(Choice::of(&sources).unwrap().of, None);
        let choice = Choice::among(&sources, 20).unwrap();
        let designs = few.number.len();
        assert_eq!(choice.of, Some(90 + designs));
        let of = |study| choice.rows.iter().filter(|r| r.study == study).count();
        assert!((18..45).contains(&of(0)), "{}", of(0));
        assert_eq!(of(1), designs);
        let marked = marks::marks(&sources, &choice);
        let rows: u64 = marked.iter().filter_map(|m| m.pointer("/rows/n")?.as_u64()).sum();
        assert_eq!((designs > 1, rows), (true, designs as u64));
    }
}
