//! The messages of the studio by their structure: requests of the page to its engine and to the server, with arbitrary designs, and with a value changed anywhere.
#![no_main]

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use serde_json::{Value, json};
use smalti_serve::studio::native::Request;
use smalti_wasm::Engine;

/// Numbers at the ends of ranges.
const NUMBERS: [f64; 14] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    16.0,
    17.0,
    400.0,
    550.0,
    700.0,
    1e-300,
    1e300,
    4294967296.0,
    18446744073709551615.0,
];
/// Texts, among them names of files.
const TEXTS: [&str; 12] = [
    "",
    "R",
    "RG",
    "GB",
    "spices",
    "../../etc/passwd",
    "silicon",
    "bayer",
    "D65",
    "\u{0}",
    "é",
    "RGRGRGRGRGRGRGRGR",
];
/// Kinds of filters with their keys.
const FILTERS: [(&str, &[&str]); 9] = [
    ("flat", &[]),
    ("gaussian", &["center_nm", "sigma_nm", "peak"]),
    ("box", &["low_nm", "high_nm", "peak"]),
    ("raised_cosine", &["center_nm", "fwhm_nm", "peak"]),
    ("long_pass", &["edge_nm", "width_nm", "peak"]),
    ("butterworth", &["center_nm", "fwhm_nm", "order", "peak"]),
    ("builtin", &[]),
    ("file", &[]),
    ("samples", &["start_nm", "step_nm"]),
];

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let mut input = Unstructured::new(data);
    let Ok((engine, server)) = messages(&mut input) else { return };
    drop(Engine::default().ask(engine.to_string().as_bytes()));
    if let Ok(request) = Request::from_bytes(server.to_string().as_bytes()) {
        drop(request.check().map_err(|e| e.to_string()));
    }
});

/// A request to the engine and one to the server.
fn messages(input: &mut Unstructured<'_>) -> Result<(Value, Value)> {
    let design = design(input)?;
    let scene = text(input)?;
    let luminances =
        (0..input.int_in_range(0..=3)?).map(|_| number(input)).collect::<Result<Vec<Value>>>()?;
    let luminance = number(input)?;
    let draw =
        json!({"design": design, "scene": scene, "luminance_cd_m2": luminance, "seed": number(input)?});
    let cells = json!([[number(input)?, number(input)?]]);
    let filters = json!([text(input)?]);
    let locks = json!({"filters": filters, "cells": cells, "mosaic": input.arbitrary::<bool>()?});
    let mut engine = match input.int_in_range(0..=6u8)? {
        0 => json!({"curves": {"design": design}}),
        1 => json!({"camera_toml": {"design": design}}),
        2 => json!({"draw": draw}),
        3 => json!({"scores": {"design": design, "luminances_cd_m2": luminances}}),
        4 => json!({"improve": {"design": design, "locks": locks, "luminances_cd_m2": luminances}}),
        5 => json!({"learn": draw}),
        _ => json!({"step": {}}),
    };
    let job = match input.int_in_range(0..=3u8)? {
        0 => json!({"table": {"design": design, "quality": "best"}}),
        1 => {
            json!({"capture": {"design": design, "scene": scene, "luminance_cd_m2": luminance, "pipeline": null}})
        }
        2 => {
            json!({"search": {"design": design, "filters": filters, "cells": cells, "luminances_cd_m2": luminances}})
        }
        _ => {
            json!({"report": {"design": design, "rival": design, "scene": scene, "luminances_cd_m2": luminances}})
        }
    };
    let mut server = json!({"start": {"id": number(input)?, "job": job}});
    for message in [&mut engine, &mut server] {
        if input.ratio(1, 2)? {
            change(input, message)?;
        }
    }
    Ok((engine, server))
}

fn number(input: &mut Unstructured<'_>) -> Result<Value> {
    match input.int_in_range(0..=2u8)? {
        0 => Ok(json!(input.int_in_range(0..=20)?)),
        1 => Ok(json!(*input.choose(&NUMBERS)?)),
        _ => Ok(json!(input.arbitrary::<f64>()?)),
    }
}

fn text(input: &mut Unstructured<'_>) -> Result<Value> {
    if input.ratio(3, 4)? {
        Ok(json!(input.choose(&TEXTS)?))
    } else {
        Ok(json!(input.arbitrary::<String>()?))
    }
}

/// A camera with a mosaic of letters and arbitrary filters.
fn design(input: &mut Unstructured<'_>) -> Result<Value> {
    let (rows, cols) = (input.int_in_range(1..=4)?, input.int_in_range(1..=4)?);
    let letters = &["R", "G", "B", "W"][..input.int_in_range(1..=4)?];
    let mut line = || (0..cols).map(|_| Ok(*input.choose(letters)?)).collect::<Result<String>>();
    let pattern = (0..rows).map(|_| line()).collect::<Result<Vec<String>>>()?;
    let mut filters = json!({});
    for letter in letters {
        filters[*letter] = filter(input)?;
    }
    let mut design = json!({"name": "fuzz", "sensor": {"cfa": {"pattern": pattern, "filters": filters}}});
    if input.ratio(1, 3)? {
        design["sensor"]["pixel"] = json!({"pitch_um": number(input)?, "full_well_e": number(input)?, "read_noise_e": number(input)?});
    }
    if input.ratio(1, 3)? {
        design["optics"] = json!({"f_number": number(input)?, "ir_cut": filter(input)?});
    }
    if input.ratio(1, 3)? {
        design["exposure"] = json!({"time_ms": number(input)?});
    }
    Ok(design)
}

fn filter(input: &mut Unstructured<'_>) -> Result<Value> {
    let (kind, keys) = *input.choose(&FILTERS)?;
    let mut inner = json!({});
    for key in keys {
        inner[*key] = number(input)?;
    }
    let content = match kind {
        "flat" => number(input)?,
        "builtin" | "file" => text(input)?,
        "samples" => {
            let values = (0..input.int_in_range(0..=8)?).map(|_| number(input));
            inner["values"] = Value::Array(values.collect::<Result<_>>()?);
            inner
        }
        _ => inner,
    };
    Ok(json!({kind: content}))
}

/// Changes a value anywhere, or adds a key that there is not.
fn change(input: &mut Unstructured<'_>, value: &mut Value) -> Result<()> {
    let goes_on = input.ratio(3, 4)?;
    match value {
        Value::Object(map) if goes_on && !map.is_empty() => {
            let keys: Vec<String> = map.keys().cloned().collect();
            let key = input.choose(&keys)?;
            if input.ratio(1, 16)? {
                map.insert(input.arbitrary()?, json!(1));
            }
            map.get_mut(key).map_or(Ok(()), |inner| change(input, inner))
        }
        Value::Array(all) if goes_on && !all.is_empty() => {
            let at = input.choose_index(all.len())?;
            change(input, &mut all[at])
        }
        other => {
            *other = match input.int_in_range(0..=4u8)? {
                0 => Value::Null,
                1 => json!([]),
                2 => json!({}),
                3 => text(input)?,
                _ => number(input)?,
            };
            Ok(())
        }
    }
}
