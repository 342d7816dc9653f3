//! Scenes by name or file.

use std::path::Path;

use smalti::names::nearest;
use smalti::scene::{Scene, SceneError, Setting, catalog};
use smalti::spectrum::{Illuminant, WavelengthGrid};

use crate::error::At;
use crate::scene_file::{self, is_meant};
use crate::{IoError, ReadOptions, rendered};

/// Properties that a scene is required to have. Those that are not stated here are taken from its file, else from [`Setting`].
#[derive(Debug, Clone, Default)]
pub struct SceneRequest {
    /// Mean luminance, cd/m².
    pub luminance_cd_m2: Option<f64>,
    /// Distance from the lens, m.
    pub distance_m: Option<f64>,
    /// Horizontal field of view, degrees.
    pub horizontal_fov_deg: Option<f64>,
    /// The light; a file is re-lit.
    pub illuminant: Option<Illuminant>,
    /// The wavelengths; a file is resampled.
    pub grid: Option<WavelengthGrid>,
    /// Assumptions for facts that a file does not state.
    pub read: ReadOptions,
}

impl SceneRequest {
    /// Applies the requested properties to a scene.
    ///
    /// # Errors
    /// When the scene cannot be so: it is dark, has no light at a wavelength, or a number is out of range.
    pub fn applied_to(&self, mut scene: Scene) -> Result<Scene, SceneError> {
        if let Some(grid) = self.grid {
            scene = scene.resampled(grid)?;
        }
        if let Some(light) = &self.illuminant {
            scene = scene.relit(light)?;
        }
        if let Some(cd_m2) = self.luminance_cd_m2 {
            scene = scene.with_mean_luminance(cd_m2)?;
        }
        if let Some(m) = self.distance_m {
            scene = scene.with_distance(m)?;
        }
        match self.horizontal_fov_deg {
            Some(deg) => scene.with_fov(deg),
            None => Ok(scene),
        }
    }

    fn setting(&self) -> Setting {
        let default = Setting::default();
        Setting {
            luminance_cd_m2: self.luminance_cd_m2.unwrap_or(default.luminance_cd_m2),
            distance_m: self.distance_m.unwrap_or(default.distance_m),
            horizontal_fov_deg: self.horizontal_fov_deg.unwrap_or(default.horizontal_fov_deg),
            illuminant: self.illuminant.clone().unwrap_or(default.illuminant),
            grid: self.grid.unwrap_or_default(),
        }
    }
}

/// Names and summaries of the built-in scenes, those that come from files last.
pub fn names() -> impl Iterator<Item = (&'static str, &'static str)> {
    let rendered = rendered::names().iter().map(|s| (s.name, s.summary));
    catalog::names().iter().map(|s| (s.name, s.summary)).chain(rendered)
}

/// A built-in scene by its name and parameters (`zone-plate?frequency=0.4`), painted with natural reflectances, one that comes
/// from a built-in file ([rendered]), or a file of any format that [`scene_file`] reads.
///
/// # Errors
/// When there is no such scene, a parameter is out of range, the file holds no scene, or it cannot be as asked: a path-traced scene keeps its
/// lamps.
pub fn load(name: &str, request: &SceneRequest) -> Result<Scene, IoError> {
    let setting = request.setting();
    if let Some(scene) = rendered::find(name) {
        if request.illuminant.is_some() && !scene.has_one_light() {
            return Err(IoError::Lamps { name: name.to_owned() });
        }
        return request.applied_to(scene.load()?).at(Path::new(name));
    }
    if !is_meant(name) {
        return catalog::build_natural(name, &setting).map_err(|source| of_catalog(name, source));
    }
    let path = Path::new(name);
    request.applied_to(scene_file::read(path, &setting, &request.read)?).at(path)
}

/// Checks that the catalogue has the scene of a name with parameters.
///
/// # Errors
/// With all built-in scenes when it has not.
pub(crate) fn ensure_in_catalog(spec: &str) -> Result<(), IoError> {
    catalog::find(spec).map(drop).map_err(|source| of_catalog(spec, source))
}

