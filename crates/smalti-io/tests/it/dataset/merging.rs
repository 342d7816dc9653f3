//! Merging of the folders of shards.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::json;
use smalti_io::dataset::{Column, Dataset, DatasetError, PartProblem, Plan, Run, Shard, merge};

use super::fixtures::{assert_same, columns, fill, plan, whole};

/// Completes each shard of a plan in its own folder.
fn shards(dir: &Path, plan: &Plan, of: u32) -> Vec<PathBuf> {
    let one = |index| {
        let folder = dir.join(format!("{index}-of-{of}"));
        let run = Run::open(&folder, plan, Some(Shard::new(index, of).unwrap())).unwrap();
        fill(&run);
        run.finish(json!({"seconds": index})).unwrap();
        folder
    };
    (1..=of).map(one).collect()
}

#[test]
fn merged_shards_are_a_whole_run() {
    let dir = tempfile::tempdir().unwrap();
    let plan = plan(95, 10);
    let expected = dir.path().join("whole");
    whole(&expected, &plan);
    let from = shards(dir.path(), &plan, 3);
    let into = dir.path().join("into");
    merge(&from, &into).unwrap();
    assert_same(&into, &expected);
    let manifest = Dataset::open(&into).unwrap().manifest().clone();
    let runs: Vec<_> = manifest.runs.iter().map(|r| (r.shard.clone().unwrap(), r.parts)).collect();
    assert_eq!(runs, [("1/3".to_owned(), 4), ("2/3".into(), 3), ("3/3".into(), 3)]);
    // An interrupted merge is resumed, and no run is recorded twice.
    fs::remove_file(into.join("trials/part-000004.parquet")).unwrap();
    merge(&from, &into).unwrap();
    assert_same(&into, &expected);
    assert_eq!(*Dataset::open(&into).unwrap().manifest(), manifest);
    // The target is one of the folders, and some chunks are in two of them.
    merge(&[from.clone(), vec![into]].concat(), &from[0]).unwrap();
    assert_same(&from[0], &expected);
}

#[test]
fn shards_that_make_no_whole_are_refused_before_anything_is_written() {
    let dir = tempfile::tempdir().unwrap();
    let plan = plan(95, 10);
    let from = shards(dir.path(), &plan, 3);
    let into = dir.path().join("into");
    let error = merge(&from[1..], &into).unwrap_err();
    assert!(matches!(error, DatasetError::Incomplete { missing: 4, chunks: 10, first: 0 }), "{error}");
    assert!(matches!(merge(&[], &into), Err(DatasetError::NothingToMerge)));
    let mut other = plan.clone();
    other.study["seed"] = json!(8);
    let others = dir.path().join("other");
    whole(&others, &other);
    let error = merge(&[from[0].clone(), others], &into).unwrap_err().to_string();
    assert!(error.contains("\n  seed: 7 → 8\n"), "{error}");
    assert!(!into.exists());
}

#[test]
fn damaged_and_contradicting_parts_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let plan = plan(95, 10);
    let mut from = shards(dir.path(), &plan, 2);
    let odd = dir.path().join("odd");
    let run = Run::open(&odd, &plan, None).unwrap();
    let mut columns = columns(&plan, 3);
    columns[0] = Column::Int(vec![1; 10]);
    run.write(3, &columns).unwrap();
    drop(run);
    from.push(odd);
    for into in ["a", "b"] {
        let error = merge(&from, &dir.path().join(into)).unwrap_err();
        assert!(matches!(error, DatasetError::Conflict { .. }), "{error}");
        from.reverse();
    }
    from.retain(|f| !f.ends_with("odd"));
    let part = from[1].join("trials/part-000003.parquet");
    let mut bytes = fs::read(&part).unwrap();
    bytes[40] ^= 1;
    fs::write(&part, bytes).unwrap();
    let error = merge(&from, &dir.path().join("c")).unwrap_err();
    assert!(matches!(error, DatasetError::Part { problem: PartProblem::Damaged { .. }, .. }), "{error}");
}
