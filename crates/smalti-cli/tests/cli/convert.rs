//! `smalti convert`.

use smalti_io::ReadOptions;
use smalti_io::{Limits, npy, picture};

use crate::Place;

fn photons(place: &Place, name: &str) -> (Vec<usize>, Vec<f32>) {
    let array = npy::read(&place.path(name), Limits::default()).unwrap();
    let data = array.to_f32();
    (array.shape, data)
}

#[test]
fn a_scene_survives_both_layouts_of_exr() {
    let place = Place::new();
    assert_eq!(place.ok("convert macbeth?patch=4 -o direct.npy"), "direct.npy\n");
    place.ok("convert macbeth?patch=4 -o fichet.exr");
    place.ok("convert macbeth?patch=4 -o pbrt.exr --layout pbrt");
    let (shape, direct) = photons(&place, "direct.npy");
    assert_eq!(shape, [31, 16, 24]);
    for name in ["fichet", "pbrt"] {
        place.ok(&format!("convert {name}.exr -o {name}.npy"));
        let (its_shape, back) = photons(&place, &format!("{name}.npy"));
        assert_eq!(its_shape, shape);
        let worst = direct.iter().zip(&back).map(|(a, b)| (b / a - 1.0).abs()).fold(0.0f32, f32::max);
        // Photons to energy and back, and half a nanometre's radiance: each rounds once, to 6e-8.
        assert!(worst < 4e-7, "{name}: {worst:e}");
    }
    // The scene in the file is the scene: what is stated of it too.
    for scene in ["macbeth?patch=4", "fichet.exr"] {
        place.ok(&format!("simulate bayer --scene {scene} --noise none -o {} --fov 8", &scene[..4]));
    }
    let (a, b) = (place.json("macb/metrics.json"), place.json("fich/metrics.json"));
    for key in ["distance_m", "horizontal_fov_deg"] {
        assert_eq!(a["scene"][key], b["scene"][key]);
    }
    let lux = |m: &serde_json::Value| m["mean_illuminance_lux"].as_f64().unwrap();
    assert!((lux(&a) / lux(&b) - 1.0).abs() < 1e-5);
}

#[test]
fn wavelengths_light_and_luminance_can_be_chosen() {
    let place = Place::new();
    place.ok("convert uniform?size=4 -o a.npy --wavelengths 420:20:680 --luminance 50");
    place.ok("convert uniform?size=4 -o b.npy --wavelengths 420:20:680 --luminance 100 --illuminant A");
    let ((shape, a), (_, b)) = (photons(&place, "a.npy"), photons(&place, "b.npy"));
    assert_eq!(shape, [14, 4, 4]);
    let (blue, red) = (0, 13 * 16);
    assert!(a[blue] > a[red] * 0.5 && b[red] > 4.0 * b[blue], "daylight is bluer than a lamp");
    place.ok("convert uniform?size=4 -o a.png");
    let shown = picture::read(&place.path("a.png"), &ReadOptions::default()).unwrap().image;
    // White under the light of the scene, D65, is white: all planes the same to two levels.
    let planes = shown.planes();
    assert!((0..16).all(|i| (planes.plane(0)[i] - planes.plane(2)[i]).abs() < 2.5 / 255.0));
    place.ok("convert uniform?size=4 -o a.tif");
    assert!(picture::read(&place.path("a.tif"), &ReadOptions::default()).is_ok());
}

#[test]
fn what_cannot_be_written_leaves_nothing() {
    let place = Place::new();
    for (words, expected) in [
        ("convert uniform?size=4 -o a.foo", "a.foo: expected a name that ends in .exr, .png, .tif or .npy"),
        ("convert uniform?size=4 -o no/a.exr", "cannot write no/a.exr: No such file or directory"),
        ("convert uniform?size=4 -o a.npy --wavelengths 400:0:700", "a positive step"),
        (
            "convert uniform?size=4 -o a.npy --wavelengths 400:700",
            "expected START:STEP:END, such as 400:10:700",
        ),
        ("convert uniform?size=4 -o a.npy --wavelengths 400:10:x", "'x' is not a number"),
        (
            "convert uniform?size=4 -o a.npy --wavelengths 100:10:4000",
            "--wavelengths 100:10:4000: the illuminant D65: the data cover 300",
        ),
    ] {
        let run = place.run(&words.split(' ').collect::<Vec<_>>());
        assert_eq!((run.code, run.out.as_str()), (1, ""), "{words}: {}", run.err);
        assert!(run.err.contains(expected), "{words}: {}", run.err);
        // The words of the system come once.
        assert!(run.err.matches("os error").count() <= 1, "{}", run.err);
        assert!(place.names("").is_empty(), "{words}: {:?}", place.names(""));
    }
}
