//! Few designs beside a cloud of many: they are marked, since they would be lost among its dots.

use std::collections::BTreeSet;

use serde_json::{Value, json};
use smalti_report::page::packed;

use super::Sources;
use super::choice::Choice;
use crate::study_report::answers::Section;
use crate::study_report::figures::MAX_MARKS;
use crate::study_report::results::Results;

/// Times as many designs that a cloud must have.
const CLOUD: usize = 8;
/// Symbols there are: of more kinds of filters each study has one symbol.
const SYMBOLS: usize = 5;

/// Whether the designs of a study are marked on a page of all.
pub(super) fn is_marked(results: &Results, sources: &Sources<'_>) -> bool {
    let designs = results.number.len();
    let cloud = sources.all.iter().map(|(r, _)| r.number.len()).max().unwrap_or(0);
    designs <= MAX_MARKS && cloud >= CLOUD * designs.max(1)
}

/// Groups of marked designs, each with a symbol of its own: `{"study", "name", "rows"}`. They are named by what their filters are called,
/// as in the figure `filters-by-rule`, as far as there are symbols.
pub(super) fn marks(sources: &Sources<'_>, choice: &Choice) -> Vec<Value> {
    let marked: Vec<(usize, &Results, &[Section<'_>])> = sources
        .all
        .iter()
        .enumerate()
        .filter(|(_, (results, _))| is_marked(results, sources))
        .map(|(study, (results, sections))| (study, *results, sections.as_slice()))
        .collect();
    let names = |sections: &[Section<'_>]| -> BTreeSet<String> {
        let named: BTreeSet<String> = sections.iter().flat_map(|s| s.labels.keys().cloned()).collect();
        if named.is_empty() { [String::new()].into() } else { named }
    };
    let by_name = marked.iter().map(|(.., sections)| names(sections).len()).sum::<usize>() <= SYMBOLS;
    let mut out = Vec::new();
    for (study, results, sections) in marked {
        for name in if by_name { names(sections) } else { [String::new()].into() } {
            let rows = sections.iter().flat_map(|s| match s.labels.get(&name) {
                Some(groups) => groups.values().flatten().copied().collect(),
                None if name.is_empty() => s.rows.clone().collect(),
                None => Vec::new(),
            });
            let places: Vec<f64> =
                rows.filter_map(|row| choice.place(study, row)).map(|place| place as f64).collect();
            out.push(json!({"study": results.name(), "name": name, "rows": packed(&places)}));
        }
    }
    out
}
