//! Cameras with another mosaic, filters from one file, learned tables in every command, and clear channels that see too much.

use serde_json::Value;
use smalti_io::ReadOptions;

use crate::learn::{EXPOSURES, LEAVES, OTHER, SMALL};
use crate::{Place, Run};

/// Words separated by spaces, with notes on standard error.
fn told(place: &Place, words: &str) -> Run {
    let run = place.run(&words.split_whitespace().collect::<Vec<_>>());
    assert_eq!(run.code, 0, "smalti {words}: {}", run.err);
    run
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// Runs what must fail, with every word in the message.
fn refused(place: &Place, args: &[&str], words: &[&str]) {
    let run = place.run(args);
    assert_eq!(run.code, 1, "{args:?}: {}{}", run.out, run.err);
    words.iter().for_each(|word| assert!(run.err.contains(word), "{args:?}: no {word} in {}", run.err));
    assert!(place.names("out").is_empty(), "{args:?}");
}

#[test]
fn a_camera_has_another_mosaic_wherever_it_is_named() {
    let place = Place::new();
    let scene = format!("--scene macbeth?patch=8 {SMALL}");
    place.ok(&format!("simulate bayer@quad-bayer {scene} -o at"));
    place.ok(&format!("simulate bayer --cfa quad-bayer {scene} -o cfa"));
    place.ok(&format!("simulate bayer {scene} --set sensor.cfa.pattern=quad-bayer -o set"));
    assert_eq!(place.read("at/raw.dng"), place.read("cfa/raw.dng"));
    // The filters are generic, so that it is the camera with the pattern replaced.
    assert_eq!(place.read("at/rendered.png"), place.read("set/rendered.png"));
    assert_eq!(place.json("at/metrics.json")["camera"], "bayer@quad-bayer");
    assert_eq!(place.json("set/metrics.json")["camera"], "bayer");

    let words = format!(
        "compare bayer@quad-bayer bayer@rgbw-sony --processing bilinear --luminance 80 {LEAVES} {SMALL} -o o"
    );
    let run = told(&place, &words);
    let note =
        "note: bayer@rgbw-sony: the camera has no filter for W (white); that of the catalogue is taken\n";
    assert_eq!(run.err, note);
    assert!(run.out.contains("bayer@quad-bayer") && run.out.contains("bayer@rgbw-sony"), "{}", run.out);
    let table = told(&place, &format!("evaluate bayer rgbw --cfa xtrans {SMALL}")).out;
    assert!(table.contains("bayer@xtrans") && table.contains("rgbw@xtrans"), "{table}");
    place.ok(&format!(
        "train bayer@quad-bayer {LEAVES} {SMALL} {EXPOSURES} --patch 3 --levels 2 --textures none -o quad.l3"
    ));

    // A file of the array, as `show` prints it.
    place.write("array.toml", place.ok("show quad-bayer --toml"));
    let of_file = place.document("show machine-vision --cfa array.toml --json");
    assert_eq!(of_file["name"], "machine-vision@array");
    assert_eq!(of_file["description"]["sensor"]["cfa"]["filters"]["R"]["builtin"], "red");
    // A camera file, and its own filters.
    place.write("own.toml", place.ok("show machine-vision --toml"));
    let shown = place.document("show own.toml@quad-bayer --json");
    let cfa = &shown["description"]["sensor"]["cfa"];
    assert_eq!(
        (&cfa["pattern"], &cfa["filters"]["G"]["builtin"]),
        (
            &"quad-bayer".into(),
            &place.document("show own.toml --json")["description"]["sensor"]["cfa"]["filters"]["G"]["builtin"]
        )
    );
    // What is printed as TOML is that camera.
    place.write("quad.toml", place.ok("show own.toml@quad-bayer --toml"));
    let again = place.document("show quad.toml --json");
    assert_eq!(again["description"], shown["description"]);
}

#[test]
fn a_mosaic_that_the_camera_has_no_filters_for_says_what_would_mend_it() {
    let place = Place::new();
    let words = [
        "the letter W",
        "it has R, G, B",
        "--set 'sensor.cfa.filters.W={ file = \"W.csv\" }'",
        "curves of its own",
    ];
    refused(&place, &["simulate", "machine-vision@rgbw-sony", "-o", "out"], &words);
    let mono = "--set sensor.cfa.filters.W={builtin=\"cmv12000/mono\"}";
    let run = told(&place, &format!("show cmv12000@rgbw-sony {mono} --json"));
    assert_eq!(run.err, "");
    assert_eq!(json(&run.out)["description"]["sensor"]["cfa"]["filters"]["W"]["builtin"], "cmv12000/mono");
    // In a comparison it does not apply to the mosaic without that letter, which is told.
    let run = told(&place, &format!("show cmv12000@quad-bayer {mono} --json"));
    assert!(run.err.contains("the stated filter for W is not used"), "{}", run.err);
    // Nor to a camera that has its own mosaic, beside one that has another.
    let run = told(
        &place,
        &format!("evaluate cmv12000 cmv12000@rgbw-sony {mono} --set isp.demosaic=bilinear --luminance 80"),
    );
    let note = "cmv12000: the stated filter for W is not used, since the mosaic has no such letter";
    assert!(run.err.contains(note), "{}", run.err);
    assert!(run.out.contains("cmv12000@rgbw-sony"), "{}", run.out);

    for (args, words) in [
        (["evaluate", "quad-bayer"], &["quad-bayer: this is a mosaic", "bayer@quad-bayer is the camera"][..]),
        (["evaluate", "bayer@quad-bayr"], &["no such mosaic 'quad-bayr'", "did you mean 'quad-bayer'?"]),
        (["evaluate", "bayer@phone-quad"], &["'phone-quad' is a camera"]),
        (["evaluate", "bayer@none.toml"], &["none.toml"]),
        (["evaluate", "bayr@quad-bayer"], &["bayr: no such camera", "did you mean 'bayer'?"]),
        (["evaluate", "bayer@random?rows=x"], &["rows", "whole number"]),
    ] {
        refused(&place, &args, words);
    }
    refused(&place, &["evaluate", "bayer@xtrans", "--cfa", "quad-bayer"], &["given twice"]);
    let twice = ["evaluate", "bayer@xtrans", "--set", "sensor.cfa.pattern=rgbw"];
    refused(&place, &twice, &["--set sensor.cfa.pattern=rgbw", "given twice", "bayer@xtrans"]);
}

/// A camera file as the studio saves it: the tile in letters, and every filter.
fn saved_bands(of_a: &str) -> String {
    let band = |i: u8| match i {
        1 => format!("A = {of_a}\n"),
        i => format!("{} = {{ builtin = \"band-{i}-of-25\" }}\n", char::from(b'A' + i - 1)),
    };
    let filters: String = (1..=25).map(band).collect();
    let tile = r#"["ALWIT", "HSEKV", "OUGRD", "QCNYF", "XJPBM"]"#;
    format!("name = \"bands\"\n[sensor.cfa]\npattern = {tile}\n[sensor.cfa.filters]\n{filters}")
}

#[test]
fn a_band_is_no_white_filter_by_its_letter() {
    let place = Place::new();
    place.write("saved.toml", saved_bands("{ builtin = \"band-1-of-25\" }"));
    let run = told(&place, "show saved.toml@mono --json");
    let note = "note: bands@mono: the camera has no filter for W (white); that of the catalogue is taken\n";
    assert_eq!(run.err, note);
    place.write("mono.toml", "name = \"bands@mono\"\n[sensor.cfa]\npattern = \"mono\"\n");
    let description = |text: &str| json(text)["description"].clone();
    assert_eq!(description(&run.out), description(&place.ok("show mono.toml --json")));

    place.write("own.toml", saved_bands("{ flat = 0.4 }"));
    let words = [
        "own.toml@mono: the mosaic has the letter W (white), for which the camera has no filter",
        "W (band-23-of-25)",
        "--set 'sensor.cfa.filters.W={ file = \"W.csv\" }'",
        "bands has curves of its own",
    ];
    refused(&place, &["simulate", "own.toml@mono", "-o", "out"], &words);
}

const CAMERA: &str = "[sensor.cfa]\npattern = \"bayer\"\nfilters = { file = \"filters.csv\" }\n";

#[test]
fn one_file_holds_the_filters_of_all_letters() {
    let place = Place::new();
    place.write("camera.toml", CAMERA);
    place.write("filters.csv", "wavelength_nm,R,G,B\n400,0.1,0.2,0.9\n550,0.2,0.8,0.1\n700,0.7,0.1,0.05\n");
    let plain = place.document("show camera.toml --json");
    // The names of files stay where the text is shown.
    let text = place.ok("show camera.toml");
    assert!(text.contains("filters.csv#G") && !text.contains("values"), "{text}");
    assert!(place.ok("show camera.toml@xtrans --toml").contains("\"filters.csv#G\""));
    // As a spreadsheet of another country writes it, in percent; the file decides, and it is told.
    place.write("filters.csv", "Wellenlänge;R;G;B (%)\n400;10;20;90\n550;20;80;10\n700;70;10;5,0\n");
    let run = told(&place, "show camera.toml --json");
    let note =
        "filters.csv: columns separated by semicolons, decimal commas, values in percent, divided by 100";
    assert_eq!(run.err, format!("note: {note}\n"));
    let percent = json(&run.out);
    assert_eq!(percent["notes"], serde_json::json!([note]));
    for (a, b) in plain["channels"].as_array().unwrap().iter().zip(percent["channels"].as_array().unwrap()) {
        let values = |c: &Value| crate::numbers(&c["effective_sensitivity"]);
        assert!(values(a).iter().zip(values(b)).all(|(a, b)| (a - b).abs() < 1e-12), "{a} {b}");
    }
    assert!(told(&place, "show filters.csv#B").out.contains("peak 0.90 at 400 nm"));
    // Other mosaics take their letters from the same file; a letter beside the file takes precedence.
    place.write("filters.csv", "nm,R,G,B,W\n400,0.1,0.2,0.9,0.9\n700,0.7,0.1,0.05,0.9\n");
    let run = told(&place, "show camera.toml --json");
    assert!(
        run.err.contains("filters.csv: the column W is not used, since the mosaic has R, G, B"),
        "{}",
        run.err
    );
    let run = told(&place, "show camera.toml@rgbw --json --set sensor.cfa.filters.W={flat=0.5}");
    assert_eq!(run.err, "");
    assert_eq!(json(&run.out)["description"]["sensor"]["cfa"]["filters"]["W"]["flat"], 0.5);
}

#[test]
fn files_of_filters_that_do_not_fit_are_refused() {
    let place = Place::new();
    place.write("camera.toml", CAMERA);
    for (csv, words) in [
        (
            "nm,R,G,B\n400,5,90,10\n700,5,10,101\n",
            &["filters.csv: line 3: found 101 in column 'B'", "at most 100 %"][..],
        ),
        (
            "nm,R,G,B\n400,0.5,90,10\n700,0.5,10,11\n",
            &["line 2: found 0.5 in column 'R'", "percent as in column 'G'"],
        ),
        ("nm,R,G,B\n400,0.5,0.5,1.4\n700,0.5,0.5,1\n", &["line 2: found 1.4 in column 'B'", "0 to 1"]),
        ("nm,Red,G,B\n400,0,0,0\n700,1,1,1\n", &["the column 'Red'", "single letter"]),
        ("nm,R,G\n400,0,0\n700,1,1\n", &["filters.csv has no column B", "it has G, R"]),
        ("nm;R;G;B\n400;0.5;0.5;0,5\n700;1;1;1\n", &["line 2: found '0,5'", "decimal point"]),
        ("nm,R,G,B\n450,0,0,0\n700,1,1,1\n", &["sensor.cfa.filters"]),
    ] {
        place.write("filters.csv", csv);
        refused(&place, &["simulate", "camera.toml", "-o", "out"], words);
    }
    place.write("camera.toml", "[sensor.cfa]\nfilters = { file = 3 }\n");
    refused(&place, &["simulate", "camera.toml", "-o", "out"], &["camera.toml:2"]);
    place.write("camera.toml", CAMERA.replace("filters.csv", "absent.csv"));
    refused(&place, &["simulate", "camera.toml", "-o", "out"], &["camera.toml:3", "absent.csv"]);
}

#[test]
fn a_learned_table_renders_in_simulate_and_evaluate() {
    let place = Place::new();
    place.ok(&format!("train bayer {LEAVES} {SMALL} {EXPOSURES} -o a.l3"));
    place.ok(&format!("simulate bayer {OTHER} {SMALL} --noise none -o own"));
    place.ok(&format!("simulate bayer {OTHER} {SMALL} --noise none --pipeline a.l3 -o learned"));
    assert_eq!(place.read("own/raw.dng"), place.read("learned/raw.dng"));
    let cpsnr =
        |folder: &str| place.json(&format!("{folder}/metrics.json"))["picture"]["cpsnr_db"].as_f64().unwrap();
    assert!(cpsnr("learned") > cpsnr("own"), "{} {}", cpsnr("learned"), cpsnr("own"));
    assert_eq!(place.json("learned/metrics.json")["pipeline"], "a.l3");
    // The picture is that of `render`, which adapts the white of the table: under the same light within rounding.
    place.ok("render learned/raw.dng --pipeline a.l3 -o learned/again.png -q");
    let pixels = |name: &str| {
        smalti_io::picture::read(&place.path(name), &ReadOptions::default())
            .unwrap()
            .image
            .planes()
            .data()
            .to_vec()
    };
    let (a, b) = (pixels("learned/rendered.png"), pixels("learned/again.png"));
    let largest = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(a.len() == b.len() && largest <= 2.0 / 255.0, "{largest}");

    let scores =
        |words: &str| place.document(&format!("evaluate bayer {SMALL} {words} --json"))["cameras"][0].clone();
    let (own, learned) = (scores(""), scores("--pipeline a.l3"));
    assert_ne!(own["mtf50_cy_per_px"], learned["mtf50_cy_per_px"]);
    let text = place.ok(&format!("evaluate bayer {SMALL} --pipeline a.l3"));
    assert!(text.contains("The learned kernels of a low signal"), "{text}");
    assert_eq!(own["dynamic_range_db"], learned["dynamic_range_db"]);

    for (words, expected) in [
        (
            "simulate rgbw --pipeline a.l3 -o out",
            &["rgbw with a.l3", "mosaic of 2 × 2 with channels R G W B"][..],
        ),
        (
            "evaluate rgbw --pipeline a.l3",
            &["a.l3 for rgbw", "the pipeline is for 2 × 2 with channels R G G B"],
        ),
        ("evaluate bayer-bggr.toml --pipeline a.l3", &["bayer-bggr", "B G G R"]),
        (
            "evaluate bayer --set sensor.adc_bits=10 --pipeline a.l3",
            &["a.l3 for bayer", "white level", "learned for this camera (smalti train)"],
        ),
        ("evaluate bayer rgbw --pipeline a.l3", &["--pipeline: 1 given for 2 cameras"]),
        ("simulate bayer --pipeline none.l3 -o out", &["none.l3"]),
        (
            "simulate bayer --pipeline a.l3 --set isp.white_balance=gray-world -o out",
            &["isp.white_balance", "gray-world"],
        ),
    ] {
        place.write("bayer-bggr.toml", "[sensor.cfa]\npattern = \"bayer-bggr\"\n");
        refused(&place, &words.split(' ').collect::<Vec<_>>(), expected);
    }
}

#[test]
fn a_clear_channel_that_sees_infrared_is_told() {
    let place = Place::new();
    let uncut = "--set optics.ir_cut=none";
    for words in [
        format!("show rgbw {uncut}"),
        format!("simulate rgbw --scene macbeth?patch=8 {SMALL} {uncut} -o o"),
        format!("evaluate rgbw {SMALL} {uncut}"),
        format!("compare bayer rgbw --processing bilinear --luminance 80 {LEAVES} {SMALL} {uncut} -o c"),
    ] {
        let run = told(&place, &words);
        assert!(run.err.starts_with("note: rgbw: ") && run.err.lines().count() == 1, "{words}: {}", run.err);
        for part in
            ["the clear channel W", "above 680 nm", "--set 'optics.ir_cut={ builtin = \"hot-mirror\" }'"]
        {
            assert!(run.err.contains(part), "{words}: {}", run.err);
        }
        assert_eq!(told(&place, &format!("{words} -q")).err, "");
    }
    assert!(
        told(&place, &format!("show rgbw {uncut}"))
            .err
            .contains("this may cause colour errors. Add an infrared-cut filter")
    );
    // The advice suits the end of the spectrum: these colours transmit no violet.
    let narrow =
        "--set sensor.cfa.filters.B={box={low_nm=425,high_nm=495,peak=0.8}} --set wavelengths_nm=[380,5,680]";
    let violet = told(&place, &format!("show rgbw {narrow}"));
    assert!(violet.err.contains("blocks light below") && !violet.err.contains("ir_cut"), "{}", violet.err);
    // Cameras that it applies to alike share a note.
    let run = told(&place, &format!("evaluate rgbw bayer@rgbw-sony {SMALL} {uncut}"));
    assert!(run.err.contains("note: rgbw, bayer@rgbw-sony: ") && run.err.lines().count() == 2, "{}", run.err);
    // What is proposed mends it, and cameras for infrared are not for colour.
    place.ok(r#"show rgbw --set optics.ir_cut={builtin="hot-mirror"}"#);
    assert!(told(&place, "show rgbx").err.contains("near infrared"));
    let run = told(&place, "evaluate rgbx --set wavelengths_nm=[400,50,800]");
    assert!(run.err.starts_with("note: rgbx: at least ") && run.err.contains("near infrared"), "{}", run.err);
    assert!(place.ok("list cameras").contains("near infrared, RGB and infrared without infrared cut"));
    let wrong = ["show", "rgbw", "--set", "optics.ir_cut=nothing"];
    refused(&place, &wrong, &["--set optics.ir_cut=nothing", "\"none\""]);
}
