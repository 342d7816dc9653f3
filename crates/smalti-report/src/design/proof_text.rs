//! The proof of a design for a terminal.

use smalti::experiment::{Proof, ProofResult, Rival};

use super::proof::Proved;
use super::proof_words::{STATED, basis, by_light, headline, together};
use super::robustness;
use crate::TextTable;
use crate::comparison::verdict::WORDS;

/// Rivals of the printed table.
const PRINTED: usize = 8;

/// Statement, results by luminance, the rivals that come nearest, and other conditions.
#[must_use]
pub fn text(proved: &Proved<'_>, table: &TextTable<'_>) -> String {
    let mut out = String::new();
    for proof in proved.proofs {
        out += &format!("Proof. {}\n{}\n", headline(proof), basis(proof));
        for (light, cd_m2) in proof.luminances_cd_m2.iter().enumerate() {
            out += &format!("  {cd_m2} cd/m²\n");
            for (name, words) in by_light(proof, light) {
                out += &format!("    {name:<9} {words}\n");
            }
        }
        out += &nearest(proof, table);
    }
    out + &robustness::text(proved, table)
}

/// The leads over the rivals with the smallest mean lead in CPSNR.
fn nearest(proof: &Proof, table: &TextTable<'_>) -> String {
    let mean = |r: &Rival| r.leads.iter().map(|l| l[0].by.value).sum::<f64>();
    let mut rivals: Vec<&Rival> = proof.rivals.iter().collect();
    rivals.sort_by(|a, b| mean(a).total_cmp(&mean(b)));
    rivals.truncate(PRINTED);
    let mut header = vec!["rival".to_owned()];
    for (word, _, _) in WORDS.iter().take(STATED) {
        header.extend(proof.luminances_cd_m2.iter().map(|light| format!("{word} at {light}")));
    }
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let row = |r: &&Rival| {
        let cell = |metric: usize| {
            r.leads.iter().map(move |l| {
                let mark = match l[metric].result() {
                    ProofResult::Wins => "",
                    ProofResult::Ties => " =",
                    ProofResult::Loses => " ✗",
                };
                together(&l[metric], WORDS[metric].2) + mark
            })
        };
        std::iter::once(r.scored.label.clone()).chain((0..STATED).flat_map(cell)).collect()
    };
    let rows: Vec<Vec<String>> = rivals.iter().map(row).collect();
    format!("\nLeads over the nearest rivals (= not shown, ✗ worse):\n{}", table(&header, &rows))
}
