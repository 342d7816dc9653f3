//! The scene that pipelines of designs learn from: many small pictures side by side.
//!
//! One scene is thrown on the sensor once, captured at one go and has no borders to be left out: where pieces meet is an edge like
//! any other.

use crate::camera::{Camera, CameraError, training_reflectances};
use crate::numeric::Planes;
use crate::scene::{Scene, Setting, catalog};
use crate::spectrum::{SpectralCube, Spectrum};

/// Pixels of the sensor that a piece spans, in rows and columns.
const PIECE_PX: usize = 64;
/// Samples per pixel: two, so that detail beyond the sensor's Nyquist frequency is there to alias.
const SAMPLES_PER_PX: usize = 2;
/// The light on pieces, in turn: shade has all colours too.
const BRIGHTNESS: [f32; 3] = [0.95, 0.95, 0.35];
/// The light on even surfaces.
const SHADES: [f64; 3] = [1.0, 0.6, 0.3];
/// Of so many pieces, leaves are all but one.
const LEAVES_OF: usize = 4;

/// A square scene for `size_px` pixels of the sensor, in rows and columns, as wide as the setting says. `white` is the radiance of a perfect white
/// diffuser in full light.
pub(super) fn scene(
    camera: &Camera,
    size_px: usize,
    white: &Spectrum,
    setting: &Setting,
) -> Result<Scene, CameraError> {
    let (n, piece) = (size_px * SAMPLES_PER_PX, PIECE_PX * SAMPLES_PER_PX);
    let reflectances = training_reflectances(camera.grid())?;
    let mut planes = Planes::zeros(n, n, setting.grid.len());
    let pieces = size_px.div_ceil(PIECE_PX);
    for i in 0..pieces * pieces {
        let (row, col) = (i / pieces * piece, i % pieces * piece);
        let part = catalog::build(&spec(i, piece), setting, &reflectances)?;
        // Scenes are as bright on the mean as the setting says, each with the light that this takes.
        let light = BRIGHTNESS[i % BRIGHTNESS.len()] * (white.max() / part.illuminant().max()) as f32;
        let (rows, cols) = (piece.min(n - row), piece.min(n - col));
        let from = part.radiance();
        for (band, source) in from.planes().planes().enumerate() {
            let to = planes.plane_mut(band).chunks_exact_mut(n).skip(row).take(rows);
            for (to, source) in to.zip(source.chunks_exact(from.cols())) {
                to[col..].iter_mut().zip(&source[..cols]).for_each(|(t, s)| *t = s * light);
            }
        }
    }
    let cube = SpectralCube::new(setting.grid, planes)?;
    Ok(Scene::new("lessons", cube, white.clone(), setting.distance_m, setting.horizontal_fov_deg)?)
}

/// The picture of a piece: dead leaves of several scales, seeds below those of the test scenes; every fourth a pattern.
fn spec(i: usize, n: usize) -> String {
    let scales = [(1.5, 200), (3.0, 60), (1.0, 30), (8.0, 400)];
    if i % LEAVES_OF != LEAVES_OF - 1 {
        let (least, largest) = scales[i % scales.len()];
        return format!("dead-leaves?rows={n}&cols={n}&seed={}&least={least}&largest={largest}", i + 1);
    }
    match i / LEAVES_OF % 5 {
        0 => format!("slanted-bar?size={}", n + 1),
        1 => format!("grey-steps?steps=16&step={}&rows={n}&density=2", n / 16),
        2 => format!("siemens-star?size={n}&cycles=12&contrast=20"),
        3 => format!("checkerboard?squares=5&square={}&contrast=50", n.div_ceil(5)),
        _ => format!("frequency-sweep?rows={n}&cols={n}&contrast=0.05"),
    }
}

/// Even surfaces to learn colours from, as the radiance that reaches the camera from each, in full light and in shade: those that
/// the camera's colour matrix is fitted to, so that learned and fitted colours rest on the same knowledge. What the leaves teach
/// of even surfaces goes beyond them.
pub(super) fn surfaces(camera: &Camera, white: &Spectrum) -> Result<Vec<Spectrum>, CameraError> {
    let all = camera.surfaces()?;
    let lit = all.iter().map(|s| Ok(s.times(white)?)).collect::<Result<Vec<_>, CameraError>>()?;
    Ok(SHADES.iter().flat_map(|&light| lit.iter().map(move |s| s.scaled(light))).collect())
}
