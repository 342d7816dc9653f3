//! The content of a page without scripts: tables, and the places where scripts draw.

use smalti::design::statistics::Estimate;

use super::choice::Choice;
use super::sources::Sources;
use crate::ReportError;
use crate::page::{Markup, Table, el};
use crate::study::sections::{Group, Section};
use crate::study::text::{figures, interval, is_spread, spread};

/// Sections with tables. report.json has all.
const SECTIONS: usize = 20;

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
    let mut out: Markup = el("p")
        .child(
            "Each mean is followed by its confidence interval of 95 %. The column after it gives the interval of 90 % of the designs.",
        )
        .into();
    for section in sections.iter().take(SECTIONS) {
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
        out = out.and(table).and(exposure.into_iter().collect::<Markup>());
    }
    if sections.len() > SECTIONS {
        out = out.and(el("p").child(format!(
            "The tables of {} more conditions are in report.json.",
            sections.len() - SECTIONS
        )));
    }
    out
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
            out = out
                .and(el("p").child(format!("Best: {}.", section.choice.words())))
                .and(table(study, section, choice)?);
        }
    }
    Ok(out)
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
