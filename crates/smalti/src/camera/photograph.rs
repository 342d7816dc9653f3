//! A photograph: the exposure, the raw image and the picture of one capture.

use super::{Camera, CameraError};
use crate::color::Image;
use crate::color::display::D65_XYZ;
use crate::isp::{Isp, WhiteBalance};
use crate::l3::Pipeline;
use crate::optics::OpticalImage;
use crate::sensor::{Exposure, NoiseMode, RawImage};
use crate::spectrum::{Observer, Spectrum};

/// One picture with the results of all earlier stages.
#[derive(Debug, Clone)]
pub struct Photograph {
    /// Irradiance on the sensor.
    pub optical_image: OpticalImage,
    /// The exposure, stated or automatic.
    pub exposure: Exposure,
    /// The raw image.
    pub raw: RawImage,
    /// The picture in XYZ, with the white balance of the description.
    pub picture: Image,
}

impl Camera {
    /// Captures an optical image of a scene under an illuminant (photons) and renders the raw image.
    ///
    /// # Errors
    /// When a stage fails; the message names it.
    pub fn photograph(
        &self,
        optical_image: OpticalImage,
        light: &Spectrum,
        noise: NoiseMode,
        seed: u64,
    ) -> Result<Photograph, CameraError> {
        let exposure = self.exposure(&optical_image)?;
        let raw = self.sensor.capture(&optical_image, &exposure, noise, seed)?;
        let picture = self.isp(light, self.white_balance())?.render(&raw)?;
        Ok(Photograph { optical_image, exposure, raw, picture })
    }

    /// [`Camera::photograph`], with the raw image rendered by a learned pipeline. White is balanced for the illuminant, or not at
    /// all.
    ///
    /// # Errors
    /// When a stage fails, the pipeline does not fit the camera, or the white balance of the description depends on the picture.
    pub fn photograph_learned(
        &self,
        pipeline: &Pipeline,
        optical_image: OpticalImage,
        light: &Spectrum,
        (noise, seed): (NoiseMode, u64),
    ) -> Result<Photograph, CameraError> {
        pipeline.ensure_renders(&self.sensor.cfa)?;
        self.ensure_one_gain()?;
        let is_balanced = match self.white_balance() {
            WhiteBalance::None => false,
            WhiteBalance::Illuminant => true,
            WhiteBalance::GrayWorld => {
                let message = "gray-world is defined for the camera's own processing; a learned pipeline takes illuminant or none";
                return Err(CameraError::Key { key: "isp.white_balance".into(), message: message.into() });
            }
        };
        let exposure = self.exposure(&optical_image)?;
        let raw = self.sensor.capture(&optical_image, &exposure, noise, seed)?;
        let picture = pipeline.render(&raw)?;
        let picture = match is_balanced {
            true => picture.adapted(D65_XYZ, Observer::Cie1931.white(light)?)?,
            false => picture,
        };
        Ok(Photograph { optical_image, exposure, raw, picture })
    }
}
