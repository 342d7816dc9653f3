//! Statistics of training, `.l3s`.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::json;
use smalti::l3::{ClassKey, Moments, Statistics};

use super::axes;
use crate::container::{Content, Opened};
use crate::error::At;
use crate::{IoError, Limits, file};

const FORMAT: &str = "smalti-l3-statistics";
const VERSION: &str = "1";

/// Writes statistics so that they read back bit for bit: merging and adding continue as if they had stayed in memory.
///
/// # Errors
/// [`IoError::Write`].
pub fn write_statistics(path: &Path, statistics: &Statistics) -> Result<(), IoError> {
    content(statistics).write(path)
}

/// The bytes of the file in pieces.
pub(crate) fn statistics_pieces(statistics: &Statistics) -> Result<Vec<Vec<u8>>, IoError> {
    content(statistics).into_pieces(Path::new("statistics"))
}

fn content(statistics: &Statistics) -> Content {
    let axes = statistics.axes();
    let mut content = Content::default();
    content.text("format", FORMAT);
    content.text("version", VERSION);
    axes::put(&mut content, axes);
    content.text("channel_names", json!(statistics.channel_names()));
    content.text("outputs", json!(statistics.outputs()));
    content.text("noisy", statistics.noisy());
    content.text("white", json!(statistics.white()));
    if let Some([black, white]) = statistics.raw_levels() {
        content.text("black_level", black);
        content.text("white_level", white);
    }
    content.tensor("trained", &[axes.positions(), 2], statistics.trained().iter().flatten().copied());
    let classes = statistics.classes();
    let keys = classes.keys().flat_map(|k| [k.position, k.saturation, k.level.into(), k.texture.into()]);
    content.tensor("keys", &[classes.len(), 4], keys);
    let triangle = triangle(axes.taps(), statistics.outputs().len());
    let sums = classes.values().flat_map(|m| m.sums().iter().copied());
    content.tensor("sums", &[classes.len(), triangle], sums);
    content
}

/// Entries on and above the diagonal of the moments.
fn triangle(taps: usize, outputs: usize) -> usize {
    let size = (1 + taps).saturating_add(outputs);
    // A product beyond the largest number fits no array.
    size.saturating_mul(size.saturating_add(1)) / 2
}

/// Reads statistics. Errors are those of [`super::read_table`].
pub fn read_statistics(path: &Path) -> Result<Statistics, IoError> {
    statistics_from_bytes(&file::read(path, Limits::default().file_bytes)?, path)
}

/// As [`read_statistics`], from memory; `path` is only named in errors.
pub fn statistics_from_bytes(bytes: &[u8], path: &Path) -> Result<Statistics, IoError> {
    let opened = Opened::new(bytes, path, super::EXPECTED, (FORMAT, &[VERSION]))?;
    let axes = axes::read(&opened)?;
    let outputs: Vec<String> = opened.json("outputs")?;
    let levels = match opened.has("black_level") || opened.has("white_level") {
        true => Some([opened.number("black_level")?, opened.number("white_level")?]),
        false => None,
    };
    let noisy = match opened.text("noisy")? {
        "true" => true,
        "false" => false,
        other => return Err(opened.wrong("noisy", format!("'{other}'"), "'true' or 'false'")),
    };
    let trained: Vec<f32> = opened.shaped("trained", &[axes.positions(), 2])?;
    if trained.iter().any(|v| v.is_nan()) {
        let expected = "numbers, infinite where none was seen";
        return Err(opened.wrong("tensor 'trained'", "not a number", expected));
    }
    let (shape, keys) = opened.any::<u32>("keys", 2)?;
    if shape[1] != 4 {
        return Err(opened.wrong("tensor 'keys'", format!("of shape {shape:?}"), "4 numbers for each class"));
    }
    let triangle = triangle(axes.taps(), outputs.len());
    let sums: Vec<f64> = opened.shaped("sums", &[shape[0], triangle])?;
    let mut classes = BTreeMap::new();
    for (key, sums) in keys.as_chunks::<4>().0.iter().zip(sums.chunks_exact(triangle)) {
        let wrong = |found: String, expected| opened.wrong("tensor 'keys'", found, expected);
        let (Ok(level), Ok(texture)) = (key[2].try_into(), key[3].try_into()) else {
            return Err(wrong(format!("{key:?}"), "levels and textures of the axes"));
        };
        let k = ClassKey { position: key[0], saturation: key[1], level, texture };
        if classes.last_key_value().is_some_and(|(last, _)| *last >= k) {
            return Err(wrong(format!("not ascending at {key:?}"), "classes in ascending order, each once"));
        }
        let moments = Moments::from_sums(axes.taps(), outputs.len(), sums.to_vec()).ok_or_else(|| {
            let expected = "finite sums, the first the number of patches";
            opened.wrong("tensor 'sums'", format!("impossible for class {key:?}"), expected)
        })?;
        classes.insert(k, moments);
    }
    let (channel_names, white) = (opened.json("channel_names")?, opened.json("white")?);
    Statistics::from_parts(
        axes,
        outputs,
        channel_names,
        levels,
        noisy,
        trained.as_chunks().0.to_vec(),
        classes,
    )
    .map(|s| s.with_white(white))
    .at(path)
}
