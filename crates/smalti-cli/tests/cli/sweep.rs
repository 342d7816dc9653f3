//! `smalti sweep`: the same results whatever the threads, shards and interruptions; what it refuses.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::{Place, Run};

/// Two numbers of colours, two conditions: 72 trials.
const STUDY: &str = r#"
name = "small"
camera = "table1"
colors = [3, 4]
[sample]
filters = 6
mosaics = 3
[filters.gaussian_grid]
[mosaics.tile]
rows = 2
cols = 3
[conditions.grid]
luminance_cd_m2 = [20, 75]
"exposure.time_ms" = [10]
"#;

/// A folder with the study in it.
fn place(study: &str) -> Place {
    let place = Place::new();
    place.write("study.toml", study);
    place
}

/// Runs a sweep in parts of eight trials.
fn sweep(place: &Place, out: &str, more: &[&str]) -> Run {
    let args = ["sweep", "study.toml", "-o", out, "--part-size", "8"];
    place.run(&[&args[..], more].concat())
}

/// The files of results but for the manifest, which holds timings.
fn parts(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = fs::read_dir(dir.join("trials")).unwrap().map(|e| e.unwrap().path());
    files.map(|p| (p.file_name().unwrap().to_str().unwrap().to_owned(), fs::read(&p).unwrap())).collect()
}

#[test]
fn threads_and_shards_do_not_change_the_results() {
    let place = place(STUDY);
    let whole = sweep(&place, "whole", &["--threads", "1"]);
    assert_eq!((whole.code, whole.err.as_str()), (0, ""));
    assert!(whole.out.contains("72 trials") && whole.out.contains("is complete"), "{}", whole.out);
    let expected = parts(&place.path("whole"));
    assert_eq!(expected.len(), 9);

    assert_eq!(sweep(&place, "threads", &["--threads", "3"]).code, 0);
    assert_eq!(parts(&place.path("threads")), expected);
    // Shards in one folder, and in folders of their own that are merged.
    for (shard, own) in [("2/3", "b"), ("1/3", "a"), ("3/3", "c")] {
        assert_eq!(sweep(&place, "shards", &["--shard", shard]).code, 0);
        assert_eq!(sweep(&place, own, &["--shard", shard]).code, 0);
    }
    assert_eq!(parts(&place.path("shards")), expected);
    place.ok("sweep --merge a b c -o merged");
    assert_eq!(parts(&place.path("merged")), expected);
}

/// Without -o the folder has the name of the study, which is told.
#[test]
fn results_go_to_a_folder_that_the_study_names() {
    let place = place(STUDY);
    let shell = |words: &str| place.run(&words.split(' ').collect::<Vec<_>>());
    std::fs::rename(place.path("study.toml"), place.path("mine.toml")).unwrap();
    let dry = shell("sweep mine.toml --dry-run");
    assert!(dry.code == 0 && dry.out.contains("in the folder small\n"), "{}", dry.out);
    assert!(!place.path("small").exists());
    let run = shell("sweep mine.toml");
    assert!(
        run.code == 0 && run.err.contains("written to the folder small; -o DIR chooses another"),
        "{}",
        run.err
    );
    assert!(
        run.out.contains("`smalti report small` reports it") && place.path("small/manifest.json").is_file()
    );
    assert!(
        shell("sweep small/manifest.json -q").out.starts_with("nothing was left to do; small is complete")
    );
    // The folder of a merge has no study to name it.
    let merge = shell("sweep --merge small");
    assert!(merge.code == 2 && merge.err.contains("--output <DIR>"), "{}", merge.err);
}

