//! `report.html`: the designs of a report to brush, filter and look at one by one.

mod again;
mod choice;
mod columns;
mod gallery;
mod marks;
mod stages;
mod words;

use std::path::PathBuf;

use serde_json::{Value, json};
use smalti_report::page::{Markup, Page, SWEEP, el, figure, packed, runs};

use super::answers::Section;
use super::results::Results;
use super::{figures, results};
use crate::Watch;
pub(crate) use again::quoted;
use choice::Choice;
use stages::Stages;
pub(crate) use words::grouped;

/// What a page is made of.
pub(super) struct Sources<'a> {
    pub(super) all: &'a [(&'a Results, Vec<Section<'a>>)],
    /// The folders as they were named.
    pub(super) dirs: &'a [PathBuf],
    /// How many designs have pictures by processing that the page has not, and which have the simulator's in any case.
    pub(super) pictures: usize,
    pub(super) wanted: &'a [u64],
    pub(super) watch: &'a Watch<'a>,
}

/// The page, and what could not be shown.
pub(super) fn page(sources: &Sources<'_>) -> anyhow::Result<(String, Vec<String>)> {
    let choice = Choice::of(sources)?;
    let stages = Stages::new(sources)?;
    let gallery = gallery::gallery(sources, &choice, &stages)?;
    let mut page = Page::new(title(sources)).with(SWEEP).lead(lead(sources, &choice));
    page = page
        .section("designs", "Designs", words::explorer())
        .section("means", "Means by number of colours", means(sources)?)
        .section("best", "Best designs", words::best(sources, &choice)?)
        .section("again", "The same again", again::section(sources)?)
        .data("sweep", data(sources, &choice, &stages, gallery.data)?)
        .foot(el("p").child(format!(
            "Made by Smalti {}. This page needs no network and sends nothing.",
            env!("CARGO_PKG_VERSION")
        )));
    Ok((page.html(), [stages.notes, gallery.notes].concat()))
}

fn title(sources: &Sources<'_>) -> String {
    let names: Vec<String> = sources.all.iter().map(|(r, _)| r.name()).collect();
    names.join(", ")
}

/// What was asked, how much of it is here, and what is amiss.
fn lead(sources: &Sources<'_>, choice: &Choice) -> Markup {
    let mut out = Markup::new();
    for (results, _) in sources.all {
        let plan = &results.dataset.manifest().plan;
        let (there, all) = (results.dataset.designs(), plan.designs);
        let name = if sources.all.len() > 1 { format!("{}: ", results.name()) } else { String::new() };
        if !results.about().is_empty() {
            out = out.and(el("p").class("about").child(format!("{name}{}", results.about())));
        }
        out = out.and(el("p").child(format!(
            "{name}{} designs, seed {}, scored by Smalti {}.",
            words::grouped(there),
            results.study().seed,
            results::plain(&results.dataset.manifest().smalti)
        )));
        let mut warnings = Vec::new();
        if there < all {
            warnings.push(format!(
                "{name}Incomplete: {} of {} designs are not scored yet.",
                words::grouped(all - there),
                words::grouped(all)
            ));
        }
        let (theirs, ours) = (&results.dataset.manifest().smalti, env!("CARGO_PKG_VERSION"));
        if theirs != ours {
            warnings.push(format!(
                "{name}Another version: the figures are those of Smalti {theirs}; spectra, mosaics and pictures on this page are by \
                 Smalti {ours}."
            ));
        }
        for (problem, count) in results.problems.iter().take(5) {
            warnings.push(format!("{name}Left out: {count} × {problem}"));
        }
        out = out.and(warnings.into_iter().map(words::warning).collect::<Markup>());
    }
    if let Some(all) = choice.of {
        out = out.and(words::warning(format!(
            "This page holds {} of {} designs: the fronts, the best, the worst, and others evenly spread. Tables are of all.",
            words::grouped(choice.rows.len() as u64),
            words::grouped(all as u64)
        )));
    }
    out
}

fn means(sources: &Sources<'_>) -> anyhow::Result<Markup> {
    let sections: Vec<&Section<'_>> = sources.all.iter().flat_map(|(_, s)| s).collect();
    let mut out = words::intervals(&sections);
    if let Some(plot) = figures::means(&sections) {
        out = out.and(figure(&plot.draw()?));
    }
    Ok(out)
}

fn data(sources: &Sources<'_>, choice: &Choice, stages: &Stages, pictures: Value) -> anyhow::Result<Value> {
    let studies: Vec<Value> = sources
        .all
        .iter()
        .zip(sources.dirs)
        .map(|((results, _), dir)| {
            json!({
                "name": results.name(),
                "seed": results.study().seed,
                "smalti": results.dataset.manifest().smalti,
                "dir": again::quoted(&dir.to_string_lossy()),
            })
        })
        .collect();
    let (stages, drawn, matrices) = stages.data(sources, choice)?;
    let sections: Vec<Value> = sources
        .all
        .iter()
        .enumerate()
        .flat_map(|(study, (_, sections))| {
            sections.iter().map(move |s| {
                json!({"study": study, "name": s.title(), "nyquist_cy_per_mm": s.nyquist_cy_per_mm()})
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
    let columns = columns::columns(sources, choice)?;
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
        "filters": columns.filters,
        "stages": stages,
        "matrices": matrices,
        "pictures": pictures,
    }))
}
