//! DNG.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(init: {
    // The fuzzer takes every panic for a finding. Those of the JPEG XL library are caught and are errors.
    std::panic::set_hook(Box::new(|_| {}));
}, |data: &[u8]| {
    let _ = smalti_io::dng::from_bytes(data, Path::new("fuzz"));
});
