//! What a part says of itself in the key-value pairs of its footer, and its hash.
//!
//! The last pair is the BLAKE3 hash of the whole file with the hash itself replaced by zeros. Whatever happens to a part is found
//! before the Parquet library sees it.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use parquet::file::metadata::KeyValue;

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
/// The end of a file where its marks stand: but for the hash of the file they are short, and only the order of each column's
/// values, three bytes, and the name of the writer follow.
const TAIL: u64 = 4096;

/// The pairs of a part, with zeros in place of the hash.
pub(super) fn pairs(manifest: &Manifest, chunk: u64) -> Vec<KeyValue> {
    let plan = &manifest.plan;
    let pair = |key: &str, value: String| KeyValue::new(key.to_owned(), value);
    let schema = serde_json::to_string(&plan.schema).unwrap_or_default();
    vec![
        // First, so that all others stand near the end of the file.
        pair(SCHEMA, schema),
        pair(ROWS, plan.rows(chunk).to_string()),
        pair(FIRST, plan.trials_of(chunk).start.to_string()),
        pair(CHUNK, chunk.to_string()),
        pair(PLAN, manifest.hash().to_owned()),
        pair(HASH, "0".repeat(DIGITS)),
    ]
}

/// Checks the pairs, but for hash and schema: what the plan's hash covers is not compared again.
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

/// The place of the value of a pair: Thrift's compact protocol writes a text as its length and its bytes, after one byte for the
/// field. The last place is the pair; statistics of a text column, before, might hold the same bytes.
fn find(bytes: &[u8], key: &str) -> Option<std::ops::Range<usize>> {
    let length = u8::try_from(key.len()).ok()?;
    let mut mark = vec![0x18, length];
    mark.extend(key.as_bytes());
    mark.push(0x18);
    let at = bytes.windows(mark.len()).rposition(|w| w == mark)? + mark.len();
    // Longer values than 127 bytes have lengths of several bytes; none of those looked for here does.
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

/// The hash of a file whose digits stand at a place.
fn hash(bytes: &[u8], at: &std::ops::Range<usize>) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(bytes.get(..at.start).unwrap_or_default());
    hasher.update(&[b'0'; DIGITS]);
    hasher.update(bytes.get(at.end..).unwrap_or_default());
    hasher.finalize().to_hex().to_string()
}

/// Puts the hash into a part that has zeros.
pub(super) fn seal(bytes: &mut [u8]) -> Result<(), PartProblem> {
    let at = digits(bytes)?;
    let hash = hash(bytes, &at);
    if let Some(place) = bytes.get_mut(at) {
        place.copy_from_slice(hash.as_bytes());
    }
    Ok(())
}

/// Compares the hash with the content.
pub(super) fn check_seal(bytes: &[u8]) -> Result<(), PartProblem> {
    if bytes.len() < 3 * MAGIC.len() || !bytes.starts_with(MAGIC) || !bytes.ends_with(MAGIC) {
        return Err(PartProblem::Truncated { bytes: bytes.len() as u64 });
    }
    let at = digits(bytes)?;
    let stated = String::from_utf8_lossy(bytes.get(at.clone()).unwrap_or_default()).into_owned();
    let found = hash(bytes, &at);
    if found == stated { Ok(()) } else { Err(PartProblem::Damaged { found, stated }) }
}

/// Checks that a part is whole and of this chunk of this plan by its last bytes, without reading its content.
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
