//! Blur, gain and shift are no aliasing; folded frequencies and false colours are.
#![allow(missing_docs, clippy::unwrap_used)]

use std::f64::consts::PI;

use smalti::metrics::MetricError;
use smalti::metrics::aliasing::{Aliasing, aliasing};
use smalti::numeric::{Planes, philox::Stream};

const SIZE: usize = 192;
const WEIGHTS: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// A neutral zone plate whose frequency rises from 0 in the middle to `top` cycles per pixel at the middle of a side,
/// and fades out before half a cycle per pixel in the corners. `transfer` gives gain and phase at a frequency.
fn zone_plate(top: f64, transfer: impl Fn(f64, usize) -> (f64, f64)) -> Planes {
    let middle = (SIZE as f64 - 1.0) / 2.0;
    let value = |i: usize| {
        let (plane, i) = (i / (SIZE * SIZE), i % (SIZE * SIZE));
        let (y, x) = ((i / SIZE) as f64 - middle, (i % SIZE) as f64 - middle);
        let r = y.hypot(x);
        let f = top * r / middle;
        let (gain, phase) = transfer(f, plane);
        let fade = ((0.48 - f) / 0.06).clamp(0.0, 1.0);
        (0.5 + 0.4 * gain * fade * (PI * top * r * r / middle + phase).cos()) as f32
    };
    Planes::new(SIZE, SIZE, 3, (0..3 * SIZE * SIZE).map(value).collect()).unwrap()
}

fn reference() -> Planes {
    zone_plate(0.45, |_, _| (1.0, 0.0))
}

fn score(picture: &Planes, reference: &Planes) -> Aliasing {
    aliasing(picture, reference, &WEIGHTS).unwrap()
}

fn changed(p: &Planes, f: impl Fn(usize, usize, usize, f32) -> f32) -> Planes {
    let n = p.plane_len();
    let value = |(i, v): (usize, &f32)| f(i / n, i % n / SIZE, i % SIZE, *v);
    Planes::new(p.rows(), p.cols(), p.count(), p.data().iter().enumerate().map(value).collect()).unwrap()
}

#[test]
fn a_linear_transfer_is_no_aliasing() {
    let r = reference();
    let same = score(&r, &r);
    assert!(same.total_percent < 1e-8, "{}", same.total_percent);
    let scaled = score(&changed(&r, |p, _, _, v| (1.0 + p as f32) * 0.3 * v + 0.1), &r);
    assert!(scaled.total_percent < 1e-8, "{}", scaled.total_percent);
    // Each plane its own blur, and a shift of 0.3 pixels along the radius.
    let blurred = zone_plate(0.45, |f, p| ((-2.0 * (PI * (0.6 + 0.2 * p as f64) * f).powi(2)).exp(), 0.0));
    let blurred = score(&blurred, &r);
    let gain = 0.8;
    let shifted = score(&zone_plate(0.45, |f, _| (gain, 2.0 * PI * 0.3 * f)), &r);
    eprintln!("blurred {} %, shifted {} %", blurred.total_percent, shifted.total_percent);
    // A tenth of a percent of the energy of the reference, of which the picture has the square of its gain.
    assert!(blurred.total_percent < 0.1 && shifted.total_percent < 0.1 / (gain * gain));
}

/// A pattern that the reference does not have counts with its share of the energy, in the part it belongs to.
#[test]
fn an_added_pattern_counts_with_its_energy() {
    let r = reference();
    let variance = |p: &Planes| {
        let d = p.plane(0).unwrap();
        let mean = d.iter().map(|&v| f64::from(v)).sum::<f64>() / d.len() as f64;
        d.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / d.len() as f64
    };
    let mut s = Stream::new(9, 0, 0);
    let noise: Vec<f32> = (0..SIZE * SIZE).map(|_| 0.1 * (s.uniform() as f32 - 0.5)).collect();
    let energy = 0.01 / 12.0;
    let expected = 100.0 * energy / (energy + variance(&r));
    let grey = score(&changed(&r, |_, y, x, v| v + noise[y * SIZE + x]), &r);
    assert!((grey.luminance_percent / expected - 1.0).abs() < 0.03, "{} {expected}", grey.luminance_percent);
    assert!(grey.color_percent < 1e-6 * expected);
    // Red up and blue down such that luminance stays.
    let sign = [1.0, 0.0, -(WEIGHTS[0] / WEIGHTS[2]) as f32];
    let colored = score(&changed(&r, |p, y, x, v| v + sign[p] * noise[y * SIZE + x]), &r);
    let weight = WEIGHTS[0] + WEIGHTS[2] * (WEIGHTS[0] / WEIGHTS[2]).powi(2);
    assert!(colored.luminance_percent < 1e-6 * expected);
    let expected = 100.0 * weight * energy / (weight * energy + variance(&r));
    assert!((colored.color_percent / expected - 1.0).abs() < 0.03, "{} {expected}", colored.color_percent);
    assert_eq!(colored.total_percent, colored.luminance_percent + colored.color_percent);
}

