//! Stable text of values, for cache keys and provenance.

use serde::Serialize;

use super::CameraError;

/// A value as JSON, with fields in declaration order and numbers that round-trip. Equal values give equal text with any version
/// of the compiler.
///
/// # Errors
/// When JSON cannot represent the value.
pub(crate) fn stable_text(value: &impl Serialize) -> Result<String, CameraError> {
    serde_json::to_string(value).map_err(|e| CameraError::Text { message: e.to_string() })
}
