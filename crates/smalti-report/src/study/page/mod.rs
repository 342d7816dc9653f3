//! The page of a report: the designs to brush, filter and look at one by one.

mod again;
mod choice;
mod columns;
mod filters;
mod gallery;
mod marks;
mod optical_setups;
mod sources;
#[cfg(test)]
mod tests;
mod words;
use serde_json::{Value, json};

use super::figures;
use super::sections::Section;
use super::text::left_out;
use crate::ReportError;
use crate::page::{Markup, Page, SWEEP, el, figure, foot, packed, runs};
use crate::words::{grouped, plain, quoted};
use choice::Choice;
use optical_setups::OpticalSetups;
pub(super) use sources::Sources;

/// The page as HTML, and notes about what could not be shown.
pub(super) fn page(sources: &Sources<'_>) -> Result<(String, Vec<String>), ReportError> {
    let choice = Choice::of(sources)?;
    let optical_setups = OpticalSetups::new(sources)?;
    let gallery = gallery::gallery(sources, &choice, &optical_setups)?;
    let mut page = Page::new(title(sources)).with(SWEEP).lead(lead(sources, &choice));
    if optical_setups.draws() {
        page = page.simulator();
    }
    page = page
        .section("designs", "Trials", words::explorer())
        .section("means", "Means by number of colours", means(sources)?)
        .section("best", "Best designs", words::best(sources, &choice)?)
        .section("again", "Reproduction", again::section(sources))
        .data("sweep", data(sources, &choice, &optical_setups, gallery.data)?)
        .foot(foot());
    Ok((page.html(), [optical_setups.notes, gallery.notes].concat()))
}

fn title(sources: &Sources<'_>) -> String {
    let names: Vec<String> = sources.all.iter().map(|(r, _)| r.name()).collect();
    names.join(", ")
}

/// The aim of each study, how much of it is scored, and warnings.
fn lead(sources: &Sources<'_>, choice: &Choice) -> Markup {
    let mut out = Markup::new();
    for (results, _) in sources.all {
        let data = &results.data;
        let (there, all) = (data.numbers.len() as u64, data.trials.len());
        let name = if sources.all.len() > 1 { format!("{}: ", results.name()) } else { String::new() };
        if !results.about().is_empty() {
            out = out.and(el("p").class("about").child(format!("{name}{}", results.about())));
        }
        out = out.and(el("p").child(format!(
            "{name}{} trials, seed {}, scored by Smalti {}.",
            grouped(there),
            results.study().seed,
            plain(&data.smalti_version)
        )));
        let mut warnings = Vec::new();
        if there < all {
            warnings.push(format!(
                "{name}Incomplete: {} of {} trials are not scored yet.",
                grouped(all - there),
                grouped(all)
            ));
        }
        let (theirs, ours) = (&data.smalti_version, env!("CARGO_PKG_VERSION"));
        if theirs != ours {
            warnings.push(format!(
                "{name}Another version: the figures are those of Smalti {theirs}. Smalti {ours} computed the spectra, mosaics and pictures \
                 of this page."
            ));
        }
        if results.has_no_scores() {
            warnings.push(format!("{name}No trial has scores, so that the tables and figures are empty."));
        }
        for (problem, count) in results.problems.iter().take(5) {
            warnings.push(format!("{name}{}", left_out(problem, *count)));
        }
        out = out.and(warnings.into_iter().map(words::warning).collect::<Markup>());
    }
    if let Some(all) = choice.of {
        out = out.and(words::warning(format!(
            "This page shows {} of {} trials: the fronts, the best, the worst and a regular sample of the others. The tables cover all trials.",
            grouped(choice.rows.len() as u64),
            grouped(all as u64)
        )));
    }
    out
}

fn means(sources: &Sources<'_>) -> Result<Markup, ReportError> {
    let sections: Vec<&Section<'_>> = sources.sections().collect();
    let mut out = words::intervals(&sections);
    if let Some(plot) = figures::means(&sections) {
        out = out.and(figure(&plot.draw()?));
    }
    Ok(out)
}

fn data(
    sources: &Sources<'_>,
    choice: &Choice,
    optical_setups: &OpticalSetups,
    pictures: Value,
) -> Result<Value, ReportError> {
    let draws = optical_setups.draws();
    let studies: Vec<Value> = sources
        .all
        .iter()
        .map(|(results, _)| -> Result<Value, ReportError> {
            let study = if draws { serde_json::to_value(results.study())? } else { Value::Null };
            Ok(json!({
                "study": study,
                "name": results.name(),
                "seed": results.study().seed,
                "smalti": results.data.smalti_version,
                "dir": quoted(&results.data.origin),
            }))
        })
        .collect::<Result<_, ReportError>>()?;
    let all: Vec<&Section<'_>> = sources.sections().collect();
    let (optical_setups, drawn) = optical_setups.data(&all)?;
    let sections: Vec<Value> = sources
        .all
        .iter()
        .enumerate()
        .flat_map(|(study, (_, sections))| {
            sections.iter().map(move |s| {
                json!({
                    "study": study, "name": s.title(), "condition": s.name,
                    "nyquist_cy_per_mm": s.nyquist_cy_per_mm(),
                })
            })
        })
        .zip(drawn)
        .map(|(mut section, drawn)| {
            section["drawn"] = drawn;
            section
        })
        .collect();
    let numbers: Vec<u64> = choice.rows.iter().map(|r| r.number).collect();
    let section: Vec<f64> = choice.rows.iter().map(|r| r.section as f64).collect();
    let front: Vec<f64> = choice.rows.iter().map(|r| f64::from(u8::from(r.front))).collect();
    let columns = columns::columns(sources, choice);
    Ok(json!({
        "version": env!("CARGO_PKG_VERSION"),
        "rows": choice.rows.len(),
        "studies": studies,
        "sections": sections,
        "number": runs(&numbers),
        "section": packed(&section),
        "marks": marks::marks(sources, choice),
        "front": packed(&front),
        "colors": columns.colors,
        "columns": columns.numbers,
        "words": columns.words,
        "filters": filters::filters(sources, choice)?,
        "optical_setups": optical_setups,
        "pictures": pictures,
    }))
}
