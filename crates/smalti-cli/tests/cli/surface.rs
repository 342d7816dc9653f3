//! What every command shares: help, lists, completion, exit codes, which stream holds what.

use std::io::Read;
use std::process::Stdio;

use serde_json::Value;

use crate::Place;

#[test]
fn every_list_is_text_and_json() {
    let place = Place::new();
    for (what, known, least) in [
        ("scenes", "zone-plate", 12),
        ("cfas", "quad-bayer", 40),
        ("cameras", "bayer", 7),
        ("illuminants", "D65", 9),
        ("filters", "nikon-d5100/R", 20),
        ("metrics", "mtf50_cy_per_mm", 15),
    ] {
        let json: Vec<Value> = serde_json::from_str(&place.ok(&format!("list {what} --json"))).unwrap();
        let names: Vec<&str> = json.iter().map(|e| e["name"].as_str().unwrap()).collect();
        assert!(names.len() >= least && names.contains(&known), "{what}: {names:?}");
        let text = place.ok(&format!("list {what}"));
        assert!(names.iter().all(|n| text.lines().any(|l| l.split(' ').next() == Some(n))), "{what}");
    }
    // What is listed can be used.
    let cameras: Vec<Value> = serde_json::from_str(&place.ok("list cameras --json")).unwrap();
    for camera in &cameras {
        let name = camera["name"].as_str().unwrap();
        place.write("own.toml", camera["toml"].as_str().unwrap());
        place.ok(&format!(
            "simulate {name} --scene uniform?size=8 --set sensor.rows=30 --set sensor.cols=40 -o a -q"
        ));
        place
            .ok("simulate own.toml --scene uniform?size=8 --set sensor.rows=30 --set sensor.cols=40 -o b -q");
        assert!(place.read("a/raw.dng") == place.read("b/raw.dng"), "{name} from its own file");
    }
    let lights: Vec<Value> = serde_json::from_str(&place.ok("list illuminants --json")).unwrap();
    for light in &lights {
        let light = light["name"].as_str().unwrap();
        place.ok(&format!("convert uniform?size=2 --illuminant {light} -o light.npy"));
    }
}

#[test]
fn help_shows_examples_and_units() {
    let place = Place::new();
    assert_eq!(place.ok("--version"), format!("smalti {}\n", env!("CARGO_PKG_VERSION")));
    let help = place.ok("--help");
    for word in [
        "Examples:",
        "smalti simulate bayer",
        "simulate",
        "evaluate",
        "list",
        "convert",
        "completions",
        "Exit code",
    ] {
        assert!(help.contains(word), "{word}");
    }
    for (command, words) in [
        ("simulate", ["Examples:", "cd/m²", "degrees", "--set <KEY=VALUE>", "--seed", "[default: 1]"]),
        ("evaluate", ["Examples:", "cd/m²", "--json", "--set <KEY=VALUE>", "results.json", "[default: 75]"]),
        (
            "compare",
            ["Examples:", "cd/m²", "--light-gain", "results.json", "[default: 1,80]", "side-by-side"],
        ),
        (
            "train",
            ["Examples:", "--pair <RAW> <PICTURE>", "--continue", "--c-header", "--solver", "safetensors"],
        ),
        ("render", ["Examples:", "--pipeline <FILE.l3>", "--fixed", ".npy", "nearest class", "--gain"]),
        ("convert", ["Examples:", ".exr", "nm", "fichet2021", "pbrt", "400:10:700"]),
        ("report", ["Examples:", "smalti sweep table2", "report.json", "cycles/mm", "FOLDER", "--json"]),
        ("rate", ["Examples:", "init", "serve", "analyse", "--experiment bayer-light", "intervals"]),
        ("rate init", ["Examples:", "--stops", "--side <PX>", "cd/m²", "experiment.json", "--quality"]),
        ("rate serve", ["Examples:", "--port", "token", "Ctrl-C", "--json", "observers"]),
        ("rate analyse", ["Examples:", "JOD", "--keep-all", "results.json", "scale.csv", "--json"]),
        ("list", ["Examples:", "scenes", "cfas", "illuminants", "metrics", "--json"]),
        ("show", ["Examples:", "smalti show rgbw", "--as <KIND>", "NO_COLOR", "sixel", "--toml"]),
        ("completions", ["Examples:", "bash", "zsh", "fish", "smalti completions bash", "SHELL"]),
    ] {
        let help = place.ok(&format!("{command} --help"));
        words.iter().for_each(|w| assert!(help.contains(w), "{command} --help has no {w}:\n{help}"));
    }
    // A heading of a group of options is not that of the options after it.
    let compare = place.ok("compare --help");
    let (general, learning) = compare.split_once("Learning:").unwrap();
    for option in ["--json", "--output", "--set", "--no-cache"] {
        assert!(general.contains(option) && !learning.contains(&format!(" {option} ")), "{option}");
    }
}

