//! What differs between cameras besides the colour filter array.

use std::collections::BTreeMap;

use serde_json::Value;

use super::ExperimentError;
use super::error::StageContext;
use crate::camera::{CameraDescription, CameraError};

/// Keys that a comparison of colour filter arrays varies, or that do not affect its scores: pictures have the size of the scene.
const IGNORED: [&str; 6] = ["name", "wavelengths_nm", "sensor.rows", "sensor.cols", "sensor.cfa", "isp"];
/// Tables of a description; all other objects are values.
const TABLES: [&str; 4] = ["optics", "sensor", "sensor.pixel", "exposure"];
/// The longest value that is stated in full, characters.
const MAX_STATED: usize = 40;

/// A key whose values differ between cameras.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CameraDifference {
    /// The key of the description, with its unit.
    pub key: String,
    /// The value of each camera: `none` where it is absent, and a letter for each distinct curve.
    pub values: Vec<String>,
}

/// The keys of lens, sensor and exposure that differ between cameras, without the colour filter array and the number of pixels.
///
/// # Errors
/// When a description cannot be represented as text.
pub fn camera_differences<'a>(
    cameras: impl IntoIterator<Item = &'a CameraDescription>,
) -> Result<Vec<CameraDifference>, ExperimentError> {
    let of = |description: &CameraDescription| {
        let text = |e: serde_json::Error| CameraError::Text { message: e.to_string() };
        // Volts depend on the conversion gain, and are products of what the user states.
        let value = serde_json::to_value(description.in_electrons()).map_err(text);
        let mut keys = BTreeMap::new();
        collect("", &value.in_context(|| description.name.clone())?, &mut keys);
        Ok(keys)
    };
    let cameras: Vec<BTreeMap<String, Value>> =
        cameras.into_iter().map(of).collect::<Result<_, ExperimentError>>()?;
    let mut names: Vec<&String> = cameras.iter().flat_map(BTreeMap::keys).collect();
    names.sort();
    names.dedup();
    let difference = |key: &String| {
        let values: Vec<&Value> = cameras.iter().map(|c| c.get(key).unwrap_or(&Value::Null)).collect();
        let differs = values.windows(2).any(|pair| pair[0] != pair[1]);
        differs.then(|| CameraDifference { key: key.clone(), values: stated(&values) })
    };
    Ok(names.into_iter().filter_map(difference).collect())
}

fn collect(key: &str, value: &Value, keys: &mut BTreeMap<String, Value>) {
    if IGNORED.contains(&key) {
        return;
    }
    match value {
        Value::Object(table) if key.is_empty() || TABLES.contains(&key) => {
            for (name, value) in table {
                let key = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
                collect(&key, value, keys);
            }
        }
        _ => drop(keys.insert(key.to_owned(), value.clone())),
    }
}

/// Values as text. Long ones, such as measured curves, get a letter each.
fn stated<'a>(values: &[&'a Value]) -> Vec<String> {
    let mut long: Vec<&'a Value> = Vec::new();
    let one = |&value: &&'a Value| match value {
        Value::Null => "none".to_owned(),
        Value::String(text) => text.clone(),
        Value::Object(curve) if curve.len() == 1 && curve.contains_key("builtin") => {
            curve["builtin"].as_str().unwrap_or_default().to_owned()
        }
        Value::Object(curve) if curve.len() == 1 && curve.contains_key("flat") => {
            format!("flat {}", curve["flat"])
        }
        other => {
            let text = other.to_string();
            if text.chars().count() <= MAX_STATED {
                return text;
            }
            let place = long.iter().position(|&v| v == value).unwrap_or_else(|| {
                long.push(value);
                long.len() - 1
            });
            let letter = char::from(b'A' + (place % 26) as u8);
            format!("curve {letter}")
        }
    };
    values.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::Filter;

    #[test]
    fn only_what_a_filter_array_does_not_change_is_stated() {
        let mut a = CameraDescription { name: "a".into(), ..CameraDescription::default() };
        let mut b = CameraDescription { name: "b".into(), ..a.clone() };
        (b.sensor.rows, b.isp.preserve_white) = (10, !a.isp.preserve_white);
        b.sensor.cfa.pattern = crate::camera::description::PatternDescription::Name("rgbw".into());
        assert_eq!(camera_differences([&a, &b]).unwrap(), []);
        (a.exposure.time_ms, b.optics.f_number) = (Some(20.0), 1.8);
        b.sensor.pixel.pitch_um = 1.0;
        a.optics.ir_cut = Some(Filter::Flat(0.5));
        let found = camera_differences([&a, &b, &a]).unwrap();
        let of = |key: &str| found.iter().find(|d| d.key == key).map(|d| d.values.clone()).unwrap();
        assert_eq!(found.len(), 4, "{found:?}");
        assert_eq!(of("exposure.time_ms"), ["20.0", "none", "20.0"]);
        assert_eq!(of("sensor.pixel.pitch_um")[1], "1.0");
        assert_eq!(of("optics.ir_cut")[1], "none");
    }
}
