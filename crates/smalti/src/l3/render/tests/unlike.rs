//! Fixed point where the kernels of classes are of unlike magnitudes.

use proptest::prelude::*;

use super::super::fixed::Entry;
use super::super::table::HIGH_PART;
use super::*;

const TAPS: usize = 25;

/// Factors from 1 to 2^-8 on the kernels of classes, in turn.
fn octave(class: usize) -> usize {
    class % 9
}

/// `pipeline` with its kernels times a factor for each class.
fn scaled(p: &Pipeline, factor: impl Fn(usize) -> f32) -> Pipeline {
    let (mut kernels, outputs) = (p.kernels().clone(), p.outputs().len());
    let taps = p.axes().taps();
    kernels.weights.iter_mut().enumerate().for_each(|(i, w)| *w *= factor(i / taps / outputs));
    kernels.offsets.iter_mut().enumerate().for_each(|(i, o)| *o *= factor(i / outputs));
    pipeline_with(p, [p.black_level(), p.white_level()], kernels)
}

#[test]
fn small_kernels_keep_their_precision_beside_large_ones() {
    let p = scaled(&pipeline(&bayer(), 5, 3), |class| 2.0 / (1 << octave(class)) as f32);
    let raw = raw(&bayer(), 120, 150);
    let reference = Reference::new(&p, &raw, [0, 0]);
    let renderer = p.fixed_renderer(BLACK, WHITE).unwrap();
    let float = p.render_raw(&raw).unwrap();
    let expected = reference.fixed(&renderer.kernels);
    for set in PATHS {
        let got = with_widest(set, || renderer.render(&raw)).unwrap();
        assert_same(&got, &expected, &format!("{set:?}"));
    }
    let octaves: Vec<usize> = (0..raw.rows() * raw.cols())
        .map(|i| octave(reference.class(i / raw.cols(), i % raw.cols(), &mut OutsideCounts::default())))
        .collect();
    for wanted in 0..9 {
        // Each as a picture of its own: against its own largest value.
        let only = |planes: &Planes| {
            let values = planes.data().iter().zip(octaves.iter().cycle());
            let values: Vec<f32> = values.filter(|(_, o)| **o == wanted).map(|(v, _)| *v).collect();
            Planes::new(1, values.len(), 1, values).unwrap()
        };
        let (float, fixed) = (only(&float.planes), only(&expected.planes));
        assert!(float.cols() > 500, "{} values of octave {wanted}", float.cols());
        let ratio = peak_ratio_db(&float, &fixed).unwrap();
        assert!(ratio > 70.0, "{ratio} dB of kernels times 2^-{wanted}");
    }
}

#[test]
fn classes_that_no_pixel_has_cost_no_precision() {
    let (alike, raw) = (pipeline(&bayer(), 5, 3), raw(&bayer(), 60, 70));
    let mut met = vec![false; alike.classes().len()];
    let reference = Reference::new(&alike, &raw, [0, 0]);
    for i in 0..60 * 70 {
        met[reference.class(i / 70, i % 70, &mut OutsideCounts::default())] = true;
    }
    assert!(met.contains(&false));
    let unlike = scaled(&alike, |class| if met[class] { 1.0 } else { 256.0 });
    assert_eq!(alike.render_fixed(&raw).unwrap(), unlike.render_fixed(&raw).unwrap());
}

/// 32768 Σ |weight| + |offset| of a kernel: the bound of its sum for any samples in any order.
fn most(weights: &[i16], offset: i32) -> i64 {
    let total: i64 = weights.iter().map(|w| i64::from(w.unsigned_abs())).sum();
    total * 32768 + i64::from(offset.unsigned_abs())
}

/// Bounds of every kernel; and of every class, that one more binary place would break them.
fn assert_bounds(p: &Pipeline, levels: [f64; 2]) {
    let kernels = p.fixed_kernels(levels[0], levels[1]).unwrap();
    let outputs = p.outputs().len();
    assert_eq!(kernels.shifts.len(), p.classes().len());
    for (class, &shift) in kernels.shifts.iter().enumerate() {
        let (mut room, mut total) = (0.0f64, 0);
        for i in class * outputs..(class + 1) * outputs {
            let (weights, offset) = (&kernels.weights[i * TAPS..][..TAPS], kernels.offsets[i]);
            assert!(most(weights, offset) < i64::from(i32::MAX), "class {class}");
            assert!(weights.iter().all(|w| *w > i16::MIN));
            let [high, low] = FixedKernels::parts(offset);
            assert_eq!(i32::from(high) * HIGH_PART + i32::from(low), offset);
            // Their products with what stands beyond the patch.
            assert!(
                (i64::from(high) * i64::from(HIGH_PART)).abs() + i64::from(low).abs() < i64::from(i32::MAX)
            );
            let largest = weights.iter().map(|w| f64::from(*w).abs()).fold(0.0, f64::max);
            total = total.max(most(weights, offset));
            room = room.max(largest / 32767.0).max(f64::from(offset).abs() / f64::from(1 << 29));
        }
        // Half a unit of each number is rounding.
        let full = room.max((total + 32768 * 13) as f64 / f64::from(i32::MAX)) * 2.0 + 2e-4 > 1.0;
        assert!(full || shift == 24, "class {class} has room left at {shift} places: {room} {total}");
        let scale = kernels.scale_of(class).unwrap();
        assert_eq!(f64::from(scale), f64::from(kernels.scale) * 0.5f64.powi(i32::from(shift)));
    }
    assert_eq!(kernels.scale_of(p.classes().len()), None);
}

