//! `smalti simulate`.

use smalti::sensor::{RawSamples, Sampling};
use smalti_io::ReadOptions;
use smalti_io::dng::{self, Dng};
use smalti_io::npy::{self, NpyData};
use smalti_io::{Limits, picture, stages};

use crate::{Place, numbers, python};

const SMALL: &str = "--set sensor.rows=48 --set sensor.cols=64";

fn raw(place: &Place, folder: &str) -> Dng {
    dng::read(&place.path(folder).join("raw.dng"), Limits::default()).unwrap()
}

fn picture_of(place: &Place, folder: &str) -> picture::Picture {
    picture::read(&place.path(folder).join("rendered.png"), &ReadOptions::default()).unwrap()
}

/// That the raw file holds what the stages say the sensor gave.
fn assert_raw_is_the_stage(place: &Place, folder: &str) -> Dng {
    let dng = raw(place, folder);
    let stage = npy::read(&place.path(folder).join("3-raw.npy"), Limits::default()).unwrap();
    let raw = &dng.raw;
    assert_eq!(stage.shape, [raw.sampling().planes(), raw.rows(), raw.cols()], "{folder}");
    match (raw.samples(), &stage.data) {
        (RawSamples::Digital(a), NpyData::U16(b)) => assert!(a == b, "{folder}"),
        (RawSamples::Analog(a), NpyData::F32(b)) => assert!(a == b, "{folder}"),
        other => panic!("{folder}: {other:?}"),
    }
    let index = stages::read_index(&place.path(folder)).unwrap();
    assert_eq!(index["3-raw"].numbers["black_level"], [raw.black_level()], "{folder}");
    assert_eq!(index["3-raw"].numbers["white_level"], [raw.white_level()], "{folder}");
    dng
}

#[test]
fn every_scene_becomes_a_picture() {
    let place = Place::new();
    let scenes: Vec<serde_json::Value> = serde_json::from_str(&place.ok("list scenes --json")).unwrap();
    let small = |name: &str| match name {
        "macbeth" => "macbeth?patch=8",
        "slanted-bar" => "slanted-bar?size=64",
        "zone-plate" => "zone-plate?size=64",
        "uniform" => "uniform?size=16",
        "grey-steps" => "grey-steps?step=4&rows=40",
        "frequency-sweep" => "frequency-sweep?rows=48&cols=96",
        "frequency-orientation" => "frequency-orientation?block=8",
        "siemens-star" => "siemens-star?size=64",
        "point-grid" => "point-grid?points=4&spacing=16",
        "checkerboard" => "checkerboard?squares=4&square=12",
        "dead-leaves" => "dead-leaves?rows=48&cols=64&largest=30",
        "color-patches" => "color-patches?rows=48&cols=64",
        "gradients" => "gradients?rows=48&cols=64",
        "glossy-balls" => "glossy-balls?rows=48&cols=64",
        "hdr" => "hdr?rows=48",
        "resolution-chart" => "resolution-chart?rows=120",
        other => panic!("a new scene, {other}: give it a small form here"),
    };
    for scene in &scenes {
        let name = scene["name"].as_str().unwrap();
        // Scenes from built-in files have one size.
        let is_stored = smalti_io::rendered::find(name).is_some();
        let form = if is_stored { name } else { small(name) };
        let out = place.ok(&format!("simulate bayer --scene {form} -o {name} {SMALL}"));
        assert!(out.contains("rendered.png"), "{out}");
        assert_eq!(place.names(name), ["metrics.json", "raw.dng", "rendered.png"], "{name}");
        let (dng, shown, metrics) =
            (raw(&place, name), picture_of(&place, name), place.json(&format!("{name}/metrics.json")));
        let (rows, cols) = (dng.raw.rows(), dng.raw.cols());
        assert!(rows <= 48 && cols <= 64 && (rows >= 40 || cols >= 56), "{name}: {rows} × {cols}");
        assert_eq!((shown.image.rows(), shown.image.cols(), shown.bits), (rows, cols, 8), "{name}");
        let mean = |p: &[f32]| p.iter().sum::<f32>() / p.len() as f32;
        let brightness = shown.image.planes().planes().map(mean).sum::<f32>() / 3.0;
        // Points on black are dark; nothing else is.
        assert!(brightness > if name == "point-grid" { 0.001 } else { 0.03 }, "{name}: {brightness}");
        assert_eq!(metrics["raw"]["rows"], rows, "{name}");
        // Rendered scenes have the light that their lamps give.
        let cd_m2 = metrics["scene"]["mean_luminance_cd_m2"].as_f64().unwrap();
        let is_rendered = name.starts_with("natural-");
        assert!(
            if is_rendered { cd_m2 > 1.0 } else { (cd_m2 / 100.0 - 1.0).abs() < 1e-3 },
            "{name}: {cd_m2}"
        );
        assert!(
            metrics["picture"]["scielab_mean"].is_number() && metrics["picture"]["cpsnr_db"].is_number(),
            "{name}"
        );
    }
}

