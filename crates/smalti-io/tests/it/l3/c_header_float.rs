//! The C header in single precision, and that of two stages in either arithmetic, compile without a warning and have the bits of the library.

use std::collections::BTreeSet;

use smalti::l3::{
    FixedRefinement, Levels, Pipeline, Quality, REFINEMENT_INPUTS, Refinement, RefinementAxes,
    RefinementClass, Textures,
};
use smalti_io::l3::{CArithmetic, write_c_header};

use super::c_header::{compile, phases, run};
use super::fixtures::{Recipe, bayer, picture_pipeline_of, pipeline, raw, recipes, second_stage_of};

const PROGRAM: &str = r#"
#include "table.h"
#ifdef MY_UNIT
typedef int32_t number;
static uint8_t *places;
#define FAST_IMAGE(raw, out) my_fast_image(raw, out, places)
#else
typedef float number;
#define FAST_IMAGE(raw, out) my_fast_image(raw, out)
#endif
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int argc, char **argv)
{
    const int rows = atoi(argv[3]), cols = atoi(argv[4]);
    const size_t pixels = (size_t)rows * (size_t)cols;
    uint16_t *samples = malloc(2 * pixels);
    number *out = malloc(sizeof *out * pixels * MY_OUTPUTS);
    my_raw raw = { samples, rows, cols, cols, atoi(argv[5]), atoi(argv[6]) };
    FILE *f = fopen(argv[1], "rb");
    if (argc != 7 || fread(samples, 2, pixels, f) != pixels || fclose(f) != 0)
        return 1;
    f = fopen(argv[2], "wb");
#ifdef MY_UNIT
    places = malloc(pixels);
#endif
#ifdef MY_WORK
    {
        /* Not a number wherever nothing is written, and a number behind the end that stays. */
        number *work = malloc(sizeof *work * (MY_WORK(cols) + 1));
        memset(work, 255, sizeof *work * MY_WORK(cols));
        work[MY_WORK(cols)] = (number)12345;
        if (my_image(&raw, out, work) != 0 || work[MY_WORK(cols)] != (number)12345)
            return 2;
        if (fwrite(out, sizeof *out, pixels * MY_OUTPUTS, f) != pixels * MY_OUTPUTS || FAST_IMAGE(&raw, out) != 0)
            return 3;
        raw.rows = MY_MIN_ROWS - 1;
        if (my_image(&raw, out, work) != -1 || FAST_IMAGE(&raw, out) != -1)
            return 4;
    }
#else
    if (my_image(&raw, out) != 0)
        return 2;
    raw.rows = MY_MIN_ROWS - 1;
    if (my_image(&raw, out) != -1)
        return 4;
#endif
    if (fwrite(out, sizeof *out, pixels * MY_OUTPUTS, f) != pixels * MY_OUTPUTS)
        return 5;
#ifdef MY_UNIT
    if (fwrite(places, 1, pixels, f) != pixels)
        return 6;
#endif
    return fclose(f) != 0;
}
"#;

/// What the program writes. `None` without a C compiler.
fn written(
    p: &Pipeline,
    arithmetic: CArithmetic,
    r: &Recipe,
    size: [usize; 2],
    phase: [usize; 2],
) -> Option<Vec<u8>> {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    write_c_header(&dir.join("table.h"), p, "my", arithmetic).unwrap();
    let trapping = ["-fsanitize=undefined", "-fno-sanitize-recover", "-fsanitize-undefined-trap-on-error"];
    compile(dir, PROGRAM, &trapping)?;
    let (_, samples) = raw(r, size[0], size[1], phase);
    let output = run(dir, &samples, size, phase);
    assert!(output.status.success(), "{:?} {r:?}", output.status);
    Some(std::fs::read(dir.join("out.bin")).unwrap())
}

/// The pictures that the header renders in single precision, one for each stage, the last stage first.
fn rendered(p: &Pipeline, r: &Recipe, size: [usize; 2], phase: [usize; 2]) -> Option<Vec<Vec<f32>>> {
    let bytes = written(p, CArithmetic::SinglePrecision, r, size, phase)?;
    let values: Vec<f32> = bytes.as_chunks().0.iter().map(|b| f32::from_ne_bytes(*b)).collect();
    Some(values.chunks(size[0] * size[1] * p.outputs().len()).map(<[f32]>::to_vec).collect())
}

fn assert_same_bits(found: &[f32], expected: &[f32], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert_eq!(found.to_bits(), expected.to_bits(), "value {i}, {found} and {expected}: {what}");
    }
}

