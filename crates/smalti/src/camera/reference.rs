//! What others would see in the place of a camera: the standard observer, or any set of sensitivities; on the scale of the
//! camera's own pictures, so that picture and reference can be compared as they are.
//!
//! # Scale
//!
//! Under the light `l` (photons, through a lens of transmittance τ) a perfect white diffuser throws the irradiance κ·τ·l on a
//! pixel; κ is geometry. It makes the raw value, black level 0 and white level 1,
//!
//! `n_c = κ · A · ∫τ·s_c·l · t · g / (white − black)`
//!
//! in channel `c`, with the photodetector's area `A`, the responsivity `s_c`, the time `t` and the gain `g` in samples per
//! photoelectron. [`Classic`](crate::isp::Classic) renders it with Y = max n_c. An observer without the lens before him sees
//! `κ · ∫ȳ·l` there. Hence the factor from what is seen to the picture: κ is gone from
//!
//! `A · max_c ∫τ·s_c·l · t · g / ((white − black) · ∫ȳ·l)`.

use super::{Camera, CameraError};
use crate::color::{ColorSpace, Image};
use crate::isp::IspError;
use crate::numeric::Planes;
use crate::optics::OpticalImage;
use crate::sensor::{Cfa, Channel, ColorArchitecture, Exposure, Mosaic, NonUniformity, Pixel, Sensor};
use crate::spectrum::{Observer, Outside, Spectrum};

/// A lens that passes less than this at a wavelength has taken the light away: it is not looked for behind the lens.
const OPAQUE: f64 = 1e-4;
/// Volts per electron of the pixel that an observer looks through: so few, and the well so large, that nothing is ever full.
const OBSERVER_V_PER_E: f64 = 1e-9;

impl Camera {
    /// What the standard observer would see through the same lens and pixels: XYZ of every pixel that is read, without
    /// noise, mosaic or saturation, absolute up to a common factor.
    ///
    /// # Errors
    /// As [`Sensor::expected_volts`].
    pub fn reference(&self, image: &OpticalImage) -> Result<Image, CameraError> {
        let weights = Observer::Cie1931.photon_weights(self.grid())?;
        let largest = weights.iter().map(Spectrum::max).fold(0.0, f64::max);
        let (volts, _) = self.volts_through(image, &xyz(&weights), largest)?;
        Ok(Image::new(ColorSpace::Xyz, volts)?)
    }

    /// What the standard observer sees of the scene, pixel by pixel and without noise, on the scale of
    /// [`Classic`](crate::isp::Classic)'s pictures at an exposure under a light (photons): Y = 1 for a perfect white diffuser
    /// that just saturates the channel that sees it brightest. Colours are those before the lens, as the camera's colour
    /// matrix aims at them; blur and fall-off are those behind it.
    ///
    /// It does not saturate: what is brighter than the sensor can hold stays so. Crosstalk between pixels, which a
    /// colour matrix knows nothing of, is left out.
    ///
    /// # Errors
    /// When the light is dark to camera or observer, its wavelengths are not the camera's, or the exposure is impossible.
    pub fn reference_as_exposed(
        &self,
        image: &OpticalImage,
        exposure: &Exposure,
        light: &Spectrum,
    ) -> Result<Image, CameraError> {
        self.as_exposed(self.seen_by_observer(image)?, exposure, light)
    }

    /// What the observer sees, on the scale of [`Camera::reference_as_exposed`].
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

    /// [`Camera::seen_by`] of the standard observer: X, Y, Z.
    pub(crate) fn seen_by_observer(&self, image: &OpticalImage) -> Result<Planes, CameraError> {
        self.seen_by(image, &xyz(&Observer::Cie1931.photon_weights(self.grid())?))
    }

