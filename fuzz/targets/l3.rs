//! Learned tables and statistics.
#![no_main]

use std::path::Path;

use smalti_io::IoError;
use smalti_io::l3::{statistics_from_bytes, table_from_bytes};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    read(data, table_from_bytes);
    read(data, statistics_from_bytes);
});

/// Reads; where only the hash is wrong, puts the right one in and reads again: nobody guesses it, and what stands behind it has to
/// be sound too.
fn read<T>(data: &[u8], reader: fn(&[u8], &Path) -> Result<T, IoError>) {
    let path = Path::new("fuzz");
    let Err(IoError::Damaged { found, stated, .. }) = reader(data, path) else { return };
    let place = data.windows(stated.len().max(1)).position(|w| w == stated.as_bytes());
    if let Some(at) = place.filter(|_| stated.len() == found.len()) {
        let mut data = data.to_vec();
        data[at..at + found.len()].copy_from_slice(found.as_bytes());
        let _ = reader(&data, path);
    }
}
