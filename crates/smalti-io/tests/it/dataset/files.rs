//! Values are read back as written, and equal plans give identical files.

use std::fs;

use rayon::prelude::*;
use serde_json::json;
use smalti_io::dataset::{Column, ColumnKind, Dataset, Plan, Run, Shard};

use super::fixtures::{assert_same, bits, columns, content, fill, plan, spec, whole};

#[test]
fn every_kind_of_column_is_read_back_bit_for_bit() {
    let dir = tempfile::tempdir().unwrap();
    let plan = plan(103, 10);
    whole(dir.path(), &plan);
    let dataset = Dataset::open(dir.path()).unwrap();
    assert_eq!((dataset.manifest().plan == plan, dataset.is_complete(), dataset.trials()), (true, true, 103));
    dataset.verify().unwrap();
    let names: Vec<&str> = plan.schema.iter().map(|c| c.name.as_str()).collect();
    let mut seen = 0;
    for (chunk, part) in dataset.columns(&names).unwrap().enumerate() {
        let part = part.unwrap();
        assert_eq!((part.chunk, part.trials.clone()), (chunk as u64, plan.trials_of(chunk as u64)));
        seen += part.trials.end - part.trials.start;
        for (read, written) in part.columns.iter().zip(columns(&plan, part.chunk)) {
            assert_eq!(read.kind(), written.kind());
            assert_eq!(bits(read), bits(&written));
        }
    }
    assert_eq!(seen, 103);
    // A subset of the columns in another order, one of them twice.
    let part = dataset.columns(&["mosaic", "trial", "mosaic"]).unwrap().last().unwrap().unwrap();
    let written = columns(&plan, 10);
    assert_eq!(part.columns, [written[3].clone(), written[0].clone(), written[3].clone()]);
    let error = dataset.columns(&["mosaics"]).unwrap_err().to_string();
    assert!(
        error.ends_with(
            r#"unknown column "mosaics"; the columns are trial, seed, delta_e, mosaic, centers_nm"#
        )
    );
}

#[test]
fn columns_of_many_pages_are_read_back() {
    let dir = tempfile::tempdir().unwrap();
    let rows = 150_000u64;
    let schema = vec![
        spec("text", ColumnKind::Text, ""),
        spec("list", ColumnKind::Floats, ""),
        spec("number", ColumnKind::Float, ""),
    ];
    let plan = Plan { schema, ..plan(rows, rows) };
    // Distinct texts exceed the limit of the dictionary, so that the rest is stored as plain text.
    let columns = [
        Column::Text((0..rows).map(|i| format!("a text of its own, number {i}")).collect()),
        Column::Floats((0..rows).map(|i| vec![i as f64 * 0.1; (i % 4) as usize]).collect()),
        Column::Float((0..rows).map(|i| if i % 3 == 0 { f64::NAN } else { (i as f64).sqrt() }).collect()),
    ];
    let run = Run::open(dir.path(), &plan, None).unwrap();
    run.write(0, &columns).unwrap();
    run.finish(json!(null)).unwrap();
    let dataset = Dataset::open(dir.path()).unwrap();
    let part = dataset.columns(&["text", "list", "number"]).unwrap().next().unwrap().unwrap();
    for (read, written) in part.columns.iter().zip(&columns) {
        assert!(bits(read) == bits(written));
    }
}

#[test]
fn files_are_the_same_whatever_the_order_and_the_threads() {
    let [one, two, three] = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let plan = plan(1003, 10);
    whole(one.path(), &plan);
    let run = Run::open(two.path(), &plan, None).unwrap();
    run.missing().par_iter().rev().for_each(|&c| run.write(c, &columns(&plan, c)).unwrap());
    run.finish(json!({"seconds": 2})).unwrap();
    assert_same(one.path(), two.path());
    // Three shards at the same time in one folder.
    let runs: Vec<Run> =
        (1..=3).map(|i| Run::open(three.path(), &plan, Some(Shard::new(i, 3).unwrap())).unwrap()).collect();
    runs.par_iter().for_each(fill);
    let left: Vec<u64> = runs.into_iter().map(|r| r.finish(json!({})).unwrap()).collect();
    assert_eq!(left, [0, 0, 0]);
    assert_same(one.path(), three.path());
    // The order of the keys of a study does not matter.
    let study = json!({"seed": 7, "camera": plan.study["camera"].clone(), "name": "test"});
    let run = Run::open(three.path(), &Plan { study, ..plan }, None).unwrap();
    assert!(run.missing().is_empty());
}

