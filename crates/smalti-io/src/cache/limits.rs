//! How much a cache keeps, and for how long.

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use std::{env, fs, io};

use super::kind::EntryKind;
use crate::IoError;

const DAY: Duration = Duration::from_secs(24 * 60 * 60);

/// The limits of a cache.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CacheLimits {
    /// Largest size of all entries together, bytes.
    pub bytes: u64,
    /// An entry that was not used for longer is removed when another is written.
    pub unused: Duration,
}

impl Default for CacheLimits {
    /// 2 GB, and 90 days.
    fn default() -> Self {
        Self { bytes: 2_000_000_000, unused: 90 * DAY }
    }
}

impl CacheLimits {
    /// The name of the variable with the largest size.
    pub const SIZE_VARIABLE: &'static str = "SMALTI_CACHE_GB";
    /// The name of the variable with the largest age.
    pub const AGE_VARIABLE: &'static str = "SMALTI_CACHE_DAYS";

    /// `$SMALTI_CACHE_GB`, 0 to 10⁶ units of 10⁹ bytes, and `$SMALTI_CACHE_DAYS`, 0 to 10⁶ days since the last use; where a variable
    /// is absent or empty, the default.
    ///
    /// # Errors
    /// [`IoError::Environment`] when a variable is no such number.
    pub fn from_environment() -> Result<Self, IoError> {
        let read = |variable| env::var_os(variable).filter(|v| !v.is_empty());
        Self::parse(&|variable| read(variable).map(|v| v.to_string_lossy().into_owned()))
    }

    fn parse(read: &dyn Fn(&'static str) -> Option<String>) -> Result<Self, IoError> {
        let number = |variable| {
            let Some(text) = read(variable) else { return Ok(None) };
            match text.trim().parse::<f64>() {
                Ok(number) if (0.0..=1e6).contains(&number) => Ok(Some(number)),
                _ => Err(IoError::Environment {
                    variable,
                    found: text,
                    expected: "a number from 0 to 1000000",
                }),
            }
        };
        let default = Self::default();
        Ok(Self {
            bytes: number(Self::SIZE_VARIABLE)?.map_or(default.bytes, |gb| (gb * 1e9) as u64),
            unused: number(Self::AGE_VARIABLE)?.map_or(default.unused, |days| DAY.mul_f64(days)),
        })
    }
}

/// A file of a cache.
pub(super) struct CacheFile {
    pub(super) used: SystemTime,
    pub(super) bytes: u64,
    pub(super) path: PathBuf,
    pub(super) kind: EntryKind,
}

/// The entries in a folder, finished or not. Other files are no part of the cache.
pub(super) fn files(dir: Option<&Path>) -> Result<Vec<CacheFile>, IoError> {
    let Some(dir) = dir else { return Ok(Vec::new()) };
    let listing = match fs::read_dir(dir) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        listing => listing.map_err(IoError::reading(dir))?,
    };
    let file = |entry: fs::DirEntry| {
        let kind = kind_of(entry.file_name().to_str()?)?;
        // Another process may have removed it since it was listed.
        let metadata = entry.metadata().ok().filter(fs::Metadata::is_file)?;
        let used = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
        Some(CacheFile { used, bytes: metadata.len(), path: entry.path(), kind })
    };
    Ok(listing.flatten().filter_map(file).collect())
}

/// The kind of an entry by the name of its file, a key and an extension, or of the temporary file of one; `None` for all others.
fn kind_of(name: &str) -> Option<EntryKind> {
    let (key, rest) = name.strip_prefix('.').unwrap_or(name).split_once('.')?;
    let is_key = key.len() == 64 && key.bytes().all(|b| b.is_ascii_hexdigit());
    let is_temporary = name.starts_with('.') && name.ends_with(".tmp");
    let extension = if is_temporary { rest.split_once('.')?.0 } else { rest };
    let kind = EntryKind::ALL.into_iter().find(|kind| kind.extension() == extension);
    kind.filter(|_| is_key && is_temporary == name.starts_with('.'))
}

/// Removes entries (and temporary files of processes that died) beside `kept`: those that were not used for too long, then those not
/// used for longest until the rest is within the limit. What cannot be removed stays: another process may have been faster.
pub(super) fn evict(dir: &Path, kept: &Path, limits: CacheLimits) {
    let Ok(mut files) = files(Some(dir)) else { return };
    files.retain(|f| f.path != kept);
    files.sort_by(|a, b| (a.used, &a.path).cmp(&(b.used, &b.path)));
    let mut total: u64 = files.iter().map(|f| f.bytes).sum();
    for file in files {
        // A use in the future, by another clock, is recent.
        let unused = file.used.elapsed().unwrap_or_default();
        if total <= limits.bytes && unused <= limits.unused {
            break;
        }
        let _ = fs::remove_file(file.path);
        total -= file.bytes;
    }
}

/// Removes a file that another process may have removed already.
pub(super) fn remove(path: &Path) -> Result<(), IoError> {
    match fs::remove_file(path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(IoError::writing(path)(e)),
        _ => Ok(()),
    }
}

/// The time of the last use decides which entries are removed first. Without it, another order does no harm.
pub(super) fn mark_used(path: &Path) {
    let _ = fs::File::options().append(true).open(path).and_then(|f| f.set_modified(SystemTime::now()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_numbers_or_errors() {
        let of = |gb: &str, days: &str| {
            CacheLimits::parse(&|v| {
                let text = if v == CacheLimits::SIZE_VARIABLE { gb } else { days };
                (!text.is_empty()).then(|| text.to_owned())
            })
        };
        assert_eq!(of("", "").unwrap(), CacheLimits::default());
        assert_eq!(of("0.5", "").unwrap().bytes, 500_000_000);
        assert_eq!(of("", "0").unwrap().unused, Duration::ZERO);
        for wrong in ["-1", "nan", "inf", "1e7", "2GB", " "] {
            for (error, variable) in
                [(of(wrong, ""), CacheLimits::SIZE_VARIABLE), (of("", wrong), CacheLimits::AGE_VARIABLE)]
            {
                let expected =
                    format!("the variable {variable} is '{wrong}'; expected a number from 0 to 1000000");
                assert_eq!(error.unwrap_err().to_string(), expected);
            }
        }
    }

    #[test]
    fn only_entries_are_files_of_a_cache() {
        let key = "0123456789abcdef".repeat(4);
        for kind in EntryKind::ALL {
            assert_eq!(kind_of(&format!("{key}.{}", kind.extension())), Some(kind));
            assert_eq!(kind_of(&format!(".{key}.{}.17-3.tmp", kind.extension())), Some(kind));
        }
        for other in [
            "notes.smalti-oi".to_owned(),
            format!("{key}.smalti-oi.bak"),
            format!(".{key}.smalti-oi"),
            format!("{key}.txt"),
            format!("{key}x.smalti-oi"),
            key.clone(),
        ] {
            assert_eq!(kind_of(&other), None, "{other}");
        }
    }
}
