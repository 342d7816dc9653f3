//! In double precision, where what a pipeline keeps is single.

use super::*;
use crate::l3::{Axes, Levels, Pair, PerceptualWeights};
use crate::numeric::Planes;
use crate::numeric::least_squares::{Matrix, lstsq};
use crate::numeric::philox::Stream;
use crate::sensor::{Mosaic, RawImage, RawSamples, Sampling};

const NOISE: SignalNoise = SignalNoise {
    constant: 2e-4,
    per_signal: 3e-3,
    per_signal_squared: 1e-3,
    row: 5e-5,
    column: 2e-5,
    above: None,
};

fn names(outputs: &[&str]) -> Vec<String> {
    outputs.iter().map(|o| (*o).to_owned()).collect()
}

/// Statistics of one class (mosaic of one channel, one level) of an image, with its normalised samples and the target.
fn one_class(
    side: usize,
    outputs: &[&str],
    noisy: bool,
    mut target: impl FnMut(&[f32], usize, usize, usize) -> f32,
) -> (Statistics, Vec<f32>, Planes) {
    let (rows, cols) = (30, 34);
    let mut random = Stream::new(11, 1, 2);
    let samples: Vec<u16> = (0..rows * cols).map(|_| 100 + random.below(800) as u16).collect();
    let sampling = Sampling::Mosaic(Mosaic::new(1, 1, vec![0]).unwrap());
    let samples = RawSamples::Digital(samples);
    let raw = RawImage::new(rows, cols, samples, sampling, names(&["W"]), 64.0, 1023.0).unwrap();
    let x = raw.normalized();
    let planes = (0..outputs.len() * rows * cols)
        .map(|i| target(&x, i / (rows * cols), i % (rows * cols) / cols, i % cols))
        .collect();
    let planes = Planes::new(rows, cols, outputs.len(), planes).unwrap();
    let axes =
        Axes::new(Mosaic::new(1, 1, vec![0]).unwrap(), side, Levels::new(vec![]).unwrap(), NOISE).unwrap();
    let axes = axes.with_textures(crate::l3::Textures::None);
    let mut s = Statistics::new(axes, names(outputs), noisy).unwrap();
    s.add(&Pair { raw: &raw, seen: None, target: &planes }).unwrap();
    (s, x, planes)
}

