//! `smalti train` and `smalti render`.

use smalti::color::Image;
use smalti::l3::Pipeline;
use smalti::numeric::Planes;
use smalti_io::ReadOptions;
use smalti_io::npy::{self, NpyData};
use smalti_io::picture::Depth;
use smalti_io::{Limits, l3, picture};

use crate::Place;

pub(crate) const SMALL: &str = "--set sensor.rows=96 --set sensor.cols=96";
pub(crate) const LEAVES: &str = "--scene dead-leaves?rows=96&cols=96&largest=60";
pub(crate) const OTHER: &str = "--scene dead-leaves?rows=96&cols=96&largest=60&seed=5";
pub(crate) const EXPOSURES: &str = "--exposures 1,0.1";

fn table(place: &Place, name: &str) -> Pipeline {
    l3::read_table(&place.path(name)).unwrap()
}

fn array(place: &Place, name: &str) -> (Vec<usize>, Vec<f32>) {
    let read = npy::read(&place.path(name), Limits::default()).unwrap();
    let NpyData::F32(data) = read.data else { panic!("{name}: {:?}", read.data) };
    (read.shape, data)
}

/// The same but for how it was made.
fn assert_same_table(a: &Pipeline, b: &Pipeline) {
    assert_eq!(a.axes(), b.axes());
    assert_eq!(a.classes(), b.classes());
    assert_eq!(a.kernels(), b.kernels());
    assert_eq!((a.saturations(), a.outputs(), a.white()), (b.saturations(), b.outputs(), b.white()));
}

#[test]
fn what_is_trained_renders_what_is_simulated() {
    let place = Place::new();
    let text = place.ok(&format!("train bayer {LEAVES} {SMALL} {EXPOSURES} -o a.l3"));
    assert!(text.lines().next().unwrap().starts_with("position  channel"), "{text}");
    assert!(
        text.contains("classes had training data (16928 patches, ") && text.ends_with("a.l3\n"),
        "{text}"
    );
    place.ok(&format!("simulate bayer {OTHER} {SMALL} -o s"));

    // What the table gives, in numbers.
    let json = place.document("render s/raw.dng --pipeline a.l3 -o p.npy --json");
    assert_eq!((&json["rows"], &json["cols"]), (&96.into(), &96.into()));
    assert_eq!(json["outputs"], serde_json::json!(["X", "Y", "Z"]));
    assert_eq!((&json["output"], &json["arithmetic"]), (&"p.npy".into(), &"single precision".into()));
    for key in ["darker_than", "brighter_than", "clipped_unlike"] {
        assert!(json[format!("pixels_{key}_trained")].is_number(), "{key} of {json}");
    }
    let (shape, xyz) = array(&place, "p.npy");
    assert_eq!(shape, [3, 96, 96]);

    // It is the scene: nearer to the reference than half of what the reference spreads by.
    place.ok("render s/raw.dng --pipeline a.l3 -o fixed.npy --fixed -q");
    let (_, fixed) = array(&place, "fixed.npy");
    let peak = xyz.iter().copied().fold(0.0, f32::max);
    let mse = xyz.iter().zip(&fixed).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / xyz.len() as f64;
    let psnr = 10.0 * (f64::from(peak).powi(2) / mse).log10();
    assert!(psnr > 60.0, "fixed point is {psnr} dB from single precision");

    // As pictures: 8 and 16 bits, the same, and like that of the classic pipeline.
    let out = place.ok("render s/raw.dng --pipeline a.l3 -o p.png -q");
    assert_eq!(out, "p.png\n");
    place.ok("render s/raw.dng --pipeline a.l3 -o p.tif --bits 16 -q");
    let read = |name: &str| picture::read(&place.path(name), &ReadOptions::default()).unwrap();
    let (eight, sixteen, classic) = (read("p.png"), read("p.tif"), read("s/rendered.png"));
    assert_eq!((eight.bits, sixteen.bits), (8, 16));
    let far = |a: &picture::Picture, b: &picture::Picture| {
        let (a, b) = (a.image.planes().data(), b.image.planes().data());
        let squares = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2));
        (squares.sum::<f64>() / a.len() as f64).sqrt()
    };
    assert!(far(&eight, &sixteen) < 0.5 / 255.0);
    assert!(far(&eight, &classic) < 0.1, "{} from the classic picture", far(&eight, &classic));
    // The command that captures makes the same picture of it.
    place.ok(&format!("simulate bayer {OTHER} {SMALL} --pipeline a.l3 -o learned"));
    assert!(place.read("learned/raw.dng") == place.read("s/raw.dng"));
    assert!(read("learned/rendered.png").image == eight.image);
    // Half the brightness in linear light.
    place.ok("render s/raw.dng --pipeline a.l3 -o bright.png --gain 1 -q");
    place.ok("render s/raw.dng --pipeline a.l3 -o dim.png --gain 0.5 -q");
    let mean = |p: &picture::Picture| p.image.planes().data().iter().sum::<f32>();
    assert!(mean(&read("dim.png")) < 0.85 * mean(&read("bright.png")));
}

