//! The correction beside highlights, on pictures that no kernel has changed.

use super::super::highlights::{CONTRASTS, REACH, correct};
use super::super::strips::each_strip;
use super::*;
use crate::l3::Axes;
use crate::numeric::mirror::about_outermost;
use crate::sensor::{Mosaic, RawImage, RawSamples, Sampling, SignalNoise};

const DARK: f32 = 0.001;
/// Levels of raw images, digital numbers, and the response from which they count as clipped.
const LEVELS: [f64; 2] = [100.0, 4100.0];
const CLIP: f64 = 0.9;

fn corrected(picture: &Planes) -> Planes {
    compared(picture, None)
}

fn compared(picture: &Planes, samples: Option<RefinementSamples<'_>>) -> Planes {
    let mut out = picture.clone();
    each_strip(&mut out, REACH, |strip| correct(strip, DARK, samples));
    out
}

/// A raw image of a mosaic, whose responses are rounded to digital numbers, and the axes of its tile.
fn seen(
    tile: [usize; 2],
    [rows, cols]: [usize; 2],
    response: impl Fn(usize, usize) -> f32,
) -> (RawImage, Axes) {
    let cells = (0..(tile[0] * tile[1]) as u8).collect();
    let mosaic = Mosaic::new(tile[0], tile[1], cells).unwrap();
    let names = (0..tile[0] * tile[1]).map(|i| format!("c{i}")).collect();
    let [black, white] = LEVELS;
    let sample =
        |i: usize| (f64::from(response(i / cols, i % cols)) * (white - black) + black).round() as u16;
    let samples = RawSamples::Digital((0..rows * cols).map(sample).collect());
    let sampling = Sampling::Mosaic(mosaic.clone());
    let raw = RawImage::new(rows, cols, samples, sampling, names, black, white).unwrap();
    let axes = Axes::new(mosaic, 3, axes().levels().clone(), SignalNoise::default()).unwrap();
    (raw, axes.with_clip(CLIP).unwrap())
}

/// The samples of a picture of lamps: some proportion of its Y that depends on the cell of the tile, and some light that the picture lacks.
fn seen_lamps(tile: [usize; 2], picture: &Planes) -> (RawImage, Axes) {
    let cols = picture.cols();
    seen(tile, [picture.rows(), cols], |r, c| {
        let y = picture.data()[(picture.rows() + r) * cols + c].max(0.0);
        let cell = (r % tile[0] * tile[1] + c % tile[1]) as f32;
        y * (0.3 + 0.2 * cell) + 0.01 * Stream::new(11, (r * cols + c) as u32, 1).uniform() as f32 - 0.003
    })
}

/// The definition, in double precision and pixel by pixel. Responses are those of the samples, and the tile is that of their mosaic.
fn definition(
    picture: &Planes,
    row: usize,
    col: usize,
    samples: Option<(&RawImage, [usize; 2])>,
) -> [f64; 3] {
    let at = |plane: usize, down: isize, right: isize| {
        let r = about_outermost(row as isize + down, picture.rows());
        let c = about_outermost(col as isize + right, picture.cols());
        f64::from(picture.data()[(plane * picture.rows() + r) * picture.cols() + c])
    };
    let around = || (-4..=4).flat_map(|r: isize| (-4..=4).map(move |c: isize| (r, c)));
    let fall = |d: isize| [1.0, 1.0, 1.0, 0.5, 0.25][d.unsigned_abs()];
    let rise = |d: isize| [1.0, 1.0, 1.0, 2.0, 4.0][d.unsigned_abs()];
    let brightest = around().map(|(r, c)| at(1, r, c).max(0.0) * fall(r) * fall(c)).fold(0.0, f64::max);
    let dark = |(r, c)| (at(1, r, c).max(0.0) + f64::from(DARK)) * rise(r) * rise(c);
    let darkest = around().map(dark).fold(f64::INFINITY, f64::min);
    let share = ((brightest / darkest - 16.0) / 16.0).clamp(0.0, 1.0);
    let binomial = |d: isize| [70.0, 56.0, 28.0, 8.0, 1.0][d.unsigned_abs()] / 256.0;
    let mean: f64 = around().map(|(r, c)| binomial(r) * binomial(c) * at(1, r, c).max(0.0)).sum();
    let weight = |(r, c)| {
        let most = (0..3).map(|plane| at(plane, r, c)).fold(0.0, f64::max);
        (1.0 - most).max(0.25).powi(4)
    };
    let sum = |plane| around().map(|(r, c)| weight((r, c)) * at(plane, r, c)).sum::<f64>();
    let least = f64::from(DARK) * around().map(weight).sum::<f64>();
    let least = least.max(sum(0) / 3.0).max(sum(2) / 16.0);
    let near: f64 = (-1..=1)
        .flat_map(|r: isize| (-1..=1).map(move |c: isize| (r, c)))
        .map(|(r, c)| f64::from(1 << (2 - r.abs() - c.abs())) / 16.0 * at(1, r, c).max(0.0))
        .sum();
    let floor = f64::max(near / 2.0, mean / 4.0);
    let mut light = at(1, 0, 0).max(floor);
    if let Some((raw, tile)) = samples.filter(|(_, tile)| tile.iter().any(|side| *side <= 4)) {
        let responses = raw.normalized();
        let response = |down: isize, right: isize| {
            let [r, c] = [row.checked_add_signed(down)?, col.checked_add_signed(right)?];
            let response = *responses.get(r * raw.cols() + c).filter(|_| c < raw.cols())?;
            (f64::from(response) < CLIP).then(|| f64::from(response).max(0.0))
        };
        let in_step = |at: isize, period: usize| at % period as isize == 0;
        let of_cell = around().filter(|&(r, c)| in_step(r, tile[0]) && in_step(c, tile[1]));
        let pairs = of_cell.filter_map(|(r, c)| Some((at(1, r, c).max(0.0), response(r, c)?)));
        let parts = pairs.map(|(y, response)| [y, response].map(|v| v / (y + response + f64::from(DARK))));
        let [lights, responses] = parts.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
        if let Some(own) = response(0, 0).filter(|_| responses > 0.0) {
            let given = (own * lights / responses).clamp(light / 2.0, 2.0 * light);
            light = floor.max((light + given) / 2.0);
        }
    }
    let ratio = |plane| sum(plane).max(0.0) / sum(1).max(least);
    let goal = [ratio(0) * light, light, ratio(2) * light];
    std::array::from_fn(|plane| at(plane, 0, 0) + share * (goal[plane] - at(plane, 0, 0)))
}

