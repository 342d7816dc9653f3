//! `smalti compare`. Cameras are noisy and of few wavelengths, so that there is little to learn from; all tests share one cache.

use std::path::PathBuf;
use std::sync::OnceLock;

use serde_json::Value;
use smalti::l3::Pipeline;
use smalti_io::ReadOptions;
use smalti_io::{l3, picture};

use crate::{Place, Run};

/// Noise that leaves two exposures to learn from, seven wavelengths, a small sensor.
pub(crate) const QUICK: &str = "--set sensor.pixel.read_noise_mv=100 --set wavelengths_nm=[400,50,700] \
    --set sensor.rows=96 --set sensor.cols=96";
pub(crate) const LEAVES: &str = "dead-leaves?rows=96&cols=96&largest=60";

/// A cache with what the cameras of these tests have learned.
fn cache() -> PathBuf {
    static CACHE: OnceLock<tempfile::TempDir> = OnceLock::new();
    let cache = CACHE.get_or_init(|| {
        let dir = tempfile::tempdir().unwrap();
        let place = Place::new();
        let words = format!("compare bayer rgbw --scene {LEAVES} --luminance 80 -o o {QUICK}");
        let run = place.command().env("SMALTI_CACHE_DIR", dir.path()).args(words.split_whitespace()).output();
        assert!(run.unwrap().status.success());
        dir
    });
    cache.path().to_owned()
}

fn run(place: &Place, words: &str) -> Run {
    let mut command = place.command();
    command.env("SMALTI_CACHE_DIR", cache()).args(words.split_whitespace()).args(QUICK.split_whitespace());
    Run::of(&mut command)
}

pub(crate) fn ok(place: &Place, words: &str) -> String {
    let run = run(place, words);
    assert_eq!((run.code, run.err.as_str()), (0, ""), "smalti {words}");
    run.out
}

fn table(place: &Place, name: &str) -> Pipeline {
    l3::read_table(&place.path(name)).unwrap()
}

