//! A camera: every key of its description with its unit, derived quantities, the mosaic and the spectra.

use serde_json::{Map, Value, json};
use smalti::camera::description::PatternDescription;
use smalti::camera::{Camera, ColorimetricObserver};
use smalti::experiment::light_notes;
use smalti::names::in_one_line;
use smalti::sensor::cfa::info;
use smalti::sensor::{Binning, Channel, Exposure};
use smalti::spectrum::Illuminant;
use smalti_io::cameras::LoadedCamera;
use smalti_io::{Override, cameras};
use smalti_report::names;

use super::datasheet::{Datasheet, Part, four_digits};
use super::tile::{self, Tile};
use super::{cfa, study};
use crate::args::Common;
use crate::output::note;

/// Sections of the description, in the direction of light.
const SECTIONS: [&str; 4] = ["optics", "sensor", "exposure", "isp"];
/// Keys that are tables of their own in the file; curves are written in one line.
const TABLES: [&str; 4] = ["pixel", "cfa", "psf", "zernike_um"];
/// Longer lists are shown by their length only.
const SHORT_LIST: usize = 8;
/// The wavelength of the diffraction limit.
const MIDDLE_NM: f64 = 550.0;

pub(super) fn datasheet(name: &str, overrides: &[Override], common: &Common) -> anyhow::Result<Datasheet> {
    let loaded = cameras::load_with_notes(name, overrides, None).map_err(anyhow::Error::from)?;
    let own_toml = loaded.stated_toml().map_err(anyhow::Error::from)?;
    let LoadedCamera { camera, stated, mut notes } = loaded;
    let warnings = light_notes(&camera, &Illuminant::D65.photons(camera.grid())?)?;
    notes.extend(warnings.iter().map(|text| format!("{}: {text}", stated.name)));
    notes.iter().for_each(|text| note(text, common));
    let (summary, toml) = if cameras::has_mosaic(name) {
        // No file has this text.
        (String::new(), format!("# {name}\n{own_toml}"))
    } else {
        study::file(name, cameras::names())?
    };
    let description = serde_json::to_value(camera.description())?;
    // Curves of files are shown by the names of the files.
    let mut shown = serde_json::to_value(&stated)?;
    leave_out_replaced(&mut shown);
    let array = &stated.sensor.cfa;
    let built_in = match &array.pattern {
        PatternDescription::Name(name) => info(name).ok(),
        PatternDescription::Letters(_) => None,
    };
    let described = |letter: char| match array.filters.get(&letter.to_string()) {
        Some(filter) => Some(value(&serde_json::to_value(filter).ok()?)),
        None => built_in?.filters.iter().find(|(l, _)| *l == letter).map(|(_, f)| (*f).to_owned()),
    };
    let tile = Tile::of(&camera.sensor.cfa, described)?;
    let sensitivity = sensitivity(&camera)?;
    let derived = derived(&camera)?;
    let mut lines = String::new();
    for section in SECTIONS {
        if let Some(Value::Object(keys)) = shown.get(section) {
            lines += &table(&format!("[{section}]"), section, keys);
        }
    }
    let row = |(name, value, unit): &(&str, f64, &str)| {
        [(*name).to_owned(), four_digits(*value), (*unit).to_owned()]
    };
    lines += &aligned("derived", &derived.iter().map(row).collect::<Vec<_>>());
    let ideal = camera.description().ideal_quantities();
    if !ideal.is_empty() {
        lines += &format!("ideal (not modelled or not stated)\n  {}\n", ideal.join(", "));
    }
    let entry = |(e, c): (&tile::Entry, &Channel)| {
        let values = c.transmittance.values();
        json!({"letter": e.letter.to_string(), "effective_sensitivity": values})
    };
    let json = json!({
        "kind": "camera", "name": camera.description().name, "summary": summary, "description": description,
        "notes": notes,
        "ideal": ideal,
        "derived": derived.iter().map(|(k, v, u)| json!({"name": k, "value": v, "unit": u})).collect::<Vec<_>>(),
        "wavelengths_nm": camera.grid().wavelengths_nm().collect::<Vec<_>>(),
        "cfa": tile.json(),
        "channels": tile.channels.iter().zip(&sensitivity).map(entry).collect::<Vec<_>>(),
    });
    let mut plot = cfa::spectra(
        "Effective sensitivity: filter × quantum efficiency × lens and infrared cut",
        "Electrons per photon",
        &tile,
    );
    plot.curves.iter_mut().zip(sensitivity).for_each(|(curve, c)| curve.values = c.transmittance);
    let size = format!("{} × {}", camera.sensor.cols, camera.sensor.rows);
    let of = match camera.sensor.binning {
        None => format!("{size} pixels"),
        Some(Binning { side, mode }) => {
            format!("{size} samples of {side} × {side} pixels each ({} binning)", mode.name())
        }
    };
    let title = format!("{}: a camera, {of}", camera.description().name);
    Ok(Datasheet {
        title,
        about: Some(summary).filter(|s| !s.is_empty()).into_iter().chain(notes).collect(),
        // The drawings come last, since they remain visible when the text scrolls.
        parts: vec![Part::Lines(lines), Part::Tile(tile), Part::Plot(plot)],
        json,
        toml: Some(toml),
    })
}

