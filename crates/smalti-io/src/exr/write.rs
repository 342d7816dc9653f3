//! Writing spectral OpenEXR.

use std::collections::HashMap;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, Image, Layer,
    LayerAttributes, LineOrder, Text, WritableImage,
};

use super::layout::{Layout, fichet_name};
use crate::scene_file::facts::Comment;
use crate::text::ascii_json;
use crate::{IoError, Quantity, SpectralFile, write};

/// Writes a spectral image, 32-bit, losslessly compressed. What the layout has no place for (name, distance, field
/// of view, illuminant, exact grid) goes as JSON into the attribute `comments`, so that [`super::open`] returns an
/// equal value. Equal values make equal bytes.
///
/// # Errors
/// When a reflectance should be written in PBRT's layout, or the file cannot be written.
pub fn write(path: &Path, file: &SpectralFile, layout: Layout) -> Result<(), IoError> {
    let grid = file.cube.grid();
    let kind = match (layout, file.quantity) {
        (Layout::Pbrt, Quantity::Reflectance) => {
            let expected = "that of Fichet et al. for reflectances";
            return Err(IoError::field(path, "the layout", "PBRT's", expected));
        }
        (_, Quantity::Reflectance) => "T",
        _ => "S0",
    };
    let channels =
        grid.wavelengths_nm().zip(file.cube.planes().planes()).enumerate().map(|(i, (nm, plane))| {
            let name = match layout {
                Layout::Pbrt => format!("Radiance.C{:02}", i + 1),
                Layout::Fichet2021 => fichet_name(kind, nm),
            };
            // The names are made here, of ASCII: they are always valid.
            AnyChannel::new(Text::from(name.as_str()), FlatSamples::F32(plane.to_vec()))
        });
    let channels = AnyChannels::sort(channels.collect());

    let attributes = LayerAttributes {
        comments: Text::new_or_none(ascii_json(&Comment::of(file))),
        other: attribute("emissiveUnits", units(file.quantity).filter(|_| layout == Layout::Fichet2021)),
        ..LayerAttributes::default()
    };
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new((file.cube.cols(), file.cube.rows()), attributes, encoding, channels);
    let mut image = Image::from_layer(layer);
    // Attributes are hash maps, written in their random order. With one entry in each, the bytes of a file
    // depend on its content alone.
    image.attributes.other =
        attribute("spectralLayoutVersion", Some("1.0").filter(|_| layout == Layout::Fichet2021));

    write::atomic(path, |out| {
        image.write().to_buffered(out).map_err(|e| {
            IoError::writing(path)(match e {
                exr::error::Error::Io(source) => source,
                other => std::io::Error::other(other.to_string()),
            })
        })
    })
}

fn attribute(name: &str, value: Option<&str>) -> HashMap<Text, AttributeValue> {
    value.map(|v| (Text::from(name), AttributeValue::Text(Text::from(v)))).into_iter().collect()
}

/// In the words of the layout's authors, who omit "per nm".
fn units(quantity: Quantity) -> Option<&'static str> {
    match quantity {
        Quantity::Photons => Some("photons.s^-1.m^-2.sr^-1"),
        Quantity::Energy => Some("W.m^-2.sr^-1"),
        Quantity::RelativeEnergy | Quantity::Reflectance => None,
    }
}
