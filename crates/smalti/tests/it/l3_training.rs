//! Laws of training: what is learned, and what noise, weights and symmetry do to it.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use smalti::l3::{
    Alpha, Axes, ClassKey, KernelForm, Levels, Moments, Origin, Pair, PerceptualWeights, Pipeline, Solver,
    Statistics, Textures, Training,
};
use smalti::numeric::Planes;
use smalti::numeric::least_squares::{Matrix, lstsq};
use smalti::numeric::philox::Stream;
use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling, SignalNoise};

pub(crate) const NONE: SignalNoise = SignalNoise {
    constant: 0.0,
    per_signal: 0.0,
    per_signal_squared: 0.0,
    row: 0.0,
    column: 0.0,
    above: None,
};
pub(crate) const SOME: SignalNoise = SignalNoise {
    constant: 1e-4,
    per_signal: 2e-3,
    per_signal_squared: 1e-4,
    row: 4e-5,
    column: 3e-5,
    above: None,
};

pub(crate) fn bayer() -> Mosaic {
    Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap()
}

pub(crate) fn one_channel() -> Mosaic {
    Mosaic::new(1, 1, vec![0]).unwrap()
}

pub(crate) fn names(list: &[&str]) -> Vec<String> {
    list.iter().map(|n| (*n).to_owned()).collect()
}

pub(crate) fn levels(cuts: &[f32]) -> Levels {
    Levels::new(cuts.to_vec()).unwrap()
}

fn channel_names(mosaic: &Mosaic) -> Vec<String> {
    (0..mosaic.channels()).map(|c| format!("c{c}")).collect()
}

/// A raw image of 10 bits, black at 0 and white at 1024, so that normalised samples are exact.
fn raw(mosaic: &Mosaic, rows: usize, cols: usize, samples: Vec<u16>) -> RawImage {
    let sampling = Sampling::Mosaic(mosaic.clone());
    RawImage::new(rows, cols, RawSamples::Digital(samples), sampling, channel_names(mosaic), 0.0, 1024.0)
        .unwrap()
}

fn gathered(axes: &Axes, outputs: &[&str], pairs: &[(RawImage, Planes)]) -> Statistics {
    let mut s = Statistics::new(axes.clone(), names(outputs), false).unwrap();
    pairs.iter().for_each(|(raw, target)| s.add(&Pair { raw, seen: None, target }).unwrap());
    s
}

pub(crate) fn solve(training: &Training, s: &Statistics) -> Pipeline {
    training.solve(s, "{}".into()).unwrap()
}

pub(crate) fn with(solver: Solver) -> Training {
    Training { solver, symmetry: false, ..Training::default() }
}

pub(crate) fn perceptual(luminance: f64, chrominance: f64) -> Training {
    let alpha = Alpha { luminance, chrominance };
    with(Solver::Perceptual(PerceptualWeights { flat: alpha, texture: alpha }))
}

/// Σ z zᵀ of some z.
pub(crate) fn moments_of(taps: usize, outputs: usize, list: &[Vec<f64>]) -> Moments {
    let size = 1 + taps + outputs;
    let pairs = (0..size).flat_map(|i| (i..size).map(move |j| (i, j)));
    Moments::from_sums(taps, outputs, pairs.map(|(i, j)| list.iter().map(|z| z[i] * z[j]).sum()).collect())
        .unwrap()
}

pub(crate) fn statistics_of(
    axes: &Axes,
    outputs: &[&str],
    noisy: bool,
    classes: BTreeMap<ClassKey, Moments>,
) -> Statistics {
    let trained = vec![[0.0, 1.0]; axes.positions()];
    let names_of = channel_names(axes.mosaic());
    Statistics::from_parts(
        axes.clone(),
        names(outputs),
        names_of,
        Some([0.0, 1024.0]),
        noisy,
        trained,
        classes,
    )
    .unwrap()
}

fn normal(random: &mut Stream) -> f64 {
    (-2.0 * (1.0 - random.uniform()).ln()).sqrt() * (random.uniform() * std::f64::consts::TAU).cos()
}

