//! Glossy balls and lamps: highlights in the colour of the illuminant on objects of any colour, and deep
//! shade.
//!
//! A ball reflects light in two ways ([shafer1985]). Body reflection is the reflectance times the cosine of
//! the angle of incidence. Surface reflection keeps the spectrum of the illuminant and follows Blinn: a power
//! of the cosine between the normal and the bisector of the directions to light and eye. Highlights are many
//! times as bright as white. Lamps are uniform discs that are brighter still. The backdrop is white paper,
//! and patches of shade cover the whole scene.
//!
//! [shafer1985]: https://doi.org/10.1002/col.5080100409

use rayon::prelude::*;

use super::compose::count_reflectances;
use super::compose::{Fragment, check_size, fragments, lit};
use super::{Scene, SceneError, Setting};
use crate::numeric::philox::Stream;
use crate::numeric::require;
use crate::spectrum::Spectrum;

/// Separates the random numbers of this pattern from other uses of the seed.
const PURPOSE: u32 = 0x676c_6f73;
/// Samples per pixel in each direction.
const SAMPLES: usize = 2;
/// Number of balls for any image size: they cover the backdrop about once.
const BALLS: u32 = 220;
/// Smallest and largest radius, as fractions of the shorter side of the image; radii are spaced
/// geometrically.
const RADII: [f64; 2] = [0.012, 0.16];
/// One ball in this many is a lamp.
const LAMP_OF: u32 = 20;
/// Luminance of lamps relative to fully lit white.
const LAMP: f64 = 12.0;
/// Reflectance of the backdrop.
const PAPER: f64 = 0.85;
/// Illumination of surfaces that face away from the main light.
const AMBIENT: f64 = 0.2;
/// Unit vector towards the light: right, down, towards the eye.
const TO_LIGHT: [f64; 3] = [-0.48, -0.6, 0.64];
/// Specular exponents, from satin to polish, and the brightness relative to white for an exponent of 1.
const GLOSS: [f64; 3] = [15.0, 60.0, 250.0];
const HIGHLIGHT: f64 = 0.1;

/// Randomly placed balls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GlossyBalls {
    /// Rows, 8 to 16384.
    pub rows: usize,
    /// Columns, 8 to 16384.
    pub cols: usize,
    /// Ratio of full light to the deepest shade, 1 to 10⁸.
    pub shade: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

struct Ball {
    x: f64,
    y: f64,
    radius: f64,
    /// `None` for a lamp.
    body: Option<u32>,
    gloss: f64,
}

/// Draws the balls, each with a random one of the `reflectances` (on the grid of the setting).
///
/// # Errors
/// When a parameter or the setting is out of range, the list of reflectances is empty, or a reflectance is
/// negative or on another grid.
pub fn glossy_balls(
    pattern: &GlossyBalls,
    reflectances: &[Spectrum],
    setting: &Setting,
) -> Result<Scene, SceneError> {
    let GlossyBalls { rows, cols, shade, seed } = *pattern;
    require((8..=16384).contains(&rows), "rows", rows as f64, "8 to 16384")?;
    require((8..=16384).contains(&cols), "cols", cols as f64, "8 to 16384")?;
    require((1.0..=1e8).contains(&shade), "shade", shade, "1 to 1e8")?;
    let white = count_reflectances(reflectances, setting.grid)?;
    check_size(rows, cols, setting.grid)?;
    let balls: Vec<Ball> = (0..BALLS).map(|i| ball(i, rows, cols, white, seed)).collect();
    let shades = Shades::new(rows, cols, shade, seed);
    let row_of = |row: usize| -> Vec<Fragment> {
        let near = |b: &&Ball| (b.y - row as f64 - 0.5).abs() <= b.radius + 1.0;
        let near: Vec<&Ball> = balls.iter().filter(near).collect();
        let mut out = Vec::with_capacity(2 * cols);
        for col in 0..cols {
            let first = out.len();
            for part in 0..SAMPLES * SAMPLES {
                let inside = |i: usize| (i as f64 + 0.5) / SAMPLES as f64;
                let (x, y) = (col as f64 + inside(part % SAMPLES), row as f64 + inside(part / SAMPLES));
                let light = shades.at(x, y) / (SAMPLES * SAMPLES) as f64;
                let hit = near.iter().find(|b| (x - b.x).powi(2) + (y - b.y).powi(2) < b.radius * b.radius);
                let mut add = |spectrum: u32, light: f64| {
                    let weight = light as f32;
                    match out[first..].iter_mut().find(|f: &&mut Fragment| f.spectrum == spectrum) {
                        Some(fragment) => fragment.weight += weight,
                        None => out.push(Fragment { col: col as u32, spectrum, weight }),
                    }
                };
                match hit {
                    None => add(white, PAPER * light),
                    Some(Ball { body: None, .. }) => add(white, LAMP / (SAMPLES * SAMPLES) as f64),
                    Some(b @ Ball { body: Some(body), .. }) => {
                        let (diffuse, highlight) = b.shine(x, y);
                        add(*body, diffuse * light);
                        if highlight > 1e-4 {
                            add(white, highlight * light);
                        }
                    }
                }
            }
        }
        out
    };
    let painted: Vec<_> = (0..rows).into_par_iter().map(row_of).collect();
    let light = setting.light()?;
    let mut radiance = lit(reflectances, &light)?;
    radiance.push(light.clone());
    fragments("glossy-balls", cols, &painted, &radiance, &light, setting)
}

