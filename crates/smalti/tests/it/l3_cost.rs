//! What a pixel costs, as docs/l3.md states it.
#![allow(clippy::unwrap_used)]

use smalti::l3::{
    Axes, Class, Kernels, Levels, Origin, Pipeline, PipelineParts, REFINEMENT_INPUTS, Refinement,
    RefinementAxes, RefinementClass, Textures,
};
use smalti::sensor::{Mosaic, SignalNoise};

/// A pipeline of both stages for Bayer with patches of `side` × `side` pixels; all kernels are zeros.
fn pipeline(side: usize, textures: Textures) -> Pipeline {
    let noise = SignalNoise {
        constant: 1e-6,
        per_signal: 1e-4,
        per_signal_squared: 0.0,
        row: 0.0,
        column: 0.0,
        above: None,
    };
    let mosaic = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
    let axes =
        Axes::new(mosaic, side, Levels::new(vec![0.1]).unwrap(), noise).unwrap().with_textures(textures);
    let count = axes.positions() * axes.level_count() * textures.count();
    let parts = PipelineParts {
        saturations: vec![0],
        outputs: ["X", "Y", "Z"].map(String::from).to_vec(),
        channel_names: ["R", "G", "B"].map(String::from).to_vec(),
        black_level: 0.0,
        white_level: 1023.0,
        trained: vec![[0.0, 1.0]; axes.positions()],
        classes: vec![Class { count: 0, origin: Origin::Learned }; count],
        kernels: Kernels { weights: vec![0.0; count * 3 * axes.taps()], offsets: vec![0.0; count * 3] },
        provenance: String::new(),
        axes,
    };
    let axes = RefinementAxes::new(Levels::new(vec![0.1]).unwrap(), [1e-4, 0.0, 0.0]).unwrap();
    let count = axes.count();
    let classes = vec![RefinementClass { count: 0, is_learned: false }; count];
    let weights = vec![0.0; count * 3 * REFINEMENT_INPUTS];
    let second = Refinement::new(axes, classes, weights, vec![0.0; count * 3]).unwrap();
    Pipeline::from_parts(parts).unwrap().with_refinement(Some(second)).unwrap()
}

/// A convolution of a network: inputs, outputs, side, and the side in pixels of the squares of which each has one output. A transposed convolution of
/// 2 × 2 reads one pixel for each output.
type Convolution = [u64; 4];

/// The U-Net of the page, with a number of convolutions in each block.
fn network(convolutions: usize) -> Vec<Convolution> {
    let block = |inputs: u64, outputs: u64, every: u64| {
        (0..convolutions).map(move |i| [if i == 0 { inputs } else { outputs }, outputs, 3, every])
    };
    let mut all: Vec<Convolution> = Vec::new();
    for (inputs, outputs, every) in [(7, 64, 1), (64, 128, 2), (128, 256, 4)] {
        all.extend(block(inputs, outputs, every));
    }
    for (inputs, outputs, every) in [(256, 128, 2), (128, 64, 1)] {
        all.push([inputs, outputs, 1, every]);
        all.extend(block(2 * outputs, outputs, every));
    }
    all.push([64, 3, 1, 1]);
    all
}

#[test]
fn the_page_states_what_is_counted() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/l3.md")).unwrap();
    let counts = pipeline(5, Textures::Oriented).multiply_adds();
    let per_pixel: Vec<f64> = counts.iter().map(|c| c.per_pixel).collect();
    let all = |steps: &[f64]| steps.iter().sum::<f64>();
    let grouped = |n: u64| if n < 1000 { n.to_string() } else { format!("{} {:03}", n / 1000, n % 1000) };
    let mut rows: Vec<u64> = per_pixel.iter().map(|n| n.round() as u64).collect();
    rows.insert(2, all(&per_pixel[..2]).round() as u64);
    rows.push(all(&per_pixel).round() as u64);
    for convolutions in [1, 2] {
        let cost =
            |[inputs, outputs, side, every]: &Convolution| inputs * outputs * side * side / (every * every);
        rows.push(network(convolutions).iter().map(cost).sum());
    }
    let table = page.split_once("| multiply-adds per pixel |").unwrap().1;
    let stated: Vec<String> = table
        .lines()
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.rsplit('|').nth(1).unwrap().trim_matches([' ', '*']).to_owned())
        .collect();
    assert_eq!(stated, rows.iter().map(|n| grouped(*n)).collect::<Vec<_>>());
    // The weights: a transposed convolution has four of each of its inputs and outputs.
    for (convolutions, stated) in [(1, "0.91 million"), (2, "1.86 million")] {
        let transposed = [[256, 128, 1, 2], [128, 64, 1, 1]];
        let weights = |c: &Convolution| c[0] * c[1] * if transposed.contains(c) { 4 } else { c[2] * c[2] };
        let weights: u64 = network(convolutions).iter().map(weights).sum();
        let rounded = format!("{:.2} million", weights as f64 / 1e6);
        assert_eq!(rounded, stated);
        assert!(page.contains(stated));
    }
}

/// Multiply-adds grow with the patch and the texture classes as the sizes of the kernels do.
#[test]
fn kernels_cost_their_taps() {
    for side in [3, 5, 7, 9] {
        let of = |textures| -> Vec<f64> {
            pipeline(side, textures).multiply_adds().iter().map(|c| c.per_pixel).collect()
        };
        let (plain, oriented) = (of(Textures::None), of(Textures::Oriented));
        assert_eq!(plain[1], (3 * side * side) as f64);
        // The roots need a matrix, three products and three square roots.
        assert_eq!(plain[4], (3 * REFINEMENT_INPUTS + 15) as f64);
        assert_eq!(plain[1..], oriented[1..]);
        // Four products for the gradient and three of its parts in every row of the patch, and five for the orientation.
        assert_eq!(oriented[0] - of(Textures::FlatTexture)[0], (7 * side + 5) as f64);
        let fast = pipeline(side, Textures::None).with_refinement(None).unwrap().multiply_adds();
        assert_eq!(fast.iter().map(|c| c.per_pixel).collect::<Vec<_>>(), plain[..2]);
    }
}