#[test]
fn stages_say_what_they_are_and_metrics_what_made_them() {
    let place = Place::new();
    let json =
        place.ok(&format!("simulate bayer --scene macbeth?patch=8 -o o --stages --json --seed 7 {SMALL}"));
    assert_eq!(json.as_bytes(), place.read("o/metrics.json"));
    let expected = [
        "1-scene-radiance.npy",
        "2-optical-image-irradiance.npy",
        "3-raw.npy",
        "4-picture-xyz.npy",
        "metrics.json",
        "raw.dng",
        "rendered.png",
        "stages.json",
    ];
    assert_eq!(place.names("o"), expected);
    let dng = assert_raw_is_the_stage(&place, "o");
    assert_eq!((dng.raw.black_level(), dng.raw.white_level()), (64.0, 16383.0));
    assert_eq!(dng.raw.channel_names(), ["R", "G", "B"]);
    assert!(matches!(dng.raw.sampling(), Sampling::Mosaic(m) if m.cells() == [0, 1, 1, 2]));
    let index = stages::read_index(&place.path("o")).unwrap();
    for (name, unit) in [
        ("1-scene-radiance", "photons s^-1 m^-2 sr^-1 nm^-1"),
        ("2-optical-image-irradiance", "photons s^-1 m^-2 nm^-1"),
        ("3-raw", "digital numbers"),
    ] {
        let stage = &index[name];
        assert_eq!(stage.unit, unit);
        assert_eq!(
            npy::read(&place.path("o").join(&stage.file), Limits::default()).unwrap().shape,
            stage.shape
        );
    }
    assert_eq!(index["1-scene-radiance"].numbers["wavelengths_nm"].len(), 31);
    assert!(index["4-picture-xyz"].unit.contains("relative"));
    let m = place.json("o/metrics.json");
    assert_eq!((&m["seed"], &m["camera"], &m["noise"]), (&7.into(), &"bayer".into(), &"all".into()));
    assert_eq!(m["exposure_time_s"], 0.1);
    // Every key is there, also those that the camera's file leaves to the defaults.
    let d = &m["description"];
    assert_eq!((&d["sensor"]["rows"], &d["sensor"]["pixel"]["temperature_c"]), (&48.into(), &25.0.into()));
    assert_eq!((&d["optics"]["model"], &d["isp"]["demosaic"]), (&"diffraction".into(), &"bilinear".into()));

    // Without --stages those of an earlier run do not stay beside another picture.
    assert!(place.path("o/2-optical-image-irradiance.npy").exists());
    place.ok(&format!("simulate bayer --scene uniform?size=8 -o o {SMALL}"));
    let left = std::fs::read_dir(place.path("o")).unwrap().map(|f| f.unwrap().file_name());
    let mut left: Vec<String> = left.map(|f| f.into_string().unwrap()).collect();
    left.sort();
    assert_eq!(left, ["metrics.json", "raw.dng", "rendered.png"]);
}

