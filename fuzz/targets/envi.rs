//! ENVI: the header up to the first zero byte, then the samples.
#![no_main]

use std::path::Path;

use smalti_io::envi::from_bytes;

mod options;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let end = data.iter().position(|b| *b == 0).unwrap_or(data.len());
    let (header, samples) = data.split_at(end);
    options::each(|o| from_bytes(header, samples.get(1..).unwrap_or_default(), Path::new("fuzz"), o));
});
