//! DNG.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = smalti_io::dng::from_bytes(data, Path::new("fuzz"));
});
