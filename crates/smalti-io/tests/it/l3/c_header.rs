//! The C header compiles without a warning, and renders what the definition says.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::{Command, Output};

use smalti::l3::{Pair, Pipeline, Statistics, Textures};
use smalti::numeric::Planes;
use smalti_io::l3::{CArithmetic, operations, write_c_header};

use super::fixtures::{Recipe, axes, bayer, outputs, pipeline, raw, recipes};

const PROGRAM: &str = r#"
#include "table.h"
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
    const int rows = atoi(argv[3]), cols = atoi(argv[4]);
    const size_t pixels = (size_t)rows * (size_t)cols;
    uint16_t *samples = malloc(2 * pixels);
    int32_t *out = malloc(4 * pixels * MY_OUTPUTS);
    uint32_t *classes = malloc(4 * pixels);
    uint8_t *places = malloc(pixels);
    my_raw raw = { samples, rows, cols, cols, atoi(argv[5]), atoi(argv[6]) };
    FILE *f = fopen(argv[1], "rb");
    int row, col;
    if (argc != 7 || fread(samples, 2, pixels, f) != pixels || fclose(f) != 0 || my_image(&raw, out, places) != 0)
        return 1;
    for (row = 0; row < rows; row++)
        for (col = 0; col < cols; col++)
            classes[row * cols + col] = my_class(&raw, row, col);
    f = fopen(argv[2], "wb");
    if (fwrite(classes, 4, pixels, f) != pixels || fwrite(out, 4, pixels * MY_OUTPUTS, f) != pixels * MY_OUTPUTS
        || fwrite(places, 1, pixels, f) != pixels)
        return 2;
    printf("%.9g %d %d\n", (double)MY_SCALE, MY_CLASSES, (int)(sizeof my_kernels + sizeof my_offsets + sizeof my_shifts));
    raw.rows = MY_MIN_ROWS - 1;
    return fclose(f) != 0 || my_image(&raw, out, places) != -1;
}
"#;

/// `None` where there is no C compiler.
pub(crate) fn compile(dir: &Path, source: &str, options: &[&str]) -> Option<()> {
    std::fs::write(dir.join("main.c"), source).unwrap();
    let cc = std::env::var("CC").unwrap_or_else(|_| "cc".into());
    let Ok(output) = Command::new(&cc)
        .current_dir(dir)
        .args(["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror", "-O1"])
        .args(options)
        .args(["-o", "main", "main.c", "-lm"])
        .output()
    else {
        eprintln!("skipped: no C compiler ({cc})");
        return None;
    };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(())
}

/// Runs the compiled program on samples; it writes `out.bin`.
pub(crate) fn run(dir: &Path, samples: &[u16], [rows, cols]: [usize; 2], phase: [usize; 2]) -> Output {
    std::fs::write(dir.join("raw.bin"), samples.iter().flat_map(|s| s.to_ne_bytes()).collect::<Vec<_>>())
        .unwrap();
    let numbers = [rows, cols, phase[0], phase[1]].map(|n| n.to_string());
    let mut program = Command::new(dir.join("main"));
    program.current_dir(dir).args(["raw.bin", "out.bin"]).args(&numbers).output().unwrap()
}

/// The place that stands in for one beyond the ends: of the same phase, nearest to the mirrored one.
fn place(at: i64, len: i64, period: i64) -> i64 {
    if (0..len).contains(&at) {
        return at;
    }
    let mirror = if at < 0 { -at } else { 2 * (len - 1) - at };
    (0..len).filter(|p| (p - at) % period == 0).min_by_key(|p| (p - mirror).abs()).unwrap()
}