/// Without noise a linear target is found again, in every class, those included that had too few patches of their own.
#[test]
fn a_linear_target_is_recovered() {
    let (rows, cols, side) = (120, 133, 3);
    let mut random = Stream::new(1, 1, 1);
    let picture = raw(&bayer(), rows, cols, (0..rows * cols).map(|_| random.below(900) as u16).collect());
    let x = picture.normalized();
    // Other weights at every position.
    let weight = |position: usize, output: usize, tap: usize| {
        ((position * 37 + output * 11 + tap * 7) % 13) as f32 / 13.0 - 0.4
    };
    let offset = |position: usize, output: usize| 0.1 * position as f32 - 0.2 * output as f32;
    let mut target = vec![0.0; 2 * rows * cols];
    for (o, plane) in target.chunks_exact_mut(rows * cols).enumerate() {
        for r in 1..rows - 1 {
            for c in 1..cols - 1 {
                let p = r % 2 * 2 + c % 2;
                let taps = (0..9).map(|t| weight(p, o, t) * x[(r + t / 3 - 1) * cols + c + t % 3 - 1]);
                plane[r * cols + c] = taps.sum::<f32>() + offset(p, o);
            }
        }
    }
    let pairs = [(picture, Planes::new(rows, cols, 2, target).unwrap())];
    let axes = Axes::new(bayer(), side, levels(&[0.3, 0.4, 0.45, 0.6]), NONE).unwrap();
    let s = gathered(&axes, &["a", "b"], &pairs);
    for solver in [
        Solver::LeastSquares,
        Solver::Wiener,
        Solver::Ridge,
        Solver::Perceptual(PerceptualWeights::default()),
    ] {
        let p = solve(&with(solver), &s);
        let learned = p.classes().iter().filter(|c| c.origin == Origin::Learned).count();
        assert!(learned > 8 && learned < p.classes().len(), "{learned} of {}", p.classes().len());
        for class in 0..p.classes().len() {
            let position = p.key(class).position as usize;
            for o in 0..2 {
                for (tap, got) in p.weights(class, o).unwrap().iter().enumerate() {
                    // The target is in single precision: 10⁻⁷ of a few tenths, times the spread of the patches.
                    let error = (got - weight(position, o, tap)).abs();
                    assert!(error < 2e-6, "{solver:?} class {class} tap {tap}: {error:e}");
                }
                assert!((p.kernels().offsets[class * 2 + o] - offset(position, o)).abs() < 3e-6);
            }
        }
    }
}

/// A class of Gaussian patches: correlated signal, and a target that is seen through it only in part.
struct Gaussian {
    mean: f64,
    covariance: Vec<f64>,
    /// Of the target with every tap.
    cross: Vec<f64>,
}

const SPREAD: f64 = 0.06;

impl Gaussian {
    /// Taps of 3 × 3 with correlation 0.8 to the distance; the target is what lies half a pixel to the right.
    fn new() -> Self {
        let place = |t: usize| [(t / 3) as f64, (t % 3) as f64];
        let correlation = |a: [f64; 2], b: [f64; 2]| 0.8f64.powf((a[0] - b[0]).hypot(a[1] - b[1]));
        let v = SPREAD * SPREAD;
        let covariance = (0..81).map(|i| v * correlation(place(i / 9), place(i % 9))).collect();
        let cross = (0..9).map(|t| v * correlation(place(t), [1.0, 1.5])).collect();
        Self { mean: 0.5, covariance, cross }
    }

    /// Σ of the noise at the class's mean signals.
    fn noise(&self) -> Vec<f64> {
        let own = SOME.own(self.mean, self.mean * self.mean + SPREAD * SPREAD);
        let same = |a: bool, value: f64| if a { value } else { 0.0 };
        let at = |i: usize, j: usize| {
            same(i == j, own) + same(i / 3 == j / 3, SOME.row) + same(i % 3 == j % 3, SOME.column)
        };
        (0..81).map(|i| at(i / 9, i % 9)).collect()
    }

    /// The textbook's (C + Σ)⁻¹ c.
    fn wiener(&self) -> Vec<f64> {
        let sum: Vec<f64> = self.covariance.iter().zip(self.noise()).map(|(c, n)| c + n).collect();
        lstsq(Matrix::new(9, 9, &sum), Matrix::new(9, 1, &self.cross)).unwrap()
    }

    /// The exact moments of `count` patches.
    fn moments(&self, count: f64) -> Moments {
        let mut sums = Vec::new();
        for i in 0..11 {
            for j in i..11 {
                let mean = |i: usize| if i == 0 { 1.0 } else { self.mean };
                let second = match (i, j) {
                    (0, _) => 0.0,
                    (10, 10) => SPREAD * SPREAD,
                    (_, 10) => self.cross[i - 1],
                    _ => self.covariance[(i - 1) * 9 + j - 1],
                };
                sums.push(count * (mean(i) * mean(j) + second));
            }
        }
        Moments::from_sums(9, 1, sums).unwrap()
    }

