//! PNG, TIFF, JPEG and OpenEXR pictures.
#![no_main]

use std::path::Path;

use smalti_io::Limits;
use smalti_io::ReadOptions;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let limits = Limits { file_bytes: 1 << 20, decoded_bytes: 64 << 20 };
    let options = ReadOptions { limits, ..ReadOptions::default() };
    let _ = smalti_io::picture::from_bytes(data, Path::new("fuzz"), &options);
});
