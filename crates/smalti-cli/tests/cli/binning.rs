//! Binned cameras and cameras with two conversion gains in every command.

use serde_json::Value;
use smalti_io::{Limits, dng};

use crate::Place;
use crate::compare::{LEAVES as SCENE, QUICK};
use crate::learn::{EXPOSURES, LEAVES, OTHER, SMALL};

/// Numbers that are written as texts.
fn numbers_in(texts: &Value) -> Vec<f64> {
    texts.as_array().unwrap().iter().map(|t| t.as_str().unwrap().parse().unwrap()).collect()
}

/// A sensor of 96 × 96 pixels is simulated, trained for, rendered and shown; its raw file has 48 × 48 samples.
#[test]
fn a_binned_sensor_is_simulated_learned_and_shown() {
    let place = Place::new();
    for (mode, white) in [("charge", 16383.0), ("digital", 65532.0)] {
        let camera = format!("bayer@quad-bayer --set sensor.binning={mode} {SMALL}");
        place.ok(&format!("simulate {camera} {OTHER} -o {mode}"));
        let metrics = place.json(&format!("{mode}/metrics.json"));
        assert_eq!((&metrics["raw"]["rows"], &metrics["raw"]["cols"]), (&48.into(), &48.into()), "{metrics}");
        let raw = dng::read(&place.path(&format!("{mode}/raw.dng")), Limits::default()).unwrap().raw;
        assert_eq!((raw.rows(), raw.cols(), raw.white_level()), (48, 48, white));
        let text = place.ok(&format!("show {camera}"));
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains(&format!("48 × 48 samples of 2 × 2 pixels each ({mode} binning)")), "{text}");
        let derived = place.document(&format!("show {camera} --json"));
        let value = |name: &str| {
            let all = derived["derived"].as_array().unwrap();
            all.iter().find(|d| d["name"] == name).unwrap()["value"].as_f64().unwrap()
        };
        assert_eq!(derived["description"]["sensor"]["binning"], mode);
        let single = place.document(&format!("show bayer@quad-bayer {SMALL} --json"));
        let of_single = |name: &str| {
            let all = single["derived"].as_array().unwrap();
            all.iter().find(|d| d["name"] == name).unwrap()["value"].as_f64().unwrap()
        };
        let near = |name: &str, factor: f64| {
            assert!((value(name) / of_single(name) / factor - 1.0).abs() < 1e-9, "{mode} {name}");
        };
        near("width of the sensor", 1.0);
        near("Nyquist frequency", 0.5);
        near("read noise", if mode == "charge" { 1.0 } else { 2.0 });

        let table = format!("{mode}.l3");
        place.ok(&format!(
            "train {camera} {LEAVES} {EXPOSURES} --patch 3 --levels 2 --textures none -o {table}"
        ));
        place.ok(&format!("render {mode}/raw.dng --pipeline {table} -o {mode}/learned.png -q"));
    }
    // A file with the key is the same camera.
    let own = place.ok("show bayer@quad-bayer --toml");
    place.write("camera.toml", own.replace("[sensor]\n", "[sensor]\nbinning = \"charge\"\n"));
    place.ok(&format!("simulate camera.toml {SMALL} {OTHER} -o again"));
    let raw =
        |folder: &str| dng::read(&place.path(&format!("{folder}/raw.dng")), Limits::default()).unwrap().raw;
    assert!(raw("again") == raw("charge"));
    place.ok(&format!("simulate camera.toml {SMALL} --set sensor.binning=none {OTHER} -o none"));
    assert_eq!(place.json("none/metrics.json")["raw"]["rows"], 96);
}

/// One sensor without binning, with charge and with digital binning: camera files in one comparison, at equal exposure.
#[test]
fn a_sensor_is_compared_with_itself() {
    let place = Place::new();
    let own = place.ok("show phone-quad --toml");
    for mode in ["none", "charge", "digital"] {
        let text = own.replace("[sensor]\n", &format!("[sensor]\nbinning = \"{mode}\"\n"));
        place.write(&format!("{mode}.toml"), text);
    }
    let words = format!(
        "compare none.toml charge.toml digital.toml --processing bilinear --scene {SCENE} --luminance 1 {QUICK} \
         --set sensor.pixel.read_noise_mv=3 --json -o o"
    );
    let results = place.document(&words);
    let text = results.to_string();
    assert!(text.contains("sensor.binning"), "{text}");
    // Equally many samples of twice the pitch see more of the scene.
    let difference = |key: &str| {
        let all = results["differences"].as_array().unwrap();
        all.iter().find(|d| d["key"] == key).unwrap()["values"].clone()
    };
    assert_eq!(difference("sample pitch, µm"), serde_json::json!(["1.20", "2.40", "2.40"]));
    let views: Vec<f64> = numbers_in(&difference("field of view of 1000 samples, degrees"));
    assert!(views[1] > 1.9 * views[0] && views[1] == views[2], "{views:?}");
    let page = String::from_utf8(place.read("o/report.html")).unwrap();
    assert!(page.contains("field of view of 1000 samples, degrees") && page.contains("equally many samples"));
    let entries = results["results"].as_array().unwrap();
    let cpsnr: Vec<f64> = entries.iter().map(|e| e["cpsnr_db"].as_f64().unwrap()).collect();
    assert!(cpsnr.len() == 3 && cpsnr[0] < cpsnr[2] && cpsnr[2] < cpsnr[1], "{cpsnr:?}");
    place.ok("evaluate charge.toml --luminance 5 -o e");
}

