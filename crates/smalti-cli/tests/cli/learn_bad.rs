//! Bad input to `smalti train` and `smalti render`: one line that names it, and nothing left behind.

use crate::Place;
use crate::learn::{EXPOSURES, LEAVES, OTHER, SMALL};

/// Words that must fail with a message that holds others; what was in the folder is all there is after.
fn refused(place: &Place, words: &str, code: i32, expected: &[&str]) {
    let before = place.names("");
    let run = place.run(&words.split_whitespace().collect::<Vec<_>>());
    assert_eq!((run.code, run.out.as_str()), (code, ""), "{words}: {}", run.err);
    assert!(run.err.starts_with("error: "), "{words}: {}", run.err);
    // A second line says what is built in.
    assert!(code == 2 || run.err.lines().count() <= 2, "{words}: {}", run.err);
    for e in expected {
        assert!(run.err.contains(e), "{words}: no {e} in {}", run.err);
    }
    assert_eq!(place.names(""), before, "{words}");
}

/// Options that would be ignored are refused.
#[test]
fn options_of_scenes_need_scenes_and_lights_of_the_default_set_need_it() {
    let place = Place::new();
    refused(&place, "train bayer --illuminant A -o a.l3", 1, &["--illuminant", "--scene", "--illuminants"]);
    let both = "train bayer --scene macbeth --illuminants A -o a.l3";
    refused(&place, both, 2, &["--scene", "--illuminants", "cannot be used with"]);
}

#[test]
fn settings_that_cannot_be_learned_with() {
    let place = Place::new();
    place.write("file", "kept");
    let train = format!("train bayer {LEAVES} {SMALL} -o a.l3");
    for (more, code, expected) in [
        ("--exposures 0", 2, &["'0'", "--exposures", "above 0"][..]),
        ("--exposures 1,nan", 2, &["'nan'", "--exposures"]),
        ("--exposures -1", 2, &["'-1'", "--exposures", "above 0"]),
        ("--levels 0", 2, &["'0'", "--levels", "1 to 256"]),
        ("--levels 257", 2, &["'257'", "--levels", "1 to 256"]),
        ("--patch 13", 2, &["'13'", "--patch"]),
        ("--alpha-flat x", 2, &["'x'", "--alpha-flat", "such as 16,4"]),
        ("--alpha-flat 1,nan", 2, &["'1,nan'", "--alpha-flat"]),
        ("--smoothing nan", 2, &["'nan'", "--smoothing", "0 to 1"]),
        ("--pair a.dng b.tif", 2, &["--pair", "--scene", "cannot be used with"]),
        ("--pair a.dng", 2, &["--pair", "2 values required"]),
        ("--set sensor.architecture=prism", 1, &["bayer", "`sensor.architecture` is prism", "mosaics"]),
        ("--target bayr", 1, &["--target bayr", "did you mean 'bayer'?"]),
        ("--target-illuminant D66", 1, &["did you mean 'D65'?"]),
        ("--scene dead-leafs", 1, &["did you mean 'dead-leaves'?"]),
        ("--statistics file/such.st", 1, &["cannot write file/such.st"]),
        ("--npz file/a.npz", 1, &["cannot write file/a.npz"]),
        ("--continue no.st", 1, &["cannot read no.st"]),
        ("--continue file", 1, &["file"]),
        ("--quality good", 2, &["'good'", "--quality", "fast, best"]),
        ("--c-header-float file/a.h", 1, &["cannot write file/a.h"]),
        ("--raw-cfa xtrans", 1, &["--raw-cfa", "--pair", "--cfa"]),
        ("--quality best --target rgbw", 1, &["--quality best", "X, Y, Z"]),
    ] {
        refused(&place, &format!("{train} {more}"), code, expected);
    }
    refused(&place, &format!("train bayer {LEAVES} -o file/such.l3"), 1, &["cannot write file/such.l3"]);
    assert_eq!(place.read("file"), b"kept");
}

