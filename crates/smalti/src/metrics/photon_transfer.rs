//! Photon transfer: the characteristics of a sensor from flat frames, following EMVA 1288 ([emva1288], release 4.0 Linear).
//!
//! The variance of a photon signal equals its mean. The slope of temporal variance over mean, both in digital numbers, is
//! therefore the system gain, which converts all other quantities to electrons.
//!
//! [emva1288]: https://www.emva.org/standards-technology/emva-1288/

use super::MetricError;
use super::dynamic_range::{DynamicRange, dynamic_range};
use super::error::{at_least, finite, not_negative};

/// Fraction of saturation up to which the gain is fitted.
const GAIN_FIT_TOP: f64 = 0.7;
/// Range of linearity, as fractions of saturation.
const LINEAR_RANGE: std::ops::RangeInclusive<f64> = 0.05..=0.95;
/// Variance in squared converter steps below which quantisation hides the dark noise. Its upper limit is then
/// √(0.24 − 1/12) = 0.4 steps.
const QUANTISATION_LIMIT: f64 = 0.24;

/// Two flat frames and two dark frames at one exposure, each the samples of one channel in the same order.
#[derive(Debug, Clone, Copy)]
pub struct FlatPair<'a> {
    /// Exposure, in any unit that is proportional to the number of photons.
    pub exposure: f64,
    /// Uniformly lit, in digital numbers.
    pub bright: [&'a [f32]; 2],
    /// Without light, at the same integration time.
    pub dark: [&'a [f32]; 2],
}

/// Frames for the fixed pattern, at least two of each kind (400 in the standard).
#[derive(Debug, Clone, Copy)]
pub struct FrameStacks<'a> {
    /// Uniformly lit to about half of saturation.
    pub bright: &'a [&'a [f32]],
    /// Without light, at the same integration time.
    pub dark: &'a [&'a [f32]],
}

/// The characteristics of a sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotonTransfer {
    /// System gain, digital numbers per electron.
    pub gain_dn_per_e: f64,
    /// Temporal noise in the dark, without quantisation noise, electrons; for short integration it is the read noise.
    pub dark_noise_e: f64,
    /// Whether quantisation hides the dark noise, so that `dark_noise_e` is an upper limit.
    pub dark_noise_is_limit: bool,
    /// Saturation capacity, electrons: the signal at the largest temporal variance, above which clipping reduces the variance. Its
    /// resolution is one step of the exposure series, and it lies a few times the shot noise below the full well.
    pub saturation_e: f64,
    /// The largest signal in the brightest frames, electrons: the full well, or an earlier clipping level. `None` when the series
    /// does not reach it, that is, the variance of the brightest frames is not below half of its maximum.
    pub full_well_e: Option<f64>,
    /// The largest signal-to-noise ratio, `√saturation_e`, in decibels.
    pub snr_max_db: f64,
    /// The dynamic range.
    pub dynamic_range: DynamicRange,
    /// Mean absolute deviation from a straight line between 5 and 95 % of saturation, percent.
    pub linearity_error_percent: f64,
    /// Photoresponse non-uniformity (PRNU1288), percent of the signal; `None` without stacks.
    pub prnu_percent: Option<f64>,
    /// Dark signal non-uniformity (DSNU1288), electrons; `None` without stacks.
    pub dsnu_e: Option<f64>,
    /// The photon transfer curve: one point per exposure, ascending.
    pub curve: Vec<TransferPoint>,
}

impl PhotonTransfer {
    /// Volts at the pixel per electron, for a converter of `volts_per_dn` (after division by the analog gain).
    #[must_use]
    pub fn conversion_gain_v_per_e(&self, volts_per_dn: f64) -> f64 {
        self.gain_dn_per_e * volts_per_dn
    }
}

/// One point of the photon transfer curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransferPoint {
    /// Exposure as given.
    pub exposure: f64,
    /// Mean above the dark mean, digital numbers.
    pub signal_dn: f64,
    /// Temporal variance, digital numbers squared.
    pub variance_dn2: f64,
    /// Temporal variance in the dark, digital numbers squared.
    pub dark_variance_dn2: f64,
}

