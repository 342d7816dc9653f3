//! Spectral OpenEXR, up to a scene.
#![no_main]

use std::path::Path;

use smalti_io::exr::from_bytes;

mod options;

libfuzzer_sys::fuzz_target!(init: {
    // The fuzzer takes every panic for a finding. Those of the OpenEXR library are caught and are errors; ours are findings.
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !info.location().is_some_and(|l| l.file().contains("/exr-")) {
            report(info);
        }
    }));
}, |data: &[u8]| options::each(|o| from_bytes(data, Path::new("fuzz"), o)));