#[test]
fn mosaics_that_are_too_much() {
    let place = Place::new();
    let letters: String = ('A'..='Z').chain('a'..='z').take(40).collect();
    let filters: String = letters.chars().map(|c| format!("{c} = {{ flat = 0.5 }}\n")).collect();
    place.write(
        "many.toml",
        format!("[sensor.cfa]\npattern = [\"{letters}\"]\n[sensor.cfa.filters]\n{filters}"),
    );
    refused(
        &place,
        &format!("train many.toml {LEAVES} -o a.l3"),
        1,
        &["number of channels is 40", "1 to 32"],
    );
    // 4096 positions with the largest patch and the most levels: 380 GiB of moments.
    if smalti_io::memory::available_bytes().is_none_or(|bytes| bytes > 350 << 30) {
        eprintln!("skipped: memory of unknown size, or enough");
        return;
    }
    let cell = |i: usize| ['R', 'G', 'B'][(i * i + i / 7) % 3];
    let line = |r: usize| format!("\"{}\"", (0..64).map(|c| cell(r * 64 + c)).collect::<String>());
    let lines = (0..64).map(line).collect::<Vec<_>>().join(", ");
    let filters = "R = { flat = 0.3 }\nG = { flat = 0.4 }\nB = { flat = 0.2 }\n";
    place.write("large.toml", format!("[sensor.cfa]\npattern = [{lines}]\n[sensor.cfa.filters]\n{filters}"));
    refused(
        &place,
        "train large.toml --scene uniform?size=64 --patch 11 --levels 256 -o a.l3",
        1,
        &["4096 positions × 256 levels × 6 textures", "11 × 11", "of memory to learn", "a smaller patch"],
    );
}

#[test]
fn statistics_of_something_else() {
    let place = Place::new();
    let common = format!("{SMALL} {EXPOSURES}");
    place.ok(&format!("train bayer {LEAVES} {common} -o a.l3 --statistics a.st"));
    for (words, expected) in [
        (format!("train rgbw {OTHER} {common} --continue a.st"), "a.st: statistics of another mosaic"),
        (
            "train bayer --patch 7 --continue a.st".into(),
            "a.st: statistics of patches of 5 × 5; 7 × 7 was asked for",
        ),
        ("train bayer --levels 4 --continue a.st".into(), "a.st: statistics of 10 levels; 4 were asked for"),
        ("train bayer --textures none --continue a.st".into(), "; any were asked for"),
        (
            "train bayer --set sensor.pixel.read_noise_mv=5 --continue a.st".into(),
            "a.st: statistics of a camera with other noise",
        ),
        (
            "train bayer --target rgbw --continue a.st".into(),
            "with targets X, Y, Z; R, G, W, B were asked for",
        ),
        (
            format!("train bayer {OTHER} --illuminant A {common} --continue a.st"),
            "a.st, gathered in another light",
        ),
        ("train bayer --continue a.l3".into(), "a.l3"),
    ] {
        refused(&place, &format!("{words} -o b.l3"), 1, &[expected]);
    }
    place.ok(&format!("simulate bayer {LEAVES} {SMALL} --bits 16 --format tif -o s"));
    let pair = "train bayer --pair s/raw.dng s/rendered.tif";
    refused(
        &place,
        &format!("{pair} --continue a.st -o b.l3"),
        1,
        &["a.st", "statistics from raw files include noise"],
    );
}

#[test]
fn pairs_that_do_not_fit() {
    let place = Place::new();
    place.ok(&format!("simulate bayer {LEAVES} {SMALL} -o s"));
    place.ok("convert uniform?size=30 -o small.png");
    place.ok("convert uniform?size=96 -o flat.png");
    place.ok(&format!("simulate bayer {LEAVES} {SMALL} --set sensor.adc_bits=10 -o ten"));
    let pair = |pairs: &str, expected: &[&str]| {
        refused(&place, &format!("train bayer {pairs} -o a.l3"), 1, expected)
    };
    pair(
        "--no-align --pair s/raw.dng small.png",
        &["s/raw.dng and small.png", "96 × 96", "the target 30 × 30"],
    );
    pair(
        "--pair s/raw.dng small.png",
        &["s/raw.dng and small.png", "30 × 30 pixels are too few for alignment"],
    );
    pair(
        "--pair s/raw.dng flat.png",
        &["s/raw.dng and flat.png", "the image is uniform; an alignment needs structure"],
    );
    pair("--pair s/raw.dng no.png", &["cannot read no.png"]);
    pair("--pair no.dng s/rendered.png", &["cannot read no.dng"]);
    pair("--pair s/rendered.png s/rendered.png", &["s/rendered.png"]);
    pair(
        "--pair s/raw.dng s/rendered.png --pair ten/raw.dng ten/rendered.png",
        &["ten/raw.dng and", "white level 1023", "16383"],
    );
    refused(
        &place,
        "train rgbw --pair s/raw.dng s/rendered.png -o a.l3",
        1,
        &["s/raw.dng and s/rendered.png", "R G G B"],
    );
}

