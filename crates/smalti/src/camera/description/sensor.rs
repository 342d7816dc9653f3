//! The image sensor: `[sensor]`, its pixel and its colour filter array.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::BinningDescription;
use crate::sensor::cfa::{self, Mosaic};
use crate::sensor::{Binning, Filter};

/// Colour architecture of a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ArchitectureName {
    /// A colour filter array.
    Mosaic,
    /// A prism with one sensor per channel.
    Prism,
    /// One capture per channel; they share the exposure time.
    FieldSequential,
}

/// `[sensor]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct SensorDescription {
    /// Rows of pixels.
    pub rows: usize,
    /// Columns of pixels.
    pub cols: usize,
    /// Colour architecture: mosaic, prism or field-sequential capture.
    pub architecture: ArchitectureName,
    /// Bits of the converter; 0: no quantisation, the raw samples are volts.
    pub adc_bits: u32,
    /// Digital number without light.
    pub black_level_dn: f64,
    /// Gain differences between pixels, standard deviation in percent.
    pub prnu_percent: f64,
    /// Offset differences between pixels, standard deviation in mV.
    pub dsnu_mv: f64,
    /// Offset differences between pixels, standard deviation in electrons, in place of `dsnu_mv`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dsnu_e: Option<f64>,
    /// Noise common to a row, drawn anew for each capture, mV.
    pub row_noise_mv: f64,
    /// Offset common to a column, fixed for the device, standard deviation in mV.
    pub column_noise_mv: f64,
    /// Pixels that give no signal, per million.
    pub dead_pixels_ppm: f64,
    /// Pixels with a large dark signal, per million.
    pub hot_pixels_ppm: f64,
    /// Dark signal of a hot pixel, V/s.
    pub hot_pixel_dark_voltage_v_per_s: f64,
    /// Serial number of the device. It seeds the fixed-pattern noise, which is the same in every capture.
    pub serial: u64,
    /// Electrons per photon that reaches the photodetector.
    pub quantum_efficiency: Filter,
    /// Share of a pixel's signal that its neighbours receive, percent in all; 0: none.
    pub crosstalk_percent: f64,
    /// Binning of neighbouring pixels behind one filter: `"charge"` adds their electrons before one reading, `"digital"` averages
    /// their samples after the converter; absent or `"none"`: none. The blocks are the largest of one filter that the tile consists
    /// of, or those of `{ side = 2, mode = "charge" }`. All other keys remain those of the single pixels.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "super::binning::binning_or_none"
    )]
    #[cfg_attr(feature = "schema", schemars(schema_with = "super::binning::binning_or_none_schema"))]
    pub binning: Option<BinningDescription>,
    /// The pixel.
    pub pixel: PixelDescription,
    /// The colour filter array.
    pub cfa: CfaDescription,
}

impl Default for SensorDescription {
    fn default() -> Self {
        Self {
            rows: 480,
            cols: 640,
            architecture: ArchitectureName::Mosaic,
            adc_bits: 12,
            black_level_dn: 0.0,
            prnu_percent: 0.0,
            dsnu_mv: 0.0,
            dsnu_e: None,
            row_noise_mv: 0.0,
            column_noise_mv: 0.0,
            dead_pixels_ppm: 0.0,
            hot_pixels_ppm: 0.0,
            hot_pixel_dark_voltage_v_per_s: 1.0,
            serial: 1,
            quantum_efficiency: Filter::Flat(1.0),
            crosstalk_percent: 0.0,
            binning: None,
            pixel: PixelDescription::default(),
            cfa: CfaDescription::default(),
        }
    }
}

impl SensorDescription {
    /// Distance between samples, µm: that of the pixels, with binning times the side of a block. `None` when the mosaic cannot be
    /// binned.
    #[must_use]
    pub fn sample_pitch_um(&self) -> Option<f64> {
        Some(self.pixel.pitch_um * self.binning_side()? as f64)
    }

    /// Photodiodes along each side of a sample, 1 without binning. `None` when the mosaic cannot be binned.
    pub(crate) fn binning_side(&self) -> Option<usize> {
        match (self.binning, &self.cfa.pattern) {
            (None, _) => Some(1),
            (Some(BinningDescription::Blocks(blocks)), _) => Some(blocks.side),
            (Some(BinningDescription::Mode(_)), pattern) => {
                let lines = match pattern {
                    PatternDescription::Name(name) => cfa::pattern(name).ok()?,
                    PatternDescription::Letters(lines) => lines.clone(),
                };
                Mosaic::from_letters(&lines).ok()?.0.block_side(Binning::MAX_SIDE)
            }
        }
    }
}

