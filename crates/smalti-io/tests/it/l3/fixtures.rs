//! Pipelines and statistics of no meaning, with every part in use.

use std::collections::BTreeMap;

use smalti::l3::{
    Axes, Class, ClassKey, Kernels, Levels, Moments, Origin, Pipeline, PipelineParts, REFINEMENT_INPUTS,
    Refinement, RefinementAxes, RefinementClass, Statistics, Textures,
};
use smalti::numeric::philox::Stream;
use smalti::sensor::{Mosaic, NoiseAbove, RawImage, RawSamples, Sampling, SignalNoise};

/// What a fixture is made with.
#[derive(Debug, Clone)]
pub(crate) struct Recipe {
    pub(crate) tile: (usize, usize, Vec<u8>),
    pub(crate) side: usize,
    pub(crate) cuts: Vec<f32>,
    pub(crate) by_position: bool,
    pub(crate) textures: Textures,
    pub(crate) saturations: Vec<u32>,
    pub(crate) outputs: usize,
    pub(crate) levels: [f64; 2],
    pub(crate) seed: u64,
}

pub(crate) fn bayer() -> Recipe {
    Recipe {
        tile: (2, 2, vec![0, 1, 1, 2]),
        side: 5,
        cuts: vec![0.05, 0.1, 0.2, 0.45],
        by_position: true,
        textures: Textures::FlatTexture,
        saturations: vec![0, 1, 2, 7],
        outputs: 3,
        levels: [64.0, 1023.0],
        seed: 1,
    }
}

/// One with each peculiarity: tiles that repeat within themselves or are wide, no cuts, every kind of texture, a patch smaller than
/// the tile, levels with a fraction.
pub(crate) fn recipes() -> Vec<Recipe> {
    let knight = (0..25).map(|i| ((i % 5 + 3 * (i / 5)) % 5) as u8).collect();
    vec![
        bayer(),
        Recipe { textures: Textures::Oriented, side: 3, by_position: false, seed: 2, ..bayer() },
        Recipe {
            tile: (5, 5, knight),
            side: 7,
            textures: Textures::Oriented,
            saturations: vec![0, 3, 16, 31],
            outputs: 1,
            levels: [12.375, 4095.5],
            seed: 3,
            ..bayer()
        },
        Recipe {
            tile: (1, 3, vec![0, 1, 2]),
            cuts: vec![],
            textures: Textures::None,
            saturations: vec![0],
            outputs: 4,
            levels: [0.0, 65535.0],
            seed: 4,
            ..bayer()
        },
        Recipe {
            tile: (4, 4, vec![0, 1, 3, 1, 1, 2, 1, 0, 3, 1, 0, 1, 1, 0, 1, 2]),
            side: 3,
            by_position: false,
            outputs: 2,
            seed: 5,
            ..bayer()
        },
    ]
}

pub(crate) fn axes(r: &Recipe) -> Axes {
    let mosaic = Mosaic::new(r.tile.0, r.tile.1, r.tile.2.clone()).unwrap();
    // Thirds have no end in binary nor in decimal.
    let noise = SignalNoise {
        constant: 1e-6 / 3.0,
        per_signal: 1e-4 / 7.0,
        per_signal_squared: 1e-7,
        row: 2e-7,
        column: 1e-300,
        above: Some(NoiseAbove { signal: 0.3, constant: 1e-5 / 3.0 }),
    };
    let positions = mosaic.cells().len();
    let set = |i: usize| {
        Levels::new(r.cuts.iter().map(|c| c * (1.0 + 0.01 * i as f32)).collect::<Vec<f32>>()).unwrap()
    };
    let levels = (0..if r.by_position { positions } else { 1 }).map(set).collect();
    Axes::new(mosaic, r.side, set(0), noise)
        .unwrap()
        .with_levels(levels)
        .unwrap()
        .with_contrast(1.7, 0.1 + 0.2)
        .unwrap()
        .with_clip(0.98)
        .unwrap()
        .with_textures(r.textures)
}

pub(crate) fn outputs(r: &Recipe) -> Vec<String> {
    ["X", "Y", "near \"infrared\" °", "reflectance */ 700 nm"][..r.outputs]
        .iter()
        .map(ToString::to_string)
        .collect()
}

pub(crate) fn channel_names(axes: &Axes) -> Vec<String> {
    (0..axes.mosaic().channels()).map(|c| format!("C{c}")).collect()
}

