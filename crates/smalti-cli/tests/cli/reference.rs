//! The keys of cameras and studies, and the pages of the reference that are made of the lists.

use std::path::Path;

use serde_json::Value;

use super::Place;

/// Leaves of a document by their path.
fn leaves(value: &Value, path: &str, found: &mut Vec<(String, Value)>) {
    match value {
        Value::Object(map) if path != "optics.transmittance" && path != "sensor.quantum_efficiency" => {
            for (key, value) in map {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                leaves(value, &path, found);
            }
        }
        other => found.push((path.to_owned(), other.clone())),
    }
}

/// What a camera is when its file is empty is what the list calls default.
#[test]
fn camera_keys_are_those_of_the_code() {
    let place = Place::new();
    let listed: Value = serde_json::from_str(&place.ok("list camera-keys --json")).unwrap();
    let default = |key: &str| {
        let entry = listed.as_array().unwrap().iter().find(|e| e["key"] == key);
        entry.unwrap_or_else(|| panic!("{key} is not listed"))["default"].clone()
    };
    let description = serde_json::to_value(smalti::camera::CameraDescription::default()).unwrap();
    let mut found = Vec::new();
    leaves(&description, "", &mut found);
    assert!(found.len() > 40, "{}", found.len());
    for (key, value) in found {
        assert_eq!(default(&key), value, "{key}");
    }
    for e in listed.as_array().unwrap() {
        assert!(e["doc"].as_str().is_some_and(|d| !d.is_empty() && !d.contains("::")), "{e}");
    }
}

#[test]
fn study_keys_and_schemas() {
    let place = Place::new();
    let studies = place.ok("list study-keys");
    for word in
        ["conditions.grid", "mosaics.tile.symmetry", "\"scielab_mean\"", "filters.library.series.dyes"]
    {
        assert!(studies.contains(word), "{word} is missing in\n{studies}");
    }
    let schema: Value = serde_json::from_str(&place.ok("list camera-keys --schema")).unwrap();
    assert!(schema["properties"]["sensor"].is_object() && schema["additionalProperties"] == false);
    assert_eq!(place.run(&["list", "cfas", "--schema"]).code, 1);
}

/// `just reference` makes them.
#[test]
fn the_pages_of_the_reference_are_current() {
    let place = Place::new();
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference");
    for what in [
        "scenes",
        "cfas",
        "cameras",
        "illuminants",
        "filters",
        "metrics",
        "studies",
        "camera-keys",
        "study-keys",
    ] {
        let page = std::fs::read_to_string(docs.join(format!("{what}.md"))).unwrap_or_default();
        let made = place.ok(&format!("list {what} --markdown"));
        assert!(page == made, "docs/reference/{what}.md is not what the code says; run `just reference`");
    }
}