/// One stage: every rule of the first stage, every pixel up to the borders.
#[test]
fn one_stage_has_the_bits_of_the_library() {
    for r in recipes() {
        for phase in phases(&r) {
            let p = pipeline(&r);
            let Some(pictures) = rendered(&p, &r, [40, 53], phase) else { return };
            let (image, _) = raw(&r, 40, 53, phase);
            let expected = p.render_raw(&image).unwrap().planes;
            assert_eq!(pictures.len(), 1);
            assert_same_bits(&pictures[0], expected.data(), &format!("{phase:?} {r:?}"));
        }
    }
}

/// The classes of the second stage that pixels of a picture fall into: those of a stage whose outputs are the number of the class.
fn classes_met(axes: &RefinementAxes, first: &Pipeline, image: &smalti::sensor::RawImage) -> BTreeSet<u32> {
    let count = axes.count();
    let classes = vec![RefinementClass { count: 0, is_learned: false }; count];
    // Above the contrasts at which pixels are corrected.
    let offsets = (0..3 * count).map(|i| (count + i / 3) as f32).collect();
    let stage =
        Refinement::new(axes.clone(), classes, vec![0.0; 3 * count * REFINEMENT_INPUTS], offsets).unwrap();
    let mut planes = first.render_raw(image).unwrap().planes;
    stage.apply(&mut planes, None).unwrap();
    planes.data().iter().map(|&class| class as u32 - count as u32).collect()
}

/// Axes of the second stage, and images of mosaics, sizes and phases: Bayer, also with levels that have a fraction, six channels of 3 × 2 with 16 bits, RGBW of
/// 4 × 4, a knight's move of 5 × 5, with odd and even sizes, more rows than are kept, as small as images may be, and the structures of tables of version 2.
fn cases() -> Vec<(Recipe, [usize; 2], [usize; 2], RefinementAxes)> {
    let levels = |count| Levels::logarithmic(count, 0.01, 0.8).unwrap();
    let axes = [
        RefinementAxes::new(levels(12), [1e-4, 1e-4, 0.0]).unwrap(),
        RefinementAxes::new(levels(1), [2e-3, 1e-2, 1e-4])
            .unwrap()
            .with_structures(vec![0.02, 0.1, 0.5], 4)
            .unwrap(),
    ];
    let rgbw = Recipe { side: 5, textures: Textures::Oriented, ..recipes()[4].clone() };
    let fraction = Recipe { levels: [60.375, 1023.5], ..bayer() };
    let six = Recipe { tile: (3, 2, (0..6).collect()), levels: [0.0, 65535.0], ..bayer() };
    let small = Recipe { side: 3, textures: Textures::None, ..bayer() };
    let images = [
        (bayer(), [75, 64]),
        (bayer(), [40, 53]),
        (fraction, [80, 71]),
        (six, [91, 91]),
        (rgbw, [91, 70]),
        (recipes()[2].clone(), [50, 51]),
        (small.clone(), [3, 4]),
        (small, [5, 3]),
    ];
    let with_axes = |(r, size): (Recipe, [usize; 2])| {
        let phases = phases(&r).into_iter().zip(axes.clone());
        phases.map(|(phase, axes)| (r.clone(), size, phase, axes)).collect::<Vec<_>>()
    };
    images.into_iter().flat_map(with_axes).collect()
}

/// A stage of which every second class is below black and the others are bright, so that pixels where they meet are corrected. Lifted by much, the
/// same has no such contrast.
fn with_highlights(stage: &Refinement, lift: f32) -> Refinement {
    let offset =
        |(i, offset): (usize, &f32)| lift + if i / 3 % 2 == 0 { -0.9 + offset } else { 2.0 + offset };
    let offsets = stage.offsets().iter().enumerate().map(offset).collect();
    let (axes, classes) = (stage.axes().clone(), stage.classes().to_vec());
    Refinement::new(axes, classes, stage.weights().collect(), offsets).unwrap()
}

/// The pipeline with such a stage, whose pictures of an image have corrected pixels unless the image is small.
pub(super) fn best_of(first: &Pipeline, axes: RefinementAxes, image: &smalti::sensor::RawImage) -> Pipeline {
    let stage = second_stage_of(axes);
    let with = |lift| first.clone().with_refinement(Some(with_highlights(&stage, lift))).unwrap();
    let (best, lifted) = (with(0.0), with(100.0));
    let [picture, plain] = [&best, &lifted].map(|p| p.render_raw(image).unwrap().planes);
    let differ = picture.data().iter().zip(plain.data()).filter(|(a, b)| (*a - (*b - 100.0)).abs() > 0.01);
    let corrected = differ.count();
    assert!(image.rows() < 40 || corrected > 100, "{corrected}");
    best
}

