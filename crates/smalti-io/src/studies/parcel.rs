//! The scenes in files of a study as bytes, for another machine that runs the same version.

use std::sync::Arc;

use smalti::design::Study;
use smalti::numeric::Planes;
use smalti::scene::Scene;
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};

use super::hash;

/// Rows, columns, bands; first wavelength, step, distance, field of view.
const HEAD: usize = 7;

/// The scenes of a study that come from files, one after the other, in little endian; empty where there is none. A study as JSON holds the
/// rest: see [`super::from_json`].
#[must_use]
pub fn scenes_as_bytes(study: &Study) -> Vec<u8> {
    let mut out = Vec::new();
    for scene in study.scenes.iter().filter_map(|s| s.scene.as_deref()) {
        let radiance = scene.radiance();
        let grid = radiance.grid();
        let shape = [radiance.rows(), radiance.cols(), grid.len()].map(|n| n as f64);
        let numbers = [grid.start_nm(), grid.step_nm(), scene.distance_m(), scene.horizontal_fov_deg()];
        for v in shape.iter().chain(&numbers).chain(scene.illuminant().values()) {
            out.extend(v.to_le_bytes());
        }
        for v in radiance.planes().data() {
            out.extend(v.to_le_bytes());
        }
    }
    out
}

/// Puts the scenes that were sent into a study that came without them.
///
/// # Errors
/// In words, when they are not those of the study.
pub(super) fn put_scenes(study: &mut Study, mut bytes: &[u8]) -> Result<(), String> {
    for of in study.scenes.iter_mut().filter(|s| s.hash.is_some()) {
        let scene = next(&of.name, &mut bytes).filter(|scene| of.hash.as_ref() == Some(&hash(scene)));
        let Some(scene) = scene else {
            return Err(format!("the scene {} is not the one that the study was made with", of.name));
        };
        of.scene = Some(Arc::new(scene));
    }
    if bytes.is_empty() { Ok(()) } else { Err("more scenes than the study has".into()) }
}

/// Takes a scene off the front.
fn next(name: &str, bytes: &mut &[u8]) -> Option<Scene> {
    let mut take = |count: usize, size: usize| bytes.split_off(..count.checked_mul(size)?);
    let doubles =
        |part: &[u8]| part.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect::<Vec<_>>();
    let head = doubles(take(HEAD, 8)?);
    let [rows, cols, bands, start_nm, step_nm, distance_m, fov_deg] = head[..] else { return None };
    let [rows, cols, bands] = [rows, cols, bands].map(|v| v as usize);
    let grid = WavelengthGrid::new(start_nm, step_nm, bands).ok()?;
    let illuminant = Spectrum::new(grid, doubles(take(bands, 8)?)).ok()?;
    let samples = take(rows.checked_mul(cols)?.checked_mul(bands)?, 4)?;
    let samples = samples.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let planes = Planes::new(rows, cols, bands, samples).ok()?;
    let radiance = SpectralCube::new(grid, planes).ok()?;
    Scene::new(name, radiance, illuminant, distance_m, fov_deg).ok()
}
