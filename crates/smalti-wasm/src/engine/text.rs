//! Designs as JSON, camera files, and what is built in.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;
use serde_json::{Value, json};
use smalti::camera::CameraDescription;
use smalti::sensor::cfa;
use smalti_io::{TomlSource, cameras, designs};

use super::EngineError;

/// Characters of the longest camera file.
const MAX_TEXT: usize = 1 << 20;

/// A camera description as JSON. Errors name the key as those of camera files do.
pub(super) fn description(design: Value) -> Result<CameraDescription, EngineError> {
    match CameraDescription::deserialize(&design) {
        Ok(description) => Ok(description),
        // The reader of camera files knows where in the description the error is.
        Err(error) => {
            let text = toml_of(without_nulls(design)).map_err(|()| error)?;
            let source = TomlSource { name: "design".into(), folder: PathBuf::new(), text };
            Ok(source.describe(&[])?)
        }
    }
}

fn toml_of(design: Value) -> Result<String, ()> {
    designs::toml_text(&design).map_err(|_| ())
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

/// The camera file of a design.
pub(super) fn toml(design: Value) -> Result<String, EngineError> {
    Ok(designs::own_camera_toml(&description(design)?)?)
}

/// The description in a camera file, as it states it.
pub(super) fn parse(text: &str) -> Result<CameraDescription, EngineError> {
    if text.len() > MAX_TEXT {
        return Err(EngineError::TooLong { bytes: text.len(), limit: MAX_TEXT });
    }
    let source = TomlSource { name: "camera.toml".into(), folder: PathBuf::new(), text: text.to_owned() };
    Ok(cameras::from_source_with_notes(&source, &[], None)?.stated)
}

/// The mosaics, filters and cameras that are built in.
pub(super) fn catalogue() -> Result<Value, EngineError> {
    let of_cfa = |info: &cfa::CfaInfo| -> Result<Value, EngineError> {
        let tile = cfa::pattern(info.name).map_err(smalti::camera::CameraError::from)?;
        let named = cfa::default_filters(info.name).map_err(smalti::camera::CameraError::from)?;
        let filters: BTreeMap<String, Value> =
            named.into_iter().map(|(letter, name)| (letter.to_string(), json!({"builtin": name}))).collect();
        Ok(json!({"name": info.name, "aliases": info.aliases, "tile": tile, "filters": filters}))
    };
    let cfas = cfa::names().iter().map(of_cfa).collect::<Result<Vec<_>, _>>()?;
    let filters: Vec<&str> = cfa::builtin_filters().iter().map(|f| f.name).collect();
    let camera = |file: &smalti_io::BuiltinFile| parse(file.toml);
    let cameras = cameras::names().iter().map(camera).collect::<Result<Vec<_>, _>>()?;
    Ok(json!({"cfas": cfas, "filters": filters, "cameras": cameras}))
}
