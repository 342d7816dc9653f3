//! Inputs that are larger than what there is, or that never end, are errors and not the end of the program.
#![cfg(target_os = "linux")]

use std::process::Command;

use crate::{Place, Run};

/// Runs the program within limits of the shell, such as `-v 600000` (KiB).
fn within(place: &Place, limit: &str, words: &str) -> Run {
    let command = place.command();
    let mut shell = Command::new("sh");
    shell.current_dir(place.path("")).args(["-c", &format!("ulimit {limit} && exec \"$0\" \"$@\"")]);
    shell.arg(command.get_program()).args(words.split(' '));
    Run::of(&mut shell)
}

/// Samples of ENVI that take no room on the disk.
fn sparse_envi(place: &Place, name: &str, side: u64, bands: u64, quantity: &str) {
    let nm: Vec<String> = (0..bands).map(|b| (400 + 100 * b).to_string()).collect();
    place.write(
        &format!("{name}.hdr"),
        format!(
            "ENVI\nsamples = {side}\nlines = {side}\nbands = {bands}\ndata type = 4\ninterleave = bsq\nbyte order = 0\n\
             wavelength units = nm\nwavelength = {{{}}}\n{quantity}",
            nm.join(", ")
        ),
    );
    let samples = std::fs::File::create(place.path(&format!("{name}.img"))).unwrap();
    samples.set_len(side * side * bands * 4).unwrap();
}

#[test]
fn an_image_larger_than_memory_is_an_error() {
    let place = Place::new();
    // 192 MiB, then 4.5 GiB.
    sparse_envi(&place, "a", 4096, 3, "");
    sparse_envi(&place, "b", 20_000, 3, "");
    for (name, limit) in [("a", "-d 150000"), ("b", "-v 4000000")] {
        for extension in ["exr", "mat", "h5", "npy"] {
            let run = within(&place, limit, &format!("convert {name}.hdr -o out.{extension}"));
            assert_eq!(run.code, 1, "{name} to {extension}: {}", run.err);
            assert!(run.err.contains(" MB are available"), "{name} to {extension}: {}", run.err);
            assert!(!place.path(&format!("out.{extension}")).exists());
        }
    }
    // By parts, as the help of convert says.
    for extension in ["hdr", "npz"] {
        let run = within(&place, "-d 150000", &format!("convert a.hdr -o out.{extension}"));
        assert_eq!((run.code, run.err.as_str()), (0, ""), "{extension}");
    }
}

#[test]
fn a_picture_whose_spectra_are_larger_than_memory_is_an_error() {
    let place = Place::new();
    let side = 9000u32;
    let mut encoder = png::Encoder::new(std::fs::File::create(place.path("large.png")).unwrap(), side, side);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_compression(png::Compression::Fast);
    let row = vec![128u8; side as usize];
    let mut writer = encoder.write_header().unwrap();
    let mut rows = writer.stream_writer().unwrap();
    (0..side).for_each(|_| std::io::Write::write_all(&mut rows, &row).unwrap());
    rows.finish().unwrap();
    drop(writer);
    let run = within(&place, "-v 900000", "simulate bayer --scene large.png -o out");
    assert_eq!(run.code, 1, "{}", run.err);
    assert!(run.err.contains("large.png: the picture takes 1053 MB of memory"), "{}", run.err);
    assert!(!place.path("out/raw.dng").exists());
}

/// A device that never ends is read up to 64 MiB by every reader of whole files.
#[test]
fn a_device_without_an_end_is_an_error() {
    let place = Place::new();
    let zero = |name: &str| std::os::unix::fs::symlink("/dev/zero", place.path(name)).unwrap();
    ["a.dng", "a.l3", "a.png", "a.npy", "a.toml", "a.csv", "a.light"].into_iter().for_each(zero);
    for words in [
        "render a.dng --pipeline a.l3 -o out.png",
        "compare bayer --pipeline a.l3 -o out",
        "simulate bayer --scene a.png -o out",
        "convert a.npy -o out.npz",
        "show a.toml",
        "evaluate bayer --illuminant a.csv",
        "train bayer --pair a.dng a.png -o out.l3",
    ] {
        let run = within(&place, "-v 2000000", words);
        assert_eq!(run.code, 1, "{words}: {}", run.err);
        assert!(run.err.starts_with("error: ") && run.err.contains("a."), "{words}: {}", run.err);
    }
}
