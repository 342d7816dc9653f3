//! From located samples to the response: supersampled profile, derivative, window, Fourier transform.

use std::f64::consts::PI;

use rustfft::{FftPlanner, num_complex::Complex};

use super::edge::{EdgeLine, Lines, hamming};
use super::options::{EdgeOrientation, EsfrOptions, FrequencyAxis};
use super::response::{EdgeSfr, first_crossing};
use crate::metrics::MetricError;

/// Bins per pixel.
const OVERSAMPLING: usize = 4;
/// Largest accepted gap between adjacent samples of the profile, pixels. Slopes of 1:1 and 1:2 leave gaps of 1 and 1/2 pixel,
/// which are too wide to interpolate; the gap of 1/3 at 1:3 is acceptable with bins of a quarter pixel.
const MAXIMUM_GAP_PX: f64 = 0.4;
/// Resolution of the measurement of gaps, divisions per pixel.
const GAP_DIVISIONS: usize = 20;
/// Largest angle of an edge to its axis. Near 45° the lines sample only a few distinct phases.
const MAXIMUM_ANGLE_DEG: f64 = 44.0;

pub(super) fn respond(
    lines: &Lines,
    fit: &EdgeLine,
    orientation: EdgeOrientation,
    options: &EsfrOptions,
) -> Result<EdgeSfr, MetricError> {
    let edge_angle_deg = fit.slope.atan().to_degrees();
    let shift_px = fit.slope.abs() * (lines.lines.len() - 1) as f64;
    if shift_px < 1.0 || edge_angle_deg.abs() > MAXIMUM_ANGLE_DEG {
        let expected = "at most 44°, and over its length a shift by one pixel or more";
        return Err(MetricError::EdgeAngle { angle_deg: edge_angle_deg, expected });
    }
    let (esf, edge_at) = profile(lines, fit, options.place_correction)?;
    let contrast = contrast(&esf);
    if contrast.is_nan() || contrast < options.minimum_contrast {
        return Err(MetricError::LowContrast { contrast, minimum: options.minimum_contrast });
    }
    let cosine = match options.frequency_axis {
        FrequencyAxis::EdgeNormal => fit.slope.atan().cos(),
        FrequencyAxis::PixelLines => 1.0,
    };
    let mut sfr = windowed_transform(&esf, edge_at, lines.width);
    let at_zero = sfr.first().copied().unwrap_or(0.0);
    if at_zero.is_nan() || at_zero <= 0.0 {
        return Err(MetricError::NoEdge("the profile has no net step"));
    }
    // One step of the transform of 4 · width quarter pixels is 1 / width cycles per pixel along the lines.
    let along_lines = |k: usize| k as f64 / lines.width as f64;
    for (k, v) in sfr.iter_mut().enumerate() {
        *v /= at_zero;
        if options.derivative_correction {
            *v *= derivative_correction(along_lines(k));
        }
    }
    let frequency_cy_per_px: Vec<f64> = (0..sfr.len()).map(|k| along_lines(k) / cosine).collect();
    // The Nyquist limit of the pixel grid applies along the lines, for either frequency axis.
    let above: f64 = sfr.iter().enumerate().filter(|(k, _)| along_lines(*k) >= 0.5).map(|(_, v)| v).sum();
    Ok(EdgeSfr {
        mtf50_cy_per_px: first_crossing(&frequency_cy_per_px, &sfr, 0.5),
        aliasing_percent: 100.0 * above / sfr.iter().sum::<f64>(),
        frequency_cy_per_px,
        sfr,
        orientation,
        edge_angle_deg,
        contrast,
        fit_residual_px: fit.residual_rms,
        esf,
        edge_at,
    })
}

/// The samples of one bin.
#[derive(Clone, Copy, Default)]
struct Bin {
    count: u32,
    sum: f64,
    /// Sum of their distances from the centre of the bin, in bins.
    offset_sum: f64,
}

