//! Camera files, mosaics, and improvements.

use serde_json::{Value, json};
use smalti::sensor::Filter;
use smalti::spectrum::WavelengthGrid;
use smalti_wasm::Engine;

use super::{ask, engine, files, refused};

#[test]
fn camera_files_read_back() {
    let mut engine = engine();
    let design = json!(files().camera);
    let toml = ask(&mut engine, &json!({"camera_toml": {"design": design}})).said["toml"].clone();
    assert_eq!(ask(&mut engine, &json!({"parse": {"text": toml}})).said["design"], design);
    let curves = ask(&mut engine, &json!({"curves": {"design": design}})).said;
    assert_eq!(curves["mosaic"].as_array().unwrap().len(), 2);
    assert_eq!(curves["channels"].as_array().unwrap().len(), 3);
    assert_eq!(curves["wavelengths_nm"].as_array().unwrap().len(), 31);
    let catalogue = ask(&mut engine, &json!({"catalogue": {}})).said;
    assert!(catalogue["cfas"].as_array().unwrap().iter().any(|c| c["name"] == "rgbw"));
}

/// A design has in another mosaic the filters of the camera that was opened, and those that were changed by hand in place of those of their kind.
#[test]
fn mosaics_keep_the_filters_of_the_camera_and_those_changed_by_hand() {
    let mut engine = engine();
    let in_full = ask(
        &mut engine,
        &json!({"in_full": {"array": {"pattern": "quad", "filters": {"R": {"flat": 0.5}}}}}),
    );
    assert_eq!(in_full.said["pattern"].as_array().unwrap().len(), 4);
    assert_eq!(in_full.said["filters"]["R"], json!({"flat": 0.5}));
    assert_eq!(in_full.said["filters"]["G"], json!({"builtin": "green"}));
    let unknown = refused(&mut engine, &json!({"in_full": {"array": {"pattern": "quadd"}}}));
    assert!(unknown.contains("'quadd'; did you mean 'quad'?"), "{unknown}");
    let request = |base: &Value, given: &Value, changed: &Value, array: &Value, mosaic: &str| json!({"mosaic": {"base": base, "given": given, "changed": changed, "array": array, "mosaic": mosaic}});
    let builtin = |name: &str| json!({"builtin": name});
    let base = json!({"pattern": "bayer"});
    let full = |filters: Value| json!({"pattern": ["GR", "BG"], "filters": filters});
    let plain = full(json!({"R": builtin("red"), "G": builtin("green"), "B": builtin("blue")}));
    let own = ask(&mut engine, &request(&base, &base, &json!([]), &plain, "bayer")).said;
    assert_eq!((&own["is_own"], &own["array"]), (&json!(true), &own["in_full"]));
    let mine = json!({"gaussian": {"center_nm": 611.0, "sigma_nm": 30.0, "peak": 0.9}});
    let by_hand = full(json!({"R": mine, "G": builtin("green"), "B": builtin("blue")}));
    let rgbw = ask(&mut engine, &request(&base, &base, &json!([]), &by_hand, "rgbw")).said;
    assert_eq!(rgbw["given"], json!({"pattern": "rgbw"}));
    assert_eq!(rgbw["is_own"], json!(false));
    assert_eq!((&rgbw["in_full"]["filters"]["R"], &rgbw["array"]["filters"]["R"]), (&builtin("red"), &mine));
    assert_eq!(
        (&rgbw["in_full"]["pattern"], &rgbw["array"]["filters"]["W"]),
        (&rgbw["array"]["pattern"], &builtin("white"))
    );
    // The change is remembered where the mosaic has no such filter, and ends where it is taken back.
    let mono =
        ask(&mut engine, &request(&base, &rgbw["given"], &rgbw["changed"], &rgbw["array"], "mono")).said;
    assert_eq!(
        (&mono["array"]["filters"], &mono["changed"][0]["filter"]),
        (&json!({"W": builtin("white")}), &mine)
    );
    let again =
        ask(&mut engine, &request(&base, &mono["given"], &mono["changed"], &mono["array"], "bayer")).said;
    assert_eq!(again["array"]["filters"], by_hand["filters"]);
    let back = ask(&mut engine, &request(&base, &again["given"], &again["changed"], &plain, "rgbw")).said;
    assert_eq!((&back["array"], &back["changed"]), (&back["in_full"], &json!([])));
    // A camera with curves of its own has none for some letters.
    let measured = json!({"pattern": "bayer", "filters": {"R": mine}});
    let missing = ask(&mut engine, &request(&measured, &measured, &json!([]), &by_hand, "rgbw")).said;
    assert_eq!(missing, json!({"missing": ["W"]}));
    // A filter that was added serves its letter, in one mosaic after another.
    let mut added = by_hand.clone();
    added["filters"]["W"] = mine.clone();
    let mut last = ask(&mut engine, &request(&measured, &measured, &json!([]), &added, "rgbw")).said;
    for mosaic in ["mono", "rgbw"] {
        assert_eq!(last["array"]["filters"]["W"], mine, "{last}");
        let next = request(&measured, &last["given"], &last["changed"], &last["array"], mosaic);
        last = ask(&mut engine, &next).said;
    }
    assert_eq!((&last["array"]["filters"]["W"], &last["array"]["filters"]["R"]), (&mine, &mine));
    assert!(refused(&mut engine, &request(&base, &base, &json!([]), &plain, "bayr")).contains("bayer"));
}

