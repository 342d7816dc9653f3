//! A noisy uniform grey has no pattern with the period of the mosaic's tile in pictures of quality `best`.

use std::path::Path;

use smalti::numeric::fft::RealFft2;
use smalti::numeric::philox::Stream;
use smalti_io::npy;

use crate::Place;

/// Rows and columns of the pictures.
const SIDE: usize = 384;
/// How many frequencies on either side of one of the tile measure the noise.
const AROUND: usize = 6;
/// The frequencies of a tile of 2 × 2 pixels other than 0, in cycles per picture.
const OF_TILE: [[usize; 2]; 3] = [[0, SIDE / 2], [SIDE / 2, 0], [SIDE / 2, SIDE / 2]];

/// The amplitude at each frequency of the tile relative to the standard deviation of the spectrum around it.
fn peaks(plane: &[f32]) -> [f64; 3] {
    let spectrum = RealFft2::new(SIDE, SIDE).unwrap().forward(plane).unwrap();
    // Columns beyond the middle one are left out: their powers are those of the columns before it.
    let power = |row: usize, col: usize| f64::from(spectrum[col * SIDE + row % SIDE].norm_sqr());
    OF_TILE.map(|[row, col]| {
        let cols = col.saturating_sub(AROUND)..=(col + AROUND).min(SIDE / 2);
        let near = |by: usize| cols.clone().map(move |col| power(row + SIDE + by - AROUND, col));
        let (all, own) = ((0..=2 * AROUND).flat_map(near).collect::<Vec<f64>>(), power(row, col));
        let noise = (all.iter().sum::<f64>() - own) / (all.len() - 1) as f64;
        (own / noise).sqrt()
    })
}

#[test]
fn a_wave_of_the_tile_is_a_peak() {
    let plane = |strength: f32| -> Vec<f32> {
        let mut random = Stream::new(1, 0, 0);
        let wave = |i: usize| if i.is_multiple_of(2) { strength } else { 0.0 };
        (0..SIDE * SIDE).map(|i| wave(i) + random.uniform() as f32).collect()
    };
    let ([wave, _, _], none) = (peaks(&plane(0.02)), peaks(&plane(0.0)));
    // An amplitude of 0.01 in noise of variance 1/12: 0.01 · 384 · √12 = 13.3.
    assert!((wave - 13.3).abs() < 4.0, "{wave}");
    assert!(none.iter().all(|&peak| peak < 3.0), "{none:?}");
}

/// In the mean of four captures noise is half as strong, a pattern is not. The spectrum is real at these frequencies: of nine values of noise
/// alone, the largest exceeds 3 in at most one case of 40.
#[test]
fn a_uniform_grey_has_no_pattern_of_the_tile() {
    let place = Place::new();
    place.ok("train bayer --quality best -o best.l3 --quiet");
    for luminance in [1, 10, 80] {
        let mut sums = vec![0.0; 3 * SIDE * SIDE];
        for seed in 1..=4 {
            let scene = format!("--scene uniform --luminance {luminance} --seed {seed}");
            let size = format!("--set sensor.rows={SIDE} --set sensor.cols={SIDE}");
            place.ok(&format!("simulate bayer {scene} {size} -o grey --quiet"));
            place.ok("render grey/raw.dng --pipeline best.l3 --quality best -o grey.npy --quiet");
            let picture = npy::from_bytes(&place.read("grey.npy"), Path::new("grey.npy")).unwrap();
            assert_eq!(picture.shape, [3, SIDE, SIDE]);
            sums.iter_mut().zip(picture.to_f32()).for_each(|(sum, value)| *sum += value);
        }
        let all: Vec<[f64; 3]> = sums.chunks_exact(SIDE * SIDE).map(peaks).collect();
        assert!(all.as_flattened().iter().all(|&peak| peak < 3.0), "{luminance} cd/m²: {all:?}");
    }
}
