//! `smalti evaluate`.

use serde_json::Value;

use crate::{Place, numbers};

fn cameras(place: &Place, words: &str) -> Vec<Value> {
    let document = place.document(&format!("evaluate --json {words}"));
    document["cameras"].as_array().unwrap().clone()
}

fn number(v: &Value, pointer: &str) -> f64 {
    v.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer} of {v}"))
}

const NOISE: &str = "/luminance_noise_percent/mean";
const MTF: &str = "/mtf50_cy_per_mm";
const FIGURES: [&str; 13] = [
    "/delta_e_76/mean",
    "/delta_e_2000/mean",
    MTF,
    "/mtf50_cy_per_px",
    NOISE,
    "/saturated_percent",
    "/aliasing_percent",
    "/color_aliasing_percent",
    "/dynamic_range_db",
    "/mtf50_low_contrast_cy_per_px",
    "/vora_value",
    "/sensitivity_metamerism_index",
    "/metamer_mismatch_percent",
];

#[test]
fn scores_have_all_their_keys_with_and_without_cache() {
    let own = Place::new();
    let words = "evaluate bayer rgbw --luminance 75,5 --json --seed 9 -o o";
    let fresh = own.ok(words);
    assert!(!own.names("cache").is_empty());
    assert_eq!(fresh, own.ok(words), "from the cache");
    assert_eq!(fresh, own.ok(&format!("{words} --no-cache --threads 1")));
    assert_eq!(fresh.as_bytes(), own.read("o/results.json"));
    let pictures = ["aliasing.png", "edge.png", "macbeth.png", "zone-plate.png"];
    for folder in ["bayer-75-cd-m2", "bayer-5-cd-m2", "rgbw-75-cd-m2", "rgbw-5-cd-m2"] {
        assert_eq!(own.names(&format!("o/{folder}")), pictures);
    }
    assert_eq!(own.names("o").len(), 6);
    let document: Value = serde_json::from_str(&fresh).unwrap();
    assert_eq!(document["illuminant"], "D65");
    let all = document["cameras"].as_array().unwrap();
    let runs = [("bayer", 75.0), ("bayer", 5.0), ("rgbw", 75.0), ("rgbw", 5.0)];
    assert_eq!(all.len(), runs.len());
    for (c, (name, cd_m2)) in all.iter().zip(runs) {
        assert_eq!((&c["camera"], number(c, "/luminance_cd_m2")), (&name.into(), cd_m2));
        for (key, patches) in [("delta_e_76", 24), ("delta_e_2000", 24), ("luminance_noise_percent", 6)] {
            let scores = numbers(&c[key]["per_patch"]);
            assert_eq!(scores.len(), patches, "{key}");
            let mean = scores.iter().sum::<f64>() / patches as f64;
            assert!((number(&c[key], "/mean") - mean).abs() < 1e-12, "{key}");
        }
        FIGURES.iter().for_each(|f| assert!(number(c, f).is_finite()));
        for key in ["macbeth_s", "edge_s", "zone_plate_s"] {
            assert_eq!(c["exposure"][key], 0.1);
        }
        assert_eq!((&c["seed"], &c["description"]["name"]), (&9.into(), &name.into()));
    }
    assert!(number(&all[1], NOISE) > 2.0 * number(&all[0], NOISE), "less light, more noise");
    let table = own.ok("evaluate bayer --luminance 75 --seed 9");
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 11, "{table}");
    assert_eq!(lines[0], "Exposure time: 100 ms, as set in the camera.");
    assert!(lines[2].contains("ΔE2000") && lines[2].contains("MTF50 cy/mm") && lines[4].starts_with("bayer"));
    assert!(lines[4].contains(&format!("{:.2}", number(&all[0], "/delta_e_2000/mean"))), "{table}");
    // Resolution is read beside the noise, and the colorimetry of the sensor does not depend on the luminance.
    assert!(lines[5].contains("MTF50") && lines[5].contains("without noise"), "{table}");
    assert_eq!(lines[7], "Colorimetry of the sensor under D65:");
    assert!(lines[8].contains("Vora value") && lines[8].contains("SMI") && lines[10].starts_with("bayer"));
    assert!(lines[10].contains(&format!("{:.3}", number(&all[0], "/vora_value"))), "{table}");
    assert_eq!(all[0]["sensitivity_metamerism_index"], all[1]["sensitivity_metamerism_index"]);
}