#[test]
fn the_table_the_files_and_the_figures_agree() {
    let place = Place::new();
    let words = format!("compare bayer rgbw --scene {LEAVES} --luminance 5,80 -o o");
    let text = ok(&place, &words);
    let lines: Vec<&str> = text.lines().collect();
    // The verdict comes first: for each light the three metrics of pictures.
    assert!(lines[0].starts_with("Verdict. One scene with 3 noise realisations"), "{text}");
    for name in ["  5 cd/m²", "  80 cd/m²"] {
        let at = lines.iter().position(|l| *l == name).unwrap();
        for (line, metric) in lines[at + 1..].iter().zip(["CPSNR", "ΔE2000", "S-CIELAB"]) {
            assert!(line.trim_start().starts_with(metric), "{text}");
            assert!(
                ["leads ", "no difference that these scenes can show", "no relevant difference"]
                    .iter()
                    .any(|words| line.contains(words)),
                "{text}"
            );
        }
    }
    let conditions = lines.iter().position(|l| l.starts_with("Exposure time: ")).unwrap();
    let lines = &lines[conditions..];
    assert_eq!(lines[0], "Exposure time: 100 ms, as set in each camera.");
    assert_eq!(lines[2].split("  ").filter(|c| !c.is_empty()).count(), 12, "{text}");
    let rows: Vec<[&str; 3]> = lines[4..8]
        .iter()
        .map(|l| l.split_whitespace().take(3).collect::<Vec<_>>().try_into().unwrap())
        .collect();
    let expected = [["bayer", "l3", "5"], ["rgbw", "l3", "5"], ["bayer", "l3", "80"], ["rgbw", "l3", "80"]];
    assert_eq!(rows, expected);
    let files = [
        "bayer-kernels.png",
        "bayer.l3",
        "report.html",
        "results.json",
        "rgbw-kernels.png",
        "rgbw.l3",
        "side-by-side",
    ];
    assert_eq!(place.names("o"), files);
    let pictures = [
        "dead-leaves-5-cd-m2-differences.png",
        "dead-leaves-5-cd-m2.png",
        "dead-leaves-80-cd-m2-differences.png",
        "dead-leaves-80-cd-m2.png",
    ];
    assert_eq!(place.names("o/side-by-side"), pictures);

    let results = place.json("o/results.json");
    for key in ["smalti_version", "illuminant", "seed", "results", "light_gains", "learned", "cameras"] {
        assert!(results.get(key).is_some(), "{key}");
    }
    let entries = results["results"].as_array().unwrap();
    assert_eq!(entries.len(), 4);
    for entry in entries {
        let row = lines[4..8].iter().find(|l| {
            let words: Vec<&str> = l.split_whitespace().collect();
            words[0] == entry["camera"] && words[2].parse::<f64>().unwrap() == entry["luminance_cd_m2"]
        });
        let row: Vec<&str> = row.unwrap().split_whitespace().collect();
        let shown = |key: &str, digits: usize| format!("{:.digits$}", entry[key].as_f64().unwrap());
        assert_eq!(row[3], shown("cpsnr_db", 2));
        assert_eq!(row[4], shown("pixel_delta_e_2000_mean", 2));
        assert_eq!(row[5], shown("scielab_mean", 2));
        for pointer in [
            "/targets/mtf50_cy_per_mm",
            "/targets/mtf50_reliability",
            "/targets/mtf50_low_contrast_cy_per_mm",
            "/targets/visual_snr/median",
            "/scenes/0/scores",
        ] {
            assert!(entry.pointer(pointer).is_some(), "{pointer}");
        }
    }
    let cpsnr = |i: usize| entries[i]["cpsnr_db"].as_f64().unwrap();
    assert!(cpsnr(1) > cpsnr(0), "more light, a better picture");
    assert_eq!(results["learned"][1]["camera"], "rgbw");
    assert_eq!(results["cameras"][1]["name"], "rgbw");

    // The pictures hold what they say: the reference and two renderings, 48 pixels of each in cells of 120, 20 apart, below a
    // title, above their captions. Built-in scenes have two samples to a pixel, so that detail beyond the sensor's reach is
    // there.
    let read = |name: &str| picture::read(&place.path(name), &ReadOptions::default()).unwrap().image;
    let row = read("o/side-by-side/dead-leaves-80-cd-m2.png");
    assert_eq!(row.cols(), 3 * 120 + 4 * 20);
    let plane = row.planes().plane(1).unwrap();
    let part = |rows: std::ops::Range<usize>, from: usize| {
        rows.flat_map(|r| plane[r * row.cols() + from..][..48].to_vec()).collect::<Vec<f32>>()
    };
    let mean = |from: usize| part(58..106, from).iter().sum::<f32>() / (48.0 * 48.0);
    let [reference, bayer, rgbw] = [56, 196, 336].map(mean);
    assert!(
        (bayer - reference).abs() < 0.05 && (rgbw - reference).abs() < 0.05,
        "{reference} {bayer} {rgbw}"
    );
    assert!(reference < 0.9, "not the background");
    for from in [56, 196, 336] {
        assert!(part(110..150, from).iter().any(|v| *v < 0.4), "a caption below");
    }
    // The maps are in the colours of viridis, whose red is never as bright as the paper: a row for each camera, two maps each.
    let maps = read("o/side-by-side/dead-leaves-80-cd-m2-differences.png");
    assert_eq!(maps.cols(), 2 * 120 + 3 * 20);
    let colored = |r: usize, c: usize| {
        let [r, g, b] = [0, 1, 2].map(|p| maps.planes().plane(p).unwrap()[r * maps.cols() + c]);
        (r - b).abs() > 0.02 || (g - b).abs() > 0.02
    };
    for from in [56, 196] {
        let rows = (0..maps.rows()).filter(|r| (from..from + 48).all(|c| colored(*r, c))).count();
        assert!((96 + 10..96 + 16).contains(&rows), "two maps and the colours, not {rows} rows");
    }
    let drawn = read("o/bayer-kernels.png");
    assert!(drawn.rows() > 2 * 5 * 28 && drawn.cols() > 3 * 5 * 28);
    for entry in entries {
        let db = entry.pointer("/scenes/0/fixed_point_psnr_db").unwrap().as_f64().unwrap();
        assert!(db > 60.0, "{db}");
    }
    assert!(
        text.contains("\nPSNR of fixed point (16-bit samples and kernels) against single precision: "),
        "{text}"
    );
    assert_eq!(table(&place, "o/rgbw.l3").channel_names(), ["R", "G", "W", "B"]);

    // From the cache or not, on any number of threads: the same bits.
    let json = ok(&place, &format!("{words} --json"));
    assert_eq!(json.as_bytes(), place.read("o/results.json"));
    assert_eq!(serde_json::from_str::<Value>(&json).unwrap(), results);
    let fresh = ok(&place, &format!("{words} --json --threads 1 --no-cache"));
    assert_eq!(fresh, json, "without the cache, on one thread");
}

