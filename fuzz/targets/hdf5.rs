//! HDF5, up to a scene.
#![no_main]

use std::panic;
use std::path::Path;

use smalti_io::hdf5::from_bytes;

mod options;

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
    |data: &[u8]| options::each(|o| from_bytes(data, Path::new("fuzz"), o))
);
