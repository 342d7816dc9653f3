//! HDF5, up to a scene.
#![no_main]

use std::panic;
use std::path::Path;

use smalti_io::hdf5::from_bytes;
use smalti_io::{Limits, ReadOptions, SceneDefaults};

libfuzzer_sys::fuzz_target!(
    init: {
        // Panics of the crate that reads the structure are caught by the reader and become errors; ours are findings.
        let report = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !info.location().is_some_and(|l| l.file().contains("hdf5-pure")) {
                report(info);
            }
        }));
    },
    |data: &[u8]| {
        let limits = Limits { file_bytes: 1 << 20, decoded_bytes: 64 << 20 };
        let options = ReadOptions { limits, ..ReadOptions::default() };
        if let Ok(file) = from_bytes(data, Path::new("fuzz"), &options) {
            let _ = file.into_scene(&SceneDefaults::default());
        }
    }
);