/// The edge profile, means of the samples in bins of a quarter pixel over `width` pixels around the centre of the region, and the
/// position of the edge in it. Bins start at the first pixel of the first line, as in the software of the standard, because the
/// result for an aliased picture depends on their phase.
fn profile(lines: &Lines, fit: &EdgeLine, place_correction: bool) -> Result<(Vec<f64>, f64), MetricError> {
    let fine = OVERSAMPLING as f64;
    let count = OVERSAMPLING * lines.width;
    let first = (-0.5 * fine * fit.slope * (lines.lines.len() - 1) as f64).round();
    let mut bins = vec![Bin::default(); count];
    for (y, line) in lines.lines.iter().enumerate() {
        for &(x, v) in line {
            let place = (x - fit.slope * y as f64) * fine - first;
            // Bin k holds places above k − 1 up to k.
            let k = place.ceil();
            if let Some(bin) = bins.get_mut(if k < 0.0 { usize::MAX } else { k as usize }) {
                bin.count += 1;
                bin.sum += v;
                bin.offset_sum += place - (k - 0.5);
            }
        }
    }
    let gap_px = largest_gap_px(lines, fit);
    if gap_px > MAXIMUM_GAP_PX {
        let angle_deg = fit.slope.atan().to_degrees();
        return Err(MetricError::EdgeSampling { gap_px, maximum_px: MAXIMUM_GAP_PX, angle_deg });
    }
    let mut esf = fill(&bins);
    if place_correction {
        esf = at_bin_middles(&bins, &esf);
    }
    Ok((esf, fine * fit.intercept - first + 0.5))
}

/// The largest gap between samples within a quarter of the width from the edge, where the profile changes.
fn largest_gap_px(lines: &Lines, fit: &EdgeLine) -> f64 {
    let count = GAP_DIVISIONS * (lines.width / 2);
    let mut met = vec![false; count];
    for (y, line) in lines.lines.iter().enumerate() {
        for &(x, _) in line {
            let from_edge = x - fit.intercept - fit.slope * y as f64;
            let at = from_edge * GAP_DIVISIONS as f64 + count as f64 / 2.0;
            if let Some(slot) = met.get_mut(if at < 0.0 { usize::MAX } else { at as usize }) {
                *slot = true;
            }
        }
    }
    let longest = met.split(|m| *m).map(<[bool]>::len).max().unwrap_or(0);
    (longest + 1) as f64 / GAP_DIVISIONS as f64
}

/// Means of the bins; empty bins are interpolated linearly between filled ones, or take the nearest at the ends.
fn fill(bins: &[Bin]) -> Vec<f64> {
    let known: Vec<(usize, f64)> = bins
        .iter()
        .enumerate()
        .filter(|(_, b)| b.count > 0)
        .map(|(i, b)| (i, b.sum / f64::from(b.count)))
        .collect();
    let mut after = 0;
    (0..bins.len())
        .map(|i| {
            while known.get(after).is_some_and(|k| k.0 < i) {
                after += 1;
            }
            match (after.checked_sub(1).and_then(|b| known.get(b)), known.get(after)) {
                (_, Some(&(at, v))) if at == i => v,
                (Some(&(i0, v0)), Some(&(i1, v1))) => v0 + (v1 - v0) * (i - i0) as f64 / (i1 - i0) as f64,
                (Some(&(_, v)), None) | (None, Some(&(_, v))) => v,
                (None, None) => 0.0,
            }
        })
        .collect()
}

/// Corrects each mean from the mean position of its samples to the centre of the bin, along the local slope.
fn at_bin_middles(bins: &[Bin], means: &[f64]) -> Vec<f64> {
    let offset = |b: &Bin| if b.count > 0 { b.offset_sum / f64::from(b.count) } else { 0.0 };
    let mut moved = means.to_vec();
    for ((slot, m), b) in moved.iter_mut().skip(1).zip(means.windows(3)).zip(bins.windows(3)) {
        if let ([before, _, after], [left, here, right]) = (m, b) {
            // The mean positions of the outer two bins are at least one bin apart.
            *slot -= offset(here) * (after - before) / (2.0 + offset(right) - offset(left));
        }
    }
    moved
}

/// Michelson contrast of the outer eighths of the profile.
fn contrast(esf: &[f64]) -> f64 {
    let end = (esf.len() / 8).max(1);
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let (a, b) = (mean(&esf[..end]), mean(&esf[esf.len() - end..]));
    let sum = a.abs() + b.abs();
    if sum > 0.0 { (a - b).abs() / sum } else { 0.0 }
}

