//! The training scene of a study: many small pictures side by side.
//!
//! One scene needs one optical image and one capture. The boundaries between its pictures are edges like any others.

use crate::camera::training_set::{SAMPLES_PER_PX, dead_leaves};
use crate::camera::{Camera, CameraError, training_reflectances};
use crate::numeric::Planes;
use crate::scene::{Scene, Setting, catalog};
use crate::spectrum::{SpectralCube, Spectrum};

/// Side of one picture, pixels of the sensor.
const PIECE_PX: usize = 64;
/// Relative illuminance of the pictures, in turn: all colours occur in shade as well.
const BRIGHTNESS: [f32; 3] = [0.95, 0.95, 0.35];
/// Seeds of leaves of one training scene: a multiple of the scales of leaves, and at least its pictures.
const SCENE_SEEDS: usize = 4096;
/// One picture of this many is a test pattern; the others are dead leaves.
const PATTERN_INTERVAL: usize = 4;

/// A square scene for `size_px` × `size_px` pixels of the sensor, with the field of view of the setting. `white` is the radiance
/// of a perfect white diffuser in full light; scenes of different numbers have different leaves.
pub(super) fn scene(
    camera: &Camera,
    size_px: usize,
    number: u32,
    white: &Spectrum,
    setting: &Setting,
) -> Result<Scene, CameraError> {
    let (n, piece) = (size_px * SAMPLES_PER_PX, PIECE_PX * SAMPLES_PER_PX);
    let reflectances = training_reflectances(camera.grid())?;
    let mut planes = Planes::zeros(n, n, setting.grid.len());
    let pieces = size_px.div_ceil(PIECE_PX);
    for i in 0..pieces * pieces {
        let (row, col) = (i / pieces * piece, i % pieces * piece);
        let part = catalog::build(&spec(i, number, piece), setting, &reflectances)?;
        // Every scene has the mean luminance of the setting, so that their illuminants differ in strength.
        let light = BRIGHTNESS[i % BRIGHTNESS.len()] * (white.max() / part.illuminant().max()) as f32;
        let (rows, cols) = (piece.min(n - row), piece.min(n - col));
        let from = part.radiance();
        for (band, source) in from.planes().planes().enumerate() {
            let to = planes.plane_mut(band)?.chunks_exact_mut(n).skip(row).take(rows);
            for (to, source) in to.zip(source.chunks_exact(from.cols())) {
                to[col..].iter_mut().zip(&source[..cols]).for_each(|(t, s)| *t = s * light);
            }
        }
    }
    let cube = SpectralCube::new(setting.grid, planes)?;
    Ok(Scene::new("training", cube, white.clone(), setting.distance_m, setting.horizontal_fov_deg)?)
}

/// The scene of one picture: dead leaves or a test pattern.
fn spec(i: usize, number: u32, n: usize) -> String {
    if i % PATTERN_INTERVAL != PATTERN_INTERVAL - 1 {
        return dead_leaves(i + SCENE_SEEDS * number as usize, n);
    }
    match i / PATTERN_INTERVAL % 5 {
        0 => format!("slanted-bar?size={}", n + 1),
        1 => format!("grey-steps?steps=16&step={}&rows={n}&density=2", n / 16),
        2 => format!("siemens-star?size={n}&cycles=12&contrast=20"),
        3 => format!("checkerboard?squares=5&square={}&contrast=50", n.div_ceil(5)),
        _ => format!("frequency-sweep?rows={n}&cols={n}&contrast=0.05"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::CameraDescription;
    use crate::spectrum::{Illuminant, WavelengthGrid};

    /// Three by three pictures, of which those at the edge are cut: each has light, and none more than white. No two are equal, and a third is in shade.
    #[test]
    fn pictures_cover_the_scene() {
        let grid = WavelengthGrid::new(400.0, 20.0, 16).unwrap();
        let camera = Camera::new(CameraDescription::default(), grid).unwrap();
        let setting = Setting { grid, ..Setting::default() };
        let white = Illuminant::D65.photons(grid).unwrap();
        let px = 2 * PIECE_PX + 8;
        let built = scene(&camera, px, 1, &white, &setting).unwrap();
        let (n, side) = (px * SAMPLES_PER_PX, PIECE_PX * SAMPLES_PER_PX);
        let radiance = built.radiance();
        assert_eq!((radiance.rows(), radiance.cols(), built.illuminant()), (n, n, &white));
        const BAND: usize = 7;
        let plane = radiance.planes().plane(BAND).unwrap();
        let mut means = Vec::new();
        for i in 0..9 {
            let (rows, cols) =
                (i / 3 * side..n.min((i / 3 + 1) * side), i % 3 * side..n.min((i % 3 + 1) * side));
            let count = (rows.len() * cols.len()) as f64;
            let of_row = |row: usize| {
                plane[row * n + cols.start..row * n + cols.end].iter().map(|v| f64::from(*v)).sum::<f64>()
            };
            let mean = rows.map(of_row).sum::<f64>() / count / white.values()[BAND];
            assert!(mean > 0.01 && mean < 1.0, "{i}: {mean}");
            assert!(i % 3 != 2 || mean < f64::from(BRIGHTNESS[2]), "{i}: {mean}");
            assert!(!means.contains(&mean), "{i}: {means:?}");
            means.push(mean);
        }
    }
}