/// Starts a sweep and kills it at work, again and again, then lets it end.
///
/// The moment is a number of parts on disk, and then a share of the time that a part takes, so that it falls at work however slow
/// the machine is: a sleep alone may outlast the run.
fn killed(times: u32) {
    let place = place(STUDY);
    let words = ["sweep", "study.toml", "--part-size", "1", "-o"];
    let run = |out: &str| place.run(&[&words[..], &[out]].concat());
    run("first");
    let start = Instant::now();
    assert_eq!(run("whole").code, 0);
    let part = start.elapsed() / 72;
    let mut kills = 0;
    for i in 0..10 * times {
        // Spread over the run and over a part, by the golden ratio and the root of two.
        let spread = |step: f64| (f64::from(i + 1) * step).fract();
        let before = place.names("broken/trials").len();
        let until = before + (spread(0.618_034) * (72 - before) as f64) as usize;
        let mut child = place
            .command()
            .args([&words[..], &["broken"]].concat())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        while place.names("broken/trials").len() < until && child.try_wait().unwrap().is_none() {
            sleep(part / 4);
        }
        sleep(part.mul_f64(spread(0.414_214)));
        kills += u32::from(child.try_wait().unwrap().is_none());
        child.kill().unwrap();
        child.wait().unwrap();
        if kills == times {
            break;
        }
        // Once it is nearly complete there is little left to break: some parts are taken away again.
        if place.names("broken/trials").len() > 50 {
            for part in (0..72).step_by(2) {
                let _ = fs::remove_file(place.path(&format!("broken/trials/part-{part:06}.parquet")));
            }
        }
    }
    assert_eq!(kills, times, "runs killed at work");
    let last = run("broken");
    assert_eq!(last.code, 0, "{}", last.err);
    assert_eq!(parts(&place.path("broken")), parts(&place.path("whole")));
}

#[test]
fn a_killed_sweep_goes_on() {
    killed(6);
}

/// `cargo test --release -p smalti-cli --test cli a_hundred_kills -- --ignored`
#[test]
#[ignore = "takes a minute; `just kills` runs it"]
fn a_hundred_kills() {
    killed(100);
}

#[cfg(unix)]
#[test]
fn a_stopped_sweep_says_how_to_go_on() {
    let place = place(&STUDY.replace("filters = 6", "filters = 300000"));
    let words = ["sweep", "study.toml", "--part-size", "8", "-o", "out"];
    let child = place.command().args(words).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let parts = || place.names("out/trials").iter().filter(|n| n.ends_with(".parquet")).count();
    while parts() == 0 {
        sleep(Duration::from_millis(20));
    }
    let stopped = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(stopped.unwrap().success());
    let ended = child.wait_with_output().unwrap();
    let said = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(130), "{said}");
    assert!(said.contains("stopped; out keeps the results so far"), "{said}");
    assert!(parts() > 0);
}

#[test]
fn another_study_in_the_same_folder_is_refused() {
    let place = place(STUDY);
    assert_eq!(sweep(&place, "out", &["--shard", "1/9"]).code, 0);
    let before = parts(&place.path("out"));
    place.write("study.toml", STUDY.replace("filters = 6", "filters = 7"));
    let refused = sweep(&place, "out", &[]);
    assert_eq!(refused.code, 1);
    let e = refused.err;
    assert!(e.contains("filter_sets") && e.contains('6') && e.contains('7'), "{e}");
    assert_eq!(parts(&place.path("out")), before);
}

#[test]
fn a_cut_part_is_refused() {
    let place = place(STUDY);
    assert_eq!(sweep(&place, "out", &["--shard", "1/9"]).code, 0);
    let part = "out/trials/part-000000.parquet";
    let bytes = place.read(part);
    place.write(part, &bytes[..bytes.len() / 2]);
    let run = sweep(&place, "out", &[]);
    assert!(run.code == 1 && run.err.contains("part-000000.parquet"), "{}", run.err);
}

#[test]
fn a_second_run_in_the_same_folder_is_refused() {
    // At work until it is killed.
    let place = place(&STUDY.replace("filters = 6", "filters = 300000"));
    let args = ["sweep", "study.toml", "-o", "busy"];
    let mut first = place.command().args(args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    while !place.path("busy/manifest.json").exists() && first.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(20));
    }
    let second = place.run(&args);
    first.kill().unwrap();
    first.wait().unwrap();
    assert!(second.code == 1 && second.err.contains("another run"), "{}", second.err);
}

