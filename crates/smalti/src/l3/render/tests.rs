//! Against the definition, pixel by pixel.

mod products;
mod unlike;

use super::super::lattice;
use super::super::window::mirrored;
use super::super::{Axes, Class, Kernels, Levels, Origin, PipelineParts, Textures};
use super::*;
use crate::numeric::arithmetic::digest;
use crate::numeric::philox::Stream;
use crate::numeric::simd::{Set, with_widest};
use crate::sensor::{Mosaic, Sampling, SignalNoise};

const BLACK: f64 = 64.0;
const WHITE: f64 = 4095.0;

fn bayer() -> Mosaic {
    Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap()
}

/// Every row two to the right of the one above.
fn knight() -> Mosaic {
    Mosaic::new(5, 5, (0..25).map(|i| ((i % 5 + 3 * (i / 5)) % 5) as u8).collect()).unwrap()
}

fn noise() -> SignalNoise {
    SignalNoise {
        constant: 1e-6,
        per_signal: 1e-4,
        per_signal_squared: 1e-6,
        row: 1e-8,
        column: 1e-8,
        above: None,
    }
}

fn pipeline_of(axes: Axes, saturations: Vec<u32>, outputs: usize, seed: u64) -> Pipeline {
    let mut random = Stream::new(seed, 1, 2);
    let count = axes.positions() * saturations.len() * axes.level_count() * axes.textures().count();
    let taps = axes.taps();
    let mut weights: Vec<f32> =
        (0..count * outputs * taps).map(|_| (random.uniform() as f32 - 0.3) * 1.5 / taps as f32).collect();
    let mut offsets: Vec<f32> = (0..count * outputs).map(|_| random.uniform() as f32 * 0.1 - 0.05).collect();
    // Classes that share their kernels, as those without patches of their own do.
    for class in (3..count).step_by(7) {
        weights
            .copy_within((class - 2) * outputs * taps..(class - 1) * outputs * taps, class * outputs * taps);
        offsets.copy_within((class - 2) * outputs..(class - 1) * outputs, class * outputs);
    }
    let channels = axes.mosaic().channels();
    let parts = PipelineParts {
        saturations,
        outputs: (0..outputs).map(|i| i.to_string()).collect(),
        channel_names: (0..channels).map(|i| i.to_string()).collect(),
        black_level: BLACK,
        white_level: WHITE,
        trained: (0..axes.positions()).map(|p| [0.05 + 0.01 * p as f32, 0.7]).collect(),
        classes: vec![Class { count: 1, origin: Origin::Learned }; count],
        kernels: Kernels { weights, offsets },
        provenance: String::new(),
        axes,
    };
    Pipeline::from_parts(parts).unwrap()
}

fn pipeline(mosaic: &Mosaic, side: usize, outputs: usize) -> Pipeline {
    let white: Vec<f64> = (0..mosaic.channels()).map(|c| 0.5 + 0.2 * c as f64).collect();
    let levels = Levels::logarithmic(9, 0.02, 0.8).unwrap();
    let axes = Axes::new(mosaic.clone(), side, levels, noise()).unwrap();
    let axes = axes.with_levels_by_position(&white).unwrap();
    pipeline_of(axes, vec![0, 1, 2], outputs, side as u64)
}

fn raw_of(mosaic: &Mosaic, rows: usize, cols: usize, samples: RawSamples, levels: [f64; 2]) -> RawImage {
    let names = (0..mosaic.channels()).map(|i| i.to_string()).collect();
    let sampling = Sampling::Mosaic(mosaic.clone());
    RawImage::new(rows, cols, samples, sampling, names, levels[0], levels[1]).unwrap()
}

/// From dark to clipped, with flat parts and noise.
fn samples(rows: usize, cols: usize) -> Vec<u16> {
    let mut random = Stream::new(5, 1, 2);
    let mut at = |i: usize| {
        let (row, col) = (i / cols, i % cols);
        let light = 4500 * (row + 3 * col) / (rows + 3 * cols);
        let texture = if (row / 9 + col / 11) % 2 == 0 { random.next_u32() as usize % 800 } else { 0 };
        (40 + light + texture).min(4095) as u16
    };
    (0..rows * cols).map(&mut at).collect()
}