    /// z of noisy patches: signal and target drawn with the covariance, noise on top with the variance of each signal.
    fn draw(&self, count: usize) -> Vec<Vec<f64>> {
        let mut random = Stream::new(21, 1, 7);
        // Cholesky factor of the covariance of taps and target.
        let whole = |i: usize, j: usize| match (i, j) {
            (9, 9) => SPREAD * SPREAD,
            (9, t) | (t, 9) => self.cross[t],
            _ => self.covariance[i * 9 + j],
        };
        let mut lower = [[0.0f64; 10]; 10];
        for i in 0..10 {
            for j in 0..=i {
                let rest = whole(i, j) - (0..j).map(|k| lower[i][k] * lower[j][k]).sum::<f64>();
                lower[i][j] = if i == j { rest.sqrt() } else { rest / lower[j][j] };
            }
        }
        (0..count)
            .map(|_| {
                let seeds: Vec<f64> = (0..10).map(|_| normal(&mut random)).collect();
                let mut signal: Vec<f64> = lower
                    .iter()
                    .map(|l| self.mean + l.iter().zip(&seeds).map(|(l, s)| l * s).sum::<f64>())
                    .collect();
                let shared: Vec<f64> = (0..6).map(|_| normal(&mut random)).collect();
                for (t, x) in signal.iter_mut().take(9).enumerate() {
                    let own = SOME.own(*x, *x * *x).sqrt() * normal(&mut random);
                    *x += own + SOME.row.sqrt() * shared[t / 3] + SOME.column.sqrt() * shared[3 + t % 3];
                }
                [vec![1.0], signal].concat()
            })
            .collect()
    }
}

#[test]
fn wiener_is_the_textbooks_and_computed_noise_is_drawn_noise() {
    let class = Gaussian::new();
    let axes = Axes::new(one_channel(), 3, levels(&[]), SOME).unwrap().with_textures(Textures::None);
    let key = ClassKey { position: 0, saturation: 0, level: 0, texture: 0 };
    let of = |noisy, moments| statistics_of(&axes, &["Y"], noisy, BTreeMap::from([(key, moments)]));
    let expected = class.wiener();
    let computed = solve(&with(Solver::Wiener), &of(false, class.moments(1e6)));
    for (got, want) in computed.weights(0, 0).unwrap().iter().zip(&expected) {
        // Single precision.
        assert!((f64::from(*got) - want).abs() < 1e-6, "{got} is not {want}");
    }
    let count = 100_000;
    let drawn = solve(&with(Solver::Wiener), &of(true, moments_of(9, 1, &class.draw(count))));
    // The covariance of weights from n patches is that of the residual times (C + Σ)⁻¹ / n.
    let sum: Vec<f64> = class.covariance.iter().zip(class.noise()).map(|(c, n)| c + n).collect();
    let eye: Vec<f64> = (0..81).map(|i| f64::from(u8::from(i / 9 == i % 9))).collect();
    let inverse = lstsq(Matrix::new(9, 9, &sum), Matrix::new(9, 9, &eye)).unwrap();
    let residual = SPREAD * SPREAD - expected.iter().zip(&class.cross).map(|(w, c)| w * c).sum::<f64>();
    let score = |t: usize| {
        let error = (residual * inverse[t * 10] / count as f64).sqrt();
        (f64::from(drawn.weights(0, 0).unwrap()[t]) - expected[t]) / error
    };
    let scores: Vec<f64> = (0..9).map(score).collect();
    assert!(scores.iter().all(|s| s.abs() < 4.0), "in standard errors: {scores:?}");
    // And the noise matters: without it the weights are far away.
    let plain = solve(&with(Solver::LeastSquares), &of(false, class.moments(1e6)));
    assert!((f64::from(plain.weights(0, 0).unwrap()[4]) - expected[4]).abs() > 0.1);
}

