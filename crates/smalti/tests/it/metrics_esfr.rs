//! Slanted edges whose response is known in closed form.
#![allow(missing_docs, clippy::unwrap_used)]

use crate::common;

use std::f64::consts::PI;

use common::normal;
use proptest::prelude::*;
use smalti::metrics::esfr::{
    EdgeOrientation, EdgeSfr, EsfrOptions, ISETCAM_LUMINANCE_WEIGHTS, Mtf50Reliability, NYQUIST_CY_PER_PX,
    edge_sfr, find_edge_region, picture_sfr, raw_channel_sfr,
};
use smalti::metrics::{MetricError, Rect};
use smalti::numeric::{Planes, philox::Stream};
use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling};

/// An edge through the middle of the image at `angle_deg` to the columns, blurred by a Gaussian of `sigma_px` at right
/// angles to itself, from 0.1 to 0.9, sampled at points.
fn edge(rows: usize, cols: usize, angle_deg: f64, sigma_px: f64) -> Planes {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    let value = |i: usize| {
        let y = (i / cols) as f64 - (rows as f64 - 1.0) / 2.0;
        let x = (i % cols) as f64 - (cols as f64 - 1.0) / 2.0 - 0.2;
        let distance = x * cos - y * sin;
        (0.5 + 0.4 * libm::erf(distance / sigma_px / 2f64.sqrt())) as f32
    };
    Planes::new(rows, cols, 1, (0..rows * cols).map(value).collect()).unwrap()
}

fn transposed(p: &Planes) -> Planes {
    let (rows, cols, data) = (p.rows(), p.cols(), p.plane(0).unwrap());
    Planes::new(cols, rows, 1, (0..rows * cols).map(|i| data[(i % rows) * cols + i / rows]).collect())
        .unwrap()
}

fn inverted(p: &Planes) -> Planes {
    Planes::new(p.rows(), p.cols(), 1, p.data().iter().map(|v| 1.0 - v).collect()).unwrap()
}

fn whole(p: &Planes) -> Rect {
    Rect::whole(p.rows(), p.cols())
}

fn measured(p: &Planes) -> EdgeSfr {
    edge_sfr(p, 0, whole(p), &EsfrOptions::default()).unwrap()
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) }
}

/// Largest departure, up to half a cycle per pixel, from the Gaussian's response times that of the averaging in bins of
/// a quarter pixel along the lines.
fn error(sfr: &EdgeSfr, sigma_px: f64) -> f64 {
    let bin_px = 0.25 * sfr.edge_angle_deg.to_radians().cos();
    let expected = |f: f64| (-2.0 * (PI * sigma_px * f).powi(2)).exp() * sinc(bin_px * f);
    let pairs = sfr.frequency_cy_per_px.iter().zip(&sfr.sfr);
    pairs.filter(|(f, _)| **f <= 0.5).map(|(f, m)| (m - expected(*f)).abs()).fold(0.0, f64::max)
}

#[test]
fn a_gaussian_edge_has_a_gaussian_response() {
    for sigma in [0.4, 0.7, 1.5] {
        for angle in [-31.0, -12.0, -5.0, 2.5, 5.0, 8.13, 15.0, 23.2, 35.0] {
            let p = edge(100, 80, angle, sigma);
            for (p, orientation) in [
                (p.clone(), EdgeOrientation::Vertical),
                (inverted(&p), EdgeOrientation::Vertical),
                (transposed(&p), EdgeOrientation::Horizontal),
            ] {
                let sfr = measured(&p);
                let e = error(&sfr, sigma);
                assert_eq!(sfr.orientation, orientation);
                // The centroid of a finely sampled step wanders by the aliasing of the pixels.
                assert!((sfr.edge_angle_deg - angle).abs() < 0.05, "{angle}°: found {}", sfr.edge_angle_deg);
                assert!(e < 0.01, "sigma {sigma}, {angle}°: error {e}");
            }
        }
    }
}