/// Folders of the files to be written are made, as other commands make theirs.
#[test]
fn folders_are_made() {
    let place = Place::new();
    place.ok(&format!("train bayer {LEAVES} {SMALL} {EXPOSURES} -o no/such/a.l3 --npz other/a.npz -q"));
    assert_eq!((place.names("no/such"), place.names("other")), (vec!["a.l3".into()], vec!["a.npz".into()]));
}

#[test]
fn parts_make_the_whole() {
    let place = Place::new();
    let common = format!("{SMALL} {EXPOSURES}");
    place.ok(&format!("train bayer {LEAVES} {OTHER} {common} -o whole.l3 --statistics whole.st"));
    place.ok(&format!("train bayer {LEAVES} {common} -o one.l3 --statistics one.st"));
    place.ok(&format!("train bayer {OTHER} {common} -o two.l3 --continue one.st --statistics both.st"));
    let whole = table(&place, "whole.l3");
    assert_same_table(&whole, &table(&place, "two.l3"));
    assert!(place.read("whole.st") == place.read("both.st"), "statistics know no order of work");
    // Merged alone, without a scene; sums of parts differ in the last bits of double precision.
    place.ok(&format!("train bayer {OTHER} {common} -o other.l3 --statistics other.st"));
    place.ok("train bayer --continue one.st --continue other.st -o merged.l3");
    let merged = table(&place, "merged.l3");
    assert_eq!(merged.classes(), whole.classes());
    let far = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(far(&merged.kernels().weights, &whole.kernels().weights) < 1e-4);
    // From saved statistics another solver takes no scene.
    place.ok("train bayer --continue whole.st --solver ridge -o ridge.l3");
    assert_ne!(table(&place, "ridge.l3").kernels(), whole.kernels());
    // The same again, on any number of threads.
    place.ok(&format!("train bayer {LEAVES} {OTHER} {common} -o again.l3 --threads 1"));
    assert!(place.read("again.l3") == place.read("whole.l3"));
}

/// What a camera's own processing makes of its raw files can be learned from the two.
#[test]
fn a_raw_file_and_its_picture_are_enough() {
    let place = Place::new();
    place.ok(&format!("simulate bayer {LEAVES} {SMALL} --bits 16 --format tif -o a"));
    place.ok(&format!("simulate bayer {OTHER} {SMALL} --bits 16 --format tif -o b"));
    place.ok("train bayer --pair a/raw.dng a/rendered.tif --pair b/raw.dng b/rendered.tif -o pair.l3");
    place.ok("render a/raw.dng --pipeline pair.l3 -o back.tif --bits 16 --gain 1 -q");
    let read = |name: &str| picture::read(&place.path(name), &ReadOptions::default()).unwrap().image;
    let (wanted, got) = (read("a/rendered.tif"), read("back.tif"));
    let squares =
        wanted.planes().data().iter().zip(got.planes().data()).map(|(a, b)| f64::from(a - b).powi(2));
    let rms = (squares.sum::<f64>() / got.planes().data().len() as f64).sqrt();
    assert!(rms < 0.05, "{rms} from the picture that was learned from");
}

