//! Pictures laid onto raw images: known shifts are found, and learning from the aligned pair is as from the exact one.
#![allow(clippy::unwrap_used)]

use smalti::l3::{
    Axes, GOOD_RESIDUAL_PX, Pair, Pipeline, Registration, RegistrationError, Statistics, Training,
    peak_ratio_db,
};
use smalti::numeric::Planes;
use smalti::numeric::philox::Stream;
use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling};

use super::l3_training::{SOME, bayer, levels, names, solve};

/// Blobs of light in three colours, known at every place.
struct Scene(Vec<[f64; 6]>);

impl Scene {
    fn new(seed: u64, side: f64) -> Self {
        let mut s = Stream::new(seed, 7, 0);
        let mut blob = || {
            let reach = 1.2 + 8.0 * s.uniform().powi(2);
            let place = |u: f64| -20.0 + (side + 40.0) * u;
            [place(s.uniform()), place(s.uniform()), reach, s.uniform(), s.uniform(), s.uniform()]
        };
        Self((0..(side * side / 40.0) as usize).map(|_| blob()).collect())
    }

    /// Linear RGB at pixel centres `first + i · step` along each axis, 0 to 1.
    fn picture(&self, rows: usize, cols: usize, first: [f64; 2], step: f64) -> Planes {
        let mut data = vec![0.05f64; 3 * rows * cols];
        for &[y, x, reach, r, g, b] in &self.0 {
            let range = |at: f64, first: f64, n: usize| {
                let (low, high) = ((at - 4.0 * reach - first) / step, (at + 4.0 * reach - first) / step);
                (low.ceil().max(0.0) as usize).min(n)
                    ..(high.floor().max(-1.0) as isize + 1).clamp(0, n as isize) as usize
            };
            for i in range(y, first[0], rows) {
                for j in range(x, first[1], cols) {
                    let d = [first[0] + i as f64 * step - y, first[1] + j as f64 * step - x];
                    let v = (-(d[0] * d[0] + d[1] * d[1]) / (2.0 * reach * reach)).exp();
                    for (c, w) in [r, g, b].into_iter().enumerate() {
                        data[(c * rows + i) * cols + j] += 0.18 * w * v;
                    }
                }
            }
        }
        Planes::new(rows, cols, 3, data.into_iter().map(|v| (v as f32).min(1.0)).collect()).unwrap()
    }

    /// As a sensor with this mosaic sees it, with noise; channel 3 is white.
    fn raw(&self, side: usize, mosaic: &Mosaic, noise: f64, seed: u64) -> RawImage {
        let picture = self.picture(side, side, [0.0; 2], 1.0);
        let mut s = Stream::new(seed, 8, 0);
        let mut sample = |i: usize| {
            let of = |c: usize| f64::from(picture.plane(c).unwrap()[i]);
            let signal = match mosaic.channel_at(i / side, i % side) {
                3 => (of(0) + of(1) + of(2)) / 3.0,
                c => of(c),
            };
            // The sum of twelve is normal enough.
            let normal = (0..12).map(|_| s.uniform()).sum::<f64>() - 6.0;
            (64.0 + 3800.0 * (signal + noise * signal.sqrt() * normal)).round().clamp(0.0, 4095.0) as u16
        };
        let samples = (0..side * side).map(&mut sample).collect();
        let letters = ["R", "G", "B", "W"].iter().take(mosaic.channels()).map(|n| (*n).to_owned()).collect();
        let sampling = Sampling::Mosaic(mosaic.clone());
        RawImage::new(side, side, RawSamples::Digital(samples), sampling, letters, 64.0, 4095.0).unwrap()
    }
}

fn rgbw() -> Mosaic {
    Mosaic::new(2, 2, vec![0, 1, 3, 2]).unwrap()
}

