//! The conditions of a study.

use std::path::Path;

use smalti::camera::CameraDescription;
use smalti::design::{Condition, ConditionValue};
use smalti::names::nearest;

use super::file::{Conditions, MAX_CONDITIONS, StudyFile};
use crate::camera_toml::Override;
use crate::cameras::tell;
use crate::diagnostic::Diagnostic;
use crate::toml_source::{TomlSource, is_toml};
use crate::{cameras, lights};

/// Keys of a condition that are not keys of the camera.
const OF_STUDY: [&str; 2] = ["luminance_cd_m2", "illuminant"];

/// The conditions of the list, or those of the grid. Keys of a grid are sorted by name, and the last key changes fastest.
/// `notes` receives what is to be told about files.
pub(super) fn conditions(
    file: &StudyFile,
    source: &TomlSource,
    notes: &mut Vec<String>,
) -> Result<Vec<Condition>, Box<Diagnostic>> {
    let wrong = |key: &str, message: &str| Box::new(source.about_key(key, message));
    let mut points: Vec<Vec<(String, toml::Value)>> = vec![Vec::new()];
    match &file.conditions {
        None => {}
        Some(Conditions::Grid(axes)) => {
            for (key, axis) in axes {
                let values = axis.values().map_err(|e| wrong(&format!("conditions.grid.{key}"), &e))?;
                if points.len().saturating_mul(values.len()) > MAX_CONDITIONS {
                    return Err(wrong("conditions.grid", &format!("more than {MAX_CONDITIONS} conditions")));
                }
                let with = |point: &Vec<(String, toml::Value)>| {
                    let point = point.clone();
                    let key = key.clone();
                    values.clone().into_iter().map(move |v| {
                        let mut longer = point.clone();
                        longer.push((key.clone(), v));
                        longer
                    })
                };
                points = points.iter().flat_map(with).collect();
            }
        }
        Some(Conditions::List(list)) => {
            points = list.iter().map(|point| point.clone().into_iter().collect()).collect();
            for (i, point) in points.iter().enumerate() {
                same_keys(&points[0], point).map_err(|(message, help)| {
                    let shown = source.about_key(&format!("conditions.list[{i}]"), &message);
                    Box::new(Diagnostic { help: help.or(shown.help.clone()), ..shown })
                })?;
            }
        }
    }
    let listed = matches!(file.conditions, Some(Conditions::List(_)));
    let place = |i: usize| if listed { format!("conditions.list[{i}]") } else { "conditions.grid".into() };
    let condition = |(i, point)| condition(file, source, &place(i), point, notes);
    points.into_iter().enumerate().map(condition).collect()
}

/// Checks that an entry of the list has the keys of the first one. The error names the first key that only one of them has, and the
/// key that may be meant.
fn same_keys(
    first: &[(String, toml::Value)],
    other: &[(String, toml::Value)],
) -> Result<(), (String, Option<String>)> {
    let lacks = |of: &[(String, toml::Value)], key: &str| of.iter().all(|(k, _)| k != key);
    let only_in = |a: &[(String, toml::Value)], b: &[(String, toml::Value)]| -> Vec<String> {
        a.iter().map(|(key, _)| key.clone()).filter(|key| lacks(b, key)).collect()
    };
    let (missing, added) = (only_in(first, other), only_in(other, first));
    let meant = |key: &str| nearest(key, missing.iter().map(String::as_str));
    match (added.first(), missing.first()) {
        (Some(key), _) => {
            let help = meant(key).map(|meant| format!("did you mean `{meant}`?"));
            Err((format!("the first entry has no key `{key}`; all entries have the same keys"), help))
        }
        (None, Some(key)) => Err((
            format!("it lacks the key `{key}` of the first entry; all entries have the same keys"),
            None,
        )),
        (None, None) => Ok(()),
    }
}

/// A TOML value in the form of the option `--set`.
fn as_override(key: &str, value: &toml::Value) -> Override {
    Override { key: key.into(), value: value.to_string() }
}

/// Builds a condition. `place` is the path of its keys in the file.
fn condition(
    file: &StudyFile,
    source: &TomlSource,
    place: &str,
    point: Vec<(String, toml::Value)>,
    notes: &mut Vec<String>,
) -> Result<Condition, Box<Diagnostic>> {
    let wrong = |key: &str, message: &str| Box::new(source.about_key(key, message));
    // A condition overrides keys of the study. Errors point to the value that is used.
    let at = |key: &str| match point.iter().any(|(k, _)| k == key) {
        true => format!("{place}.{key}"),
        false => key.to_owned(),
    };
    let (mut luminance_cd_m2, mut light) = (file.luminance_cd_m2, file.illuminant.as_str());
    let mut overrides: Vec<Override> = file.set.iter().map(|(k, v)| as_override(k, v)).collect();
    let mut values = Vec::new();
    for (key, value) in &point {
        let number = value.as_float().or_else(|| value.as_integer().map(|i| i as f64));
        match (key.as_str(), number, value.as_str()) {
            ("luminance_cd_m2", Some(v), _) => luminance_cd_m2 = v,
            ("illuminant", _, Some(name)) => light = name,
            ("luminance_cd_m2", None, _) => return Err(wrong(&at(key), "expected a number")),
            ("illuminant", _, None) => return Err(wrong(&at(key), "expected a name")),
            _ => match nearest(key, OF_STUDY) {
                Some(meant) => {
                    let shown = source.about_key(&format!("{place}.{key}"), &format!("unknown key `{key}`"));
                    let help = Some(format!("did you mean `{meant}`?"));
                    return Err(Box::new(Diagnostic { help, ..shown }));
                }
                None => overrides.push(as_override(key, value)),
            },
        }
        let text = || ConditionValue::Text(value.as_str().map_or_else(|| value.to_string(), str::to_owned));
        values.push((key.clone(), number.map_or_else(text, ConditionValue::Number)));
    }
    if !(luminance_cd_m2 > 0.0 && luminance_cd_m2.is_finite()) {
        let message = format!("{luminance_cd_m2}; expected a number above 0");
        return Err(wrong(&at("luminance_cd_m2"), &message));
    }
    let camera = cameras::name_beside(&source.folder, &file.camera);
    let camera = cameras::load_with_notes(&camera, &overrides, None).map_err(|e| {
        match e.origin.strip_prefix("--set ") {
            // Overrides come from keys of the study file.
            Some(set) => {
                let key = set.split('=').next().unwrap_or(set);
                let place = if point.iter().any(|(k, _)| k == key) { place } else { "set" };
                let message = e.message.strip_prefix(&format!("`{key}`: ")).unwrap_or(&e.message);
                let shown = source.about_key(&format!("{place}.{key}"), message);
                Box::new(Diagnostic { help: e.help.clone().or(shown.help.clone()), ..shown })
            }
            None if !is_toml(Path::new(&file.camera)) => {
                let shown = source.about_key("camera", &format!("{}: {}", file.camera, e.message));
                Box::new(Diagnostic { help: e.help.clone().or(shown.help.clone()), ..shown })
            }
            // Errors in a camera file already point into that file.
            None => e,
        }
    })?;
    let (illuminant, told) = lights::load_with_note(light, &source.folder)
        .map_err(|e| wrong(&at("illuminant"), &e.to_string()))?;
    camera.notes.into_iter().chain(told).for_each(|note| tell(notes, Some(note)));
    let camera = CameraDescription::clone(camera.camera.description());
    Ok(Condition { values, luminance_cd_m2, illuminant, camera })
}
