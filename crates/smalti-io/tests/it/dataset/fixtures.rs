//! A plan with a column of every type, and values for it.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use smalti_io::dataset::{Column, ColumnKind, ColumnSpec, Plan, Run};

pub(crate) fn spec(name: &str, kind: ColumnKind, unit: &str) -> ColumnSpec {
    ColumnSpec { name: name.into(), kind, unit: unit.into(), doc: format!("what {name} is") }
}

pub(crate) fn plan(trials: u64, chunk: u64) -> Plan {
    Plan {
        study: json!({"name": "test", "seed": 7, "camera": {"pitch_um": 2.2, "cfa": ["RG", "GB"]}}),
        schema: vec![
            spec("trial", ColumnKind::Int, ""),
            spec("seed", ColumnKind::Int, ""),
            spec("delta_e", ColumnKind::Float, "ΔE*ab"),
            spec("mosaic", ColumnKind::Text, ""),
            spec("centers_nm", ColumnKind::Floats, "nm"),
        ],
        trials,
        chunk,
    }
}

/// A pseudo-random number that depends only on the trial.
fn mixed(trial: u64) -> u64 {
    let mut x = trial.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x ^= x >> 29;
    x.wrapping_mul(0xbf58_476d_1ce4_e5b9)
}

/// The values of a chunk, including NaN, infinity, negative zero, and empty texts and lists.
pub(crate) fn columns(plan: &Plan, chunk: u64) -> Vec<Column> {
    let trials: Vec<u64> = plan.trials_of(chunk).collect();
    let float = |d: u64| match d % 7 {
        0 => f64::NAN,
        1 => f64::NEG_INFINITY,
        2 => -0.0,
        _ => mixed(d) as f64 * 1e-18,
    };
    vec![
        Column::Int(trials.iter().map(|d| *d as i64).collect()),
        Column::Int(trials.iter().map(|d| mixed(*d) as i64).collect()),
        Column::Float(trials.iter().map(|d| float(*d)).collect()),
        Column::Text(trials.iter().map(|d| "ŘG/".repeat((*d % 3) as usize)).collect()),
        Column::Floats(trials.iter().map(|d| (0..*d % 5).map(|i| float(d + i)).collect()).collect()),
    ]
}

/// The bits of a column. NaN equals NaN, and zero differs from negative zero.
pub(crate) fn bits(column: &Column) -> Vec<Vec<u64>> {
    let float = |v: &f64| if v.is_nan() { u64::MAX } else { v.to_bits() };
    match column {
        Column::Int(v) => v.iter().map(|v| vec![*v as u64]).collect(),
        Column::Float(v) => v.iter().map(|v| vec![float(v)]).collect(),
        Column::Text(v) => v.iter().map(|v| v.bytes().map(u64::from).collect()).collect(),
        Column::Floats(v) => v.iter().map(|v| v.iter().map(float).collect()).collect(),
    }
}

/// Writes the missing chunks of a run in order.
pub(crate) fn fill(run: &Run) {
    for &chunk in run.missing() {
        run.write(chunk, &columns(&run.manifest().plan, chunk)).unwrap();
    }
}

/// Completes a whole run in a new folder.
pub(crate) fn whole(dir: &Path, plan: &Plan) {
    let run = Run::open(dir, plan, None).unwrap();
    fill(&run);
    assert_eq!(run.finish(json!({"seconds": 1})).unwrap(), 0);
}

/// The parts by name, and the manifest without its runs.
pub(crate) fn content(dir: &Path) -> (BTreeMap<String, Vec<u8>>, String) {
    let parts = fs::read_dir(dir.join("trials")).unwrap().map(|e| {
        let path = e.unwrap().path();
        (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(path).unwrap())
    });
    let mut manifest: Value = serde_json::from_slice(&fs::read(dir.join("manifest.json")).unwrap()).unwrap();
    manifest.as_object_mut().unwrap().remove("runs").unwrap();
    (parts.collect(), manifest.to_string())
}

pub(crate) fn assert_same(one: &Path, two: &Path) {
    let (one, two) = (content(one), content(two));
    assert_eq!(one.0.keys().collect::<Vec<_>>(), two.0.keys().collect::<Vec<_>>());
    for (name, bytes) in &one.0 {
        assert!(two.0[name] == *bytes, "{name} differs");
    }
    assert_eq!(one.1, two.1);
}