fn raw(mosaic: &Mosaic, rows: usize, cols: usize) -> RawImage {
    raw_of(mosaic, rows, cols, RawSamples::Digital(samples(rows, cols)), [BLACK, WHITE])
}

/// The definition: classes of all pixels, and what is unlike training.
struct Reference<'a> {
    pipeline: &'a Pipeline,
    raw: &'a RawImage,
    normalized: Vec<f32>,
    phase: [usize; 2],
}

impl<'a> Reference<'a> {
    fn new(pipeline: &'a Pipeline, raw: &'a RawImage, phase: [usize; 2]) -> Self {
        Self { pipeline, raw, normalized: raw.normalized(), phase }
    }

    fn place(&self, row: isize, col: isize) -> usize {
        let m = self.pipeline.axes().mosaic();
        let (rows, cols) = (self.raw.rows(), self.raw.cols());
        mirrored(row, rows, m.rows()) * cols + mirrored(col, cols, m.cols())
    }

    /// Sum over rectangle, columns first.
    fn sum(
        &self,
        rows: [isize; 2],
        cols: [isize; 2],
        mut value: impl FnMut(isize, isize) -> f32,
    ) -> Vec<f32> {
        let column = |c: isize| (rows[0]..=rows[1]).fold(0.0f32, |s, r| s + value(r, c));
        (cols[0]..=cols[1]).map(column).collect()
    }

    fn class(&self, row: usize, col: usize, outside: &mut OutsideCounts) -> usize {
        let axes = self.pipeline.axes();
        let (m, half) = (axes.mosaic(), (axes.side() / 2) as isize);
        let (r0, c0) = (row as isize, col as isize);
        let at = |r: isize, c: isize| self.normalized[self.place(r0 + r, c0 + c)];
        let add = |s: f32, v: &f32| s + v;
        let all = [-half, half];
        let mean = self.sum(all, all, at).iter().fold(0.0, add) * (1.0 / axes.taps() as f32);
        let mut count = 0;
        let mut contrast = 0.0f32;
        for shift in lattice::basis(m) {
            let span = |s: isize| {
                let span = [(-half).max(-half - s), half.min(half - s)];
                if span[0] <= span[1] { span } else { [-s.div_euclid(2); 2] }
            };
            let (rows, cols) = (span(shift[0]), span(shift[1]));
            let sums = self.sum(rows, cols, |r, c| (at(r, c) - at(r + shift[0], c + shift[1])).abs());
            count += sums.len() * (rows[1] - rows[0] + 1) as usize;
            contrast = sums.iter().fold(contrast, add);
        }
        let (n, (over, share), x) = (axes.noise(), axes.contrast(), f64::from(mean.max(0.0)));
        let variance = n.constant + n.row + n.column + n.per_signal * x + n.per_signal_squared * x * x;
        let limit = over * over * 4.0 / std::f64::consts::PI * variance + share * share * x * x;
        let texture = (f64::from(contrast) / count as f64).powi(2) > limit;
        let position = (self.phase[0] + row) % m.rows() * m.cols() + (self.phase[1] + col) % m.cols();
        let mut clipped = 0;
        for (r, c) in (-half..=half).flat_map(|r| (-half..=half).map(move |c| (r, c))) {
            let tap = ((r + half) as usize * axes.side()) + (c + half) as usize;
            let bit = 1 << axes.channel_of(position, tap);
            clipped |= if at(r, c) >= axes.clip() as f32 { bit } else { 0 };
        }
        let [least, most] = self.pipeline.trained()[position];
        outside.darker += u64::from(mean < least);
        outside.brighter += u64::from(mean > most);
        outside.saturation += u64::from(!self.pipeline.saturations().contains(&clipped));
        let level = axes.levels_at(position).level_of(mean);
        self.pipeline.index(position, self.pipeline.saturation_place(clipped), level, usize::from(texture))
    }

