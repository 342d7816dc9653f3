//! Learned tables by their structure: an arbitrary valid table, and one of its fields changed. No field makes the reader panic, and what it accepts is
//! written and read back equal.
#![no_main]

use std::path::Path;

use libfuzzer_sys::arbitrary::{Error, Result, Unstructured};
use serde_json::{Map, Value, json};
use smalti::l3::{Axes, Class, Kernels, Levels, Origin, Pipeline, PipelineParts, Textures};
use smalti::sensor::{Mosaic, SignalNoise};
use smalti_io::IoError;
use smalti_io::l3::{table_from_bytes, table_to_bytes};

/// Values of strings, beside arbitrary ones.
const TEXTS: [&str; 16] = [
    "",
    "0",
    "1",
    "2",
    "3",
    "5",
    "-1",
    "1e308",
    "NaN",
    "null",
    "[]",
    "{}",
    "[0.5]",
    "oriented",
    "18446744073709551616",
    "smalti-l3-statistics",
];
/// Types of arrays.
const TYPES: [&str; 6] = ["F32", "F64", "U8", "U32", "U64", "I8"];

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let mut input = Unstructured::new(data);
    let Ok(table) = table(&mut input) else { return };
    let bytes = table_to_bytes(&table, Path::new("fuzz")).expect("a valid table can be written");
    assert_eq!(read(&bytes).expect("a table that was written can be read"), table);
    let Ok(changed) = changed(&mut input, bytes) else { return };
    if let Ok(accepted) = read(&changed) {
        let again = table_to_bytes(&accepted, Path::new("fuzz")).expect("what was read can be written");
        let read = read(&again).expect("what was written can be read");
        assert_eq!(table_to_bytes(&read, Path::new("fuzz")).expect("it can be written again"), again);
        assert_eq!(read, accepted);
    }
});

/// Reads; where only the hash is wrong, with the right one in its place.
fn read(bytes: &[u8]) -> std::result::Result<Pipeline, IoError> {
    let path = Path::new("fuzz");
    let (found, stated) = match table_from_bytes(bytes, path) {
        Err(IoError::Damaged { found, stated, .. }) if found.len() == stated.len() => (found, stated),
        other => return other,
    };
    let mut bytes = bytes.to_vec();
    let at = bytes.windows(stated.len()).position(|w| w == stated.as_bytes());
    if let Some(place) = at.and_then(|at| bytes.get_mut(at..at + found.len())) {
        place.copy_from_slice(found.as_bytes());
    }
    table_from_bytes(&bytes, path)
}

