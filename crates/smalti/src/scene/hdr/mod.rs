//! A scene of high dynamic range: a room in daylight with a sunlit floor, a window, a bare bulb and a dark
//! corridor.
//!
//! Ray tracing determines the luminance. Light comes from the sky through the window, the sun, the bulb, and
//! the walls (approximated by a constant), and falls on matt surfaces with shadows. The bulb is CIE
//! illuminant A; everything else has the illuminant of the setting. The bulb and sunlit surfaces are more
//! than 10⁵ times as bright as the end of the corridor.

mod geometry;
mod room;

use rayon::prelude::*;

use self::geometry::unit;
use self::room::{GREYS, Room};
use super::compose::{Fragment, check_size, fragments, lit};
use super::{Scene, SceneError, Setting, macbeth};
use crate::numeric::require;
use crate::spectrum::{Illuminant, Observer, Spectrum};

/// Samples per pixel in each direction.
const SAMPLES: usize = 3;
/// Half the width of the field of view at a distance of 1.
const HALF_WIDTH: f64 = 0.68;

/// Renders the room with `rows` rows (8 to 16384) and 3/2 as many columns.
///
/// # Errors
/// When `rows` or the setting is out of range.
pub fn hdr(rows: usize, setting: &Setting) -> Result<Scene, SceneError> {
    require((8..=16384).contains(&rows), "rows", rows as f64, "8 to 16384")?;
    let cols = rows * 3 / 2;
    check_size(rows, cols, setting.grid)?;
    let mut reflectances = macbeth::reflectances(setting.grid)?;
    for v in GREYS {
        reflectances.push(Spectrum::constant(setting.grid, v)?);
    }
    let daylight = of_unit_luminance(setting.light()?)?;
    let lamplight = of_unit_luminance(Illuminant::A.photons(setting.grid)?)?;
    let mut radiance = lit(&reflectances, &daylight)?;
    radiance.extend(lit(&reflectances, &lamplight)?);
    let room = Room::new();
    let kinds = reflectances.len();
    let painted: Vec<Vec<Fragment>> =
        (0..rows).into_par_iter().map(|row| paint_row(&room, row, rows, cols, kinds)).collect();
    fragments("hdr", cols, &painted, &radiance, &daylight, setting)
}

fn of_unit_luminance(light: Spectrum) -> Result<Spectrum, SceneError> {
    let luminance = Observer::Cie1931.xyz_from_photons(&light)?[1];
    // An illuminant without luminance stays unchanged; the check of the mean luminance rejects it later.
    Ok(if luminance > 0.0 { light.scaled(1.0 / luminance)? } else { light })
}

fn paint_row(room: &Room, row: usize, rows: usize, cols: usize, kinds: usize) -> Vec<Fragment> {
    let mut out = Vec::with_capacity(3 * cols);
    let mut sums = vec![0.0f64; 2 * kinds];
    for col in 0..cols {
        for part in 0..SAMPLES * SAMPLES {
            let inside = |i: usize| (i as f64 + 0.5) / SAMPLES as f64;
            let x = col as f64 + inside(part % SAMPLES) - cols as f64 / 2.0;
            let y = row as f64 + inside(part / SAMPLES) - rows as f64 / 2.0;
            let scale = 2.0 * HALF_WIDTH / cols as f64;
            let direction = unit([x * scale, -0.06 - y * scale, 1.0]);
            let shade = room.seen([0.15, 1.42, -0.2], direction, part);
            sums[shade.reflectance] += shade.daylight;
            sums[kinds + shade.reflectance] += shade.lamplight;
        }
        for (spectrum, sum) in sums.iter_mut().enumerate().filter(|(_, s)| **s > 0.0) {
            out.push(Fragment { col: col as u32, spectrum: spectrum as u32, weight: *sum as f32 });
            *sum = 0.0;
        }
    }
    out
}
