//! RGB pictures in OpenEXR: linear light, sRGB primaries unless the file states others.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{AnyChannels, FlatSamples, Layer, MetaData, ReadChannels, ReadLayers};
use smalti::color::{ColorSpace, Image};
use smalti::numeric::Planes;

use super::read::declared_bytes;
use crate::error::At;
use crate::file::{Negative, guarded, sample};
use crate::picture::Picture;
use crate::{IoError, Limits, Orientation, ReadOptions};

/// The channels R, G, B, or Y for all three.
pub(crate) fn rgb_from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Picture, IoError> {
    let negative = options.negative_or(Negative::Keep);
    for layer in load(bytes, path, options.limits)? {
        let channels = &layer.channel_data.list;
        let find = |name: &str| channels.iter().find(|c| c.name.to_string() == name);
        let names = if find("R").is_some() { ["R", "G", "B"] } else { ["Y", "Y", "Y"] };
        let [Some(r), Some(g), Some(b)] = names.map(find) else { continue };
        let (cols, rows) = (layer.size.0, layer.size.1);
        let mut data = Vec::with_capacity(3 * cols * rows);
        for (channel, name) in [r, g, b].into_iter().zip(names) {
            data.extend(checked(&channel.sample_data, name, cols, path, negative)?);
        }
        let planes = Planes::new(rows, cols, 3, data).at(path)?;
        let mut notes = Vec::new();
        if find("A").is_some() {
            notes.push("the alpha channel is ignored".to_owned());
        }
        return Ok(Picture {
            image: Image::new(ColorSpace::LinearSrgb, planes).at(path)?,
            bits: 32,
            orientation: Orientation::default(),
            notes,
        });
    }
    Err(IoError::field(path, "the picture", "without channels R, G, B or Y", "an RGB or grey picture"))
}

/// All layers, flat, at full resolution, after the header was compared with the length of the file.
fn load(bytes: &[u8], path: &Path, limits: Limits) -> Result<Vec<Layer<AnyChannels<FlatSamples>>>, IoError> {
    let decode = |e: exr::error::Error| IoError::decode(path, "OpenEXR", e);
    guarded(path, "OpenEXR", || {
        let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(decode)?;
        limits.check(path, "the image", declared_bytes(&meta, path)?, bytes.len() as u64)?;
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .map_err(decode)?;
        Ok(image.layer_data.into_vec())
    })
}

/// The samples of a channel as f32; an error names the first that is not what `negative` allows.
fn checked(
    samples: &FlatSamples,
    channel: &str,
    cols: usize,
    path: &Path,
    negative: Negative,
) -> Result<Vec<f32>, IoError> {
    let cols = cols.max(1);
    let check = |(i, v): (usize, f32)| {
        sample(v, negative)
            .map_err(|expected| IoError::pixel(path, channel, [i / cols, i % cols], v, expected))
    };
    match samples {
        FlatSamples::F16(v) => v.iter().map(|x| x.to_f32()).enumerate().map(check).collect(),
        FlatSamples::F32(v) => v.iter().copied().enumerate().map(check).collect(),
        FlatSamples::U32(v) => v.iter().map(|&x| x as f32).enumerate().map(check).collect(),
    }
}
