//! Photoelectrons per second of every pixel: light that is integrated over wavelength and photodetectors once, for captures in
//! several amounts of it.

use std::borrow::Cow;
use std::sync::Arc;

use rayon::prelude::*;

use super::collect::{Collector, LightBand};
use super::pattern::Pattern;
use super::pixel_spectra::FilteredLight;
use super::{PixelSpectra, Sensor, SensorError};
use crate::numeric::simd::dispatch;
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
    pattern: Option<Arc<Pattern>>,
}

impl ElectronRates {
    /// The rates of an image on a sensor.
    ///
    /// # Errors
    /// When the sensor is invalid, a curve does not cover the wavelengths of the image, or a row of pixels times wavelengths exceeds
    /// [`MAX_SAMPLES`](super::MAX_SAMPLES).
    pub fn new(sensor: &Sensor, image: &OpticalImage) -> Result<Self, SensorError> {
        let [rates] = Self::of_each([sensor], image)?;
        Ok(rates)
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

    /// The rates of an image on several sensors, in groups of `N`: those of [`ElectronRates::new`], but the image is read once for
    /// all sensors whose pixels collect the same light, because reading takes longer than the products.
    ///
    /// If the samples of the image are as close as the pixels or closer, the light is first collected by the photodetectors and then
    /// integrated over wavelength, which is less work. Otherwise the order is that of [`Sensor::capture`]. Both give the same rates up to
    /// rounding.
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
        let dark = |sensor: &&Sensor| {
            let window = sensor.read_window();
            let per_s = Planes::zeros(window.rows, window.cols, sensor.sampling().planes());
            Self { window, per_s, pattern: None }
        };
        let mut rates: Vec<Self> = fine.iter().map(dark).collect();
        let lit = fine.iter().copied().zip(rates.iter_mut().map(|r| &mut r.per_s));
        let (finer, mut left): (Vec<_>, Vec<_>) = lit.partition(|(sensor, _)| sensor.is_finer_than(image));
        let (sensors, planes): (Vec<_>, Vec<_>) = finer.into_iter().unzip();
        for (collector, planes) in Collector::of_all(&sensors, image)?.iter().zip(planes) {
            *planes = collector.sensor.electrons_from(collector, 1.0);
        }
        while let Some(&(first, _)) = left.first() {
            let (alike, others): (Vec<_>, Vec<_>) =
                left.into_iter().partition(|(sensor, _)| sensor.collects_as(first));
            let (sensors, planes): (Vec<_>, Vec<_>) = alike.into_iter().unzip();
            through_pixels(&sensors, image, planes)?;
            left = others;
        }
        Ok(places.into_iter().map(|places| places.map(|place| rates[place].clone())).collect())
    }

    /// The same rates with the random numbers behind the fixed pattern of a sensor, which captures of these rates by this sensor then need
    /// not draw again. The captures have the same bits. Rates of another window or of other planes get none.
    #[must_use]
    pub fn with_pattern_of(self, sensor: &Sensor) -> Self {
        self.with_kept_pattern(sensor, &mut FixedPattern::default())
    }

    /// [`with_pattern_of`](Self::with_pattern_of) with the pattern of earlier rates, if it is the same.
    #[must_use]
    pub(crate) fn with_kept_pattern(self, sensor: &Sensor, drawn: &mut FixedPattern) -> Self {
        let sensor = sensor.unbinned();
        if self.ensure_of(&sensor, 1.0).is_err() {
            return Self { pattern: None, ..self };
        }
        if !drawn.0.as_ref().is_some_and(|pattern| pattern.suits(&sensor)) {
            drawn.0 = Pattern::new(&sensor).map(Arc::new);
        }
        Self { pattern: drawn.0.clone(), ..self }
    }

    pub(super) fn pattern(&self) -> Option<&Pattern> {
        self.pattern.as_deref()
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

/// The random numbers behind the fixed pattern of a sensor, kept for the next captures.
#[derive(Debug, Clone, Default)]
pub(crate) struct FixedPattern(Option<Arc<Pattern>>);

/// The most rows that are collected at a time, and the most samples of their spectra, which stay in the cache until all sensors have
/// integrated them; but at least one row.
const BAND_ROWS: usize = 32;
const BAND_SAMPLES: usize = 1 << 19;

/// The rates of an image on sensors whose photodetectors are alike, one plane for each of its samples, collected before they are
/// integrated over wavelength.
fn through_pixels(
    sensors: &[&Sensor],
    image: &OpticalImage,
    planes: Vec<&mut Planes>,
) -> Result<(), SensorError> {
    let Some(window) = sensors.first().map(|s| s.read_window()) else { return Ok(()) };
    let samples_per_row = window.cols.saturating_mul(image.irradiance().grid().len());
    let band_rows = (BAND_SAMPLES / samples_per_row).clamp(1, BAND_ROWS);
    // For each band, the rows of each plane of each sensor.
    let mut bands: Vec<Vec<Vec<&mut [f32]>>> = Vec::new();
    bands.resize_with(window.rows.div_ceil(band_rows), Vec::new);
    for planes in planes {
        bands.iter_mut().for_each(|band| band.push(Vec::with_capacity(planes.count())));
        for plane in planes.planes_mut() {
            for (band, rows) in bands.iter_mut().zip(plane.chunks_mut(band_rows * window.cols)) {
                if let Some(of) = band.last_mut() {
                    of.push(rows);
                }
            }
        }
    }
    bands.into_par_iter().enumerate().try_for_each(|(i, band)| {
        let row = i * band_rows;
        let part = Rect { row: window.row + row, rows: band_rows.min(window.rows - row), ..window };
        let part_of = |sensor: &Sensor| Sensor { window: Some(part), ..sensor.clone() };
        let light = PixelSpectra::on_one_thread(&part_of(sensors[0]), image)?;
        for (sensor, planes) in sensors.iter().zip(band) {
            let sensor = &part_of(sensor);
            let rates = &FilteredLight::new(sensor, &light)?;
            for (plane, out) in planes.into_iter().enumerate() {
                dispatch(LightBand { sensor, rates, plane, first_row: 0, out });
            }
        }
        Ok(())
    })
}
