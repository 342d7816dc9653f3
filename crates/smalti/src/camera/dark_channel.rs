//! Whether a camera measures colour under a light.

use super::{Camera, CameraError};
use crate::isp::BLIND;
use crate::sensor::Channel;
use crate::spectrum::{Observer, Spectrum};

/// With fewer channels that see the light, colour has fewer than three dimensions.
const COLORS: usize = 3;
/// X, Y and Z of a light that colour differences are defined for are at least this share of the largest of them. It is 0.36 for a
/// tungsten lamp and 0.0015 for the line of sodium at 589 nm.
const LEAST_WHITE: f64 = 2e-3;

/// A channel that sees almost nothing of a light.
#[derive(Debug, Clone, PartialEq)]
pub struct DarkChannel {
    /// Its name.
    pub channel: String,
    /// Its response to white, percent of that of the brightest channel: less than 0.1.
    pub percent: f64,
}

impl Camera {
    /// The channels that see almost nothing of a light (photons): their response to white is less than a thousandth of that of the brightest
    /// one.
    ///
    /// # Errors
    /// When a curve does not cover the wavelengths of the light.
    pub fn dark_channels(&self, light: &Spectrum) -> Result<Vec<DarkChannel>, CameraError> {
        let camera = self.on_grid(light.grid())?;
        let white = |c: &Spectrum| Ok(c.times(light)?.integral());
        let whites = camera.responsivities()?.iter().map(white).collect::<Result<Vec<f64>, CameraError>>()?;
        let brightest = whites.iter().copied().fold(0.0, f64::max);
        let of = |(channel, white): (&Channel, f64)| {
            let percent = if brightest > 0.0 { 100.0 * white / brightest } else { 0.0 };
            (brightest <= 0.0 || white < BLIND * brightest)
                .then(|| DarkChannel { channel: channel.name.clone(), percent })
        };
        Ok(camera.sensor.cfa.channels().iter().zip(whites).filter_map(of).collect())
    }

    /// Checks that colours can be measured under a light (photons): no channel is without light, unless three others see it; and the
    /// light has a white in all three of X, Y and Z. Cameras of fewer channels are not expected to measure colour.
    ///
    /// # Errors
    /// [`CameraError::DarkChannel`] and [`CameraError::NarrowLight`]; and when a curve does not cover the wavelengths of the light.
    pub fn ensure_measures_color(&self, light: &Spectrum) -> Result<(), CameraError> {
        let dark = self.dark_channels(light)?;
        let seeing = self.sensor.cfa.channels().len() - dark.len();
        let darkest = dark.into_iter().min_by(|a, b| a.percent.total_cmp(&b.percent));
        if let Some(DarkChannel { channel, percent }) = darkest.filter(|_| seeing < COLORS) {
            return Err(CameraError::DarkChannel { channel, percent });
        }
        let xyz = Observer::Cie1931.white(light)?;
        let largest = xyz.iter().copied().fold(0.0, f64::max);
        let least = xyz.iter().zip(["X", "Y", "Z"]).min_by(|a, b| a.0.total_cmp(b.0));
        match least.filter(|(v, _)| **v < LEAST_WHITE * largest) {
            Some((v, primary)) => Err(CameraError::NarrowLight { primary, percent: 100.0 * v / largest }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::CameraDescription;
    use crate::camera::description::PatternDescription;
    use crate::sensor::Filter;
    use crate::spectrum::{Illuminant, WavelengthGrid};

    fn camera(pattern: &str, dark: &[&str]) -> Camera {
        let mut d = CameraDescription::default();
        d.sensor.cfa.pattern = PatternDescription::Name(pattern.into());
        for letter in dark {
            d.sensor.cfa.filters.insert((*letter).into(), Filter::Flat(0.0));
        }
        Camera::new(d, WavelengthGrid::VISIBLE).unwrap()
    }

    #[test]
    fn a_channel_without_light_is_an_error_that_names_it() {
        let d65 = Illuminant::D65.photons(WavelengthGrid::VISIBLE).unwrap();
        for pattern in ["bayer", "rgbw", "mono", "rccc"] {
            assert_eq!(camera(pattern, &[]).ensure_measures_color(&d65), Ok(()), "{pattern}");
        }
        let dark = camera("bayer", &["B"]).ensure_measures_color(&d65);
        assert_eq!(dark, Err(CameraError::DarkChannel { channel: "B".into(), percent: 0.0 }));
        // W − R − G remains blue.
        assert_eq!(camera("rgbw", &["B"]).ensure_measures_color(&d65), Ok(()));
        let blind = camera("rgbw", &["B"]).dark_channels(&d65).unwrap();
        assert_eq!(blind, [DarkChannel { channel: "B".into(), percent: 0.0 }]);
        assert_eq!(camera("rgbw", &[]).dark_channels(&d65), Ok(Vec::new()));
    }

    /// A light with nothing below 590 nm. A tungsten lamp is no such light.
    #[test]
    fn a_light_without_blue_is_an_error() {
        let nm: Vec<f64> = WavelengthGrid::VISIBLE.wavelengths_nm().collect();
        let red = Spectrum::new(
            WavelengthGrid::VISIBLE,
            nm.iter().map(|nm| ((nm - 590.0) / 10.0).clamp(0.0, 1.0)).collect(),
        );
        let narrow = camera("rgbw", &[]).ensure_measures_color(&red.unwrap());
        assert!(matches!(narrow, Err(CameraError::NarrowLight { primary: "Z", .. })), "{narrow:?}");
        let lamp = Illuminant::A.photons(WavelengthGrid::VISIBLE).unwrap();
        assert_eq!(camera("bayer", &[]).ensure_measures_color(&lamp), Ok(()));
    }
}
