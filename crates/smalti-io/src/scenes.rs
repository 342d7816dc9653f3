//! Scenes by name or file.

use std::path::Path;

use smalti::scene::{Scene, SceneError, Setting, catalog};
use smalti::spectrum::{Illuminant, WavelengthGrid};

use crate::error::At;
use crate::scene_file::{self, is_meant};
use crate::{IoError, ReadOptions};

/// What is asked of a scene. What is not is as its file states, else as in [`Setting`].
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
    /// What a file may leave unsaid.
    pub read: ReadOptions,
}

impl SceneRequest {
    /// A scene made to be what is asked for, whatever it was.
    ///
    /// # Errors
    /// When the scene cannot be so: it is dark, has no light at a wavelength, or a number is out of range.
    pub fn applied_to(&self, scene: Scene) -> Result<Scene, SceneError> {
        let scene = match self.grid {
            Some(grid) if grid != scene.radiance().grid() => scene.resampled(grid)?,
            _ => scene,
        };
        let scene = match &self.illuminant {
            Some(light) => scene.relit(light)?,
            None => scene,
        };
        let scene = match self.luminance_cd_m2 {
            Some(cd_m2) => scene.with_mean_luminance(cd_m2)?,
            None => scene,
        };
        let scene = match self.distance_m {
            Some(m) => scene.with_distance(m)?,
            None => scene,
        };
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

/// A built-in scene by its name and parameters (`zone-plate?frequency=0.4`), painted with natural reflectances, or a file of any
/// format that [`scene_file`] reads.
///
/// # Errors
/// When there is no such scene, a parameter is out of range, the file holds no scene, or it cannot be as asked.
pub fn load(name: &str, request: &SceneRequest) -> Result<Scene, IoError> {
    let setting = request.setting();
    if !is_meant(name) {
        return catalog::build_natural(name, &setting).map_err(IoError::Catalog);
    }
    let path = Path::new(name);
    request.applied_to(scene_file::read(path, &setting, &request.read)?).at(path)
}
