//! Tests of the page of a design.
#![allow(clippy::unwrap_used)]

use serde_json::{Value, json};
use smalti::experiment::{Estimate, Finding, Proof, ProvedLead, Rival, RobustnessRow, Scored};
use smalti::numeric::bootstrap::Interval;

use super::{Document, Proved, page, proof_text};
use crate::page::Markup;

const HOSTILE: &str = "</script><script>alert(1)</script>";

fn expected(shift: f64) -> Value {
    let at = |(cd_m2, db): (f64, f64)| json!({ "illuminant": "D65", "luminance_cd_m2": cd_m2, "cpsnr_db": db + shift, "delta_e_2000": 9.0 - shift, "time_s": 0.1 });
    json!([at((1.0, 22.0)), at((80.0, 31.0))])
}

fn array(name: &str, shift: f64) -> Value {
    json!({
        "name": name, "tile": "ab/bc", "filters": 3, "cost": -0.5 - shift, "expected": expected(shift),
        "figures": {
            "photon_efficiency": 0.4125, "vora_value": 0.95, "sensitivity_metamerism_index": 82.0, "metamer_mismatch_percent": 3.0,
            "condition_number": null, "luminance_noise_gain": 1.25,
        },
        "costs_of_starts": [-0.5, -0.4], "transmittances": [[0.9, 0.2, 0.1], [0.1, 0.9, 0.1], [0.1, 0.2, 0.9]],
    })
}

fn results(front: usize) -> Document {
    let cause = |e: f64| json!({ "squared_error": e, "delta_e_2000": 1e3 * e });
    let class = |name: &str, patches: f64| json!({ "class": name, "patches": patches, "noise": cause(3e-3), "sampling": cause(2e-3), "color": cause(1e-3) });
    let limits = |cd_m2: f64| json!({ "luminance_cd_m2": cd_m2, "classes": [class("contrast below 0.15", 0.75), class("contrast from 0.15", 0.25)] });
    let sensitivity = |filter: Option<&str>, words: &str, shift: f64| json!({ "filter": filter, "words": words, "expected": expected(shift) });
    let points: Vec<Value> = (0..front as i64)
        .map(|i| json!({ "shares": [0.5, 0.5], "costs": [i, -i], "design": array("ab/bc", i as f64) }))
        .collect();
    let document = json!({
        "name": HOSTILE, "camera": "bayer", "illuminants": ["D65"], "wavelengths_nm": [400.0, 550.0, 700.0],
        "quantum_efficiency": [0.5, 0.6, 0.4], "lens_and_ir_cut": [1.0, 1.0, 0.3],
        "light": [{ "scenes": 30, "patches": 469_508 }], "seconds": 33.0,
        "own": array("bayer", -1.0), "searched": [array("ab/bc", 1.0)], "rivals": [array("rgbcmy", 0.5)],
        "analysis": {
            "expected": expected(1.0),
            "sensitivities": [
                sensitivity(Some("B"), "+5 nm", 0.75), sensitivity(Some("A"), "+5 nm", 0.98), sensitivity(None, "+5 nm", 0.5),
            ],
            "limits": [limits(1.0), limits(80.0)],
        },
        "front": { "aims": [{ "name": "noise" }, { "name": "colour" }], "points": points },
    });
    serde_json::from_value(document).unwrap()
}

fn lead(value: f64, half: f64, finding: Finding) -> ProvedLead {
    let around = |half: f64| Some(Interval { low: value - half, high: value + half });
    ProvedLead { by: Estimate { value, interval: around(0.5 * half) }, simultaneous: around(half), finding }
}

fn proof(leads: &[(&str, ProvedLead)]) -> Proof {
    let scored =
        |label: &str| Scored { label: label.into(), means: vec![[30.0, 4.0, 3.0]], times_s: vec![0.1] };
    Proof {
        patch: 5,
        scenes: (0..6).map(|i| format!("scene {i}")).collect(),
        seeds: 5,
        seed: 1,
        illuminant: "D65".into(),
        luminances_cd_m2: vec![10.0],
        found: scored("six"),
        rivals: leads
            .iter()
            .map(|(name, lead)| Rival { scored: scored(name), leads: vec![[*lead; 3]] })
            .collect(),
    }
}

