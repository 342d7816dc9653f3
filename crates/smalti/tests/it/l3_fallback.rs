//! Training where patches are missing: fallbacks, smoothing, rare saturations, and what cannot be learned.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use proptest::prelude::*;
use smalti::l3::{
    Axes, ClassKey, KernelForm, L3Error, Moments, Origin, Pipeline, Solver, Statistics, Textures, Training,
};
use smalti::numeric::philox::Stream;

use crate::l3_training::{
    NONE, SOME, bayer, levels, moments_of, names, one_channel, perceptual, solve, statistics_of, with,
};

/// Patches of 3 × 3 whose target is a multiple of the central sample.
fn multiple(factor: f64, count: usize, seed: u64) -> Moments {
    let mut random = Stream::new(seed, 3, 3);
    let mut patches = Vec::new();
    for _ in 0..count {
        let x: Vec<f64> = (0..9).map(|_| random.uniform()).collect();
        let y = factor * x[4];
        patches.push([vec![1.0], x, vec![y]].concat());
    }
    moments_of(9, 1, &patches)
}

fn key(saturation: u32, level: u16, texture: u16) -> ClassKey {
    ClassKey { position: 0, saturation, level, texture }
}

#[test]
fn missing_classes_fall_back_in_order() {
    // Middles of levels: 0.05, √0.02, √0.08, 0.6.
    let axes = Axes::new(one_channel(), 3, levels(&[0.1, 0.2, 0.4]), NONE).unwrap();
    let training = Training { least_patches: Some(50), saturation_share: 0.0, ..with(Solver::LeastSquares) };
    let class = |p: &Pipeline, s: usize, l: usize, t: usize| {
        let at = p.index(0, s, l, t);
        (p.classes()[at].origin, f64::from(p.weights(at, 0).unwrap()[4]))
    };
    let near = |got: (Origin, f64), origin: Origin, factor: f64| {
        assert!(got.0 == origin && (got.1 - factor).abs() < 1e-5, "{got:?}, expected {origin:?} {factor}");
    };
    let classes = BTreeMap::from([
        (key(0, 0, 0), multiple(1.0, 60, 1)),
        (key(0, 1, 0), multiple(9.0, 49, 2)),
        (key(0, 2, 0), multiple(3.0, 60, 3)),
        (key(0, 2, 1), multiple(3.0, 10, 4)),
        (key(1, 1, 1), multiple(9.0, 1, 5)),
    ]);
    let p = solve(&training, &statistics_of(&axes, &["Y"], false, classes));
    near(class(&p, 0, 0, 0), Origin::Learned, 1.0);
    let share = (0.02f64.sqrt() / 0.05).ln() / (0.08f64.sqrt() / 0.05).ln();
    near(class(&p, 0, 1, 0), Origin::Interpolated, 1.0 + 2.0 * share);
    near(class(&p, 0, 0, 1), Origin::PooledTextures, 1.0);
    near(class(&p, 0, 2, 1), Origin::PooledTextures, 3.0);
    // 49 flat patches and one of texture that clips.
    near(class(&p, 0, 1, 1), Origin::PooledSaturations, 9.0);
    near(class(&p, 1, 2, 0), Origin::PooledSaturations, 3.0);
    near(class(&p, 0, 3, 0), Origin::NearestLevel, 3.0);
    let few = BTreeMap::from([(key(0, 1, 0), multiple(2.0, 20, 6))]);
    let p = solve(&training, &statistics_of(&axes, &["Y"], false, few));
    near(class(&p, 0, 3, 1), Origin::PooledLevels, 2.0);
    assert_eq!(p.classes()[p.index(0, 0, 1, 0)].count, 20);
    let summary = p.summary();
    assert_eq!((summary.occupied, summary.operators, summary.classes, summary.patches), (1, 1, 8, 20));
    assert_eq!(summary.positions[0].by_origin, [0, 0, 0, 0, 0, 8]);
    assert_eq!(summary.positions[0].channel, "c0");
}