/// That of S-CIELAB: luminance, red-green, blue-yellow from X, Y, Z.
const OPPONENT: [[f64; 3]; 3] = [
    [0.2787336, 0.7218031, -0.1065520],
    [-0.4487736, 0.2898056, 0.0771569],
    [0.0859513, -0.5899859, 0.5011089],
];
const XYZ_FROM_RGB: [[f64; 3]; 3] = [[0.41, 0.36, 0.18], [0.21, 0.72, 0.07], [0.02, 0.12, 0.95]];

/// A Bayer image of coloured blocks with texture, and its X, Y, Z.
fn colored(side: usize) -> (RawImage, Planes) {
    let mut random = Stream::new(5, 5, 5);
    let block = 7;
    let across = side.div_ceil(block);
    let colors: Vec<[f64; 3]> =
        (0..across * across).map(|_| [0, 1, 2].map(|_| 0.1 + 0.5 * random.uniform())).collect();
    let rgb = |r: usize, c: usize| {
        let texture = 1.0 + 0.3 * ((r * 3 + c) as f64 * 0.9).sin() * ((c * 2 + r) as f64 * 0.45).cos();
        colors[r / block * across + c / block].map(|v| v * texture)
    };
    let places = || (0..side * side).map(|i| (i / side, i % side));
    let samples =
        places().map(|(r, c)| (rgb(r, c)[bayer().channel_at(r, c)] * 1024.0).round() as u16).collect();
    let xyz = XYZ_FROM_RGB.iter().flat_map(|m| {
        places().map(move |(r, c)| rgb(r, c).iter().zip(m).map(|(v, m)| v * m).sum::<f64>() as f32)
    });
    (raw(&bayer(), side, side, samples), Planes::new(side, side, 3, xyz.collect()).unwrap())
}

/// bias² and variance of the estimate in opponent coordinates, over all patches of the statistics.
fn bias_and_variance(p: &Pipeline, s: &Statistics) -> [[f64; 2]; 3] {
    let taps = p.axes().taps();
    let side = p.axes().side();
    let mut sums = [[0.0; 2]; 3];
    for (key, m) in s.classes() {
        let class = p.index(key.position as usize, 0, usize::from(key.level), usize::from(key.texture));
        let n = m.get(0, 0);
        for (k, sums) in sums.iter_mut().enumerate() {
            // The error is e · z with e = (offset, weights, −target).
            let mut e = vec![0.0; m.size()];
            for (o, &share) in OPPONENT[k].iter().enumerate() {
                e[0] += share * f64::from(p.kernels().offsets[class * 3 + o]);
                p.weights(class, o)
                    .unwrap()
                    .iter()
                    .zip(&mut e[1..])
                    .for_each(|(&w, e)| *e += share * f64::from(w));
                e[1 + taps + o] = -share;
            }
            let pairs = || (0..m.size()).flat_map(|i| (0..m.size()).map(move |j| (i, j)));
            sums[0] += pairs().map(|(i, j)| e[i] * e[j] * m.get(i, j)).sum::<f64>();
            let w = &e[1..=taps];
            for (i, w) in w.iter().enumerate() {
                let own = s.axes().noise().own(m.get(0, 1 + i) / n, m.get(1 + i, 1 + i) / n);
                sums[1] += n * own * w * w;
            }
            for line in 0..side {
                let row: f64 = w[line * side..(line + 1) * side].iter().sum();
                let column: f64 = w.iter().skip(line).step_by(side).sum();
                sums[1] += n * (s.axes().noise().row * row * row + s.axes().noise().column * column * column);
            }
        }
    }
    let count = s.count() as f64;
    sums.map(|parts| parts.map(|v| v / count))
}

