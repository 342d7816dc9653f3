//! RGB pictures in OpenEXR: linear light, sRGB primaries unless the file says otherwise.

use std::path::Path;

use smalti::color::{ColorSpace, Image};
use smalti::numeric::Planes;

use super::read::{checked, load};
use crate::IoError;
use crate::ReadOptions;
use crate::error::At;
use crate::file::Negative;
use crate::picture::Picture;

/// The channels R, G, B, or Y for all three.
pub(crate) fn rgb_from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Picture, IoError> {
    let negative = if options.clamp_negative { Negative::Clamp } else { Negative::Keep };
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
        return Ok(Picture { image: Image::new(ColorSpace::LinearSrgb, planes).at(path)?, bits: 32, notes });
    }
    Err(IoError::field(path, "the picture", "without channels R, G, B or Y", "an RGB or grey picture"))
}
