//! A uniform field.

use super::compose::{check_size, grey};
use super::{Scene, SceneError, Setting};

/// A perfect white diffuser that fills the field of view, `rows` × `cols` pixels.
///
/// # Errors
/// When the scene would be empty or too large, or the setting is out of range.
pub fn uniform(rows: usize, cols: usize, setting: &Setting) -> Result<Scene, SceneError> {
    check_size(rows, cols, setting.grid)?;
    grey("uniform", rows, cols, &vec![1.0; rows * cols], setting)
}
