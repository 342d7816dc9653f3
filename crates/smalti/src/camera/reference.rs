//! Reference pictures: the response of the standard observer, or of any set of sensitivities, behind the lens and pixels of a
//! camera. They have the scale of the camera's pictures, so that both can be compared directly.
//!
//! # Scale
//!
//! Under the illuminant `l` (photons, through a lens of transmittance τ) a perfect white diffuser causes the irradiance κ·τ·l on
//! a pixel, with a geometric factor κ. With black level 0 and white level 1, its raw value is
//!
//! `n_c = κ · A · ∫τ·s_c·l · t · g / (white − black)`
//!
//! in channel `c`, with the photodetector's area `A`, the responsivity `s_c`, the time `t` and the gain `g` in samples per
//! photoelectron. [`Classic`](crate::isp::Classic) renders it with Y = max n_c. The response of an observer without the lens is
//! `κ · ∫ȳ·l`. The factor from this response to the picture does not depend on κ:
//!
//! `A · max_c ∫τ·s_c·l · t · g / ((white − black) · ∫ȳ·l)`.

use super::{Camera, CameraError};
use crate::color::{ColorSpace, Image};
use crate::isp::IspError;
use crate::numeric::Planes;
use crate::optics::OpticalImage;
use crate::sensor::{
    Binning, BinningMode, Cfa, Channel, ColorArchitecture, Exposure, Light, Mosaic, NonUniformity, Pixel,
    Sensor,
};
use crate::spectrum::{Extrapolation, Observer, Spectrum};

/// Transmittance of the lens below which the irradiance before the lens is not reconstructed.
const OPAQUE: f64 = 1e-4;
/// Conversion gain of the reference pixel, volts per electron, so small that no pixel saturates.
const OBSERVER_V_PER_E: f64 = 1e-9;

impl Camera {
    /// X, Y, Z of the standard observer behind the same lens and pixels, for every pixel that is read, without noise, mosaic or
    /// saturation, up to a common factor.
    ///
    /// # Errors
    /// As [`Sensor::expected_volts`].
    pub fn reference(&self, image: &OpticalImage) -> Result<Image, CameraError> {
        let weights = Observer::Cie1931.photon_weights(self.grid())?;
        let largest = weights.iter().map(Spectrum::max).fold(0.0, f64::max);
        let volts = self.witness_of(&xyz(&weights), largest)?.volts(image)?;
        Ok(Image::new(ColorSpace::Xyz, volts)?)
    }

    /// X, Y, Z of the standard observer at every pixel without noise, on the scale of the pictures of
    /// [`Classic`](crate::isp::Classic) at an exposure under an illuminant (photons): Y = 1 for a perfect white diffuser that just
    /// saturates its brightest channel. Colours are those before the lens, which are the target of the colour matrix; blur and
    /// fall-off are those behind the lens.
    ///
    /// The reference does not saturate and has no crosstalk between pixels.
    ///
    /// # Errors
    /// When the illuminant is dark to the camera or the observer, its wavelengths are not those of the camera, or the exposure is
    /// invalid.
    pub fn reference_as_exposed(
        &self,
        image: &OpticalImage,
        exposure: &Exposure,
        light: &Spectrum,
    ) -> Result<Image, CameraError> {
        self.as_exposed(self.seen_by_observer(image)?, exposure, light)
    }

    /// Scales the response of the observer as in [`Camera::reference_as_exposed`].
    pub(crate) fn as_exposed(
        &self,
        mut seen: Planes,
        exposure: &Exposure,
        light: &Spectrum,
    ) -> Result<Image, CameraError> {
        let y = &Observer::Cie1931.photon_weights(self.grid())?[1];
        let scale = self.exposure_scale(exposure, light, y)? as f32;
        seen.data_mut().iter_mut().for_each(|v| *v *= scale);
        Ok(Image::new(ColorSpace::Xyz, seen)?)
    }

    /// [`Camera::seen_by`] for the standard observer: X, Y, Z.
    pub(crate) fn seen_by_observer(&self, image: &OpticalImage) -> Result<Planes, CameraError> {
        self.seen_by(image, &self.observer_channels()?)
    }

    /// The sensitivities of the standard observer: X, Y, Z per photon.
    pub(super) fn observer_channels(&self) -> Result<Vec<Channel>, CameraError> {
        Ok(xyz(&Observer::Cie1931.photon_weights(self.grid())?))
    }

    /// The response of other sensitivities (per photon, not negative, in any unit; zero beyond their wavelengths) behind the same
    /// lens and pixels: one plane for each sensitivity, for every pixel that is read, without noise, mosaic or saturation. A value
    /// is the mean over the photodetector of ∫ sensitivity · irradiance. The transmittance of the lens is divided out where it is
    /// at least 10⁻⁴.
    ///
    /// The unit is that of the sensitivities times photons s⁻¹ m⁻². Multiplied by [`Camera::exposure_scale`], the planes have the
    /// scale of a picture and are targets for training.
    ///
    /// # Errors
    /// When there is no sensitivity, one is negative, or all are zero; and as [`Sensor::expected_volts`].
    pub fn seen_by(&self, image: &OpticalImage, targets: &[Channel]) -> Result<Planes, CameraError> {
        self.witness(targets)?.seen(image)
    }

