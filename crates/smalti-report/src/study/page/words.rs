//! The content of a page without scripts: tables, and the places where scripts draw.

use smalti::design::statistics::Estimate;

use super::choice::Choice;
use super::sources::Sources;
use crate::ReportError;
use crate::page::{Markup, Table, el};
use crate::study::sections::{Group, Section};
use crate::study::text::{condition_row, figures, interval, is_spread, spread};

/// Conditions with tables. report.json has all.
const SECTIONS: usize = 20;
/// Conditions whose tables are open at first.
const OPEN: usize = 3;

pub(super) fn warning(text: String) -> Markup {
    el("p").class("warning").attr("role", "note").child(text).into()
}

/// The place of the trials, which a script draws.
pub(super) fn explorer() -> Markup {
    let without = el("p").class("warning").child(
        "A script draws the trials, and this reader does not run scripts. The tables and figures below need none. report.json and the \
         Parquet files of the results hold every number.",
    );
    el("div").id("explorer").child(without).into()
}

fn estimate(e: &Estimate, digits: usize) -> Markup {
    if !e.value.is_finite() {
        return "–".into();
    }
    let value = Markup::from(format!("{:.digits$}", e.value));
    if !(e.low.is_finite() && e.high.is_finite()) {
        return value;
    }
    value.and(el("span").class("interval").child(format!(" {}", interval(e.low, e.high, digits))))
}

/// The paper's table 2, with intervals, for each section.
pub(super) fn intervals(sections: &[&Section<'_>]) -> Markup {
    let mut out = conditions(sections).and(el("p").child(
        "In the tables by number of colours, each mean is followed by its confidence interval of 95 %. The column after it gives the interval \
         of 90 % of the designs.",
    ));
    for (place, section) in sections.iter().take(SECTIONS).enumerate() {
        let measures = &section.results.measures;
        let mut table = Table::new(format!("Means, {}", section.title()))
            .number("Colours")
            .number("Designs")
            .number("Left out");
        for measure in measures {
            table = table.number(format!("{}, mean", measure.header));
            if is_spread(&measure.name) {
                table = table.number("90 %");
            }
        }
        for g in &section.groups {
            let (designs, left_out) = g.counts();
            let mut cells: Vec<Markup> =
                vec![g.colors.to_string().into(), designs.to_string().into(), left_out.to_string().into()];
            for (measure, summary) in measures.iter().zip(&g.summaries) {
                cells.push(estimate(&summary.mean, measure.digits));
                cells.extend(is_spread(&measure.name).then(|| spread(summary, measure.digits).into()));
            }
            table = table.row(cells, false);
        }
        let exposure = section.exposure_in_words().map(|words| el("p").child(words));
        let tables = Markup::from(table).and(exposure.into_iter().collect::<Markup>());
        out = out.and(folded(place, section, tables));
    }
    out.and(others(sections.len()))
}

/// A row for each condition: the means over all designs. Empty where there is one condition, and where studies score other metrics.
fn conditions(sections: &[&Section<'_>]) -> Markup {
    let [first, rest @ ..] = sections else { return Markup::new() };
    let headers = |s: &Section<'_>| s.results.measures.iter().map(|m| m.header.clone()).collect::<Vec<_>>();
    let heads = headers(first);
    if rest.is_empty() || rest.iter().any(|s| headers(s) != heads) {
        return Markup::new();
    }
    let several = rest.iter().any(|s| !std::ptr::eq(s.results, first.results));
    let (caption, head) = match (several, sections.iter().any(|s| !s.name.is_empty())) {
        (true, false) => ("Means of all designs of each study", "Study"),
        (true, true) => ("Means of all designs under each condition", "Study and condition"),
        (false, _) => ("Means of all designs under each condition", "Condition"),
    };
    let table = Table::new(caption).text(head).number("Designs");
    let table = heads.iter().fold(table, |table, head| table.number(head));
    let table = sections.iter().fold(table, |table, section| {
        let mut cells = condition_row(section);
        if let (true, Some(name)) = (several, cells.first_mut()) {
            *name = section.title();
        }
        table.row(cells, false)
    });
    table.into()
}

/// The tables of a condition, which are closed for all but the first conditions.
fn folded(place: usize, section: &Section<'_>, tables: Markup) -> Markup {
    if place < OPEN {
        return tables;
    }
    el("details").class("condition").child(el("summary").child(section.title())).child(tables).into()
}

/// Where the tables of further conditions are.
fn others(sections: usize) -> Markup {
    match sections.saturating_sub(SECTIONS) {
        0 => Markup::new(),
        more => el("p").child(format!("The tables of {more} more conditions are in report.json.")).into(),
    }
}

/// The best designs of each number of colours.
pub(super) fn best(sources: &Sources<'_>, choice: &Choice) -> Result<Markup, ReportError> {
    let mut out = Markup::new();
    let mut shown = 0;
    for (study, (_, sections)) in sources.all.iter().enumerate() {
        for section in sections {
            shown += 1;
            if shown > SECTIONS {
                continue;
            }
            let rule = Markup::from(el("p").child(format!("Best: {}.", section.choice.words())));
            let tables = rule.and(table(study, section, choice)?);
            out = out.and(folded(shown - 1, section, tables));
        }
    }
    Ok(out.and(others(shown)))
}

fn table(study: usize, section: &Section<'_>, choice: &Choice) -> Result<Markup, ReportError> {
    let mut table =
        Table::new(format!("Best designs, {}", section.title())).number("Trial").number("Colours");
    for measure in &section.results.measures {
        table = table.number(&measure.header);
    }
    table = table.text("Mosaic").text("Filters: centre/FWHM, nm");
    let rows = section.groups.iter().flat_map(|g: &Group| g.best.iter().enumerate());
    for (rank, &row) in rows {
        let trial = section.results.trial(row)?;
        let number: Markup = match choice.place(study, row) {
            Some(place) => el("button")
                .class("design")
                .attr("type", "button")
                .attr("data-row", place.to_string())
                .child(trial.number.to_string())
                .into(),
            None => trial.number.to_string().into(),
        };
        let mut cells: Vec<Markup> = vec![number, trial.design.filters.filters.len().to_string().into()];
        cells.extend(section.results.measures.iter().map(|m| Markup::from(m.text(row))));
        cells.extend([
            el("code").child(section.results.mosaic(&trial.design)).into(),
            figures(&trial.design)?.join("  ").into(),
        ]);
        table = table.row(cells, rank == 0);
    }
    Ok(table.into())
}
