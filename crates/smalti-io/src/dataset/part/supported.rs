//! Whether this build writes and reads parts.

use std::path::Path;

use crate::IoError;

/// Refuses a folder of results in a build that cannot write or read their parts.
pub(in crate::dataset) fn check_supported(dir: &Path) -> Result<(), IoError> {
    if cfg!(feature = "parquet") { Ok(()) } else { Err(refused(dir)) }
}

pub(super) fn refused(path: &Path) -> IoError {
    IoError::LeftOut { path: path.to_owned(), format: "results of studies (Parquet)", feature: "parquet" }
}