#[test]
fn ways_of_processing_stand_beside_each_other_where_they_are_defined() {
    let place = Place::new();
    let all = "--processing malvar2004,bilinear,hamilton-adams1997,bilinear";
    let words = format!("compare bayer rgbw --scene {LEAVES} --luminance 80 {all} -o o");
    let got = run(&place, &words);
    assert_eq!(got.code, 0);
    assert_eq!(
        got.err,
        "note: rgbw malvar2004 is left out, since the method is defined for Bayer mosaics only; l3 and bilinear are defined for any mosaic\n\
         note: rgbw hamilton-adams1997 is left out, since the method is defined for Bayer mosaics only; l3 and bilinear are defined for any mosaic\n"
    );
    let ways: Vec<String> = got
        .out
        .lines()
        .skip_while(|l| !l.starts_with("Exposure time: "))
        .skip(4)
        .take(4)
        .map(|l| l.split_whitespace().take(2).collect::<Vec<_>>().join(" "))
        .collect();
    assert_eq!(ways, ["bayer malvar2004", "bayer bilinear", "bayer hamilton-adams1997", "rgbw bilinear"]);
    let results = place.json("o/results.json");
    assert_eq!(results["left_out"], serde_json::json!(["rgbw malvar2004", "rgbw hamilton-adams1997"]));
    assert_eq!(results["cameras"].as_array().unwrap().len(), 2);
    // Nothing was learned, so no table is written.
    assert_eq!(place.names("o"), ["report.html", "results.json", "side-by-side"]);
    assert_eq!(run(&place, &format!("{words} --quiet")).err, "");
    // A prism has every channel everywhere: nothing to learn, but to compare.
    let prism = format!("compare bayer --scene {LEAVES} --luminance 80 --set sensor.architecture=prism -o p");
    ok(&place, &format!("{prism} --processing bilinear"));
}

#[test]
fn cameras_and_scenes_of_one_name_are_numbered() {
    let place = Place::new();
    let scenes = "--scene dead-leaves?rows=48&cols=48&largest=30 --scene dead-leaves?rows=48&cols=48&largest=30&seed=9";
    let run = run(&place, &format!("compare bayer bayer {scenes} --luminance 80 --processing l3 -o o"));
    assert_eq!(run.err, "note: 1-bayer and 2-bayer are identical cameras: their scores do not differ\n");
    let text = run.out;
    assert!(String::from_utf8(place.read("o/report.html")).unwrap().contains("The cameras are identical."));
    assert!(text.contains("\n1-bayer") && text.contains("\n2-bayer"), "{text}");
    let files = [
        "1-bayer-kernels.png",
        "1-bayer.l3",
        "2-bayer-kernels.png",
        "2-bayer.l3",
        "report.html",
        "results.json",
        "side-by-side",
    ];
    assert_eq!(place.names("o"), files);
    let numbered =
        ["1", "2"].map(|n| ["-differences", ""].map(|what| format!("{n}-dead-leaves-80-cd-m2{what}.png")));
    assert_eq!(place.names("o/side-by-side"), numbered.as_flattened());
    assert!(place.read("o/1-bayer.l3") == place.read("o/2-bayer.l3"));
    let r = &place.json("o/results.json")["results"];
    assert_eq!((&r[0]["camera"], &r[0]["cpsnr_db"]), (&"1-bayer".into(), &r[1]["cpsnr_db"]));
}

/// A second comparison in the same folder leaves nothing of the first, and all else that lies there.
#[test]
fn files_of_an_earlier_comparison_go() {
    let place = Place::new();
    let scene = "--scene dead-leaves?rows=48&cols=48&largest=30";
    ok(&place, &format!("compare bayer rgbw {scene} --luminance 80,20 -o o"));
    place.write("o/mine.png", "kept");
    place.write("o/side-by-side/mine.png", "kept");
    place.write("mine.l3", "kept");
    ok(&place, &format!("compare rgbw {scene} --luminance 20 -o o"));
    let own = ["mine.png", "report.html", "results.json", "rgbw-kernels.png", "rgbw.l3", "side-by-side"];
    assert_eq!(place.names("o"), own);
    let pictures = ["dead-leaves-20-cd-m2-differences.png", "dead-leaves-20-cd-m2.png", "mine.png"];
    assert_eq!(place.names("o/side-by-side"), pictures);
    // Names that lead elsewhere are not believed.
    let hostile = r#"{"files": ["../mine.l3", "side-by-side/../mine.png", "side-by-side", ".", 7]}"#;
    place.write("o/results.json", hostile);
    ok(&place, &format!("compare rgbw {scene} --luminance 20 -o o"));
    assert_eq!((place.names("o"), place.read("mine.l3")), (own.map(String::from).to_vec(), b"kept".to_vec()));
}