/// Dim colours with lamps, some of them on the border. Some dim values are negative.
fn lamps(rows: usize, cols: usize, seed: u64) -> Planes {
    let mut random = Stream::new(seed, 2, 2);
    let lit: Vec<f32> = (0..rows * cols)
        .map(|_| if random.uniform() < 0.02 { 0.5 + random.uniform() as f32 } else { 0.01 })
        .collect();
    planes(rows, cols, |p, r, c| {
        let colour = Stream::new(seed, (r * cols + c) as u32, 7 + p as u32).uniform() as f32;
        lit[r * cols + c] * (0.5 + colour) - 0.008
    })
}

#[test]
fn the_correction_is_its_definition() {
    for (rows, cols) in [(1, 1), (1, 9), (7, 1), (3, 4), (20, 21), (41, 130)] {
        let picture = lamps(rows, cols, (rows * cols) as u64);
        let without = corrected(&picture);
        for tile in
            [None, Some([1, 1]), Some([2, 2]), Some([3, 2]), Some([4, 4]), Some([5, 6]), Some([10, 2])]
        {
            let seen = tile.map(|tile| (seen_lamps(tile, &picture), tile));
            let samples = seen.as_ref().map(|((raw, axes), _)| RefinementSamples::of(raw, axes));
            let found = compared(&picture, samples);
            let (mut changed, mut differ) = (0, 0);
            let seen = seen.as_ref().map(|((raw, _), tile)| (raw, *tile));
            for (r, c) in (0..rows).flat_map(|r| (0..cols).map(move |c| (r, c))) {
                for (plane, expected) in definition(&picture, r, c, seen).into_iter().enumerate() {
                    let at = (plane * rows + r) * cols + c;
                    let far = (f64::from(found.data()[at]) - expected).abs();
                    assert!(
                        far < 1e-5 * (1.0 + expected.abs()),
                        "{rows} × {cols} {tile:?}: {r} {c} {plane}: {far}"
                    );
                    changed += usize::from(found.data()[at] != picture.data()[at]);
                    differ += usize::from(found.data()[at] != without.data()[at]);
                }
            }
            assert!(rows * cols < 400 || changed > rows * cols / 4, "{changed}");
            match tile {
                None | Some([5, 6]) => assert_eq!(differ, 0),
                _ => assert!(rows * cols < 400 || differ > rows * cols / 4, "{tile:?}: {differ}"),
            }
        }
    }
}

#[test]
fn what_has_less_contrast_keeps_its_bits() {
    let picture = planes(60, 70, |p, r, c| {
        let step = Stream::new(3, (r * 70 + c) as u32, p as u32).uniform() as f32;
        0.1 + 0.99 * (0.1 * CONTRASTS[0] - 0.1) * step
    });
    assert_eq!(corrected(&picture), picture);
    let (raw, axes) = seen_lamps([2, 2], &picture);
    assert_eq!(compared(&picture, Some(RefinementSamples::of(&raw, &axes))), picture);
}

