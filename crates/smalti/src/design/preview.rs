//! What it takes to draw what designs make of a scene where no simulator is, as in a page: the light on the pixels as few
//! pictures that have a spectrum each, and the numbers of the read-out.

use rayon::prelude::*;
use serde::Serialize;

use crate::camera::{Camera, CameraError, ExposureTime, Setup};
use crate::numeric::Planes;
use crate::numeric::dense::{Eigen, dot};
use crate::sensor::{AutoExposure, ColorArchitecture, PixelSpectra, SensorError};
use crate::spectrum::Spectrum;

/// Rows whose moments are summed at a time, and the sums added in order: the same bits for any number of threads.
const BAND: usize = 16;
/// Products of two wavelengths that the moments are summed of, about a second's worth; of more, from pixels evenly spread.
const MOST_PRODUCTS: usize = 500_000_000;

/// The light of a scene on the pixels of a camera, in the photoelectrons that it would make without colour filters: its
/// principal components, of which few hold all that filters can tell apart, since the spectra of surfaces are smooth.
///
/// A channel of transmittance T has Σₖ planeₖ · ∫ T · spectrumₖ dλ photoelectrons per second.
#[derive(Debug, Clone)]
pub struct PixelLight {
    planes: Planes,
    spectra: Vec<Spectrum>,
    lost: f64,
}

impl PixelLight {
    /// The first `most` components of a scene before a camera.
    ///
    /// # Errors
    /// When the light on the pixels cannot be gathered.
    pub fn new(setup: &Setup, most: usize) -> Result<Self, CameraError> {
        let Setup { camera, image, .. } = setup;
        let light = PixelSpectra::new(&camera.sensor, image)?;
        let (window, grid) = (light.window(), light.grid());
        let bare = camera.sensor.bare_responsivity_on(grid)?;
        // Wavelength by wavelength, every `step`-th pixel of a row; which one it begins with differs from row to row.
        let electrons = |row: usize, step: usize| -> Vec<Vec<f64>> {
            let line = |(i, r): (usize, &f64)| {
                let photons = light.line(window.row + row, i).iter().skip(row * 5 % step).step_by(step);
                photons.map(|&v| f64::from(v) * r).collect()
            };
            bare.values().iter().enumerate().map(line).collect()
        };
        let n = grid.len();
        let step =
            (window.rows * window.cols).saturating_mul(n * n).div_ceil(MOST_PRODUCTS).clamp(1, window.cols);
        let bands: Vec<Vec<f64>> = (0..window.rows.div_ceil(BAND))
            .into_par_iter()
            .map(|band| {
                let mut moments = vec![0.0; n * n];
                for row in band * BAND..((band + 1) * BAND).min(window.rows) {
                    let lines = electrons(row, step);
                    for (i, a) in lines.iter().enumerate() {
                        for (j, b) in lines.iter().enumerate().skip(i) {
                            moments[i * n + j] += dot(a, b);
                        }
                    }
                }
                moments
            })
            .collect();
        let mut moments = vec![0.0; n * n];
        for band in bands {
            moments.iter_mut().zip(band).for_each(|(sum, v)| *sum += v);
        }
        for i in 0..n {
            (0..i).for_each(|j| moments[i * n + j] = moments[j * n + i]);
        }
        let eigen = Eigen::of(&moments, n).ok_or(SensorError::NoLight)?;
        // They ascend.
        let found: Vec<&[f64]> = eigen.above(0.0).map(|(_, vector)| vector).collect();
        let vectors: Vec<&[f64]> = found.into_iter().rev().take(most).collect();
        let mut planes = Planes::zeros(window.rows, window.cols, vectors.len());
        for (k, vector) in vectors.iter().enumerate() {
            planes.plane_mut(k).par_chunks_mut(window.cols).enumerate().for_each(|(row, out)| {
                let lines = electrons(row, 1);
                for (col, o) in out.iter_mut().enumerate() {
                    *o = vector.iter().zip(&lines).map(|(v, line)| v * line[col]).sum::<f64>() as f32;
                }
            });
        }
        let of_row = |row: usize| electrons(row, 1).iter().map(|line| dot(line, line)).sum::<f64>();
        let all: f64 = (0..window.rows).into_par_iter().map(of_row).collect::<Vec<_>>().iter().sum();
        let kept: f64 = planes.data().iter().map(|v| f64::from(*v).powi(2)).sum();
        Ok(Self {
            lost: (1.0 - kept / all.max(f64::MIN_POSITIVE)).max(0.0).sqrt(),
            spectra: vectors.iter().map(|v| Spectrum::new(grid, v.to_vec())).collect::<Result<_, _>>()?,
            planes,
        })
    }

    /// The pictures: photoelectrons s⁻¹ nm⁻¹, the strongest first.
    #[must_use]
    pub fn planes(&self) -> &Planes {
        &self.planes
    }

    /// The spectra, one for each picture, orthonormal as vectors.
    #[must_use]
    pub fn spectra(&self) -> &[Spectrum] {
        &self.spectra
    }

    /// What the components leave out, as a share of the light: root of the mean square over pixels and wavelengths.
    #[must_use]
    pub fn lost(&self) -> f64 {
        self.lost
    }

    /// The most light on any pixel, as the root of its squares over wavelength: the scale of what a filter lets through.
    #[must_use]
    pub fn brightest(&self) -> f64 {
        let squares = |i: usize| self.planes.planes().map(|p| f64::from(p[i]).powi(2)).sum::<f64>();
        (0..self.planes.plane_len()).map(squares).fold(0.0, f64::max).sqrt()
    }
}