#[test]
fn a_name_alone_is_the_scene_of_the_built_in_set() {
    let place = Place::new();
    ok(&place, "compare bayer --scene macbeth --luminance 80 --processing bilinear -o o");
    let results = place.json("o/results.json");
    assert_eq!(results.pointer("/results/0/scenes/0/scene").unwrap(), "macbeth?patch=128");
}

/// Cameras with automatic exposure would take different times; the table states the common time and what else differs.
#[test]
fn cameras_with_rules_of_their_own_are_compared_at_equal_times() {
    let place = Place::new();
    let words = format!("compare phone table1 --scene {LEAVES} --luminance 5 --processing bilinear -o o");
    let text = ok(&place, &words);
    assert!(text.contains("\nThe cameras differ in more than the colour filter array:\nkey "), "{text}");
    assert!(text.contains("\noptics.f_number ") && !text.contains("\nexposure.auto"), "{text}");
    assert!(
        text.contains("at most 0.5 % of the samples of any camera saturate, and at most 33 ms. Noise saturates further samples"),
        "{text}"
    );
    let results = place.json("o/results.json");
    assert_eq!(results["exposure"]["policy"], "equal");
    let time = |camera: usize| results["results"][camera]["scenes"][0]["scores"]["exposure_time_s"].clone();
    assert_eq!((time(0), time(1)), (0.033.into(), 0.033.into()));
    let page = std::fs::read_to_string(place.path("o/report.html")).unwrap();
    assert!(page.contains("Differences between the cameras besides the colour filter array"));
    let own = ok(&place, &format!("{words} --exposure own"));
    assert!(
        own.contains("Exposure time: automatic, by the rule of each camera; the tables state the times."),
        "{own}"
    );
    let results = place.json("o/results.json");
    let time = |camera: usize| results["results"][camera]["scenes"][0]["scores"]["exposure_time_s"].as_f64();
    assert!(time(0) != time(1) && time(1) > Some(0.033));
    let fixed = run(&place, &format!("{words} --exposure 0.2 --json"));
    assert!(fixed.out.contains("\"exposure_time_s\": 0.2"), "{}", fixed.out + &fixed.err);
    let refused = run(&place, &format!("{words} --exposure long"));
    assert!(
        refused.code == 2
            && refused
                .err
                .contains("own, equal, auto-equal or a time above 0, such as 0.03 (seconds) or 30ms")
    );
    let refused = run(&place, &format!("{words} --max-saturated 100"));
    assert!(refused.code == 2 && refused.err.contains("expected percent, 0 to less than 100"));
}

/// One camera with a small well makes the times of all too short; short times keep their digits, and those of chart and edge are
/// stated.
#[test]
fn the_camera_that_limits_equal_times_is_named() {
    let place = Place::new();
    let small = "name = \"tiny\"\n[sensor.pixel]\nfull_well_e = 90\n[exposure]\ntime_ms = 100\n";
    place.write("tiny.toml", small);
    let words = format!(
        "compare bayer tiny.toml --scene {LEAVES} --luminance 800 --processing bilinear --set sensor.pixel.read_noise_mv=0.1 \
         --set sensor.dsnu_mv=0 --set wavelengths_nm=[400,50,700] -o o"
    );
    let text = place.ok(&format!("{words} --exposure equal"));
    assert!(text.contains("tiny saturates first and limits the exposure times, which could be"), "{text}");
    let results = place.json("o/results.json");
    assert_eq!(results["exposure"]["limited_by"]["camera"], "tiny");
    assert!(results["exposure"]["limited_by"]["factor"].as_f64().unwrap() > 10.0);
    let time_s = &results["results"][1]["scenes"][0]["scores"]["exposure_time_s"];
    let time_ms = 1e3 * time_s.as_f64().unwrap();
    assert!(time_ms < 1.0, "{time_ms}");
    let cells = text.lines().find(|l| l.starts_with("tiny ") && l.contains("bilinear")).unwrap();
    let digits = if time_ms < 0.1 { 4 } else { 3 };
    assert!(cells.contains(&format!(" {time_ms:.digits$} ")), "{time_ms}: {cells}");
    assert!(text.contains("At 800 cd/m², MTF50 is measured with an exposure of 0."), "{text}");
    let own = place.ok(&format!("{words} --exposure 0.1ms"));
    assert!(!own.contains("saturates first") && !own.contains("MTF50 is measured with an exposure"), "{own}");
}