/// Quantities that are stated in electrons, and the keys in volts whose defaults they replace; with the table of both.
const REPLACED: [(&str, &str, &str); 4] = [
    ("/sensor", "dsnu_e", "dsnu_mv"),
    ("/sensor/pixel", "read_noise_e", "read_noise_mv"),
    ("/sensor/pixel", "dark_current_e_per_s", "dark_voltage_v_per_s"),
    ("/sensor/pixel", "low_gain_read_noise_e", "low_gain_read_noise_mv"),
];

/// Removes the values in volts that a value in electrons replaces.
fn leave_out_replaced(description: &mut Value) {
    for (table, electrons, volts) in REPLACED {
        if let Some(Value::Object(keys)) = description.pointer_mut(table)
            && keys.get(electrons).is_some_and(|v| !v.is_null())
        {
            keys.remove(volts);
        }
    }
}

/// Electrons per photon that reaches the lens, for each channel.
fn sensitivity(camera: &Camera) -> anyhow::Result<Vec<Channel>> {
    let lens = camera.optics.transmittance_on(camera.grid())?;
    let others = camera.sensor.quantum_efficiency.times(&lens)?;
    let channel =
        |c: &Channel| Ok(Channel { name: c.name.clone(), transmittance: c.transmittance.times(&others)? });
    camera.sensor.cfa.channels().iter().map(channel).collect()
}

/// Quantities derived from the keys: name, value, unit.
fn derived(camera: &Camera) -> anyhow::Result<Vec<(&'static str, f64, &'static str)>> {
    let (sensor, pixel) = (&camera.sensor, &camera.sensor.pixel);
    // With binning, of a sample: the electrons of all its photodiodes.
    let exposure = Exposure { analog_offset_v: 0.0, ..camera.gain_and_offset() };
    let saturation_e = sensor.saturation_e(&exposure);
    let read_e = sensor.read_noise_e(&exposure);
    let mut out = vec![
        ("width of the sensor", sensor.cols as f64 * pixel.pitch_m * 1e3, "mm"),
        ("height of the sensor", sensor.rows as f64 * pixel.pitch_m * 1e3, "mm"),
        ("horizontal field of view", camera.field_of_view_deg(sensor.cols, f64::INFINITY)?, "degrees"),
        ("Nyquist frequency", 0.5e-3 / pixel.pitch_m, "cy/mm"),
        ("diffraction cut-off at 550 nm", 1e-3 / (MIDDLE_NM * 1e-9 * camera.optics.f_number), "cy/mm"),
        ("saturation", saturation_e, "e⁻"),
    ];
    let light = Illuminant::D65.photons(camera.grid())?;
    let sensor = ColorimetricObserver::new(&light)?.colorimetry(camera)?;
    out.push(("Vora value", sensor.vora_value, ""));
    out.push(("sensitivity metamerism, D65", sensor.sensitivity_metamerism_index, "SMI"));
    out.push(("metamer mismatch, D65", sensor.metamer_mismatch_percent, "%"));
    if read_e > 0.0 {
        out.push(("read noise", read_e, "e⁻"));
        out.push(("saturation over read noise", 20.0 * (saturation_e / read_e).log10(), "dB"));
    }
    Ok(out)
}

/// The keys of a section, then its inner tables below their own headings.
fn table(heading: &str, path: &str, keys: &Map<String, Value>) -> String {
    // The legend of the tile shows the filters.
    if path == "sensor.cfa" {
        return String::new();
    }
    let inner = |v: &Value, key: &str| TABLES.contains(&key) && v.is_object();
    let unit = |v: &Value, key: &str| if v.is_number() || v.is_array() { names::unit(key) } else { "" };
    let line = |(key, v): (&String, &Value)| [key.clone(), value(v), unit(v, key).to_owned()];
    let lines: Vec<_> = keys.iter().filter(|(key, v)| !inner(v, key)).map(line).collect();
    let mut out = aligned(heading, &lines);
    for (key, v) in keys.iter().filter(|(key, v)| inner(v, key)) {
        if let Value::Object(keys) = v {
            let path = format!("{path}.{key}");
            out += &table(&format!("[{path}]"), &path, keys);
        }
    }
    out
}

/// A heading with names, values and units in columns below it.
fn aligned(heading: &str, lines: &[[String; 3]]) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let mut out = format!("{heading}\n");
    for [name, value, unit] in lines {
        let value = in_one_line(value);
        out += &format!("  {}\n", format!("{name:<32} {value:<14} {unit}").trim_end());
    }
    out
}

/// A value in one line; a long list by its length.
fn value(v: &Value) -> String {
    match v {
        Value::String(text) => text.clone(),
        Value::Number(n) => n.as_f64().filter(|_| n.is_f64()).map_or(n.to_string(), |x| x.to_string()),
        Value::Array(items) if items.len() > SHORT_LIST => format!("{} values", items.len()),
        Value::Array(items) => items.iter().map(value).collect::<Vec<_>>().join(", "),
        // A curve is a table with one key, its shape; a built-in curve is shown by its name.
        Value::Object(keys) => match (keys.len(), keys.get("builtin")) {
            (1, Some(name)) => value(name),
            (1, None) => keys.iter().map(|(k, v)| format!("{k}: {}", value(v))).collect(),
            _ => keys.iter().map(|(k, v)| format!("{k} {}", value(v))).collect::<Vec<_>>().join(", "),
        },
        other => other.to_string(),
    }
}
