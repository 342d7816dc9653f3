//! What stands for Parquet in a build without it.

use std::path::Path;

use super::super::error::DatasetError;
use super::super::manifest::Manifest;
use super::super::schema::Column;
use super::supported::refused;

/// # Errors
/// Always.
pub fn encode(_: &Manifest, chunk: u64, _: &[Column]) -> Result<Vec<u8>, DatasetError> {
    Err(refused(Path::new(&format!("part {chunk}"))).into())
}

/// # Errors
/// Always.
pub fn part_from_bytes(
    _: Vec<u8>,
    path: &Path,
    _: &Manifest,
    _: u64,
    _: &[usize],
) -> Result<Vec<Column>, DatasetError> {
    Err(refused(path).into())
}