#[test]
fn a_run_continues_where_parts_are_missing() {
    let [one, two] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let plan = plan(95, 10);
    whole(one.path(), &plan);
    whole(two.path(), &plan);
    for chunk in [0, 4, 9] {
        fs::remove_file(two.path().join(format!("trials/part-{chunk:06}.parquet"))).unwrap();
    }
    // Temporary files of a killed run.
    for name in ["trials/.part-000004.parquet.77-0.tmp", ".manifest.json.77-1.tmp"] {
        fs::write(two.path().join(name), b"half").unwrap();
    }
    let dataset = Dataset::open(two.path()).unwrap();
    assert_eq!((dataset.missing().collect::<Vec<_>>(), dataset.trials()), (vec![0, 4, 9], 70));
    assert_eq!(dataset.columns(&["trial"]).unwrap().count(), 7);
    let run = Run::open(two.path(), &plan, None).unwrap();
    assert_eq!(run.missing(), [0, 4, 9]);
    fill(&run);
    assert_eq!(run.finish(json!({"seconds": 3})).unwrap(), 0);
    assert_same(one.path(), two.path());
    assert!(!two.path().join(".manifest.json.77-1.tmp").exists());
    let runs = &Dataset::open(two.path()).unwrap().manifest().runs.clone();
    let seen: Vec<_> = runs.iter().map(|r| (r.parts, r.timings["seconds"].as_u64())).collect();
    assert_eq!(seen, [(10, Some(1)), (3, Some(3))]);
    // A run that writes no part is not recorded.
    Run::open(two.path(), &plan, None).unwrap().finish(json!({"seconds": 4})).unwrap();
    assert_eq!(Dataset::open(two.path()).unwrap().manifest().runs, *runs);
}

#[test]
fn shards_do_their_own_and_leave_the_temporary_files_of_others() {
    let dir = tempfile::tempdir().unwrap();
    let plan = plan(95, 10);
    let shard = |text: &str| Some(text.parse::<Shard>().unwrap());
    let run = Run::open(dir.path(), &plan, shard("2/4")).unwrap();
    assert_eq!(run.missing(), [1, 5, 9]);
    fill(&run);
    assert_eq!(run.finish(json!({"seconds": 1})).unwrap(), 7);
    let own = dir.path().join("trials/.part-000003.parquet.77-0.tmp");
    let other = dir.path().join("trials/.part-000002.parquet.77-0.tmp");
    fs::write(&own, b"half").unwrap();
    fs::write(&other, b"half").unwrap();
    let run = Run::open(dir.path(), &plan, shard("4/4")).unwrap();
    assert_eq!((own.exists(), other.exists()), (false, true));
    assert!(run.write(1, &columns(&plan, 1)).is_err());
    drop(run);
    Run::open(dir.path(), &plan, None).unwrap();
    assert!(!other.exists());
    assert_eq!(content(dir.path()).0.len(), 3);
}

#[test]
fn the_unit_and_the_meaning_of_a_column_stand_in_every_file() {
    let dir = tempfile::tempdir().unwrap();
    whole(dir.path(), &plan(5, 5));
    let part = fs::read(dir.path().join("trials/part-000000.parquet")).unwrap();
    let text = r#"{"name":"delta_e","kind":"float","unit":"ΔE*ab","doc":"what delta_e is"}"#;
    assert!(part.windows(text.len()).any(|w| w == text.as_bytes()));
}
