//! `smalti design`: the search as a command, its files and its errors.

use serde_json::Value;

use super::Place;

/// So small that it takes seconds: one mosaic, patches of 3 × 3, few starts.
const SMALL: &str = "camera = \"bayer\"\ncolors = [3]\nluminances_cd_m2 = [10]\nrivals = false\n\
    [filters.pigments]\n[mosaics]\ngiven = [[\"bc\", \"ab\"]]\n\
    [search]\nstarts = 2\nsteps = 10\n[light]\nside = 3\nmax_components = 4\nstep_px = 8\n";

#[test]
fn a_design_becomes_a_camera_that_other_commands_take() {
    let place = Place::new();
    place.write("small.toml", SMALL);
    let printed = place.ok("design small.toml -o best --no-pipeline --training-set catalog");
    for word in ["small: one mosaic searched", "the camera's own", "smalti compare best/camera.toml", "bc/ab"]
    {
        assert!(printed.contains(word), "{word} is missing in\n{printed}");
    }
    let results = place.json("best/results.json");
    let best = &results["searched"][0];
    assert!(best["cost"].as_f64().unwrap() < results["own"]["cost"].as_f64().unwrap(), "{results}");
    assert_eq!(best["transmittances"].as_array().unwrap().len(), 3);
    assert!(place.read("best/filters.csv").starts_with(b"wavelength_nm,A,B,C\n"));
    assert!(place.read("best/mosaic.svg").starts_with(b"<svg"));
    assert!(place.read("best/mosaic.png").starts_with(b"\x89PNG"));
    let shown = place.document("show best/camera.toml --json");
    assert_eq!(shown["name"], "small");
    // The same search gives the same files.
    place.ok("design small.toml -o again --no-pipeline --training-set catalog --threads 1");
    for file in ["camera.toml", "filters.csv", "mosaic.svg", "mosaic.png"] {
        assert_eq!(place.read(&format!("best/{file}")), place.read(&format!("again/{file}")), "{file}");
    }
}

/// The mosaic of a camera that bins is that of its samples: its files have a block of photodiodes for each cell.
#[test]
fn a_camera_that_bins_and_has_crosstalk_is_designed() {
    let place = Place::new();
    let camera = "camera = \"phone-quad-binned\"\nset = { \"sensor.crosstalk_percent\" = 2 }";
    place.write("binned.toml", SMALL.replace("camera = \"bayer\"", camera).replace("bc", "ac"));
    place.ok("design binned.toml -o best --no-pipeline --training-set catalog");
    let toml = String::from_utf8(place.read("best/camera.toml")).unwrap();
    assert!(toml.contains("side = 2"), "{toml}");
    let (own, found) =
        (place.document("show phone-quad-binned --json"), place.document("show best/camera.toml --json"));
    let (own, found) = (&own["description"]["sensor"], &found["description"]["sensor"]);
    let pattern: Vec<&str> =
        found["cfa"]["pattern"].as_array().unwrap().iter().map(|row| row.as_str().unwrap()).collect();
    let is_of_pairs = |row: &&str| row.len() == 4 && row[..1] == row[1..2] && row[2..3] == row[3..];
    assert!(pattern.len() == 4 && pattern.iter().all(is_of_pairs), "{pattern:?}");
    assert!(pattern[0] == pattern[1] && pattern[1] != pattern[2] && pattern[2] == pattern[3], "{pattern:?}");
    assert_eq!(found["rows"], own["rows"]);
}

/// Noise that leaves two exposures to learn from, few wavelengths, and small scenes.
const QUICK: &str = "[set]\n\"sensor.pixel.read_noise_mv\" = 100\nwavelengths_nm = [400, 50, 700]\n";