#[test]
fn mtf50_of_a_gaussian_edge() {
    let sfr = measured(&edge(100, 80, 5.0, 0.8));
    // The response is one half where 2π²σ²f² = ln 2.
    let expected = (2f64.ln() / 2.0).sqrt() / (PI * 0.8);
    let got = sfr.mtf50_cy_per_px.unwrap();
    assert!((got / expected - 1.0).abs() < 0.01, "{got}, expected {expected}");
    assert_eq!(sfr.frequency_at(0.5), Some(got));
    assert!((sfr.mtf(got).unwrap() - 0.5).abs() < 1e-12);
    assert_eq!(sfr.mtf(0.0), Some(1.0));
    assert!(sfr.mtf(-0.1).is_none() && sfr.mtf(f64::NAN).is_none() && sfr.mtf(1e9).is_none());
    assert!((sfr.mtf50_cy_per_mm(2e-6).unwrap() - got * 500.0).abs() < 1e-9);
    assert!((sfr.contrast - 0.8).abs() < 1e-6);
}

/// ISETCam's figures for an analytic edge of slope 1:7, its profile a function of the column alone, at 2.8 µm pitch
/// (`metric_mtf_edge.json`): MTF50 in cycles per millimetre and aliasing of green. ISETCam projects and bins the same
/// samples; what is left (2e-5) comes from where its transform is centred, to the nearest bin.
#[test]
fn isetcam_measures_the_same_edge_alike() {
    let (rows, cols) = (80, 60);
    let plane = |sigma: f64| {
        (0..rows * cols).map(move |i| {
            let edge = 30.0 + ((i / cols) as f64 + 1.0 - 40.5) / 7.0;
            let distance = (i % cols) as f64 + 1.0 - edge;
            (0.5 + 0.4 * libm::erf(distance / sigma / 2f64.sqrt())) as f32
        })
    };
    let data = [0.7, 0.9, 1.2].into_iter().flat_map(plane).collect();
    let rgb = Planes::new(rows, cols, 3, data).unwrap();
    let got = picture_sfr(&rgb, whole(&rgb), &ISETCAM_LUMINANCE_WEIGHTS, &EsfrOptions::isetcam()).unwrap();
    let all = got.channels.iter().chain([&got.luminance]);
    let expected = [93.34007192710861, 73.3816403702767, 55.513665683798095, 76.22938587100258];
    for (sfr, expected) in all.zip(expected) {
        let mtf50 = sfr.mtf50_cy_per_mm(2.8e-6).unwrap();
        assert!((mtf50 / expected - 1.0).abs() < 1e-3, "{mtf50}, expected {expected}");
    }
    assert!((got.channels[1].aliasing_percent / 7.377241907385966 - 1.0).abs() < 1e-2);
    // Across the edge and with the derivative corrected, the Gaussian itself: 0.9 columns are 0.9 · cos across.
    let normal = edge_sfr(&rgb, 1, whole(&rgb), &EsfrOptions::default()).unwrap();
    let sigma = 0.9 * (1f64 / 7.0).atan().cos();
    let expected = (2f64.ln() / 2.0).sqrt() / (PI * sigma);
    assert!((normal.mtf50_cy_per_px.unwrap() / expected - 1.0).abs() < 0.01);
}

/// Independent noise adds a floor to the response, but hardly moves MTF50.
#[test]
fn noise_biases_mtf50_little() {
    let clean = edge(100, 60, 7.0, 0.8);
    let truth = measured(&clean).mtf50_cy_per_px.unwrap();
    let noisy = |seed: u64| {
        let mut s = Stream::new(seed, 1, 0);
        let data = clean.data().iter().map(|v| v + 0.02 * normal(&mut s) as f32).collect();
        measured(&Planes::new(100, 60, 1, data).unwrap()).mtf50_cy_per_px.unwrap()
    };
    let n = 24;
    let all: Vec<f64> = (0..n).map(noisy).collect();
    let mean = all.iter().sum::<f64>() / n as f64;
    let std = (all.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1) as f64).sqrt();
    eprintln!("noise of 2.5 % of the step: MTF50 {mean} ± {std}, without {truth}");
    assert!((mean / truth - 1.0).abs() < 0.02, "mean {mean}, without noise {truth}");
    assert!(std / truth < 0.03);
}

