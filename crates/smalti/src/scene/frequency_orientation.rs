//! Gratings of several frequencies and orientations (ISETCam: eight of each).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::compose::{check_size, grey};
use super::{PatternSampling, Scene, SceneError, Setting};
use crate::numeric::require;

/// Square blocks with one sinusoidal grating each. The frequency increases from left to right; the
/// orientation changes from horizontal bars at the top to vertical bars at the bottom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrequencyOrientation {
    /// Rows and columns of a block in pixels, 2 to 4096.
    pub block_px: usize,
    /// Columns of blocks; column `j` (from 1) has `j` cycles per block. 1 to 64.
    pub frequencies: usize,
    /// Rows of blocks, with orientations evenly spaced over 0–90°. 1 to 64.
    pub angles: usize,
    /// Contrast (Michelson), more than 0 and at most 1.
    pub contrast: f64,
    /// `Isetcam`: point samples, clipped to at least 10⁻⁴. `Area`: the mean over each pixel.
    pub sampling: PatternSampling,
}

/// Draws the gratings: reflectance (1 + contrast · sin 2πj(x sin α + y cos α)) / 2, where x and y run from 0
/// at the first pixel of a block to 1 at its end. ISETCam illuminates it with equal photons at every
/// wavelength.
///
/// # Errors
/// When a parameter or the setting is out of range.
pub fn frequency_orientation(target: &FrequencyOrientation, setting: &Setting) -> Result<Scene, SceneError> {
    let FrequencyOrientation { block_px, frequencies, angles, contrast, sampling } = *target;
    require((2..=4096).contains(&block_px), "block_px", block_px as f64, "2 to 4096")?;
    require((1..=64).contains(&frequencies), "frequencies", frequencies as f64, "1 to 64")?;
    require((1..=64).contains(&angles), "angles", angles as f64, "1 to 64")?;
    require(contrast > 0.0 && contrast <= 1.0, "contrast", contrast, "more than 0 and at most 1")?;
    let (rows, cols) = (angles * block_px, frequencies * block_px);
    check_size(rows, cols, setting.grid)?;
    let block = block_px as f64;
    let angle = |i: usize| if angles > 1 { FRAC_PI_2 * i as f64 / (angles - 1) as f64 } else { 0.0 };
    // The mean of a sinusoid over a pixel is its value at the centre times one sinc per direction.
    let sinc = |f: f64| if f == 0.0 { 1.0 } else { (PI * f).sin() / (PI * f) };
    let (offset, least) = match sampling {
        PatternSampling::Isetcam => (0.0, 1e-4),
        PatternSampling::Area => (0.5, 0.0),
    };
    let mut reflectance = Vec::with_capacity(rows * cols);
    for row in 0..rows {
        let (s, c) = angle(row / block_px).sin_cos();
        let y = ((row % block_px) as f64 + offset) / block;
        for col in 0..cols {
            let cycles = (col / block_px + 1) as f64;
            let x = ((col % block_px) as f64 + offset) / block;
            let kept = match sampling {
                PatternSampling::Isetcam => 1.0,
                PatternSampling::Area => sinc(cycles * s / block) * sinc(cycles * c / block),
            };
            let wave = kept * (TAU * cycles * (s * x + c * y)).sin();
            reflectance.push((0.5 * (1.0 + contrast * wave)).max(least) as f32);
        }
    }
    grey("frequency-orientation", rows, cols, &reflectance, setting)
}