/// Around a lamp on a dim wall that does not saturate, errors of a few percent of its brightness that alternate between X and Z from pixel to pixel
/// make coloured and black dots. The lamp and its surroundings have the same colour, and after the correction nearly do.
#[test]
fn a_lamp_has_neither_coloured_nor_dark_dots() {
    let far = |r: usize, c: usize| ((r as f32 - 20.0).powi(2) + (c as f32 - 20.0).powi(2)).sqrt();
    let light = |r, c| if far(r, c) < 4.0 { 0.2 } else { 0.002 };
    let picture = planes(41, 41, |p, r, c| {
        let sign = if (r + c) % 2 == 0 { 1.0 } else { -1.0 };
        let error = if far(r, c) < 6.0 { 0.004 * sign * [1.0, 0.6, -1.0][p] } else { 0.0 };
        light(r, c) + error
    });
    let worst = |picture: &Planes| {
        let (mut chroma, mut least) = (0.0f32, f32::INFINITY);
        for (r, c) in (0..41).flat_map(|r| (0..41).map(move |c| (r, c))) {
            let [x, y, z] = [0, 1, 2].map(|p| picture.data()[(p * 41 + r) * 41 + c]);
            chroma = chroma.max((x - y).abs().max((z - y).abs()) / light(r, c));
            least = least.min(y / light(r, c));
        }
        [chroma, least]
    };
    let [before, after] = [worst(&picture), worst(&corrected(&picture))];
    assert!(before[0] > 3.0 && before[1] < 0.0, "{before:?}");
    assert!(after[0] < 0.15 && after[1] > 0.3, "{after:?}");
}

/// Errors of Y beside a lamp, which differ among pixels that see the same cell of the tile, become a third smaller where the samples of the pixels
/// show its glow.
#[test]
fn samples_show_the_glow_of_a_lamp() {
    let far = |r: usize, c: usize| ((r as f32 - 20.3).powi(2) + (c as f32 - 20.1).powi(2)).sqrt();
    let light = |r, c| 0.002 + if far(r, c) < 4.0 { 0.4 } else { 0.4 * (1.5 * (4.0 - far(r, c))).exp() };
    let picture = planes(41, 41, |_, r, c| {
        let sign = if (r / 2 + c / 2) % 2 == 0 { 1.0 } else { -1.0 };
        light(r, c) * if far(r, c) < 8.0 { 1.0 + 0.4 * sign } else { 1.0 }
    });
    let (raw, axes) = seen([2, 2], [41, 41], |r, c| light(r, c) * [0.5, 1.0, 0.8, 0.3][r % 2 * 2 + c % 2]);
    let found = compared(&picture, Some(RefinementSamples::of(&raw, &axes)));
    let worst = |picture: &Planes| {
        let places = (0..41).flat_map(|r| (0..41).map(move |c| (r, c)));
        let glow = places.filter(|&(r, c)| (4.0..7.0).contains(&far(r, c)));
        let wrong = glow.map(|(r, c)| picture.data()[(41 + r) * 41 + c] / light(r, c) - 1.0);
        wrong.map(f32::abs).fold(0.0, f32::max)
    };
    let [without, with] = [&corrected(&picture), &found].map(worst);
    assert!(without > 0.3 && with < 0.7 * without, "{without} {with}");
}

/// A raw image of another size is refused, and in integers one in volts.
#[test]
fn samples_are_those_of_the_picture() {
    let (raw, axes) = seen([2, 2], [41, 40], |_, _| 0.1);
    let samples = Some(RefinementSamples::of(&raw, &axes));
    let mut picture = lamps(40, 41, 1);
    let stage = learned(0..1).solve([1, 1]).unwrap();
    let fixed = stage.fixed().unwrap();
    let said = "the raw image is 41 × 40 pixels, the picture to refine 40 × 41";
    assert_eq!(stage.apply(&mut picture, samples).unwrap_err().to_string(), said);
    let mut whole = vec![0; 3 * 40 * 41];
    assert_eq!(fixed.apply(&mut whole, 40, 41, samples).unwrap_err().to_string(), said);
    assert!(matches!(fixed.apply(&mut whole, 40, 40, None), Err(L3Error::Shape(_))));
    let volts = RawSamples::Analog(vec![0.1; 40 * 41]);
    let volts =
        RawImage::new(40, 41, volts, raw.sampling().clone(), raw.channel_names().to_vec(), 0.0, 1.0).unwrap();
    let samples = Some(RefinementSamples::of(&volts, &axes));
    assert_eq!(fixed.apply(&mut whole, 40, 41, samples), Err(L3Error::NotDigital));
}

