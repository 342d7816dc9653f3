//! Against the definition, pixel by pixel.

use super::super::window::mirrored;
use super::*;
use crate::isp::source::Source;
use crate::numeric::philox::Stream;
use crate::sensor::{Mosaic, RawImage, RawSamples, Sampling, SignalNoise};

fn axes(rows: usize, cols: usize, cells: Vec<u8>, side: usize) -> Axes {
    let noise = SignalNoise { constant: 1e-5, per_signal: 1e-4, ..SignalNoise::default() };
    let levels = super::super::Levels::logarithmic(7, 0.02, 0.8).unwrap();
    Axes::new(Mosaic::new(rows, cols, cells).unwrap(), side, levels, noise).unwrap()
}

/// From dark to clipped, with flat parts and noise.
fn image(mosaic: &Mosaic, rows: usize, cols: usize) -> RawImage {
    let mut random = Stream::new(6, 1, 2);
    let mut sample = |i: usize| {
        let (row, col) = (i / cols, i % cols);
        let noise = if (row / 5 + col / 9) % 2 == 0 { random.below(900) } else { 0 };
        ((100 + 3600 * col / cols) as u32 + noise).min(4095) as u16
    };
    let samples = RawSamples::Digital((0..rows * cols).map(&mut sample).collect());
    let names = (0..mosaic.channels()).map(|c| c.to_string()).collect();
    RawImage::new(rows, cols, samples, Sampling::Mosaic(mosaic.clone()), names, 64.0, 4095.0).unwrap()
}

/// Mean, level and texture, and clipped channels of the patch around a pixel, by their definition. The mean is summed down the columns
/// and then along the row.
fn defined(axes: &Axes, raw: &RawImage, samples: &[f32], [row, col]: [usize; 2]) -> (f32, u32, u32) {
    let (tile, side, half) = (axes.mosaic(), axes.side(), (axes.side() / 2) as isize);
    let at = |r: isize, c: isize| {
        let line = mirrored(row as isize + r, raw.rows(), tile.rows()) * raw.cols();
        samples[line + mirrored(col as isize + c, raw.cols(), tile.cols())]
    };
    let column = |c: isize| (-half..=half).fold(0.0f32, |sum, r| sum + at(r, c));
    let mean = (-half..=half).fold(0.0f32, |sum, c| sum + column(c)) * (1.0 / axes.taps() as f32);
    let mut differences = Vec::new();
    for pairs in axes.contrast_pairs() {
        let [down, right] = pairs.shift;
        for r in pairs.rows[0]..=pairs.rows[1] {
            for c in pairs.cols[0]..=pairs.cols[1] {
                differences.push(f64::from((at(r, c) - at(r + down, c + right)).abs()));
            }
        }
    }
    let contrast = differences.iter().sum::<f64>() / differences.len() as f64;
    let ([v0, v1, v2], x) = (axes.contrast_limit(), f64::from(mean.max(0.0)));
    let texture = u32::from(contrast * contrast > v0 + v1 * x + v2 * x * x);
    let position = row % tile.rows() * tile.cols() + col % tile.cols();
    let mut clipped = 0;
    for tap in 0..axes.taps() {
        let (r, c) = ((tap / side) as isize - half, (tap % side) as isize - half);
        if at(r, c) >= axes.clip() as f32 {
            clipped |= 1u32 << axes.channel_of(position, tap);
        }
    }
    (mean, 2 * axes.levels_at(position).level_of(mean) as u32 + texture, clipped)
}

#[test]
fn rows_are_classified_as_defined() {
    let (rows, cols) = (12, 70);
    let (mut textures, mut clipped) = ([0; 2], 0);
    for axes in [
        axes(2, 2, vec![0, 1, 1, 2], 5),
        axes(3, 3, (0..9).collect(), 7),
        // The tile is wider than the patch: samples beyond it are compared.
        axes(1, 8, (0..8).collect(), 3),
    ] {
        let tile = axes.mosaic();
        let raw = image(tile, rows, cols);
        let (samples, classifier) = (raw.normalized(), Classifier::new(&axes));
        let mut window = Window::default();
        window.read(Source::of(&raw), 0, rows, classifier.margin(), [tile.rows(), tile.cols()]);
        let mut classes = RowClasses::default();
        for row in 0..rows {
            for first in [0, 19] {
                classifier.row(&window, row, [row, 0], first..cols, &mut classes);
                for col in first..cols {
                    let i = col - first;
                    let found = (classes.mean[i], classes.local[i], classes.saturation[i]);
                    let expected = defined(&axes, &raw, &samples, [row, col]);
                    assert_eq!(found, expected, "pixel {row}, {col}, patch {}", axes.side());
                    textures[(found.1 % 2) as usize] += 1;
                    clipped += u32::from(found.2 != 0);
                }
            }
        }
    }
    assert!(textures.iter().all(|n| *n > 100) && clipped > 100, "{textures:?} {clipped}");
}

#[test]
fn the_search_for_levels_may_begin_anywhere() {
    let axes = axes(2, 2, vec![0, 1, 1, 2], 5).with_levels_by_position(&[0.5, 0.8, 1.0]).unwrap();
    let mut random = Stream::new(7, 1, 2);
    for row in 0..2 {
        let (cuts, mut below) = (Cuts::new(&axes, row, run_of(2)), 0);
        for block in 0..200 {
            // Blocks in a row differ much, the means of a block little.
            let light = random.uniform();
            let means: [f32; LANES] =
                std::array::from_fn(|_| (light * (0.7 + 0.6 * random.uniform())) as f32);
            let column = block % 40;
            let levels = cuts.levels(&means, column, &mut below);
            let expected: [u32; LANES] =
                std::array::from_fn(|i| axes.levels_at(row * 2 + (column + i) % 2).level_of(means[i]) as u32);
            assert_eq!(levels, expected);
            // The next search begins at the cuts that are below all means.
            assert_eq!(Some(below as u32), expected.iter().copied().min());
        }
    }
}
