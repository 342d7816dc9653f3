//! What differs between cameras besides the colour filter array.

use std::collections::BTreeMap;

use serde_json::Value;

use super::ExperimentError;
use super::error::StageContext;
use crate::camera::{Camera, CameraDescription, CameraError};

/// The field of view of a thousand samples along a row, as the key of a difference.
pub const FIELD_OF_VIEW: &str = "field of view of 1000 samples, degrees";

/// Keys that a comparison of colour filter arrays varies, or that do not affect its scores: pictures have the size of the scene, and
/// scores are computed before white balance and output.
const IGNORED: [&str; 7] =
    ["name", "sensor.rows", "sensor.cols", "sensor.cfa", "isp.pipeline", "isp.white_balance", "isp.output"];
/// Tables of a description; all other objects are values.
const TABLES: [&str; 5] = ["optics", "sensor", "sensor.pixel", "exposure", "isp"];
/// The key of the wavelengths: the first, the step and the last.
const WAVELENGTHS: &str = "wavelengths_nm";
/// What the absence of a key means, where it is not the absence of the thing.
const ABSENT: [(&str, &str); 3] = [
    ("exposure.time_ms", "automatic"),
    ("optics.ir_cut", "none stated"),
    (WAVELENGTHS, "400 to 700 in steps of 10"),
];
/// The longest value that is stated in full, characters.
const MAX_STATED: usize = 40;

/// The keys of the processing, `[isp]`, that affect scores.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IspKeys {
    /// None: learned pipelines replace the processing.
    Unused,
    /// Those of the colour matrix. The demosaicking is that of the comparison.
    ColorMatrix,
    /// All.
    Own,
}

impl IspKeys {
    /// Whether a key affects scores.
    fn contain(self, key: &str) -> bool {
        match self {
            Self::Unused => !key.starts_with("isp."),
            Self::ColorMatrix => key != "isp.demosaic",
            Self::Own => true,
        }
    }
}

/// A key whose values differ between cameras.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CameraDifference {
    /// The key of the description, with its unit; or what follows from several keys, in words.
    pub key: String,
    /// The value of each camera: `none` where it is absent, and a letter for each distinct curve.
    pub values: Vec<String>,
}

/// The samples whose field of view is stated, which are as many for every camera.
const SAMPLES: usize = 1000;
/// The distance of the scene at which it is stated, m: far beyond any focal length.
const DISTANCE_M: f64 = 1000.0;
/// The smallest ratio of two values that differ.
const DIFFERENT: f64 = 1.0005;

/// What differs between cameras besides the colour filter array and the number of pixels: keys of lens, sensor, exposure, processing that is used
/// and wavelengths, then the spacing of binned samples and the field of view of equally many samples, which follow from them.
///
/// # Errors
/// When a description cannot be represented as text, and when a camera has no image of a distant scene.
pub fn camera_differences(
    cameras: &[Camera],
    isp: IspKeys,
) -> Result<Vec<CameraDifference>, ExperimentError> {
    let mut differences = of_descriptions(cameras.iter().map(Camera::description), isp)?;
    // Without binning it is the pitch of the pixels, a key of its own.
    if cameras.iter().any(|c| c.sensor.binning.is_some()) {
        let pitches_um = cameras.iter().map(|c| c.sensor.pixel.pitch_m * 1e6);
        differences.extend(of_values("sample pitch, µm", &pitches_um.collect::<Vec<_>>()));
    }
    let view =
        |c: &Camera| c.field_of_view_deg(SAMPLES, DISTANCE_M).in_context(|| c.description().name.clone());
    let views_deg = cameras.iter().map(view).collect::<Result<Vec<_>, _>>()?;
    differences.extend(of_values(FIELD_OF_VIEW, &views_deg));
    Ok(differences)
}

/// A derived quantity, where it differs.
fn of_values(name: &str, values: &[f64]) -> Option<CameraDifference> {
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    let stated = || values.iter().map(|v| format!("{v:.2}")).collect();
    (high > DIFFERENT * low).then(|| CameraDifference { key: name.to_owned(), values: stated() })
}

