mod highlights;
mod products;
mod tile_pattern;

use super::classes::{Scratch, classify};
use super::stages::{FINE, Stages};
use super::*;
use crate::l3::blocks::LANES;
use crate::l3::{L3Error, Levels};
use crate::numeric::Planes;
use crate::numeric::arithmetic::digest;
use crate::numeric::philox::Stream;
use crate::numeric::simd::{Set, with_widest};

/// Standard deviation of the noise of a sample at Y = 0.
const SIGMA: f32 = 0.02;

fn axes() -> RefinementAxes {
    let levels = Levels::logarithmic(6, 0.02, 0.8).unwrap();
    RefinementAxes::new(levels, [SIGMA * SIGMA, 1e-4, 0.0]).unwrap()
}

fn planes(rows: usize, cols: usize, value: impl Fn(usize, usize, usize) -> f32) -> Planes {
    let at = |i: usize| value(i / (rows * cols), i / cols % rows, i % cols);
    Planes::new(rows, cols, 3, (0..3 * rows * cols).map(at).collect()).unwrap()
}

/// Tiles of random colours, each on a square of `side` pixels.
fn tiles(rows: usize, cols: usize, side: usize, seed: u64) -> Planes {
    let colour = |p: usize, r: usize, c: usize| {
        let cell = (r / side * 1000 + c / side) as u32;
        let mut random = Stream::new(seed, cell, 3);
        let light = 0.05 + 0.6 * random.uniform();
        (light * (0.8 + 0.4 * Stream::new(seed, cell, 4 + p as u32).uniform())) as f32
    };
    planes(rows, cols, colour)
}

/// The same less dark, so that no contrast is that of a highlight.
fn lifted(picture: &Planes) -> Planes {
    let data = picture.data().iter().map(|v| 0.3 + v).collect();
    Planes::new(picture.rows(), picture.cols(), 3, data).unwrap()
}

/// A picture with independent noise, nearly normal, of a standard deviation of [`SIGMA`].
fn noisy(picture: &Planes, seed: u64) -> Planes {
    let mut random = Stream::new(seed, 9, 9);
    let mut noise = || ((0..12).map(|_| random.uniform()).sum::<f64>() - 6.0) as f32 * SIGMA;
    let data = picture.data().iter().map(|v| v + noise()).collect();
    Planes::new(picture.rows(), picture.cols(), 3, data).unwrap()
}

fn mean_square(a: &Planes, b: &Planes) -> f64 {
    let squares: f64 = a.data().iter().zip(b.data()).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    squares / a.data().len() as f64
}

fn learned(seeds: std::ops::Range<u64>) -> RefinementStatistics {
    let mut statistics = RefinementStatistics::new(axes());
    for seed in seeds {
        let target = tiles(160, 170, 20 + seed as usize, seed);
        statistics.add(&noisy(&target, seed), &target, 1).unwrap();
    }
    statistics
}

#[test]
fn smoothing_removes_noise_and_keeps_edges() {
    let edge = planes(96, 96, |_, _, c| if c < 48 { 0.1 } else { 0.6 });
    let stages = Stages::of(&noisy(&edge, 5), axes().noise());
    // Columns 47 and 48 are on both sides of the edge, and those before and after it in a coarse picture.
    let variance = |stage: usize| {
        let side = if stage > FINE { 48 } else { 96 };
        let mut sum = 0.0;
        for r in 0..side {
            let picture = stage.checked_sub(1).map_or(stages.picture(), |scale| stages.smooth(scale));
            let line = &picture.line(1, r as isize)[super::stages::MARGIN..][..side];
            sum += line
                .iter()
                .enumerate()
                .map(|(c, v)| (v - if c < side / 2 { 0.1 } else { 0.6 }).powi(2))
                .sum::<f32>();
        }
        f64::from(sum) / (side * side) as f64
    };
    let before = f64::from(SIGMA * SIGMA);
    assert!((variance(0) / before - 1.0).abs() < 0.05, "{}", variance(0) / before);
    // A binomial filter of 3 × 3 leaves (3/8)² = 0.14 of the variance.
    assert!((0.13..0.25).contains(&(variance(1) / before)), "{}", variance(1) / before);
    assert!(variance(5) < 0.02 * before, "{}", variance(5) / before);
}