/// Where the times that one camera limits are too short for another one, the error names both and what would mend it.
#[test]
fn cameras_that_cannot_be_exposed_equally_are_named() {
    let place = Place::new();
    place.write("tiny.toml", "name = \"tiny\"\n[sensor.pixel]\nfull_well_e = 5\nread_noise_e = 1\n");
    for words in [
        format!("compare tiny.toml bayer --scene {LEAVES} --processing bilinear -o o"),
        "evaluate bayer tiny.toml".into(),
    ] {
        let words = format!("{words} --luminance 10 --exposure equal --set wavelengths_nm=[400,50,700]");
        let refused = place.run(&words.split_whitespace().collect::<Vec<_>>());
        assert_eq!(refused.code, 1, "{}", refused.err);
        for part in [
            "bayer at 10 cd/m²: the ColorChecker is too dark",
            "; tiny saturates first and limits the equal exposure times, which could be",
            "compare without it, or with the own exposure times of the cameras",
        ] {
            assert_eq!(refused.err.matches(part).count(), 1, "{part} in {}", refused.err);
        }
    }
}

/// A camera without any processing that is left is in no table of differences, and a clear channel is not green.
#[test]
fn cameras_that_are_left_out_are_not_compared() {
    let place = Place::new();
    let words = format!("--scene {LEAVES} --luminance 80 --processing malvar2004 -o o");
    let one = run(&place, &format!("compare bayer rgbw {words} --set optics.f_number=4"));
    assert_eq!(one.code, 0, "{}", one.err);
    place.write("dim.toml", "name = \"dim\"\n[sensor.cfa]\npattern = \"rgbw\"\n[optics]\nf_number = 8\n[exposure]\ntime_ms = 100\n");
    let left = run(&place, &format!("compare bayer dim.toml {words}"));
    assert!(left.err.contains("note: dim malvar2004 is left out"), "{}", left.err);
    assert!(!left.out.contains("differ in more") && !left.out.contains("optics.f_number"), "{}", left.out);
    let clear = run(&place, &format!("compare bayer@rccb bayer {words}"));
    let note = "note: bayer@rccb malvar2004: the method takes channel C for the green of a Bayer mosaic";
    assert!(clear.err.contains(note) && !clear.err.contains("note: bayer malvar2004"), "{}", clear.err);
}

#[test]
fn the_light_gain_is_a_table_and_json() {
    let place = Place::new();
    let scene = "dead-leaves?rows=48&cols=48&largest=30";
    let words = format!(
        "compare bayer rgbw --scene {scene} --luminance 20 --processing bilinear --light-gain --seeds 2 -o o"
    );
    let text = ok(&place, &words);
    assert!(
        text.contains("Additional light for bayer bilinear to match rgbw bilinear at 20 cd/m²"),
        "{text}"
    );
    assert!(text.contains("over its four captures of the chart."), "{text}");
    let results = place.json("o/results.json");
    let gain = &results["light_gains"][0];
    assert_eq!(gain["needs_more_light"], "bayer bilinear");
    assert_eq!(gain["to_equal"], "rgbw bilinear");
    let metrics = gain.pointer("/gains/metrics").unwrap().as_array().unwrap();
    assert_eq!(metrics.len(), 5);
    // Table and gain are of the same pictures.
    for (metric, name) in metrics.iter().zip(["cpsnr_db", "pixel_delta_e_2000_mean", "scielab_mean"]) {
        assert_eq!(metric["metric"], name);
        assert_eq!(
            (&metric["own"], &metric["target"]),
            (&results["results"][0][name], &results["results"][1][name])
        );
    }
    let of_chart = ["/targets/visual_snr/median", "/targets/luminance_noise_percent/mean"];
    for (metric, path) in metrics[3..].iter().zip(of_chart) {
        let rows = [0, 1].map(|i| results["results"][i].pointer(path).unwrap());
        assert_eq!([&metric["own"], &metric["target"]], rows, "{path}");
    }
    let headings = ["CPSNR dB", "ΔE2000", "S-CIELAB", "visual SNR", "noise %"];
    for (m, heading) in metrics.iter().zip(headings) {
        assert!(m["own"].is_number() && m["target"].is_number() && m["gain"].is_object(), "{m}");
        let interval = &m["interval"];
        assert!(interval["low"].is_object() && interval["high"].is_object(), "{m}");
        let line = text.lines().find(|l| l.starts_with(heading) && l.contains(" stops")).unwrap();
        assert!(line.contains(" stops [") && line.contains(']'), "{line}");
    }
}