/// A mark says that an MTF50 is no resolution, and is explained where it occurs only.
#[test]
fn an_mtf50_that_is_no_resolution_is_marked() {
    let place = Place::new();
    // All colours in every pixel through a sharp lens.
    place.write("sharp.toml", "name = \"sharp\"\n[optics]\nf_number = 1.4\n[sensor]\narchitecture = \"prism\"\n[sensor.pixel]\nfill_factor = 0.3\n");
    let [sharp, bayer] = &cameras(&place, "sharp.toml bayer --exposure own -o o")[..] else { panic!() };
    assert!(number(sharp, "/mtf50_cy_per_px") > 0.5, "{sharp}");
    assert_eq!(sharp["mtf50_reliability"], "beyond-nyquist");
    assert_eq!(bayer["mtf50_reliability"], "reliable");
    let shown = format!("{:.3} *", number(sharp, "/mtf50_cy_per_px"));
    let table = place.ok("evaluate sharp.toml bayer --exposure own");
    assert!(table.contains(&shown) && table.contains("\n* MTF50 lies beyond"), "{table}");
    assert!(!place.ok("evaluate bayer").contains('*'));
    let page = String::from_utf8(place.read("o/report.html")).unwrap();
    assert!(page.contains(&shown) && page.contains("* MTF50 lies beyond"), "the page has no mark");
}

#[test]
fn scores_follow_the_physics() {
    let place = Place::new();
    let camera = |words: &str| cameras(&place, words).remove(0);
    let base = camera("bayer");
    // Eight times the light within the same swing: photon noise falls by √8, no more.
    let noise = |words: &str| number(&camera(words), NOISE);
    let (dim, lit, bright) =
        (noise("bayer --luminance 5"), number(&base, NOISE), noise("bayer --luminance 80"));
    assert!(dim > lit && lit > bright, "{dim} {lit} {bright}");
    // An automatic exposure gathers the same light: times go with the cone's solid angle.
    // The description states a time, which an override cannot take back: a camera of its own.
    place.write("auto.toml", "name = \"auto\"\n[exposure]\nauto = \"mean\"\n");
    let time =
        |n: &str| number(&camera(&format!("auto.toml --set optics.f_number={n}")), "/exposure/macbeth_s");
    let (wide, narrow) = (time("2"), time("4"));
    assert!((narrow / wide - 65.0 / 17.0).abs() < 0.05, "{narrow} {wide}");
    // Larger pixels resolve less.
    let coarse = camera("bayer --set sensor.pixel.pitch_um=4.4");
    assert!(number(&coarse, MTF) < 0.8 * number(&base, MTF));
    // With all colours in every pixel there is nothing to interpolate.
    let prism = camera("bayer --set sensor.architecture=prism");
    let colour = "/color_aliasing_percent";
    assert!(
        number(&prism, colour) < 0.01 * number(&base, colour),
        "{} {}",
        prism[&colour[1..]],
        base[&colour[1..]]
    );
    assert!(number(&prism, MTF) > number(&base, MTF));
    // Colour is a matter of filters and light, not of the arrangement.
    let de = "/delta_e_2000/mean";
    assert!((number(&prism, de) - number(&base, de)).abs() < 0.02);
    assert_ne!(number(&base, de), number(&camera("bayer --illuminant A"), de));
}