#[test]
fn architectures_mosaics_and_converters() {
    let place = Place::new();
    let scene = "--scene macbeth?patch=8 --stages";
    for architecture in ["prism", "field-sequential"] {
        place.ok(&format!(
            "simulate bayer {scene} -o {architecture} --set sensor.architecture={architecture} {SMALL}"
        ));
        let dng = assert_raw_is_the_stage(&place, architecture);
        assert_eq!(dng.raw.sampling(), &Sampling::Full { channels: 3 });
    }
    place.ok(&format!(
        "simulate bayer {scene} -o analog --set sensor.adc_bits=0 --set sensor.black_level_dn=0 {SMALL}"
    ));
    let dng = assert_raw_is_the_stage(&place, "analog");
    assert!(matches!(dng.raw.samples(), RawSamples::Analog(_)));
    assert_eq!(place.json("analog/stages.json")["3-raw"]["unit"], "V");
    for pattern in ["rgbw", "xtrans", "hirakawa2008", "mono", "multispectral-4x4"] {
        place.ok(&format!("simulate bayer {scene} -o {pattern} --set sensor.cfa.pattern={pattern} {SMALL}"));
        let dng = assert_raw_is_the_stage(&place, pattern);
        let Sampling::Mosaic(mosaic) = dng.raw.sampling() else { panic!("{pattern}") };
        assert!(dng.raw.channel_names().len() == mosaic.channels(), "{pattern}");
    }
    place.ok(&format!("simulate rgbw {scene} -o deep --bits 16 {SMALL}"));
    let shown = picture_of(&place, "deep");
    assert_eq!(shown.bits, 16);
    let low_byte = |v: &f32| !((v * 65535.0).round() as u32).is_multiple_of(257);
    assert!(shown.image.planes().data().iter().any(low_byte), "8 bits spread over 16");
}

#[test]
fn a_seed_gives_the_same_bits_on_any_number_of_threads() {
    let place = Place::new();
    let run = |folder: &str, more: &str| {
        place.ok(&format!(
            "simulate bayer --scene dead-leaves?rows=96&cols=128&largest=60 -o {folder} {more}"
        ));
        ["raw.dng", "rendered.png", "metrics.json"].map(|f| place.read(&format!("{folder}/{f}")))
    };
    let one = run("one", "--seed 3 --threads 1");
    assert!(one == run("two", "--seed 3 --threads 2"));
    assert!(one == run("one", "--seed 3 --threads 2"), "again into the same folder");
    let other = run("other", "--seed 4");
    assert!(one[0] != other[0] && one[1] != other[1]);
    let (clean_3, clean_4) = (run("clean3", "--seed 3 --noise none"), run("clean4", "--seed 4 --noise none"));
    assert!(clean_3[..2] == clean_4[..2], "expected values depend on no seed");
    assert!(run("shot", "--seed 3 --noise shot")[0] != one[0]);
    assert_ne!(one[0], clean_3[0]);
}

#[test]
fn overrides_and_settings_arrive() {
    let place = Place::new();
    let run = |more: &str| {
        place.ok(&format!(
            "simulate bayer --scene uniform?size=16 -o o --noise none --set sensor.adc_bits=16 {SMALL} {more}"
        ));
        let m = place.json("o/metrics.json");
        let f = |v: &serde_json::Value| v.as_f64().unwrap();
        (f(&m["mean_illuminance_lux"]), f(&m["exposure_time_s"]), f(&m["raw"]["mean_percent_of_saturation"]))
    };
    let (lux, time, level) = run("");
    let close = |a: f64, b: f64, rel: f64| assert!((a / b - 1.0).abs() < rel, "{a} {b}");
    let (double, _, brighter) = run("--luminance 200");
    close(double / lux, 2.0, 1e-4);
    // Half a step of the converter on a level of hundreds or more.
    close(brighter / level, 2.0, 1e-3);
    let (_, short, darker) = run("--set exposure.time_ms=50");
    close(short / time, 0.5, 1e-12);
    close(darker / level, 0.5, 1e-3);
    // 1 + 4 N² (1 + m)² at a magnification of 3.2e-3.
    let (wide, _, _) = run("--set optics.f_number=2");
    let cone = |n: f64| 1.0 + 4.0 * n * n * (1.0 + 0.003863 / (1.2 - 0.003863f64)).powi(2);
    close(wide / lux, cone(4.0) / cone(2.0), 1e-3);
    run("--illuminant A --distance 2 --fov 10");
    let m = place.json("o/metrics.json");
    assert_eq!((&m["scene"]["distance_m"], &m["scene"]["horizontal_fov_deg"]), (&2.0.into(), &10.0.into()));
    place.ok(&format!("simulate bayer --scene uniform?size=16 -o o --full-frame --fov 1 {SMALL}"));
    assert_eq!(place.json("o/metrics.json")["raw"]["cols"], 64);
}