#[test]
fn files_are_scenes_too() {
    let place = Place::new();
    place.ok("convert macbeth?patch=8 -o chart.png");
    let text = ok(&place, "compare bayer --scene chart.png --luminance 80 --processing bilinear -o o");
    assert!(text.contains("means over one scene and 3 seeds"), "{text}");
    assert_eq!(place.names("o/side-by-side"), ["chart-80-cd-m2-differences.png", "chart-80-cd-m2.png"]);
}

/// That a run of bad words fails with one line, with these words, and leaves nothing.
fn refused(words: &str, code: i32, expected: &[&str]) {
    let place = Place::new();
    place.write("file", "kept");
    let run = run(&place, words);
    assert_eq!((run.code, run.out.as_str()), (code, ""), "{words}: {}", run.err);
    for e in expected {
        assert!(run.err.contains(e), "{words}: no {e} in {}", run.err);
    }
    // A second line says what is built in.
    assert!(code == 2 || run.err.lines().count() <= 2, "{words}: {}", run.err);
    assert!(place.names("out").is_empty(), "{words}: {:?}", place.names("out"));
    assert_eq!(place.read("file"), b"kept");
}

#[test]
fn what_cannot_be_compared_is_refused_before_work() {
    for (words, code, expected) in [
        ("compare bayer --light-gain", 1, &["--light-gain", "two or more"][..]),
        ("compare bayer --luminance 0", 2, &["'0'", "--luminance", "above 0"]),
        ("compare bayer --luminance 1,-5", 2, &["'-5'", "--luminance", "above 0"]),
        ("compare bayer --luminance nan", 2, &["'nan'", "--luminance"]),
        ("compare bayer --levels 0", 2, &["'0'", "--levels", "1 to 256"]),
        ("compare bayer --patch 4", 2, &["'4'", "--patch", "3, 5, 7, 9, 11"]),
        ("compare bayer --alpha-flat 16", 2, &["'16'", "--alpha-flat", "luminance,chrominance"]),
        ("compare bayer --alpha-flat 16,x,4", 2, &["'16,x,4'", "--alpha-flat"]),
        ("compare bayer --alpha-texture -1,4", 2, &["'-1,4'", "--alpha-texture", "0 to 1e6"]),
        ("compare bayer --smoothing 1.5", 2, &["'1.5'", "--smoothing", "0 to 1"]),
        ("compare bayer --processing fancy", 2, &["'fancy'", "malvar2004"]),
        ("compare bayr", 1, &["bayr: no such camera", "did you mean 'bayer'?"]),
        ("compare @rgbw", 1, &["@rgbw: no such camera"]),
        ("compare bayer --scene portrait", 1, &["did you mean 'natural-portrait'?", "photo-fig"]),
        (
            "compare bayer --scene photo-fig --exposure 33s",
            1,
            &["saturate in 33 s", "expected an exposure time of at most"],
        ),
        ("compare bayer --illuminant D66", 1, &["did you mean 'D65'?"]),
        (
            "compare bayer --scene dead-leafs --luminance 80",
            1,
            &["dead-leafs", "did you mean 'dead-leaves'?"],
        ),
        ("compare bayer --scene no.exr --luminance 80", 1, &["cannot read no.exr"]),
        // Before any scene is read.
        ("compare rgbw --processing malvar2004 --scene no.exr", 1, &["nothing is left to compare"]),
        (
            "compare bayer --scene macbeth?patch=8 --set sensor.architecture=prism",
            1,
            &["bayer", "prism", "mosaics"],
        ),
        (
            "compare bayer --scene macbeth?patch=8 --set sensor.architecture=field-sequential",
            1,
            &["field-sequential", "mosaics"],
        ),
    ] {
        let quick = if words.contains("--luminance") || code == 2 { "" } else { " --luminance 80" };
        let quiet = if words.contains("malvar2004") { " -q" } else { "" };
        refused(&format!("{words}{quick}{quiet} -o out"), code, expected);
    }
    refused("compare bayer -o file", 1, &["file: it is a file; expected a folder"]);
    refused("compare bayer -o file/in", 1, &["cannot write file/in"]);
    #[cfg(target_os = "linux")]
    refused("compare bayer -o /proc/out", 1, &["cannot write /proc/out"]);
}
