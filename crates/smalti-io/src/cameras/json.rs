//! Camera descriptions as JSON.

use std::path::PathBuf;

use serde::Deserialize;
use serde_json::Value;
use smalti::camera::CameraDescription;

use crate::diagnostic::Diagnostic;
use crate::toml_source::TomlSource;

/// A camera description that is JSON, such as a design of the studio, read as strictly as a camera file. No file that it names is read.
///
/// # Errors
/// With the key, as for camera files.
pub fn from_json(design: Value) -> Result<CameraDescription, Box<Diagnostic>> {
    CameraDescription::deserialize(&design).or_else(|error| {
        // The reader of camera files knows where in the description the error is.
        let text = toml::to_string(&without_nulls(design))
            .map_err(|_| Box::new(Diagnostic::new("design", error.to_string())))?;
        TomlSource { name: "design".into(), folder: PathBuf::new(), text }.describe(&[])
    })
}

/// TOML has no null.
fn without_nulls(value: Value) -> Value {
    match value {
        Value::Object(map) => {
            let kept = map.into_iter().filter(|(_, v)| !v.is_null());
            Value::Object(kept.map(|(k, v)| (k, without_nulls(v))).collect())
        }
        Value::Array(all) => Value::Array(all.into_iter().map(without_nulls).collect()),
        other => other,
    }
}