/// Class and outputs of every pixel, from the definition: no fixed point, no sums shared between pixels.
pub(crate) fn definition(
    p: &Pipeline,
    samples: &[u16],
    rows: usize,
    cols: usize,
    phase: [usize; 2],
) -> Vec<(usize, Vec<f64>)> {
    let axes = p.axes();
    let tile = axes.mosaic();
    let half = axes.side() as i64 / 2;
    let range = p.white_level() - p.black_level();
    let at = |r: i64, c: i64| {
        let r = place(r, rows as i64, tile.rows() as i64) as usize;
        let c = place(c, cols as i64, tile.cols() as i64) as usize;
        (f64::from(samples[r * cols + c]) - p.black_level()) / range
    };
    let offsets = || (-half..=half).flat_map(move |r| (-half..=half).map(move |c| (r, c)));
    let cell = |r: i64, c: i64| {
        let r = (r + phase[0] as i64).rem_euclid(tile.rows() as i64) as usize;
        let c = (c + phase[1] as i64).rem_euclid(tile.cols() as i64) as usize;
        r * tile.cols() + c
    };
    let pixel = |row: i64, col: i64| {
        let patch: Vec<f64> = offsets().map(|(r, c)| at(row + r, col + c)).collect();
        let mean = patch.iter().sum::<f64>() / patch.len() as f64;
        let position = cell(row, col);
        let cuts = axes.levels_at(position).cuts();
        let level = cuts.iter().filter(|&&c| mean >= f64::from(c)).count();
        let clipped = offsets()
            .filter(|(r, c)| at(row + r, col + c) >= axes.clip())
            .fold(0, |mask, (r, c)| mask | 1u32 << tile.cells()[cell(row + r, col + c)]);
        let mut texture = 0;
        if axes.textures() != Textures::None {
            let (mut sum, mut count) = (0.0, 0.0);
            for pairs in axes.contrast_pairs() {
                for r in pairs.rows[0]..=pairs.rows[1] {
                    for c in pairs.cols[0]..=pairs.cols[1] {
                        let (r, c) = (row + r as i64, col + c as i64);
                        let other = at(r + pairs.shift[0] as i64, c + pairs.shift[1] as i64);
                        sum += (at(r, c) - other).abs();
                        count += 1.0;
                    }
                }
            }
            let [v0, v1, v2] = axes.contrast_limit();
            let x = mean.max(0.0);
            texture = usize::from((sum / count).powi(2) > v0 + v1 * x + v2 * x * x);
        }
        if axes.textures() == Textures::Oriented && texture == 1 {
            let shifts = axes.contrast_pairs().map(|p| p.shift.map(|s| s as i64));
            let [mut dd, mut dr, mut rr] = [0.0; 3];
            for (r, c) in offsets() {
                let [u, v] = shifts.map(|s| {
                    let start = (row + r - s[0].div_euclid(2), col + c - s[1].div_euclid(2));
                    at(start.0 + s[0], start.1 + s[1]) - at(start.0, start.1)
                });
                // Solves shift · gradient = difference for both.
                let [[a, b], [e, f]] = shifts.map(|s| s.map(|x| x as f64));
                let det = a * f - b * e;
                let (down, right) = ((u * f - b * v) / det, (a * v - u * e) / det);
                dd += down * down;
                dr += down * right;
                rr += right * right;
            }
            // Eigenvalues: half the trace, more or less half this.
            let spread = ((rr - dd).powi(2) + 4.0 * dr * dr).sqrt();
            if spread > Textures::EDGE_COHERENCE * (dd + rr) {
                let angle = f64::atan2(2.0 * dr, rr - dd).to_degrees() / 2.0;
                texture += 1 + (angle.rem_euclid(180.0) / 45.0).round() as usize % 4;
            }
        }
        let class = p.index(position, p.saturation_place(clipped), level, texture);
        let output = |o: usize| {
            let sum: f64 =
                p.weights(class, o).unwrap().iter().zip(&patch).map(|(&w, x)| f64::from(w) * x).sum();
            f64::from(p.kernels().offsets[class * p.outputs().len() + o]) + sum
        };
        (class, (0..p.outputs().len()).map(output).collect())
    };
    (0..rows * cols).map(|i| pixel((i / cols) as i64, (i % cols) as i64)).collect()
}

