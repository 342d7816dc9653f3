//! A folder of bands: of each picture the length of its name, its name, two bytes of length, its content.
#![no_main]

use std::path::Path;

use smalti_io::bands::from_files;

mod options;

fn files(mut data: &[u8]) -> Option<Vec<(String, Vec<u8>)>> {
    let mut files = Vec::new();
    while let Some((&len, rest)) = data.split_first() {
        let (name, rest) = rest.split_at_checked(usize::from(len))?;
        let (len, rest) = rest.split_first_chunk::<2>()?;
        let (content, rest) = rest.split_at_checked(usize::from(u16::from_le_bytes(*len)))?;
        files.push((String::from_utf8_lossy(name).into_owned(), content.to_vec()));
        data = rest;
    }
    Some(files)
}

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    if let Some(files) = files(data) {
        options::each(|o| from_files(&files, Path::new("fuzz"), o));
    }
});
