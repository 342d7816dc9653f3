//! Laws of the patterns that kernels do not pass on.

use super::super::inputs::{COUNT, LINEAR, OWN, SMOOTH, plane_of};
use super::super::tile_pattern::{ERROR, TilePattern};
use super::*;

/// Classes of level 3 that are flat and of the greatest strength.
fn classes(axes: &RefinementAxes) -> [u32; 2] {
    let structures = axes.structures() as u32;
    [3 * structures, 4 * structures - 1]
}

#[test]
fn a_single_pixel_has_no_pattern() {
    let axes = axes();
    let pattern = TilePattern::new(&axes, [1, 1]);
    assert!(pattern.of_class(classes(&axes)[0]).iter().all(|v| *v == 0.0));
}

/// The error of one position varies over a tile of n pixels with a variance of (1 − 1/n) / n, and n positions have one. Smoothing over neighbours
/// that all count as they are removes what alternates between pixels.
#[test]
fn inputs_vary_with_the_errors_of_positions() {
    let axes = RefinementAxes::new(axes().levels().clone(), [1e-8, 1e-8, 0.0]).unwrap();
    for (tile, count) in [([2, 2], 4.0), ([4, 4], 16.0), ([3, 3], 9.0), ([2, 4], 8.0)] {
        let pattern = TilePattern::new(&axes, tile);
        let [flat, strong] = classes(&axes);
        assert!(pattern.of_class(strong).is_empty());
        let covariance = pattern.of_class(flat);
        let error = (ERROR * f64::from(axes.brightness(3))).powi(2);
        let of = |a: usize, b: usize| covariance[a * COUNT + b] / error;
        for own in OWN {
            assert!((of(own, own) / (1.0 - 1.0 / count) - 1.0).abs() < 1e-3, "{tile:?}: {}", of(own, own));
        }
        for (a, b) in (0..COUNT).flat_map(|a| (0..COUNT).map(move |b| (a, b))) {
            let alone = a >= LINEAR || b >= LINEAR || plane_of(a) != plane_of(b);
            assert!(!alone || of(a, b) == 0.0, "{tile:?}: {a} and {b}");
            assert_eq!(of(a, b), of(b, a));
        }
        // The finest smooth picture: its own errors, and hardly any of those of the picture where the tile has two rows and columns.
        let finest = of(SMOOTH, SMOOTH) - (1.0 - 1.0 / count);
        assert!(finest >= 0.0 && (tile != [2, 2] || finest < 0.02), "{tile:?}: {finest}");
    }
}

/// What is left of the errors of positions in the output of the kernels of uniform areas.
#[test]
fn the_kernels_of_uniform_areas_do_not_pass_a_pattern_on() {
    let statistics = learned(1..7);
    let axes = axes();
    for tile in [[2, 2], [4, 4]] {
        let pattern = TilePattern::new(&axes, tile);
        let error = ERROR * f64::from(axes.brightness(3));
        let left = |refinement: Refinement| {
            // The class that has most of the uniform areas.
            let structures = axes.structures();
            let of_level = 3 * structures..4 * structures;
            let flat = of_level.filter(|&c| !pattern.of_class(c as u32).is_empty());
            let flat = flat.max_by_key(|&c| refinement.classes()[c].count).unwrap();
            assert!(refinement.classes()[flat].is_learned);
            let weights: Vec<f32> = refinement.weights().skip(flat * 3 * COUNT).take(3 * COUNT).collect();
            let of_output = |w: &[f32]| {
                let line = |(row, w_i): (&[f64], &f32)| {
                    let sum: f64 = row.iter().zip(w).map(|(c, w_j)| c * f64::from(*w_j)).sum();
                    sum * f64::from(*w_i)
                };
                let variance: f64 = pattern.of_class(flat as u32).chunks_exact(COUNT).zip(w).map(line).sum();
                variance.sqrt() / error
            };
            weights.chunks_exact(COUNT).map(of_output).fold(0.0, f64::max)
        };
        let (heeded, ignored) =
            (left(statistics.solve(tile).unwrap()), left(statistics.solve([1, 1]).unwrap()));
        assert!(heeded < 0.05 && ignored > 10.0 * heeded, "{tile:?}: {heeded}, without heed {ignored}");
    }
}
