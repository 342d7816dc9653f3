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
mod supported;
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
pub(super) use supported::check_supported;

use super::error::DatasetError;
use super::manifest::Manifest;
use super::schema::Column;
use crate::file;

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