    /// The sensor whose response [`Camera::seen_by`] states.
    pub(super) fn witness(&self, targets: &[Channel]) -> Result<Witness, CameraError> {
        let lens = self.optics.transmittance_on(self.grid())?;
        let before = |c: &Channel| {
            let mut passes = lens.values().iter();
            let on_grid = c.transmittance.resampled(self.grid(), Extrapolation::Zero)?;
            let undone = on_grid.map(|_, v| match passes.next() {
                Some(&t) if t >= OPAQUE => v / t,
                _ => 0.0,
            })?;
            Ok(Channel { name: c.name.clone(), transmittance: undone })
        };
        let targets = targets.iter().map(before).collect::<Result<Vec<_>, CameraError>>()?;
        let largest = targets.iter().map(|c| c.transmittance.max()).fold(0.0, f64::max);
        self.witness_of(&targets, largest)
    }

    /// The factor from the planes of [`Camera::seen_by`] to the scale of a picture: a perfect white diffuser that just saturates
    /// its brightest channel becomes 1 in the plane of `sensitivity` (ȳ for XYZ). All planes of one target take the same factor,
    /// so that they keep their ratios.
    ///
    /// For a target under another light than that of the capture, divide by ∫ sensitivity · target light and multiply by
    /// ∫ sensitivity · light, both lights as radiance of a white diffuser.
    ///
    /// # Errors
    /// When the illuminant is dark to the camera or the sensitivity, grids differ, or the exposure is invalid.
    pub fn exposure_scale(
        &self,
        exposure: &Exposure,
        light: &Spectrum,
        sensitivity: &Spectrum,
    ) -> Result<f64, CameraError> {
        exposure.validate()?;
        let white = |s: &Spectrum| Ok::<f64, CameraError>(s.times(light)?.integral());
        let channels = self.responsivities()?.iter().map(white).collect::<Result<Vec<_>, _>>()?;
        let brightest = channels.iter().copied().fold(0.0, f64::max);
        let seen = white(&sensitivity.resampled(self.grid(), Extrapolation::Zero)?)?;
        for (what, response) in [("the camera", brightest), ("the target", seen)] {
            if response <= 0.0 {
                return Err(IspError::NoResponse(what).into());
            }
        }
        let (sensor, pixel) = (&self.sensor, &self.sensor.pixel);
        let levels = sensor.raw_levels(exposure)?;
        let range_v = levels.white_v - levels.black_v;
        let per_electron = sensor.volts_per_electron(exposure) * exposure.analog_gain / range_v;
        let per_photon = pixel.photodetector_area_m2() * exposure.time_s / sensor.captures() * per_electron;
        Ok(brightest * per_photon / seen)
    }

    /// Pixels with other sensitivities, whose largest value is `largest`.
    fn witness_of(&self, targets: &[Channel], largest: f64) -> Result<Witness, CameraError> {
        if largest <= 0.0 {
            return Err(IspError::NoResponse("the target").into());
        }
        let scaled = |c: &Channel| -> Result<Channel, CameraError> {
            Ok(Channel { name: c.name.clone(), transmittance: c.transmittance.scaled(1.0 / largest)? })
        };
        let channels = targets.iter().map(scaled).collect::<Result<Vec<_>, _>>()?;
        let cells = (0..targets.len()).map(|c| c.min(usize::from(u8::MAX)) as u8).collect();
        let sensor = Sensor {
            cfa: Cfa::new("observer", Mosaic::new(1, targets.len(), cells)?, channels)?,
            architecture: ColorArchitecture::Prism,
            quantum_efficiency: Spectrum::constant(self.grid(), 1.0)?,
            ir_cut: None,
            crosstalk: None,
            nonuniformity: NonUniformity::default(),
            // The light on all photodiodes of a sample.
            binning: self.sensor.binning.map(|b| Binning { mode: BinningMode::Charge, ..b }),
            ..self.sensor.clone()
        };
        // The full well and the voltage swing are so large that the reference never clips.
        let pixel = Pixel {
            full_well_e: 1e12,
            voltage_swing_v: 1e3,
            conversion_gain_v_per_e: OBSERVER_V_PER_E,
            ..sensor.pixel
        };
        let sensor = Sensor { pixel, ..sensor };
        let volts_per_unit = OBSERVER_V_PER_E * pixel.photodetector_area_m2() / largest;
        Ok(Witness { sensor, volts_per_unit })
    }
}

/// Other sensitivities behind the lens and the pixels of a camera: a sensor without noise, mosaic and saturation.
#[derive(Debug, Clone)]
pub(crate) struct Witness {
    pub(crate) sensor: Sensor,
    /// Of ∫ sensitivity · irradiance.
    volts_per_unit: f64,
}

impl Witness {
    fn volts<'a>(&self, light: impl Into<Light<'a>>) -> Result<Planes, CameraError> {
        Ok(self.sensor.expected_volts(light, &Exposure::new(1.0))?)
    }

    /// The response, as [`Camera::seen_by`] states it.
    pub(crate) fn seen<'a>(&self, light: impl Into<Light<'a>>) -> Result<Planes, CameraError> {
        let mut volts = self.volts(light)?;
        let scale = (1.0 / self.volts_per_unit) as f32;
        volts.data_mut().iter_mut().for_each(|v| *v *= scale);
        Ok(volts)
    }
}

fn xyz(weights: &[Spectrum; 3]) -> Vec<Channel> {
    let channel = |(name, w): (&str, &Spectrum)| Channel { name: name.into(), transmittance: w.clone() };
    ["X", "Y", "Z"].into_iter().zip(weights).map(channel).collect()
}
