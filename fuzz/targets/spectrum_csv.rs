//! CSV spectra, and the UTF-8 door before them.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let path = Path::new("fuzz");
    if let Ok(text) = smalti_io::text::from_bytes(data.to_vec(), path) {
        let _ = smalti_io::spectrum_csv::parse(&text, path);
    }
});
