use super::statistics::{ClassLight, WIDE};
use super::{EvenPatches, LightSystem, Saturated};
use crate::design::screen::lanes::ZERO;
use crate::l3::{Axes, ClassMap, ClassPool, Levels, Moments, PoolSource};
use crate::numeric::dense::{cholesky, dot, substitute};
use crate::numeric::philox::Stream;
use crate::sensor::{Mosaic, SignalNoise};

const TAPS: usize = 9;
const K: usize = 2;
const SCALE: f64 = 0.7;
const RESPONSES: [[f64; K]; 2] = [[0.8, -0.1], [0.3, 0.4]];
/// The channel of each pixel of a patch: a checkerboard.
const CHANNELS: [usize; TAPS] = [0, 1, 0, 1, 0, 1, 0, 1, 0];
const EVEN: [([f64; 2], [f64; 3]); 3] =
    [([0.2, 0.1], [0.1, 0.2, 0.3]), ([0.5, 0.3], [0.4, 0.3, 0.1]), ([0.3, 0.4], [0.2, 0.2, 0.2])];
/// Patches of each even field, and the share of the patches of the light that count.
const TIMES: f64 = 128.0;
const SHARE: f64 = 0.5;

/// Coefficients of every pixel of patches of smooth light, and X, Y, Z of the middle pixel.
fn patches(count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = Stream::new(seed, 4, 9);
    let patch = |_| {
        let [level, slope, hue] = [(); 3].map(|()| random.uniform());
        let mut u: Vec<f64> = (0..TAPS)
            .flat_map(|tap| {
                let v = 0.1 + 0.5 * level + 0.2 * slope * (tap % 3) as f64 + 0.05 * random.uniform();
                [v, 0.3 * hue * v]
            })
            .collect();
        let [a, b] = [u[TAPS / 2 * K], u[TAPS / 2 * K + 1]];
        u.extend([a + b, 0.9 * a, 0.2 * a - b]);
        u
    };
    (0..count).map(patch).collect()
}

/// Σ z zᵀ.
fn moments(patches: &[Vec<f64>]) -> Moments {
    let size = 1 + TAPS * K + 3;
    let at = |z: &Vec<f64>, i: usize| if i == 0 { 1.0 } else { z[i - 1] };
    let sum = |i: usize, j: usize| patches.iter().map(|z| at(z, i) * at(z, j)).sum::<f64>();
    let sums = (0..size).flat_map(|i| (i..size).map(move |j| (i, j))).map(|(i, j)| sum(i, j)).collect();
    Moments::from_sums(TAPS * K, 3, sums).unwrap()
}

fn pool(texture: usize) -> ClassPool {
    ClassPool { level: Some(0), texture: Some(texture) }
}

/// Statistics with a lane for each set of patches.
fn statistics(sets: &[Vec<Vec<f64>>]) -> ClassLight {
    let mut light = ClassLight {
        taps: TAPS,
        components: K,
        pools: Vec::new(),
        groups: sets.len().div_ceil(WIDE),
        covariances: vec![[0.0; WIDE]; sets.len().div_ceil(WIDE) * TAPS * (TAPS + 1) / 2 * K * K],
        means: vec![ZERO; sets.len().div_ceil(WIDE) * 2 * TAPS * K],
        crossed: vec![[ZERO; 3]; sets.len().div_ceil(WIDE) * 2 * TAPS * K],
        range: [0.0, 1.0],
        counts: sets.iter().map(|s| s.len() as f64).collect(),
        textures: sets.len(),
        map: ClassMap { first: 1, cols: 1, local: Vec::new(), range: [0.0, 1.0] },
        turns: Vec::new(),
    };
    for (lane, set) in sets.iter().enumerate() {
        light.fill(lane, pool(lane), &moments(set));
    }
    light
}

/// The samples of a patch, and its target.
fn seen(u: &[f64]) -> Vec<f64> {
    let x = (0..TAPS).map(|i| dot(&RESPONSES[CHANNELS[i]], &u[i * K..(i + 1) * K]));
    x.chain(u[TAPS * K..].iter().map(|y| SCALE * y)).collect()
}

