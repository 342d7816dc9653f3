//! The proof of a design on its page.

use smalti::camera::PICTURE_METRICS;
use smalti::experiment::{Proof, ProofResult, RobustnessRow};

use super::proof_words::{basis, by_light, together};
use crate::comparison::figures::{beside, drawn, look};
use crate::comparison::verdict::WORDS;
use crate::page::{Markup, Table, el, paragraph};
use crate::{Line, Plot, Points, Rgb};

/// The proof of a design.
pub struct Proved<'a> {
    /// One for each size of the pipelines.
    pub proofs: &'a [Proof],
    /// The scores under other conditions.
    pub robustness: &'a [RobustnessRow],
    /// The rival of the robustness table.
    pub rival: &'a str,
    /// The regions of the scenes in which the pictures differ most.
    pub crops: Markup,
    /// The page of the comparison with all pictures, relative to that of the design.
    pub comparison: &'a str,
}

/// Statement, figures and tables of all proofs.
pub(super) fn section(proved: &Proved<'_>) -> Markup {
    proved.proofs.iter().map(one).collect()
}

fn one(proof: &Proof) -> Markup {
    let cards = (0..proof.luminances_cd_m2.len()).map(|light| {
        let words = by_light(proof, light);
        let metric =
            |(name, words): (&str, String)| Markup::from(el("dt").child(name)).and(el("dd").child(words));
        el("article")
            .class("verdict")
            .child(el("h3").child(format!("{} cd/m²", proof.luminances_cd_m2[light])))
            .child(el("dl").children(words.into_iter().map(metric)))
    });
    let all_rivals = el("details").child(el("summary").child("All rivals as numbers")).child(table(proof));
    Markup::from(el("h3").child(format!("Pipelines of {0} × {0}", proof.patch)))
        .and(paragraph("help", basis(proof)))
        .and(el("div").class("verdicts").children(cards))
        .and(beside((0..proof.luminances_cd_m2.len()).map(|light| leads(proof, light))))
        .and(all_rivals)
}

/// The leads over all rivals at a luminance: CPSNR across, ΔE2000 up.
fn leads(proof: &Proof, light: usize) -> Markup {
    let mut groups: [(&str, [Vec<f64>; 2]); 3] = [
        ("better in both", Default::default()),
        ("mixed or no difference", Default::default()),
        ("worse in one", Default::default()),
    ];
    for rival in &proof.rivals {
        let Some([cpsnr, delta_e, _]) = rival.leads.get(light) else { continue };
        let results = [cpsnr.result(), delta_e.result()];
        let group = match results {
            [ProofResult::Wins, ProofResult::Wins] => 0,
            r if r.contains(&ProofResult::Loses) => 2,
            _ => 1,
        };
        groups[group].1[0].push(cpsnr.by.value);
        groups[group].1[1].push(delta_e.by.value);
    }
    let all = |axis: usize| groups.iter().flat_map(move |(_, g)| g[axis].iter().copied());
    let ends = |axis: usize| all(axis).fold((0.0f64, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
    let ((left, right), (low, high)) = (ends(0), ends(1));
    let zero = Rgb(150, 150, 150);
    let mut plot = Plot::new("Lead in CPSNR (dB)", "Lead in ΔE2000")
        .title(format!("Leads over {} rivals at {} cd/m²", proof.rivals.len(), proof.luminances_cd_m2[light]))
        .note("A point is a rival; above and to the right of the lines, the array that was found is better. Findings rest on the simultaneous intervals.")
        .size(620.0, 460.0)
        .line(Line::new("", &[left, right], &[0.0, 0.0]).color(zero).width(1.2))
        .line(Line::new("", &[0.0, 0.0], &[low, high]).color(zero).width(1.2));
    for (i, (name, [x, y])) in groups.iter().enumerate().filter(|(_, (_, g))| !g[0].is_empty()) {
        let (_, symbol) = look(i);
        let color = [crate::OKABE_ITO[2], crate::OKABE_ITO[0], crate::OKABE_ITO[5]][i];
        plot = plot.points(Points::new(*name, x, y).color(color).symbol(symbol).radius(6.0).marks());
    }
    drawn(&plot)
}

/// The leads over every rival with their simultaneous intervals.
fn table(proof: &Proof) -> Markup {
    let name = &proof.found.label;
    let mut table = Table::new(format!("Leads of {name}, with simultaneous 95 % intervals")).text("Rival");
    for (word, unit, _) in &WORDS {
        for light in &proof.luminances_cd_m2 {
            let unit = unit.trim();
            let unit = if unit.is_empty() { String::new() } else { format!(", {unit}") };
            table = table.number(format!("{word} at {light} cd/m²{unit}"));
        }
    }
    for rival in &proof.rivals {
        let cells = (0..PICTURE_METRICS.len()).flat_map(|metric| {
            rival.leads.iter().map(move |leads| {
                let lead = &leads[metric];
                let mark = match lead.result() {
                    ProofResult::Wins => "",
                    ProofResult::Ties => " =",
                    ProofResult::Loses => " ✗",
                };
                together(lead, WORDS[metric].2) + mark
            })
        });
        table = table.row(std::iter::once(rival.scored.label.clone()).chain(cells), false);
    }
    Markup::from(table).and(paragraph(
        "help",
        "A lead above 0 means that the array that was found is better. = marks leads that are not shown to differ from 0, ✗ losses.",
    ))
}