fn solved(s: &Statistics, solver: Solver, form: KernelForm) -> Solution {
    let mut whole = Moments::new(s.axes().taps(), s.outputs().len());
    s.classes().values().for_each(|m| whole.merge(m));
    ClassSolver::new(&solver, form, s).solve(&whole, false, 0).unwrap()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// What is streamed and solved from moments is what a singular value decomposition of all patches at once gives, with the noise as rows of
/// its own: Σ = L Lᵀ times n below the centred patches.
#[test]
fn the_same_as_a_dense_solution() {
    let mut random = Stream::new(3, 3, 3);
    let (s, x, target) = one_class(5, &["a", "b"], false, |x, o, r, c| {
        let around = x[r * 34 + c] + 0.3 * x[r * 34 + (c + 1).min(33)];
        around * (1.0 + o as f32) + 0.2 * random.uniform() as f32
    });
    let patches: Vec<(usize, usize)> = (2..28).flat_map(|r| (2..32).map(move |c| (r, c))).collect();
    let n = patches.len();
    let tap = |(r, c): (usize, usize), t: usize| f64::from(x[(r + t / 5 - 2) * 34 + c + t % 5 - 2]);
    let mean: Vec<f64> =
        (0..25).map(|t| patches.iter().map(|&p| tap(p, t)).sum::<f64>() / n as f64).collect();
    let square: Vec<f64> =
        (0..25).map(|t| patches.iter().map(|&p| tap(p, t).powi(2)).sum::<f64>() / n as f64).collect();
    for (solver, form) in [
        (Solver::LeastSquares, KernelForm::Affine),
        (Solver::LeastSquares, KernelForm::Linear),
        (Solver::Wiener, KernelForm::Affine),
        (Solver::Wiener, KernelForm::Linear),
    ] {
        // Rows of noise: own, per row of the patch, per column of the patch; each scaled by √n.
        let mut noise: Vec<Vec<f64>> = Vec::new();
        if solver == Solver::Wiener {
            for t in 0..25 {
                let own = NOISE.own(mean[t], square[t]).sqrt();
                noise.push((0..25).map(|k| if k == t { own } else { 0.0 }).collect());
            }
            for line in 0..5 {
                noise.push((0..25).map(|k| if k / 5 == line { NOISE.row.sqrt() } else { 0.0 }).collect());
                noise.push((0..25).map(|k| if k % 5 == line { NOISE.column.sqrt() } else { 0.0 }).collect());
            }
        }
        // An offset is a column of ones, which noise does not reach.
        let affine = usize::from(form == KernelForm::Affine);
        let (rows, cols) = (n + noise.len(), 25 + affine);
        let entry = |i: usize, j: usize| match (i < n, j < 25) {
            (true, true) => tap(patches[i], j),
            (true, false) => 1.0,
            (false, true) => noise[i - n][j] * (n as f64).sqrt(),
            (false, false) => 0.0,
        };
        let a: Vec<f64> = (0..rows * cols).map(|i| entry(i / cols, i % cols)).collect();
        let wanted = |i: usize, o: usize| {
            patches.get(i).map_or(0.0, |&(r, c)| f64::from(target.plane(o).unwrap()[r * 34 + c]))
        };
        let b: Vec<f64> = (0..rows * 2).map(|i| wanted(i / 2, i % 2)).collect();
        let expected = lstsq(Matrix::new(rows, cols, &a), Matrix::new(rows, 2, &b)).unwrap();
        let got = solved(&s, solver, form);
        let scale = largest(&got.weights);
        for o in 0..2 {
            for t in 0..25 {
                let error = (got.weights[o * 25 + t] - expected[t * 2 + o]).abs() / scale;
                assert!(
                    error < 1e-9,
                    "{solver:?} {form:?} output {o} tap {t}: {error:e} of the largest weight"
                );
            }
            if affine == 1 {
                assert!((got.offsets[o] - expected[25 * 2 + o]).abs() < 1e-9 * scale);
            }
        }
    }
}

#[test]
fn equal_weights_are_wieners_solution_bit_by_bit() {
    let (s, ..) = one_class(5, &["X", "Y", "Z"], false, |x, o, r, c| x[r * 34 + c] * (o as f32 - 0.5) + 0.1);
    let one = Alpha { luminance: 1.0, chrominance: 1.0 };
    let perceptual = Solver::Perceptual(PerceptualWeights { flat: one, texture: one });
    for form in [KernelForm::Affine, KernelForm::Linear] {
        assert_eq!(solved(&s, perceptual, form), solved(&s, Solver::Wiener, form));
    }
    // And going through the opponent space and back changes no more than rounding.
    let nearly = Alpha { luminance: 1.0, chrominance: 1.0 + 1e-15 };
    let perceptual = Solver::Perceptual(PerceptualWeights { flat: nearly, texture: nearly });
    let (a, b) = (solved(&s, perceptual, KernelForm::Affine), solved(&s, Solver::Wiener, KernelForm::Affine));
    a.weights.iter().zip(&b.weights).for_each(|(a, b)| assert!((a - b).abs() < 1e-12));
    // Outputs that are no colours are Wiener's with any weights; colours among others keep their own.
    let (other, ..) =
        one_class(5, &["a", "Y", "Z"], false, |x, o, r, c| x[r * 34 + c] * (o as f32 - 0.5) + 0.1);
    assert_eq!(
        solved(&other, Solver::Perceptual(PerceptualWeights::default()), KernelForm::Affine),
        solved(&other, Solver::Wiener, KernelForm::Affine)
    );
    let (four, ..) =
        one_class(5, &["N", "X", "Y", "Z"], false, |x, o, r, c| x[r * 34 + c] * (o as f32 - 1.5) + 0.1);
    let (a, b) = (
        solved(&four, Solver::Perceptual(PerceptualWeights::default()), KernelForm::Affine),
        solved(&four, Solver::Wiener, KernelForm::Affine),
    );
    assert_eq!(a.weights[..25], b.weights[..25]);
    assert_ne!(a.weights[25..], b.weights[25..]);
    let three = solved(&s, Solver::Perceptual(PerceptualWeights::default()), KernelForm::Affine);
    let moved = |o: usize| (a.weights[(o + 1) * 25] - three.weights[o * 25]).abs();
    assert!((0..3).all(|o| moved(o) < 1e-12));
}

/// Patches that hold the noise already get none at α = 1, and α − 1 times the noise above.
#[test]
fn noisy_statistics_hold_their_noise() {
    let (clean, x, target) =
        one_class(3, &["X", "Y", "Z"], false, |x, o, r, c| x[r * 34 + c] * (1.0 + o as f32));
    let noisy = Statistics::new(clean.axes().clone(), clean.outputs().to_vec(), true).unwrap();
    let mut moments = Moments::new(9, 3);
    clean.classes().values().for_each(|m| moments.merge(m));
    drop((x, target));
    // The same moments with n Σ added by hand.
    let n = moments.get(0, 0);
    let mut with_noise = moments.sums().to_vec();
    let place = |i: usize, j: usize| i * 13 - i * (i + 1) / 2 + j;
    for i in 0..9 {
        for j in i..9 {
            let own = NOISE.own(moments.get(0, 1 + i) / n, moments.get(1 + i, 1 + i) / n);
            let shared = f64::from(u8::from(i / 3 == j / 3)) * NOISE.row
                + f64::from(u8::from(i % 3 == j % 3)) * NOISE.column
                + if i == j { own } else { 0.0 };
            with_noise[place(1 + i, 1 + j)] += n * shared;
        }
    }
    let with_noise = Moments::from_sums(9, 3, with_noise).unwrap();
    for solver in [Solver::Wiener, Solver::Perceptual(PerceptualWeights::default())] {
        let a = ClassSolver::new(&solver, KernelForm::Affine, &clean).solve(&moments, true, 0).unwrap();
        let b = ClassSolver::new(&solver, KernelForm::Affine, &noisy).solve(&with_noise, true, 0).unwrap();
        // For α ≠ 1 the mean square that PRNU acts on holds the noise itself, and Σ is larger by a thousandth.
        let tolerance = if solver == Solver::Wiener { 1e-12 } else { 1e-3 };
        a.weights.iter().zip(&b.weights).for_each(|(a, b)| assert!((a - b).abs() < tolerance, "{a} {b}"));
    }
}

/// Classes whose patches are all equal, all black, fewer than taps, or repeat a column.
#[test]
fn degenerate_classes_have_finite_kernels() {
    let moments_of = |patches: &[Vec<f64>]| {
        let mut sums = Vec::new();
        for i in 0..13 {
            for j in i..13 {
                sums.push(patches.iter().map(|z| z[i] * z[j]).sum());
            }
        }
        Moments::from_sums(9, 3, sums).unwrap()
    };
    let patch = |x: [f64; 9], y: f64| [&[1.0][..], &x, &[y, 2.0 * y, y / 2.0]].concat();
    let mut random = Stream::new(4, 4, 4);
    let mut any = || std::array::from_fn(|_| f64::from(random.uniform() as f32));
    let few: Vec<Vec<f64>> = (0..4).map(|i| patch(any(), f64::from(i))).collect();
    let twins: Vec<Vec<f64>> = (0..50)
        .map(|_| {
            let mut x: [f64; 9] = any();
            x[8] = x[7];
            patch(x, x[7] + x[8])
        })
        .collect();
    let cases = [
        ("equal", vec![patch([0.3, 0.1, 0.3, 0.1, 0.2, 0.1, 0.3, 0.1, 0.3], 0.7); 20]),
        ("black", vec![patch([0.0; 9], 0.0); 20]),
        ("one", vec![patch([0.4; 9], 1.0)]),
        ("few", few),
        ("twins", twins),
    ];
    let noiseless = one_class(3, &["X", "Y", "Z"], true, |_, _, _, _| 0.0).0;
    let zero = Alpha { luminance: 0.0, chrominance: 0.5 };
    let below = Solver::Perceptual(PerceptualWeights { flat: zero, texture: zero });
    for (name, patches) in cases {
        let moments = moments_of(&patches);
        for solver in [
            Solver::LeastSquares,
            Solver::Ridge,
            Solver::Wiener,
            Solver::Perceptual(PerceptualWeights::default()),
            below,
        ] {
            for form in [KernelForm::Affine, KernelForm::Linear] {
                let s = ClassSolver::new(&solver, form, &noiseless).solve(&moments, true, 0).unwrap();
                assert!(s.weights.iter().chain(&s.offsets).all(|v| v.is_finite()), "{name}");
                if solver == Solver::LeastSquares && (form == KernelForm::Affine || name != "few") {
                    // What was seen is fitted, all of these being linear.
                    for z in &patches {
                        let y = s.offsets[0] + dense::dot(&s.weights[..9], &z[1..10]);
                        assert!((y - z[10]).abs() < 1e-6, "{name} {form:?}: {y} for {}", z[10]);
                    }
                }
                if solver == Solver::LeastSquares && name == "twins" {
                    // Of all solutions the one of least norm shares equally.
                    assert!((s.weights[7] - s.weights[8]).abs() < 1e-6 && (s.weights[7] - 1.0).abs() < 1e-6);
                }
            }
        }
    }
}

/// λ by cross-validation from moments is that by its definition, with matrices, and predicts unseen data about as well as
/// the best λ does.
#[test]
fn cross_validation_finds_the_weight() {
    let (taps, n) = (25, 80);
    for (seed, noise) in [(1, 0.02), (2, 0.3), (3, 3.0), (4, 10.0)] {
        let mut random = Stream::new(seed, 9, 9);
        let mut normal = || (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
        let truth: Vec<f64> = (0..taps).map(|t| 1.0 / (1.0 + t as f64)).collect();
        // Samples of uneven variance, so that there is something to gain.
        let mut draw = |count: usize| {
            let mut rows = Vec::new();
            for _ in 0..count {
                let x: Vec<f64> = (0..taps).map(|t| normal() * 0.8f64.powi(t as i32)).collect();
                let y = dense::dot(&x, &truth) + noise * normal();
                rows.push((x, y));
            }
            rows
        };
        let (seen, held_out) = (draw(n), draw(4000));
        type Sample = (Vec<f64>, f64);
        let per = |f: &dyn Fn(&Sample) -> f64| seen.iter().map(f).sum::<f64>() / n as f64;
        let gram: Vec<f64> = (0..taps * taps).map(|i| per(&|(x, _)| x[i / taps] * x[i % taps])).collect();
        let cross: Vec<f64> = (0..taps).map(|i| per(&|(x, y)| x[i] * y)).collect();
        let power = per(&|(_, y)| y * y);
        let eigen = Eigen::of(&gram, taps).unwrap();
        let ridge = Ridge { eigen: &eigen, cut: 1e-14, count: n as f64, offset: 0.0, power };
        let at = |lambda: f64| {
            let mut w = vec![0.0; taps];
            for (d, v) in eigen.above(0.0) {
                let along = dense::dot(v, &cross) / (d + lambda);
                w.iter_mut().zip(v).for_each(|(w, v)| *w += along * v);
            }
            w
        };
        // V by its definition: residuals of the data, and the trace of X (XᵀX + n λ)⁻¹ Xᵀ.
        let v = |lambda: f64| {
            let w = at(lambda);
            let residual: f64 = seen.iter().map(|(x, y)| (y - dense::dot(x, &w)).powi(2)).sum();
            let trace: f64 = eigen.values.iter().map(|d| d / (d + lambda)).sum();
            residual / (n as f64 - trace).powi(2)
        };
        let chosen = ridge.lambda(&cross);
        let grid = (0..=400).map(|i| 10f64.powf(-8.0 + 0.03 * f64::from(i)));
        let least = grid.clone().map(v).fold(f64::INFINITY, f64::min);
        assert!(v(chosen) <= least * (1.0 + 1e-4), "noise {noise}: V {} is above {least}", v(chosen));
        let error = |lambda: f64| {
            let w = at(lambda);
            held_out.iter().map(|(x, y)| (y - dense::dot(x, &w)).powi(2)).sum::<f64>() / held_out.len() as f64
        };
        let (best, plain) = (grid.map(error).fold(f64::INFINITY, f64::min), error(1e-9));
        // From 80 patches λ is not known well; what it costs is a few per cent of the error, where no λ costs a third.
        assert!(error(chosen) < 1.1 * best, "noise {noise}: {} for {best} at best", error(chosen));
        assert!(error(chosen) < 1.02 * plain, "noise {noise}: {} and {plain} without", error(chosen));
    }
}

/// Noise that pixels of a row share, or those of a column, is that of one random number per line: Σ over the lines of 1 1ᵀ.
#[test]
fn shared_noise_is_that_of_whole_lines() {
    let patches: Vec<f64> = (0..10).map(|i| 0.1 * f64::from(i)).collect();
    let sums = (0..11).flat_map(|i| (i..11).map(move |j| (i, j)));
    let z: Vec<f64> = std::iter::once(1.0).chain(patches).collect();
    let moments = Moments::from_sums(9, 1, sums.map(|(i, j)| 4.0 * z[i] * z[j]).collect()).unwrap();
    let none = SignalNoise::default();
    let own = SignalNoise { constant: 2e-4, per_signal: 3e-3, per_signal_squared: 1e-3, ..none };
    for (row, column) in [(0.0, 0.0), (5e-5, 0.0), (0.0, 2e-5), (5e-5, 2e-5)] {
        let mut found = vec![1.0; 81];
        add_noise(&mut found, 1.5, &SignalNoise { row, column, ..own }, 3, &moments);
        let mut expected = vec![1.0; 81];
        for (i, x) in z[1..10].iter().enumerate() {
            expected[i * 10] += 1.5 * own.variance(*x);
        }
        for line in 0..3 {
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                expected[(line * 3 + i) * 9 + line * 3 + j] += 1.5 * row;
                expected[(i * 3 + line) * 9 + j * 3 + line] += 1.5 * column;
            }
        }
        for (i, (a, b)) in found.iter().zip(&expected).enumerate() {
            // Rounding of sums near 1.
            assert!((a - b).abs() < 4e-15, "row {row}, column {column}: {a} for {b} at {i}");
        }
    }
}

/// The unit of the samples does not matter: λ is a second moment of them.
#[test]
fn the_weight_scales_with_the_samples() {
    let taps = 9;
    let spread: Vec<f64> = (0..taps).map(|t| 0.64f64.powi(t)).collect();
    for noise in [0.1, 0.3, 1.0, 3.0] {
        let lambda = |scale: f64| {
            let size = taps as usize;
            let mut gram = vec![0.0; size * size];
            gram.iter_mut().step_by(size + 1).zip(&spread).for_each(|(g, d)| *g = d * scale * scale);
            let sign = |t: usize| if t % 4 < 2 { 1.0 } else { -1.0 };
            let cross = |(t, d): (usize, &f64)| d / (1.0 + t as f64) + noise * sign(t) * (d / 80.0).sqrt();
            let cross: Vec<f64> = spread.iter().enumerate().map(cross).collect();
            let explained: f64 = cross.iter().zip(&spread).map(|(c, d)| c * c / d).sum();
            let power = explained + noise * noise * 71.0 / 80.0;
            let eigen = Eigen::of(&gram, size).unwrap();
            let ridge = Ridge { eigen: &eigen, cut: 1e-14 * scale * scale, count: 80.0, offset: 0.0, power };
            let cross: Vec<f64> = cross.iter().map(|c| c * scale).collect();
            ridge.lambda(&cross) / (scale * scale)
        };
        let own = lambda(1.0);
        assert!(own > 1e-4, "{own}");
        for scale in [1e-3, 0.25, 1e3] {
            // λ is determined to a thousandth.
            assert!((lambda(scale) / own - 1.0).abs() < 1e-3, "noise {noise}, scale {scale}: {own}");
        }
    }
}

/// Ridge regression of few patches with the λ that minimises V by its definition: A is the matrix from the outputs to their fit, and its
/// trace counts the offset as a degree of freedom, which is not penalised.
#[test]
fn an_offset_is_a_degree_of_freedom() {
    let (n, taps) = (14, 9);
    let mut random = Stream::new(2, 5, 5);
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for _ in 0..n {
        let patch: Vec<f64> = (0..taps).map(|_| random.uniform()).collect();
        let truth = patch.iter().enumerate().map(|(t, v)| v * if t == 4 { 0.9 } else { 0.1 });
        y.push(truth.sum::<f64>() + 0.4 + random.uniform() - 0.5);
        x.push(patch);
    }
    let mut moments = Moments::new(taps, 1);
    for (patch, y) in x.iter().zip(&y) {
        moments.add(&[&[1.0][..], &patch[..], &[*y][..]].concat(), 1.0);
    }
    let statistics = one_class(3, &["a"], true, |_, _, _, _| 0.0).0;
    for form in [KernelForm::Affine, KernelForm::Linear] {
        let cols = taps + usize::from(form == KernelForm::Affine);
        // Weights, and V.
        let fitted = |log: f64| {
            let penalty = (n as f64 * log.exp()).sqrt();
            let entry = |i: usize, j: usize| match i.checked_sub(n) {
                None => x[i].get(j).copied().unwrap_or(1.0),
                Some(t) => f64::from(u8::from(t == j)) * penalty,
            };
            let a: Vec<f64> = (0..(n + taps) * cols).map(|i| entry(i / cols, i % cols)).collect();
            let unit = |i: usize| f64::from(u8::from(i / n == i % n));
            let b: Vec<f64> = (0..(n + taps) * n).map(unit).collect();
            let inverse = lstsq(Matrix::new(n + taps, cols, &a), Matrix::new(n + taps, n, &b)).unwrap();
            let weights: Vec<f64> = inverse.chunks_exact(n).map(|line| dense::dot(line, &y)).collect();
            let fit = |i: usize| (0..cols).map(|j| entry(i, j) * weights[j]).sum::<f64>();
            let residual: f64 = (0..n).map(|i| (y[i] - fit(i)).powi(2)).sum();
            let trace: f64 =
                (0..n).map(|i| (0..cols).map(|j| entry(i, j) * inverse[j * n + i]).sum::<f64>()).sum();
            (weights, residual / (n as f64 - trace).powi(2))
        };
        let mut best = (0.0, f64::INFINITY);
        let mut step = 0.2;
        let mut search: Vec<f64> = (-70..20).map(|i| step * f64::from(i)).collect();
        while step > 1e-4 {
            for log in search {
                let (_, v) = fitted(log);
                best = if v < best.1 { (log, v) } else { best };
            }
            step /= 4.0;
            search = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0].map(|i| best.0 + i * step).to_vec();
        }
        let expected = fitted(best.0).0;
        let found = ClassSolver::new(&Solver::Ridge, form, &statistics).solve(&moments, false, 0).unwrap();
        for (a, b) in found.weights.iter().zip(&expected) {
            // With one degree of freedom more or less, weights change by a tenth of the largest.
            assert!((a - b).abs() < 5e-3 * largest(&expected[..taps]), "{form:?}: {a} for {b}");
        }
        let offset = expected.get(taps).copied().unwrap_or(0.0);
        assert!((found.offsets[0] - offset).abs() < 1e-2, "{form:?}: {} for {offset}", found.offsets[0]);
    }
}