#[test]
fn every_cfa_has_finite_scores() {
    let place = Place::new();
    let list: Vec<Value> = serde_json::from_str(&place.ok("list cfas --json")).unwrap();
    assert!(list.len() >= 40);
    let names: Vec<&str> = list.iter().map(|c| c["name"].as_str().unwrap()).collect();
    // One process for all: cameras that differ in their pattern alone.
    for name in &names {
        place.write(&format!("cfa-{name}.toml"), format!("name = \"{name}\"\n[sensor.cfa]\npattern = \"{name}\"\n[sensor]\nquantum_efficiency = {{ builtin = \"silicon\" }}\n"));
    }
    let files: Vec<String> = names.iter().map(|n| format!("cfa-{n}.toml")).collect();
    // The cameras have no infrared cut, which notes about clear channels tell.
    let scores = cameras(&place, &format!("-q {}", files.join(" ")));
    for (name, c) in names.iter().zip(&scores) {
        assert_eq!(c["camera"], *name);
        FIGURES.iter().for_each(|f| assert!(number(c, f).is_finite(), "{name} {f}"));
        assert!(number(c, NOISE) > 0.1 && number(c, NOISE) < 30.0, "{name}: {} % noise", number(c, NOISE));
        let (least, most) = match *name {
            // One or two kinds of pixel cannot tell three dimensions of colour.
            "mono" => (10.0, 30.0),
            "rccc" => (5.0, 30.0),
            _ => (0.1, 4.0),
        };
        let de = number(c, "/delta_e_2000/mean");
        assert!((least..most).contains(&de), "{name}: {de}");
        let mtf50 = number(c, "/mtf50_cy_per_px");
        assert!((0.02..0.6).contains(&mtf50), "{name}: {mtf50}");
    }
    let of = |name: &str| &scores[names.iter().position(|n| *n == name).unwrap()];
    assert!(number(of("mono"), "/aliasing_percent") < 0.1, "no mosaic, no aliasing of one");
}

#[test]
fn cameras_of_one_name_or_a_hostile_one_keep_to_the_folder() {
    let own = Place::new();
    own.write("a.toml", "name = \"../../same\"\n");
    own.write("b.toml", "name = \"../../same\"\n[optics]\nf_number = 8\n");
    own.ok("evaluate a.toml b.toml -o out/deep/er --luminance 75");
    assert_eq!(own.names("out"), ["deep"]);
    assert_eq!(own.names("out/deep"), ["er"]);
    assert_eq!(own.names("out/deep/er").len(), 4, "{:?}", own.names("out/deep/er"));
}

#[test]
fn what_fails_writes_nothing() {
    let own = Place::new();
    for (words, expected) in [
        ("evaluate bayer bayr -o o", "did you mean 'bayer'?"),
        (
            "evaluate bayer --luminance 75,0 -o o",
            "bayer at 0 cd/m²: luminance_cd_m2 is 0; expected 1e-6 to 1e12",
        ),
        ("evaluate bayer --illuminant D66 -o o", "did you mean 'D65'?"),
    ] {
        let run = own.run(&words.split(' ').collect::<Vec<_>>());
        assert_eq!((run.code, run.out.as_str()), (1, ""), "{}", run.err);
        assert!(run.err.contains(expected), "{}", run.err);
        assert!(own.names("o").is_empty());
    }
    own.write("file", "x");
    let run = own.run(&["evaluate", "bayer", "-o", "file"]);
    assert_eq!(run.code, 1);
    assert!(run.err.contains("file: it is a file; expected a folder"), "{}", run.err);
}

/// A target that cannot be measured names the cause, not the property of the edge that it lacks.
#[test]
fn the_cause_of_a_target_that_cannot_be_measured_is_named() {
    let place = Place::new();
    for (words, expected) in [
        // The white channel is nearly a sum of the others, and nothing limits the factors of the matrix.
        (
            "evaluate rgbw --set isp.color_noise_percent=0",
            &["the colour matrix amplifies noise", "`isp.color_noise_percent` is 0", "such as 0.3"][..],
        ),
        (
            "evaluate rgbw --luminance 1 --set isp.color_noise_percent=0",
            &["the colour matrix amplifies noise"],
        ),
        (
            "evaluate phone --luminance 10 --exposure 33",
            &["100 % of the samples", "saturate in 33 s", "at most", " ms"],
        ),
        ("evaluate bayer --luminance 0.0001", &["too dark", "electrons in 100 ms", "expected more light"]),
    ] {
        let run = place.run(&words.split(' ').collect::<Vec<_>>());
        assert_eq!((run.code, run.out.as_str()), (1, ""), "{words}: {}", run.err);
        expected.iter().for_each(|e| assert!(run.err.contains(e), "{words}: no {e} in {}", run.err));
        assert!(!run.err.contains("straight edge") || words.contains("color_noise"), "{}", run.err);
    }
    // The command of the README, with which the noise is several times that of the default.
    let [plain] = &cameras(&place, "rgbw --set isp.color_noise_percent=0.01")[..] else { panic!() };
    let [default] = &cameras(&place, "rgbw")[..] else { panic!() };
    assert!(number(plain, NOISE) > 3.0 * number(default, NOISE));
    assert!(number(plain, "/delta_e_2000/mean") < number(default, "/delta_e_2000/mean"));
    // A time without a unit that may be meant in milliseconds.
    let note = |words: &str| place.run(&words.split(' ').collect::<Vec<_>>()).err;
    let bare = note("evaluate bayer --luminance 1 --exposure 1");
    assert!(bare.contains("note: --exposure 1 is a time of 1 s; 1ms"), "{bare}");
    assert_eq!(note("evaluate bayer --luminance 1 --exposure 1s"), "");
}

