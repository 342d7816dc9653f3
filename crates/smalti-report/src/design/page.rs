//! The page of a design.

use super::document::Document;
use super::proof::{self, Proved};
use super::proof_words::headline;
use super::{arrays, limits, robustness, search, sensitivity};
use crate::ReportError;
use crate::page::{DESIGN, Markup, Page, copyable, el, foot, paragraph};
use crate::words::quoted;

/// The page of the results of a search as HTML, with its proof if there is one. `folder` is that of the results, for commands.
///
/// # Errors
/// Never for results as the command writes them.
pub fn page(document: &Document, proved: Option<&Proved<'_>>, folder: &str) -> Result<String, ReportError> {
    let mut page = Page::new(format!("{}: the best colour filter array", document.name))
        .with(DESIGN)
        .lead(lead(document))
        .section("result", "Result", result(document, proved, folder))
        .section("arrays", "Arrays", arrays::section(document));
    if let Some(proved) = proved {
        let link = el("p").child("All pictures, scores, noise and kernels: ").child(
            el("a")
                .attr("href", proved.comparison)
                .child("the comparison with the best rival and the camera’s own array"),
        );
        page = page.section("proof", "Proof", proof::section(proved)).section(
            "pictures",
            "Pictures",
            Markup::from(link).and(proved.crops.clone()),
        );
        if let Some(table) = robustness::section(proved) {
            page = page.section("robustness", "Robustness", table);
        }
    }
    page = page.section("limits", "What limits it", limits::section(document)).section(
        "sensitivity",
        "Sensitivity",
        sensitivity::section(document),
    );
    if let Some(front) = search::front(&document.front) {
        page = page.section("front", "Trade-offs", front);
    }
    Ok(page.section("search", "Search", search::section(document)).foot(foot()).html())
}

fn lead(document: &Document) -> Markup {
    let count = document.own.expected.len() / document.illuminants.len().max(1);
    let lights: Vec<String> =
        document.own.expected.iter().take(count).map(|e| e.luminance_cd_m2.to_string()).collect();
    let text = format!(
        "Camera {}, light {}, {} cd/m². Filters and mosaic minimise the expected error of the best linear pipeline.",
        document.camera,
        document.illuminants(),
        crate::words::listed(&lights),
    );
    el("p").child(text).into()
}

/// The statement of the proof, or the expectation with the command that proves it.
fn result(document: &Document, proved: Option<&Proved<'_>>, folder: &str) -> Markup {
    if let Some(proved) = proved {
        let of = |p: &smalti::experiment::Proof| {
            let several = proved.proofs.len() > 1;
            let size = if several { format!("{0} × {0}: ", p.patch) } else { String::new() };
            paragraph("headline", size + &headline(p))
        };
        return proved.proofs.iter().map(of).collect();
    }
    let gain = |array: &super::Array| {
        let found = document.searched.first().map_or([f64::NAN; 2], |a| super::document::means(&a.expected));
        let [db, de] = super::document::means(&array.expected);
        let text = format!("{:+.2} dB in CPSNR and {:+.2} in ΔE2000", found[0] - db, found[1] - de);
        text.replace('-', "−")
    };
    let mut text = format!("Expected against the camera’s own array: {}", gain(&document.own));
    if let Some(rival) = document.rivals.first() {
        text += &format!("; against {} with the best filters of the same kind: {}", rival.name, gain(rival));
    }
    paragraph("headline", text + ".")
        .and(paragraph(
            "help",
            "Means over the luminances; less is better in ΔE2000. These are expectations and no scores. The following command learns pipelines for this \
             array and for its rivals, and scores them on scenes that were not used.",
        ))
        .and(copyable(&format!("smalti design {} --prove", quoted(folder)), "command"))
}