#[test]
fn weights_trade_bias_for_variance_in_their_own_coordinate() {
    let pairs = [colored(91)];
    let axes = Axes::new(bayer(), 5, levels(&[0.2, 0.3]), SOME).unwrap();
    let s = gathered(&axes, &["X", "Y", "Z"], &pairs);
    for form in [KernelForm::Affine, KernelForm::Linear] {
        let of = |l: f64, c: f64| {
            let training = Training { kernel: form, least_patches: Some(1), ..perceptual(l, c) };
            bias_and_variance(&solve(&training, &s), &s)
        };
        let alphas = [1.0, 4.0, 16.0, 64.0];
        let [by_luminance, by_chrominance] = [alphas.map(|a| of(a, 1.0)), alphas.map(|a| of(1.0, a))];
        for i in 1..alphas.len() {
            for k in 0..3 {
                let (moved, kept) =
                    if k == 0 { (&by_luminance, &by_chrominance) } else { (&by_chrominance, &by_luminance) };
                let ([bias, variance], [bias_before, variance_before]) = (moved[i][k], moved[i - 1][k]);
                assert!(
                    bias > 1.02 * bias_before,
                    "{form:?} coordinate {k}: bias² {bias} after {bias_before}"
                );
                assert!(
                    variance < 0.9 * variance_before,
                    "{form:?} {k}: variance {variance} after {variance_before}"
                );
                for (now, first) in kept[i][k].iter().zip(kept[0][k]) {
                    // Through X, Y, Z in single precision and back.
                    let change = now / first - 1.0;
                    assert!(change.abs() < 1e-4, "{form:?} coordinate {k} moved by {change}");
                }
            }
        }
        // α = 1 has the least sum of both in every coordinate, as Wiener's filter must.
        let total = |v: [f64; 2]| v[0] + v[1];
        assert!((0..3).all(|k| total(by_luminance[0][k]) < total(by_luminance[2][k]) + 1e-12));
        let wiener = solve(&Training { kernel: form, least_patches: Some(1), ..with(Solver::Wiener) }, &s);
        let one = solve(&Training { kernel: form, least_patches: Some(1), ..perceptual(1.0, 1.0) }, &s);
        assert_eq!(wiener.kernels(), one.kernels());
    }
}

/// Uniform patches of many colours are rendered less colourful the more the variance of chrominance weighs, and no
/// darker.
#[test]
fn weight_on_chrominance_desaturates() {
    let pairs = [colored(91)];
    let axes = Axes::new(bayer(), 5, levels(&[]), SOME).unwrap().with_textures(Textures::None);
    let s = gathered(&axes, &["X", "Y", "Z"], &pairs);
    let mut random = Stream::new(6, 6, 6);
    let colors: Vec<[f64; 3]> = (0..40).map(|_| [0, 1, 2].map(|_| 0.1 + 0.5 * random.uniform())).collect();
    // Means and spread of luminance, and chroma about the mean colour, of the uniform patches around a red pixel.
    let rendered = |alpha: f64, form| {
        let p = solve(&Training { kernel: form, ..perceptual(1.0, alpha) }, &s);
        let opponent: Vec<[f64; 3]> = colors
            .iter()
            .map(|color| {
                let xyz = [0, 1, 2].map(|o| {
                    let taps = p.weights(0, o).unwrap().iter().enumerate();
                    let sum: f64 = taps.map(|(t, &w)| f64::from(w) * color[axes.channel_of(0, t)]).sum();
                    sum + f64::from(p.kernels().offsets[o])
                });
                OPPONENT.map(|m| m[0] * xyz[0] + m[1] * xyz[1] + m[2] * xyz[2])
            })
            .collect();
        let mean = |k: usize| opponent.iter().map(|o| o[k]).sum::<f64>() / 40.0;
        let spread =
            |k: usize| (opponent.iter().map(|o| (o[k] - mean(k)).powi(2)).sum::<f64>() / 40.0).sqrt();
        (spread(1).hypot(spread(2)), mean(0))
    };
    for form in [KernelForm::Affine, KernelForm::Linear] {
        let chroma = [1.0, 4.0, 16.0, 64.0].map(|alpha| rendered(alpha, form));
        for pair in chroma.windows(2) {
            assert!(pair[1].0 < 0.97 * pair[0].0, "{form:?}: chroma {} after {}", pair[1].0, pair[0].0);
            assert!(
                (pair[1].1 / pair[0].1 - 1.0).abs() < 1e-4,
                "{form:?}: luminance {} after {}",
                pair[1].1,
                pair[0].1
            );
        }
        assert!(chroma[3].0 < 0.6 * chroma[0].0, "{form:?}: {chroma:?}");
    }
}

#[test]
fn training_in_parts_is_training_at_once_for_any_number_of_threads() {
    let pairs = [colored(91), colored(64), colored(77)];
    let axes = Axes::new(bayer(), 5, levels(&[0.2, 0.3]), SOME).unwrap();
    let outputs = &["X", "Y", "Z"];
    let whole = gathered(&axes, outputs, &pairs);
    let mut parts = gathered(&axes, outputs, &pairs[..1]);
    parts.merge(&gathered(&axes, outputs, &pairs[1..])).unwrap();
    let training = Training::default();
    let (a, b) = (solve(&training, &whole), solve(&training, &parts));
    assert_eq!(a.classes(), b.classes());
    for (a, b) in a.kernels().weights.iter().zip(&b.kernels().weights) {
        assert!((a - b).abs() < 1e-6, "{a} and {b}");
    }
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let s = gathered(&axes, outputs, &pairs);
            let p = solve(&training, &s);
            (s, p)
        })
    };
    assert!(run(1) == run(3));
}