/// What a camera's picture has of the scene: a tone curve, undone but for a remainder.
fn luminance(rgb: &Planes) -> Planes {
    let (r, g, b) = (rgb.plane(0).unwrap(), rgb.plane(1).unwrap(), rgb.plane(2).unwrap());
    let tone = |v: f32| v.powf(0.8);
    let y = (0..rgb.plane_len()).map(|i| tone(0.21 * r[i] + 0.72 * g[i] + 0.07 * b[i])).collect();
    Planes::new(rgb.rows(), rgb.cols(), 1, y).unwrap()
}

const SIDE: usize = 192;

#[test]
fn shifts_and_crops_are_found_to_a_tenth_of_a_pixel() {
    let scene = Scene::new(1, SIDE as f64);
    let mut worst: f64 = 0.0;
    for (mosaic, noise) in [(bayer(), 0.0), (bayer(), 0.05), (rgbw(), 0.05)] {
        let raw = scene.raw(SIDE, &mosaic, noise, 3);
        for (shift, rows, cols) in [
            ([0.0, 0.0], SIDE, SIDE),
            ([0.3, -0.7], SIDE, SIDE),
            ([-2.45, 5.13], SIDE, SIDE),
            ([21.5, 13.25], 150, 160),
        ] {
            let picture = luminance(&scene.picture(rows, cols, shift, 1.0));
            let found = Registration::best(&raw, &picture, &[1.0]).unwrap();
            let off = [found.row_shift_px - shift[0], found.col_shift_px - shift[1]];
            worst = worst.max(off[0].abs()).max(off[1].abs());
            assert!(found.correlation > 0.9, "{found:?}");
            // Nothing is distorted, and nothing said to be; quadrants of the crop are too small to tell.
            assert!(rows < SIDE || found.largest_residual_px() < GOOD_RESIDUAL_PX, "{found:?}");
            assert_eq!(found.is_identity(), shift == [0.0; 2], "{found:?}");
        }
    }
    assert!(worst < 0.1, "{worst} pixels off");
    println!("largest error {worst:.4} pixels");
}

#[test]
fn a_picture_of_other_scale_is_placed_by_its_best_scale() {
    let scene = Scene::new(2, SIDE as f64);
    let raw = scene.raw(SIDE, &bayer(), 0.03, 4);
    // Pixels twice as large; the first lies at 10.3 to 12.3 and 6.6 to 8.6.
    let picture = luminance(&scene.picture(80, 80, [10.3 + 0.5, 6.6 + 0.5], 2.0));
    let found = Registration::best(&raw, &picture, &[1.0, 2.0, 2.4]).unwrap();
    assert_eq!(found.scale, 2.0, "{found:?}");
    assert!((found.row_shift_px - 10.3).abs() < 0.1 && (found.col_shift_px - 6.6).abs() < 0.1, "{found:?}");
}

#[test]
fn distortion_shows_in_the_quadrants() {
    let scene = Scene::new(3, SIDE as f64);
    let raw = scene.raw(SIDE, &bayer(), 0.03, 5);
    // Magnified by one percent about the centre.
    let (step, middle) = (1.0 / 1.01, (SIDE as f64 - 1.0) / 2.0);
    let first = middle - middle * step;
    let picture = luminance(&scene.picture(SIDE, SIDE, [first, first], step));
    let found = Registration::best(&raw, &picture, &[1.0]).unwrap();
    let [upper_left, _, _, lower_right] = found.residuals_px.map(Option::unwrap);
    assert!(upper_left.iter().all(|v| *v > 0.2) && lower_right.iter().all(|v| *v < -0.2), "{found:?}");
    assert!(found.largest_residual_px() > GOOD_RESIDUAL_PX);
}