#[test]
fn a_uniform_picture_is_one_class_and_stays_uniform() {
    let refinement = learned(1..7).solve([1, 1]).unwrap();
    for value in [0.0, 0.01, 0.1, 0.5, 1.2] {
        let mut picture = planes(40, 50, |p, _, _| value * (0.9 + 0.1 * p as f32));
        refinement.apply(&mut picture, None).unwrap();
        for plane in picture.planes() {
            assert!(plane.iter().all(|v| *v == plane[0]), "{value}");
        }
    }
}

#[test]
fn edges_are_told_by_orientation_and_strength() {
    let class_by = |axes: &RefinementAxes, picture: &Planes, at: [usize; 2]| {
        let (mut scratch, mut classes) = (Scratch::default(), Vec::new());
        let stages = Stages::of(picture, axes.noise());
        classify(axes, stages.smooth(0), 0..picture.rows(), picture.cols(), &mut scratch, &mut classes);
        let row = picture.cols().next_multiple_of(LANES);
        axes.structure_name(classes[at[0] * row + at[1]] as usize % axes.structures())
    };
    let class = |picture: &Planes, at: [usize; 2]| class_by(&axes(), picture, at);
    let step = |height: f32, side: fn(usize, usize) -> bool| {
        planes(40, 40, move |_, r, c| if side(r, c) { 0.2 } else { 0.2 + height })
    };
    assert_eq!(class(&step(0.0, |_, c| c < 20), [20, 20]), "flat");
    assert_eq!(class(&step(0.5, |_, c| c < 20), [20, 20]), "edge 0°, strength 6");
    assert_eq!(class(&step(0.5, |r, _| r < 20), [20, 20]), "edge 90°, strength 6");
    assert_eq!(class(&step(0.5, |r, c| r + c < 40), [20, 20]), "edge 45°, strength 6");
    assert_eq!(class(&step(0.5, |r, c| r < c), [20, 20]), "edge 135°, strength 6");
    // Half a column for each row: across 26.6° from the columns, to the left and to the right.
    assert_eq!(class(&step(0.5, |r, c| 2 * c + r < 60), [20, 20]), "edge 22.5°, strength 6");
    assert_eq!(class(&step(0.5, |r, c| 2 * c < 20 + r), [20, 20]), "edge 157.5°, strength 6");
    assert_eq!(class(&step(0.5, |r, c| c + 2 * r < 60), [20, 20]), "edge 67.5°, strength 6");
    assert_eq!(class(&step(0.5, |_, c| c < 20), [20, 10]), "flat");
    // The structures of version 2.
    let earlier = axes().with_structures(vec![0.02, 0.1, 0.5], 4).unwrap();
    assert_eq!(earlier.structures(), 16);
    assert_eq!(class_by(&earlier, &step(0.5, |r, c| r + c < 40), [20, 20]), "edge 45°, strength 3");
    // Fainter than the noise.
    assert_eq!(class(&step(0.004, |_, c| c < 20), [20, 20]), "flat");
}

#[test]
fn a_learned_stage_reduces_the_error_of_unseen_pictures() {
    let refinement = learned(1..9).solve([1, 1]).unwrap();
    let target = tiles(120, 130, 24, 100);
    let picture = noisy(&target, 101);
    let mut refined = picture.clone();
    refinement.apply(&mut refined, None).unwrap();
    let gain = mean_square(&picture, &target) / mean_square(&refined, &target);
    assert!(gain > 10.0, "{gain}");
}

#[test]
fn any_number_of_threads_and_any_instruction_set_give_the_same_bits() {
    let statistics = learned(1..4);
    let refinement = statistics.solve([1, 1]).unwrap();
    let picture = noisy(&tiles(70, 83, 9, 3), 4);
    let render = || {
        let mut refined = picture.clone();
        refinement.apply(&mut refined, None).unwrap();
        refined
    };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let expected = render();
    assert_eq!(one.install(render), expected);
    assert_eq!(one.install(|| learned(1..4)), statistics);
    for set in [Set::Plain, Set::Avx2] {
        assert_eq!(with_widest(set, render), expected, "{set:?}");
        assert_eq!(with_widest(set, || learned(1..4)), statistics, "{set:?}");
    }
    // Every machine gives the same bits: the digest was recorded when this test was written.
    let digest = digest(expected.data().iter().map(|v| u64::from(v.to_bits())));
    assert_eq!(digest, 0x9965_8d98_f277_d92e, "{digest:#x}");
}

