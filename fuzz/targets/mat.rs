//! MAT-files, up to a scene.
#![no_main]

use std::path::Path;

use smalti_io::matlab::from_bytes;
use smalti_io::{Limits, ReadOptions, SceneDefaults};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let limits = Limits { file_bytes: 1 << 20, decoded_bytes: 64 << 20 };
    let options = ReadOptions { limits, ..ReadOptions::default() };
    if let Ok(file) = from_bytes(data, Path::new("fuzz"), &options) {
        let _ = file.into_scene(&SceneDefaults::default());
    }
});
