//! What the array that was found depends on.

use super::document::{Document, Sensitivity, means};
use crate::page::{Markup, Table, el, paragraph};

/// The change of the expected figures with each deviation, averaged over the luminances.
pub(super) fn section(document: &Document) -> Markup {
    let analysis = &document.analysis;
    let [cpsnr_db, delta_e] = means(&analysis.expected);
    let change = |s: &Sensitivity| {
        let [db, de] = means(&s.expected);
        [db - cpsnr_db, de - delta_e]
    };
    let mut deviations: Vec<&str> = Vec::new();
    let mut filters: Vec<Option<&str>> = Vec::new();
    for s in &analysis.sensitivities {
        if !deviations.contains(&s.words.as_str()) {
            deviations.push(&s.words);
        }
        if !filters.contains(&s.filter.as_deref()) {
            filters.push(s.filter.as_deref());
        }
    }
    filters.sort_unstable_by_key(|filter| (filter.is_none(), *filter));
    let mut table = Table::new("Change of the expected figures when filters deviate").text("Filter");
    for unit in ["dB", "ΔE2000"] {
        for deviation in &deviations {
            table = table.number(format!("{deviation}: {unit}"));
        }
    }
    for filter in &filters {
        let of = |metric: usize| {
            deviations.iter().map(move |deviation| {
                let found = analysis
                    .sensitivities
                    .iter()
                    .find(|s| s.filter.as_deref() == *filter && s.words == **deviation);
                found.map_or_else(String::new, |s| signed(change(s)[metric]))
            })
        };
        let name = filter.map_or_else(|| "all alike".to_owned(), str::to_owned);
        table = table.row(std::iter::once(name).chain(of(0)).chain(of(1)), filter.is_none());
    }
    let single = analysis.sensitivities.iter().filter(|s| s.filter.is_some());
    let worst = single.min_by(|a, b| change(a)[0].total_cmp(&change(b)[0]));
    let headline = worst.map(|s| {
        let [db, _] = change(s);
        let filter = s.filter.as_deref().unwrap_or_default();
        let text = match db < -0.005 {
            true => format!(
                "The most costly deviation of one filter is {} of {filter}: it costs {:.2} dB.",
                s.words, -db
            ),
            false => "No deviation of one filter by this much costs 0.01 dB.".to_owned(),
        };
        el("p").class("headline").child(text)
    });
    Markup::new().and(headline.map(Markup::from).unwrap_or_default()).and(table).and(paragraph(
        "help",
        "Expected figures of the closed form, means over the luminances, with the best linear pipeline for the filters as they are. In CPSNR a \
             change below 0 is a loss, in ΔE2000 a change above 0. A thickness changes the absorbance of the whole filter in proportion. A pipeline that was \
             learned for the design loses more on filters that deviate: the table of robustness measures that.",
    ))
}

fn signed(change: f64) -> String {
    let text = format!("{change:+.3}").replace('-', "−");
    if text.trim_start_matches(['+', '−']).chars().all(|c| "0.".contains(c)) {
        "0.000".into()
    } else {
        text
    }
}
