//! The circular zone plate: every frequency in every direction, which makes aliasing visible.

use std::f64::consts::{PI, TAU};

use super::compose::{check_size, grey};
use super::quadrature::mean_over_pixel;
use super::{Scene, SceneError, Setting};
use crate::numeric::require;

/// A circular zone plate with the reflectance (1 + contrast · cos φ) / 2. The phase φ is proportional to the
/// square of the distance from the centre. Every pixel contains the mean over its area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZonePlate {
    /// Rows and columns, 1 to 32768.
    pub size: usize,
    /// Frequency at the middle of each side, cycles per pixel of the scene, more than 0 and at most 2. In the
    /// corners it is √2 times as high.
    pub frequency: f64,
    /// Contrast (Michelson), more than 0 and at most 1.
    pub contrast: f64,
}

impl Default for ZonePlate {
    /// 384 × 384 pixels, up to half a cycle per pixel, as in ISETCam.
    fn default() -> Self {
        Self { size: 384, frequency: 0.5, contrast: 1.0 }
    }
}

/// Draws the zone plate.
///
/// # Errors
/// When a parameter or the setting is out of range.
pub fn zone_plate(plate: &ZonePlate, setting: &Setting) -> Result<Scene, SceneError> {
    let ZonePlate { size, frequency, contrast } = *plate;
    require((1..=32768).contains(&size), "size", size as f64, "1 to 32768")?;
    require(frequency > 0.0 && frequency <= 2.0, "frequency", frequency, "more than 0 and at most 2")?;
    require(contrast > 0.0 && contrast <= 1.0, "contrast", contrast, "more than 0 and at most 1")?;
    check_size(size, size, setting.grid)?;
    let middle = size as f64 / 2.0;
    // The frequency in cycles per pixel is the derivative of φ / 2π, so φ = π f r² / middle.
    let phase = |x: f64| PI * frequency * (x - middle).powi(2) / middle;
    // exp(iφ) is the product of a function of x and one of y, and so is its mean over a pixel.
    let cos: Vec<f64> = (0..size).map(|i| mean_over_pixel(i, |x| phase(x).cos())).collect();
    let sin: Vec<f64> = (0..size).map(|i| mean_over_pixel(i, |x| phase(x).sin())).collect();
    let mut reflectance = Vec::with_capacity(size * size);
    for r in 0..size {
        let wave = cos.iter().zip(&sin).map(|(c, s)| c * cos[r] - s * sin[r]);
        reflectance.extend(wave.map(|w| (0.5 * (1.0 + contrast * w)).max(0.0) as f32));
    }
    grey("zone-plate", size, size, &reflectance, setting)
}

/// The zone plate of ISETCam's `sceneCreate('zonePlate')`, for comparisons: 384 × 384 point samples of 1 +
/// cos(π r² / 384), clipped to 10⁻⁴–1. The clipping flattens the bright half of every ring and adds
/// harmonics. ISETCam illuminates it with equal photons at every wavelength.
///
/// # Errors
/// When the setting is out of range.
pub fn zone_plate_isetcam(setting: &Setting) -> Result<Scene, SceneError> {
    const SIZE: usize = 384;
    check_size(SIZE, SIZE, setting.grid)?;
    let square = |i: usize| (i as f64 + 0.5 - SIZE as f64 / 2.0).powi(2);
    let value = |i: usize| {
        let phase = TAU / 2.0 / SIZE as f64 * (square(i / SIZE) + square(i % SIZE));
        (1.0 + phase.cos()).clamp(1e-4, 1.0) as f32
    };
    let reflectance: Vec<f32> = (0..SIZE * SIZE).map(value).collect();
    grey("zone-plate", SIZE, SIZE, &reflectance, setting)
}