/// A picture that is a crop of the raw image finds its place.
#[test]
fn a_cropped_picture_is_aligned() {
    let place = Place::new();
    place.ok(&format!("simulate bayer {LEAVES} {SMALL} --bits 16 --format tif -o a"));
    let options = ReadOptions::default();
    let whole = picture::read(&place.path("a/rendered.tif"), &options).unwrap().image;
    let (row, col, rows, cols) = (7, 11, 80, 76);
    let planes = whole.planes();
    let part = planes
        .planes()
        .flat_map(|p| p.chunks(planes.cols()).skip(row).take(rows).flat_map(|r| r[col..col + cols].to_vec()));
    let part = Planes::new(rows, cols, 3, part.collect()).unwrap();
    let part = Image::new(whole.space(), part).unwrap();
    picture::write(&place.path("part.tif"), &part, Depth::Sixteen).unwrap();
    let said = place.ok("train bayer --pair a/raw.dng part.tif -o part.l3 --json");
    let said: serde_json::Value = serde_json::from_str(&said).unwrap();
    let found = &said["pairs"][0];
    let near = |key: &str, value: f64| (found["alignment"][key].as_f64().unwrap() - value).abs() < 0.1;
    assert!(near("row_shift_px", 7.0) && near("col_shift_px", 11.0) && near("scale", 1.0), "{found}");
    assert!(found["alignment"]["correlation"].as_f64().unwrap() > 0.8, "{found}");
    assert!(found["rows"].as_u64().unwrap() >= 70, "{found}");
    let text = place.ok("train bayer --pair a/raw.dng a/rendered.tif -o whole.l3");
    assert!(
        text.contains("96 × 96 pixels, the picture shifted by") && text.contains("(left as it is)"),
        "{text}"
    );
}

/// A learned picture has the scale of the wavelengths that its table was learned for. With those below 400 nm, the reference would be 6 % brighter.
#[test]
fn a_scene_at_other_wavelengths_is_scored_on_the_scale_of_the_table() {
    let place = Place::new();
    place.ok(&format!("train bayer {LEAVES} {SMALL} {EXPOSURES} -o t.l3"));
    place.ok("convert dead-leaves?rows=96&cols=96&largest=60 --wavelengths 380:10:780 -o wide.h5");
    place.ok("convert dead-leaves?rows=96&cols=96&largest=60 --wavelengths 420:10:700 -o narrow.h5");
    let scores = |scene: &str| {
        place.ok(&format!(
            "simulate bayer --scene {scene} {SMALL} --noise none --luminance 40 --pipeline t.l3 -o s"
        ));
        place.json("s/metrics.json")["picture"]["cpsnr_db"].as_f64().unwrap()
    };
    let (own, wide) = (scores("dead-leaves?rows=96&cols=96&largest=60"), scores("wide.h5"));
    assert!((own - wide).abs() < 0.1, "{own} and {wide} dB");
    let run = place.run(&["simulate", "bayer", "--scene", "narrow.h5", "--pipeline", "t.l3", "-o", "n"]);
    assert_eq!(run.code, 1);
    assert!(run.err.contains("narrow.h5 (--pipeline)") && run.err.contains("420"), "{}", run.err);
    // Scenes are shared by the cameras of a comparison.
    let compare = |scene: &str| {
        let words =
            format!("compare bayer --pipeline t.l3 --scene {scene} --luminance 40 --seeds 1 {SMALL} -o c");
        let run = place.run(&words.split(' ').collect::<Vec<_>>());
        assert_eq!(run.code, 0, "{}", run.err);
        run.err.contains(
            "the table is for the wavelengths of the camera, 400:10:700 nm, and scenes have 380:10:780 nm",
        )
    };
    assert!(compare("wide.h5"));
    assert!(!compare("photo-brushes"));
}

#[test]
fn other_targets_and_other_light() {
    let place = Place::new();
    place.ok(&format!("train bayer {LEAVES} {SMALL} {EXPOSURES} --target rgbw -o t.l3"));
    assert_eq!(table(&place, "t.l3").outputs(), ["R", "G", "W", "B"]);
    place.ok(&format!("simulate bayer {LEAVES} --illuminant A {SMALL} -o s"));
    place.ok("render s/raw.dng --pipeline t.l3 -o t.npy -q");
    assert_eq!(array(&place, "t.npy").0, [4, 96, 96]);
    let run = place.run(&["render", "s/raw.dng", "--pipeline", "t.l3", "-o", "t.png"]);
    assert_eq!(run.code, 1);
    assert!(
        run.err.contains("t.png: the outputs of t.l3 are R, G, W, B, not a picture; use the extension .npy"),
        "{}",
        run.err
    );
    assert!(!place.path("t.png").exists());

    // Tungsten seen as by daylight: the mean has the colour of daylight, that of plain training the light's.
    let blue = |name: &str, more: &str| {
        place.ok(&format!("train bayer {LEAVES} --illuminant A {SMALL} {EXPOSURES} {more} -o {name}.l3"));
        place.ok(&format!("render s/raw.dng --pipeline {name}.l3 -o {name}.npy -q"));
        let (_, xyz) = array(&place, &format!("{name}.npy"));
        let sum = |c: usize| xyz[c * 96 * 96..][..96 * 96].iter().sum::<f32>();
        sum(2) / sum(1)
    };
    let (warm, balanced) = (blue("warm", ""), blue("balanced", "--target-illuminant D65"));
    // Z of white: 0.36 in A, 1.09 in D65; leaves are yellower than white.
    assert!(warm < 0.4 && balanced > 2.0 * warm, "{warm} {balanced}");
}