#[test]
fn what_does_not_match_is_refused() {
    let raw = Scene::new(4, SIDE as f64).raw(SIDE, &bayer(), 0.03, 6);
    let other = luminance(&Scene::new(5, SIDE as f64).picture(SIDE, SIDE, [0.0; 2], 1.0));
    let refused = |picture: &Planes, scales: &[f64]| Registration::best(&raw, picture, scales).unwrap_err();
    assert!(matches!(refused(&other, &[1.0]), RegistrationError::NoMatch(_)));
    assert_eq!(refused(&other, &[]), RegistrationError::NoScale);
    let flat = Planes::new(SIDE, SIDE, 1, vec![0.5; SIDE * SIDE]).unwrap();
    assert_eq!(refused(&flat, &[1.0]), RegistrationError::Uniform("the image"));
    let three = Planes::zeros(SIDE, SIDE, 3);
    assert!(matches!(refused(&three, &[1.0]), RegistrationError::Shape(_)));
    for value in [f32::NAN, f32::INFINITY] {
        let mut broken = other.clone();
        broken.data_mut()[2 * SIDE + 5] = value;
        let error = refused(&broken, &[1.0]);
        assert!(matches!(error, RegistrationError::Value { row: 2, col: 5, .. }), "{error}");
    }
    // A tall raw image and a wide picture have no common part of half their size.
    let wide = luminance(&Scene::new(5, SIDE as f64).picture(32, 2 * SIDE, [0.0; 2], 1.0));
    let samples = RawSamples::Digital((0..64 * SIDE).map(|i| (i * i % 4096) as u16).collect());
    let (sampling, channels) = (Sampling::Mosaic(bayer()), names(&["R", "G", "B"]));
    let tall = RawImage::new(2 * SIDE, 32, samples, sampling, channels, 64.0, 4095.0).unwrap();
    assert_eq!(Registration::best(&tall, &wide, &[1.0]), Err(RegistrationError::NoOverlap));
    let small = Planes::new(8, 80, 1, vec![0.5; 640]).unwrap();
    let error = Registration::best(&raw, &small, &[1.0]).unwrap_err();
    assert_eq!(error, RegistrationError::TooSmall { rows: 8, cols: 80, least: 32 });
    for scale in [0.0, -1.0, f64::NAN, 1e9] {
        assert!(matches!(refused(&other, &[1.0, scale]), RegistrationError::Scale(_)));
    }
}

fn learned(pairs: &[(RawImage, Planes)]) -> Pipeline {
    let axes = Axes::new(bayer(), 5, levels(&[0.2, 0.4]), SOME).unwrap();
    let mut s = Statistics::new(axes, names(&["R", "G", "B"]), true).unwrap();
    pairs.iter().for_each(|(raw, target)| s.add(&Pair { raw, seen: None, target }).unwrap());
    solve(&Training::default(), &s)
}

#[test]
fn learning_from_an_aligned_pair_is_as_from_the_exact_one() {
    let scene = Scene::new(6, SIDE as f64);
    let raw = scene.raw(SIDE, &bayer(), 0.02, 7);
    let exact = scene.picture(SIDE, SIDE, [0.0; 2], 1.0);
    let shifted = scene.picture(SIDE, SIDE, [1.6, -2.3], 1.0);
    let found = Registration::best(&raw, &luminance(&shifted), &[1.0]).unwrap();
    let aligned = found.apply(&raw, &shifted).unwrap();
    assert_eq!((aligned.row % 2, aligned.col % 2), (0, 0));
    assert_eq!((aligned.raw.rows(), aligned.raw.cols()), (aligned.target.rows(), aligned.target.cols()));

    let test = Scene::new(8, SIDE as f64);
    let truth = test.picture(SIDE, SIDE, [0.0; 2], 1.0);
    let seen = test.raw(SIDE, &bayer(), 0.02, 9);
    let quality = |raw: &RawImage, target: &Planes| {
        let rendered = learned(&[(raw.clone(), target.clone())]).render_raw(&seen).unwrap();
        peak_ratio_db(&truth, &rendered.planes).unwrap()
    };
    let (best, good, bad) =
        (quality(&raw, &exact), quality(&aligned.raw, &aligned.target), quality(&raw, &shifted));
    println!("exact {best:.2} dB, aligned {good:.2} dB, as it is {bad:.2} dB");
    assert!(good > best - 0.2 && bad < best - 3.0, "exact {best}, aligned {good}, as it is {bad} dB");
}
