//! Random mosaics with blue noise: irregular, so that aliasing turns into noise, yet evenly spread.

use super::{CfaError, Mosaic};
use crate::numeric::philox::Stream;

/// Separates these random numbers from other uses of the same seed.
const PURPOSE: u32 = 0x4346_4101;

/// Sweeps over all pairs of cells; most tiles come to rest before.
const MAX_SWEEPS: usize = 30;

/// A random tile in which each channel is spread evenly over the torus, in equal numbers of cells (to one). The
/// same arguments give the same tile on every machine.
///
/// The aim is that of Condat (2010), chrominance with a blue-noise spectrum; the method is void-and-cluster's
/// energy (Ulichney 1993): every two cells of the same channel repel each other by a Gaussian of their
/// distance, and two cells are swapped as long as this lowers the sum.
///
/// # Errors
/// When there are fewer than 2 or more than 26 channels, fewer cells than channels, or more than 4096 cells.
pub fn blue_noise(channels: usize, rows: usize, cols: usize, seed: u64) -> Result<Mosaic, CfaError> {
    let parameter = |name: &str, value: usize, expected| {
        Err(CfaError::Parameter { name: name.into(), value: value as f64, expected })
    };
    if !(2..=26).contains(&channels) {
        return parameter("the number of channels of a random mosaic", channels, "2 to 26");
    }
    let count = rows.saturating_mul(cols);
    if count < channels || count > 4096 {
        return parameter(
            "the number of cells of a random tile",
            count,
            "at least one per channel, at most 4096",
        );
    }
    let mut random = Stream::new(seed, PURPOSE, 0);
    let mut cells: Vec<u8> = (0..count).map(|i| (i % channels) as u8).collect();
    for last in (1..count).rev() {
        cells.swap(last, random.below(last as u32 + 1) as usize);
    }

    // A channel in 1 of n cells has its cells √n apart; 0.6 of that makes neighbours feel each other and little
    // beyond.
    let sigma = 0.6 * (channels as f64).sqrt();
    let (down, across) = (periodic_gaussian(rows, sigma), periodic_gaussian(cols, sigma));
    let kernel =
        |a: usize, b: usize| down[(a / cols).abs_diff(b / cols)] * across[(a % cols).abs_diff(b % cols)];
    // What each cell would feel if it had each channel.
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
                // Rounding must not keep two equal states swapping for ever.
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

/// A Gaussian of the distance on a circle of `length` cells, with all its images within six deviations.
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