#[test]
fn every_column_of_the_tables_is_a_listed_metric() {
    let place = Place::new();
    let metrics = place.ok("list metrics");
    for (command, headings) in [
        ("compare", &["CPSNR dB", "ΔE2000", "S-CIELAB", "MTF50 cy/mm", "visual SNR", "noise %"][..]),
        (
            "evaluate",
            &["ΔE76", "ΔE2000", "MTF50 cy/mm", "MTF50 cy/px", "noise %", "aliasing %", "saturated %"],
        ),
        ("evaluate", &["MTF50 4:1 cy/px", "Vora value", "SMI", "metamer mismatch %"]),
    ] {
        for heading in headings {
            assert!(metrics.contains(&format!("'{heading}' in smalti {command}")), "{heading} in {metrics}");
        }
    }
}

#[test]
fn wrong_usage_is_two_and_failure_is_one() {
    let place = Place::new();
    for words in [
        "",
        "simulte",
        "simulate",
        "evaluate",
        "list",
        "list foo",
        "convert macbeth",
        "completions tcsh",
        "simulate bayer --bits 12",
        "simulate bayer --noise some",
        "simulate bayer --sed 1",
        "simulate bayer --seed x",
        "simulate bayer --set pitch",
        "simulate bayer --set =1",
        "evaluate bayer --luminance a",
        "compare",
        "compare bayer --processing none",
        "train bayer",
        "train -o a.l3",
        "render a.dng -o a.png",
        "render a.dng --pipeline a.l3",
        "list cfas --threads 0",
    ] {
        let run = place.run(&words.split_whitespace().collect::<Vec<_>>());
        assert_eq!((run.code, run.out.as_str()), (2, ""), "{words}");
        assert!(run.err.contains("Usage") || run.err.contains("--help"), "{words}: {}", run.err);
    }
    let run = place.run(&["simulte"]);
    assert!(run.err.contains("a similar subcommand exists: 'simulate'"), "{}", run.err);
    for words in [
        "simulate bayr",
        "evaluate no.toml",
        "convert macbet -o a.npy",
        "compare bayr",
        "train no.toml -o a.l3",
        "render no.dng --pipeline no.l3 -o a.png",
    ] {
        let run = place.run(&words.split(' ').collect::<Vec<_>>());
        assert_eq!((run.code, run.out.as_str()), (1, ""), "{words}");
        assert!(run.err.starts_with("error: "), "{}", run.err);
    }
    assert!(place.names("").is_empty());
}

#[test]
fn a_reader_that_has_seen_enough_is_no_failure() {
    let place = Place::new();
    // Longer than a pipe holds, so that the write must meet the closed end.
    let mut child = place
        .command()
        .args(["list", "cfas", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut err = String::new();
    child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    assert_eq!((child.wait().unwrap().code(), err.as_str()), (Some(0), ""));
}

#[test]
fn quiet_is_silent_and_results_stay() {
    let place = Place::new();
    let small = "--scene uniform?size=8 --set sensor.rows=30 --set sensor.cols=40";
    assert!(place.ok(&format!("simulate bayer {small} -o o --quiet")).starts_with("o/rendered.png"));
    assert!(place.ok("convert uniform?size=8 -o o/a.npy -q").contains("a.npy"));
    let json = place.ok(&format!("simulate bayer {small} -o o -q --json"));
    assert!(serde_json::from_str::<Value>(&json).is_ok(), "one document and nothing else");
}
