//! Other programs read the parts in a folder of results.

use std::path::Path;

use serde_json::{Value, json};
use smalti_io::dataset::{Column, Dataset, Run};

use super::fixtures::{columns, plan};
use crate::python::python;

/// Checks that a program, run by `check_dataset.py`, reads the values that were written.
fn judged_by(program: &str, packages: &str) {
    let dir = tempfile::tempdir().unwrap();
    let plan = plan(43, 10);
    let run = Run::open(dir.path(), &plan, None).unwrap();
    let mut rows: Vec<Value> = Vec::new();
    for &chunk in run.missing() {
        let values = columns(&plan, chunk);
        run.write(chunk, &values).unwrap();
        rows.extend((0..values[0].len()).map(|row| values.iter().map(|c| value(c, row)).collect::<Value>()));
    }
    run.finish(json!(null)).unwrap();
    let parts = dir.path().join("trials");
    let Some(seen) = python("check_dataset.py", packages, &[Path::new(program), &parts]) else { return };
    let names: Vec<&str> = plan.schema.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(seen[0]["names"], json!(names));
    assert_eq!(seen[0]["unit"], "ΔE*ab");
    assert_eq!(seen[1..].len(), rows.len());
    for (seen, row) in seen[1..].iter().zip(&rows) {
        assert_eq!(seen, row);
    }
    // The program left every part as it was.
    Dataset::open(dir.path()).unwrap().verify().unwrap();
}

fn value(column: &Column, row: usize) -> Value {
    // JSON has no infinity, so that infinities are compared as text and NaN as null.
    let float = |v: f64| if v.is_infinite() { json!(v.to_string()) } else { json!(v) };
    match column {
        Column::Int(v) => json!(v[row]),
        Column::Float(v) => float(v[row]),
        Column::Text(v) => json!(v[row]),
        Column::Floats(v) => v[row].iter().map(|v| float(*v)).collect(),
    }
}

#[test]
fn pandas_reads_the_folder() {
    judged_by("pandas", "pandas, pyarrow");
}

#[test]
fn duckdb_reads_the_folder() {
    judged_by("duckdb", "duckdb");
}

#[test]
fn polars_reads_the_folder() {
    judged_by("polars", "polars");
}