#[test]
fn a_proof_is_a_comparison_with_the_rivals() {
    let place = Place::new();
    place
        .write("small.toml", SMALL.replace("[filters.pigments]", &(QUICK.to_owned() + "[filters.pigments]")));
    let scenes =
        "--proof-scene dead-leaves?rows=64&cols=64&largest=40 --proof-scene macbeth?patch=8 --seeds 2";
    let options = "--training-set catalog --patch 3 --proof-patch 3";
    let printed = place.ok(&format!("design small.toml -o best --no-pipeline --prove {scenes} {options}"));
    for words in [
        "small: one mosaic searched",
        "Proof. small does not beat its one rival",
        "under other conditions",
        "illuminant LED",
        "filters −5 nm",
    ] {
        assert!(printed.contains(words), "{words} is missing in\n{printed}");
    }
    let proof = place.json("best/proof/results.json");
    let compared = place.json("best/proof/comparison/results.json");
    let found = &proof["proofs"][0]["found"];
    assert_eq!(found["label"], "small");
    // The figures are those of `compare` for the same camera, scenes and seeds.
    for (means, place) in [(found, 0), (&proof["proofs"][0]["rivals"][0], 1)] {
        let of_comparison = &compared["results"][place];
        for (i, key) in ["cpsnr_db", "pixel_delta_e_2000_mean", "scielab_mean"].into_iter().enumerate() {
            let (a, b) = (means["means"][0][i].as_f64().unwrap(), of_comparison[key].as_f64().unwrap());
            assert!((a - b).abs() < 1e-9, "{key}: {a} and {b}");
        }
    }
    let rows = proof["robustness"]["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 10);
    assert_eq!(rows[0]["found"], found["means"]);
    for lead in proof["proofs"][0]["rivals"][0]["leads"][0].as_array().unwrap() {
        let (alone, together) = (&lead["by"]["interval"], &lead["simultaneous"]);
        assert!(together["low"].as_f64().unwrap() <= alone["low"].as_f64().unwrap(), "{lead}");
    }
    let page = String::from_utf8(place.read("best/design.html")).unwrap();
    assert!(page.contains("id=\"proof\"") && page.contains("proof/comparison/report.html"));
    // The proof of a finished search gives the same results, here from the cache of scores.
    let text = place.read("best/proof/results.json");
    let again = place.ok(&format!("design best --prove {scenes} {options} --json"));
    assert_eq!(again.as_bytes(), text);
    // A new search removes the page of the proof of the former array.
    let search = ["design", "small.toml", "-o", "best", "--no-pipeline", "--training-set", "catalog", "-q"];
    assert_eq!(place.run(&search).code, 0);
    let page = String::from_utf8(place.read("best/design.html")).unwrap();
    assert!(page.contains("best --prove") && !page.contains("id=\"proof\""));
    let run = place.run(&["design", "best"]);
    assert!(run.code == 1 && run.err.contains("folder of a finished search"), "{}", run.err);
    std::fs::create_dir(place.path("empty")).unwrap();
    let run = place.run(&["design", "empty", "--prove"]);
    assert!(run.code == 1 && run.err.contains("no results of a search"), "{}", run.err);
}

/// Two aims and the number of filters, three compromises for each number.
const FRONT: &str = "[front]\npoints = 3\nfilters = true\n[[front.aims]]\nname = \"noise\"\ncpsnr_db = 1\n[[front.aims]]\nname = \"colour\"\ndelta_e_2000 = 1\n";

#[test]
fn a_search_goes_on_from_its_log_and_its_light() {
    let place = Place::new();
    let small = SMALL
        .replace("colors = [3]", "colors = [3, 4]")
        .replace("[[\"bc\", \"ab\"]]", "[[\"bc\", \"ab\"], [\"bc\", \"ad\"]]");
    place.write("small.toml", small + FRONT);
    let options = "--no-pipeline --training-set catalog";
    let printed = place.ok(&format!("design small.toml -o best {options}"));
    assert!(printed.contains("The front: ") && printed.contains("front/1.toml"), "{printed}");
    let points = place.json("best/results.json")["front"]["points"].as_array().unwrap().clone();
    let costs: Vec<Vec<f64>> =
        points.iter().map(|p| serde_json::from_value(p["costs"].clone()).unwrap()).collect();
    // The last cost is the number of filters. Fewer filters stay beside more, and no point is surpassed in everything.
    for filters in [3, 4] {
        let of = |p: &&Value| p["design"]["filters"] == filters;
        assert!(points.iter().any(|p| of(&p)), "{points:?}");
        assert!(points.iter().filter(of).all(|p| p["costs"][2] == f64::from(filters)));
    }
    let surpasses = |a: &Vec<f64>, b: &Vec<f64>| a != b && a.iter().zip(b).all(|(a, b)| a <= b);
    assert!(costs.iter().all(|b| !costs.iter().any(|a| surpasses(a, b))), "{costs:?}");
    assert!(points.len() > 1 && place.path(&format!("best/front/{}.toml", points.len())).exists());
    let page = String::from_utf8(place.read("best/design.html")).unwrap();
    assert!(page.contains("id=\"front\""));
    // As after a kill: the first parts of the search, and a line that is not whole.
    let log = String::from_utf8(place.read("best/search.jsonl")).unwrap();
    let cut: String = log.lines().take(2).map(|l| l.to_owned() + "\n").collect::<String>() + &log[..30];
    std::fs::create_dir(place.path("resumed")).unwrap();
    std::fs::write(place.path("resumed/search.jsonl"), cut).unwrap();
    let run = place.run(&[
        "design",
        "small.toml",
        "-o",
        "resumed",
        "--no-pipeline",
        "--light",
        "best/light/D65.light",
    ]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.err.contains("1 part of the search is that of an earlier run"), "{}", run.err);
    for file in ["camera.toml", "filters.csv", "front/1.toml", "light/D65.light", "search.jsonl"] {
        assert_eq!(place.read(&format!("best/{file}")), place.read(&format!("resumed/{file}")), "{file}");
    }
    // Statistics hold for one lens.
    place.write("other.toml", SMALL.replace("[filters", "[set]\n\"optics.f_number\" = 8\n[filters"));
    let run = place.run(&["design", "other.toml", "-o", "other", "--light", "best/light/D65.light"]);
    assert!(run.code == 1 && run.err.contains("no file has the light of D65"), "{}", run.err);
    let scenes = "--scene macbeth?patch=8 --scene dead-leaves?rows=64&cols=64&largest=40";
    place.ok(&format!("design small.toml -o own {options} {scenes}"));
    assert_eq!(place.json("own/results.json")["light"][0]["scenes"], 2);
}

#[test]
fn wrong_design_files_name_the_key_and_the_line() {
    let place = Place::new();
    for (change, with, message) in [
        ("colors = [3]", "colors = []", "`colors`: expected at least one number of filters"),
        ("starts = 2", "starts = 0", "`search.starts`: 0; expected 1 to 100000"),
        ("steps = 10", "steps = 100001", "`search.steps`: 100001; expected 1 to 100000"),
        (
            "[search]",
            "[annealing]\nmoves = 1000001\n[search]",
            "`annealing.moves`: 1000001; expected 1 to 1000000",
        ),
        ("side = 3", "side = 4", "`light.side`: 4; expected 3, 5, 7 or 9 pixels"),
        (
            "luminances_cd_m2 = [10]",
            "luminances_cd_m2 = [0]",
            "`luminances_cd_m2`: 0; expected numbers above 0",
        ),
        ("[filters.pigments]", "[filters.pigments]\nmax_thickness = 0", "filters.pigments.max_thickness"),
        ("[filters.pigments]", "[filters.pigments]\nlibrary = [{ flat = 0 }]", "it transmits no light"),
        ("given = [[\"bc\", \"ab\"]]", "given = [[\"ab\", \"ba\"]]", "no mosaic has [3] filters"),
        (
            "given = [[\"bc\", \"ab\"]]",
            "tile = { rows = 400, cols = 300 }",
            "400 × 300 cells; expected 1 to 1024",
        ),
        ("starts = 2", "stars = 2", "did you mean `starts`?"),
        (
            "[search]",
            "[rules]\nleast_distance_px = 1.5\n[search]",
            "none of the 1 mosaics of 3 filters fulfils it",
        ),
        (
            "[search]",
            "[rules]\nkept = [\"a.\", \"..\"]\n[search]",
            "cells are kept in the tile of `mosaics.tile`",
        ),
        ("[search]", "[tolerance]\nshift_nm = -1\n[search]", "`tolerance.shift_nm`: -1; expected 0 to 50 nm"),
        (
            "[search]",
            "[front]\n[[front.aims]]\nname = \"a\"\ncpsnr_db = 1\n[search]",
            "`front.aims`: 1 aims; expected 2 or 3",
        ),
        (
            "[filters.pigments]",
            "[filters.measured]\nlibrary = [{ flat = 0.5 }]",
            "one filter leaves nothing to choose",
        ),
    ] {
        assert!(SMALL.contains(change), "{change}");
        place.write("wrong.toml", SMALL.replace(change, with));
        let run = place.run(&["design", "wrong.toml", "-o", "wrong", "--no-pipeline"]);
        assert_eq!(run.code, 1, "{with}");
        assert!(run.err.contains(message), "{with}:\n{}", run.err);
    }
    assert!(!place.path("wrong").exists());
    let run = place.run(&["design", "pigments-9"]);
    assert!(run.code == 1 && run.err.contains("did you mean 'pigments-"), "{}", run.err);
    assert_eq!(place.run(&["design"]).code, 2);
}