#[test]
fn parts_make_the_offset_and_bad_levels_are_refused() {
    let [high, low] = FixedKernels::parts(-(1 << 28) - 12345);
    assert_eq!(i32::from(high) * HIGH_PART + i32::from(low), -(1 << 28) - 12345);
    let p = pipeline(&bayer(), 7, 3);
    for [black, white] in [[10.0, 10.0], [0.0, f64::NAN], [0.0, 1e-40], [-2e5, 0.0], [0.0, 2e5]] {
        assert!(p.fixed_kernels(black, white).is_err(), "{black} {white}");
    }
}

/// Samples at both ends, each where it adds to the sum: nothing but the bound of the weights keeps it within 32 bits.
#[test]
fn the_worst_samples_overflow_no_sum() {
    let p = pipeline(&bayer(), 5, 1);
    let mut random = Stream::new(9, 9, 9);
    let signs: Vec<f32> = (0..TAPS).map(|_| if random.uniform() < 0.5 { -1.0 } else { 1.0 }).collect();
    // Just below a power of two: nearly all of the bound is used.
    let weights = signs.iter().map(|s| s * 65_530.0 / 65_536.0 / TAPS as f32).collect::<Vec<_>>();
    let mut kernels = p.kernels().clone();
    kernels.weights = weights.repeat(p.classes().len());
    kernels.offsets.fill(0.0);
    let levels = [32_768.0, 65_535.0];
    let p = pipeline_with(&p, levels, kernels);
    assert_bounds(&p, levels);
    let samples: Vec<u16> = signs.iter().map(|s| if *s > 0.0 { u16::MAX } else { 0 }).collect();
    let raw = raw_of(&bayer(), 5, 5, RawSamples::Digital(samples), levels);
    let renderer = p.fixed_renderer(levels[0], levels[1]).unwrap();
    let expected = Reference::new(&p, &raw, [0, 0]).fixed(&renderer.kernels);
    // The pixel in the middle.
    let sum = f64::from(expected.planes.data()[12]) / f64::from(renderer.kernels.scale_of(0).unwrap());
    assert!(sum > 0.99 * f64::from(i32::MAX), "{sum}");
    for set in PATHS {
        let got = with_widest(set, || renderer.render(&raw)).unwrap();
        assert_same(&got, &expected, &format!("{set:?}"));
    }
}

#[test]
fn an_entry_holds_place_and_shift() {
    for (place, shift) in [(0, 0), (12, 24), ((1 << 27) - 1, 9)] {
        let entry = Entry::new(place, shift).unwrap();
        assert_eq!(entry.place(), place as usize);
        assert_eq!(entry.scale(0.75), 0.75 * 0.5f32.powi(i32::from(shift)));
    }
    assert!(Entry::new(1 << 27, 0).is_none());
    assert!(Entry::new(0, 25).is_none());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_kernels_keep_to_the_bounds(
        seed in any::<u64>(),
        levels in prop::sample::select(vec![[64.0, 4095.0], [512.4, 65535.0], [0.0, 255.0], [32768.0, 65535.0]]),
        even in 0.0f32..1.0,
    ) {
        let p = pipeline(&bayer(), 5, 2);
        let (mut kernels, mut random) = (p.kernels().clone(), Stream::new(seed, 3, 4));
        for (weights, offsets) in kernels.weights.chunks_mut(2 * TAPS).zip(kernels.offsets.chunks_mut(2)) {
            // From kernels that just fit to such as are nothing.
            let size = 2f32.powi((random.uniform() * 36.0) as i32 - 30);
            weights.iter_mut().for_each(|w| *w = size * (random.uniform() as f32 - even) * 50.0);
            offsets.iter_mut().for_each(|o| *o = size * (random.uniform() as f32 - 0.5) * 20.0);
        }
        assert_bounds(&pipeline_with(&p, levels, kernels), levels);
    }
}

/// The finer part is at most half a step of the coarser one, so that their magnitudes exceed that of the offset by less than a step.
#[test]
fn the_finer_part_of_an_offset_is_small() {
    for offset in (-(1 << 28)..1 << 28).step_by(4099) {
        let [high, low] = FixedKernels::parts(offset).map(i32::from);
        assert_eq!(high * HIGH_PART + low, offset);
        assert!(low.abs() <= HIGH_PART / 2, "{offset}: {high} {low}");
    }
}