#[test]
fn studies_that_cannot_be_are_refused_where_they_say_so() {
    let place = Place::new();
    let fails = |(what, by): (&str, &str), expected: &[&str]| {
        assert!(STUDY.contains(what), "{what}");
        place.write("study.toml", STUDY.replace(what, by));
        let run = sweep(&place, "none", &[]);
        assert_eq!(run.code, 1, "{by}: {}", run.err);
        assert!(expected.iter().all(|word| run.err.contains(word)), "{}\nexpected {expected:?}", run.err);
        assert!(!place.path("none").exists());
    };
    // 540 placements have all three colours; 6 of them look the same after one of the six shifts: (540 + 6) / 6.
    fails(("mosaics = 3", "mosaics = 1000"), &["study.toml:7", "1000", "has only 91"]);
    // Those of three colours are few enough; nothing is listed before all are counted.
    let tile = |mosaics: &str| {
        format!("mosaics = {mosaics}\n[filters.gaussian_grid]\n[mosaics.tile]\nrows = 4\ncols = 4")
    };
    let small = "mosaics = 3\n[filters.gaussian_grid]\n[mosaics.tile]\nrows = 2\ncols = 3";
    fails((small, &tile("\"all\"")), &["study.toml:7", "257706024 mosaics of 4 colours", "at most 6250000"]);
    let head = |colors: &str| format!("colors = [{colors}]\n[sample]\nfilters = 6\n");
    let (small, large) = (head("3, 4") + small, head("4, 5, 6") + &tile("3200000"));
    fails(
        (&small, &large),
        &[
            "study.toml:7",
            "9600000 mosaics are too many",
            "at most 6250000 of all numbers of colours together",
        ],
    );
    fails(("colors = [3, 4]", "colors = [9]"), &["no design"]);
    fails(("colors = [3, 4]", "colors = []"), &["no design"]);
    fails(("colors = [3, 4]", "colors = [3, 3]"), &["study.toml:4", "twice"]);
    fails(
        ("camera = \"table1\"", "camera = \"tabel1\""),
        &["study.toml:3", "tabel1: no such camera", "did you mean 'table1'"],
    );
    fails(("camera = \"table1\"", "camara = \"table1\""), &["study.toml:3", "camara"]);
    fails(("[filters.gaussian_grid]", "[filters.gaussian]"), &["study.toml:8", "gaussian_grid"]);
    fails(
        ("[filters.gaussian_grid]", "[filters.gaussian_grid]\nsigmas_nm = [10, 0, 60]"),
        &["study.toml:9", "sigmas_nm"],
    );
    fails(
        ("[filters.gaussian_grid]", "[filters.gaussian_grid]\nsigmas_nm = [10, 60]"),
        &["study.toml:9", "found 2 numbers", "[first, step, last]"],
    );
    fails(("[sample]", "[sensor]\nadc_bits = 10\n[sample]"), &["study.toml:5", "this is a camera file"]);
    fails(("luminance_cd_m2 = [20, 75]", "\"optics.f_numbr\" = [2, 4]"), &["f_numbr", "f_number"]);
    fails(
        ("luminance_cd_m2 = [20, 75]", "luminance = [20, 75]"),
        &["`luminance`", "did you mean `luminance_cd_m2`"],
    );
    fails(("luminance_cd_m2 = [20, 75]", "luminance_cd_m2 = [-1]"), &["luminance_cd_m2", "above 0"]);
    fails(("colors = [3, 4]", "colors = [3, 4]\nprocessing = \"fancy\""), &["study.toml:5"]);
    let processing = "colors = [3, 4]\nprocessing = [\"l3\", \"l3\"]";
    fails(("colors = [3, 4]", processing), &["study.toml:5", "twice"]);
    let learn = |by| ("[sample]", by);
    fails(learn("processing = \"l3\"\n[l3]\nside = 8\n[sample]"), &["study.toml", "`l3`", "side", "3, 5, 7"]);
    fails(learn("processing = \"l3\"\n[l3]\nlevels = 4000000000\n[sample]"), &["levels", "1 to 256"]);
    fails(learn("processing = \"l3\"\nset = { \"sensor.architecture\" = \"prism\" }\n[sample]"), &["mosaic"]);
    fails(("filters = 6", "filters = 0"), &["study.toml:6", "`sample.filters`"]);
    fails(
        ("[filters.gaussian_grid]", "[filters.gaussian_grid]\nmin_spacing_nm = 300"),
        &["study.toml:8", "`filters`", "0 sets"],
    );
    fails(("filters = 6", "filters = 9000000000000000000"), &["study.toml:6", "only"]);
}

#[test]
fn a_dry_run_counts_and_writes_nothing() {
    let place = place(STUDY);
    let dry = sweep(&place, "none", &["--dry-run", "--json"]);
    assert_eq!(dry.code, 0, "{}", dry.err);
    let document: serde_json::Value = serde_json::from_str(&dry.out).unwrap();
    assert_eq!((document["trials"].as_u64(), document["parts"].as_u64()), (Some(72), Some(9)));
    assert!(document["trials_per_s"].as_f64().unwrap() > 0.0 && !place.path("none").exists());
}