#[test]
fn parts_merge_to_the_whole() {
    let (mut parts, whole) = (learned(1..3), learned(1..5));
    parts.merge(&learned(3..5)).unwrap();
    assert_eq!(parts.count(), whole.count());
    let (a, b) = (parts.solve([1, 1]).unwrap(), whole.solve([1, 1]).unwrap());
    let far = a.weights().zip(b.weights()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(far < 1e-4, "{far}");
    let other = RefinementAxes::new(Levels::logarithmic(5, 0.02, 0.8).unwrap(), axes().noise()).unwrap();
    let error = parts.merge(&RefinementStatistics::new(other)).unwrap_err();
    assert_eq!(error, L3Error::Mismatch("levels or noise of the second stage"));
}

#[test]
fn without_enough_pixels_a_picture_stays_as_it_is() {
    let mut statistics = RefinementStatistics::new(axes());
    let target = tiles(12, 12, 4, 1);
    statistics.add(&noisy(&target, 1), &target, 1).unwrap();
    let refinement = statistics.solve([1, 1]).unwrap();
    assert!(refinement.classes().iter().all(|c| !c.is_learned));
    let picture = lifted(&noisy(&target, 2));
    let mut refined = picture.clone();
    refinement.apply(&mut refined, None).unwrap();
    assert_eq!(refined, picture);
}

#[test]
fn what_cannot_be_refined_is_refused() {
    let mut statistics = RefinementStatistics::new(axes());
    let good = planes(8, 9, |_, _, _| 0.5);
    let two = Planes::zeros(8, 9, 2);
    assert_eq!(statistics.add(&two, &good, 1), Err(L3Error::Outputs { expected: 3, got: 2 }));
    let size = [8, 9];
    let smaller = planes(8, 8, |_, _, _| 0.5);
    let differ = L3Error::PairSize { what: "the target", size, got: [8, 8] };
    assert_eq!(statistics.add(&good, &smaller, 1), Err(differ));
    let bad = planes(8, 9, |p, r, c| if [p, r, c] == [1, 2, 3] { f32::INFINITY } else { 0.5 });
    match statistics.add(&good, &bad, 1) {
        Err(L3Error::Value { row: 2, col: 3, .. }) => {}
        other => panic!("{other:?}"),
    }
    assert_eq!(statistics.count(), 0);
    assert_eq!(statistics.solve([1, 1]).unwrap().apply(&mut two.clone(), None), Err(L3Error::NotAPicture(2)));
    for noise in [[0.0, 1e-4, 0.0], [1e-4, -1.0, 0.0], [1e-4, 0.0, f32::NAN]] {
        assert!(RefinementAxes::new(axes().levels().clone(), noise).is_err(), "{noise:?}");
    }
    assert!(Refinement::new(axes(), Vec::new(), Vec::new(), Vec::new()).is_err());
}

/// A picture of two strips has the same bits as a part across their border, which is one strip.
#[test]
fn strips_have_no_seams() {
    let refinement = learned(1..4).solve([1, 1]).unwrap();
    let (rows, cols) = (1060, 1000);
    let picture = noisy(&tiles(rows, cols, 31, 8), 9);
    let part = |planes: &Planes, from: std::ops::Range<usize>| {
        let lines = planes.planes().flat_map(|p| &p[from.start * cols..from.end * cols]);
        Planes::new(from.len(), cols, 3, lines.copied().collect()).unwrap()
    };
    let mut alone = part(&picture, 400..660);
    refinement.apply(&mut alone, None).unwrap();
    let mut whole = picture;
    refinement.apply(&mut whole, None).unwrap();
    assert_eq!(part(&whole, 440..620), part(&alone, 40..220));
}

/// A picture that counts three times is as good as the same picture three times.
#[test]
fn a_picture_may_count_several_times() {
    let target = tiles(90, 80, 20, 3);
    let picture = noisy(&target, 3);
    let (mut once, mut thrice) = (RefinementStatistics::new(axes()), RefinementStatistics::new(axes()));
    once.add(&picture, &target, 3).unwrap();
    (0..3).for_each(|_| thrice.add(&picture, &target, 1).unwrap());
    assert_eq!(once.count(), 3 * 90 * 80);
    assert_eq!(once.count(), thrice.count());
    let (once, thrice) = (once.solve([1, 1]).unwrap(), thrice.solve([1, 1]).unwrap());
    let far = once.weights().zip(thrice.weights()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(far < 1e-4, "{far}");
}

/// The second stage in integers gives the picture that single precision gives, to 75 dB of its peak, and is as near to the target.
#[test]
fn integers_refine_as_single_precision_does() {
    let refinement = learned(1..9).solve([1, 1]).unwrap();
    let fixed = refinement.fixed().unwrap();
    for (light, seed) in [(1.0, 100), (0.1, 102)] {
        let scaled = |planes: Planes| {
            let data = planes.data().iter().map(|v| v * light).collect();
            Planes::new(planes.rows(), planes.cols(), 3, data).unwrap()
        };
        let target = scaled(tiles(121, 130, 24, seed));
        let picture = noisy(&target, seed + 1);
        let (mut float, mut integers) = (picture.clone(), picture);
        refinement.apply(&mut float, None).unwrap();
        fixed.apply_to(&mut integers, None).unwrap();
        let db = crate::l3::peak_ratio_db(&float, &integers).unwrap();
        let loss = 10.0 * (mean_square(&integers, &target) / mean_square(&float, &target)).log10();
        println!("light {light}: {db:.1} dB, a loss of {loss:.4} dB");
        assert!(db > 75.0, "{db}");
        assert!(loss < 0.02, "{loss}");
    }
}

/// Whatever a picture holds, no number overflows (the profile of tests checks), and what is uniform stays so. Values saturate at 8 times white.
#[test]
fn integers_saturate_and_do_not_overflow() {
    let fixed = learned(1..4).solve([1, 1]).unwrap().fixed().unwrap();
    let (rows, cols) = (37, 41);
    let mut random = Stream::new(5, 5, 5);
    let extreme = |random: &mut Stream| match random.next_u32() % 4 {
        0 => i32::MIN,
        1 => i32::MAX,
        2 => 0,
        _ => random.next_u32() as i32 >> 9,
    };
    let mut picture: Vec<i32> = (0..3 * rows * cols).map(|_| extreme(&mut random)).collect();
    fixed.apply(&mut picture, rows, cols, None).unwrap();
    assert!(picture.iter().all(|v| v.abs() <= FixedRefinement::MOST));
    for value in [0, 9_000, 1 << FixedRefinement::PLACES, i32::MAX] {
        let mut uniform = vec![value; 3 * rows * cols];
        fixed.apply(&mut uniform, rows, cols, None).unwrap();
        for plane in uniform.chunks(rows * cols) {
            assert!(plane.iter().all(|v| *v == plane[0]), "{value}");
        }
    }
}

#[test]
fn what_has_no_place_in_integers_is_refused() {
    let with = |axes: RefinementAxes, weight: f32, offset: f32| {
        let count = axes.count();
        let class = RefinementClass { count: 0, is_learned: false };
        let weights = vec![weight; count * 3 * REFINEMENT_INPUTS];
        let stage = Refinement::new(axes, vec![class; count], weights, vec![offset; count * 3]).unwrap();
        stage.fixed().map_err(|e| e.to_string())
    };
    assert!(with(axes(), 1.0, 0.1).is_ok());
    assert!(with(axes(), 4e4, 0.1).unwrap_err().contains("a weight"));
    assert!(with(axes(), 1.0, 1e20).unwrap_err().contains("an offset"));
    let strong = axes().with_structures(vec![0.02, 7e4], 8).unwrap();
    assert!(with(strong, 1.0, 0.0).unwrap_err().contains("a strength"));
    let loud = RefinementAxes::new(axes().levels().clone(), [10.0, 0.0, 0.0]).unwrap();
    assert!(with(loud, 1.0, 0.0).unwrap_err().contains("the noise"));
}

/// The multiply-adds of the kernels are those of the inputs, and fifteen for the roots; a smooth picture reads eight neighbours of three colours.
#[test]
fn multiply_adds_follow_from_the_sizes_of_kernels() {
    let [smooth, _, kernels, _] = multiply_adds(&axes());
    assert_eq!(kernels, (3 * REFINEMENT_INPUTS + 15) as f64);
    // Three pictures of every pixel and two of every fourth: of nine pixels three products with a weight, of eight three squares and two for
    // the weight, and eight of the centre.
    assert_eq!(smooth, (3.0 + 2.0 / 4.0) * (9.0 * 3.0 + 8.0 * 5.0 + 8.0));
}

/// A kernel that picks one input gives what training reads for it, at every pixel.
#[test]
fn rendering_and_training_read_the_same_inputs() {
    let axes = axes().with_structures(vec![0.5], 4).unwrap();
    let picture = lifted(&noisy(&tiles(19, 37, 6, 8), 3));
    let stages = Stages::of(&picture, axes.noise());
    let classes = vec![RefinementClass { count: 1, is_learned: true }; axes.count()];
    for input in 0..REFINEMENT_INPUTS {
        let mut weights = vec![0.0; axes.count() * 3 * REFINEMENT_INPUTS];
        weights.iter_mut().skip(input).step_by(REFINEMENT_INPUTS).for_each(|w| *w = 1.0);
        let offsets = vec![0.0; axes.count() * 3];
        let picks = Refinement::new(axes.clone(), classes.clone(), weights, offsets).unwrap();
        let mut found = picture.clone();
        picks.apply(&mut found, None).unwrap();
        let mut read = [0.0; REFINEMENT_INPUTS];
        for (pixel, value) in found.data().iter().enumerate().take(19 * 37) {
            super::inputs::Lines::of(&stages, pixel / 37).read(pixel % 37, &mut read);
            assert_eq!(value.to_bits(), (read[input] + 0.0).to_bits(), "input {input}, pixel {pixel}");
        }
    }
}

#[test]
fn roots_scale_with_the_light_in_both_arithmetics() {
    let colours = [[0.3, 0.2, 0.05], [0.0, 0.0, 0.0], [-0.1, 0.02, 0.4], [0.95, 1.0, 1.09]];
    for [x, y, z] in colours {
        let own = super::roots::roots(x, y, z);
        let doubled = super::roots::roots(2.0 * x, 2.0 * y, 2.0 * z);
        assert!(own.iter().zip(doubled).all(|(a, b)| (2.0 * a - b).abs() < 1e-6), "{own:?} {doubled:?}");
    }
    // In integers they are rounded.
    for colour in colours {
        let whole = colour.map(|v| (f64::from(v) * f64::from(1u32 << 20)).round() as i32);
        let float = super::roots::roots(colour[0], colour[1], colour[2]);
        for (whole, float) in
            super::roots::fixed_roots(&super::roots::fixed_rgb_from_xyz(), whole).into_iter().zip(float)
        {
            let error = f64::from(whole) / f64::from(1u32 << 20) - f64::from(float);
            assert!(error.abs() < 3e-6, "{colour:?}: {error}");
        }
    }
    // The coefficients that docs/formats-l3.md states.
    let stated = [
        [1.716_651_2, -0.355_670_78, -0.253_366_3],
        [-0.666_684_3, 1.616_481_2, 0.015_768_547],
        [0.017_639_857, -0.042_770_613, 0.942_103_15],
    ];
    assert_eq!(REFINEMENT_RGB_FROM_XYZ, stated);
    // White of D65 is grey, of which every root is the luminance.
    let white = super::roots::roots(0.950_456, 1.0, 1.089_058);
    assert!(white.iter().all(|v| (v - 1.0).abs() < 1e-3), "{white:?}");
}

/// A colour error that no matrix corrects: the second stage learns it, and corrects colours at light that it has not seen.
#[test]
fn colours_are_corrected_beyond_a_matrix() {
    let bent = |picture: &Planes| {
        let [x, y, z] = [0, 1, 2].map(|i| picture.plane(i).unwrap());
        let bend = |i: usize| (super::roots::roots(x[i], y[i], z[i])[0] - y[i]) * 0.3;
        let data = [x, y, z].into_iter().flat_map(|p| p.iter().enumerate().map(|(i, v)| v + bend(i)));
        Planes::new(picture.rows(), picture.cols(), 3, data.collect()).unwrap()
    };
    let mut statistics = RefinementStatistics::new(axes());
    for seed in 1..7 {
        let target = tiles(160, 170, 24, seed);
        statistics.add(&bent(&target), &target, 1).unwrap();
    }
    let refinement = statistics.solve([1, 1]).unwrap();
    let target = tiles(96, 96, 24, 99);
    let mut picture = bent(&target);
    let before = mean_square(&picture, &target);
    refinement.apply(&mut picture, None).unwrap();
    let after = mean_square(&picture, &target);
    assert!(after < 0.05 * before, "{after} {before}");
}

/// Axes of version 2 state neither strengths nor orientations.
#[test]
fn axes_of_version_2_are_read() {
    let earlier = axes().with_structures(vec![0.02, 0.1, 0.5], 4).unwrap();
    let mut stated = serde_json::to_value(&earlier).unwrap();
    let read = |stated: &serde_json::Value| serde_json::from_value::<RefinementAxes>(stated.clone());
    assert_eq!(read(&stated).unwrap(), earlier);
    let fields = stated.as_object_mut().unwrap();
    fields.remove("strengths").unwrap();
    fields.remove("orientations").unwrap();
    assert_eq!(read(&stated).unwrap(), earlier);
    // What is stated holds, and is checked.
    assert_eq!(read(&serde_json::to_value(axes()).unwrap()).unwrap(), axes());
    for strengths in [vec![-1.0], vec![0.0], vec![0.5, 0.5], vec![], vec![1e7]] {
        stated["strengths"] = strengths.clone().into();
        assert!(read(&stated).is_err(), "{strengths:?}");
    }
    assert!(axes().with_structures(vec![0.5], 6).is_err());
}

/// Where the noise is in proportion to the light, structures do not depend on the light, and noise is no strong structure.
#[test]
fn structures_are_told_by_the_noise_of_their_light() {
    let levels = Levels::logarithmic(6, 0.02, 0.8).unwrap();
    let axes = RefinementAxes::new(levels, [1e-18, 0.0, 1e-4]).unwrap();
    let structures = |light: f32| {
        let value = |_: usize, r: usize, c: usize| {
            let random = Stream::new(3, (r * 40 + c) as u32, 8).uniform() as f32 - 0.5;
            // A standard deviation of 1 %.
            light * (1.0 + 0.01 * 12f32.sqrt() * random)
        };
        let (mut scratch, mut classes) = (Scratch::default(), Vec::new());
        let stages = Stages::of(&planes(24, 40, value), axes.noise());
        classify(&axes, stages.picture(), 0..24, 40, &mut scratch, &mut classes);
        let rows = classes.chunks_exact(40usize.next_multiple_of(LANES));
        let seen = rows.flat_map(|row| row[..40].iter().map(|class| *class as usize % axes.structures()));
        seen.collect::<Vec<_>>()
    };
    let found = structures(0.25);
    // The trace has the mean of one variance; strength 6 begins at 62.5 of them.
    let strong = 1 + 5 * (1 + axes.orientations());
    assert!(found.iter().all(|structure| (1..strong).contains(structure)));
    for light in [0.0625, 0.5, 1.0] {
        assert_eq!(structures(light), found, "{light}");
    }
}

/// Columns that are all alike are smoothed as a single one is.
#[test]
fn a_single_column_is_smoothed_as_many_alike_are() {
    let picture = |cols: usize| {
        let value = |p: usize, r: usize, _: usize| Stream::new(4, r as u32, p as u32).uniform() as f32;
        Stages::of(&planes(40, cols, value), [0.1, 0.0, 0.0])
    };
    let (one, many) = (picture(1), picture(50));
    for scale in 0..super::stages::SCALES {
        let rows = if scale < FINE { 40 } else { 20 };
        for (plane, row) in (0..3).flat_map(|plane| (0..rows).map(move |row| (plane, row))) {
            let first = |stages: &Stages| stages.smooth(scale).line(plane, row)[super::stages::MARGIN];
            assert_eq!(first(&one), first(&many), "scale {scale}, row {row}");
            assert!(first(&one) > 0.0);
        }
    }
}