#[test]
fn clipping_and_the_part_of_learned_kernels_are_told() {
    let place = Place::new();
    let clipped = place.ok("evaluate bayer --luminance 75,1500 -o o");
    let note = "ΔE contains the errors of clipped patches: bayer at 1500 cd/m². A shorter exposure";
    assert!(clipped.contains(note), "{clipped}");
    let page = String::from_utf8(place.read("o/report.html")).unwrap();
    assert!(page.contains(note) && !page.contains("learned kernels"), "the page has no note");
    let text = place.ok("evaluate bayer --luminance 75");
    assert!(!text.contains("clipped patches") && !text.contains("learned kernels"), "{text}");
}

/// Cameras that are the same but for their names, and values that are given twice.
#[test]
fn what_is_given_twice_is_told() {
    let place = Place::new();
    let err = |words: &str, code: i32| {
        let run = place.run(&words.split(' ').collect::<Vec<_>>());
        assert_eq!(run.code, code, "{words}: {}", run.err);
        run.err
    };
    let note =
        "note: bayer@quad-bayer and rgbw@quad-bayer are identical cameras: their scores do not differ\n";
    assert!(err("evaluate bayer rgbw --cfa quad-bayer", 0).contains(note));
    assert!(err("evaluate bayer bayer", 0).contains("1-bayer and 2-bayer are identical cameras"));
    assert_eq!(err("evaluate bayer bayer -q", 0), "");
    assert_eq!(err("evaluate bayer rgbw", 0), "");
    assert!(err("evaluate bayer --luminance 10,10", 1).contains("--luminance: 10 is given twice"));
    assert!(err("compare bayer --luminance 1,80,1.0 -o o", 1).contains("--luminance: 1 is given twice"));
    let scenes = "compare bayer --scene macbeth --scene macbeth -o o";
    assert!(err(scenes, 1).contains("--scene: macbeth is given twice"));
}

/// Quantities that the user states in electrons are compared in electrons, as stated.
#[test]
fn differences_are_in_the_units_of_the_user() {
    let place = Place::new();
    let electrons = "[sensor]\ndsnu_e = 1\n[sensor.pixel]\nread_noise_e = 2\ndark_current_e_per_s = 5\nconversion_gain_uv_per_e = 70\n";
    place.write("mine.toml", format!("name = \"mine\"\n{electrons}[exposure]\ntime_ms = 100\n"));
    let text = place.ok("evaluate bayer mine.toml");
    let row = |key: &str| {
        let line = text.lines().find(|l| l.starts_with(key)).unwrap_or_else(|| panic!("no {key} in {text}"));
        line.split_whitespace().skip(1).map(str::to_owned).collect::<Vec<_>>()
    };
    // Those of bayer are 1.4 mV, 1.34 mV and 10 µV/s at 200 µV per electron.
    assert_eq!(row("sensor.dsnu_e"), ["7", "1"]);
    assert_eq!(row("sensor.pixel.read_noise_e"), ["6.7", "2"]);
    assert_eq!(row("sensor.pixel.dark_current_e_per_s"), ["0.05", "5"]);
    assert!(!text.contains("_mv ") && !text.contains("voltage_v_per_s"), "{text}");
}
