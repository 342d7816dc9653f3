//! The camera as its user describes it: one struct per table of `camera.toml`, keys in the user's units.
//!
//! Every key has a default, so that a file names only what differs; the resolved description names all.

mod binning;
mod electrons;
mod exchange;
mod exposure;
mod ideal;
mod isp;
mod optics;
mod sensor;

pub use binning::{BinnedBlocks, BinningDescription};
pub use exchange::{ExchangeError, ExchangedMosaic, FilterWithKind};
pub use exposure::{AutoExposureName, ConversionGainName, ExposureDescription};
pub use isp::{ColorCorrectionName, IspDescription, OutputName, PipelineName};
pub use optics::{OpticsDescription, OpticsModelName, PsfDescription};
pub use sensor::{
    ArchitectureName, CfaDescription, FILTER_TABLE, PatternDescription, PixelDescription, SensorDescription,
    TWIN_KEYS,
};

use serde::{Deserialize, Serialize};

/// A camera file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct CameraDescription {
    /// Name of the camera.
    pub name: String,
    /// Wavelength grid if the scene states none: first, step and last, nm. Default: 400, 10, 700.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavelengths_nm: Option<[f64; 3]>,
    /// The lens.
    pub optics: OpticsDescription,
    /// The image sensor.
    pub sensor: SensorDescription,
    /// Exposure time and gain.
    pub exposure: ExposureDescription,
    /// Processing from raw to picture.
    pub isp: IspDescription,
}

impl Default for CameraDescription {
    fn default() -> Self {
        Self {
            name: "camera".into(),
            wavelengths_nm: None,
            optics: OpticsDescription::default(),
            sensor: SensorDescription::default(),
            exposure: ExposureDescription::default(),
            isp: IspDescription::default(),
        }
    }
}