/// That of an image which begins with a whole tile, and one that begins with the last cell of it: the first phase that makes
/// the same mosaic, which is the one that the library takes it for.
pub(crate) fn phases(r: &Recipe) -> [[usize; 2]; 2] {
    let axes = axes(r);
    let (tile, rows, cols) = (axes.mosaic(), r.tile.0, r.tile.1);
    let last = tile.shifted(rows - 1, cols - 1);
    let first = (0..rows * cols).find(|i| tile.shifted(i / cols, i % cols) == last).unwrap();
    [[0, 0], [first / cols, first % cols]]
}

/// What is tested against is what the library does: it sorts the patches within an image into the same classes.
#[test]
fn the_library_classifies_by_the_definition() {
    for r in recipes() {
        for phase in phases(&r) {
            let (rows, cols, half) = (70, 53, r.side / 2);
            let (image, samples) = raw(&r, rows, cols, phase);
            let target = Planes::new(rows, cols, r.outputs, vec![0.0; rows * cols * r.outputs]).unwrap();
            let mut statistics = Statistics::new(axes(&r), outputs(&r), true).unwrap();
            statistics.add(&Pair { raw: &image, seen: None, target: &target }).unwrap();
            // A table with every combination of clipped channels, so that none is replaced by another.
            let channels = r.tile.2.iter().max().unwrap() + 1;
            let all = Recipe { saturations: (0..1 << channels).collect(), ..r.clone() };
            let p = pipeline(&all);
            let mut expected = BTreeMap::new();
            for (i, (class, _)) in definition(&p, &samples, rows, cols, phase).iter().enumerate() {
                if (half..rows - half).contains(&(i / cols)) && (half..cols - half).contains(&(i % cols)) {
                    *expected.entry(p.key(*class)).or_insert(0u64) += 1;
                }
            }
            let counts: BTreeMap<_, _> = statistics.classes().iter().map(|(k, m)| (*k, m.count())).collect();
            assert_eq!(counts, expected, "{r:?}");
        }
    }
}

fn check(r: &Recipe, rows: usize, cols: usize, phase: [usize; 2]) -> Option<()> {
    let p = pipeline(r);
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    write_c_header(&dir.join("table.h"), &p, "my", CArithmetic::Integers).unwrap();
    compile(dir, PROGRAM, &[])?;
    let (image, samples) = raw(r, rows, cols, phase);
    let output = run(dir, &samples, [rows, cols], phase);
    assert!(output.status.success(), "{:?} {r:?}", output.status);
    let printed: Vec<f64> =
        String::from_utf8(output.stdout).unwrap().split_whitespace().map(|n| n.parse().unwrap()).collect();
    let [scale, classes, kernel_bytes] = printed[..] else { panic!("{printed:?}") };
    let kernels = p.fixed_kernels(p.black_level(), p.white_level()).unwrap();
    // Nine digits bring a 32-bit float back.
    assert_eq!(scale as f32, kernels.scale);
    assert_eq!(classes as usize, p.classes().len());
    assert!(operations(&p).table_bytes >= kernel_bytes as u64);
    let out = std::fs::read(dir.join("out.bin")).unwrap();
    let (out, places) = out.split_at(out.len() - rows * cols);
    let values: Vec<i32> = out.as_chunks().0.iter().map(|b| i32::from_ne_bytes(*b)).collect();
    let (classes, values) = values.split_at(rows * cols);
    let step = |i: usize| kernels.scale * 0.5f32.powi(i32::from(places[i % (rows * cols)]));
    let expected = definition(&p, &samples, rows, cols, phase);
    // The library's fixed point has the same sums.
    let planes = p.render_fixed(&image).unwrap().planes;
    for (i, (sum, output)) in values.iter().zip(planes.data()).enumerate() {
        assert_eq!(*sum as f32 * step(i), *output, "value {i} {r:?}");
    }
    // Half a step of every weight times the largest sample, half a step of the offset, and where samples lose a bit half of
    // their step times the weights.
    let unit = 1.0 / f64::from(kernels.scale);
    let lost = f64::from(kernels.sample_shift) * 0.5 * 65535.0;
    let tolerance = |step: f64| step * (0.5 + 0.5 * p.axes().taps() as f64 * (unit + 64.0) + lost);
    let (mut largest, mut squares, mut seen) = (0.0f64, 0.0, BTreeSet::new());
    for (i, (class, outputs)) in expected.iter().enumerate() {
        assert_eq!(classes[i] as usize, *class, "row {} column {} {r:?}", i / cols, i % cols);
        seen.insert(p.key(*class));
        for (o, expected) in outputs.iter().enumerate() {
            let step = f64::from(step(i));
            let error = f64::from(values[o * rows * cols + i]) * step - expected;
            assert!(error.abs() <= tolerance(step), "{error} {}", tolerance(step));
            largest = largest.max(error.abs());
            squares += error * error;
        }
    }
    let rms = (squares / (rows * cols * p.outputs().len()) as f64).sqrt();
    let textures: BTreeSet<u16> = seen.iter().map(|k| k.texture).collect();
    println!(
        "{rows} × {cols}, {} classes met, textures {textures:?}, {:?} places: largest error {largest:.2e}, RMS {rms:.2e}, PSNR {:.1} dB",
        seen.len(),
        places.iter().collect::<BTreeSet<_>>(),
        -20.0 * rms.log10()
    );
    // The image meets every kind of structure, so that each rule has been tried.
    assert_eq!(textures.len(), p.axes().textures().count(), "{textures:?} {r:?}");
    // And kernels of unlike scales.
    assert!(seen.len() < 3 || places.iter().min() < places.iter().max(), "{r:?}");
    assert!(rms < 1e-3, "{rms}");
    Some(())
}