/// On a disk that is full the run fails by name of the file; with space it goes on.
#[test]
fn a_full_disk_is_told_and_the_run_goes_on() {
    let place = place(STUDY);
    let disk = place.path("disk");
    fs::create_dir(&disk).unwrap();
    let mount = |args: &[&str]| std::process::Command::new(args[0]).args(&args[1..]).arg(&disk).output();
    let mounted = mount(&["mount", "-t", "tmpfs", "-o", "size=48k", "tmpfs"]);
    if !mounted.is_ok_and(|o| o.status.success()) {
        eprintln!("skipped: no small disk can be mounted here");
        return;
    }
    let full = sweep(&place, "disk/out", &[]);
    let room = mount(&["mount", "-o", "remount,size=10m"]);
    let on = sweep(&place, "disk/out", &[]);
    let written = parts(&disk.join("out"));
    let _ = mount(&["umount"]);
    assert_eq!(full.code, 1);
    assert!(full.err.contains("disk/out") && full.err.contains("space"), "{}", full.err);
    assert!(room.is_ok_and(|o| o.status.success()));
    assert_eq!(on.code, 0, "{}", on.err);
    assert_eq!(sweep(&place, "whole", &[]).code, 0);
    assert_eq!(written, parts(&place.path("whole")));
}

/// A camera whose demosaicking suits no mosaic of the study, or conditions that make no difference.
#[test]
fn studies_whose_trials_cannot_differ_or_be_scored_are_told() {
    let study = "camera = \"machine-vision\"\ncolors = [3, 4]\n[sample]\nfilters = 2\n[filters.gaussian_grid]\n[mosaics]\n";
    let square = "[mosaics.tile]\nrows = 1\ncols = 3\n";
    let place = place(&study.replace("colors = [3, 4]", "colors = [3]").replace("[mosaics]\n", square));
    for dry in [&["--dry-run"][..], &[]] {
        let run = sweep(&place, "out", dry);
        assert_eq!((run.code, run.out.as_str()), (1, ""), "{}", run.err);
        for part in [
            "study.toml:1",
            "hamilton-adams1997",
            "no such mosaic",
            "set = { \"isp.demosaic\" = \"bilinear\" }",
        ] {
            assert!(run.err.contains(part), "no {part} in {}", run.err);
        }
    }
    assert!(place.names("out").is_empty());
    // Some of the mosaics are Bayer mosaics.
    let given = "given = [[\"bc\", \"ab\"], [\"ab\", \"cd\"]]\n";
    place.write("study.toml", format!("{study}{given}"));
    let run = sweep(&place, "some", &[]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.err.contains("trials of 1 of 2 mosaics will have no scores"), "{}", run.err);
    let text = place.ok("report some --pictures 0");
    assert!(text.contains("Left out: 2 trials without some or all scores. Reason: "), "{text}");
    assert!(!text.contains("No trial has scores"), "{text}");

    // The same light for every luminance.
    let lights = "[conditions.grid]\nluminance_cd_m2 = [1, 75]\n";
    let cured = format!("set = {{ \"isp.demosaic\" = \"bilinear\" }}\n{study}{given}{lights}");
    place.write("study.toml", &cured);
    let run = sweep(&place, "same", &["--dry-run"]);
    assert!(run.code == 0 && run.err.contains("the camera exposes automatically"), "{}", run.err);
    assert!(run.err.contains("\"exposure.time_ms\" = 33") && run.err.lines().count() == 1, "{}", run.err);
    place.write("study.toml", cured.replace("set = {", "set = { \"exposure.time_ms\" = 33,"));
    assert_eq!(sweep(&place, "same", &["--dry-run"]).err, "");
}

#[test]
#[cfg(target_os = "linux")]
fn a_folder_that_cannot_be_made_is_told_once() {
    let place = place(STUDY);
    let run = sweep(&place, "/proc/foo", &[]);
    assert_eq!(run.code, 1);
    assert!(run.err.contains("cannot write /proc/foo") && !run.err.contains("finished parts"), "{}", run.err);
    assert_eq!(run.err.matches("os error").count(), 1, "{}", run.err);
}
