//! A noisy uniform grey has no pattern with the period of the mosaic's tile in pictures of quality `best`.

use std::f64::consts::TAU;
use std::path::Path;

use smalti::numeric::philox::Stream;
use smalti_io::npy;

use crate::Place;

/// Rows and columns of the pictures.
const SIDE: usize = 384;
/// Frequencies on either side of one of the tile that show how strong noise is there.
const AROUND: isize = 6;
/// The frequencies of a tile of two rows and columns, but 0, in cycles per picture.
const OF_TILE: [[usize; 2]; 3] = [[0, SIDE / 2], [SIDE / 2, 0], [SIDE / 2, SIDE / 2]];

/// The power of a plane at the frequencies up to [`AROUND`] from one.
fn powers(plane: &[f32], [down, right]: [usize; 2]) -> Vec<f64> {
    let around = |centre: usize| (-AROUND..=AROUND).map(move |by| centre as f64 + by as f64);
    let wave = |frequency: f64, at: usize| (TAU * frequency * at as f64 / SIDE as f64).sin_cos();
    let mut all = Vec::new();
    for frequency in around(right) {
        let waves: Vec<(f64, f64)> = (0..SIDE).map(|col| wave(frequency, col)).collect();
        let of_row = |row: &[f32]| {
            let each =
                row.iter().zip(&waves).map(|(v, (sin, cos))| [f64::from(*v) * cos, -f64::from(*v) * sin]);
            each.fold([0.0; 2], |[re, im], [a, b]| [re + a, im + b])
        };
        let rows: Vec<[f64; 2]> = plane.chunks_exact(SIDE).map(of_row).collect();
        for frequency in around(down) {
            let turned = rows.iter().enumerate().map(|(row, [re, im])| {
                let (sin, cos) = wave(frequency, row);
                [re * cos + im * sin, im * cos - re * sin]
            });
            let [re, im] = turned.fold([0.0; 2], |[re, im], [a, b]| [re + a, im + b]);
            all.push(re * re + im * im);
        }
    }
    all
}

/// The amplitude at a frequency of the tile relative to the standard deviation of the spectrum around it.
fn peak(plane: &[f32], frequency: [usize; 2]) -> f64 {
    // The mean is not part of the noise around the frequency 0 of rows or columns.
    let mean = plane.iter().map(|v| f64::from(*v)).sum::<f64>() / plane.len() as f64;
    let plane: Vec<f32> = plane.iter().map(|v| (f64::from(*v) - mean) as f32).collect();
    let mut powers = powers(&plane, frequency);
    let own = powers.remove(powers.len() / 2);
    (own * powers.len() as f64 / powers.iter().sum::<f64>()).sqrt()
}

#[test]
fn a_wave_of_the_tile_is_a_peak() {
    let plane = |strength: f32| -> Vec<f32> {
        let mut random = Stream::new(1, 0, 0);
        let wave = |i: usize| if i.is_multiple_of(2) { strength } else { 0.0 };
        (0..SIDE * SIDE).map(|i| wave(i) + random.uniform() as f32).collect()
    };
    let peaks = |strength| OF_TILE.map(|frequency| peak(&plane(strength), frequency));
    // The noise has a variance of 1/12, so that half of a strength of 0.02 is 13 times its share of the frequency.
    let ([wave, _, _], none) = (peaks(0.02), peaks(0.0));
    assert!((wave - 13.3).abs() < 4.0, "{wave}");
    assert!(none.iter().all(|&peak| peak < 3.0), "{none:?}");
}

/// Of 36 values of noise alone, the largest exceeds 3 once in 200 cases.
#[test]
fn a_uniform_grey_has_no_pattern_of_the_tile() {
    let place = Place::new();
    place.ok("train bayer --quality best -o best.l3 --quiet");
    for luminance in [1, 10, 80] {
        let mut largest = 0.0f64;
        for seed in 1..=4 {
            let scene = format!("--scene uniform --luminance {luminance} --seed {seed}");
            let size = format!("--set sensor.rows={SIDE} --set sensor.cols={SIDE}");
            place.ok(&format!("simulate bayer {scene} {size} -o grey --quiet"));
            place.ok("render grey/raw.dng --pipeline best.l3 --quality best -o grey.npy --quiet");
            let picture = npy::from_bytes(&place.read("grey.npy"), Path::new("grey.npy")).unwrap();
            assert_eq!(picture.shape, [3, SIDE, SIDE]);
            for plane in picture.to_f32().chunks_exact(SIDE * SIDE) {
                largest = OF_TILE.iter().map(|&f| peak(plane, f)).fold(largest, f64::max);
            }
        }
        assert!(largest < 3.0, "{luminance} cd/m²: {largest}");
    }
}