#[test]
fn the_header_renders_what_the_definition_says() {
    for r in recipes() {
        for phase in phases(&r) {
            if check(&r, 40, 53, phase).is_none() {
                return;
            }
        }
    }
    // As small as images may be: mirrored on both sides at once.
    let r = Recipe { side: 11, textures: Textures::None, ..bayer() };
    check(&r, 11, 12, [1, 0]);
}

/// Undefined behaviour, overflow above all, stops the program, with samples that no sensor would give.
#[test]
fn no_sample_overflows() {
    let r = Recipe { textures: Textures::Oriented, ..recipes()[2].clone() };
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    write_c_header(&dir.join("table.h"), &pipeline(&r), "my", CArithmetic::Integers).unwrap();
    if compile(
        dir,
        PROGRAM,
        &["-fsanitize=undefined", "-fno-sanitize-recover", "-fsanitize-undefined-trap-on-error"],
    )
    .is_none()
    {
        return;
    }
    let samples: Vec<u8> = (0..30 * 30)
        .flat_map(|i: u32| if i.count_ones().is_multiple_of(2) { [255; 2] } else { [0; 2] })
        .collect();
    std::fs::write(dir.join("raw.bin"), samples).unwrap();
    let arguments = ["raw.bin", "out.bin", "30", "30", "4", "3"];
    let status = Command::new(dir.join("main")).current_dir(dir).args(arguments).status().unwrap();
    assert!(status.success(), "{status}");
}

#[test]
fn what_has_no_place_in_a_header_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("table.h");
    for arithmetic in [CArithmetic::Integers, CArithmetic::SinglePrecision] {
        let error = |r: &Recipe, prefix: &str| {
            write_c_header(&path, &pipeline(r), prefix, arithmetic).unwrap_err().to_string()
        };
        for prefix in ["", "1a", "a-b", "Big", "a b", "_x", "a/**/"] {
            assert!(error(&bayer(), prefix).contains("small letters"), "{prefix}");
        }
        let volts = Recipe { levels: [0.0, 0.9], ..bayer() };
        assert!(error(&volts, "my").contains("expected digital numbers of 16 bits"));
    }
    assert!(!path.exists());
}