/// Modulus of the transform of the windowed derivative, from frequency 0 to 1 cycle per pixel along the lines.
fn windowed_transform(esf: &[f64], edge_at: f64, width: usize) -> Vec<f64> {
    let half = esf.len() as f64 / 2.0;
    let mut buffer = vec![Complex::new(0.0, 0.0); esf.len()];
    for (i, (slot, e)) in buffer.iter_mut().skip(1).zip(esf.windows(3)).enumerate() {
        if let [before, _, after] = *e {
            slot.re = (0.5 * (after - before) * hamming((i + 1) as f64 - edge_at, half)) as f32;
        }
    }
    FftPlanner::new().plan_fft_forward(buffer.len()).process(&mut buffer);
    buffer.iter().take(width + 1).map(|c| f64::from(c.norm())).collect()
}

/// The correction of the central difference over two quarter pixels at a frequency along the lines: x / sin x.
fn derivative_correction(cy_per_px: f64) -> f64 {
    let x = 2.0 * PI * cy_per_px / OVERSAMPLING as f64;
    if x > 0.0 { x / x.sin() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The central difference of a wave, which has a known derivative, is right once it is corrected.
    #[test]
    fn the_correction_undoes_the_central_difference() {
        for cy_per_px in [0.01, 0.1, 0.25, 0.5, 0.75, 1.0] {
            let step = 2.0 * std::f64::consts::PI * cy_per_px / 4.0;
            let wave = |n: f64| (step * n + 0.3).sin();
            for n in 0..8 {
                let n = f64::from(n);
                let difference = 0.5 * (wave(n + 1.0) - wave(n - 1.0));
                let derivative = step * (step * n + 0.3).cos();
                let corrected = difference * derivative_correction(cy_per_px);
                // Rounding of a difference of numbers near 1.
                assert!((corrected - derivative).abs() < 1e-14, "{cy_per_px}: {corrected} for {derivative}");
            }
        }
        assert_eq!(derivative_correction(0.0), 1.0);
    }
    /// Lines of an edge at slope 1:10, each with samples at the places that are kept. Together they sample its profile every tenth of a pixel.
    fn sampled(keep: impl Fn(f64) -> bool) -> f64 {
        let fit = EdgeLine { intercept: 19.02, slope: 0.1, residual_rms: 0.0 };
        let line = |y: usize| {
            let from_edge = |x: usize| x as f64 - fit.intercept - fit.slope * y as f64;
            (0..40).filter(|x| keep(from_edge(*x))).map(|x| (x as f64, 0.0)).collect()
        };
        largest_gap_px(&Lines { lines: (0..20).map(line).collect(), width: 40 }, &fit)
    }

    #[test]
    fn gaps_on_both_sides_of_the_edge_are_found() {
        // A division is a twentieth of a pixel.
        let near = |gap: f64, expected: f64| (gap - expected).abs() < 0.11;
        assert!(near(sampled(|_| true), 0.1));
        for middle in [-8.0, -3.0, 0.0, 3.0, 8.0] {
            for width in [0.5, 2.0] {
                let gap = sampled(|x| (x - middle).abs() > width / 2.0);
                assert!(near(gap, width), "{width} at {middle}: {gap}");
            }
        }
        // Farther than a quarter of the width from the edge, the profile is level.
        assert!(near(sampled(|x| x.abs() < 10.2), 0.1));
        assert!(sampled(|_| false) > 19.9);
    }

    #[test]
    fn empty_bins_of_a_straight_profile_lie_on_it() {
        let line = |i: usize| 3.0 + 0.5 * i as f64;
        let (filled, size) = ([2, 3, 7, 8, 13], 16);
        let bin = |i: usize| {
            let count = if filled.contains(&i) { 2 } else { 0 };
            Bin { count, sum: f64::from(count) * line(i), offset_sum: 0.0 }
        };
        let bins: Vec<Bin> = (0..size).map(bin).collect();
        for (i, v) in fill(&bins).into_iter().enumerate() {
            // Beyond the filled bins the profile is level. Rounding of a few terms.
            assert!((v - line(i.clamp(2, 13))).abs() < 1e-12, "{i}: {v}");
        }
    }
}