#[test]
fn raws_and_tables_that_do_not_fit() {
    let place = Place::new();
    place.ok(&format!("train bayer {LEAVES} {SMALL} {EXPOSURES} --patch 11 -o a.l3"));
    let raw = |folder: &str, camera: &str, more: &str| {
        place.ok(&format!("simulate {camera} {LEAVES} {more} -o {folder}"));
    };
    raw("good", "bayer", SMALL);
    raw("rgbw", "rgbw", SMALL);
    raw("ten", "bayer", &format!("{SMALL} --set sensor.adc_bits=10"));
    raw("black", "bayer", &format!("{SMALL} --set sensor.black_level_dn=100"));
    raw("prism", "bayer", &format!("{SMALL} --set sensor.architecture=prism"));
    raw("tiny", "bayer", "--set sensor.rows=8 --set sensor.cols=8");
    raw("volts", "bayer", &format!("{SMALL} --set sensor.adc_bits=0 --set sensor.black_level_dn=0"));
    for (words, expected) in [
        ("rgbw/raw.dng --pipeline a.l3", &["rgbw/raw.dng with a.l3", "R G W B", "R G G B"][..]),
        ("ten/raw.dng --pipeline a.l3", &["ten/raw.dng with a.l3", "white level 1023", "64 and 16383"]),
        ("black/raw.dng --pipeline a.l3", &["black level 100", "64 and 16383"]),
        ("prism/raw.dng --pipeline a.l3", &["every channel at every pixel", "mosaics"]),
        ("tiny/raw.dng --pipeline a.l3", &["8 × 8 pixels", "at least 11 × 11"]),
        ("volts/raw.dng --pipeline a.l3 --fixed", &["volts/raw.dng"]),
        ("no.dng --pipeline a.l3", &["cannot read no.dng"]),
        ("good/raw.dng --pipeline no.l3", &["cannot read no.l3"]),
        ("good/rendered.png --pipeline a.l3", &["good/rendered.png"]),
        ("a.l3 --pipeline a.l3", &["a.l3"]),
        ("good/raw.dng --pipeline good/raw.dng", &["good/raw.dng"]),
    ] {
        refused(&place, &format!("render {words} -o a.png"), 1, expected);
    }
    let render = "render good/raw.dng --pipeline a.l3";
    refused(&place, &format!("{render} -o a.png --quality good"), 2, &["'good'", "--quality", "fast, best"]);
    let one_stage = ["--quality best with a.l3", "one stage", "expected quality fast"];
    refused(&place, &format!("{render} -o a.png --quality best"), 1, &one_stage);
    refused(
        &place,
        &format!("{render} -o a.jpg"),
        1,
        &["a.jpg: expected a name that ends in .png, .tif, .dng or .npy"],
    );
    refused(&place, &format!("{render} -o no/a.png"), 1, &["cannot write no/a.png"]);
    for gain in ["0", "-1", "nan", "inf", "x"] {
        refused(&place, &format!("{render} -o a.png --gain {gain}"), 2, &["--gain", "above 0"]);
    }
    // Tables that were damaged: at every place a cut or a flipped byte, and another version.
    let whole = place.read("a.l3");
    for cut in [0, 4, 8, 200, whole.len() / 2, whole.len() - 1] {
        place.write("bad.l3", &whole[..cut]);
        refused(&place, "render good/raw.dng --pipeline bad.l3 -o a.png", 1, &["bad.l3"]);
    }
    let mut huge = whole.clone();
    huge[..8].copy_from_slice(&u64::MAX.to_le_bytes());
    place.write("bad.l3", huge);
    refused(&place, "render good/raw.dng --pipeline bad.l3 -o a.png", 1, &["bad.l3"]);
    let text = String::from_utf8_lossy(&whole[8..]).find("\"version\":\"1\"").unwrap();
    let mut other = whole;
    other[8 + text + "\"version\":\"".len()] = b'9';
    place.write("bad.l3", other);
    refused(
        &place,
        "render good/raw.dng --pipeline bad.l3 -o a.png",
        1,
        &["bad.l3", "version 9", "version 1 or 2 or 3 or 4 or 5 is read here"],
    );
}

/// Work that is broken off leaves no file, whole or half.
#[cfg(unix)]
#[test]
fn an_interrupt_leaves_nothing() {
    let place = Place::new();
    for words in ["train bayer -o a.l3 --statistics a.st", "compare bayer -o out --no-cache"] {
        let mut child = place
            .command()
            .args(words.split(' '))
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        // Either takes many seconds.
        std::thread::sleep(std::time::Duration::from_millis(700));
        let id = child.id().to_string();
        assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        let ended = child.wait().unwrap();
        assert!(!ended.success(), "SIGINT was ignored, as by what a shell starts in the background");
        let left: Vec<String> = place.names("").into_iter().filter(|n| n != "cache").collect();
        assert!(left.is_empty(), "{words} left {left:?}");
    }
}