    /// What a device of other sensitivities (per photon, 0 or more, in any unit; zero beyond their wavelengths) would see in
    /// the place of this one: one plane for each, every pixel that is read, without noise, mosaic or saturation. The mean over
    /// the photodetector of ∫ sensitivity · irradiance, where irradiance is as before the lens: its transmittance is
    /// divided out, but where it passes less than 10⁻⁴.
    ///
    /// The unit is that of the sensitivities times photons s⁻¹ m⁻². Times [`Camera::exposure_scale`] it has the scale of
    /// a picture: what a learned pipeline is trained to make.
    ///
    /// # Errors
    /// When there is no sensitivity, one is negative, or all are zero; and as [`Sensor::expected_volts`].
    pub fn seen_by(&self, image: &OpticalImage, targets: &[Channel]) -> Result<Planes, CameraError> {
        let lens = self.optics.transmittance_on(self.grid())?;
        let before = |c: &Channel| {
            let mut passes = lens.values().iter();
            let on_grid = c.transmittance.resampled(self.grid(), Outside::Zero)?;
            let undone = on_grid.map(|_, v| match passes.next() {
                Some(&t) if t >= OPAQUE => v / t,
                _ => 0.0,
            });
            Ok(Channel { name: c.name.clone(), transmittance: undone })
        };
        let targets = targets.iter().map(before).collect::<Result<Vec<_>, CameraError>>()?;
        let largest = targets.iter().map(|c| c.transmittance.max()).fold(0.0, f64::max);
        let (mut volts, volts_per_unit) = self.volts_through(image, &targets, largest)?;
        let scale = (1.0 / volts_per_unit) as f32;
        volts.data_mut().iter_mut().for_each(|v| *v *= scale);
        Ok(volts)
    }

    /// The factor that brings what [`Camera::seen_by`] returns to the scale of a picture: with it, a perfect white diffuser
    /// that just saturates the camera's brightest channel reads 1 through `sensitivity` (ȳ for XYZ). All planes
    /// of one set of targets take one factor, so that they keep their proportions.
    ///
    /// For a target under another light than that of the capture, divide by ∫ sensitivity · target light and multiply by
    /// ∫ sensitivity · light, both lights as radiance of a white diffuser.
    ///
    /// # Errors
    /// When the light is dark to camera or sensitivity, grids differ, or the exposure is impossible.
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
        let seen = white(&sensitivity.resampled(self.grid(), Outside::Zero)?)?;
        for (what, response) in [("the camera", brightest), ("the target", seen)] {
            if response <= 0.0 {
                return Err(IspError::NoResponse { what }.into());
            }
        }
        let (sensor, pixel) = (&self.sensor, &self.sensor.pixel);
        let captures = match sensor.architecture {
            ColorArchitecture::FieldSequential => sensor.cfa.channels().len() as f64,
            ColorArchitecture::Mosaic | ColorArchitecture::Prism => 1.0,
        };
        let levels = sensor.raw_levels(exposure)?;
        let range_v = levels.white_v - levels.black_v;
        let per_electron = pixel.conversion_gain_v_per_e * exposure.analog_gain / range_v;
        let per_photon = pixel.photodetector_area_m2() * exposure.time_s / captures * per_electron;
        Ok(brightest * per_photon / seen)
    }

    /// Volts behind pixels of other sensitivities, of which `largest` is the largest value, and volts for a unit of
    /// ∫ sensitivity · irradiance.
    fn volts_through(
        &self,
        image: &OpticalImage,
        targets: &[Channel],
        largest: f64,
    ) -> Result<(Planes, f64), CameraError> {
        if largest <= 0.0 {
            return Err(IspError::NoResponse { what: "the target" }.into());
        }
        let scaled = |c: &Channel| Channel {
            name: c.name.clone(),
            transmittance: c.transmittance.scaled(1.0 / largest),
        };
        let channels: Vec<Channel> = targets.iter().map(scaled).collect();
        let cells = (0..targets.len()).map(|c| c.min(usize::from(u8::MAX)) as u8).collect();
        let sensor = Sensor {
            cfa: Cfa::new("observer", Mosaic::new(1, targets.len(), cells)?, channels)?,
            architecture: ColorArchitecture::Prism,
            quantum_efficiency: Spectrum::constant(self.grid(), 1.0),
            ir_cut: None,
            crosstalk: None,
            nonuniformity: NonUniformity::default(),
            ..self.sensor.clone()
        };
        // A well and a swing that nothing fills, so that the reference never clips.
        let pixel = Pixel {
            full_well_e: 1e12,
            voltage_swing_v: 1e3,
            conversion_gain_v_per_e: OBSERVER_V_PER_E,
            ..sensor.pixel
        };
        let sensor = Sensor { pixel, ..sensor };
        let volts_per_unit = OBSERVER_V_PER_E * pixel.photodetector_area_m2() / largest;
        Ok((sensor.expected_volts(image, &Exposure::new(1.0))?, volts_per_unit))
    }
}

fn xyz(weights: &[Spectrum; 3]) -> Vec<Channel> {
    let channel = |(name, w): (&str, &Spectrum)| Channel { name: name.into(), transmittance: w.clone() };
    ["X", "Y", "Z"].into_iter().zip(weights).map(channel).collect()
}