/// The keys of descriptions that differ.
fn of_descriptions<'a>(
    cameras: impl IntoIterator<Item = &'a CameraDescription>,
    isp: IspKeys,
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
    let mut names: Vec<&String> =
        cameras.iter().flat_map(BTreeMap::keys).filter(|key| isp.contain(key)).collect();
    names.sort();
    names.dedup();
    let difference = |key: &String| {
        let values: Vec<&Value> = cameras.iter().map(|c| c.get(key).unwrap_or(&Value::Null)).collect();
        let differs = values.windows(2).any(|pair| pair[0] != pair[1]);
        differs.then(|| CameraDifference { key: key.clone(), values: stated(key, &values) })
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

/// A number with four significant digits and without trailing zeros.
fn rounded(value: f64) -> String {
    let magnitude = if value == 0.0 { 0 } else { libm::floor(libm::log10(value.abs())) as i32 };
    if !(-4..6).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    let text = format!("{value:.*}", (3 - magnitude).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A number as text; anything else as JSON.
fn number(value: &Value) -> String {
    value.as_f64().map_or_else(|| value.to_string(), rounded)
}

/// Values as text. Long ones, such as measured curves, get a letter each.
fn stated<'a>(key: &str, values: &[&'a Value]) -> Vec<String> {
    let mut long: Vec<&'a Value> = Vec::new();
    let one = |&value: &&'a Value| match value {
        Value::Null => ABSENT.iter().find(|(of, _)| *of == key).map_or("none", |(_, words)| words).to_owned(),
        Value::Number(_) => number(value),
        Value::String(text) => text.clone(),
        Value::Object(curve) if curve.len() == 1 && curve.contains_key("builtin") => {
            curve["builtin"].as_str().unwrap_or_default().to_owned()
        }
        Value::Object(curve) if curve.len() == 1 && curve.contains_key("flat") => {
            format!("flat {}", number(&curve["flat"]))
        }
        other => {
            if let (WAVELENGTHS, Some([start, step, end])) = (key, other.as_array().map(Vec::as_slice)) {
                return format!("{} to {} in steps of {}", number(start), number(end), number(step));
            }
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
    use crate::camera::description::{BinningDescription, PatternDescription};
    use crate::sensor::{BinningMode, Filter};
    use crate::spectrum::WavelengthGrid;

    #[test]
    fn only_what_a_filter_array_does_not_change_is_stated() {
        let mut a = CameraDescription { name: "a".into(), ..CameraDescription::default() };
        let mut b = CameraDescription { name: "b".into(), ..a.clone() };
        (b.sensor.rows, b.isp.preserve_white) = (10, !a.isp.preserve_white);
        b.isp.demosaic = crate::isp::Demosaic::Malvar2004;
        b.sensor.cfa.pattern = PatternDescription::Name("rgbw".into());
        let keys = |isp| -> Vec<String> {
            of_descriptions([&a, &b], isp).unwrap().into_iter().map(|d| d.key).collect()
        };
        // What an evaluation and classic processing depend on is not hidden.
        assert_eq!(keys(IspKeys::Unused), [""; 0]);
        assert_eq!(keys(IspKeys::ColorMatrix), ["isp.preserve_white"]);
        assert_eq!(keys(IspKeys::Own), ["isp.demosaic", "isp.preserve_white"]);
        (a.exposure.time_ms, b.optics.f_number) = (Some(20.0), 1.8);
        b.sensor.pixel.pitch_um = 1.0;
        a.optics.ir_cut = Some(Filter::Flat(0.5));
        b.wavelengths_nm = Some([400.0, 50.0, 700.0]);
        let found = of_descriptions([&a, &b, &a], IspKeys::Unused).unwrap();
        let of = |key: &str| found.iter().find(|d| d.key == key).map(|d| d.values.clone()).unwrap();
        assert_eq!(found.len(), 5);
        let usual = "400 to 700 in steps of 10";
        assert_eq!(of("wavelengths_nm"), [usual, "400 to 700 in steps of 50", usual]);
        assert_eq!(of("exposure.time_ms"), ["20", "automatic", "20"]);
        assert_eq!(of("sensor.pixel.pitch_um")[1], "1");
        assert_eq!(of("optics.ir_cut"), ["flat 0.5", "none stated", "flat 0.5"]);
    }

    #[test]
    fn numbers_have_four_digits() {
        let all = [0.0, 0.12531328320802, 25.5918, 71_820.0, 1.8, 1e-5, 3e7, -0.05].map(rounded);
        assert_eq!(all, ["0", "0.1253", "25.59", "71820", "1.8", "1.000e-5", "3.000e7", "-0.05"]);
    }

    #[test]
    fn unequal_fields_of_view_are_stated() {
        let of = |f: &dyn Fn(&mut CameraDescription)| {
            let mut description = CameraDescription::default();
            f(&mut description);
            Camera::new(description, WavelengthGrid::default()).unwrap()
        };
        let quad = |d: &mut CameraDescription| {
            d.sensor.cfa.pattern = PatternDescription::Name("quad-bayer".into());
            (d.sensor.pixel.pitch_um, d.optics.focal_length_mm) = (1.0, 5.0);
        };
        let full = of(&quad);
        let binned = of(&|d| {
            quad(d);
            d.sensor.binning = Some(BinningDescription::Mode(BinningMode::Charge));
        });
        let found = camera_differences(&[full.clone(), binned], IspKeys::Unused).unwrap();
        let values = |key: &str| found.iter().find(|d| d.key == key).map(|d| d.values.clone()).unwrap();
        assert_eq!(values("sample pitch, µm"), ["1.00", "2.00"]);
        // 2 atan(1000 × 1 µm / 2 / 5 mm).
        assert_eq!(values(FIELD_OF_VIEW), ["11.42", "22.62"]);
        // The lens alone can make the difference.
        let longer = of(&|d| {
            quad(d);
            d.optics.focal_length_mm = 10.0;
        });
        let found = camera_differences(&[full.clone(), longer], IspKeys::Unused).unwrap();
        assert_eq!(found.last().unwrap().values, ["11.42", "5.72"]);
        assert!(found.iter().all(|d| d.key != "sample pitch, µm"));
        assert_eq!(camera_differences(&[full.clone(), full], IspKeys::Unused).unwrap(), []);
    }
}