/// False colour of many times the contrast of the reference is nearly all of the picture, and never more than all of it.
#[test]
fn aliasing_is_a_share() {
    let r = reference();
    let mut s = Stream::new(4, 0, 0);
    let noise: Vec<f32> = (0..SIZE * SIZE).map(|_| s.uniform() as f32 - 0.5).collect();
    let mut last = 0.0;
    for gain in [0.1, 1.0, 10.0, 1000.0] {
        let wild = changed(&r, |p, y, x, v| v + gain * (p as f32 - 1.0) * noise[y * SIZE + x]);
        let total = score(&wild, &r).total_percent;
        assert!(total > last && total <= 100.0, "{gain}: {total} after {last}");
        last = total;
    }
    assert!(last > 99.9, "{last}");
    // A picture without structure has none that is false.
    assert_eq!(score(&changed(&r, |_, _, _, _| 0.25), &r).total_percent, 0.0);
}

/// Bilinear demosaicking of a Bayer mosaic of a neutral picture, written out plainly.
fn bilinear(r: &Planes) -> Planes {
    let seen = |y: usize, x: usize| match (y % 2, x % 2) {
        (0, 0) => 0,
        (1, 1) => 2,
        _ => 1,
    };
    changed(r, |plane, y, x, _| {
        let (mut sum, mut weight) = (0.0, 0.0);
        for (dy, wy) in [1.0, 2.0, 1.0].into_iter().enumerate() {
            for (dx, wx) in [1.0, 2.0, 1.0].into_iter().enumerate() {
                let (y, x) = ((y + dy).wrapping_sub(1), (x + dx).wrapping_sub(1));
                if y < SIZE && x < SIZE && seen(y, x) == plane {
                    sum += wy * wx * r.plane(plane).unwrap()[y * SIZE + x];
                    weight += wy * wx;
                }
            }
        }
        sum / weight
    })
}

#[test]
fn a_mosaic_shows_false_colour_and_its_picture() {
    let r = reference();
    let s = score(&bilinear(&r), &r);
    eprintln!("bilinear Bayer: luminance {} %, colour {} %", s.luminance_percent, s.color_percent);
    assert!(s.color_percent > 5.0 && s.luminance_percent > 0.5);
    // The picture of the aliasing is quiet in the middle, where frequencies are low.
    let energy = |side: usize| {
        let from = (SIZE - side) / 2;
        let pixels = (from..from + side).flat_map(|y| (from..from + side).map(move |x| (y, x)));
        pixels.map(|(y, x)| s.difference.plane(0).unwrap()[y * SIZE + x].powi(2)).sum::<f32>()
            / (side * side) as f32
    };
    assert!(energy(16) < 0.01 * energy(SIZE), "{} {}", energy(16), energy(SIZE));
    // Frequencies well below the limit of red and blue fold by what bilinear interpolation lets through alone.
    let low = zone_plate(0.1, |_, _| (1.0, 0.0));
    let quiet = score(&bilinear(&low), &low);
    eprintln!("at low frequencies: {} %", quiet.total_percent);
    assert!(quiet.total_percent < 0.02 * s.total_percent);
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let r = reference();
    let fails = |p: &Planes, r: &Planes, w: &[f64]| aliasing(p, r, w).unwrap_err();
    assert!(matches!(fails(&Planes::zeros(SIZE, SIZE, 1), &r, &WEIGHTS), MetricError::Size { .. }));
    assert!(matches!(fails(&r, &r, &[1.0]), MetricError::Count { .. }));
    assert!(matches!(fails(&r, &r, &[1.0, -1.0, 1.0]), MetricError::Parameter { .. }));
    assert!(matches!(fails(&r, &r, &[0.0; 3]), MetricError::Parameter { .. }));
    let flat = Planes::zeros(SIZE, SIZE, 3);
    assert!(matches!(fails(&r, &flat, &WEIGHTS), MetricError::Undefined { .. }));
    let small = Planes::zeros(15, 40, 3);
    assert!(matches!(fails(&small, &small, &WEIGHTS), MetricError::TooFew { .. }));
    let mut hole = r.clone();
    hole.data_mut()[7] = f32::NAN;
    assert!(matches!(fails(&hole, &r, &WEIGHTS), MetricError::NotFinite { index: 7, .. }));
}
