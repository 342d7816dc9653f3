//! The scores of a design under other conditions.

use smalti::experiment::{Estimate, RobustnessRow};

use super::proof::Proved;
use crate::comparison::verdict::{WORDS, amount};
use crate::page::{Markup, Table, paragraph};

const STATED: usize = super::proof_words::STATED;

/// The table; `None` without conditions.
pub(super) fn section(proved: &Proved<'_>) -> Option<Markup> {
    let proof = proved.proofs.first()?;
    let lights = &proof.luminances_cd_m2;
    proved.robustness.first()?;
    let (name, rival) = (&proof.found.label, proved.rival);
    let mut table = Table::new(format!("{name} and its lead over {rival}, with 95 % intervals"))
        .text("Condition")
        .number("Scenes");
    for (word, unit, _) in WORDS.iter().take(STATED) {
        for light in lights {
            let unit = unit.trim();
            let unit = if unit.is_empty() { String::new() } else { format!(", {unit}") };
            table = table.number(format!("{word} at {light} cd/m²{unit}"));
            table = table.number("lead");
        }
    }
    for row in proved.robustness {
        table = table.row(cells(row), false);
    }
    Some(Markup::from(table).and(paragraph(
        "help",
        format!(
            "A lead above 0 means that {name} is better than {rival}, the published mosaic with the best expected cost and filters of the same kind. \
             Scenes that can be relit are used in all rows but the last. Pipelines are learned for each illuminant and f-number. Filters that \
             deviate are rendered with the pipeline of the design. The intervals are those of single comparisons, not of all rows together.",
        ),
    )))
}

fn cells(row: &RobustnessRow) -> Vec<String> {
    let mut cells = vec![row.name.clone(), row.scenes.to_string()];
    for (metric, (_, _, digits)) in WORDS.iter().enumerate().take(STATED) {
        for (means, leads) in row.found.iter().zip(&row.leads) {
            cells.push(format!("{:.*}", digits, means[metric]));
            cells.push(lead(&leads[metric], *digits));
        }
    }
    cells
}

/// A lead with a mark where it is not shown, or a loss.
fn lead(lead: &Estimate, digits: usize) -> String {
    let mark = match lead.interval {
        Some(i) if i.contains(0.0) => " =",
        _ if lead.value < 0.0 => " ✗",
        _ => "",
    };
    amount(lead, "", digits) + mark
}

/// The table as lines of text, for a terminal.
pub(super) fn text(proved: &Proved<'_>, table: &crate::TextTable<'_>) -> String {
    let Some(proof) = proved.proofs.first().filter(|_| !proved.robustness.is_empty()) else {
        return String::new();
    };
    let mut header = vec!["condition".to_owned()];
    for (word, _, _) in WORDS.iter().take(STATED) {
        header.extend(proof.luminances_cd_m2.iter().map(|light| format!("{word} at {light}")));
    }
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let row = |row: &RobustnessRow| {
        let leads = |metric: usize| row.leads.iter().map(move |l| lead(&l[metric], WORDS[metric].2));
        std::iter::once(row.name.clone()).chain((0..STATED).flat_map(leads)).collect()
    };
    let rows: Vec<Vec<String>> = proved.robustness.iter().map(row).collect();
    format!("\nLeads over {} under other conditions:\n{}", proved.rival, table(&header, &rows))
}
