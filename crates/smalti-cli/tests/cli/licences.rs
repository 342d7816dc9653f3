//! THIRD-PARTY.txt credits everything that the programs contain.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// The systems for which there are releases, as tools/licences.py lists them.
const PLATFORMS: [&str; 3] = ["x86_64-unknown-linux-gnu", "aarch64-apple-darwin", "x86_64-pc-windows-msvc"];

/// The crates of others that the command and the Python package link on a platform, as THIRD-PARTY.txt lists them.
fn linked(root: &Path, platform: &str) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked", "--filter-platform", platform])
        .current_dir(root)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let by_id = |list: &Value| -> BTreeMap<String, Value> {
        let id = |v: &Value| v["id"].as_str().unwrap().to_owned();
        list.as_array().unwrap().iter().map(|v| (id(v), v.clone())).collect()
    };
    let (packages, nodes) = (by_id(&metadata["packages"]), by_id(&metadata["resolve"]["nodes"]));
    let is_built = |name: &Value| name == "smalti-cli" || name == "smalti-py";
    let mut open: Vec<&str> =
        packages.iter().filter(|(_, p)| is_built(&p["name"])).map(|(id, _)| id.as_str()).collect();
    let mut linked = BTreeSet::new();
    while let Some(id) = open.pop() {
        if linked.insert(id) {
            let normal = |d: &&Value| d["dep_kinds"].as_array().unwrap().iter().any(|k| k["kind"].is_null());
            let deps = nodes[id]["deps"].as_array().unwrap().iter().filter(normal);
            open.extend(deps.map(|d| d["pkg"].as_str().unwrap()));
        }
    }
    let external = linked.iter().map(|id| &packages[*id]).filter(|p| p["source"].is_string());
    external
        .map(|p| {
            let word = |key: &str| p[key].as_str().unwrap().to_owned();
            format!("{} {}: {}", word("name"), word("version"), word("license"))
        })
        .collect()
}

#[test]
fn every_crate_font_and_script_is_credited() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = std::fs::read_to_string(root.join("THIRD-PARTY.txt")).unwrap();
    let listed: BTreeSet<&str> =
        text.lines().skip_while(|l| !l.contains(": ")).take_while(|l| !l.is_empty()).collect();
    let mut expected: BTreeSet<String> =
        PLATFORMS.iter().flat_map(|platform| linked(&root, platform)).collect();
    assert!(expected.len() > 100, "{}", expected.len());
    expected.insert("the typeface Inter, in figures: crates/smalti-report/fonts/OFL.txt".into());
    expected.insert("photographs, as scenes: crates/smalti-io/scenes/LICENCES.md".into());
    expected.insert("uPlot, in pages: crates/smalti-report/vendor/uplot/LICENSE".into());
    let expected: BTreeSet<&str> = expected.iter().map(String::as_str).collect();
    assert_eq!(listed, expected, "run python3 tools/licences.py");
    for credit in [
        "the work of the Independent JPEG Group",
        "SIL OPEN FONT LICENSE",
        "UNICODE LICENSE V3",
        "Leon Sorokin",
        "flickr.com/photos/vultilion/6056698931",
    ] {
        assert!(text.contains(credit), "{credit}");
    }
    // It comes with the package.
    let package = std::fs::read_to_string(root.join("pyproject.toml")).unwrap();
    assert!(package.contains("\"THIRD-PARTY.txt\""));
}
