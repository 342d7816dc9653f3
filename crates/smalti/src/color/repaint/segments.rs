//! Segments of a photograph, and how much of each neighbouring segment a pixel takes.
//!
//! After R. Achanta et al. (2012), "SLIC superpixels compared to state-of-the-art superpixel methods", *IEEE
//! Transactions on Pattern Analysis and Machine Intelligence* 34(11): k-means in colour and position from the centres of
//! square cells, in which a pixel looks at the nine segments around its cell.

use rayon::prelude::*;

use crate::numeric::simd::{Kernel, dispatch};

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

impl Centre {
    /// The squared distance of a pixel, in sides.
    #[inline(always)]
    fn distance(&self, at: [f32; 2], lab: [f32; 3]) -> f32 {
        let colour: f32 = lab.iter().zip(self.lab).map(|(a, b)| (a - b) * (a - b)).sum();
        let (y, x) = (at[0] - self.at[0], at[1] - self.at[1]);
        let scale = 1.0 / (SIDE * SIDE) as f32;
        colour / (COMPACTNESS * COMPACTNESS) + (y * y + x * x) * scale
    }
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
                let mut nearest = vec![0; self.cols];
                for row in band * BAND * SIDE..self.rows.min((band + 1) * BAND * SIDE) {
                    let at = row * self.cols;
                    let lab = lab.each_ref().map(|plane| &plane[at..at + self.cols]);
                    dispatch(NearestInRow { segments: self, row, lab, out: &mut nearest });
                    for (col, &segment) in nearest.iter().enumerate() {
                        let sum = &mut sums[segment as usize - first * self.cells[1]];
                        for c in 0..3 {
                            sum.lab[c] += f64::from(lab[c][col]);
                            sum.rgb[c] += rgb.map_or(0.0, |rgb| f64::from(rgb[c][at + col]));
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
        let at = [row as f32, col as f32];
        self.near(row, col).map(move |segment| (segment, self.centres[segment].distance(at, lab)))
    }

    /// The segments around a pixel, in order; those around all pixels of a cell are the same.
    #[inline(always)]
    fn near(&self, row: usize, col: usize) -> impl Iterator<Item = usize> {
        let near = |cell: usize, count: usize| cell.saturating_sub(1)..(cell + 2).min(count);
        let (down, across) = (near(row / SIDE, self.cells[0]), near(col / SIDE, self.cells[1]));
        let cols = self.cells[1];
        down.flat_map(move |r| across.clone().map(move |c| r * cols + c))
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

/// The segment that is nearest to each pixel of a row.
struct NearestInRow<'a> {
    segments: &'a Segments,
    row: usize,
    lab: [&'a [f32]; 3],
    out: &'a mut [u32],
}

impl Kernel for NearestInRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { segments, row, lab, out } = self;
        for (cell, out) in out.chunks_mut(SIDE).enumerate() {
            let first = cell * SIDE;
            let mut colours = [[0.0f32; SIDE]; 3];
            for (colour, plane) in colours.iter_mut().zip(lab) {
                colour.iter_mut().zip(&plane[first..]).for_each(|(c, v)| *c = *v);
            }
            let (mut least, mut nearest) = ([f32::INFINITY; SIDE], [0u32; SIDE]);
            for segment in segments.near(row, first) {
                let centre = segments.centres[segment];
                for i in 0..SIDE {
                    let at = [row as f32, (first + i) as f32];
                    let distance = centre.distance(at, [colours[0][i], colours[1][i], colours[2][i]]);
                    let is_nearer = distance < least[i];
                    least[i] = if is_nearer { distance } else { least[i] };
                    nearest[i] = if is_nearer { segment as u32 } else { nearest[i] };
                }
            }
            out.copy_from_slice(&nearest[..out.len()]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: usize = 85;
    const COLS: usize = 70;

    fn picture(of: impl Fn(usize, usize) -> [f32; 3]) -> [Vec<f32>; 3] {
        [0, 1, 2].map(|c| (0..ROWS * COLS).map(|i| of(i / COLS, i % COLS)[c]).collect())
    }

    fn planes(rgb: &[Vec<f32>; 3]) -> [&[f32]; 3] {
        [0, 1, 2].map(|c| rgb[c].as_slice())
    }

    /// Every pixel is in the sums of one segment, also across bands of rows.
    #[test]
    fn sums_are_those_of_all_pixels() {
        let lab = picture(|row, col| [40.0 + (row % 9) as f32, (col % 30) as f32, ((row * col) % 17) as f32]);
        let rgb = picture(|row, col| [0.25, ((row + col) % 4) as f32, (row % 3) as f32]);
        let segments = Segments::new(&lab, ROWS, COLS);
        assert_eq!((segments.cells, segments.centres.len()), ([6, 5], 30));
        let sums = segments.sums(&lab, Some(planes(&rgb)));
        // The numbers are whole or quarters, so that sums are exact.
        let sum = |of: &dyn Fn(&Sums) -> f64| sums.iter().map(of).sum::<f64>();
        let all = |plane: &[f32]| plane.iter().map(|v| f64::from(*v)).sum::<f64>();
        for c in 0..3 {
            assert_eq!(sum(&|s| s.lab[c]), all(&lab[c]));
            assert_eq!(sum(&|s| s.rgb[c]), all(&rgb[c]));
        }
        let count = (ROWS * COLS) as f64;
        assert_eq!(sum(&|s| s.count), count);
        assert_eq!(sum(&|s| s.at[0]), count * (ROWS - 1) as f64 / 2.0);
        assert_eq!(sum(&|s| s.at[1]), count * (COLS - 1) as f64 / 2.0);
    }

    /// A border between two colours is one between segments, wherever it lies in a cell, and every segment has a colour of the picture.
    #[test]
    fn segments_end_at_borders() {
        for border in [18, 21, 27] {
            let is_left = |row: usize, col: usize| col + row / 20 < border;
            let lab =
                picture(|row, col| if is_left(row, col) { [60.0, 50.0, -20.0] } else { [60.0, -40.0, 30.0] });
            let (left, right) = ([0.5, 0.125, 0.25], [0.0, 0.5, 0.25]);
            let rgb = picture(|row, col| if is_left(row, col) { left } else { right });
            let segments = Segments::new(&lab, ROWS, COLS);
            let means = segments.means(&lab, planes(&rgb));
            let (left, right) = (left.map(f64::from), right.map(f64::from));
            for mean in means.iter().flatten() {
                assert!(*mean == left || *mean == right, "{border}: {mean:?}");
            }
            assert!(means.contains(&Some(left)) && means.contains(&Some(right)));
        }
    }

    /// In a picture of one colour, the segments are its cells, but for those next to cells that the edge cuts.
    #[test]
    fn segments_of_one_colour_are_cells() {
        let lab = picture(|_, _| [50.0, 10.0, 10.0]);
        let segments = Segments::new(&lab, ROWS, COLS);
        for (row, col) in (0..9).map(|i| (i / 3, i % 3)) {
            let centre = &segments.centres[row * segments.cells[1] + col];
            for (at, cell) in centre.at.iter().zip([row, col]) {
                let middle = (cell * SIDE) as f32 + (SIDE - 1) as f32 / 2.0;
                assert!((at - middle).abs() <= 1.0, "{row} {col}: {at} {middle}");
            }
            assert_eq!(centre.lab, [50.0, 10.0, 10.0]);
        }
    }

    /// Shares sum to 1, the nearest segment has the largest, and none is beyond reach.
    #[test]
    fn shares_sum_to_one() {
        let lab = picture(|row, col| [30.0 + 0.4 * row as f32, 0.5 * col as f32 - 10.0, 5.0]);
        let segments = Segments::new(&lab, ROWS, COLS);
        for i in (0..ROWS * COLS).step_by(7) {
            let (row, col) = (i / COLS, i % COLS);
            let v = [0, 1, 2].map(|c| lab[c][i]);
            let Shares { segments: numbers, weights, count } = segments.shares(row, col, v);
            let (numbers, weights) = (&numbers[..count], &weights[..count]);
            assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-6, "{row} {col}: {weights:?}");
            let distances: Vec<(usize, f32)> = segments.around(row, col, v).collect();
            let (nearest, least) = distances.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            let largest = weights.iter().copied().fold(0.0, f32::max);
            for ((number, weight), (other, distance)) in numbers.iter().zip(weights).zip(&distances) {
                assert_eq!(number, other);
                assert!(*number != nearest || *weight == largest, "{row} {col}: {weights:?}");
                assert_eq!(*weight > 0.0, distance - least < REACH, "{row} {col}: {distance} {least}");
            }
        }
    }
}