pub(crate) fn parts(r: &Recipe) -> PipelineParts {
    let axes = axes(r);
    let mut random = Stream::new(r.seed, 7, 7);
    let count = axes.positions() * r.saturations.len() * axes.level_count() * axes.textures().count();
    let mut values = |n: usize, size: f64| -> Vec<f32> {
        (0..n).map(|_| ((random.uniform() - 0.4) * size) as f32).collect()
    };
    let mut kernels = Kernels {
        weights: values(count * r.outputs * axes.taps(), 0.4),
        offsets: values(count * r.outputs, 0.1),
    };
    // As learned ones, kernels of some classes are larger than those of others.
    let (taps, size) = (axes.taps(), |kernel: usize| 0.5f32.powi((kernel / r.outputs % 6) as i32));
    kernels.weights.iter_mut().enumerate().for_each(|(i, w)| *w *= size(i / taps));
    kernels.offsets.iter_mut().enumerate().for_each(|(i, o)| *o *= size(i));
    // Bits that text would lose.
    kernels.weights[0] = -0.0;
    kernels.weights[1] = f32::MIN_POSITIVE / 8.0;
    let class = |i: usize| Class { count: u64::MAX >> (i % 64), origin: Origin::ALL[i % Origin::ALL.len()] };
    let trained = (0..axes.positions()).map(|i| [0.01 * i as f32, f32::INFINITY]).collect();
    PipelineParts {
        saturations: r.saturations.clone(),
        outputs: outputs(r),
        channel_names: channel_names(&axes),
        black_level: r.levels[0],
        white_level: r.levels[1],
        trained,
        classes: (0..count).map(class).collect(),
        kernels,
        provenance: r#"{"scenes": ["dead-leaves", "caf\u00e9"], "λ": 0.1}"#.into(),
        axes,
    }
}

/// A pipeline whose outputs are X, Y, Z.
pub(crate) fn picture_pipeline() -> Pipeline {
    picture_pipeline_of(&bayer())
}

/// The same with other axes.
pub(crate) fn picture_pipeline_of(r: &Recipe) -> Pipeline {
    let outputs = ["X", "Y", "Z"].map(String::from).to_vec();
    Pipeline::from_parts(PipelineParts { outputs, ..parts(&Recipe { outputs: 3, ..r.clone() }) }).unwrap()
}

/// A second stage with random kernels that sum to about one.
pub(crate) fn second_stage() -> Refinement {
    second_stage_of(
        RefinementAxes::new(Levels::logarithmic(3, 0.01, 0.8).unwrap(), [1e-4, 1e-4, 0.0]).unwrap(),
    )
}

/// The same with other axes.
pub(crate) fn second_stage_of(axes: RefinementAxes) -> Refinement {
    let mut random = Stream::new(3, 1, 4);
    let mut numbers =
        |n: usize, size: f64| (0..n).map(|_| (random.uniform() * size) as f32).collect::<Vec<_>>();
    let (weights, offsets) =
        (numbers(axes.count() * 3 * REFINEMENT_INPUTS, 0.03), numbers(axes.count() * 3, 0.01));
    let class = |i: usize| RefinementClass { count: 7 * i as u64, is_learned: i.is_multiple_of(3) };
    let classes = (0..axes.count()).map(class).collect();
    Refinement::new(axes, classes, weights, offsets).unwrap()
}

pub(crate) fn pipeline(r: &Recipe) -> Pipeline {
    Pipeline::from_parts(parts(r)).unwrap()
}

/// A raw image with flat parts, edges, noise and clipped samples.
pub(crate) fn raw(r: &Recipe, rows: usize, cols: usize, phase: [usize; 2]) -> (RawImage, Vec<u16>) {
    let mut random = Stream::new(r.seed, 8, 8);
    let [black, white] = r.levels;
    let sample = |i: usize, random: &mut Stream| {
        let (row, col) = (i / cols, i % cols);
        let (r, c) = (row % 8, col % 10);
        let scene = match (row / 8 + col / 10) % 5 {
            0 => 0.02 * (1 + row % 3) as f64,
            1 => 0.3,
            2 => f64::from(u8::from(r + c > 8)) * 0.7 + 0.2,
            3 => f64::from(u8::from(c > r)) * 0.7 + 0.2,
            _ => 0.9 + 0.2 * random.uniform(),
        };
        let noisy = scene + 0.02 * (random.uniform() - 0.5);
        (black + noisy * (white - black)).round().clamp(0.0, white.min(65535.0)) as u16
    };
    let samples: Vec<u16> = (0..rows * cols).map(|i| sample(i, &mut random)).collect();
    let axes = axes(r);
    let sampling = Sampling::Mosaic(axes.mosaic().shifted(phase[0], phase[1]));
    let digital = RawSamples::Digital(samples.clone());
    let raw = RawImage::new(rows, cols, digital, sampling, channel_names(&axes), black, white).unwrap();
    (raw, samples)
}

pub(crate) fn statistics(r: &Recipe, levels: Option<[f64; 2]>) -> Statistics {
    let axes = axes(r);
    let mut random = Stream::new(r.seed, 9, 9);
    let size = 1 + axes.taps() + r.outputs;
    let moments = |random: &mut Stream| {
        let mut sums: Vec<f64> = (0..size * (size + 1) / 2).map(|_| random.uniform() / 3.0).collect();
        sums[0] = f64::from(random.next_u32());
        Moments::from_sums(axes.taps(), r.outputs, sums).unwrap()
    };
    let keys = (0..axes.positions() as u32).flat_map(|position| {
        r.saturations.iter().map(move |&saturation| ClassKey { position, saturation, level: 0, texture: 0 })
    });
    let classes: BTreeMap<ClassKey, Moments> = keys.map(|k| (k, moments(&mut random))).collect();
    let trained = vec![[f32::INFINITY, f32::NEG_INFINITY]; axes.positions()];
    let names = channel_names(&axes);
    Statistics::from_parts(axes.clone(), outputs(r), names, levels, true, trained, classes).unwrap()
}
