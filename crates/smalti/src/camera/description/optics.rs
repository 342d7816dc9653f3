//! The lens: `[optics]`.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{self, MapAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::numeric::Planes;
use crate::optics::{Boundary, Falloff, ZernikeIndex};
use crate::sensor::Filter;

/// How the lens forms the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum OpticsModelName {
    /// No blur, for tests.
    Pinhole,
    /// Limited by diffraction alone, with defocus if stated.
    Diffraction,
    /// Wavefront aberrations by Zernike coefficients.
    Zernike,
    /// A point spread function from a file.
    Psf,
}

/// `[optics]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct OpticsDescription {
    /// How the image is formed.
    pub model: OpticsModelName,
    /// Focal length divided by the diameter of the entrance pupil.
    pub f_number: f64,
    /// Focal length, mm.
    pub focal_length_mm: f64,
    /// Fall-off towards the edge.
    pub falloff: Falloff,
    /// What the lens sees beyond the border of the scene.
    pub surround: Boundary,
    /// Transmittance of the lens.
    pub transmittance: Filter,
    /// Infrared-cut filter in front of the sensor; absent or `"none"`: none.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "filter_or_none")]
    #[cfg_attr(feature = "schema", schemars(schema_with = "filter_or_none_schema"))]
    pub ir_cut: Option<Filter>,
    /// Separation of the four spots of a birefringent low-pass filter on the sensor, µm in both directions; 0: none.
    pub low_pass_separation_um: f64,
    /// Error of the lens power, dioptres.
    pub defocus_dioptres: f64,
    /// Wavelength at which the lens is in focus, nm; only with `chromatic_dioptres_per_um`.
    pub chromatic_reference_nm: f64,
    /// Longitudinal chromatic focus: change of focus per µm of wavelength, dioptres/µm; 0: none.
    pub chromatic_dioptres_per_um: f64,
    /// Wavefront coefficients, µm RMS, by index (`model = "zernike"`).
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub zernike_um: BTreeMap<String, f64>,
    /// Numbering of the Zernike modes in `zernike_um`.
    pub zernike_ordering: ZernikeIndex,
    /// Point spread function, a `.npy` of shape (wavelengths, rows, cols) (`model = "psf"`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psf: Option<PsfDescription>,
}

impl Default for OpticsDescription {
    fn default() -> Self {
        Self {
            model: OpticsModelName::Diffraction,
            f_number: 4.0,
            focal_length_mm: 3.863,
            falloff: Falloff::Cos4,
            surround: Boundary::Mirror,
            transmittance: Filter::Flat(1.0),
            ir_cut: None,
            low_pass_separation_um: 0.0,
            defocus_dioptres: 0.0,
            chromatic_reference_nm: 550.0,
            chromatic_dioptres_per_um: 0.0,
            zernike_um: BTreeMap::new(),
            zernike_ordering: ZernikeIndex::Noll,
            psf: None,
        }
    }
}

/// `[optics.psf]`: a measured or computed point spread function.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PsfDescription {
    /// A `.npy` of shape (wavelengths, rows, cols), or (rows, cols) for all wavelengths; each plane is scaled to
    /// unit sum, its centre at (rows / 2, cols / 2).
    pub file: String,
    /// Distance between samples on the sensor, µm.
    pub spacing_um: f64,
    /// First wavelength, nm.
    #[serde(default = "first_nm")]
    pub start_nm: f64,
    /// Step between the planes, nm.
    #[serde(default = "step_nm")]
    pub step_nm: f64,
    /// The content of the file, once it has been read.
    #[serde(skip)]
    pub planes: Option<Planes>,
    /// BLAKE3 hash of the file, which identifies the data of a resolved description. Smalti adds it when it reads the file.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub hash: String,
}

fn first_nm() -> f64 {
    400.0
}

fn step_nm() -> f64 {
    10.0
}

/// A filter, or the word `none`.
fn filter_or_none<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Filter>, D::Error> {
    deserializer.deserialize_any(FilterOrNone)
}

struct FilterOrNone;

impl<'de> Visitor<'de> for FilterOrNone {
    type Value = Option<Filter>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a filter such as { builtin = \"hot-mirror\" }, or \"none\"")
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Self::Value, E> {
        if text == "none" { Ok(None) } else { Err(E::invalid_value(Unexpected::Str(text), &self)) }
    }

    fn visit_unit<E: de::Error>(self) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_none<E: de::Error>(self) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_any(self)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        Filter::deserialize(MapAccessDeserializer::new(map)).map(Some)
    }
}

#[cfg(feature = "schema")]
fn filter_or_none_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
    let filter = generator.subschema_for::<Filter>();
    schemars::json_schema!({ "anyOf": [filter, { "type": "null" }, { "const": "none" }] })
}