/// Σ z zᵀ of the samples of patches, each of which counts so many times.
fn moments_seen<'a>(patches: impl IntoIterator<Item = &'a Vec<f64>>, times: f64) -> Moments {
    let mut moments = Moments::new(TAPS, 3);
    patches.into_iter().for_each(|u| moments.add(&[&[1.0], &seen(u)[..]].concat(), times));
    moments
}

/// Those of some patches of some sets, which a design saturates.
fn saturated(sets: &[Vec<Vec<f64>>]) -> Saturated {
    let of = |(lane, set): (usize, &Vec<Vec<f64>>)| {
        let moments = moments_seen(set.iter().filter(|u| is_saturated(lane, u)), 1.0);
        (moments.count() > 0).then_some(moments)
    };
    Saturated { classes: sets.iter().enumerate().map(of).collect(), counts: [sets.len(); 2] }
}

/// The brighter half of the patches of every third set.
fn is_saturated(lane: usize, u: &[f64]) -> bool {
    lane.is_multiple_of(3) && u[0] > 0.45
}

/// Weights and offsets by textbook: weighted samples of the patches and of even fields, their covariance, noise, and a solution for each
/// output.
fn textbook(patches: &[Vec<f64>], with_even: bool, noise: &SignalNoise) -> (Vec<f64>, Vec<f64>) {
    let light = patches.iter().map(|u| (SHARE, seen(u)));
    let even = EVEN
        .iter()
        .filter(|_| with_even)
        .map(|(samples, y)| (TIMES, CHANNELS.iter().map(|&c| samples[c]).chain(*y).collect::<Vec<f64>>()));
    let all: Vec<(f64, Vec<f64>)> = light.chain(even).collect();
    let total: f64 = all.iter().map(|(w, _)| w).sum();
    let mean: Vec<f64> =
        (0..TAPS + 3).map(|i| all.iter().map(|(w, z)| w * z[i]).sum::<f64>() / total).collect();
    let covariance = |i: usize, j: usize| {
        all.iter().map(|(w, z)| w * (z[i] - mean[i]) * (z[j] - mean[j])).sum::<f64>() / total
    };
    let mut gram: Vec<f64> = (0..TAPS * TAPS).map(|at| covariance(at / TAPS, at % TAPS)).collect();
    for i in 0..TAPS {
        gram[i * TAPS + i] += noise.own(mean[i], gram[i * TAPS + i] + mean[i] * mean[i]);
        for j in 0..TAPS {
            gram[i * TAPS + j] += if i / 3 == j / 3 { noise.row } else { 0.0 };
            gram[i * TAPS + j] += if i % 3 == j % 3 { noise.column } else { 0.0 };
        }
    }
    assert!(cholesky(&mut gram, TAPS, 0.0));
    let mut weights = Vec::new();
    for o in 0..3 {
        let mut row: Vec<f64> = (0..TAPS).map(|i| covariance(i, TAPS + o)).collect();
        substitute(&gram, TAPS, &mut row);
        weights.extend(row);
    }
    let offsets = (0..3).map(|o| mean[TAPS + o] - dot(&weights[o * TAPS..(o + 1) * TAPS], &mean[..TAPS]));
    let offsets = offsets.collect();
    (weights, offsets)
}

fn even_patches() -> EvenPatches {
    let n = EVEN.len() as f64;
    let mean = [0, 1].map(|c| EVEN.iter().map(|f| f.0[c]).sum::<f64>() / n);
    let target = [0, 1, 2].map(|o| EVEN.iter().map(|f| f.1[o]).sum::<f64>() / n);
    let covariance =
        |c: usize, d: usize| EVEN.iter().map(|f| (f.0[c] - mean[c]) * (f.0[d] - mean[d])).sum::<f64>() / n;
    let crossed =
        |c: usize, o: usize| EVEN.iter().map(|f| (f.0[c] - mean[c]) * (f.1[o] - target[o])).sum::<f64>() / n;
    EvenPatches {
        count: n * TIMES,
        mean: mean.to_vec(),
        covariance: (0..4).map(|i| covariance(i / 2, i % 2)).collect(),
        target,
        crossed: (0..2).map(|c| [0, 1, 2].map(|o| crossed(c, o))).collect(),
    }
}

