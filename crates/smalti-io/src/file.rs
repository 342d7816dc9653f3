//! Reading whole files within limits.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::{IoError, memory};

/// How much memory a file may ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Largest file that is read, bytes.
    pub file_bytes: u64,
    /// Largest decoded content, bytes.
    pub decoded_bytes: u64,
}

impl Default for Limits {
    /// Files up to 4 GiB, content up to 8 GiB.
    fn default() -> Self {
        Self { file_bytes: 4 << 30, decoded_bytes: 8 << 30 }
    }
}

// Deflate, the densest coding here but JPEG XL, expands at most 1032 times (zlib's technical notes).
// Headers and tables add a little; small files may declare up to a mebibyte whatever their length.
pub(crate) const LARGEST_EXPANSION: u64 = 1032;
const ALWAYS_ALLOWED: u64 = 1 << 20;

impl Limits {
    /// Refuses content that takes more memory than allowed.
    pub(crate) fn check_memory(self, path: &Path, what: &'static str, bytes: u64) -> Result<(), IoError> {
        at_most(self.decoded_bytes, path, what, bytes)?;
        memory::ensure_available(path, what, bytes)
    }

    /// Refuses content that takes more memory than allowed, or more than a file of `file_len` bytes can hold.
    pub(crate) fn check(
        self,
        path: &Path,
        what: &'static str,
        bytes: u64,
        file_len: u64,
    ) -> Result<(), IoError> {
        self.check_memory(path, what, bytes)?;
        plausible(path, what, bytes, file_len)
    }
}

/// Refuses what takes more bytes than a limit.
pub(crate) fn at_most(limit: u64, path: &Path, what: &'static str, bytes: u64) -> Result<(), IoError> {
    if bytes > limit {
        return Err(IoError::TooLarge { path: path.to_owned(), what, bytes, limit });
    }
    Ok(())
}

/// Refuses content that is larger than a file of `file_len` bytes can hold.
pub(crate) fn plausible(path: &Path, what: &'static str, bytes: u64, file_len: u64) -> Result<(), IoError> {
    if bytes > ALWAYS_ALLOWED.max(file_len.saturating_mul(LARGEST_EXPANSION)) {
        return Err(IoError::truncated(path, what, bytes / LARGEST_EXPANSION, file_len));
    }
    Ok(())
}

/// The largest content of a device or pipe: it states no length and may never end.
const STREAM_BYTES: u64 = 64 << 20;

/// The whole file, device or pipe.
pub(crate) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, IoError> {
    let io = IoError::reading(path);
    let mut file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    let limit = if metadata.is_file() { limit } else { limit.min(STREAM_BYTES) };
    at_most(limit, path, "the file", metadata.len())?;
    memory::ensure_available(path, "the file", metadata.len())?;
    let mut bytes = Vec::new();
    // The limit is held while reading too: the file may grow.
    file.by_ref().take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(io)?;
    at_most(limit, path, "the file", bytes.len() as u64)?;
    Ok(bytes)
}

/// The name of a file without folder and extension, to call its content by.
pub(crate) fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}

/// Runs a decoder of another crate. If it panics on a malformed file, that is an error about the file and not the end of the program.
pub(crate) fn guarded<T>(
    path: &Path,
    format: &'static str,
    decode: impl FnOnce() -> Result<T, IoError>,
) -> Result<T, IoError> {
    caught(decode).unwrap_or_else(|message| Err(IoError::decode(path, format, message)))
}

/// The result of a decoder of another crate; an error in words if it panics.
pub(crate) fn caught<T>(decode: impl FnOnce() -> T) -> Result<T, &'static str> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode)).map_err(|_| "the decoder failed on it")
}

/// How negative samples are treated. NaN and infinity are always errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Negative {
    /// An error: there is no negative radiance.
    Refuse,
    /// Zero.
    Clamp,
    /// Kept: colours outside the gamut of RGB have them.
    Keep,
}

/// Checks a sample; an error states the expected value.
pub(crate) fn sample(value: f32, negative: Negative) -> Result<f32, &'static str> {
    match negative {
        _ if !value.is_finite() => Err("a finite number"),
        Negative::Refuse if value < 0.0 => Err("a finite number, not negative"),
        Negative::Clamp => Ok(value.max(0.0)),
        // Minus zero is zero: two equal scenes have equal bits.
        _ => Ok(value + 0.0),
    }
}
