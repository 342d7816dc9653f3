//! Reading whole files within limits.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::IoError;

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
    /// Refuses content that is larger than allowed, or than a file of `file_len` bytes can hold.
    pub(crate) fn check(
        self,
        path: &Path,
        what: &'static str,
        bytes: u64,
        file_len: u64,
    ) -> Result<(), IoError> {
        if bytes > self.decoded_bytes {
            let limit = self.decoded_bytes;
            return Err(IoError::TooLarge { path: path.to_owned(), what, bytes, limit });
        }
        plausible(path, what, bytes, file_len)
    }
}

/// Refuses content that is larger than a file of `file_len` bytes can hold.
pub(crate) fn plausible(path: &Path, what: &'static str, bytes: u64, file_len: u64) -> Result<(), IoError> {
    if bytes > ALWAYS_ALLOWED.max(file_len.saturating_mul(LARGEST_EXPANSION)) {
        let need = bytes / LARGEST_EXPANSION;
        return Err(IoError::Truncated { path: path.to_owned(), what, need, have: file_len });
    }
    Ok(())
}

/// The whole file.
pub(crate) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, IoError> {
    let io = |source| IoError::Read { path: path.to_owned(), source };
    let mut file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    let too_large = |bytes| IoError::TooLarge { path: path.to_owned(), what: "the file", bytes, limit };
    if metadata.len() > limit {
        return Err(too_large(metadata.len()));
    }
    let mut bytes = Vec::new();
    // A device or pipe has no length: the limit is held while reading too.
    file.by_ref().take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > limit {
        return Err(too_large(bytes.len() as u64));
    }
    Ok(bytes)
}

/// The name of a file without folder and extension, to call its content by.
pub(crate) fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}

/// Runs a decoder that is not ours. Should it panic on a hostile file after all, that is an error about the file,
/// not the end of the program.
pub(crate) fn guarded<T>(
    path: &Path,
    format: &'static str,
    decode: impl FnOnce() -> Result<T, IoError>,
) -> Result<T, IoError> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode)).unwrap_or_else(|_| {
        let message = "the decoder failed on it".to_owned();
        Err(IoError::Decode { path: path.to_owned(), format, message })
    })
}

/// What becomes of negative samples. NaN and infinity are always errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Negative {
    /// An error: there is no negative radiance.
    Refuse,
    /// Zero.
    Clamp,
    /// Kept: colours outside the gamut of RGB have them.
    Keep,
}

/// Checks a sample; an error says what was expected.
pub(crate) fn sample(value: f32, negative: Negative) -> Result<f32, &'static str> {
    match negative {
        _ if !value.is_finite() => Err("a finite number"),
        Negative::Refuse if value < 0.0 => Err("a finite number, not negative"),
        Negative::Clamp => Ok(value.max(0.0)),
        // Minus zero is zero: two equal scenes have equal bits.
        _ => Ok(value + 0.0),
    }
}
