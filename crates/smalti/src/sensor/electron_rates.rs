//! Photoelectrons per second of every pixel: light that is integrated over wavelength and photodetectors once, for captures in
//! several amounts of it.

use std::borrow::Cow;

use super::collect::Collector;
use super::pattern::Pattern;
use super::{PixelSpectra, Sensor, SensorError};
use crate::numeric::{Planes, Rect, require};
use crate::optics::OpticalImage;

/// Mean photoelectrons per second of every photodiode of a sensor's window, from light alone: after crosstalk, without saturation.
///
/// They depend on the optical image, the filters, the quantum efficiency, and the geometry of the pixels. Noise, well and converter
/// can vary between captures ([`Sensor::capture`]).
#[derive(Debug, Clone, PartialEq)]
pub struct ElectronRates {
    window: Rect,
    per_s: Planes,
    pattern: Option<Pattern>,
}

impl ElectronRates {
    /// The rates of an image on a sensor.
    ///
    /// # Errors
    /// When the sensor is invalid, or a curve does not cover the wavelengths of the image.
    pub fn new(sensor: &Sensor, image: &OpticalImage) -> Result<Self, SensorError> {
        sensor.validate()?;
        Ok(Self {
            window: sensor.unbinned().read_window(),
            per_s: sensor.electrons(image.into(), 1.0)?,
            pattern: None,
        })
    }

    /// The rates of photons that stand gathered on the pixels of a sensor.
    ///
    /// # Errors
    /// As [`ElectronRates::new`]; and when the photons are those of other pixels.
    pub fn of_pixels(sensor: &Sensor, pixels: &PixelSpectra) -> Result<Self, SensorError> {
        sensor.validate()?;
        Ok(Self {
            window: sensor.unbinned().read_window(),
            per_s: sensor.electrons(pixels.into(), 1.0)?,
            pattern: None,
        })
    }

    /// [`ElectronRates::of_all`] for one group.
    pub(crate) fn of_each<const N: usize>(
        sensors: [&Sensor; N],
        image: &OpticalImage,
    ) -> Result<[Self; N], SensorError> {
        Ok(Self::of_all(&[sensors], image)?.swap_remove(0))
    }

    /// The rates of an image on several sensors, in groups of `N`: those of [`ElectronRates::new`], but the image is read once, which
    /// takes longer than the products.
    ///
    /// # Errors
    /// As [`ElectronRates::new`].
    pub fn of_all<const N: usize>(
        sensors: &[[&Sensor; N]],
        image: &OpticalImage,
    ) -> Result<Vec<[Self; N]>, SensorError> {
        sensors.iter().flatten().try_for_each(|sensor| sensor.validate())?;
        // Equal sensors have equal rates, such as the observers behind cameras that differ in their mosaics alone.
        let mut distinct: Vec<&Sensor> = Vec::new();
        let mut place = |sensor| {
            distinct.iter().position(|known| *known == sensor).unwrap_or_else(|| {
                distinct.push(sensor);
                distinct.len() - 1
            })
        };
        let places: Vec<[usize; N]> = sensors.iter().map(|s| s.map(&mut place)).collect();
        let fine: Vec<Cow<'_, Sensor>> = distinct.into_iter().map(Sensor::unbinned).collect();
        let fine: Vec<&Sensor> = fine.iter().map(|s| &**s).collect();
        let rates = |c: &Collector<'_>| Self {
            window: c.sensor.read_window(),
            per_s: c.sensor.electrons_from(c, 1.0),
            pattern: None,
        };
        let rates: Vec<Self> = Collector::of_all(&fine, image)?.iter().map(rates).collect();
        Ok(places.into_iter().map(|places| places.map(|place| rates[place].clone())).collect())
    }

    /// The same rates with the random numbers behind the fixed pattern of a sensor, which captures of these rates by this sensor then need
    /// not draw again. The captures have the same bits. Rates of another window or of other planes get none.
    #[must_use]
    pub fn with_pattern_of(self, sensor: &Sensor) -> Self {
        let sensor = sensor.unbinned();
        let pattern = self.ensure_of(&sensor, 1.0).ok().and_then(|()| Pattern::new(&sensor));
        Self { pattern, ..self }
    }

    pub(super) fn pattern(&self) -> Option<&Pattern> {
        self.pattern.as_ref()
    }

    /// An error unless these are rates of the window of a sensor without binning, and the factor is one of light.
    pub(super) fn ensure_of(&self, sensor: &Sensor, factor: f64) -> Result<(), SensorError> {
        require(factor >= 0.0, "factor", factor, "0 or more, finite")?;
        let (window, gathered) = (sensor.read_window(), self.window);
        let same = window == gathered && sensor.sampling().planes() == self.per_s.count();
        if same { Ok(()) } else { Err(SensorError::OtherPixels { window, gathered }) }
    }

    /// The rates of a band of rows of a plane times a factor.
    pub(super) fn band(&self, plane: usize, first_row: usize, factor: f32, out: &mut [f32]) {
        let start = (plane * self.window.rows + first_row) * self.window.cols;
        for (o, rate) in out.iter_mut().zip(self.per_s.data().get(start..).unwrap_or(&[])) {
            *o = rate * factor;
        }
    }
}
