//! The dead-leaves model ([matheron1968], [lee2001]): overlapping discs whose radii have a density ∝ 1/r³.
//! The image is scale-invariant, and its power spectrum resembles that of natural images.
//!
//! [matheron1968]: https://cg.ensmp.fr/bibliotheque/public/MATHERON_Rapport_00129.pdf
//! [lee2001]: https://doi.org/10.1023/A:1011109015675

use std::f64::consts::FRAC_1_SQRT_2;

use rayon::prelude::*;

use super::compose::count_reflectances;
use super::compose::{Fragment, check_size, fragments, lit};
use super::{Scene, SceneError, Setting};
use crate::numeric::philox::Stream;
use crate::numeric::require;
use crate::spectrum::Spectrum;

/// Separates the random numbers of this pattern from other uses of the seed.
const PURPOSE: u32 = 0x6c65_6166;
/// Leaves per batch, and rows per task. Both affect only speed, not the image.
const BATCH: u32 = 1 << 14;
const BAND: usize = 32;
/// A pixel counts as covered when less than this fraction of it remains visible.
const COVERED: f32 = 1.0 / 512.0;

/// Leaves of random reflectance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeadLeaves {
    /// Rows, 1 to 32768.
    pub rows: usize,
    /// Columns, 1 to 32768.
    pub cols: usize,
    /// Smallest radius in pixels, at least 0.5.
    pub least_radius_px: f64,
    /// Largest radius in pixels, more than the smallest and at most 10⁵.
    pub largest_radius_px: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Draws the leaves, each with a random one of the `reflectances` (on the grid of the setting).
///
/// Leaves are placed from front to back, and only where the image is still empty. The cost is therefore
/// bounded by the number of pixels and by the number of leaves that cover them.
///
/// # Errors
/// When a parameter or the setting is out of range, the list of reflectances is empty, or a reflectance is
/// negative or on another grid.
pub fn dead_leaves(
    leaves: &DeadLeaves,
    reflectances: &[Spectrum],
    setting: &Setting,
) -> Result<Scene, SceneError> {
    let DeadLeaves { rows, cols, least_radius_px: least, largest_radius_px: largest, seed } = *leaves;
    require((1..=32768).contains(&rows), "rows", rows as f64, "1 to 32768")?;
    require((1..=32768).contains(&cols), "cols", cols as f64, "1 to 32768")?;
    require(least >= 0.5, "least_radius_px", least, "at least 0.5")?;
    let largest_ok = largest > least && largest <= 1e5;
    require(largest_ok, "largest_radius_px", largest, "more than the least radius and at most 1e5")?;
    let kinds = count_reflectances(reflectances, setting.grid)?;
    check_size(rows, cols, setting.grid)?;

    let law = LeafDistribution { size: [cols as f64, rows as f64], least, largest, kinds, seed };
    let mut bands: Vec<Band> =
        (0..rows).step_by(BAND).map(|first| Band::new(first, BAND.min(rows - first), cols)).collect();
    for batch in 0..law.batches() {
        let leaves = law.batch(batch);
        bands.par_iter_mut().for_each(|band| band.paint(&leaves));
        if bands.iter().all(|b| b.empty == 0) {
            break;
        }
    }
    let backdrop = Stream::new(seed, PURPOSE, u32::MAX).below(law.kinds);
    let painted: Vec<Vec<Fragment>> =
        bands.into_par_iter().flat_map_iter(|band| band.finish(backdrop)).collect();
    let light = setting.light()?;
    fragments("dead-leaves", cols, &painted, &lit(reflectances, &light)?, &light, setting)
}

#[derive(Debug, Clone, Copy)]
struct Leaf {
    x: f64,
    y: f64,
    radius: f64,
    spectrum: u32,
}

/// The distribution of leaves that can reach the image. The centre of such a leaf of radius r lies in a
/// rectangle of (cols + 2r) × (rows + 2r), so radii have the density r⁻³ (cols + 2r)(rows + 2r), a sum of
/// three powers of r.
struct LeafDistribution {
    size: [f64; 2],
    least: f64,
    largest: f64,
    kinds: u32,
    seed: u64,
}

impl LeafDistribution {
    /// Integrals of the three powers: r⁻³, r⁻² and r⁻¹.
    fn shares(&self) -> [f64; 3] {
        let ([cols, rows], a, b) = (self.size, self.least, self.largest);
        [
            cols * rows * (a.powi(-2) - b.powi(-2)) / 2.0,
            2.0 * (cols + rows) * (a.recip() - b.recip()),
            4.0 * (b / a).ln(),
        ]
    }

