//! Processing: `[isp]`.

use serde::{Deserialize, Serialize};

use crate::isp::{Demosaic, WhiteBalance};

/// Image pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum PipelineName {
    /// Demosaic, white balance, colour matrix.
    Classic,
}

/// The surfaces a colour matrix is fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ColorCorrectionName {
    /// The 24 patches of the ColorChecker.
    Macbeth,
    /// The natural reflectances.
    Natural,
}

/// Colour space of the pictures written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum OutputName {
    /// sRGB (IEC 61966-2-1).
    Srgb,
    /// Display P3.
    DisplayP3,
}

/// `[isp]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct IspDescription {
    /// Image pipeline.
    pub pipeline: PipelineName,
    /// Demosaicking method.
    pub demosaic: Demosaic,
    /// White balance.
    pub white_balance: WhiteBalance,
    /// The surfaces to which the colour matrix is fitted by least squares, under the scene's illuminant.
    pub color_correction: ColorCorrectionName,
    /// Whether the matrix is constrained to render the illuminant's white exactly.
    pub preserve_white: bool,
    /// Noise that the matrix is fitted for, percent of the brightest white; 0: plain least squares.
    pub color_noise_percent: f64,
    /// Colour space of the pictures written.
    pub output: OutputName,
}

impl Default for IspDescription {
    fn default() -> Self {
        Self {
            pipeline: PipelineName::Classic,
            demosaic: Demosaic::Bilinear,
            white_balance: WhiteBalance::Illuminant,
            color_correction: ColorCorrectionName::Macbeth,
            preserve_white: false,
            color_noise_percent: 0.3,
            output: OutputName::Srgb,
        }
    }
}
