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
    let listed = place.document("list camera-keys --json");
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
    let schema = place.document("list camera-keys --schema");
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
        "designs",
        "camera-keys",
        "study-keys",
        "design-keys",
    ] {
        let page = std::fs::read_to_string(docs.join(format!("{what}.md"))).unwrap_or_default();
        let made = place.ok(&format!("list {what} --markdown"));
        assert!(page == made, "docs/reference/{what}.md is not what the code says; run `just reference`");
    }
}

/// `just reference` draws them.
#[test]
fn the_tiles_of_the_reference_are_current() {
    let place = Place::new();
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/cfas");
    let listed = place.document("list cfas --json");
    let names: Vec<&str> = listed.as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(std::fs::read_dir(&docs).unwrap().count(), names.len());
    for name in names {
        place.ok(&format!("show {name} --as cfa -o tile.svg"));
        let there = std::fs::read(docs.join(format!("{name}.svg"))).unwrap_or_default();
        assert!(there == place.read("tile.svg"), "docs/reference/cfas/{name}.svg: run `just reference`");
    }
}

/// Links of README and docs lead to files that are there, and the book has every page.
#[test]
fn documents_lead_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut pages = vec![root.join("README.md")];
    let mut folders = vec![root.join("docs")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.extension() {
                _ if path.is_dir() => folders.push(path),
                Some(e) if e == "md" => pages.push(path),
                _ => {}
            }
        }
    }
    let mut linked = std::collections::BTreeSet::new();
    for page in &pages {
        let text = std::fs::read_to_string(page).unwrap();
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = target.split('#').next().unwrap_or_default();
            if file.is_empty() || target.contains("://") || file.contains([' ', '`']) {
                continue;
            }
            let path = page.parent().unwrap().join(file);
            assert!(path.exists(), "{} leads to {target}, which is not there", page.display());
            if page.ends_with("SUMMARY.md") {
                linked.insert(path.canonicalize().unwrap());
            }
        }
    }
    for page in pages.iter().filter(|p| !p.ends_with("README.md") && !p.ends_with("SUMMARY.md")) {
        assert!(
            linked.contains(&page.canonicalize().unwrap()),
            "{} is not in docs/SUMMARY.md",
            page.display()
        );
    }
}