/// What the exposure rule of a camera looks at in a scene before it, photoelectrons s⁻¹ nm⁻¹ of a pixel without colour filter; `None`
/// where the time is stated or the rule looks at all pixels.
///
/// # Errors
/// When the rule is impossible or the sensor sees nothing of the scene.
pub fn metered_electrons(setup: &Setup) -> Result<Option<Spectrum>, CameraError> {
    let sensor = &setup.camera.sensor;
    let Some(irradiance) = setup.camera.metered(&setup.image)? else { return Ok(None) };
    let bare = sensor.bare_responsivity_on(irradiance.grid())?;
    Ok(Some(irradiance.times(&bare)?.scaled(sensor.pixel.photodetector_area_m2())))
}

/// How a camera reads out photoelectrons, as [`Sensor::capture`](crate::sensor::Sensor::capture) does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReadoutModel {
    /// Integration time, s, where it is stated.
    pub time_s: Option<f64>,
    /// Else the volts before gain that what the exposure rule looks at is to reach.
    pub metered_v: Option<f64>,
    /// Conversion gain, V per electron.
    pub gain_v_per_e: f64,
    /// Electrons that the well holds.
    pub full_well_e: f64,
    /// The voltage swing.
    pub swing_v: f64,
    /// Gain between pixel and converter.
    pub analog_gain: f64,
    /// Added before the gain.
    pub analog_offset_v: f64,
    /// Step of the converter; 0 without one.
    pub step_v: f64,
    /// Volts at the converter of its first and last number; what is beyond is clipped. Of no use without one.
    pub range_v: [f64; 2],
    /// Volts at the converter of samples that are black.
    pub black_v: f64,
    /// Volts at the converter of samples that are saturated.
    pub white_v: f64,
    /// Dark current, electrons per second.
    pub dark_e_per_s: f64,
    /// Standard deviation of the read noise.
    pub read_noise_v: f64,
    /// That of gains, of offsets of pixels, of rows, of columns.
    pub prnu: f64,
    /// See [`prnu`](Self::prnu).
    pub dsnu_v: f64,
    /// See [`prnu`](Self::prnu).
    pub row_noise_v: f64,
    /// See [`prnu`](Self::prnu).
    pub column_noise_v: f64,
    /// Share of pixels that see nothing.
    pub dead: f64,
    /// Share of pixels with much dark current.
    pub hot: f64,
    /// Their dark current, electrons per second.
    pub hot_e_per_s: f64,
    /// What a pixel gives to those around it.
    pub crosstalk: Option<[[f64; 3]; 3]>,
    /// Whether every pixel sees every channel; otherwise that of the mosaic.
    pub all_channels: bool,
    /// Whether channels share the exposure time.
    pub in_turn: bool,
}

impl ReadoutModel {
    /// That of a camera.
    ///
    /// # Errors
    /// When its exposure or temperature are impossible.
    pub fn new(camera: &Camera) -> Result<Self, CameraError> {
        let (sensor, exposure) = (&camera.sensor, camera.gain_and_offset());
        let (pixel, non, levels) = (&sensor.pixel, &sensor.nonuniformity, sensor.raw_levels(&exposure)?);
        let (time_s, share) = match camera.exposure_time() {
            ExposureTime::Fixed(time_s) => (Some(time_s), None),
            ExposureTime::Auto(AutoExposure::Specular { fraction }) => (None, Some(fraction)),
            ExposureTime::Auto(
                AutoExposure::Mean { target } | AutoExposure::LuminancePercentile { target, .. },
            ) => (None, Some(target)),
        };
        let saturation_v = sensor.saturation_v(&exposure) / exposure.analog_gain - exposure.analog_offset_v;
        let warmth = sensor.dark_temperature.map_or(Ok(1.0), |t| t.factor())?;
        let electrons = |v_per_s: f64| v_per_s * warmth / pixel.conversion_gain_v_per_e;
        let step_v = if sensor.adc.bits == 0 { 0.0 } else { pixel.voltage_swing_v / sensor.adc.levels() };
        Ok(Self {
            time_s,
            metered_v: share.map(|share| share * saturation_v),
            gain_v_per_e: pixel.conversion_gain_v_per_e,
            full_well_e: pixel.full_well_e,
            swing_v: pixel.voltage_swing_v,
            analog_gain: exposure.analog_gain,
            analog_offset_v: exposure.analog_offset_v,
            step_v,
            range_v: [0.0, sensor.adc.levels() - 1.0].map(|n| (n - sensor.adc.black_level_dn) * step_v),
            black_v: levels.black_v,
            white_v: levels.white_v,
            dark_e_per_s: electrons(pixel.dark_voltage_v_per_s),
            read_noise_v: pixel.read_noise_v,
            prnu: non.prnu_fraction,
            dsnu_v: non.dsnu_v,
            row_noise_v: non.row_noise_v,
            column_noise_v: non.column_noise_v,
            dead: non.dead_pixel_fraction,
            hot: non.hot_pixel_fraction,
            hot_e_per_s: electrons(non.hot_pixel_dark_voltage_v_per_s),
            crosstalk: sensor.crosstalk,
            all_channels: sensor.architecture != ColorArchitecture::Mosaic,
            in_turn: sensor.architecture == ColorArchitecture::FieldSequential,
        })
    }
}
