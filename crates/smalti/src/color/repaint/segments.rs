//! Segments of a photograph, and how much of each neighbouring segment a pixel takes.
//!
//! After R. Achanta et al. (2012), "SLIC superpixels compared to state-of-the-art superpixel methods", *IEEE
//! Transactions on Pattern Analysis and Machine Intelligence* 34(11): k-means in colour and position from the centres of
//! square cells, in which a pixel looks at the nine segments around its cell.

use rayon::prelude::*;

/// Side of a cell, in pixels.
const SIDE: usize = 16;
/// The difference of colour, ΔE*ab, that counts as much as the side of a cell.
const COMPACTNESS: f32 = 10.0;
const ROUNDS: usize = 3;
/// A segment has no share in pixels whose squared distance, in sides, exceeds that of the nearest one by this much.
const REACH: f32 = 1.0;
/// Rows of cells per task. The number is fixed, so that sums do not depend on the number of threads.
const BAND: usize = 2;

/// A point in colour (CIELAB) and position (row, column), as k-means moves it.
#[derive(Debug, Clone, Copy)]
struct Centre {
    lab: [f32; 3],
    at: [f32; 2],
}

/// The segments of a picture.
#[derive(Debug)]
pub(super) struct Segments {
    rows: usize,
    cols: usize,
    /// Cells, and therefore segments, along rows and columns.
    cells: [usize; 2],
    centres: Vec<Centre>,
}

/// Sums over the pixels of a segment.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    lab: [f64; 3],
    at: [f64; 2],
    rgb: [f64; 3],
    count: f64,
}

impl Segments {
    /// Segments of a picture in CIELAB: three planes of rows × columns.
    pub(super) fn new(lab: &[Vec<f32>; 3], rows: usize, cols: usize) -> Self {
        let cells = [rows.div_ceil(SIDE), cols.div_ceil(SIDE)];
        let centres = (0..cells[0] * cells[1])
            .map(|i| {
                let middle = |cell: usize, count: usize| ((cell * SIDE + SIDE / 2).min(count - 1), count);
                let ((row, _), (col, _)) = (middle(i / cells[1], rows), middle(i % cells[1], cols));
                Centre { lab: [0, 1, 2].map(|c| lab[c][row * cols + col]), at: [row as f32, col as f32] }
            })
            .collect();
        let mut segments = Self { rows, cols, cells, centres };
        for _ in 0..ROUNDS {
            let sums = segments.sums(lab, None);
            for (centre, sum) in segments.centres.iter_mut().zip(sums).filter(|(_, s)| s.count > 0.0) {
                *centre = Centre {
                    lab: sum.lab.map(|v| (v / sum.count) as f32),
                    at: sum.at.map(|v| (v / sum.count) as f32),
                };
            }
        }
        segments
    }

    /// The mean linear RGB of each segment; none of a segment without pixels.
    pub(super) fn means(&self, lab: &[Vec<f32>; 3], rgb: [&[f32]; 3]) -> Vec<Option<[f64; 3]>> {
        let sums = self.sums(lab, Some(rgb));
        sums.into_iter().map(|s| (s.count > 0.0).then(|| s.rgb.map(|v| v / s.count))).collect()
    }

    /// Sums over the pixels that are nearest to each segment.
    fn sums(&self, lab: &[Vec<f32>; 3], rgb: Option<[&[f32]; 3]>) -> Vec<Sums> {
        let parts: Vec<Vec<Sums>> = (0..self.cells[0].div_ceil(BAND))
            .into_par_iter()
            .map(|band| {
                // Pixels of these rows of cells belong to segments of the same and the adjacent rows.
                let first = (band * BAND).saturating_sub(1);
                let last = (band * BAND + BAND + 1).min(self.cells[0]);
                let mut sums = vec![Sums::default(); (last - first) * self.cells[1]];
                for row in band * BAND * SIDE..self.rows.min((band + 1) * BAND * SIDE) {
                    for col in 0..self.cols {
                        let i = row * self.cols + col;
                        let v = [0, 1, 2].map(|c| lab[c][i]);
                        let (segment, _) = self.around(row, col, v).fold((0, f32::INFINITY), nearer);
                        let sum = &mut sums[segment - first * self.cells[1]];
                        for c in 0..3 {
                            sum.lab[c] += f64::from(v[c]);
                            sum.rgb[c] += rgb.map_or(0.0, |rgb| f64::from(rgb[c][i]));
                        }
                        sum.at[0] += row as f64;
                        sum.at[1] += col as f64;
                        sum.count += 1.0;
                    }
                }
                sums
            })
            .collect();
        let mut all = vec![Sums::default(); self.centres.len()];
        for (band, part) in parts.iter().enumerate() {
            let first = (band * BAND).saturating_sub(1) * self.cells[1];
            for (sum, s) in all[first..].iter_mut().zip(part) {
                for c in 0..3 {
                    sum.lab[c] += s.lab[c];
                    sum.rgb[c] += s.rgb[c];
                }
                sum.at[0] += s.at[0];
                sum.at[1] += s.at[1];
                sum.count += s.count;
            }
        }
        all
    }

    /// The segments around a pixel with its squared distances to them, in sides.
    #[inline(always)]
    fn around(&self, row: usize, col: usize, lab: [f32; 3]) -> impl Iterator<Item = (usize, f32)> {
        let near = |cell: usize, count: usize| cell.saturating_sub(1)..(cell + 2).min(count);
        let (down, across) = (near(row / SIDE, self.cells[0]), near(col / SIDE, self.cells[1]));
        down.flat_map(move |r| across.clone().map(move |c| (r, c))).map(move |(r, c)| {
            let segment = r * self.cells[1] + c;
            let centre = &self.centres[segment];
            let colour: f32 = lab.iter().zip(centre.lab).map(|(a, b)| (a - b) * (a - b)).sum();
            let (y, x) = (row as f32 - centre.at[0], col as f32 - centre.at[1]);
            let scale = 1.0 / (SIDE * SIDE) as f32;
            (segment, colour / (COMPACTNESS * COMPACTNESS) + (y * y + x * x) * scale)
        })
    }

    /// The shares of the segments in a pixel, which sum to 1. They change smoothly from pixel to pixel of one colour.
    #[inline(always)]
    pub(super) fn shares(&self, row: usize, col: usize, lab: [f32; 3]) -> Shares {
        let mut shares = Shares { segments: [0; 9], weights: [0.0; 9], count: 0 };
        for (segment, distance) in self.around(row, col, lab) {
            shares.segments[shares.count] = segment;
            shares.weights[shares.count] = distance;
            shares.count += 1;
        }
        let weights = &mut shares.weights[..shares.count];
        let nearest = weights.iter().copied().fold(f32::INFINITY, f32::min);
        for w in weights.iter_mut() {
            let rest = (1.0 - (*w - nearest) / REACH).max(0.0);
            *w = rest * rest;
        }
        let sum: f32 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w /= sum);
        shares
    }
}

/// Segments and their shares in a pixel; the first `count` count.
#[derive(Debug)]
pub(super) struct Shares {
    pub(super) segments: [usize; 9],
    pub(super) weights: [f32; 9],
    pub(super) count: usize,
}

fn nearer(a: (usize, f32), b: (usize, f32)) -> (usize, f32) {
    if b.1 < a.1 { b } else { a }
}
