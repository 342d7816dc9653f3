//! MAT-files, up to a scene.
#![no_main]

use std::path::Path;

use smalti_io::matlab::from_bytes;

mod options;

libfuzzer_sys::fuzz_target!(|data: &[u8]| options::each(|o| from_bytes(data, Path::new("fuzz"), o)));