#[test]
fn improvements_go_on_and_keep_locks() {
    let mut engine = engine();
    assert!(refused(&mut engine, &json!({"step": {}})).contains("improvement"));
    let design = json!(files().camera);
    let begin = |locks: Value| json!({"improve": {"design": design, "locks": locks, "luminances_cd_m2": [2.0, 20.0]}});
    let mut step = ask(&mut engine, &begin(json!({"filters": ["G"], "mosaic": true}))).said;
    for _ in 0..8 {
        let next = ask(&mut engine, &json!({"step": {}})).said;
        assert!(next["cost"].as_f64().unwrap() <= step["cost"].as_f64().unwrap());
        step = next;
    }
    assert_eq!(step["design"]["sensor"]["cfa"]["pattern"].as_array().unwrap().len(), 2);
    assert_eq!(step["step"], json!(8));
    // The design of a step is one that the engine draws.
    let request =
        json!({"learn": {"design": step["design"], "scene": files().scene.name, "luminance_cd_m2": 5.0}});
    ask(&mut engine, &request);
    assert!(refused(&mut engine, &begin(json!({"filters": ["W"]}))).contains("no filter \"W\""));
    assert!(refused(&mut engine, &begin(json!({"cells": [[0, 2]]}))).contains("2 × 2"));
}

/// A palette may have a filter that no cell has: it stays, whether it is locked or not.
#[test]
fn improvements_keep_filters_without_cells() {
    let mut engine = engine();
    let mut design = json!(files().camera);
    let clear = json!({"flat": 0.9});
    let pigment = |letter: &str| json!({"builtin": format!("pigment/{letter}")});
    design["sensor"]["cfa"] = json!({
        "pattern": ["RG", "GB"],
        "filters": {"R": pigment("R"), "G": pigment("G"), "B": pigment("B"), "C": clear},
    });
    for locked in [json!(["G"]), json!(["G", "C"])] {
        let begin = json!({"improve": {"design": design, "locks": {"filters": locked, "mosaic": true}, "luminances_cd_m2": [2.0]}});
        ask(&mut engine, &begin);
        let filters =
            ask(&mut engine, &json!({"step": {}})).said["design"]["sensor"]["cfa"]["filters"].clone();
        assert_eq!(filters["C"], clear);
        assert_eq!(filters["G"], pigment("G"));
        assert!(filters["R"]["samples"].is_object() && filters["B"]["samples"].is_object(), "{filters}");
        assert_eq!(filters.as_object().unwrap().len(), 4);
    }
}

/// Each step of an improvement among pigments is one that a factory can make: with two pigments in a filter at most, as those of `smalti design`. The engine states
/// them, and their layers make the curve.
#[test]
fn improvements_state_the_pigments_of_filters_that_can_be_made() {
    let mut engine = engine();
    let mut design = json!(files().camera);
    let gaussian = |nm: f64| json!({"gaussian": {"center_nm": nm, "sigma_nm": 38.0, "peak": 0.9}});
    design["sensor"]["cfa"] = json!({
        "pattern": ["RG", "GB"],
        "filters": {"R": gaussian(605.0), "G": gaussian(540.0), "B": gaussian(455.0)},
    });
    let curves = |engine: &mut Engine, design: &Value| {
        ask(engine, &json!({"curves": {"design": design}})).said["channels"].as_array().unwrap().clone()
    };
    let pigment = |name: &str| {
        let spectrum = Filter::Builtin(name.into()).spectrum(WavelengthGrid::VISIBLE).unwrap();
        let most = spectrum.max();
        spectrum.values().iter().map(|t| (t / most).max((-7.0f64).exp())).collect::<Vec<f64>>()
    };
    assert!(curves(&mut engine, &design).iter().all(|channel| channel["pigments"].is_null()));
    // Nor is a built-in filter, whose name says it, taken apart.
    let mut named = design.clone();
    named["sensor"]["cfa"]["filters"]["R"] = json!({"builtin": "pigment/R"});
    assert!(curves(&mut engine, &named).iter().all(|channel| channel["pigments"].is_null()));
    let begin = json!({"improve": {"design": design, "locks": {"mosaic": true}, "luminances_cd_m2": [2.0], "family": "pigments"}});
    let mut step = ask(&mut engine, &begin).said;
    let mut costs = Vec::new();
    while !step["is_done"].as_bool().unwrap() {
        for channel in curves(&mut engine, &step["design"]) {
            let layers = channel["pigments"].as_array().unwrap();
            assert!((1..=2).contains(&layers.len()), "{channel}");
            let mut made = vec![0.95; 31];
            for layer in layers {
                let thickness = layer["thickness"].as_f64().unwrap();
                let of_pigment = pigment(layer["name"].as_str().unwrap());
                made.iter_mut().zip(of_pigment).for_each(|(m, t)| *m *= t.powf(thickness));
            }
            for (made, stated) in made.iter().zip(channel["transmittance"].as_array().unwrap()) {
                assert!((made - stated.as_f64().unwrap()).abs() < 0.005, "{channel}");
            }
        }
        costs.push(step["cost"].as_f64().unwrap());
        step = ask(&mut engine, &json!({"step": {}})).said;
    }
    assert!(costs.len() > 3 && costs.is_sorted_by(|a, b| a >= b), "{costs:?}");
}
