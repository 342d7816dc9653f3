//! Random mosaics with a blue-noise distribution: irregular, so that aliasing turns into noise, yet uniform
//! in density.

use super::{CfaError, Mosaic};
use crate::numeric::philox::Stream;
use crate::numeric::require;

/// Separates these random numbers from other uses of the seed.
const PURPOSE: u32 = 0x4346_4101;

/// Maximum number of sweeps over all pairs of cells; most tiles converge earlier.
const MAX_SWEEPS: usize = 30;

/// A random tile that distributes each channel evenly with periodic boundaries. The channels have equal
/// numbers of cells, to within one. Equal arguments give the same tile on every machine.
///
/// The aim is that of Condat (2010): chrominance with a blue-noise spectrum. The method minimises the
/// void-and-cluster energy (Ulichney 1993). Every two cells of a channel repel each other by a Gaussian of
/// their distance, and cells are swapped while this reduces the sum.
///
/// # Errors
/// When the number of channels is not within 2–26, the tile has fewer cells than channels, or it has more
/// than 4096 cells.
pub fn blue_noise(channels: usize, rows: usize, cols: usize, seed: u64) -> Result<Mosaic, CfaError> {
    let name = "the number of channels of a random mosaic";
    require((2..=26).contains(&channels), name, channels as f64, "2 to 26")?;
    let count = rows.saturating_mul(cols);
    let (name, expected) = ("the number of cells of a random tile", "at least one per channel, at most 4096");
    require((channels..=4096).contains(&count), name, count as f64, expected)?;
    let mut random = Stream::new(seed, PURPOSE, 0);
    let mut cells: Vec<u8> = (0..count).map(|i| (i % channels) as u8).collect();
    for last in (1..count).rev() {
        cells.swap(last, random.below(last as u32 + 1) as usize);
    }

    // A channel with 1 in n cells has a mean spacing of √n. A standard deviation of 0.6 of that limits the
    // interaction to neighbours.
    let sigma = 0.6 * (channels as f64).sqrt();
    let (down, across) = (periodic_gaussian(rows, sigma), periodic_gaussian(cols, sigma));
    let kernel =
        |a: usize, b: usize| down[(a / cols).abs_diff(b / cols)] * across[(a % cols).abs_diff(b % cols)];
    // The energy that each cell would have with each channel.
    let mut field = vec![vec![0.0; count]; channels];
    for (at, &channel) in cells.iter().enumerate() {
        field[usize::from(channel)].iter_mut().enumerate().for_each(|(i, f)| *f += kernel(i, at));
    }
    for _ in 0..MAX_SWEEPS {
        let mut moved = false;
        for a in 0..count {
            for b in a + 1..count {
                let (p, q) = (usize::from(cells[a]), usize::from(cells[b]));
                let gain = field[p][a] - field[p][b] + field[q][b]
                    - field[q][a]
                    - 2.0 * (kernel(a, a) - kernel(a, b));
                // The threshold prevents rounding from swapping two equal states for ever.
                if p != q && gain > 1e-9 {
                    let change = |i: usize| kernel(i, b) - kernel(i, a);
                    field[p].iter_mut().enumerate().for_each(|(i, f)| *f += change(i));
                    field[q].iter_mut().enumerate().for_each(|(i, f)| *f -= change(i));
                    cells.swap(a, b);
                    moved = true;
                }
            }
        }
        if !moved {
            break;
        }
    }
    Mosaic::new(rows, cols, cells)
}

/// A Gaussian of the distance on a circle of `length` cells, with all its images within six standard
/// deviations.
fn periodic_gaussian(length: usize, sigma: f64) -> Vec<f64> {
    let images = (6.0 * sigma / length as f64).ceil() as i32 + 1;
    let at = |d: usize| {
        let term = |m: i32| {
            let x = (d as f64 + f64::from(m) * length as f64) / sigma;
            libm::exp(-0.5 * x * x)
        };
        (-images..=images).map(term).sum()
    };
    (0..length).map(at).collect()
}
