//! What the engine says of designs.

use serde_json::{Value, json};
use smalti::design::search::{FilterSpace, FreeCurves};
use smalti::sensor::Filter;
use smalti::spectrum::WavelengthGrid;
use smalti_wasm::Engine;

use super::{ask, engine, files};

#[test]
fn filters_that_the_family_does_not_have_are_named() {
    let mut engine = engine();
    let mut camera = files().camera.clone();
    let band = smalti::sensor::Filter::Box { low_nm: 500.0, high_nm: 540.0, peak: 1.0 };
    let pigment =
        |letter: &str| (letter.to_owned(), smalti::sensor::Filter::Builtin(format!("pigment/{letter}")));
    camera.sensor.cfa.filters = ["R", "B"].map(pigment).into();
    camera.sensor.cfa.filters.insert("G".into(), band);
    let mut warnings = |family: Value| {
        let request = json!({"scores": {"design": camera, "luminances_cd_m2": [], "family": family}});
        let said = ask(&mut engine, &request).said;
        let all = said["warnings"].as_array().unwrap().iter().map(|w| w["message"].as_str().unwrap());
        all.filter(|message| message.contains("cannot be made")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(warnings(Value::Null), [""; 0]);
    let of_pigments = warnings(json!("pigments"));
    assert!(
        of_pigments.len() == 1 && of_pigments[0].starts_with("the filter G cannot be made of pigments"),
        "{of_pigments:?}"
    );
    assert!(!warnings(json!("dichroic")).is_empty());
    assert_eq!(warnings(json!("pigments")), warnings(json!("pigments")));
}

/// What the page found in a family is of the family, also where its curves are steep; a higher peak is told as such.
#[test]
fn filters_that_the_page_found_can_be_made() {
    let mut engine = engine();
    let warned = |engine: &mut Engine, design: &Value, family: &str| -> Vec<String> {
        let request = json!({"scores": {"design": design, "luminances_cd_m2": [], "family": family}});
        let said = ask(engine, &request).said;
        let all =
            said["warnings"].as_array().unwrap().iter().map(|w| w["message"].as_str().unwrap().to_owned());
        all.filter(|m| m.contains("cannot be made") || m.contains("peak")).collect()
    };
    for family in ["free", "pigments", "dichroic"] {
        let begin = json!({"improve": {"design": files().camera, "locks": {"mosaic": true}, "luminances_cd_m2": [2.0], "family": family}});
        let mut step = ask(&mut engine, &begin).said;
        for _ in 0..60 {
            step = ask(&mut engine, &json!({"step": {}})).said;
        }
        assert_eq!(warned(&mut engine, &step["design"], family), [""; 0], "{family}");
    }
    let mut design = json!(files().camera);
    // Searches beside the page have fewer knots.
    let coarse = FilterSpace::Free(FreeCurves::default()).sampled(WavelengthGrid::VISIBLE).unwrap();
    let steep = |sign: f64| {
        let parameters: Vec<f64> =
            (0..coarse.parameters()).map(|i| sign * if i % 3 == 0 { 9.0 } else { -7.0 }).collect();
        json!(Filter::sampled(&coarse.spectrum(&parameters).unwrap()))
    };
    design["sensor"]["cfa"] =
        json!({"pattern": ["RG", "GR"], "filters": {"R": steep(1.0), "G": steep(-1.0)}});
    assert_eq!(warned(&mut engine, &design, "free"), [""; 0]);
    let gaussian = |center_nm: f64, peak: f64| json!({"gaussian": {"center_nm": center_nm, "sigma_nm": 40.0, "peak": peak}});
    design["sensor"]["cfa"] = json!({
        "pattern": ["RG", "GB"],
        "filters": {"R": gaussian(610.0, 0.9), "G": gaussian(540.0, 1.0), "B": gaussian(460.0, 0.95)},
    });
    assert_eq!(
        warned(&mut engine, &design, "free"),
        ["the peak of the filter G is 100 % transmittance; smooth curves reach 95 %"]
    );
    design["sensor"]["cfa"]["filters"]["B"] = gaussian(460.0, 0.98);
    assert_eq!(
        warned(&mut engine, &design, "free"),
        [
            "the peaks of 2 filters are higher than the 95 % transmittance that smooth curves reach: G (100 %), B (98 %)"
        ]
    );
}

/// Arrays that cannot tell all colours apart, whatever the noise of their colour matrix.
#[test]
fn arrays_that_confuse_colours_are_named() {
    let mut engine = engine();
    let mut warned = |pattern: Value, blue: Value| -> Vec<String> {
        let mut design = json!(files().camera);
        let pigment = |letter: &str| json!({"builtin": format!("pigment/{letter}")});
        let filters = json!({"R": pigment("R"), "G": pigment("G"), "B": blue, "W": {"flat": 0.95}});
        design["sensor"]["cfa"] = json!({"pattern": pattern, "filters": filters});
        let said = ask(&mut engine, &json!({"scores": {"design": design, "luminances_cd_m2": []}})).said;
        let all =
            said["warnings"].as_array().unwrap().iter().map(|w| w["message"].as_str().unwrap().to_owned());
        all.filter(|m| m.starts_with("the array")).collect()
    };
    let [green, blue] = ["G", "B"].map(|letter| json!({"builtin": format!("pigment/{letter}")}));
    assert_eq!(warned(json!(["RG", "GB"]), blue.clone()), [""; 0]);
    assert_eq!(warned(json!(["RW", "WB"]), blue.clone()), [""; 0]);
    for (pattern, blue, word) in [
        (json!(["RG", "GB"]), green, "only two of its channels"),
        (json!(["RG", "GR"]), blue.clone(), "only two of its channels"),
        (json!(["WW", "WW"]), blue, "sees no colour"),
    ] {
        let found = warned(pattern, blue);
        assert!(
            found.len() == 1 && found[0].contains(word) && found[0].contains("colour needs three"),
            "{found:?}"
        );
    }
}

/// What lies beyond the wavelengths of the page is judged by the curves that are stated there.
#[test]
fn infrared_is_judged_where_curves_are_stated() {
    let mut engine = engine();
    let mut warnings = |change: &dyn Fn(&mut Value)| {
        let mut design = json!(files().camera);
        let pigment = |letter: &str| json!({"builtin": format!("pigment/{letter}")});
        design["sensor"]["cfa"] = json!({
            "pattern": ["RG", "GB"],
            "filters": {"R": pigment("R"), "G": pigment("G"), "B": pigment("B")},
        });
        design["sensor"]["quantum_efficiency"] = json!({"builtin": "silicon"});
        change(&mut design);
        let said = ask(&mut engine, &json!({"scores": {"design": design, "luminances_cd_m2": []}})).said;
        let all = said["warnings"].as_array().unwrap().iter();
        all.filter(|w| w["key"] == "optics.ir_cut")
            .map(|w| w["message"].as_str().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    let without = |design: &mut Value| drop(design["optics"].as_object_mut().unwrap().remove("ir_cut"));
    let table = |values: Vec<f64>| json!({"samples": {"start_nm": 400.0, "step_nm": 10.0, "values": values}});
    // A table that is dark at 700 nm does not say what it is beyond.
    let fading: Vec<f64> = (0..31).map(|i| if i < 25 { 0.5 } else { 0.0 }).collect();
    assert_eq!(warnings(&|design| design["optics"]["ir_cut"] = json!({"builtin": "ir-cut"})), [""; 0]);
    let seen = warnings(&without);
    assert!(seen.iter().any(|m| m.contains("would reach 3 channels") && m.contains(" R (")), "{seen:?}");
    assert!(!seen.iter().any(|m| m.contains("cannot be judged")), "{seen:?}");
    let unknown = warnings(&|design| {
        without(design);
        design["sensor"]["cfa"]["filters"]["R"] = table(fading.clone());
    });
    assert!(
        unknown
            .iter()
            .any(|m| m.starts_with("whether light beyond 700 nm reaches the filters R cannot be judged")),
        "{unknown:?}"
    );
    assert!(
        unknown.iter().any(|m| m.contains("would reach 2 channels") && !m.contains(" R (")),
        "{unknown:?}"
    );
    // The infrared cut is stated there.
    let cut = warnings(&|design| {
        design["optics"]["ir_cut"] = json!({"builtin": "ir-cut"});
        design["sensor"]["cfa"]["filters"]["R"] = table(fading.clone());
    });
    assert_eq!(cut, [""; 0]);
}

/// What holds of several filters is one warning, which names the worst first.
#[test]
fn faults_of_many_filters_are_one_warning() {
    let mut engine = engine();
    let mut design = json!(files().camera);
    let band = |center_nm: f64, peak: f64| json!({"gaussian": {"center_nm": center_nm, "sigma_nm": 40.0, "peak": peak}});
    let dark = |peak: f64| band(550.0, peak);
    let filters = json!({"A": dark(0.9), "B": dark(0.009), "C": dark(0.0009), "D": dark(0.0045), "E": band(480.0, 0.8)});
    design["sensor"]["cfa"] = json!({"pattern": ["ABC", "DEA"], "filters": filters});
    let said = ask(
        &mut engine,
        &json!({"scores": {"design": design, "luminances_cd_m2": [], "family": "pigments"}}),
    )
    .said;
    let warnings = said["warnings"].as_array().unwrap();
    let of = |words: &str| -> Vec<&str> {
        let all = warnings.iter().map(|w| w["message"].as_str().unwrap());
        all.filter(|message| message.contains(words)).collect()
    };
    assert_eq!(
        of("respond weakly"),
        [
            "3 channels respond weakly to white, relative to the brightest channel: C (0.1 %), D (0.5 %), B (1.0 %)"
        ]
    );
    let unmade = of("cannot be made");
    assert_eq!(unmade.len(), 1, "{warnings:?}");
    assert!(
        unmade[0].starts_with("2 filters cannot be made of pigments. ")
            && unmade[0].contains("percentage points"),
        "{unmade:?}"
    );
}