#[test]
fn tables_for_others() {
    let place = Place::new();
    place.ok(&format!("train bayer {LEAVES} {SMALL} {EXPOSURES} -o a.l3 --npz a.npz --c-header my-isp.h"));
    let header = String::from_utf8(place.read("my-isp.h")).unwrap();
    assert!(header.contains("my_isp_") && header.contains("int16_t"), "{}", &header[..500.min(header.len())]);
    assert_eq!(&place.read("a.npz")[..2], b"PK");
    let json = place.document(&format!("train bayer {LEAVES} {SMALL} {EXPOSURES} -o b.l3 --json"));
    let table = table(&place, "b.l3");
    assert_eq!(json["classes"].as_array().unwrap().len(), table.classes().len());
    assert_eq!(json["patches"], 16928);
    let occurring = table.classes().iter().filter(|c| c.count > 0).count();
    assert_eq!(json["classes_that_occur"], occurring);
    assert_eq!(json["operators"], 3 * occurring);
}

#[test]
fn every_way_of_learning_makes_a_table_that_renders() {
    let place = Place::new();
    let leaves = "--scene dead-leaves?rows=64&cols=64&largest=30";
    let small = "--set sensor.rows=64 --set sensor.cols=64";
    place.ok(&format!("simulate bayer {leaves} {small} -o s"));
    let mut kernels = Vec::new();
    for options in [
        "",
        "--textures none",
        "--textures flat-texture",
        "--solver least-squares",
        "--solver ridge",
        "--solver perceptual",
        "--alpha-flat 4,2 --alpha-texture 2,1",
        "--level-rule noise-steps",
        "--patch 3",
        "--patch 7",
        "--patch 9",
        "--patch 11",
        "--linear",
        "--smoothing 0.5",
        "--no-symmetry",
        "--sharp",
        "--levels 1",
        "--levels 256 --textures none",
    ] {
        place.ok(&format!("train bayer {leaves} {small} --exposures 1,0.2 {options} -o a.l3"));
        let run = place.run(&["render", "s/raw.dng", "--pipeline", "a.l3", "-o", "a.npy"]);
        assert_eq!(run.code, 0, "{options}: {}", run.err);
        let (shape, values) = array(&place, "a.npy");
        assert_eq!(shape, [3, 64, 64], "{options}");
        let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
        assert!(values.iter().all(|v| v.is_finite()) && (0.02..1.0).contains(&mean), "{options}: {mean}");
        let table = table(&place, "a.l3");
        if options == "--linear" {
            assert!(table.kernels().offsets.iter().all(|o| *o == 0.0));
        }
        kernels.push((options, table.kernels().clone()));
    }
    for (i, (a, of_a)) in kernels.iter().enumerate() {
        for (b, of_b) in &kernels[..i] {
            assert!(of_a != of_b, "'{a}' does nothing else than '{b}'");
        }
    }
}

#[test]
fn pixels_beyond_what_was_trained_are_counted() {
    let place = Place::new();
    place.ok(&format!("train bayer {LEAVES} {SMALL} --exposures 0.3 -o mid.l3"));
    for (luminance, what) in [("4000", "brighter"), ("0.01", "darker")] {
        place.ok(&format!("simulate bayer {LEAVES} {SMALL} --luminance {luminance} -o s"));
        let run = place.run(&["render", "s/raw.dng", "--pipeline", "mid.l3", "-o", "a.png"]);
        assert_eq!(run.code, 0);
        let words = format!("of 9216 pixels are {what} than the training data and use the nearest class");
        assert!(run.err.starts_with("note: ") && run.err.contains(&words), "{luminance}: {}", run.err);
        let quiet = place.ok("render s/raw.dng --pipeline mid.l3 -o a.png -q --json");
        let json: serde_json::Value = serde_json::from_str(&quiet).unwrap();
        let count = json[format!("pixels_{what}_than_trained")].as_u64().unwrap();
        assert!(run.err.contains(&format!("{count} {words}")), "{count}: {}", run.err);
    }
}