/// Every channel of a mosaic, each on its own samples, shows the edge that all pixels saw.
#[test]
fn a_raw_channel_shows_the_same_response() {
    let p = edge(160, 100, 6.0, 0.8);
    let digital = p.data().iter().map(|v| (v * 60_000.0 + 500.0) as u16).collect::<Vec<_>>();
    let bayer = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
    let five = Mosaic::new(1, 5, vec![0, 1, 2, 3, 4]).unwrap();
    for mosaic in [bayer, five] {
        let names = (0..mosaic.channels()).map(|c| c.to_string()).collect();
        let channels = mosaic.channels();
        let samples = RawSamples::Digital(digital.clone());
        let raw = RawImage::new(160, 100, samples, Sampling::Mosaic(mosaic), names, 500.0, 65_000.0).unwrap();
        for channel in 0..channels {
            let sfr = raw_channel_sfr(&raw, channel, Rect::whole(160, 100), &EsfrOptions::default()).unwrap();
            assert!(error(&sfr, 0.8) < 0.01, "channel {channel} of {channels}: {}", error(&sfr, 0.8));
        }
    }
}

#[test]
fn a_three_sensor_raw_is_measured_plane_by_plane() {
    let (sharp, soft) = (edge(100, 80, 6.0, 0.6), edge(100, 80, 6.0, 1.2));
    let samples = RawSamples::Analog([sharp.data(), soft.data()].concat());
    let names = vec!["a".into(), "b".into()];
    let raw = RawImage::new(100, 80, samples, Sampling::Full { channels: 2 }, names, 0.0, 1.0).unwrap();
    for (channel, sigma) in [(0, 0.6), (1, 1.2)] {
        let sfr = raw_channel_sfr(&raw, channel, Rect::whole(100, 80), &EsfrOptions::default()).unwrap();
        assert!(error(&sfr, sigma) < 0.01);
    }
}

#[test]
fn luminance_is_the_weighted_sum() {
    let p = edge(100, 80, 6.0, 0.7);
    let data = [p.data(), p.data(), p.data()].concat();
    let rgb = Planes::new(100, 80, 3, data).unwrap();
    let got = picture_sfr(&rgb, whole(&p), &[0.25, 0.5, 0.25], &EsfrOptions::default()).unwrap();
    assert_eq!(got.channels.len(), 3);
    assert_eq!(got.luminance, measured(&p));
    let few = picture_sfr(&rgb, whole(&p), &[1.0], &EsfrOptions::default());
    assert!(matches!(few, Err(MetricError::Count { .. })));
}

