//! Results of sweeps: manifests and parts.
#![no_main]

use std::path::Path;
use std::sync::LazyLock;

use smalti_io::dataset::{DatasetError, Manifest, PartProblem, part_from_bytes};

#[path = "../plan.rs"]
mod plan;

static MANIFEST: LazyLock<Manifest> = LazyLock::new(|| Manifest::new(&plan::plan()).unwrap());

libfuzzer_sys::fuzz_target!(init: {
    // The fuzzer takes every panic for a finding. Those of the Parquet library are caught and are errors.
    std::panic::set_hook(Box::new(|_| {}));
}, |data: &[u8]| {
    let path = Path::new("fuzz");
    let _ = Manifest::from_bytes(data, path);
    let read = |data: Vec<u8>| part_from_bytes(data, path, &MANIFEST, 0, &[0, 1, 2, 3]);
    // Nobody guesses the hash, and what stands behind it has to be sound too.
    let Err(DatasetError::Part { problem: PartProblem::Damaged { found, stated }, .. }) = read(data.to_vec()) else {
        return;
    };
    let place = data.windows(stated.len().max(1)).rposition(|w| w == stated.as_bytes());
    if let Some(at) = place.filter(|_| stated.len() == found.len()) {
        let mut data = data.to_vec();
        data[at..at + found.len()].copy_from_slice(found.as_bytes());
        let _ = read(data);
    }
});
