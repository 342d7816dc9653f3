//! The axes of classes as strings and arrays: what tables and statistics share.

use serde_json::json;
use smalti::l3::{Axes, Levels};
use smalti::sensor::Mosaic;

use crate::IoError;
use crate::container::{Content, Opened};
use crate::error::At;

/// Adds all that `read` needs.
pub(super) fn put(content: &mut Content, axes: &Axes) {
    let (over_noise, flat_fraction) = axes.contrast();
    content.text("side", axes.side());
    content.text("textures", json!(axes.textures()).as_str().unwrap_or_default());
    content.text("noise", json!(axes.noise()));
    content.text("clip", axes.clip());
    content.text("contrast_over_noise", over_noise);
    content.text("contrast_flat_fraction", flat_fraction);
    let mosaic = axes.mosaic();
    content.tensor("mosaic", &[mosaic.rows(), mosaic.cols()], mosaic.cells().iter().copied());
    let cuts = axes.levels().iter().flat_map(|l| l.cuts().iter().copied());
    content.tensor("cuts", &[axes.levels().len(), axes.level_count() - 1], cuts);
}

/// The axes, exactly as they were put.
pub(super) fn read(opened: &Opened<'_>) -> Result<Axes, IoError> {
    let path = opened.path();
    let (shape, cells) = opened.any::<u8>("mosaic", 2)?;
    let mosaic = Mosaic::new(shape[0], shape[1], cells).at(path)?;
    let positions = mosaic.cells().len();
    let (shape, cuts) = opened.any::<f32>("cuts", 2)?;
    // Compared before anything is made of it: with no cuts, any number of sets fits into no bytes.
    if shape[0] != 1 && shape[0] != positions {
        let found = format!("of shape {shape:?}");
        return Err(opened.wrong("tensor 'cuts'", found, format!("1 or {positions} sets")));
    }
    let set = |i: usize| Levels::new(cuts[i * shape[1]..(i + 1) * shape[1]].to_vec());
    let levels = (0..shape[0]).map(set).collect::<Result<Vec<_>, _>>().at(path)?;
    let textures = opened.text("textures")?;
    let textures = serde_json::from_value(json!(textures)).map_err(|_| {
        opened.wrong("textures", format!("'{textures}'"), "'none', 'flat-texture' or 'oriented'")
    })?;
    let (clip, over_noise, flat_fraction) = (
        opened.number("clip")?,
        opened.number("contrast_over_noise")?,
        opened.number("contrast_flat_fraction")?,
    );
    Axes::new(mosaic, opened.number("side")?, levels[0].clone(), opened.json("noise")?)
        .and_then(|axes| axes.with_levels(levels))
        .and_then(|axes| axes.with_contrast(over_noise, flat_fraction))
        .and_then(|axes| axes.with_clip(clip))
        .map(|axes| axes.with_textures(textures))
        .at(path)
}
