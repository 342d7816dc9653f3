//! Raw images as DNG (Adobe Digital Negative, an extension of TIFF/EP; written as 1.4, read up to 1.7). Read are
//! uncompressed samples, lossless JPEG, Deflate and JPEG XL, as cameras, telephones and converters write them; lossy
//! JPEG is not.
//!
//! What DNG has a field for is stated there: mosaic, levels, colour matrix. Its colours are red, green, blue, cyan,
//! magenta, yellow and white, which also stands for clear; a channel of another name gets a code from 7 on. Names, exact
//! levels and the unit also stand as JSON in `ImageDescription`, so that [`read`] returns an equal [`RawImage`] for any mosaic.

mod jxl;
mod levels;
mod ljpeg;
mod mosaic;
mod opcodes;
mod packed;
mod picture;
mod read;
mod samples;
mod write;

use crate::Orientation;
use smalti::camera::{Camera, CameraError};
use smalti::isp::WhiteBalance;
use smalti::sensor::RawImage;
use smalti::spectrum::Spectrum;

pub use crate::scene_file::Crop;
pub use mosaic::StatedMosaic;
pub use picture::{DngPicture, write_picture};
pub use read::{from_bytes, read, read_as};
pub use write::{Compression, to_bytes, write, write_compressed};

/// How the camera sees colour, to develop the raw by.
#[derive(Debug, Clone, PartialEq)]
pub struct ColorMatrix {
    /// One row per channel: camera values from CIE XYZ (`ColorMatrix1`).
    pub camera_from_xyz: Vec<[f64; 3]>,
    /// The light it holds for, by its Exif `LightSource` code: 17 A, 20 D55, 21 D65, 22 D75, 23 D50.
    pub light_source: u16,
}

/// The metadata of a DNG.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DngInfo {
    /// Maker of the camera; not written when empty.
    pub make: String,
    /// Its model. `UniqueCameraModel` is make and model.
    pub model: String,
    /// Without it raw developers show the raw colours or refuse the file.
    pub color_matrix: Option<ColorMatrix>,
    /// Camera values of a neutral surface, one per channel.
    pub as_shot_neutral: Option<Vec<f64>>,
    /// Brightening by the developer, stops (`BaselineExposure`).
    pub baseline_exposure_stops: Option<f64>,
}

impl DngInfo {
    /// Exif's code of a light without a name.
    const OTHER_LIGHT: u16 = 255;

    /// The metadata of a simulated camera for pictures under a light, in photons.
    ///
    /// # Errors
    /// When the camera or the standard observer has no response to the light.
    pub fn of_camera(camera: &Camera, light: &Spectrum) -> Result<Self, CameraError> {
        let isp = camera.isp(light, WhiteBalance::None)?;
        let camera_from_xyz = camera.camera_from_xyz(light)?;
        Ok(Self {
            make: "Smalti".into(),
            model: camera.description().name.clone(),
            color_matrix: Some(ColorMatrix { camera_from_xyz, light_source: Self::OTHER_LIGHT }),
            as_shot_neutral: Some(isp.color_matrix.camera_white().to_vec()),
            baseline_exposure_stops: None,
        })
    }
}

/// A DNG as read.
#[derive(Debug, Clone, PartialEq)]
pub struct Dng {
    /// The raw image, cropped to the active area.
    pub raw: RawImage,
    /// The part of `raw` that makes the picture (`DefaultCropOrigin`, `DefaultCropSize`), where it is stated: the
    /// camera's own JPEG is of this size.
    pub default_crop: Option<Crop>,
    /// How the picture is to be turned for viewing.
    pub orientation: Orientation,
    /// The noise of the samples, where `NoiseProfile` states it: S and O, with the variance S x + O of a normalised sample of mean x, the
    /// mean over the channels.
    pub noise: Option<[f64; 2]>,
    /// The rest.
    pub info: DngInfo,
    /// What was simplified or ignored.
    pub notes: Vec<String>,
}

/// The JSON in `ImageDescription`.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
struct Description {
    smalti: Facts,
}

/// What the fields of DNG cannot hold, or only rounded.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
struct Facts {
    /// Names of the channels.
    channels: Vec<String>,
    /// Channel of every cell of the mosaic, row by row; absent where every pixel has every channel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    mosaic: Option<Vec<Vec<u8>>>,
    /// "digital numbers" or "V".
    unit: String,
    black_level: f64,
    white_level: f64,
}

// Values of PhotometricInterpretation.
const CFA: u16 = 32803;
const LINEAR_RAW: u16 = 34892;

#[cfg(test)]
mod tests;