fn ball(index: u32, rows: usize, cols: usize, kinds: u32, seed: u64) -> Ball {
    let mut random = Stream::new(seed, PURPOSE, index);
    let [least, largest] = RADII.map(|r| r * rows.min(cols) as f64);
    let radius = least * (largest / least).powf(random.uniform());
    let (x, y) = (random.uniform() * cols as f64, random.uniform() * rows as f64);
    let lamp = random.below(LAMP_OF) == 0;
    let gloss = GLOSS[random.below(GLOSS.len() as u32) as usize];
    Ball { x, y, radius, body: (!lamp).then(|| random.below(kinds)), gloss }
}

impl Ball {
    /// Body reflection for a reflectance of 1, and surface reflection, at a visible point of the ball.
    fn shine(&self, x: f64, y: f64) -> (f64, f64) {
        let (nx, ny) = ((x - self.x) / self.radius, (y - self.y) / self.radius);
        let nz = (1.0 - nx * nx - ny * ny).max(0.0).sqrt();
        let dot = |v: [f64; 3]| (v[0] * nx + v[1] * ny + v[2] * nz).max(0.0);
        let [lx, ly, lz] = TO_LIGHT;
        // The viewing direction is along z.
        let length = (lx * lx + ly * ly + (lz + 1.0).powi(2)).sqrt();
        let half = [lx / length, ly / length, (lz + 1.0) / length];
        let diffuse = AMBIENT + (1.0 - AMBIENT) * dot(TO_LIGHT);
        (diffuse, HIGHLIGHT * self.gloss * dot(half).powf(self.gloss))
    }
}

/// Shade factors, interpolated geometrically between the nodes of a lattice of four by four cells.
struct Shades {
    nodes: Vec<f64>,
    cell: [f64; 2],
}

impl Shades {
    const CELLS: usize = 4;

    fn new(rows: usize, cols: usize, shade: f64, seed: u64) -> Self {
        let side = Self::CELLS + 1;
        let node = |i: usize| {
            // Half of the nodes are in full light.
            let u = Stream::new(seed, PURPOSE + 1, i as u32).uniform();
            -(2.0 * u - 1.0).max(0.0) * shade.ln()
        };
        let cell = [rows, cols].map(|n| n as f64 / Self::CELLS as f64);
        Self { nodes: (0..side * side).map(node).collect(), cell }
    }

    fn at(&self, x: f64, y: f64) -> f64 {
        let place = |v: f64, cell: f64| {
            let at = (v / cell).clamp(0.0, Self::CELLS as f64 - 1e-9);
            (at as usize, at.fract())
        };
        let ((down, v), (right, u)) = (place(y, self.cell[0]), place(x, self.cell[1]));
        // `place` is below CELLS, and there is one more node than cells in each direction.
        let node = |d: usize, r: usize| self.nodes[(down + d) * (Self::CELLS + 1) + right + r];
        let across = |d: usize| (1.0 - u) * node(d, 0) + u * node(d, 1);
        ((1.0 - v) * across(0) + v * across(1)).exp()
    }
}