/// A table of best quality renders a noisy picture with less error than one of fast quality, in fixed point and with its first stage alone as
/// well, and every result states the quality.
#[test]
fn best_quality_refines_what_fast_quality_renders() {
    let place = Place::new();
    let flat = "--scene macbeth?patch=24 --set sensor.rows=96 --set sensor.cols=144";
    for quality in ["fast", "best"] {
        let headers = format!("--c-header {quality}.h --c-header-float {quality}_float.h");
        let text = place.ok(&format!(
            "train bayer {flat} --exposures 1,0.1,0.01 --quality {quality} -o {quality}.l3 {headers}"
        ));
        assert!(text.contains(&format!("\nquality: {quality}, ")), "{text}");
        for (file, number) in [("", "fixed point"), ("_float", "single precision")] {
            let header = String::from_utf8(place.read(&format!("{quality}{file}.h"))).unwrap();
            assert!(
                header.contains(&format!("{number}, of quality {quality}, written by Smalti")),
                "{quality}"
            );
            assert_eq!(header.contains(&format!("{quality}{file}_fast_image")), quality == "best");
        }
    }
    assert!(table(&place, "fast.l3").refinement().is_none());
    let best = table(&place, "best.l3");
    assert!(best.refinement().unwrap().classes().iter().any(|c| c.is_learned));
    assert!(best.provenance().contains(r#""quality":"best""#));
    // The first stage is that of the fast table.
    assert_eq!(best.kernels(), table(&place, "fast.l3").kernels());
    place.ok(&format!("simulate bayer {flat} --luminance 2 --seed 9 -o s"));
    for quality in ["fast", "best"] {
        place.ok(&format!("render s/raw.dng --pipeline {quality}.l3 -o {quality}.npy -q"));
    }
    let (shape, fast) = array(&place, "fast.npy");
    let (_, best) = array(&place, "best.npy");
    // The first stage of the table of best quality alone.
    let first = "render s/raw.dng --pipeline best.l3 --quality fast -o first.npy --json";
    let first = place.document(first);
    assert_eq!(first["quality"], "fast");
    assert_eq!(array(&place, "first.npy").1, fast);
    place.ok("render s/raw.dng --pipeline best.l3 --fixed -o fixed.npy -q");
    let (_, fixed) = array(&place, "fixed.npy");
    let peak = f64::from(best.iter().copied().fold(0.0, f32::max));
    let far =
        |a: &[f32]| a.iter().zip(&best).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / a.len() as f64;
    let psnr = 10.0 * (peak * peak / far(&fixed)).log10();
    println!("fixed point is {psnr:.1} dB from single precision");
    // The charts have 51 dB at 1 cd/m² (docs/how-to/firmware.md).
    assert!(psnr > 50.0, "fixed point is {psnr} dB from single precision");
    // In the middle of the first patch, which is uniform, what differs is noise.
    let spread = |xyz: &[f32]| {
        let cols = shape[2];
        let y: Vec<f64> =
            (0..64).map(|i| f64::from(xyz[(shape[1] + 8 + i / 8) * cols + 8 + i % 8])).collect();
        let mean = y.iter().sum::<f64>() / 64.0;
        (y.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 64.0).sqrt() / mean
    };
    assert!(spread(&best) < 0.5 * spread(&fast), "{} and {}", spread(&best), spread(&fast));
    // Tables and results state the quality.
    let compared =
        place.ok(&format!("compare bayer {flat} --luminance 80 --seeds 1 --pipeline best.l3 -o c"));
    assert!(compared.contains("l3 best"), "{compared}");
    let results = place.json("c/results.json");
    assert_eq!(results["results"][0]["quality"], "best", "{results}");
    assert_eq!(results["learned"][0]["quality"], "best");
    assert!(results.pointer("/results/0/scenes/0/fixed_point_psnr_db").unwrap().is_number());
    let page = String::from_utf8(place.read("c/report.html")).unwrap();
    assert!(page.contains("bayer l3 best") && page.contains("Quality best: "));
    let scored =
        place.ok("evaluate bayer --set sensor.rows=96 --set sensor.cols=144 --pipeline best.l3 -o e");
    assert!(scored.contains("bayer l3 best"), "{scored}");
    assert_eq!(place.json("e/results.json")["cameras"][0]["quality"], "best");
}