/// `[sensor.pixel]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct PixelDescription {
    /// Distance between pixels, µm.
    pub pitch_um: f64,
    /// Photodetector area divided by pixel area.
    pub fill_factor: f64,
    /// Volts per electron, µV.
    pub conversion_gain_uv_per_e: f64,
    /// Largest output, V.
    pub voltage_swing_v: f64,
    /// Largest number of electrons that a pixel holds.
    pub full_well_e: f64,
    /// Dark signal at 25 °C, V/s.
    pub dark_voltage_v_per_s: f64,
    /// Dark current at 25 °C, electrons per second, in place of `dark_voltage_v_per_s`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dark_current_e_per_s: Option<f64>,
    /// Temperature of the sensor, °C; the dark signal doubles with every `dark_doubling_c` above 25.
    pub temperature_c: f64,
    /// Temperature step that doubles the dark signal, °C.
    pub dark_doubling_c: f64,
    /// Noise of one reading, mV RMS.
    pub read_noise_mv: f64,
    /// Noise of one reading, electrons RMS, in place of `read_noise_mv`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub read_noise_e: Option<f64>,
    /// The low conversion gain of a pixel with two, µV, below `conversion_gain_uv_per_e`, which is then the high one;
    /// `exposure.conversion_gain` selects. Voltages of dark signal and DSNU are those at the high gain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub low_conversion_gain_uv_per_e: Option<f64>,
    /// Noise of one reading with the low conversion gain, mV RMS; absent: as many millivolts as with the high one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub low_gain_read_noise_mv: Option<f64>,
    /// Noise of one reading with the low conversion gain, electrons RMS, in place of `low_gain_read_noise_mv`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub low_gain_read_noise_e: Option<f64>,
}

impl Default for PixelDescription {
    fn default() -> Self {
        Self {
            pitch_um: 2.2,
            fill_factor: 0.45,
            conversion_gain_uv_per_e: 200.0,
            voltage_swing_v: 1.8,
            full_well_e: 9000.0,
            dark_voltage_v_per_s: 1e-5,
            dark_current_e_per_s: None,
            temperature_c: 25.0,
            dark_doubling_c: 6.0,
            read_noise_mv: 1.34,
            read_noise_e: None,
            low_conversion_gain_uv_per_e: None,
            low_gain_read_noise_mv: None,
            low_gain_read_noise_e: None,
        }
    }
}

/// Keys of one quantity in volts and in electrons, of which a file gives one.
pub const TWIN_KEYS: [[&str; 2]; 4] = [
    ["sensor.dsnu_mv", "sensor.dsnu_e"],
    ["sensor.pixel.dark_voltage_v_per_s", "sensor.pixel.dark_current_e_per_s"],
    ["sensor.pixel.read_noise_mv", "sensor.pixel.read_noise_e"],
    ["sensor.pixel.low_gain_read_noise_mv", "sensor.pixel.low_gain_read_noise_e"],
];

/// The tile: the name of a built-in, or its lines in letters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "expected the name of a CFA, or its lines such as [\"RG\", \"GB\"]")]
pub enum PatternDescription {
    /// A built-in (`smalti list cfas`).
    Name(String),
    /// One string per row, one letter per cell.
    Letters(Vec<String>),
}

/// `[sensor.cfa]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct CfaDescription {
    /// The tile.
    pub pattern: PatternDescription,
    /// One filter per letter. If `pattern` is the name of a built-in array, they replace the filters of that array.
    /// `file = "filters.csv"` takes those of all letters from the columns of a file.
    #[serde(skip_serializing_if = "BTreeMap::is_empty", deserialize_with = "filter_table")]
    #[cfg_attr(feature = "schema", schemars(schema_with = "filter_table_schema"))]
    pub filters: BTreeMap<String, Filter>,
    /// Letters that stand for weighted sums of filters: `a = { R = 0.5, G = 0.5 }`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub mixtures: BTreeMap<String, BTreeMap<String, f64>>,
}

impl Default for CfaDescription {
    fn default() -> Self {
        Self {
            pattern: PatternDescription::Name("bayer".into()),
            filters: BTreeMap::new(),
            mixtures: BTreeMap::new(),
        }
    }
}

/// The key of `sensor.cfa.filters` that names a file with a column for each letter. Its entry is a [`Filter::File`], which the reader
/// of the file replaces by the filters of the columns.
pub const FILTER_TABLE: &str = "file";

/// Filters by letter. The value of [`FILTER_TABLE`] is the name of a file.
fn filter_table<'de, D: Deserializer<'de>>(deserializer: D) -> Result<BTreeMap<String, Filter>, D::Error> {
    deserializer.deserialize_map(FilterTable)
}

struct FilterTable;

impl<'de> Visitor<'de> for FilterTable {
    type Value = BTreeMap<String, Filter>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "a table of filters, such as { R = { file = \"red.csv\" } } or { file = \"filters.csv\" }",
        )
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut filters = BTreeMap::new();
        while let Some(key) = map.next_key::<String>()? {
            let filter =
                if key == FILTER_TABLE { Filter::File(map.next_value()?) } else { map.next_value()? };
            filters.insert(key, filter);
        }
        Ok(filters)
    }
}

#[cfg(feature = "schema")]
fn filter_table_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
    let filter = generator.subschema_for::<Filter>();
    schemars::json_schema!({
        "type": "object",
        "additionalProperties": { "anyOf": [filter, { "type": "string" }] },
    })
}