fn lines(header: &[&str], rows: &[Vec<String>]) -> String {
    let rows = rows.iter().map(|row| row.join(" | ") + "\n");
    header.join(" | ") + "\n" + &rows.collect::<String>()
}

#[test]
fn a_page_has_its_sections_and_no_markup_of_names() {
    let html = page(&results(1), None, "my folder").unwrap();
    for id in ["result", "arrays", "limits", "sensitivity", "search"] {
        assert!(html.contains(&format!("<section id=\"{id}\"")), "{id}");
    }
    for absent in ["proof", "front", "robustness", "pictures"] {
        assert!(!html.contains(&format!("<section id=\"{absent}\"")), "{absent}");
    }
    assert!(!html.contains(HOSTILE) && html.contains("&lt;/script&gt;"));
    assert!(
        html.contains("smalti design &#39;my folder&#39; --prove")
            || html.contains("smalti design 'my folder' --prove")
    );
    assert!(html.contains("+5 nm of B: it costs 0.25 dB"), "the worst deviation is named");
    assert!(html.contains("+2.00 dB in CPSNR and −2.00 in ΔE2000; against rgbcmy"));
    assert!(page(&results(2), None, "a").unwrap().contains("<section id=\"front\""));
}

#[test]
fn shares_of_the_error_are_written_out() {
    let html = page(&results(0), None, "a").unwrap();
    // Half, a third and a sixth.
    assert!(html.contains("1 cd/m², all patches: noise 50 %. 1 cd/m², all patches: sampling 33 %."));
    assert!(html.contains("contrast below 0.15 (75 %)"));
}

#[test]
fn losses_are_as_loud_as_gains() {
    let wins = proof(&[("a", lead(1.0, 0.4, Finding::Lead)), ("b", lead(0.5, 0.1, Finding::Lead))]);
    let mixed = proof(&[
        ("a", lead(1.0, 0.4, Finding::Lead)),
        ("b", lead(0.2, 0.4, Finding::NoDifference)),
        ("c", lead(-0.5, 0.2, Finding::Lead)),
    ]);
    let text = |proof: &Proof| {
        let proved = Proved {
            proofs: std::slice::from_ref(proof),
            robustness: &[],
            rival: "b",
            crops: Markup::new(),
            comparison: "c.html",
        };
        proof_text(&proved, &lines)
    };
    assert!(text(&wins).contains("six beats all 2 rivals at every luminance, in CPSNR and in ΔE2000."));
    let told = text(&mixed);
    for words in [
        "six beats 1 of 3 rivals",
        "it wins 2, loses 2, and 2 show no difference",
        "better than 1 of 3; no difference shown from b 0.20 dB [−0.20, 0.60]; worse than c: −0.50 dB [−0.70, −0.30]",
        "c | −0.50 [−0.70, −0.30] ✗",
        "b | 0.20 [−0.20, 0.60] =",
        "paired bootstrap, largest deviation of all",
    ] {
        assert!(told.contains(words), "{words} is missing in\n{told}");
    }
}

#[test]
fn a_proved_page_has_the_statement_and_the_tables() {
    let proof = proof(&[("rgbcmy", lead(-0.5, 0.2, Finding::Lead))]);
    let estimate = Estimate { value: 0.3, interval: Some(Interval { low: -0.1, high: 0.7 }) };
    let rows = [RobustnessRow {
        name: "illuminant A".into(),
        scenes: 8,
        found: vec![[30.0, 4.0, 3.0]],
        rival: vec![[29.7, 4.3, 3.0]],
        leads: vec![[estimate; 3]],
    }];
    let proved = Proved {
        proofs: &[proof],
        robustness: &rows,
        rival: "rgbcmy",
        crops: Markup::from("crops"),
        comparison: "proof/comparison/report.html",
    };
    let html = page(&results(0), Some(&proved), "a").unwrap();
    for words in [
        "six does not beat its one rival",
        "worse than rgbcmy: −0.50 dB [−0.70, −0.30]",
        "href=\"proof/comparison/report.html\"",
        "illuminant A",
        "0.30 [−0.10, 0.70] =",
    ] {
        assert!(html.contains(words), "{words}");
    }
    assert!(!html.contains("--prove"));
}
