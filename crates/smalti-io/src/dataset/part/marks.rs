//! Key-value pairs in the footer of a part, which identify it and contain its hash.
//!
//! The last pair is the BLAKE3 hash of the whole file with the hash itself replaced by zeros. It reveals damage before the Parquet
//! library reads the file.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::super::error::{DatasetError, PartProblem};
use super::super::manifest::Manifest;
use crate::IoError;

pub(super) const MAGIC: &[u8] = b"PAR1";
const HASH: &str = "smalti.blake3";
const PLAN: &str = "smalti.plan_blake3";
const CHUNK: &str = "smalti.chunk";
const FIRST: &str = "smalti.first_trial";
const ROWS: &str = "smalti.trials";
const SCHEMA: &str = "smalti.schema";
/// Hexadecimal digits of a hash.
const DIGITS: usize = 64;
/// Length of the end of a file that contains all pairs except the schema, bytes. After the pairs come only the name of the writer and the
/// sort order of each column, for which [`tail`] adds eight bytes per column.
const TAIL: u64 = 4096;

/// The pairs of a part, with zeros in place of the hash.
pub(super) fn pairs(manifest: &Manifest, chunk: u64) -> Vec<(&'static str, String)> {
    let plan = &manifest.plan;
    let schema = serde_json::to_string(&plan.schema).unwrap_or_default();
    vec![
        // The schema can be long. It comes first, so that the other pairs are near the end of the file.
        (SCHEMA, schema),
        (ROWS, plan.rows(chunk).to_string()),
        (FIRST, plan.trials_of(chunk).start.to_string()),
        (CHUNK, chunk.to_string()),
        (PLAN, manifest.hash().to_owned()),
        (HASH, "0".repeat(DIGITS)),
    ]
}

/// Checks all pairs except the hash of the file and the schema, which the hash of the plan covers.
pub(super) fn check(
    manifest: &Manifest,
    chunk: u64,
    find: impl Fn(&'static str) -> Option<String>,
) -> Result<(), PartProblem> {
    let plan = &manifest.plan;
    for (key, expected) in [
        (PLAN, manifest.hash().to_owned()),
        (CHUNK, chunk.to_string()),
        (FIRST, plan.trials_of(chunk).start.to_string()),
        (ROWS, plan.rows(chunk).to_string()),
    ] {
        let found = find(key).ok_or(PartProblem::NotOurs { key })?;
        if found != expected {
            return Err(PartProblem::Foreign { key, found, expected });
        }
    }
    Ok(())
}

/// The byte range of the value of a pair. Thrift's compact protocol writes a text as one byte for the field, the length and the bytes. The
/// last match is taken, since the statistics of a text column may contain the same bytes earlier in the file.
fn find(bytes: &[u8], key: &str) -> Option<std::ops::Range<usize>> {
    let length = u8::try_from(key.len()).ok()?;
    let mut mark = vec![0x18, length];
    mark.extend(key.as_bytes());
    mark.push(0x18);
    let at = bytes.windows(mark.len()).rposition(|w| w == mark)? + mark.len();
    // A length above 127 takes several bytes, but no value that is searched for here is so long.
    let length = usize::from(*bytes.get(at).filter(|n| **n < 128)?);
    let value = at + 1..at + 1 + length;
    (value.end <= bytes.len()).then_some(value)
}

fn text(bytes: &[u8], key: &'static str) -> Option<String> {
    bytes.get(find(bytes, key)?).map(|v| String::from_utf8_lossy(v).into_owned())
}

fn digits(bytes: &[u8]) -> Result<std::ops::Range<usize>, PartProblem> {
    find(bytes, HASH).filter(|r| r.len() == DIGITS).ok_or(PartProblem::NotOurs { key: HASH })
}

/// The hash of a file with zeros in place of the digits at `at`.
fn hash(bytes: &[u8], at: &std::ops::Range<usize>) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(bytes.get(..at.start).unwrap_or_default());
    hasher.update(&[b'0'; DIGITS]);
    hasher.update(bytes.get(at.end..).unwrap_or_default());
    hasher.finalize().to_hex().to_string()
}

/// Replaces the zeros in an encoded part by its hash.
pub(super) fn seal(bytes: &mut [u8]) -> Result<(), PartProblem> {
    let at = digits(bytes)?;
    let hash = hash(bytes, &at);
    if let Some(place) = bytes.get_mut(at) {
        place.copy_from_slice(hash.as_bytes());
    }
    Ok(())
}

/// Checks that the stated hash is that of the content.
pub(super) fn check_seal(bytes: &[u8]) -> Result<(), PartProblem> {
    if bytes.len() < 3 * MAGIC.len() || !bytes.starts_with(MAGIC) || !bytes.ends_with(MAGIC) {
        return Err(PartProblem::Truncated { bytes: bytes.len() as u64 });
    }
    let at = digits(bytes)?;
    let stated = String::from_utf8_lossy(bytes.get(at.clone()).unwrap_or_default()).into_owned();
    let found = hash(bytes, &at);
    if found == stated { Ok(()) } else { Err(PartProblem::Damaged { found, stated }) }
}

/// Checks that a part is complete and belongs to this chunk and plan. Reads only its last bytes.
pub(in super::super) fn quick_check(
    path: &Path,
    manifest: &Manifest,
    chunk: u64,
) -> Result<(), DatasetError> {
    let tail = tail(path, manifest)?;
    check(manifest, chunk, |key| text(&tail, key)).map_err(|p| p.at(path))
}

/// The hash that a part states.
pub(in super::super) fn stated_hash(path: &Path, manifest: &Manifest) -> Result<String, DatasetError> {
    let tail = tail(path, manifest)?;
    text(&tail, HASH).ok_or_else(|| PartProblem::NotOurs { key: HASH }.at(path))
}

fn tail(path: &Path, manifest: &Manifest) -> Result<Vec<u8>, DatasetError> {
    let io = IoError::reading(path);
    let mut file = File::open(path).map_err(io)?;
    let bytes = file.metadata().map_err(io)?.len();
    let wanted = TAIL + 8 * manifest.plan.schema.len() as u64;
    file.seek(SeekFrom::Start(bytes.saturating_sub(wanted))).map_err(io)?;
    let mut tail = Vec::new();
    file.take(wanted).read_to_end(&mut tail).map_err(io)?;
    if tail.len() < 3 * MAGIC.len() || !tail.ends_with(MAGIC) {
        return Err(PartProblem::Truncated { bytes }.at(path));
    }
    Ok(tail)
}
