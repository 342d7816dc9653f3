//! Names, paths, keys and values that hold control codes do not reach the terminal.

use std::path::Path;

use crate::{Place, Run};

/// A title, a colour in eight bits, a change of direction, and a line that looks like a message.
const HOSTILE: &str = "x\u{1b}]0;title\u{7}\u{9b}31m\u{202e}\u{2066}y\nerror: not mine";

/// Fails where a character steers the terminal, or the hostile text has begun a line.
fn check(run: &Run, what: &str) {
    for text in [&run.out, &run.err] {
        let wrong = text.chars().find(|&c| smalti::names::steers(c) && c != '\n');
        assert_eq!(wrong, None, "{what}: {text:?}");
        assert!(!text.lines().any(|line| line.starts_with("error: not mine")), "{what}: {text}");
    }
}

#[test]
fn nothing_that_is_typed_or_read_steers_the_terminal() {
    let place = Place::new();
    let toml = "x\\u001B]0;title\\u0007\\u009B31m\\u202E\\u2066y\\nerror: not mine";
    place.write("name.toml", format!("name = \"{toml}\"\n"));
    place.write("key.toml", format!("\"{toml}\" = 1\n"));
    place.write("value.toml", format!("[exposure]\nauto = \"{toml}\"\n"));
    place.write("comment.toml", "[optics]\nf_number = \"wide\" # \u{1b}]0;title\u{7}\u{202e}\n");
    place.write(
        "letter.toml",
        "[sensor.cfa]\npattern = [\"\\u001B\"]\nfilters = { \"\\u001B\" = { flat = 1 } }\n",
    );
    place.write("study.toml", format!("name = \"{toml}\"\ncamera = \"bayer\"\ncolors = [3]\nfilters = {{ gaussian_grid = {{}} }}\nmosaics = \"catalogue\"\n"));
    place.write("about.toml", format!("about = \"{toml}\"\ncamera = \"bayer\"\ncolors = [3]\nfilters = {{ gaussian_grid = {{}} }}\nmosaics = \"catalogue\"\n"));
    place.write(
        "design.toml",
        format!("name = \"{toml}\"\ncamera = \"bayer\"\ncolors = [3]\nfilters = {{ free = {{}} }}\nmosaics = \"catalogue\"\n"),
    );
    place.write("a.hdr", format!("ENVI\nsamples = 2\nlines = 2\nbands = 2\nfile type = {HOSTILE}\n"));
    place.write("b.hdr", "ENVI\nsamples = 2\nlines = 2\nbands = 2\ninterleave = \u{1b}[1mbsq\u{202e}\n");
    place.write("light.csv", "wavelength_nm,\u{1b}[1m\n400,a\u{9b}\n");
    for (words, code) in [
        (vec!["evaluate", "name.toml"], 1),
        (vec!["show", "key.toml"], 1),
        (vec!["show", "value.toml"], 1),
        (vec!["show", "comment.toml"], 1),
        (vec!["show", "letter.toml"], 1),
        (vec!["sweep", "study.toml", "--dry-run"], 0),
        (vec!["design", "design.toml", "-o", "found"], 1),
        (vec!["show", "about.toml", "--color", "never"], 0),
        (vec!["show", "about.toml", "--json"], 0),
        (vec!["convert", "a.hdr", "-o", "a.npy"], 1),
        (vec!["convert", "b.hdr", "-o", "b.npy"], 1),
        (vec!["evaluate", "bayer", "--illuminant", "light.csv"], 1),
        (vec!["evaluate", HOSTILE], 1),
        (vec!["evaluate", "bayer", "--set", HOSTILE], 2),
        (vec!["evaluate", "bayer", "--set", &format!("name={HOSTILE}")], 1),
        (vec!["evaluate", "bayer", "--set", &format!("{HOSTILE}=1")], 1),
        (vec!["evaluate", "bayer", "--luminance", HOSTILE], 2),
        (vec![HOSTILE], 2),
        (vec!["simulate", "bayer", "--scene", HOSTILE, "-o", "out"], 1),
        (vec!["simulate", "bayer", "--scene", "uniform?size=8", "-o", "name.toml/\u{1b}[1m\u{202e}"], 1),
        (vec!["show", &format!("{HOSTILE}.exr")], 1),
        (vec!["report", HOSTILE], 1),
        (vec!["render", HOSTILE, "--pipeline", HOSTILE, "-o", "a.png"], 1),
    ] {
        let run = place.run(&words);
        assert_eq!(run.code, code, "{words:?}: {}", run.err);
        check(&run, &format!("{words:?}"));
    }
    // Results name the path that was asked for.
    let run = place.run(&["convert", "uniform?size=2", "-o", "a\u{1b}[1m\u{202e}.npy"]);
    assert_eq!((run.code, run.out.as_str()), (0, "a�[1m�.npy\n"));
}

/// Drawings have control codes of their own, and no others.
#[test]
fn a_coloured_drawing_holds_its_own_codes_alone() {
    let place = Place::new();
    place.write("about.toml", "about = \"\\u001B]0;title\\u0007\\u202E\"\ncamera = \"bayer\"\ncolors = [3]\nfilters = { gaussian_grid = {} }\nmosaics = \"catalogue\"\n");
    place.write("mixed.toml", "[sensor.cfa]\npattern = [\"Ra\"]\nfilters = { R = { flat = 1 }, G = { flat = 0.5 } }\nmixtures = { a = { R = 0.5, G = 0.5 } }\n");
    for name in ["about.toml", "mixed.toml", "rgbw"] {
        let run = place.run(&["show", name, "--color", "always", "--graphics", "blocks"]);
        assert_eq!(run.code, 0, "{}", run.err);
        let mut rest = run.out.as_str();
        let mut text = String::new();
        while let Some((before, code)) = rest.split_once("\u{1b}[") {
            let (numbers, after) = code.split_once('m').unwrap();
            assert!(numbers.bytes().all(|b| b.is_ascii_digit() || b == b';'), "{name}: {numbers:?}");
            text += before;
            rest = after;
        }
        text += rest;
        check(&Run { out: text, ..run }, name);
    }
}

/// Output goes through one module.
#[test]
fn no_other_module_writes_to_the_terminal() {
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            files += 1;
            let text = std::fs::read_to_string(&path).unwrap();
            let name = path.file_name().unwrap().to_str().unwrap();
            for writes in
                ["print!(", "println!(", "stdout().lock", "stderr().lock", "io::stdout().write", "dbg!("]
            {
                assert!(name == "output.rs" || !text.contains(writes), "{}: {writes}", path.display());
            }
        }
    }
    assert!(files > 30, "{files}");
}