    fn each(&self, mut value: impl FnMut(usize, usize, &[usize]) -> f32) -> Rendered {
        let (rows, cols, side) = (self.raw.rows(), self.raw.cols(), self.pipeline.axes().side());
        let half = (side / 2) as isize;
        let mut planes = Planes::zeros(rows, cols, self.pipeline.outputs().len());
        let mut outside = OutsideCounts::default();
        for (row, col) in (0..rows).flat_map(|r| (0..cols).map(move |c| (r, c))) {
            let class = self.class(row, col, &mut outside);
            let taps: Vec<usize> = (0..side * side)
                .map(|t| {
                    let (r, c) = ((t / side) as isize - half, (t % side) as isize - half);
                    self.place(row as isize + r, col as isize + c)
                })
                .collect();
            for output in 0..self.pipeline.outputs().len() {
                planes.plane_mut(output).unwrap()[row * cols + col] = value(class, output, &taps);
            }
        }
        Rendered { planes, outside }
    }

    /// Sixteen partial sums over the patch column by column, the offset last, and the tree.
    fn float(&self) -> Rendered {
        let (side, outputs) = (self.pipeline.axes().side(), self.pipeline.outputs().len());
        self.each(|class, output, taps| {
            let weights = self.pipeline.weights(class, output).unwrap();
            let columns = (0..side).flat_map(|c| (0..side).map(move |r| r * side + c));
            let mut products: Vec<f32> = columns.map(|t| self.normalized[taps[t]] * weights[t]).collect();
            products.push(self.pipeline.kernels().offsets[class * outputs + output]);
            let lane = |i: usize| products.iter().skip(i).step_by(16).copied().reduce(|a, b| a + b);
            let p: Vec<f32> = (0..16).map(|i| lane(i).unwrap_or(0.0)).collect();
            let four = |i: usize| (p[i] + p[i + 2]) + (p[i + 1] + p[i + 3]);
            (four(0) + four(4)) + (four(8) + four(12))
        })
    }

    fn fixed(&self, kernels: &FixedKernels) -> Rendered {
        let (taps_per_kernel, outputs) = (self.pipeline.axes().taps(), self.pipeline.outputs().len());
        let RawSamples::Digital(samples) = self.raw.samples() else { panic!("digital samples") };
        self.each(|class, output, taps| {
            let i = class * outputs + output;
            let weights = &kernels.weights[i * taps_per_kernel..][..taps_per_kernel];
            let mut sum = i64::from(kernels.offsets[i]);
            for (&w, &t) in weights.iter().zip(taps) {
                let d = i64::from(samples[t]) - i64::from(kernels.black);
                let d = (d + i64::from(kernels.sample_shift)) >> kernels.sample_shift;
                sum += i64::from(w) * d.clamp(-32768, 32767);
            }
            let sum = i32::try_from(sum).expect("the sum fits 32 bits");
            // Powers of two are exact: so is what they are multiplied with.
            sum as f32 * (kernels.scale * 0.5f32.powi(i32::from(kernels.shifts[class])))
        })
    }
}

fn assert_same(got: &Rendered, expected: &Rendered, what: &str) {
    assert_eq!(got.outside, expected.outside, "{what}");
    for (i, (a, b)) in got.planes.data().iter().zip(expected.planes.data()).enumerate() {
        // The sign of zero may differ: padding adds +0.
        assert!(a == b, "{what}: value {i} is {a}, expected {b}");
    }
}

/// The paths that a processor like this one, or a lesser one, takes.
const PATHS: [Set; 3] = [Set::Plain, Set::Avx2, Set::Avx512];