/// A design of one position.
fn system<'a>(
    light: &ClassLight,
    noise: SignalNoise,
    even: &'a (dyn Fn(usize, ClassPool) -> Option<EvenPatches> + Sync),
    saturated: Saturated,
) -> LightSystem<'a> {
    let (mosaic, levels) = (Mosaic::new(2, 2, vec![0, 1, 1, 0]).unwrap(), Levels::new(Vec::new()).unwrap());
    LightSystem {
        responses: RESPONSES.iter().map(|r| r.to_vec()).collect(),
        scale: SCALE,
        positions: vec![0],
        channels: vec![CHANNELS.to_vec()],
        share: SHARE,
        noise,
        even,
        saturated,
        counts: light.patch_counts(&Axes::new(mosaic, 3, levels, noise).unwrap()),
    }
}

/// The kernels of a lane are those of the textbook, to single precision.
fn assert_kernels(kernels: &impl PoolSource, lane: usize, (weights, offsets): &(Vec<f64>, Vec<f64>)) {
    let found = kernels.kernels(0, pool(lane)).unwrap();
    let largest = weights.iter().fold(0.0f64, |m, w| m.max(w.abs()));
    for (a, b) in found.weights.iter().zip(weights).chain(found.offsets.iter().zip(offsets)) {
        assert!((a - b).abs() < 1e-3 * largest, "lane {lane}: {a} and {b}, largest {largest}");
    }
}

/// Every lane, in both halves of two vectors, with and without even and saturated patches, and with noise of rows and columns. The statistics are in
/// single precision, beside noise of a thousandth of the variance.
#[test]
fn kernels_are_those_of_textbook_least_squares() {
    let sets: Vec<Vec<Vec<f64>>> = (0..WIDE as u64 + 3).map(|s| patches(300 + s as usize, s)).collect();
    let light = statistics(&sets);
    for noise in [
        SignalNoise { constant: 1e-4, per_signal: 1e-3, per_signal_squared: 1e-4, ..SignalNoise::default() },
        SignalNoise { constant: 1e-4, row: 1e-4, column: 2e-4, ..SignalNoise::default() },
    ] {
        let even = |_, pool: ClassPool| pool.texture.unwrap().is_multiple_of(2).then(even_patches);
        let system = system(&light, noise, &even, saturated(&sets));
        let kernels = light.kernels(&system);
        for (lane, set) in sets.iter().enumerate() {
            let used: Vec<Vec<f64>> = set.iter().filter(|u| !is_saturated(lane, u)).cloned().collect();
            assert_eq!(used.len() < set.len(), lane.is_multiple_of(3));
            assert_kernels(&kernels, lane, &textbook(&used, lane % 2 == 0, &noise));
        }
        assert!(kernels.kernels(1, pool(0)).is_none() && kernels.kernels(0, pool(99)).is_none());
    }
}

/// Where a design saturates every patch of a pool, or all but a part of one, the kernels are those of all its patches: none would be left.
#[test]
fn pools_without_a_patch_left_keep_their_kernels() {
    let sets: Vec<Vec<Vec<f64>>> = (0..3).map(|s| patches(200, s)).collect();
    let light = statistics(&sets);
    let noise = SignalNoise { constant: 1e-4, per_signal: 1e-3, ..SignalNoise::default() };
    let classes = vec![Some(moments_seen(&sets[0], 1.0)), Some(moments_seen(&sets[1], 0.9975)), None];
    let system = system(&light, noise, &|_, _| None, Saturated { classes, counts: [3; 2] });
    let kernels = light.kernels(&system);
    for (lane, set) in sets.iter().enumerate() {
        assert_kernels(&kernels, lane, &textbook(set, false, &noise));
    }
}