/// A valid table of a small mosaic.
fn table(input: &mut Unstructured<'_>) -> Result<Pipeline> {
    let wrong = |_| Error::IncorrectFormat;
    let (rows, cols) = (input.int_in_range(1..=3)?, input.int_in_range(1..=3)?);
    let channels = input.int_in_range(1..=(rows * cols).min(4))? as u8;
    // The first cells have every channel.
    let cell = |at: usize, input: &mut Unstructured<'_>| match u8::try_from(at) {
        Ok(at) if at < channels => Ok(at),
        _ => input.int_in_range(0..=channels - 1),
    };
    let cells = (0..rows * cols).map(|at| cell(at, input)).collect::<Result<Vec<u8>>>()?;
    let mosaic = Mosaic::new(rows, cols, cells).map_err(wrong_mosaic)?;
    let count = input.int_in_range(0..=3)?;
    let level = |input: &mut Unstructured<'_>| {
        let mut cut = 0.0;
        let mut next = || {
            cut += f32::from(input.int_in_range(1..=1000u16)?) / 1000.0;
            Ok(cut)
        };
        let cuts = (0..count).map(|_| next()).collect::<Result<Vec<f32>>>()?;
        Levels::new(cuts).map_err(wrong)
    };
    let noise = SignalNoise { constant: 1e-6, per_signal: 1e-4, ..SignalNoise::default() };
    let side = *input.choose(&[3, 5])?;
    let first = level(input)?;
    let mut axes = Axes::new(mosaic, side, first, noise).map_err(wrong)?;
    if input.ratio(1, 4)? {
        let levels = (0..axes.positions()).map(|_| level(input)).collect::<Result<Vec<Levels>>>()?;
        axes = axes.with_levels(levels).map_err(wrong)?;
    }
    let textures = *input.choose(&[Textures::None, Textures::FlatTexture, Textures::Oriented])?;
    let axes = axes.with_textures(textures);
    let mut masks = vec![0];
    for mask in 1..1u32 << channels {
        if input.ratio(1, 8)? {
            masks.push(mask);
        }
    }
    let outputs: Vec<String> = ["X", "Y", "Z"].map(str::to_owned)[..input.int_in_range(1..=3)?].to_vec();
    let classes = axes.positions() * masks.len() * axes.level_count() * axes.textures().count();
    let mut number = || -> f32 { f32::from(input.arbitrary::<i16>().unwrap_or_default()) / 1024.0 };
    let weights = (0..classes * outputs.len() * axes.taps()).map(|_| number()).collect();
    let offsets = (0..classes * outputs.len()).map(|_| number()).collect();
    let trained = (0..axes.positions()).map(|_| [number(), number()]).collect();
    let origins = [Origin::Learned, Origin::Interpolated, Origin::PooledLevels, Origin::NearestLevel];
    let mut class = || -> Result<Class> {
        Ok(Class { count: input.arbitrary::<u32>()?.into(), origin: *input.choose(&origins)? })
    };
    Pipeline::from_parts(PipelineParts {
        saturations: masks,
        outputs,
        channel_names: (0..channels).map(|c| char::from(b'a' + c).to_string()).collect(),
        black_level: 0.0,
        white_level: 255.0,
        trained,
        classes: (0..classes).map(|_| class()).collect::<Result<_>>()?,
        kernels: Kernels { weights, offsets },
        provenance: "{}".into(),
        axes,
    })
    .map_err(wrong)
}

fn wrong_mosaic<E>(_: E) -> Error {
    Error::IncorrectFormat
}

/// The file with a field, or bytes of an array, changed.
fn changed(input: &mut Unstructured<'_>, mut bytes: Vec<u8>) -> Result<Vec<u8>> {
    let length = bytes.first_chunk::<8>().map_or(0, |b| u64::from_le_bytes(*b)) as usize;
    let arrays = bytes.split_off((8 + length).min(bytes.len()));
    let mut header: Map<String, Value> =
        serde_json::from_slice(&bytes[8..]).map_err(|_| Error::IncorrectFormat)?;
    let mut arrays = arrays;
    for _ in 0..input.int_in_range(1..=3)? {
        let keys: Vec<String> = header.keys().cloned().collect();
        let Some(field) = header.get_mut(input.choose(&keys)?.as_str()).and_then(Value::as_object_mut) else {
            return Err(Error::IncorrectFormat);
        };
        let names: Vec<String> = field.keys().cloned().collect();
        let name = input.choose(&names)?;
        let value = match name.as_str() {
            "dtype" => json!(input.choose(&TYPES)?),
            "shape" | "data_offsets" => {
                let count = input.int_in_range(0..=4)?;
                let extent = |_| Ok(json!(*input.choose(&[0u64, 1, 2, 3, 9, 255, u64::MAX, 1 << 40])?));
                Value::Array((0..count).map(extent).collect::<Result<_>>()?)
            }
            _ if input.arbitrary()? => json!(input.choose(&TEXTS)?),
            _ => json!(input.arbitrary::<String>()?),
        };
        match input.int_in_range(0..=3u8)? {
            0 => drop(field.remove(name)),
            1 if !arrays.is_empty() => {
                let at = input.choose_index(arrays.len())?;
                arrays[at] = input.arbitrary()?;
            }
            _ => drop(field.insert(name.clone(), value)),
        }
    }
    let header = serde_json::to_vec(&header).map_err(|_| Error::IncorrectFormat)?;
    Ok([&(header.len() as u64).to_le_bytes()[..], &header, &arrays].concat())
}
