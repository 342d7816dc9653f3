//! Marks for the designs of a small study beside a cloud of many designs, among which their dots would be lost.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::choice::Choice;
use super::sources::Sources;
use crate::page::packed;
use crate::study::results::Results;
use crate::study::sections::Section;

/// The number of symbols. Where there are more kinds of filters, each study has one symbol.
const SYMBOLS: usize = 5;

/// Groups of marked designs, each with its symbol: `{"study", "name", "rows"}`. A group has the name of its filters, as in the figure
/// `filters-by-rule`, as far as there are symbols.
pub(super) fn marks(sources: &Sources<'_>, choice: &Choice) -> Vec<Value> {
    let marked: Vec<(usize, &Results, &[Section<'_>])> = sources
        .all
        .iter()
        .enumerate()
        .filter(|(_, (results, _))| sources.is_marked(results))
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
