//! Readers of the reference values of ISETCam. Not every test uses every one of them.
#![allow(dead_code, missing_docs, unreachable_pub, clippy::unwrap_used, clippy::panic)]

pub mod isetcam;

use std::f64::consts::PI;
use std::path::PathBuf;

use smalti::numeric::philox::Stream;
use smalti::spectrum::WavelengthGrid;

/// Few wavelengths, for tests to which they mean as much as many, and which take a third of the time.
pub fn coarse_grid() -> WavelengthGrid {
    WavelengthGrid::new(400.0, 30.0, 11).unwrap()
}

/// A file of the reference values of ISETCam; `tests/data/isetcam/README.md` says where each comes from.
fn reference(name: &str) -> String {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/isetcam").join(name);
    std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

/// Rows of numbers.
pub fn csv(text: &str) -> Vec<Vec<f64>> {
    text.lines()
        .filter(|l| !l.trim().is_empty() && !l.starts_with('#'))
        .map(|l| l.split(',').map(|v| v.trim().parse().unwrap()).collect())
        .collect()
}

/// A CSV file of the reference values.
pub fn reference_csv(name: &str) -> Vec<Vec<f64>> {
    csv(&reference(name))
}

/// A JSON file of the reference values.
pub fn reference_json(name: &str) -> serde_json::Value {
    serde_json::from_str(&reference(name)).unwrap()
}

/// A JSON array of numbers, flattened.
pub fn numbers(v: &serde_json::Value) -> Vec<f64> {
    match v {
        serde_json::Value::Array(a) => a.iter().flat_map(numbers).collect(),
        serde_json::Value::Number(n) => vec![n.as_f64().unwrap()],
        other => panic!("expected numbers, got {other}"),
    }
}

/// Asserts agreement relative to the largest expected value; a failure prints the largest and the RMS error.
pub fn assert_close(what: &str, got: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(got.len(), expected.len(), "{what}: number of values");
    let scale = expected.iter().fold(0.0f64, |m, v| m.max(v.abs())).max(f64::MIN_POSITIVE);
    let errors: Vec<f64> = got.iter().zip(expected).map(|(g, e)| (g - e).abs() / scale).collect();
    let (at, largest) = errors
        .iter()
        .copied()
        .enumerate()
        .fold((0, 0.0), |m, e| if e.1 > m.1 || e.1.is_nan() { e } else { m });
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt();
    assert!(
        largest <= tolerance,
        "{what}: largest error {largest:.3e} of the maximum at {at} (got {}, expected {}), RMS {rms:.3e}, allowed {tolerance:.1e}",
        got[at],
        expected[at]
    );
}

/// A standard normal deviate (Box and Muller 1958).
pub fn normal(stream: &mut Stream) -> f64 {
    (-2.0 * (1.0 - stream.uniform()).ln()).sqrt() * (2.0 * PI * stream.uniform()).cos()
}