#[test]
fn a_photograph_is_upsampled_and_photographed() {
    let place = Place::new();
    // The chart as a picture; its colours must survive picture → spectra → camera → picture.
    place.ok("convert macbeth?patch=8 -o chart.png");
    for upsampling in ["smooth", "measured"] {
        let options = format!("--upsampling {upsampling} -o o --noise none --set optics.falloff=none");
        place.ok(&format!("simulate bayer --scene chart.png {options}"));
        assert_the_chart_comes_back(&place);
    }
}

fn assert_the_chart_comes_back(place: &Place) {
    let (drawn, shown) =
        (picture::read(&place.path("chart.png"), &ReadOptions::default()).unwrap(), picture_of(place, "o"));
    // A file is not spread over more pixels than it has.
    assert_eq!((shown.image.rows(), shown.image.cols()), (drawn.image.rows(), drawn.image.cols()));
    let middle = |p: &picture::Picture, patch: usize| -> [f32; 3] {
        let (row, col) = (patch / 6 * 8 + 4, patch % 6 * 8 + 4);
        std::array::from_fn(|c| p.image.planes().plane(c).unwrap()[row * p.image.cols() + col])
    };
    // The darkest half percent clips to white: grey patches relate to the white one.
    let (white, grey) = (middle(&drawn, 18)[1], middle(&drawn, 21)[1]);
    let (seen_white, seen_grey) = (middle(&shown, 18)[1], middle(&shown, 21)[1]);
    assert!((seen_grey / seen_white - grey / white).abs() < 0.03, "{seen_grey} {seen_white} {grey} {white}");
    let [r, g, b] = middle(&shown, 14);
    assert!(r > 2.0 * g && r > 2.0 * b, "the red patch: {r} {g} {b}");
    let [r, g, b] = middle(&shown, 12);
    assert!(b > 1.5 * r && b > 1.5 * g, "the blue patch: {r} {g} {b}");
}

#[test]
fn libraw_reads_what_simulate_writes() {
    let place = Place::new();
    place.ok("simulate bayer --scene macbeth?patch=8 -o o --stages");
    let dng = assert_raw_is_the_stage(&place, "o");
    let Some(seen) = python("check_dng.py", "rawpy, tifffile, numpy", &[&place.path("o/raw.dng")]) else {
        return;
    };
    let seen = &seen[0];
    let RawSamples::Digital(samples) = dng.raw.samples() else { panic!("digital numbers") };
    assert!(numbers(&seen["samples"]).into_iter().eq(samples.iter().map(|v| f64::from(*v))));
    assert_eq!(numbers(&seen["visible"]), [dng.raw.rows() as f64, dng.raw.cols() as f64]);
    assert_eq!(seen["pattern"], serde_json::json!([["R", "G"], ["G", "B"]]));
    assert!(numbers(&seen["black"]).iter().all(|b| *b == 64.0), "{}", seen["black"]);
    assert_eq!(seen["white"], 16383);
    assert_eq!(seen["tifffile_equal"], true);
}

#[test]
fn a_spectral_scene_of_a_file_is_photographed() {
    let place = Place::new();
    place.ok("convert dead-leaves?rows=96&cols=128 --layout pbrt -o leaves.exr --quiet");
    place.ok("simulate bayer --scene leaves.exr -o o --quiet");
    let (shown, m) = (picture_of(&place, "o"), place.json("o/metrics.json"));
    assert_eq!((shown.image.rows(), shown.image.cols()), (96, 128));
    assert!((m["scene"]["mean_luminance_cd_m2"].as_f64().unwrap() - 100.0).abs() < 0.1);
    assert!(m["picture"]["cpsnr_db"].as_f64().unwrap() > 25.0, "{}", m["picture"]);
}