    /// The number of batches after which a given pixel is still empty with a probability below e⁻⁴⁰. Pixels
    /// that remain empty show the backdrop.
    fn batches(&self) -> u32 {
        // The rate at which a pixel is covered is ∫ r⁻³ π r² dr.
        let covering = std::f64::consts::PI * (self.largest / self.least).ln();
        let leaves = 40.0 * self.shares().iter().sum::<f64>() / covering;
        (leaves / f64::from(BATCH)).ceil().min(f64::from(u32::MAX / 2)) as u32
    }

    fn batch(&self, batch: u32) -> Vec<Leaf> {
        let ([cols, rows], a, b) = (self.size, self.least, self.largest);
        let shares = self.shares();
        let total: f64 = shares.iter().sum();
        let mut stream = Stream::new(self.seed, PURPOSE, batch);
        let leaf = |_| {
            let (pick, u) = (stream.uniform() * total, stream.uniform());
            // Inverse of the cumulative distribution of each power.
            let radius = if pick < shares[0] {
                (a.powi(-2) + u * (b.powi(-2) - a.powi(-2))).sqrt().recip()
            } else if pick < shares[0] + shares[1] {
                (a.recip() + u * (b.recip() - a.recip())).recip()
            } else {
                a * (b / a).powf(u)
            };
            let x = stream.uniform() * (cols + 2.0 * radius) - radius;
            let y = stream.uniform() * (rows + 2.0 * radius) - radius;
            Leaf { x, y, radius, spectrum: stream.below(self.kinds) }
        };
        (0..BATCH).map(leaf).collect()
    }
}

/// A band of rows while it is being filled.
struct Band {
    first_row: usize,
    cols: usize,
    /// Visible fraction of each pixel that is not yet covered, from 1 (empty) to 0.
    open: Vec<f32>,
    /// For each pixel, a column at or to its right with no open pixel in between. One extra entry per row
    /// ends the search.
    next: Vec<u32>,
    fragments: Vec<Vec<Fragment>>,
    empty: usize,
}

impl Band {
    fn new(first_row: usize, rows: usize, cols: usize) -> Self {
        Self {
            first_row,
            cols,
            open: vec![1.0; rows * cols],
            next: (0..rows).flat_map(|_| 0..=cols as u32).collect(),
            fragments: vec![Vec::with_capacity(cols + cols / 2); rows],
            empty: rows * cols,
        }
    }

    fn paint(&mut self, leaves: &[Leaf]) {
        for leaf in leaves {
            if self.empty == 0 {
                return;
            }
            let local = leaf.y - self.first_row as f64;
            let top = (local - leaf.radius - FRAC_1_SQRT_2).max(0.0);
            let bottom = (local + leaf.radius + FRAC_1_SQRT_2).min(self.fragments.len() as f64);
            if top < bottom {
                for row in top as usize..bottom.ceil() as usize {
                    self.paint_row(leaf, row);
                }
            }
        }
    }

    /// Draws a leaf into one row, from open pixel to open pixel.
    fn paint_row(&mut self, leaf: &Leaf, row: usize) {
        let dy = (self.first_row + row) as f64 + 0.5 - leaf.y;
        // Pixels whose centre is this far inside (outside) the circle are covered completely (not at all).
        let half_chord = |radius: f64| (radius * radius - dy * dy).max(0.0).sqrt();
        let reach = half_chord(leaf.radius + FRAC_1_SQRT_2);
        let inside = if leaf.radius > FRAC_1_SQRT_2 { half_chord(leaf.radius - FRAC_1_SQRT_2) } else { 0.0 };
        let from = (leaf.x - reach - 0.5).ceil().max(0.0) as usize;
        let end = (leaf.x + reach - 0.5).floor() + 1.0;
        let end = end.clamp(0.0, self.cols as f64) as usize;
        let mut col = self.next_open(row, from.min(self.cols));
        while col < end {
            let dx = col as f64 + 0.5 - leaf.x;
            let cover = if dx.abs() < inside { 1.0 } else { disc_cover(dx, dy, leaf.radius) };
            if cover > 0.0 {
                self.cover(row, col, leaf.spectrum, cover);
            }
            col = self.next_open(row, col + 1);
        }
    }

    fn cover(&mut self, row: usize, col: usize, spectrum: u32, cover: f32) {
        let open = &mut self.open[row * self.cols + col];
        let behind = *open * (1.0 - cover);
        let full = behind < COVERED;
        // The remainder of an almost covered pixel goes to the leaf that covers it.
        let weight = if full { *open } else { *open - behind };
        *open = if full { 0.0 } else { behind };
        self.fragments[row].push(Fragment { col: col as u32, spectrum, weight });
        if full {
            self.next[row * (self.cols + 1) + col] = col as u32 + 1;
            self.empty -= 1;
        }
    }

