//! A part as a Parquet file: encoding, metadata and decoding.
//!
//! Without the feature `parquet`, no results can be written or read.

#[cfg(not(feature = "parquet"))]
mod absent;
#[cfg(feature = "parquet")]
mod decode;
#[cfg(feature = "parquet")]
mod encode;
mod marks;
#[cfg(feature = "parquet")]
mod schema;
#[cfg(all(test, feature = "parquet"))]
mod tests;

use std::path::Path;

#[cfg(not(feature = "parquet"))]
pub use absent::{encode, part_from_bytes};
#[cfg(feature = "parquet")]
pub use decode::part_from_bytes;
#[cfg(feature = "parquet")]
pub use encode::encode;
pub(super) use marks::{quick_check, stated_hash};

use super::error::DatasetError;
use super::manifest::Manifest;
use super::schema::Column;
use crate::{IoError, file};

/// Maximum size of a part, bytes.
pub(super) const LIMIT: u64 = 4 << 30;

/// Reads the columns with these indices from a part.
pub(super) fn read(
    path: &Path,
    manifest: &Manifest,
    chunk: u64,
    columns: &[usize],
) -> Result<Vec<Column>, DatasetError> {
    part_from_bytes(file::read(path, LIMIT)?, path, manifest, chunk, columns)
}

/// Refuses a folder of results in a build that cannot write or read their parts.
pub(super) fn check_supported(dir: &Path) -> Result<(), IoError> {
    if cfg!(feature = "parquet") {
        return Ok(());
    }
    Err(IoError::LeftOut { path: dir.to_owned(), format: "results of studies (Parquet)", feature: "parquet" })
}