#[test]
fn both_paths_are_what_the_definition_says_on_every_instruction_set() {
    let nine = Mosaic::new(3, 3, (0..9).collect()).unwrap();
    let rgbw = Mosaic::new(4, 4, vec![0, 3, 1, 3, 3, 0, 3, 1, 1, 3, 2, 3, 3, 1, 3, 2]).unwrap();
    // Widths of less than a vector, of more than a strip, and in between.
    let cases = [
        (bayer(), 5, 3, 37, 83),
        (bayer(), 3, 1, 3, 3),
        (bayer(), 7, 4, 9, 1043),
        (nine, 9, 2, 34, 70),
        (rgbw, 11, 5, 13, 31),
        (knight(), 5, 3, 40, 66),
    ];
    for (mosaic, side, outputs, rows, cols) in cases {
        let pipeline = pipeline(&mosaic, side, outputs);
        // A crop that begins elsewhere in the tile.
        let phase = [1 % mosaic.rows(), (mosaic.cols() - 1) % mosaic.cols()];
        for phase in [[0, 0], phase] {
            let raw = raw(&mosaic.shifted(phase[0], phase[1]), rows, cols);
            // A mosaic that repeats within its tile may be met at an earlier phase.
            let found = phase_in(&mosaic, &[], &raw).unwrap();
            let reference = Reference::new(&pipeline, &raw, found);
            let (float, renderer) = (reference.float(), pipeline.renderer());
            for set in PATHS {
                let what = format!("{rows} × {cols}, patch {side}, {set:?}");
                assert_same(&with_widest(set, || renderer.render(&raw)).unwrap(), &float, &what);
            }
            let renderer = pipeline.fixed_renderer(BLACK, WHITE).unwrap();
            let fixed = reference.fixed(&renderer.kernels);
            for set in PATHS {
                let what = format!("{rows} × {cols}, patch {side}, fixed, {set:?}");
                assert_same(&with_widest(set, || renderer.render(&raw)).unwrap(), &fixed, &what);
            }
            // Weights are rounded to 2^-15 or so of the largest, samples are whole already.
            let ratio = peak_ratio_db(&float.planes, &fixed.planes).unwrap();
            assert!(ratio > 60.0, "{ratio} dB between the paths, patch {side}");
        }
    }
}

#[test]
fn no_bit_depends_on_the_threads_or_the_machine() {
    let (pipeline, raw) = (pipeline(&bayer(), 5, 3), raw(&bayer(), 150, 90));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (pipeline.render_raw(&raw).unwrap(), pipeline.render_fixed(&raw).unwrap()))
    };
    let (float, fixed) = with(1);
    assert_eq!(with(3), (float.clone(), fixed.clone()));
    // Nor on the machine: the digest was recorded when this test was written.
    let values = float.planes.data().iter().chain(fixed.planes.data());
    // The sign of zero may differ.
    let digest = digest(values.map(|v| u64::from((v + 0.0).to_bits())));
    assert_eq!(digest, 0x7693_f62a_06e0_50b5, "{digest:#x}");
}

#[test]
fn sixteen_bits_from_an_odd_black_level_stay_close() {
    let mosaic = bayer();
    let mut parts = pipeline(&mosaic, 5, 3);
    for (black, white) in [(512.4, 65535.0), (0.0, 32767.5), (16.0, 255.0)] {
        let full: Vec<u16> = samples(60, 60)
            .iter()
            .map(|&s| (black + f64::from(s) / 4500.0 * (white - black)) as u16)
            .collect();
        parts = pipeline_with_levels(&parts, [black, white]);
        let raw = raw_of(&mosaic, 60, 60, RawSamples::Digital(full), [black, white]);
        let (float, fixed) = (parts.render_raw(&raw).unwrap(), parts.render_fixed(&raw).unwrap());
        assert_eq!(float.outside, fixed.outside);
        let ratio = peak_ratio_db(&float.planes, &fixed.planes).unwrap();
        assert!(ratio > 60.0, "{ratio} dB from {black} to {white}");
    }
}

fn pipeline_with_levels(p: &Pipeline, levels: [f64; 2]) -> Pipeline {
    pipeline_with(p, levels, p.kernels().clone())
}

fn pipeline_with(p: &Pipeline, [black_level, white_level]: [f64; 2], kernels: Kernels) -> Pipeline {
    let parts = PipelineParts {
        axes: p.axes().clone(),
        saturations: p.saturations().to_vec(),
        outputs: p.outputs().to_vec(),
        channel_names: p.channel_names().to_vec(),
        black_level,
        white_level,
        trained: p.trained().to_vec(),
        classes: p.classes().to_vec(),
        kernels,
        provenance: String::new(),
    };
    Pipeline::from_parts(parts).unwrap()
}