/// A study of a camera with binning: its mosaics are those of the samples.
#[test]
fn a_study_may_have_a_binned_camera() {
    let place = Place::new();
    place.write(
        "study.toml",
        "name = \"binned\"\ncamera = \"phone-quad-binned\"\ncolors = [3]\n[sample]\nfilters = 2\nmosaics = 2\n\
         [filters.gaussian_grid]\n[mosaics.tile]\nrows = 2\ncols = 2\n[conditions.grid]\nluminance_cd_m2 = [5]\n\
         \"sensor.binning\" = [\"charge\", \"digital\"]\n",
    );
    let text = place.ok("sweep study.toml -o study");
    assert!(text.contains("is complete"), "{text}");
    place.ok("report study");
}

/// A camera with two conversion gains in every command, and with `auto` where no pipeline is learned.
#[test]
fn two_conversion_gains_are_used_by_every_command() {
    let place = Place::new();
    let gains = format!(
        "--set sensor.pixel.low_conversion_gain_uv_per_e=50 --set sensor.pixel.low_gain_read_noise_e=6 \
         --set sensor.pixel.full_well_e=300000 {SMALL}"
    );
    let with = |gain: &str| format!("bayer@quad-bayer {gains} --set exposure.conversion_gain={gain}");
    let raw =
        |folder: &str| dng::read(&place.path(&format!("{folder}/raw.dng")), Limits::default()).unwrap().raw;
    let white = |folder: &str| raw(folder).white_level();
    for gain in ["high", "low", "auto", "combined"] {
        place.ok(&format!("simulate {} {OTHER} --luminance 2000 -o {gain}", with(gain)));
        let text = place.ok(&format!("show {}", with(gain)));
        assert!(text.contains("conversion_gain") && text.contains("low_conversion_gain_uv_per_e"), "{text}");
    }
    assert!(raw("auto") == raw("low") && raw("auto") != raw("high"));
    assert!(white("combined") > 2.0 * white("high"), "{}", white("combined"));
    let combined = with("combined");
    place.ok(&format!(
        "train {combined} {LEAVES} {EXPOSURES} --patch 3 --levels 2 --textures none -o both.l3"
    ));
    place.ok("render combined/raw.dng --pipeline both.l3 -o both.png -q");
    place.ok(&format!("simulate {combined} --set sensor.binning=charge {OTHER} -o binned"));
    place.ok(&format!(
        "compare {} --processing bilinear --scene {SCENE} --luminance 1,1000 {QUICK} -o c",
        with("auto")
    ));
    for (words, expected) in [
        (format!("train {} {LEAVES} -o no.l3", with("auto")), "expected high, low or combined"),
        (format!("simulate {combined} --set sensor.binning=digital {OTHER} -o no"), "charge binning"),
        (
            format!("simulate bayer --set exposure.conversion_gain=low {OTHER} -o no"),
            "low_conversion_gain_uv_per_e",
        ),
    ] {
        let run = place.run(&words.split_whitespace().collect::<Vec<_>>());
        assert!(run.code == 1 && run.err.contains(expected), "{words}: {}", run.err);
    }
}

#[test]
fn a_mosaic_that_cannot_be_binned_is_refused() {
    let place = Place::new();
    place.ok("show phone-quad-binned@bayer --set sensor.binning=none");
    for (words, expected) in [
        ("bayer --set sensor.binning=charge", &["sensor.binning", "quad-bayer"][..]),
        ("phone-quad --set sensor.binning=analog", &["binning", "charge"]),
        (
            "phone-quad-binned@bayer",
            &["phone-quad-binned@bayer: `sensor.binning`", "--set sensor.binning=none"],
        ),
        ("phone-quad --set sensor.binning=charge --set sensor.rows=97", &["sensor.rows", "96"]),
        (
            "phone-quad --set sensor.binning.side=3 --set sensor.binning.mode=charge",
            &["sensor.binning", "side of 2"],
        ),
    ] {
        let args: Vec<&str> = ["show"].into_iter().chain(words.split(' ')).collect();
        let run = place.run(&args);
        assert_eq!(run.code, 1, "{words}: {}", run.out);
        // The file of a built-in camera is not at hand.
        assert!(!words.contains('@') || !run.err.contains("phone-quad-binned:"), "{}", run.err);
        expected.iter().for_each(|e| assert!(run.err.contains(e), "{words}: no {e} in {}", run.err));
    }
}
