//! Noise of the grey series of the ColorChecker, from one capture or several.

use super::chart::{GREYS, LUMINANCE, WHITE, patches};
use super::{CameraError, GreyScores, PatchScores};
use crate::color::Image;
use crate::metrics::luminance_noise::{LuminanceNoise, luminance_noise_of_captures};
use crate::metrics::visual_snr::visual_snr;
use crate::metrics::{MetricError, Rect, patch_means};
use crate::numeric::bootstrap::mean;
use crate::spectrum::{Observer, Spectrum};

/// Viewing resolution for visual noise, pixels per degree, as in [`ScoreSettings`](super::ScoreSettings).
const VIEWING_PX_PER_DEGREE: f64 = 60.0;

/// Number of captures of the ColorChecker over which comparisons and light gains average noise. Its patches are small: a light gain is
/// uncertain by a tenth of a stop with one capture and by half of that with four.
pub const COMPARED_NOISE_CAPTURES: u64 = 4;

/// The noise of the grey series, from white to black.
pub(super) struct GreyNoise {
    /// `100 · std(Y) / mean(Y)`.
    pub(super) luminance_noise_percent: PatchScores,
    /// Visual signal-to-noise ratio: reciprocal standard deviation in S-CIELAB.
    pub(super) visual_snr: GreyScores,
}

impl GreyNoise {
    /// Noise of captures of the chart under an illuminant (photons), rendered. Luminance noise is relative to the mean over all captures.
    ///
    /// The observer is assumed to be adapted to the picture: white has the chromaticity of the illuminant and the luminance of the
    /// white patch.
    pub(super) fn of_captures(captures: &[Image], light: &Spectrum) -> Result<Vec<Self>, CameraError> {
        let rects = patches();
        let planes: Vec<_> = captures.iter().map(Image::planes).collect();
        let luminance = luminance_noise_of_captures(&planes, LUMINANCE, &rects[GREYS])?;
        let white = Observer::Cie1931.xyz_from_photons(light)?;
        let of = |(noisy, luminance): (&Image, LuminanceNoise)| -> Result<Self, CameraError> {
            let white_y = patch_means(noisy.planes(), &rects[WHITE..=WHITE])?.concat()[LUMINANCE];
            let white = white.map(|v| v / white[LUMINANCE] * white_y);
            let visual = |rect: &Rect| visual_snr(noisy, *rect, white, VIEWING_PX_PER_DEGREE);
            let visual = rects[GREYS].iter().map(visual).collect::<Result<Vec<f64>, MetricError>>()?;
            Ok(Self {
                luminance_noise_percent: PatchScores::new(luminance.percent)?,
                visual_snr: GreyScores::new(visual)?,
            })
        };
        captures.iter().zip(luminance).map(of).collect()
    }

    /// The means over captures, of every patch and of the summaries.
    pub(super) fn mean(captures: &[Self]) -> Self {
        let of = |value: &dyn Fn(&Self) -> f64| mean(&captures.iter().map(value).collect::<Vec<_>>());
        let per_patch = |of_capture: &dyn Fn(&Self) -> &[f64]| -> Vec<f64> {
            let patches = captures.first().map_or(0, |c| of_capture(c).len());
            (0..patches).map(|i| of(&|c| of_capture(c)[i])).collect()
        };
        Self {
            luminance_noise_percent: PatchScores {
                mean: of(&|c| c.luminance_noise_percent.mean),
                per_patch: per_patch(&|c| &c.luminance_noise_percent.per_patch),
            },
            visual_snr: GreyScores {
                median: of(&|c| c.visual_snr.median),
                per_patch: per_patch(&|c| &c.visual_snr.per_patch),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(luminance: [f64; 2], visual: [f64; 3]) -> GreyNoise {
        GreyNoise {
            luminance_noise_percent: PatchScores::new(luminance.to_vec()).unwrap(),
            visual_snr: GreyScores::new(visual.to_vec()).unwrap(),
        }
    }

    /// The summary of visual SNR is the mean of the medians, as in a light gain, and not the median of the means.
    #[test]
    fn the_noise_of_captures_is_their_mean() {
        let both = GreyNoise::mean(&[noise([1.0, 2.0], [1.0, 5.0, 6.0]), noise([3.0, 6.0], [9.0, 1.0, 2.0])]);
        assert_eq!(both.luminance_noise_percent.per_patch, [2.0, 4.0]);
        assert_eq!(both.luminance_noise_percent.mean, 3.0);
        assert_eq!(both.visual_snr.per_patch, [5.0, 3.0, 4.0]);
        assert_eq!(both.visual_snr.median, 3.5);
    }
}