/// Where a yellow lamp saturates, it is rendered white. Its glow stays yellow.
#[test]
fn the_colour_of_clipped_light_does_not_spread() {
    let far = |r: usize, c: usize| ((r as f32 - 20.0).powi(2) + (c as f32 - 20.0).powi(2)).sqrt();
    let yellow = [1.2, 1.0, 0.1];
    let picture = planes(41, 41, |p, r, c| match far(r, c) {
        ..3.0 => 1.5,
        ..5.0 => 0.3 * yellow[p],
        _ => 0.01 * yellow[p],
    });
    let found = corrected(&picture);
    for (r, c) in (0..41).flat_map(|r| (0..41).map(move |c| (r, c))).filter(|&(r, c)| far(r, c) >= 3.0) {
        let [x, y, z] = [0, 1, 2].map(|p| found.data()[(p * 41 + r) * 41 + c]);
        assert!((x / y - 1.2).abs() < 0.05 && z / y < 0.2, "{r} {c}: {x} {y} {z}");
    }
}

/// Beside a stroke of a sign, kernels may undershoot by so much that a mean would be negative, too.
#[test]
fn beside_a_bright_stroke_nothing_is_black() {
    let picture = planes(20, 41, |_, _, c| match c {
        20 | 21 => 1.0,
        18..=23 => -0.4,
        _ => 0.01,
    });
    let found = corrected(&picture);
    let y = |r: usize, c: usize| found.data()[(20 + r) * 41 + c];
    assert!((0..20).all(|r| (0..41).all(|c| y(r, c) > 0.0)), "{:?}", &found.data()[20 * 41..21 * 41]);
    // Half of a quarter of the light of the stroke.
    assert!([19, 22].iter().all(|&c| (y(10, c) - 0.125).abs() < 1e-6), "{} {}", y(10, 19), y(10, 22));
}

/// Where negative Y beside clipped light cancels what the mean colour has of light, X and Z stay in proportion to Y.
#[test]
fn no_ratio_of_a_mean_colour_is_vast() {
    let picture = planes(30, 30, |p, r, c| match (r / 3 + c / 3) % 2 {
        0 => 2.0,
        _ => [0.1, -0.031_25, 0.05][p],
    });
    let found = corrected(&picture);
    let [x, y, z] = [0, 1, 2].map(|p| &found.data()[p * 900..(p + 1) * 900]);
    assert!((0..900).all(|i| x[i] <= 3.001 * y[i].abs() && z[i] <= 16.001 * y[i].abs()));
}

/// Two strips, three strips, every instruction set and every machine give the same bits.
#[test]
fn no_bit_depends_on_strips_or_the_machine() {
    let picture = lamps(1600, 1000, 5);
    let (raw, axes) = seen_lamps([2, 2], &picture);
    let corrected = || compared(&picture, Some(RefinementSamples::of(&raw, &axes)));
    let threads = |count| rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
    let whole = threads(1).install(corrected);
    assert_eq!(threads(2).install(corrected), whole);
    for set in [Set::Plain, Set::Avx2] {
        assert_eq!(with_widest(set, corrected), whole, "{set:?}");
    }
    let digest = digest(whole.data().iter().map(|v| u64::from(v.to_bits())));
    assert_eq!(digest, 0x1232_a27b_397d_1e7a, "{digest:#x}");
}

/// Integers correct as single precision does, to 100 dB of the peak.
#[test]
fn integers_correct_as_single_precision_does() {
    let axes = RefinementAxes::new(axes().levels().clone(), [DARK * DARK, 1e-4, 0.0]).unwrap();
    let classes = vec![RefinementClass { count: 0, is_learned: false }; axes.count()];
    let mut weights = vec![0.0; axes.count() * 3 * REFINEMENT_INPUTS];
    for class in weights.chunks_exact_mut(3 * REFINEMENT_INPUTS) {
        for (output, own) in super::super::inputs::OWN.into_iter().enumerate() {
            class[output * REFINEMENT_INPUTS + own] = 1.0;
        }
    }
    let offsets = vec![0.0; axes.count() * 3];
    let stage = Refinement::new(axes, classes, weights, offsets).unwrap();
    let picture = lamps(60, 61, 8);
    let (raw, axes) = seen_lamps([3, 2], &picture);
    for samples in [None, Some(RefinementSamples::of(&raw, &axes))] {
        let (mut float, mut integers) = (picture.clone(), picture.clone());
        stage.apply(&mut float, samples).unwrap();
        assert_eq!(float, compared(&picture, samples));
        stage.fixed().unwrap().apply_to(&mut integers, samples).unwrap();
        let db = crate::l3::peak_ratio_db(&float, &integers).unwrap();
        assert!(db > 100.0, "{db}");
    }
}
