//! Every source that code or documents cite by key, such as `[salmon2011]`, stands in REFERENCES.bib.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Files below a folder with one of the extensions.
fn files(folder: &Path, extensions: &[&str], found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, extensions, found);
        } else if path.extension().is_some_and(|e| extensions.iter().any(|x| e == *x)) {
            found.push(path);
        }
    }
}

fn entries() -> Vec<String> {
    let text = fs::read_to_string(root().join("REFERENCES.bib")).unwrap();
    let heads = text.lines().filter(|l| l.starts_with('@'));
    heads.map(|l| l.split(['{', ',']).nth(1).unwrap().trim().to_owned()).collect()
}

/// Keys in square brackets: lower-case letters, then a year; or one of the few without a year.
fn keys(text: &str) -> Vec<String> {
    let inside = text.split('[').skip(1).filter_map(|part| part.split_once(']')).map(|(key, _)| key);
    inside.filter(|key| is_key(key)).map(str::to_owned).collect()
}

fn is_key(key: &str) -> bool {
    const WITHOUT_YEAR: [&str; 14] = [
        "aptina",
        "isetcam",
        "cie15",
        "cie116",
        "cie170",
        "iec61966",
        "iso12233",
        "iso15739",
        "iso17321",
        "emva1288",
        "ansiz8028",
        "cfaresolution",
        "dng17",
        "iso18181",
    ];
    let name = key.trim_end_matches(|c: char| c.is_ascii_digit());
    let dated = name.len() > 1 && key.len() - name.len() == 4 && name.chars().all(|c| c.is_ascii_lowercase());
    dated || WITHOUT_YEAR.contains(&key)
}

#[test]
fn every_key_has_an_entry() {
    let known: BTreeSet<String> = entries().into_iter().collect();
    let mut found = Vec::new();
    files(&root().join("crates"), &["rs", "toml", "md"], &mut found);
    files(&root().join("docs"), &["md"], &mut found);
    let mut cited: BTreeMap<String, PathBuf> = BTreeMap::new();
    for path in found {
        // Not this one, whose examples are none.
        if !path.ends_with("references.rs") {
            let text = fs::read_to_string(&path).unwrap();
            cited.extend(keys(&text).into_iter().map(|key| (key, path.clone())));
        }
    }
    assert!(cited.len() > 30, "only {} keys found", cited.len());
    let missing: Vec<_> = cited.iter().filter(|(key, _)| !known.contains(*key)).collect();
    assert!(missing.is_empty(), "not in REFERENCES.bib: {missing:?}");
}

#[test]
fn entries_are_unique_and_whole() {
    let all = entries();
    let unique: BTreeSet<&String> = all.iter().collect();
    assert_eq!(unique.len(), all.len(), "an entry stands twice");
    let text = fs::read_to_string(root().join("REFERENCES.bib")).unwrap();
    let count = |c: char| text.chars().filter(|x| *x == c).count();
    assert_eq!(count('{'), count('}'));
    assert!(all.iter().all(|key| is_key(key) || key == "l3slides2014"), "{all:?}");
}

#[test]
fn keys_are_told_from_other_brackets() {
    let text = "a[0], [salmon2011], [`Scene`], [iso12233], [0.5, 2000], [x1], [Bayer1976], [malvar2004";
    assert_eq!(keys(text), ["salmon2011", "iso12233"]);
}