/// The error about a built-in scene.
fn of_catalog(spec: &str, source: SceneError) -> IoError {
    IoError::Catalog { name: spec.to_owned(), source: among_all(source) }
}

/// An unknown scene with all built-in scenes, those of files too, as known ones.
fn among_all(error: SceneError) -> SceneError {
    match error {
        SceneError::UnknownScene { name, .. } => {
            let known: Vec<&'static str> = names().map(|(name, _)| name).collect();
            let suggestion = nearest(&name, known.iter().copied());
            // The part after the hyphen suffices for scenes from files.
            let of_set =
                || known.iter().copied().find(|known| known.split_once('-').is_some_and(|(_, k)| k == name));
            SceneError::UnknownScene { suggestion: suggestion.or_else(of_set), name, known: known.join(", ") }
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use smalti::numeric::Planes;
    use smalti::spectrum::SpectralCube;

    use super::*;
    use crate::exr::{Layout, write};
    use crate::{Quantity, SpectralFile};

    fn asked() -> SceneRequest {
        SceneRequest {
            luminance_cd_m2: Some(40.0),
            distance_m: Some(2.5),
            horizontal_fov_deg: Some(7.0),
            illuminant: Some(Illuminant::A),
            grid: WavelengthGrid::new(420.0, 20.0, 12).ok(),
            read: ReadOptions::default(),
        }
    }

    fn check(scene: &Scene) {
        assert!((scene.mean_luminance_cd_m2().unwrap() / 40.0 - 1.0).abs() < 1e-5);
        assert_eq!((scene.distance_m(), scene.horizontal_fov_deg()), (2.5, 7.0));
        let grid = scene.radiance().grid();
        assert_eq!(Some(grid), asked().grid);
        // The light has the spectrum of A, whatever its level.
        let (light, a) = (scene.illuminant().values(), Illuminant::A.photons(grid).unwrap());
        let level = light[0] / a.values()[0];
        assert!(light.iter().zip(a.values()).all(|(light, a)| (light / a / level - 1.0).abs() < 1e-6));
    }

    #[test]
    fn a_name_and_a_file_are_as_asked() {
        check(&load("macbeth?patch=4", &asked()).unwrap());
        check(&load("photo-dahlia", &asked()).unwrap());
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        let grid = WavelengthGrid::VISIBLE;
        let data = (0..2 * 3 * grid.len()).map(|i| 0.1 + 0.01 * (i % 70) as f32).collect();
        let file = SpectralFile {
            name: "a".into(),
            cube: SpectralCube::new(grid, Planes::new(2, 3, grid.len(), data).unwrap()).unwrap(),
            quantity: Quantity::Reflectance,
            illuminant: None,
            distance_m: Some(1.0),
            horizontal_fov_deg: Some(20.0),
        };
        write(&path, &file, Layout::Fichet2021).unwrap();
        let name = path.to_str().unwrap();
        check(&load(name, &asked()).unwrap());
        // Other properties are those of the file.
        let as_stated = load(name, &SceneRequest::default()).unwrap();
        assert_eq!((as_stated.distance_m(), as_stated.horizontal_fov_deg()), (1.0, 20.0));
        assert_eq!(as_stated.radiance().grid(), grid);
    }

    #[test]
    fn errors_name_the_scene() {
        let error = |name: &str, request: &SceneRequest| load(name, request).unwrap_err().to_string();
        let dark = SceneRequest { luminance_cd_m2: Some(-1.0), ..SceneRequest::default() };
        assert!(error("macbeth", &dark).starts_with("macbeth: "), "{}", error("macbeth", &dark));
        let default = SceneRequest::default();
        let unknown = error("macbeht", &default);
        assert!(unknown.starts_with("there is no scene named 'macbeht'"), "{unknown}");
        for (typed, meant) in [("natural-portrat", "natural-portrait"), ("portrait", "natural-portrait")] {
            let unknown = error(typed, &default);
            assert!(unknown.contains(&format!("did you mean '{meant}'?")), "{unknown}");
        }
        assert!(error("absent.exr", &default).starts_with("cannot read absent.exr"));
    }
}