#[test]
fn a_bad_edge_says_why() {
    let fails = |p: &Planes| edge_sfr(p, 0, whole(p), &EsfrOptions::default()).unwrap_err();
    assert!(matches!(fails(&edge(80, 60, 0.0, 0.7)), MetricError::EdgeAngle { .. }));
    assert!(matches!(
        fails(&edge(60, 60, 45.0, 0.7)),
        MetricError::EdgeAngle { .. } | MetricError::EdgeSampling { .. }
    ));
    // Slope 1:2 meets only two of the four places in a pixel.
    assert!(matches!(
        fails(&edge(60, 80, 0.5f64.atan().to_degrees(), 0.7)),
        MetricError::EdgeSampling { .. }
    ));
    assert!(matches!(fails(&Planes::zeros(60, 60, 1)), MetricError::NoEdge(_)));
    let mut flat = Stream::new(3, 0, 0);
    let noise = (0..3600).map(|_| 0.5 + 0.01 * normal(&mut flat) as f32).collect();
    let noise = fails(&Planes::new(60, 60, 1, noise).unwrap());
    eprintln!("{noise}");
    assert!(matches!(
        noise,
        MetricError::NoEdge(_) | MetricError::LowContrast { .. } | MetricError::EdgeAngle { .. }
    ));
    let faint = edge(80, 60, 5.0, 0.7).data().iter().map(|v| 10.0 + v).collect();
    assert!(matches!(fails(&Planes::new(80, 60, 1, faint).unwrap()), MetricError::LowContrast { .. }));
    let mut hole = edge(80, 60, 5.0, 0.7);
    hole.data_mut()[1000] = f32::NAN;
    assert!(matches!(fails(&hole), MetricError::NotFinite { index: 1000, .. }));
    assert!(matches!(fails(&edge(80, 7, 5.0, 0.7)), MetricError::TooFew { .. }));
    let p = edge(80, 60, 5.0, 0.7);
    let outside = Rect { row: 1, col: 0, rows: 80, cols: 60 };
    assert!(matches!(edge_sfr(&p, 0, outside, &EsfrOptions::default()), Err(MetricError::Region { .. })));
    assert!(matches!(edge_sfr(&p, 1, whole(&p), &EsfrOptions::default()), Err(MetricError::Plane { .. })));
    let options = EsfrOptions { minimum_contrast: f64::NAN, ..EsfrOptions::default() };
    assert!(matches!(edge_sfr(&p, 0, whole(&p), &options), Err(MetricError::Parameter { .. })));
}

