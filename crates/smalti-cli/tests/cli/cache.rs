//! The cache: what the command shows of it, its limits, and entries that are not what they should be.

use crate::{Place, Run};

fn entries(place: &Place) -> Vec<u64> {
    let shown = place.document("cache --json");
    let kinds = shown["kinds"].as_array().unwrap();
    let sum: u64 = kinds.iter().map(|k| k["bytes"].as_u64().unwrap()).sum();
    assert_eq!(shown["bytes"].as_u64().unwrap(), sum);
    assert_eq!(shown["limit_bytes"].as_u64().unwrap(), 2_000_000_000);
    kinds.iter().map(|k| k["entries"].as_u64().unwrap()).collect()
}

#[test]
fn the_cache_is_shown_and_emptied() {
    let place = Place::new();
    assert_eq!(entries(&place), [0; 5]);
    place.ok("evaluate bayer");
    let kept = entries(&place);
    assert!(kept[0] > 0 && kept[1..] == [0; 4], "{kept:?}");
    let shown = place.ok("cache");
    let folder = place.path("cache").display().to_string();
    for word in [folder.as_str(), "of at most 2000.0 MB", "90 days", "optical images", "scores"] {
        assert!(shown.contains(word), "{word} in {shown}");
    }
    place.write("cache/notes.txt", "mine");
    let said = place.ok("cache --clear");
    assert!(said.starts_with("Removed ") && said.contains(" MB from "), "{said}");
    assert_eq!((entries(&place), place.names("cache")), (vec![0; 5], vec!["notes.txt".to_owned()]));
}

/// Every entry of a light exchanged with one of another light: the scores are those without a cache.
#[test]
fn exchanged_entries_change_no_score() {
    let place = Place::new();
    let at = |light: &str| format!("evaluate bayer --json --illuminant {light}");
    let fresh = place.ok(&at("D65"));
    let of_d65 = place.names("cache");
    place.ok(&at("A"));
    let mut of_a = place.names("cache");
    of_a.retain(|name| !of_d65.contains(name));
    assert!(!of_a.is_empty() && of_a.len() == of_d65.len(), "{of_a:?}");
    for own in &of_d65 {
        let len = |name: &str| place.read(&format!("cache/{name}")).len();
        for other in of_a.iter().filter(|other| len(other) == len(own)) {
            std::fs::copy(place.path("cache").join(other), place.path("cache").join(own)).unwrap();
        }
    }
    assert_eq!(fresh, place.ok(&at("D65")));
}

#[test]
fn limits_hold_and_must_be_numbers() {
    let place = Place::new();
    let run = |variable: &str, value: &str| {
        Run::of(place.command().args(["evaluate", "bayer"]).env(variable, value))
    };
    for (variable, value) in [("SMALTI_CACHE_GB", "much"), ("SMALTI_CACHE_DAYS", "-1")] {
        let run = run(variable, value);
        assert_eq!(
            (run.code, run.err),
            (
                1,
                format!("error: the variable {variable} is '{value}'; expected a number from 0 to 1000000\n")
            )
        );
    }
    assert_eq!(run("SMALTI_CACHE_GB", "0").code, 0);
    assert_eq!(entries(&place), [0; 5]);
}
