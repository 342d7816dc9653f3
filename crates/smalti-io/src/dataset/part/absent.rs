//! What stands for Parquet in a build without it.

use std::path::Path;

use super::super::error::DatasetError;
use super::super::manifest::Manifest;
use super::super::schema::Column;
use super::supported::check_supported;

/// # Errors
/// Always.
pub fn encode(_: &Manifest, chunk: u64, _: &[Column]) -> Result<Vec<u8>, DatasetError> {
    Ok(check_supported(Path::new(&format!("part {chunk}"))).map(|()| Vec::new())?)
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
    Ok(check_supported(path).map(|()| Vec::new())?)
}
