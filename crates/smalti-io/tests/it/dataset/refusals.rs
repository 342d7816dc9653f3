//! Folders, parts and plans that are refused.

use std::fs;
use std::path::Path;

use serde_json::json;
use smalti_io::dataset::{Column, Dataset, DatasetError, PartProblem, Plan, Run, Shard};

use super::fixtures::{columns, content, plan, whole};

fn part(dir: &Path, chunk: u64) -> std::path::PathBuf {
    dir.join(format!("trials/part-{chunk:06}.parquet"))
}

#[test]
fn a_changed_study_is_refused_with_the_difference() {
    let dir = tempfile::tempdir().unwrap();
    let plan = plan(30, 10);
    whole(dir.path(), &plan);
    let before = content(dir.path());
    let mut changed = Plan { trials: 40, ..plan.clone() };
    changed.study["camera"]["pitch_um"] = json!(1.4);
    changed.study["camera"]["cfa"] = json!(["RG"]);
    changed.schema[2].unit = "ΔE00".into();
    let error = Run::open(dir.path(), &changed, None).unwrap_err();
    assert!(matches!(error, DatasetError::OtherStudy { .. }));
    let expected = format!(
        "{} holds the results of another study or version:\n  camera.pitch_um: 2.2 → 1.4\n  camera.cfa[1]: \"GB\" → (absent)\n  \
         (trials): 30 → 40\n  (schema)[2].unit: \"ΔE*ab\" → \"ΔE00\"\nChoose another folder, or undo the change.",
        dir.path().display()
    );
    assert_eq!(error.to_string(), expected);
    assert_eq!(content(dir.path()), before);
}

/// Replaces a text in the manifest.
fn edit(dir: &Path, from: &str, to: &str) {
    let path = dir.join("manifest.json");
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{text}");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
}

