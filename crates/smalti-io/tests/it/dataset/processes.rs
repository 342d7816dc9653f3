//! Concurrent and killed runs. The test program starts itself as the other process.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Duration;

use serde_json::json;
use smalti_io::dataset::{Dataset, DatasetError, Run};

use super::fixtures::{assert_same, columns, fill, plan, whole};

const DIR: &str = "SMALTI_TEST_DIR";
/// A worker with this variable waits for its input, which never comes, before its first part.
const HOLD: &str = "SMALTI_TEST_HOLD";
const TRIALS: u64 = 400;

/// The other process, which fills a folder until it has finished or is killed.
#[test]
#[ignore = "started by the other tests"]
fn worker() {
    let dir = std::env::var_os(DIR).unwrap();
    let run = Run::open(Path::new(&dir), &plan(TRIALS, 2), None).unwrap();
    println!("\nbegun");
    if std::env::var_os(HOLD).is_some() {
        std::io::stdin().read_line(&mut String::new()).unwrap();
    }
    for &chunk in run.missing() {
        let result = run.write(chunk, &columns(&run.manifest().plan, chunk));
        if let Err(error) = result {
            println!("\n{error}");
            return;
        }
    }
    run.finish(json!({})).unwrap();
    println!("\ndone");
}

/// Starts the worker with a shell command in which `"$@"` is the worker, and waits until it has locked the folder.
fn start(dir: &Path, command: &str) -> (Child, std::io::Lines<BufReader<ChildStdout>>) {
    let mut child = Command::new("bash")
        .args(["-c", command, "worker"])
        .arg(std::env::current_exe().unwrap())
        .args(["--ignored", "--exact", "--nocapture", "dataset::processes::worker"])
        .env(DIR, dir)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap() == "begun"));
    (child, lines)
}

#[test]
fn a_lock_ends_with_its_process_and_killed_runs_are_continued() {
    let dir = tempfile::tempdir().unwrap();
    let (results, expected) = (dir.path().join("results"), dir.path().join("expected"));
    let plan = plan(TRIALS, 2);
    whole(&expected, &plan);
    for round in 0..8 {
        // The first is still at work, however fast it is, when the folder is opened beside it.
        let command = if round == 0 { format!(r#"{HOLD}=1 exec "$@""#) } else { r#"exec "$@""#.to_owned() };
        let (mut child, lines) = start(&results, &command);
        if round == 0 {
            let error = Run::open(&results, &plan, None).unwrap_err();
            let by = format!("process {}", child.id());
            assert!(matches!(&error, DatasetError::Busy { by: b, .. } if b.starts_with(&by)), "{error}");
        }
        std::thread::sleep(Duration::from_millis(1 + 3 * round));
        child.kill().unwrap();
        child.wait().unwrap();
        drop(lines);
        // All existing parts are complete.
        Dataset::open(&results).unwrap().verify().unwrap();
    }
    // Adds a temporary file, in case no kill has interrupted a write.
    fs::write(results.join("trials/.part-000003.parquet.1-0.tmp"), b"PAR1").unwrap();
    let run = Run::open(&results, &plan, None).unwrap();
    fill(&run);
    assert_eq!(run.finish(json!({})).unwrap(), 0);
    assert_same(&results, &expected);
}

#[test]
fn a_file_that_cannot_grow_is_named_and_the_run_is_continued() {
    let dir = tempfile::tempdir().unwrap();
    let (results, expected) = (dir.path().join("results"), dir.path().join("expected"));
    let plan = plan(TRIALS, 2);
    whole(&expected, &plan);
    // The manifest is shorter than the limit, and every part is longer.
    let limit = fs::metadata(expected.join("manifest.json")).unwrap().len().div_ceil(1024);
    let smallest = fs::metadata(expected.join("trials/part-000000.parquet")).unwrap().len();
    assert!(smallest > limit * 1024, "{smallest} {limit}");
    let (mut child, lines) = start(&results, &format!(r#"trap "" XFSZ; ulimit -f {limit}; exec "$@""#));
    let said: Vec<String> = lines.map(Result::unwrap).filter(|l| l.starts_with("cannot write")).collect();
    child.wait().unwrap();
    let path = results.join("trials/part-000000.parquet");
    let [said] = &said[..] else { panic!("{said:?}") };
    assert!(said.starts_with(&format!("cannot write {} (finished parts are kept", path.display())), "{said}");
    // The cause ends the message, so that a chain of errors does not state it twice.
    assert!(said.contains("the same command resumes when it can be written): File too large"), "{said}");
    // No incomplete file remains.
    assert_eq!(fs::read_dir(results.join("trials")).unwrap().count(), 0);
    let run = Run::open(&results, &plan, None).unwrap();
    fill(&run);
    run.finish(json!({})).unwrap();
    assert_same(&results, &expected);
}
