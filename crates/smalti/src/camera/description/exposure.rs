//! Exposure time and gain: `[exposure]`.

use serde::{Deserialize, Serialize};

/// How the exposure time is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum AutoExposureName {
    /// The brightest point of the image reaches 95 % of saturation.
    Specular,
    /// The mean of the image reaches `auto_target`.
    Mean,
    /// The `auto_percentile` of illuminance reaches `auto_target`.
    Luminance,
}

/// Which conversion gain reads the pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ConversionGainName {
    /// The gain `sensor.pixel.conversion_gain_uv_per_e`.
    High,
    /// The gain `sensor.pixel.low_conversion_gain_uv_per_e`.
    Low,
    /// For each exposure the high gain if at most 0.5 % of the samples saturate with it, otherwise the low gain.
    Auto,
    /// Both gains read the same electrons: a sample is that of the high gain up to 95 % of its saturation, otherwise that of the low
    /// gain times the ratio of the gains.
    Combined,
}

/// `[exposure]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ExposureDescription {
    /// Exposure time, ms; absent: `auto`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_ms: Option<f64>,
    /// Rule that finds the time if `time_ms` is absent (then `specular` by default).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub auto: Option<AutoExposureName>,
    /// Share of saturation to reach; absent: 0.95 for specular and luminance, 0.18 for mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub auto_target: Option<f64>,
    /// Percentile of illuminance for `auto = "luminance"`.
    pub auto_percentile: f64,
    /// Multiplies the voltage. ISETCam's gain of the same name divides.
    pub analog_gain: f64,
    /// Added to the voltage before the gain, mV.
    pub analog_offset_mv: f64,
    /// Conversion gain of pixels with two; absent: high.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub conversion_gain: Option<ConversionGainName>,
}

impl Default for ExposureDescription {
    fn default() -> Self {
        Self {
            time_ms: None,
            auto: None,
            auto_target: None,
            auto_percentile: 99.0,
            analog_gain: 1.0,
            analog_offset_mv: 0.0,
            conversion_gain: None,
        }
    }
}
