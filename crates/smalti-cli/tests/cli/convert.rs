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
        let run = place.run(&["convert", &format!("{name}.exr"), "-o", &format!("{name}.npy")]);
        assert!(
            run.code == 0 && run.err.contains("without the wavelengths"),
            "what an array cannot hold is said: {}",
            run.err
        );
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
    assert!((0..16).all(|i| (planes.plane(0).unwrap()[i] - planes.plane(2).unwrap()[i]).abs() < 2.5 / 255.0));
    place.ok("convert uniform?size=4 -o a.tif");
    assert!(picture::read(&place.path("a.tif"), &ReadOptions::default()).is_ok());
}

#[test]
fn what_cannot_be_written_leaves_nothing() {
    let place = Place::new();
    for (words, expected) in [
        (
            "convert uniform?size=4 -o a.foo",
            "a.foo: expected a name that ends in .exr, .mat, .h5, .hdr, .npz, .npy, .png or .tif",
        ),
        ("convert uniform?size=4 -o no/a.exr", "cannot write no/a.exr: No such file or directory"),
        ("convert uniform?size=4 -o a.npy --wavelengths 400:0:700", "a positive step"),
        (
            "convert uniform?size=4 -o a.npy --wavelengths 400:700",
            "expected START:STEP:END, such as 400:10:700",
        ),
        ("convert uniform?size=4 -o a.npy --wavelengths 400:10:x", "'x' is not a number"),
        (
            "convert uniform?size=4 -o a.npy --wavelengths 100:10:4000",
            "--wavelengths 100:10:4000: uniform?size=4: the illuminant D65: the data cover 300",
        ),
        ("convert uniform?size=4 -o a.npz --interleave bil", "--interleave applies to ENVI"),
        ("convert uniform?size=4 -o a.png --layout pages", "--layout pages and samples apply to .tif"),
        ("convert uniform?size=4 -o a.tif --compress", "--compress applies to .tif with --layout"),
        ("convert uniform?size=4 -o a.hdr --crop 0,0,1,1", "uniform?size=4: --crop applies to files"),
        (
            "convert uniform?size=4 -o a.hdr --upsampling measured",
            "uniform?size=4: --upsampling applies to files",
        ),
        ("convert no.hdr -o a.npz", "no.hdr: the file of samples is absent"),
    ] {
        let run = place.run(&words.split(' ').collect::<Vec<_>>());
        assert_eq!((run.code, run.out.as_str()), (1, ""), "{words}: {}", run.err);
        assert!(run.err.contains(expected), "{words}: {}", run.err);
        // The words of the system come once.
        assert!(run.err.matches("os error").count() <= 1, "{}", run.err);
        assert!(place.names("").is_empty(), "{words}: {:?}", place.names(""));
    }
}

#[test]
fn formats_in_a_row_keep_the_scene_to_the_last_bit() {
    let place = Place::new();
    place.ok("convert macbeth?patch=4 -o direct.npy");
    place.ok("convert macbeth?patch=4 -o a.hdr");
    let run = place.run(&["convert", "a.hdr", "-o", "a.npz", "--upsampling", "measured"]);
    assert!(run.code == 1 && run.err.contains("a picture: this file holds spectra"), "{}", run.err);
    for words in [
        "a.hdr -o b.npz",
        "b.npz -o c.tif --layout pages",
        "c.tif -o d.tif --layout samples --compress",
        "d.tif -o e.bil",
        "e.bil -o f.hdr --interleave bip --distance 2 --fov 5",
    ] {
        place.ok(&format!("convert {words}"));
    }
    let run = place.run(&["convert", "f.hdr", "-o", "last.npy"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(place.read("direct.npy") == place.read("last.npy"));
    place.ok("simulate bayer --scene f.hdr --noise none -o o --fov 8");
    assert_eq!(place.json("o/metrics.json")["scene"]["distance_m"], 2.0);
    // A part has the bits of that part of the whole.
    place.ok("convert b.npz --crop 4,8,4,4 -o part.hdr");
    let run = place.run(&["convert", "part.hdr", "-o", "part.npy"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let ((shape, part), (_, whole)) = (photons(&place, "part.npy"), photons(&place, "direct.npy"));
    assert_eq!(shape, [31, 4, 4]);
    assert_eq!(part[4..8], whole[5 * 24 + 8..5 * 24 + 12]);
    let run = place.run(&["convert", "b.npz", "-o", "b.tif"]);
    assert!(
        run.err.contains("b.tif is a picture without spectra (use --layout pages or samples to keep them)"),
        "{}",
        run.err
    );
}

#[test]
fn what_a_file_does_not_say_can_be_given() {
    let place = Place::new();
    npy::write(&place.path("a.npy"), &[2, 3, 4], &(1..25).map(f64::from).collect::<Vec<_>>()).unwrap();
    let run = place.run(&["convert", "a.npy", "-o", "b.hdr"]);
    assert!(
        run.code == 1 && run.err.contains("the wavelengths given with the file (--wavelengths)"),
        "{}",
        run.err
    );
    place.ok("convert a.npy --wavelengths 500:10:530 --quantity reflectance -o b.hdr");
    let header = String::from_utf8(place.read("b.hdr")).unwrap();
    assert!(header.contains("reflectance scale factor = 1") && header.contains("samples = 3"), "{header}");
    npy::write(&place.path("n.npy"), &[1, 2, 4], &(-3..5).map(|v| v as f32).collect::<Vec<_>>()).unwrap();
    let run = place.run(&["convert", "n.npy", "--wavelengths", "500:10:530", "-o", "c.npz"]);
    assert!(
        run.err.contains("n.npy: channel 500 nm (band 1), row 0, column 0 (counted from 0) is -3"),
        "{}",
        run.err
    );
    place.ok("convert n.npy --wavelengths 500:10:530 --clamp-negative -o c.npz");
}

/// The most memory that a run of the program held, MiB.
#[cfg(target_os = "linux")]
fn peak_mib(place: &Place, words: &str) -> u64 {
    let mut child =
        place.command().args(words.split(' ')).stdout(std::process::Stdio::null()).spawn().unwrap();
    let mut peak = 0;
    let status = loop {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
        peak = line
            .and_then(|l| l.trim().trim_end_matches(" kB").parse().ok())
            .map_or(peak, |kib: u64| peak.max(kib / 1024));
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    };
    assert!(status.success(), "{words}");
    peak
}

#[cfg(target_os = "linux")]
#[test]
fn cubes_larger_than_memory_pass_through() {
    let place = Place::new();
    let header = "ENVI\nsamples = 2048\nlines = 2048\nbands = 16\ndata type = 1\ninterleave = bip\n\
                  wavelength units = nm\nwavelength = {400,410,420,430,440,450,460,470,480,490,500,510,520,530,540,550}\n";
    place.write("a.hdr", header);
    // Zeros that take no disk.
    std::fs::File::create(place.path("a.img")).unwrap().set_len(2048 * 2048 * 16).unwrap();
    // 256 MiB as 32-bit samples.
    for words in ["convert a.hdr -o b.npz", "convert b.npz -o c.bip", "convert a.hdr -o d.tif --layout pages"]
    {
        let peak = peak_mib(&place, words);
        println!("{words}: {peak} MiB");
        assert!(peak < 160, "{words}: {peak} MiB");
    }
    assert_eq!(std::fs::metadata(place.path("c.bip")).unwrap().len(), 256 << 20);
    let peak = peak_mib(&place, "convert b.npz --crop 1000,1000,64,64 -o e.hdr");
    println!("--crop: {peak} MiB");
    assert!(peak < 40, "{peak} MiB");
}