/// Evaluates a series of exposures from near dark to beyond saturation (50 even steps in the standard), and stacks of frames for
/// the fixed pattern.
///
/// `step_dn` is the step of the converter in the unit of the samples: 1 for digital numbers, 0 for volts.
///
/// # Errors
/// When there are fewer than 4 exposures or 3 within the fitted range, frames are of different size or have fewer than 2
/// values, a stack has fewer than 2 frames, a value is not finite or `step_dn` negative, or the variance does not grow
/// with the signal.
pub fn photon_transfer(
    levels: &[FlatPair<'_>],
    stacks: Option<&FrameStacks<'_>>,
    step_dn: f64,
) -> Result<PhotonTransfer, MetricError> {
    not_negative("step_dn", step_dn)?;
    let curve = curve(levels)?;
    let saturated = saturation(&curve)?;
    let signal_top = saturated.signal_dn;

    let fitted: Vec<&TransferPoint> = curve
        .iter()
        .filter(|p| p.exposure <= saturated.exposure && p.signal_dn <= GAIN_FIT_TOP * signal_top)
        .collect();
    at_least("exposures below 70 % of saturation", 3, fitted.len())?;
    // Both lines pass through the dark point, which has neither signal nor shot noise.
    let gain = slope(fitted.iter().map(|p| (p.signal_dn, p.variance_dn2 - p.dark_variance_dn2)));
    let responsivity = slope(fitted.iter().map(|p| (p.exposure, p.signal_dn)));
    if !(gain > 0.0 && responsivity > 0.0) {
        let reason = "the variance does not grow with the signal, or the signal not with the exposure";
        return Err(MetricError::Undefined { quantity: "the system gain", reason });
    }

    let dark_variance = curve[0].dark_variance_dn2;
    let step_variance = step_dn * step_dn / 12.0;
    let dark_noise_is_limit = step_dn > 0.0 && dark_variance < QUANTISATION_LIMIT * step_dn * step_dn;
    let dark_noise_e = if dark_noise_is_limit {
        0.4 * step_dn / gain
    } else {
        (dark_variance - step_variance).max(0.0).sqrt() / gain
    };
    let saturation_e = responsivity * saturated.exposure / gain;
    let clipped = curve.last().filter(|p| p.variance_dn2 < 0.5 * saturated.variance_dn2);
    let fixed_pattern = stacks.map(fixed_pattern).transpose()?;
    Ok(PhotonTransfer {
        gain_dn_per_e: gain,
        dark_noise_e,
        dark_noise_is_limit,
        saturation_e,
        full_well_e: clipped.map(|p| p.signal_dn / gain),
        snr_max_db: 10.0 * saturation_e.log10(),
        dynamic_range: dynamic_range(saturation_e, dark_noise_e, step_dn / gain)?,
        linearity_error_percent: linearity_error_percent(&curve, saturated)?,
        prnu_percent: fixed_pattern.map(|f| f.prnu_percent),
        dsnu_e: fixed_pattern.map(|f| f.dsnu_dn / gain),
        curve,
    })
}

/// Means and temporal variances of all pairs, in ascending order of exposure.
fn curve(levels: &[FlatPair<'_>]) -> Result<Vec<TransferPoint>, MetricError> {
    at_least("exposures", 4, levels.len())?;
    let size = levels[0].bright[0].len();
    let point = |level: &FlatPair<'_>| {
        let exposure = level.exposure;
        not_negative("exposure", exposure)?;
        let (mean, variance_dn2) = pair_statistics(level.bright, size)?;
        let (dark_mean, dark_variance_dn2) = pair_statistics(level.dark, size)?;
        Ok(TransferPoint { exposure, signal_dn: mean - dark_mean, variance_dn2, dark_variance_dn2 })
    };
    let mut points: Vec<TransferPoint> = levels.iter().map(point).collect::<Result<_, MetricError>>()?;
    points.sort_by(|a, b| a.exposure.total_cmp(&b.exposure));
    Ok(points)
}

/// Mean and temporal variance of two frames. Their difference cancels the fixed pattern. Its mean, a drift of the light between
/// the frames, is subtracted.
fn pair_statistics([a, b]: [&[f32]; 2], size: usize) -> Result<(f64, f64), MetricError> {
    check_frame(a, size)?;
    check_frame(b, size)?;
    let n = size as f64;
    let pairs = || a.iter().zip(b).map(|(&a, &b)| (f64::from(a), f64::from(b)));
    let (sum, drift) = pairs().fold((0.0, 0.0), |s, (a, b)| (s.0 + a + b, s.1 + a - b));
    let drift = drift / n;
    let squares: f64 = pairs().map(|(a, b)| (a - b - drift).powi(2)).sum();
    Ok((sum / (2.0 * n), squares / (2.0 * (n - 1.0))))
}

fn check_frame(frame: &[f32], size: usize) -> Result<(), MetricError> {
    if frame.len() != size {
        return Err(MetricError::Count { what: "values in a frame", expected: size, got: frame.len() });
    }
    at_least("values in a frame", 2, size)?;
    finite("a frame", frame.iter().copied())
}

/// The point of largest temporal variance.
fn saturation(curve: &[TransferPoint]) -> Result<TransferPoint, MetricError> {
    let largest = curve.iter().copied().reduce(|a, b| if b.variance_dn2 > a.variance_dn2 { b } else { a });
    let (quantity, reason) = ("saturation", "the frame of largest variance is not above the dark");
    largest.filter(|p| p.signal_dn > 0.0).ok_or(MetricError::Undefined { quantity, reason })
}

/// Slope of the least-squares line through the origin.
fn slope(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (xx, xy) = points.fold((0.0, 0.0), |s, (x, y)| (s.0 + x * x, s.1 + x * y));
    xy / xx
}

/// Mean absolute deviation from the line of least relative squared error.
fn linearity_error_percent(curve: &[TransferPoint], saturated: TransferPoint) -> Result<f64, MetricError> {
    let within = |p: &&TransferPoint| {
        p.exposure <= saturated.exposure && LINEAR_RANGE.contains(&(p.signal_dn / saturated.signal_dn))
    };
    let points: Vec<(f64, f64)> = curve.iter().filter(within).map(|p| (p.exposure, p.signal_dn)).collect();
    at_least("exposures within 5–95 % of saturation", 3, points.len())?;
    let weighted = |f: fn(f64, f64) -> f64| points.iter().map(|&(x, y)| f(x, y) / (y * y)).sum::<f64>();
    let (w, wx, wy) = (weighted(|_, _| 1.0), weighted(|x, _| x), weighted(|_, y| y));
    let (wxx, wxy) = (weighted(|x, _| x * x), weighted(|x, y| x * y));
    let determinant = w * wxx - wx * wx;
    let (offset, rise) = ((wxx * wy - wx * wxy) / determinant, (w * wxy - wx * wy) / determinant);
    let deviation = |&(x, y): &(f64, f64)| ((y - offset - rise * x) / (offset + rise * x)).abs();
    let mean = points.iter().map(deviation).sum::<f64>() / points.len() as f64;
    if mean.is_finite() {
        Ok(100.0 * mean)
    } else {
        Err(MetricError::Undefined { quantity: "linearity", reason: "all exposures are equal" })
    }
}

#[derive(Clone, Copy)]
struct FixedPattern {
    prnu_percent: f64,
    dsnu_dn: f64,
}

fn fixed_pattern(stacks: &FrameStacks<'_>) -> Result<FixedPattern, MetricError> {
    let size = stacks.bright.first().map_or(0, |f| f.len());
    let (bright_mean, bright_variance) = spatial_statistics(stacks.bright, size)?;
    let (dark_mean, dark_variance) = spatial_statistics(stacks.dark, size)?;
    let signal = bright_mean - dark_mean;
    if signal <= 0.0 {
        let reason = "the lit stack is not brighter than the dark one";
        return Err(MetricError::Undefined { quantity: "photoresponse non-uniformity", reason });
    }
    // The variance of a weak pattern can be negative after subtracting the temporal noise.
    let root = |variance: f64| variance.max(0.0).sqrt();
    Ok(FixedPattern {
        prnu_percent: 100.0 * root(bright_variance - dark_variance) / signal,
        dsnu_dn: root(dark_variance),
    })
}

/// Mean of a stack, and the spatial variance of the pixel means without the contribution of temporal noise.
fn spatial_statistics(frames: &[&[f32]], size: usize) -> Result<(f64, f64), MetricError> {
    at_least("frames in a stack", 2, frames.len())?;
    for frame in frames {
        check_frame(frame, size)?;
    }
    let (count, n) = (frames.len() as f64, size as f64);
    let (mut means, mut temporal) = (Vec::with_capacity(size), 0.0);
    for i in 0..size {
        let values = || frames.iter().filter_map(|f| f.get(i)).map(|&v| f64::from(v));
        let mean = values().sum::<f64>() / count;
        temporal += values().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
        means.push(mean);
    }
    let mean = means.iter().sum::<f64>() / n;
    let spatial = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
    Ok((mean, spatial - temporal / n / count))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two frames of a mean and a temporal variance.
    fn pair(mean: f64, variance: f64) -> [Vec<f32>; 2] {
        let half = variance.sqrt() / 2.0;
        [half, -half].map(|d| vec![(mean + d) as f32, (mean - d) as f32])
    }

    /// The gain is that of the linear part, whatever happens near saturation and beyond it.
    #[test]
    fn the_gain_is_not_fitted_near_saturation_and_beyond() {
        const GAIN: f64 = 0.25;
        // Noise beyond that of photons above 70 % of saturation; frames that are dark again beyond saturation.
        let point = |x: i32| match x {
            ..=14 => (100.0 * f64::from(x), 1.0),
            15..=20 => (100.0 * f64::from(x), 1.5),
            _ => (900.0, 0.1),
        };
        let dark = pair(64.0, 4.0);
        let frames: Vec<(f64, [Vec<f32>; 2])> = (1..=24)
            .map(|x| (x, point(x)))
            .map(|(x, (signal, noise))| (f64::from(x), pair(64.0 + signal, 4.0 + GAIN * signal * noise)))
            .collect();
        let levels: Vec<FlatPair<'_>> = frames
            .iter()
            .map(|(exposure, [a, b])| FlatPair {
                exposure: *exposure,
                bright: [a, b],
                dark: [&dark[0], &dark[1]],
            })
            .collect();
        let found = photon_transfer(&levels, None, 0.0).unwrap();
        // Samples of single precision.
        assert!((found.gain_dn_per_e / GAIN - 1.0).abs() < 1e-4, "{}", found.gain_dn_per_e);
        assert!((found.saturation_e * GAIN / 2000.0 - 1.0).abs() < 1e-4, "{}", found.saturation_e);
        assert!((found.dark_noise_e * GAIN / 2.0 - 1.0).abs() < 1e-4, "{}", found.dark_noise_e);
        assert!(found.linearity_error_percent < 1e-3, "{}", found.linearity_error_percent);
    }

    #[test]
    fn a_straight_line_is_linear_whatever_its_offset() {
        for (offset, rise) in [(0.0, 10.0), (7.0, 10.0), (-3.0, 4.0), (0.3, 1e3)] {
            let point = |x: i32| TransferPoint {
                exposure: f64::from(x),
                signal_dn: offset + rise * f64::from(x),
                variance_dn2: 1.0,
                dark_variance_dn2: 0.0,
            };
            let curve: Vec<TransferPoint> = (1..=20).map(point).collect();
            let error = linearity_error_percent(&curve, point(20)).unwrap();
            // Rounding, far below a part in 10¹⁰.
            assert!(error < 1e-8, "{offset} {rise}: {error} %");
        }
    }
}
