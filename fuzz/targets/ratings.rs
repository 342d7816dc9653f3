//! Manifests of rating experiments and answers of observers.
#![no_main]

use std::path::Path;

use smalti_io::IoError;
use smalti_io::ratings::{Manifest, choices, from_bytes, observer_from_bytes};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let path = Path::new("fuzz");
    // A manifest, then answers to it.
    let (first, rest) = match data.iter().position(|b| *b == 0) {
        Some(at) => (&data[..at], &data[at + 1..]),
        None => (data, &[][..]),
    };
    let Some(manifest) = manifest(first, path) else { return };
    if let Ok((observer, _)) = observer_from_bytes(rest, path, &manifest) {
        let _ = choices(&manifest, &observer);
    }
});

/// Where only the hash is wrong, the right one is put in: nobody guesses it, and what stands behind it has to be sound too.
fn manifest(data: &[u8], path: &Path) -> Option<Manifest> {
    let (found, stated) = match from_bytes(data, path) {
        Err(IoError::Damaged { found, stated, .. }) => (found, stated),
        other => return other.ok(),
    };
    let at = data.windows(stated.len().max(1)).position(|w| w == stated.as_bytes())?;
    let mended = [&data[..at], found.as_bytes(), &data[at + stated.len()..]].concat();
    from_bytes(&mended, path).ok()
}