    /// The first open column of a row from `col`, or the number of columns. It shortens the path of later
    /// searches.
    fn next_open(&mut self, row: usize, col: usize) -> usize {
        let next = &mut self.next[row * (self.cols + 1)..(row + 1) * (self.cols + 1)];
        let mut found = col;
        while next[found] as usize != found {
            found = next[found] as usize;
        }
        let mut at = col;
        while at < found {
            at = std::mem::replace(&mut next[at], found as u32) as usize;
        }
        found
    }

    /// The rows, with the backdrop where a pixel is still open.
    fn finish(self, backdrop: u32) -> Vec<Vec<Fragment>> {
        let mut fragments = self.fragments;
        for (row, open) in fragments.iter_mut().zip(self.open.chunks_exact(self.cols)) {
            let left = open.iter().enumerate().filter(|(_, open)| **open > 0.0);
            row.extend(left.map(|(col, &weight)| Fragment { col: col as u32, spectrum: backdrop, weight }));
        }
        fragments
    }
}

/// The fraction of a pixel that a disc covers, from the position of the pixel's centre relative to that of
/// the disc. Within the pixel the circle is approximated by a straight line, moved inwards by the mean
/// sagitta, that is, the mean of s²/2r over s from -1/2 to 1/2.
fn disc_cover(dx: f64, dy: f64, radius: f64) -> f32 {
    let distance = dx.hypot(dy);
    let depth = radius - distance - 1.0 / (24.0 * radius);
    if distance == 0.0 {
        return (2.0 * depth).clamp(0.0, 1.0) as f32;
    }
    let (nx, ny) = ((dx / distance).abs(), (dy / distance).abs());
    let (long, short) = (nx.max(ny), nx.min(ny));
    // Projected on the normal the pixel is a trapezium: flat over `long - short`, sloping to `long + short`.
    let (flat, full) = ((long - short) / 2.0, (long + short) / 2.0);
    let d = depth.abs();
    let beyond = if d >= full {
        0.0
    } else if d <= flat {
        0.5 - d / long
    } else {
        (full - d).powi(2) / (2.0 * long * short)
    };
    (if depth > 0.0 { 1.0 - beyond } else { beyond }) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cover_is_the_area_of_a_half_plane() {
        // A huge disc is a half-plane; compare with a count of fine grid points inside it.
        let radius = 1e6;
        for (angle, depth) in [(0.0f64, 0.2f64), (0.3, -0.4), (0.785, 0.1), (1.2, 0.55), (1.57, -0.1)] {
            let (s, c) = angle.sin_cos();
            let n = 400;
            let at = |i: usize| (i as f64 + 0.5) / n as f64 - 0.5;
            let inside = (0..n * n).filter(|i| c * at(i % n) + s * at(i / n) <= depth).count();
            let expected = inside as f64 / (n * n) as f64;
            let distance = radius - depth;
            let got = f64::from(disc_cover(c * distance, s * distance, radius));
            assert!((got - expected).abs() < 3e-3, "{angle} {depth}: {got} {expected}");
        }
    }

    #[test]
    fn a_leaf_covers_its_area() {
        for (radius, tolerance) in [(1.5, 0.01), (4.0, 0.001), (11.3, 1e-4)] {
            let mut band = Band::new(0, 32, 32);
            band.paint(&[Leaf { x: 15.3, y: 16.4, radius, spectrum: 0 }]);
            let area: f64 = band.fragments.iter().flatten().map(|f| f64::from(f.weight)).sum();
            let expected = std::f64::consts::PI * radius * radius;
            assert!((area / expected - 1.0).abs() < tolerance, "{radius}: {area} {expected}");
        }
    }

    #[test]
    fn every_pixel_is_covered_once() {
        let law = LeafDistribution { size: [50.0, 40.0], least: 1.0, largest: 30.0, kinds: 3, seed: 5 };
        let mut band = Band::new(0, 40, 50);
        (0..law.batches()).for_each(|b| band.paint(&law.batch(b)));
        assert_eq!(band.empty, 0);
        let mut sums = vec![0.0f32; 40 * 50];
        for (row, line) in band.finish(0).iter().enumerate() {
            line.iter().for_each(|f| sums[row * 50 + f.col as usize] += f.weight);
        }
        assert!(sums.iter().all(|s| (s - 1.0).abs() < 1e-5));
    }
}