#[test]
fn the_edge_is_found_in_the_picture() {
    for angle in [-23.2, -5.0, 3.0, 12.0, 23.2, 30.0] {
        let upright = edge(120, 150, angle, 0.7);
        for p in [transposed(&upright), upright] {
            let rect = find_edge_region(&p, 0).unwrap();
            let sfr = edge_sfr(&p, 0, rect, &EsfrOptions::default()).unwrap();
            assert!(error(&sfr, 0.7) < 0.01, "{angle}° in {rect:?}: {}", error(&sfr, 0.7));
        }
    }
    assert!(find_edge_region(&Planes::zeros(60, 60, 1), 0).is_err());
    assert!(find_edge_region(&Planes::zeros(20, 60, 1), 0).is_err());
    assert!(find_edge_region(&Planes::zeros(60, 60, 1), 1).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    /// Any region of any picture gives a response or an error, and a response is 1 at frequency 0 and finite.
    #[test]
    fn never_panics(
        rows in 1usize..40, cols in 1usize..40, row in 0usize..10, col in 0usize..10,
        rect_rows in 0usize..40, rect_cols in 0usize..40, seed in any::<u64>(), scale in -4.0f32..4.0,
    ) {
        let mut s = Stream::new(seed, 0, 0);
        let base = edge(rows, cols, 10.0, 0.7);
        let data = base.data().iter().map(|v| v * scale + s.uniform() as f32).collect();
        let p = Planes::new(rows, cols, 1, data).unwrap();
        let rect = Rect { row, col, rows: rect_rows, cols: rect_cols };
        if let Ok(sfr) = edge_sfr(&p, 0, rect, &EsfrOptions::default()) {
            prop_assert!(sfr.sfr[0] == 1.0 && sfr.sfr.iter().all(|v| v.is_finite()));
        }
        let _ = find_edge_region(&p, 0);
    }
}

fn reliability(sfr: &EdgeSfr) -> Option<Mtf50Reliability> {
    sfr.mtf50_reliability(NYQUIST_CY_PER_PX)
}

/// The MTF50 of a Gaussian is √(ln 2 / 2) / (π σ) = 0.187 / σ.
#[test]
fn an_mtf50_beyond_the_sampling_limit_is_no_resolution() {
    let soft = measured(&edge(100, 100, 5.0, 0.6));
    assert_eq!(reliability(&soft), Some(Mtf50Reliability::Reliable));
    let sharp = measured(&edge(100, 100, 5.0, 0.3));
    assert!(sharp.mtf50_cy_per_px.unwrap() > 0.5);
    assert_eq!(reliability(&sharp), Some(Mtf50Reliability::BeyondNyquist));
    // A channel on every second pixel has half the limit.
    assert_eq!(soft.mtf50_reliability(0.25), Some(Mtf50Reliability::BeyondNyquist));
}

/// A sharp edge on a wide slope: the response falls to the share of the sharp part and stays there.
#[test]
fn an_mtf50_on_a_plateau_is_marked() {
    let (rows, cols) = (120, 160);
    let both = |share: f32| {
        let (sharp, wide) = (edge(rows, cols, 5.0, 0.45), edge(rows, cols, 5.0, 6.0));
        let pixels = sharp.data().iter().zip(wide.data()).map(|(s, w)| share * s + (1.0 - share) * w);
        measured(&Planes::new(rows, cols, 1, pixels.collect()).unwrap())
    };
    let plateau = both(0.53);
    assert!(plateau.mtf50_cy_per_px.is_some_and(|f| f < 0.5), "{:?}", plateau.mtf50_cy_per_px);
    assert_eq!(reliability(&plateau), Some(Mtf50Reliability::Plateau));
    assert_eq!(reliability(&both(0.1)), Some(Mtf50Reliability::Reliable));
    assert_eq!(reliability(&both(0.95)), Some(Mtf50Reliability::Reliable));
    let mut never = both(0.95);
    never.mtf50_cy_per_px = None;
    assert_eq!(reliability(&never), None);
}

/// A response that rises above one half again has several frequencies of one half.
#[test]
fn a_response_that_rises_again_is_marked() {
    let frequency_cy_per_px: Vec<f64> = (0..=100).map(|k| f64::from(k) / 100.0).collect();
    let of = |response: &dyn Fn(f64) -> f64| EdgeSfr {
        sfr: frequency_cy_per_px.iter().map(|f| response(*f)).collect(),
        frequency_cy_per_px: frequency_cy_per_px.clone(),
        mtf50_cy_per_px: Some(0.2),
        ..measured(&edge(60, 60, 5.0, 0.6))
    };
    let falls = |f: f64| (1.0 - 2.5 * f).max(0.0);
    assert_eq!(reliability(&of(&falls)), Some(Mtf50Reliability::Reliable));
    let rises = |f: f64| if (0.3..0.4).contains(&f) { 0.6 } else { falls(f) };
    assert_eq!(reliability(&of(&rises)), Some(Mtf50Reliability::Plateau));
    // Beyond the limit, a rise is the transform's.
    let rises_later = |f: f64| if f > 0.6 { 0.6 } else { falls(f) };
    assert_eq!(reliability(&of(&rises_later)), Some(Mtf50Reliability::Reliable));
}

/// A region has the edge in its centre and through its short sides, and plateaus of 8 to 32 pixels beside it.
#[test]
fn a_region_holds_the_edge_and_its_plateaus() {
    for (rows, cols, angle) in [(60, 220, 4.0), (90, 300, -11.0), (60, 80, 3.0), (150, 90, 23.0)] {
        let upright = edge(rows, cols, angle, 0.7);
        let slope = angle.to_radians().tan();
        for p in [transposed(&upright), upright] {
            let r = find_edge_region(&p, 0).unwrap();
            let is_upright = p.cols() == cols;
            let (first, along, left, across) =
                if is_upright { (r.row, r.rows, r.col, r.cols) } else { (r.col, r.cols, r.row, r.rows) };
            let middle = first as f64 + along as f64 / 2.0 - 0.5 - (rows as f64 - 1.0) / 2.0;
            let edge_at = (cols as f64 - 1.0) / 2.0 + 0.2 + slope * middle;
            let centre = left as f64 + across as f64 / 2.0 - 0.5;
            assert!((centre - edge_at).abs() < 2.0, "{angle}°: {r:?}, edge at {edge_at}");
            let plateau = (across as f64 - slope.abs() * along as f64) / 2.0;
            // The corners of the region are whole pixels.
            assert!((7.0..33.0).contains(&plateau), "{angle}°: {r:?}, plateaus of {plateau}");
        }
    }
}
