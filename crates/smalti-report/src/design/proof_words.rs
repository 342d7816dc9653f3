//! The proof of a design in words.

use smalti::camera::PICTURE_METRICS;
use smalti::experiment::{Estimate, Proof, ProofResult, ProvedLead};
use smalti::numeric::bootstrap::LEAST_GROUPS;

use crate::comparison::verdict::{WORDS, amount};
use crate::words::listed;

/// The metrics of the statement: CPSNR and ΔE2000.
pub(super) const STATED: usize = 2;
/// Names that a sentence lists.
const LISTED: usize = 6;

/// The lead with the interval that holds together with all others.
pub(super) fn together(lead: &ProvedLead, digits: usize) -> String {
    amount(&Estimate { value: lead.by.value, interval: lead.simultaneous }, "", digits)
}

/// The statement in a sentence: all are beaten, or where they are not.
pub(super) fn headline(proof: &Proof) -> String {
    let (name, count) = (&proof.found.label, proof.rivals.len());
    if proof.beats_all() {
        return format!("{name} beats all {count} rivals at every luminance, in CPSNR and in ΔE2000.");
    }
    let [mut wins, mut ties, mut losses] = [0; 3];
    for lead in proof.rivals.iter().flat_map(|r| &r.leads).flat_map(|leads| &leads[..STATED]) {
        match lead.result() {
            ProofResult::Wins => wins += 1,
            ProofResult::Ties => ties += 1,
            ProofResult::Loses => losses += 1,
        }
    }
    let all = wins + ties + losses;
    let beaten = |r: &&smalti::experiment::Rival| {
        r.leads.iter().flat_map(|l| &l[..STATED]).all(|l| l.result() == ProofResult::Wins)
    };
    let beaten = proof.rivals.iter().filter(beaten).count();
    format!(
        "{name} beats {beaten} of {count} rivals at every luminance in CPSNR and in ΔE2000. Of the {all} comparisons, it wins {wins}, loses {losses}, and \
             {ties} show no difference."
    )
}

/// What the proof rests on.
pub(super) fn basis(proof: &Proof) -> String {
    let method = match proof.scenes.len() {
        n if n < LEAST_GROUPS => "Student’s t with Bonferroni’s bound",
        _ => "paired bootstrap, largest deviation of all",
    };
    let count = |n: usize, one: &str| if n == 1 { format!("one {one}") } else { format!("{n} {one}s") };
    format!(
        "Pipelines of {0} × {0} learned for each camera; {1} with {2} each, none used for training or for the search; light {3}. The 95 % intervals hold \
             together for all rivals, luminances and metrics ({method}).",
        proof.patch,
        count(proof.scenes.len(), "scene"),
        count(proof.seeds as usize, "noise realisation"),
        proof.illuminant,
    )
}

/// The results at a luminance by a metric.
pub(super) fn by_metric(proof: &Proof, light: usize, metric: usize) -> String {
    let (_, unit, digits) = WORDS[metric];
    let named = |result: ProofResult| -> Vec<String> {
        let all = proof.with_result(light, metric, result);
        let more = all.len().saturating_sub(LISTED);
        let name = |(name, lead): &(&str, ProvedLead)| {
            let by = amount(&Estimate { value: lead.by.value, interval: lead.simultaneous }, unit, digits);
            format!("{name} by {by}")
        };
        let mut words: Vec<String> = all.iter().take(LISTED).map(name).collect();
        if more > 0 {
            words.push(format!("{more} more"));
        }
        words
    };
    let wins = proof.with_result(light, metric, ProofResult::Wins).len();
    let count = proof.rivals.len();
    let mut text = if wins == count {
        format!("better than all {count}")
    } else {
        format!("better than {wins} of {count}")
    };
    let ties = named(ProofResult::Ties);
    if !ties.is_empty() {
        text += &format!("; no difference shown from {}", listed(&ties).replace(" by ", " "));
    }
    // The leads of losses are negative.
    let losses = named(ProofResult::Loses);
    if !losses.is_empty() {
        text += &format!("; worse than {}", listed(&losses).replace(" by ", ": "));
    }
    text
}

/// The results of each metric at a luminance.
pub(super) fn by_light(proof: &Proof, light: usize) -> Vec<(&'static str, String)> {
    (0..PICTURE_METRICS.len()).map(|metric| (WORDS[metric].0, by_metric(proof, light, metric))).collect()
}
