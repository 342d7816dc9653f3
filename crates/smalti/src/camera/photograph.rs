//! A photograph: the exposure, the raw image and the picture of one capture.

use super::{Camera, CameraError};
use crate::color::Image;
use crate::isp::Isp;
use crate::optics::OpticalImage;
use crate::sensor::{Exposure, NoiseMode, RawImage};
use crate::spectrum::Spectrum;

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
}