#[test]
fn another_revision_and_a_damaged_manifest_are_refused() {
    let plan = plan(3, 2);
    for (from, to, message) in [
        (
            r#""revision": 2"#,
            r#""revision": 1"#,
            "it is version 1 of the results format; version 2 is read here",
        ),
        (r#""smalti-results""#, r#""x""#, r#"format is "x"; expected "smalti-results""#),
        (r#""seed": 7"#, r#""seed": 8"#, "it is damaged: its content has the hash"),
        (r#""chunk": 2"#, r#""chunk": 0"#, "its plan is invalid: the number of trials in a chunk is 0"),
        ("{", "[", "not a valid manifest file"),
    ] {
        let dir = tempfile::tempdir().unwrap();
        whole(dir.path(), &plan);
        edit(dir.path(), from, to);
        for error in [Dataset::open(dir.path()).unwrap_err(), Run::open(dir.path(), &plan, None).unwrap_err()]
        {
            let error = error.to_string();
            assert!(error.contains("manifest.json: ") && error.contains(message), "{error}");
        }
    }
}

#[test]
fn a_folder_with_other_things_is_not_filled() {
    let dir = tempfile::tempdir().unwrap();
    let target = dir.path().join("photos");
    fs::create_dir(&target).unwrap();
    fs::write(target.join("cat.jpg"), b"").unwrap();
    let error = Run::open(&target, &plan(3, 2), None).unwrap_err();
    assert!(matches!(&error, DatasetError::NotResults { found, .. } if found == "cat.jpg"), "{error}");
    assert_eq!(fs::read_dir(&target).unwrap().count(), 1);
    let error = Run::open(&target.join("cat.jpg"), &plan(3, 2), None).unwrap_err().to_string();
    assert!(error.contains("cat.jpg"), "{error}");
    assert!(matches!(Dataset::open(&target), Err(DatasetError::NoResults { .. })));
    assert!(matches!(Dataset::open(&target.join("no")), Err(DatasetError::NoResults { .. })));
}

#[test]
fn a_stray_file_among_the_parts_is_refused_and_others_are_not() {
    let dir = tempfile::tempdir().unwrap();
    let plan = plan(3, 2);
    whole(dir.path(), &plan);
    for name in ["trials/.DS_Store", "report.html"] {
        fs::write(dir.path().join(name), b"").unwrap();
    }
    drop(Run::open(dir.path(), &plan, None).unwrap());
    for name in ["part-000002.parquet", "part-1.parquet", "copy.parquet", "notes.txt"] {
        let path = dir.path().join("trials").join(name);
        fs::write(&path, b"").unwrap();
        for error in [Run::open(dir.path(), &plan, None).unwrap_err(), Dataset::open(dir.path()).unwrap_err()]
        {
            assert!(matches!(&error, DatasetError::Stray { path: p } if *p == path), "{error}");
        }
        fs::remove_file(path).unwrap();
    }
}

#[test]
fn a_part_cut_short_is_found_when_a_run_continues_and_when_it_is_read() {
    let dir = tempfile::tempdir().unwrap();
    let plan = plan(30, 10);
    whole(dir.path(), &plan);
    let path = part(dir.path(), 1);
    let good = fs::read(&path).unwrap();
    for length in [0, 3, 11, 12, 100, good.len() / 2, good.len() - 1] {
        fs::write(&path, &good[..length]).unwrap();
        for error in [
            Run::open(dir.path(), &plan, None).unwrap_err(),
            Dataset::open(dir.path()).unwrap().verify().unwrap_err(),
        ] {
            let text = error.to_string();
            assert!(
                matches!(error, DatasetError::Part { problem: PartProblem::Truncated { .. }, .. }),
                "{text}"
            );
            let expected = format!(
                "{} is truncated or not a Parquet file ({length} bytes); delete it and run the sweep again to recompute \
                 its trials",
                path.display()
            );
            assert_eq!(text, expected);
        }
    }
    // The advice of the message works.
    fs::remove_file(&path).unwrap();
    let run = Run::open(dir.path(), &plan, None).unwrap();
    run.write(1, &columns(&plan, 1)).unwrap();
    run.finish(json!(null)).unwrap();
    assert_eq!(fs::read(&path).unwrap(), good);
}

#[test]
fn parts_of_another_study_or_place_are_refused() {
    let [one, two] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let plan = plan(30, 10);
    let mut other = plan.clone();
    other.study["seed"] = json!(8);
    whole(one.path(), &plan);
    whole(two.path(), &other);
    for (from, key) in [(part(two.path(), 1), "smalti.plan_blake3"), (part(one.path(), 2), "smalti.chunk")] {
        fs::copy(from, part(one.path(), 1)).unwrap();
        for error in [
            Run::open(one.path(), &plan, None).unwrap_err(),
            Dataset::open(one.path()).unwrap().verify().unwrap_err(),
        ] {
            let foreign = matches!(&error, DatasetError::Part { problem: PartProblem::Foreign { key: k, .. }, .. } if *k == key);
            assert!(foreign, "{error}");
        }
    }
}

#[test]
fn one_run_at_a_time_and_one_of_each_shard() {
    let dir = tempfile::tempdir().unwrap();
    let plan = plan(30, 10);
    let open = |shard: Option<&str>| Run::open(dir.path(), &plan, shard.map(|s| s.parse::<Shard>().unwrap()));
    let busy = |shard: Option<&str>| match open(shard) {
        Err(DatasetError::Busy { by, .. }) => by,
        other => panic!("{other:?}"),
    };
    let own = format!("process {}", std::process::id());
    let whole = open(None).unwrap();
    assert!(busy(None).starts_with(&own), "{}", busy(None));
    assert!(busy(Some("1/2")).starts_with(&own));
    drop(whole);
    let one = open(Some("1/3")).unwrap();
    let _two = open(Some("2/3")).unwrap();
    for (shard, by) in [
        (Some("2/3"), format!("shard 2/3, {own}")),
        (Some("1/2"), format!("shard 1/3, {own}")),
        (None, format!("shard 1/3, {own}")),
    ] {
        // The message names either of the two shards, depending on the order of the listing.
        assert!(busy(shard).replace("2/3", "1/3").starts_with(&by.replace("2/3", "1/3")), "{}", busy(shard));
    }
    assert!(busy(None).ends_with(", and 1 more"));
    drop(one);
    drop(open(Some("1/3")).unwrap());
    drop(_two);
    open(None).unwrap();
}

#[test]
fn plans_and_chunks_that_cannot_be_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path().join("new");
    let good = plan(30, 10);
    let nameless = Plan { schema: vec![], ..good.clone() };
    for (plan, message) in [
        (plan(0, 10), "the number of trials is 0; expected at least 1"),
        (plan(1, 0), "the number of trials in a chunk is 0; expected 1 to 1048576"),
        (plan(1_000_001, 1), "the number of parts is 1000001; expected at most 1000000; choose larger parts"),
        (plan(u64::MAX, 1 << 20), "the number of parts is 17592186044416; expected at most 1000000"),
        (nameless, "the list of columns is empty; expected at least one"),
    ] {
        let error = Run::open(&dir, &plan, None).unwrap_err().to_string();
        assert!(error.starts_with(message), "{error}");
    }
    assert!(!dir.exists());
    let run = Run::open(&dir, &good, None).unwrap();
    for chunk in [3, u64::MAX] {
        assert!(matches!(run.write(chunk, &columns(&good, 0)), Err(DatasetError::NotOwn { .. })));
    }
    let mut short = columns(&good, 0);
    short[0] = Column::Int(vec![1]);
    assert!(matches!(run.write(0, &short), Err(DatasetError::Columns { .. })));
    assert_eq!(fs::read_dir(dir.join("trials")).unwrap().count(), 0);
}