#[test]
fn neighbouring_levels_are_mixed_by_their_patches() {
    let axes = Axes::new(one_channel(), 3, levels(&[0.1, 0.2, 0.4]), NONE).unwrap();
    let axes = axes.with_textures(Textures::None);
    let classes = BTreeMap::from([
        (key(0, 0, 0), multiple(1.0, 100, 1)),
        (key(0, 1, 0), multiple(2.0, 200, 2)),
        (key(0, 2, 0), multiple(4.0, 300, 3)),
    ]);
    let s = statistics_of(&axes, &["Y"], false, classes);
    let training = Training { smoothing: 0.5, ..with(Solver::LeastSquares) };
    let p = solve(&training, &s);
    let expected = [
        (100.0 + 100.0 * 2.0) / 200.0,
        (50.0 + 200.0 * 2.0 + 150.0 * 4.0) / 400.0,
        (100.0 * 2.0 + 300.0 * 4.0) / 400.0,
    ];
    for (level, want) in expected.into_iter().enumerate() {
        let got = f64::from(p.weights(level, 0).unwrap()[4]);
        assert!((got - want).abs() < 1e-5, "level {level}: {got}, expected {want}");
    }
}

#[test]
fn rare_saturations_count_to_the_nearest() {
    let axes = Axes::new(bayer(), 3, levels(&[]), NONE).unwrap().with_textures(Textures::None);
    let at = |position, saturation| ClassKey { position, saturation, level: 0, texture: 0 };
    let mut classes = BTreeMap::new();
    for position in 0..4 {
        classes.insert(at(position, 0b000), multiple(1.0, 900, 1));
        classes.insert(at(position, 0b010), multiple(1.0, 300, 2));
        classes.insert(at(position, 0b011), multiple(1.0, 3, 3));
        classes.insert(at(position, 0b101), multiple(1.0, 2, 4));
    }
    let s = statistics_of(&axes, &["Y"], false, classes);
    let p = solve(&Training { saturation_share: 0.01, ..with(Solver::LeastSquares) }, &s);
    assert_eq!(p.saturations(), [0b000, 0b010]);
    let counts: Vec<u64> = p.classes()[..2].iter().map(|c| c.count).collect();
    // 011 differs from 010 in one channel; 101 from 000 in two and from 010 in three.
    assert_eq!(counts, [902, 303]);
    assert_eq!((p.saturation_place(0b011), p.saturation_place(0b101)), (1, 0));
    let all = solve(&Training { saturation_share: 0.0, ..with(Solver::LeastSquares) }, &s);
    assert_eq!(all.saturations(), [0b000, 0b010, 0b011, 0b101]);
}