/// One image with symmetry teaches what its eight turns teach without.
#[test]
fn symmetry_is_worth_all_turned_images() {
    let side = 61;
    let mut random = Stream::new(9, 9, 9);
    // Eight bits, so that all sums that decide on classes are exact in any order. Blobs and edges of several contrasts.
    let noise: Vec<u16> = (0..side * side).map(|_| random.below(60) as u16).collect();
    let sample = |r: usize, c: usize| {
        let shape =
            u16::from((r * 2 + c) % 23 < 11) * 90 + u16::from((r / 10 + c / 9).is_multiple_of(2)) * 60;
        let noise = noise[r * side + c];
        shape + if (r / 20 + c / 20).is_multiple_of(2) { noise / 4 } else { noise }
    };
    let value = |r: usize, c: usize| f32::from(sample(r, c)) + f32::from(sample((r + 1) % side, c)) / 3.0;
    // The tile has red at the top left; of an odd side all corners are red, and so are those of its turns.
    let turned = |turn: usize| {
        let last = side - 1;
        let source = move |r: usize, c: usize| {
            let (r, c) = if turn & 1 == 0 { (r, c) } else { (c, r) };
            (if turn & 2 == 0 { r } else { last - r }, if turn & 4 == 0 { c } else { last - c })
        };
        let places = || (0..side * side).map(move |i| source(i / side, i % side));
        let target = places().map(|(r, c)| value(r, c)).collect();
        let samples = places().map(|(r, c)| sample(r, c)).collect();
        (raw(&bayer(), side, side, samples), Planes::new(side, side, 1, target).unwrap())
    };
    let all: Vec<(RawImage, Planes)> = (0..8).map(turned).collect();
    let quiet = SignalNoise { constant: 1e-5, ..NONE };
    let axes = Axes::new(bayer(), 5, levels(&[0.1, 0.14]), quiet).unwrap().with_textures(Textures::Oriented);
    let training = |symmetry| Training { symmetry, least_patches: Some(1), ..with(Solver::Wiener) };
    let eight = gathered(&axes, &["a"], &all);
    let plain = solve(&training(false), &eight);
    let both = solve(&training(true), &eight);
    let one = solve(&training(true), &gathered(&axes, &["a"], &all[..1]));
    let alone = solve(&training(false), &gathered(&axes, &["a"], &all[..1]));
    let differ = |a: &Pipeline, b: &Pipeline| {
        let differences = a.kernels().weights.iter().zip(&b.kernels().weights).map(|(a, b)| (a - b).abs());
        differences.fold(0.0, f32::max)
    };
    // Weights are of order 1000 here: the targets are.
    assert!(differ(&plain, &both) < 1e-2, "{}", differ(&plain, &both));
    assert!(differ(&plain, &one) < 1e-2, "{}", differ(&plain, &one));
    assert!(differ(&plain, &alone) > 1.0);
    assert!(plain.kernels().weights.iter().fold(0.0, |m: f32, w| m.max(*w)) > 100.0);
    let edges = eight.classes().keys().filter(|k| k.texture >= 2).count();
    assert!(edges >= 20, "only {edges} classes of edges");
    assert_eq!(plain.classes().iter().map(|c| c.origin).collect::<Vec<_>>(), {
        one.classes().iter().map(|c| c.origin).collect::<Vec<_>>()
    });
    // Kernels of the red cell are symmetric, those of the greens each other's transpose (level 1, flat).
    let at = |position| one.weights(one.index(position, 0, 1, 0), 0).unwrap();
    for t in 0..25 {
        let transposed = t % 5 * 5 + t / 5;
        assert!((at(0)[t] - at(0)[transposed]).abs() < 1e-2 && (at(0)[t] - at(0)[24 - t]).abs() < 1e-2);
        assert!((at(1)[t] - at(2)[transposed]).abs() < 1e-2);
    }
    // Each class counts its own patches.
    assert_eq!(one.summary().patches, gathered(&axes, &["a"], &all[..1]).count());
}
