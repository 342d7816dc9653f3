//! The command from end to end: the built program, its files, its messages, its exit codes.
#![allow(clippy::unwrap_used, clippy::panic)]

mod bad_input;
mod binning;
mod cache;
mod camera_dng;
mod camera_keys;
mod camera_text;
mod compare;
mod compare_page;
mod convert;
mod design;
mod evaluate;
mod experiments;
mod flat_field;
#[path = "../../../smalti/tests/it/gaussian_sets.rs"]
mod gaussian_sets;
mod hostile;
mod ir_cut;
mod learn;
mod learn_bad;
mod licences;
mod limits;
mod mosaics;
mod rate;
mod real_camera;
mod reference;
mod shell;
mod show;
mod simulate;
mod studio;
mod study_report;
mod surface;
mod sweep;
mod sweep_scores;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of its own, where the program runs and keeps its cache.
struct Place {
    dir: tempfile::TempDir,
}

/// What the program did.
struct Run {
    code: i32,
    out: String,
    err: String,
}

impl Run {
    fn of(command: &mut Command) -> Self {
        let Output { status, stdout, stderr } = command.output().unwrap();
        let run = Run {
            code: status.code().unwrap(),
            out: String::from_utf8(stdout).unwrap(),
            err: String::from_utf8(stderr).unwrap(),
        };
        assert!(!run.err.contains("panicked") && run.code != 101, "{}", run.err);
        run
    }
}

impl Place {
    fn new() -> Self {
        Self { dir: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_smalti"));
        command.current_dir(self.dir.path()).env("SMALTI_CACHE_DIR", self.path("cache"));
        command
    }

    fn run<S: AsRef<std::ffi::OsStr>>(&self, args: &[S]) -> Run {
        Run::of(self.command().args(args))
    }

    /// Words separated by spaces; the program must succeed in silence.
    fn ok(&self, words: &str) -> String {
        let run = self.run(&words.split_whitespace().collect::<Vec<_>>());
        assert_eq!((run.code, run.err.as_str()), (0, ""), "smalti {words}");
        run.out
    }

    /// The JSON document that the program prints.
    fn document(&self, words: &str) -> serde_json::Value {
        serde_json::from_str(&self.ok(words)).unwrap()
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&self.read(name)).unwrap()
    }

    /// Names in a folder, sorted; none where it is absent.
    fn names(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).into_iter().flatten();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

fn numbers(v: &serde_json::Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// Runs a script of smalti-io's tests; one JSON value per line of its output. `None`, with a message, without Python
/// (`$SMALTI_PYTHON`, else `python3`) or the packages.
fn python(script: &str, packages: &str, arguments: &[&Path]) -> Option<Vec<serde_json::Value>> {
    let python = std::env::var("SMALTI_PYTHON").unwrap_or_else(|_| "python3".into());
    let here = Command::new(&python).args(["-c", &format!("import {packages}")]).output();
    if !here.is_ok_and(|o| o.status.success()) {
        eprintln!("skipped: no {python} with {packages}");
        return None;
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../smalti-io/tests/python").join(script);
    let output = Command::new(&python).arg(path).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(
        String::from_utf8(output.stdout).unwrap().lines().map(|l| serde_json::from_str(l).unwrap()).collect(),
    )
}