#[test]
fn both_stages_have_the_bits_of_the_library() {
    for (r, size, phase, axes) in cases() {
        let first = picture_pipeline_of(&r);
        let (image, _) = raw(&r, size[0], size[1], phase);
        let met = classes_met(&axes, &first, &image);
        println!("{size:?}: {} of {} classes met", met.len(), axes.count());
        let structures: BTreeSet<u32> = met.iter().map(|class| class % axes.structures() as u32).collect();
        let kinds: BTreeSet<usize> = structures
            .iter()
            .filter_map(|s| (*s as usize).checked_sub(1))
            .map(|s| s % (1 + axes.orientations()))
            .collect();
        println!("{} structures, kinds {kinds:?}", structures.len());
        // The larger pictures meet texture and edges of every orientation.
        assert!(size[0] < 40 || kinds.len() == 1 + axes.orientations(), "{kinds:?}");
        let p = best_of(&first, axes, &image);
        assert_eq!(p.quality(), Quality::Best);
        let Some(pictures) = rendered(&p, &r, size, phase) else { return };
        let [best, fast] = &pictures[..] else { panic!("{}", pictures.len()) };
        let what = format!("{size:?} {phase:?} {r:?}");
        assert_same_bits(fast, first.render_raw(&image).unwrap().planes.data(), &what);
        assert_same_bits(best, p.render_raw(&image).unwrap().planes.data(), &what);
        let mut alone = first.render_raw(&image).unwrap().planes;
        p.refinement().unwrap().apply(&mut alone, None).unwrap();
        let compared = best.iter().zip(alone.data()).filter(|(a, b)| a != b).count();
        let [tile_rows, tile_cols] = [p.axes().mosaic().rows(), p.axes().mosaic().cols()];
        let is_compared = size[0] >= 40 && tile_rows.min(tile_cols) < 5;
        assert!(!is_compared || compared > 100, "{compared}: {what}");
        assert!(best.iter().zip(fast).any(|(a, b)| a != b));
    }
}

/// In integers, the second stage of the header is that of the library bit for bit, on the sums of the first stage, which another test compares.
#[test]
fn both_stages_in_integers_are_those_of_the_library() {
    for (r, size, phase, axes) in cases() {
        let (image, _) = raw(&r, size[0], size[1], phase);
        let p = best_of(&picture_pipeline_of(&r), axes, &image);
        let Some(bytes) = written(&p, CArithmetic::Integers, &r, size, phase) else { return };
        let (rows, cols) = (size[0], size[1]);
        let (values, places) = bytes.split_at(bytes.len() - rows * cols);
        let values: Vec<i32> = values.as_chunks().0.iter().map(|b| i32::from_ne_bytes(*b)).collect();
        let (best, sums) = values.split_at(3 * rows * cols);
        // The sums in units of 2⁻²⁰, halves away from zero. The scale is above 2⁻¹⁷, so that 2⁴¹ times it is a whole number.
        let scale = f64::from(p.fixed_kernels(p.black_level(), p.white_level()).unwrap().scale);
        let factor = (scale * (1u64 << 41) as f64) as i128;
        let unit = |(i, sum): (usize, &i32)| {
            let divisor = 1i128 << (41 - FixedRefinement::PLACES + u32::from(places[i % (rows * cols)]));
            let product = i128::from(*sum) * factor;
            let rounded = (product.abs() + divisor / 2) / divisor;
            i32::try_from(if product < 0 { -rounded } else { rounded }).unwrap()
        };
        let mut expected: Vec<i32> = sums.iter().enumerate().map(unit).collect();
        let samples = p.refinement_samples(&image).unwrap();
        p.refinement().unwrap().fixed().unwrap().apply(&mut expected, rows, cols, Some(samples)).unwrap();
        for (i, (found, expected)) in best.iter().zip(&expected).enumerate() {
            assert_eq!(found, expected, "value {i} {size:?} {phase:?} {r:?}");
        }
        // The renderer of the library begins with a picture in single precision, which may differ by one such unit.
        let one = f64::from(1u32 << FixedRefinement::PLACES);
        let library = p.render_fixed(&image).unwrap().planes;
        let far = |(v, found): (&f32, &i32)| (f64::from(*v) * one - f64::from(*found)).abs();
        let far: Vec<f64> = library.data().iter().zip(best).map(far).collect();
        let same = far.iter().filter(|d| **d <= 2.0).count();
        println!("{size:?}: {same} of {} values within two units", far.len());
        assert!(100 * same >= 99 * far.len(), "{same} of {}", far.len());
    }
}