#[test]
fn volts_and_nan() {
    let (mosaic, pipeline) = (bayer(), pipeline(&bayer(), 5, 3));
    let digital = raw(&mosaic, 50, 70);
    let mut volts: Vec<f32> = digital.normalized().iter().map(|v| 0.1 + 1.7 * v).collect();
    let analog = |v: &[f32]| raw_of(&mosaic, 50, 70, RawSamples::Analog(v.to_vec()), [0.1, 1.8]);
    let clean = pipeline.render_raw(&analog(&volts)).unwrap();
    let other = pipeline.render_raw(&digital).unwrap();
    // Rounding may move a few patches across a cut, where kernels are random here.
    let same = clean.planes.data().iter().zip(other.planes.data()).filter(|(a, b)| (*a - *b).abs() < 1e-5);
    assert!(same.count() as f64 > 0.99 * clean.planes.data().len() as f64);
    volts[20 * 70 + 30] = f32::NAN;
    volts[40 * 70] = f32::INFINITY;
    let holed = pipeline.render_raw(&analog(&volts)).unwrap();
    for (i, (a, b)) in clean.planes.data().iter().zip(holed.planes.data()).enumerate() {
        let (row, col) = (i % 3500 / 70, i % 70);
        let near = |r: usize, c: usize| row.abs_diff(r) <= 2 && col.abs_diff(c) <= 2;
        if near(20, 30) {
            assert!(b.is_nan());
        } else if !near(40, 0) {
            assert_eq!(a, b, "row {row}, column {col}");
        }
    }
    assert_eq!(pipeline.render_fixed(&analog(&volts)), Err(L3Error::NotDigital));
}

#[test]
fn what_does_not_fit_is_refused() {
    let pipeline = pipeline(&bayer(), 5, 2);
    let image = |rows, cols, levels: [f64; 2]| {
        raw_of(&bayer(), rows, cols, RawSamples::Digital(vec![100; rows * cols]), levels)
    };
    let levels = [BLACK, WHITE];
    assert!(matches!(pipeline.render_raw(&image(4, 9, levels)), Err(L3Error::Size { .. })));
    assert!(pipeline.render_raw(&image(5, 5, [BLACK + 0.5, WHITE])).is_ok());
    assert!(pipeline.render_fixed(&image(5, 5, [BLACK + 0.5, WHITE])).is_ok());
    for path in [Pipeline::render_raw, Pipeline::render_fixed] {
        let far = path(&pipeline, &image(5, 5, [BLACK, WHITE - 1.0]));
        assert!(matches!(far, Err(L3Error::RawLevels { .. })));
    }
    let other = raw(&knight(), 20, 20);
    assert!(matches!(pipeline.render_raw(&other), Err(L3Error::Mosaic { .. })));
    let mut planes = Planes::zeros(5, 5, 3);
    let wrong = pipeline.renderer().render_into(&image(5, 5, levels), &mut planes);
    assert!(matches!(wrong, Err(L3Error::Shape(_))));
    let classes = pipeline.classes().len();
    assert_eq!(pipeline.weights(classes - 1, 1).map(<[f32]>::len), Some(25));
    assert_eq!((pipeline.weights(classes, 0), pipeline.weights(0, 2)), (None, None));
    // Two outputs make no picture.
    let error = Isp::render(&pipeline, &image(5, 5, levels)).unwrap_err();
    assert!(error.to_string().contains("2 outputs"), "{error}");
    let picture = Isp::render(&super::tests::pipeline(&bayer(), 5, 3), &image(6, 5, levels)).unwrap();
    assert_eq!(picture.space(), ColorSpace::Xyz);
}

#[test]
fn kernels_too_large_for_16_bits_are_refused() {
    let p = pipeline(&bayer(), 3, 1);
    let mut kernels = p.kernels().clone();
    kernels.weights[4] = 1e6;
    let p = pipeline_with(&p, [BLACK, WHITE], kernels);
    let error = p.render_fixed(&raw(&bayer(), 9, 9)).unwrap_err();
    assert!(matches!(error, L3Error::NoFixedPoint(_)), "{error}");
    let error = p.fixed_kernels(WHITE, BLACK).unwrap_err();
    assert!(matches!(error, L3Error::Table(_)), "{error}");
}

#[test]
fn oriented_tables_render() {
    let axes = Axes::new(knight(), 5, Levels::logarithmic(4, 0.05, 0.8).unwrap(), noise()).unwrap();
    let pipeline = pipeline_of(axes.with_textures(Textures::Oriented), vec![0], 3, 4);
    let raw = raw(&knight(), 70, 60);
    let (float, fixed) = (pipeline.render_raw(&raw).unwrap(), pipeline.render_fixed(&raw).unwrap());
    assert!(peak_ratio_db(&float.planes, &fixed.planes).unwrap() > 60.0);
}
