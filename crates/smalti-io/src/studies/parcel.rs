//! Scenes from files as bytes, for other machines that run the same version.

use std::sync::Arc;

use smalti::design::Study;
use smalti::numeric::Planes;
use smalti::scene::Scene;
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};

/// Values before the spectra: rows, columns, bands, first wavelength (nm), step (nm), distance (m) and horizontal field of view (°).
const HEAD_NUMBERS: usize = 7;

/// The scenes of a study that come from files, one after the other, in little-endian bytes; empty if there are none. The JSON of the study
/// holds the rest: see [`super::from_json`].
#[must_use]
pub fn scenes_as_bytes(study: &Study) -> Vec<u8> {
    let mut out = Vec::new();
    for scene in study.scenes.iter().filter_map(|s| s.scene.as_deref()) {
        bytes_of(scene, |bytes| out.extend_from_slice(bytes));
    }
    out
}

/// BLAKE3 hash of the bytes of a scene, hexadecimal.
pub(super) fn hash(scene: &Scene) -> String {
    let mut hasher = blake3::Hasher::new();
    bytes_of(scene, |bytes| {
        hasher.update(bytes);
    });
    hasher.finalize().to_hex().to_string()
}

fn bytes_of(scene: &Scene, mut write: impl FnMut(&[u8])) {
    let radiance = scene.radiance();
    let grid = radiance.grid();
    let shape = [radiance.rows(), radiance.cols(), grid.len()].map(|n| n as f64);
    let numbers = [grid.start_nm(), grid.step_nm(), scene.distance_m(), scene.horizontal_fov_deg()];
    for v in shape.iter().chain(&numbers).chain(scene.illuminant().values()) {
        write(&v.to_le_bytes());
    }
    for v in radiance.planes().data() {
        write(&v.to_le_bytes());
    }
}

/// Puts the scenes from [`scenes_as_bytes`] into a study that was read from JSON.
///
/// # Errors
/// A message when their hashes are not those in the study, or when there are too many.
pub(super) fn put_scenes(study: &mut Study, mut bytes: &[u8]) -> Result<(), String> {
    for of in study.scenes.iter_mut().filter(|s| s.hash.is_some()) {
        let scene = next(&of.name, &mut bytes).filter(|scene| of.hash.as_ref() == Some(&hash(scene)));
        let Some(scene) = scene else {
            return Err(format!("the scene {} is not the one that the study was resolved with", of.name));
        };
        of.scene = Some(Arc::new(scene));
    }
    if bytes.is_empty() { Ok(()) } else { Err("more scenes than the study has".into()) }
}

/// Decodes the first scene and removes it from `bytes`; `None` if it is invalid.
fn next(name: &str, bytes: &mut &[u8]) -> Option<Scene> {
    let mut take = |count: usize, size: usize| bytes.split_off(..count.checked_mul(size)?);
    let doubles =
        |part: &[u8]| part.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect::<Vec<_>>();
    let head = doubles(take(HEAD_NUMBERS, 8)?);
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

#[cfg(test)]
mod tests {
    use smalti::scene::{Setting, catalog};

    use super::*;
    use crate::studies;

    fn study() -> Study {
        let mut study = studies::load("table2").unwrap().0.study().clone();
        let setting = Setting { grid: WavelengthGrid::new(500.0, 50.0, 2).unwrap(), ..Setting::default() };
        study.scenes = ["macbeth?patch=2", "uniform?size=3"]
            .iter()
            .map(|name| {
                let scene = catalog::build_natural(name, &setting).unwrap();
                let hash = Some(hash(&scene));
                smalti::design::StudyScene { name: (*name).into(), hash, scene: Some(Arc::new(scene)) }
            })
            .collect();
        study
    }

    #[test]
    fn scenes_arrive_as_they_were_sent_or_not_at_all() {
        let whole = study();
        let bytes = scenes_as_bytes(&whole);
        let arrived = |bytes: &[u8]| {
            let mut empty = whole.clone();
            empty.scenes.iter_mut().for_each(|s| s.scene = None);
            put_scenes(&mut empty, bytes).map(|()| empty)
        };
        let there = arrived(&bytes).unwrap();
        for (a, b) in there.scenes.iter().zip(&whole.scenes) {
            assert_eq!(a.scene.as_ref().unwrap().radiance(), b.scene.as_ref().unwrap().radiance());
        }
        assert_eq!(scenes_as_bytes(&there), bytes);
        assert!(arrived(&[&bytes[..], &[0]].concat()).unwrap_err().contains("more scenes"));
        for cut in [0, 7, 56, bytes.len() / 2, bytes.len() - 1] {
            assert!(arrived(&bytes[..cut]).unwrap_err().contains("not the one"), "{cut}");
        }
        // The least significant bit of a sample, and the exponent of the number of rows.
        for (at, flip) in [(bytes.len() - 4, 1), (7, 0x7f)] {
            let mut wrong = bytes.clone();
            wrong[at] ^= flip;
            assert!(arrived(&wrong).unwrap_err().contains("not the one"), "{at}");
        }
    }
}