#[test]
fn what_cannot_be_learned_is_said() {
    let axes = Axes::new(bayer(), 3, levels(&[0.5]), NONE).unwrap();
    let empty = Statistics::new(axes.clone(), names(&["Y"]), false).unwrap();
    let solve = |training: Training, s: &Statistics| training.solve(s, String::new());
    assert_eq!(solve(Training::default(), &empty), Err(L3Error::Empty(3)));
    let seen = |positions: &[u32]| {
        let at = |&position: &u32| (ClassKey { position, ..key(0, 0, 0) }, multiple(1.0, 300, 1));
        statistics_of(&axes, &["Y"], false, positions.iter().map(at).collect())
    };
    // One green teaches the other, by symmetry only.
    assert!(solve(Training::default(), &seen(&[0, 2, 3])).is_ok());
    let plain = Training { symmetry: false, ..Training::default() };
    assert_eq!(solve(plain.clone(), &seen(&[0, 2, 3])), Err(L3Error::UnseenPosition { row: 0, col: 1 }));
    assert_eq!(solve(Training::default(), &seen(&[0, 1])), Err(L3Error::UnseenPosition { row: 1, col: 1 }));
    let s = seen(&[0, 1, 2, 3]);
    let bad = [
        Training { smoothing: 1.5, ..plain.clone() },
        Training { smoothing: f64::NAN, ..plain.clone() },
        Training { saturation_share: -0.1, ..plain.clone() },
        perceptual(f64::INFINITY, 1.0),
        perceptual(1.0, -1.0),
    ];
    for training in bad {
        assert!(matches!(solve(training.clone(), &s), Err(L3Error::Parameter { .. })), "{training:?}");
    }
    // Numbers beyond single precision, and sums that no patches can have.
    let huge =
        BTreeMap::from([(key(0, 0, 0), moments_of(9, 1, &vec![[vec![1.0], vec![1e150; 10]].concat(); 3]))]);
    let axes = Axes::new(one_channel(), 3, levels(&[]), NONE).unwrap();
    assert!(solve(plain.clone(), &statistics_of(&axes, &["Y"], false, huge)).is_err());
    let sums = (0..66).map(|i| if i == 0 { 5.0 } else { -1e3 * f64::from(i) }).collect();
    let wrong = BTreeMap::from([(key(0, 0, 0), Moments::from_sums(9, 1, sums).unwrap())]);
    let s = statistics_of(&axes, &["Y"], false, wrong);
    for solver in [Solver::LeastSquares, Solver::Ridge, Solver::Wiener, Solver::default()] {
        if let Ok(p) = solve(with(solver), &s) {
            assert!(p.kernels().weights.iter().all(|w| w.is_finite()));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever has been seen, every class has finite kernels, or the position without any patch is named.
    #[test]
    fn there_is_never_a_hole(
        seen in proptest::collection::vec((0u32..4, 0u32..8, 0u16..5, 0u16..6, 1usize..60), 1..25),
        (textures, cuts) in (0usize..3, 0usize..5),
        (solver, linear, symmetry, noisy) in (0usize..4, any::<bool>(), any::<bool>(), any::<bool>()),
        (least, smoothing, share) in (1u64..100, 0.0..1.0f64, 0.0..0.2f64),
        quiet in any::<bool>(),
    ) {
        let textures = [Textures::None, Textures::FlatTexture, Textures::Oriented][textures];
        let cuts: Vec<f32> = (0..cuts).map(|i| 0.02 * 3f32.powi(i as i32)).collect();
        let noise = if quiet { NONE } else { SOME };
        let axes = Axes::new(bayer(), 3, levels(&cuts), noise).unwrap().with_textures(textures);
        let mut classes: BTreeMap<ClassKey, Moments> = BTreeMap::new();
        for (i, (position, saturation, level, texture, count)) in seen.into_iter().enumerate() {
            let level = level % axes.level_count() as u16;
            let texture = texture % textures.count() as u16;
            let at = ClassKey { position, saturation, level, texture };
            // Every third is of equal patches.
            let moments = if i % 3 == 0 {
                moments_of(9, 1, &vec![vec![1.0, 0.4, 0.2, 0.4, 0.3, 0.1, 0.3, 0.4, 0.2, 0.4, 0.7]; count])
            } else {
                multiple(0.5, count, i as u64)
            };
            classes.entry(at).or_insert_with(|| Moments::new(9, 1)).merge(&moments);
        }
        let s = statistics_of(&axes, &["Y"], noisy, classes);
        let training = Training {
            solver: [Solver::LeastSquares, Solver::Ridge, Solver::Wiener, Solver::default()][solver],
            kernel: if linear { KernelForm::Linear } else { KernelForm::Affine },
            symmetry,
            least_patches: Some(least),
            saturation_share: share,
            smoothing,
            ..Training::default()
        };
        let positions: std::collections::BTreeSet<u32> = s.classes().keys().map(|k| k.position).collect();
        let has = |p: u32| positions.contains(&p) || (symmetry && (p == 1 || p == 2) && positions.contains(&(3 - p)));
        match training.solve(&s, String::new()) {
            Ok(p) => {
                prop_assert!((0..4).all(has));
                prop_assert!(p.kernels().weights.iter().chain(&p.kernels().offsets).all(|v| v.is_finite()));
                prop_assert_eq!(p.summary().patches, s.count());
                if !symmetry {
                    for class in p.classes() {
                        prop_assert_eq!(class.origin == Origin::Learned, class.count >= least);
                    }
                }
            }
            Err(e) => {
                let named = matches!(e, L3Error::UnseenPosition { row, col } if !has((row * 2 + col) as u32));
                prop_assert!(named, "{}", e);
            }
        }
    }
}
