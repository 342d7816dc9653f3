//! Scenes of comparisons.

use super::{Camera, CameraError, Setup, test_scenes};
use crate::scene::{Scene, Setting};
use crate::spectrum::Illuminant;

/// A scene on which cameras are compared.
#[derive(Debug, Clone, PartialEq)]
pub enum TestScene {
    /// A scene of the catalogue, by its name and parameters, with two samples per pixel in each direction.
    BuiltIn(String),
    /// A given scene with one sample per pixel.
    Given {
        /// Its name.
        name: String,
        /// The scene; its mean luminance is 1 cd/m².
        scene: Scene,
    },
}

impl TestScene {
    /// A built-in scene by its name and parameters. A name without parameters selects the scene of that name among
    /// [`test_scenes`], which is larger than that of the catalogue.
    #[must_use]
    pub fn built_in(name: &str) -> Self {
        let of_test_set = test_scenes().iter().find(|s| s.split('?').next() == Some(name.trim()));
        Self::BuiltIn((*of_test_set.unwrap_or(&name)).to_owned())
    }

    /// The default scenes of a comparison, [`test_scenes`].
    #[must_use]
    pub fn default_set() -> Vec<Self> {
        test_scenes().iter().map(|name| Self::built_in(name)).collect()
    }

    /// The name of the scene.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::BuiltIn(name) | Self::Given { name, .. } => name,
        }
    }

    /// [`TestScene::before`] with the optical image of this scene on another camera, if lens, pixel pitch and wavelengths are the same.
    ///
    /// # Errors
    /// As [`TestScene::before`].
    pub fn before_sharing(
        &self,
        camera: &Camera,
        illuminant: &Illuminant,
        other: Option<&Setup>,
    ) -> Result<Setup, CameraError> {
        match other.map(|setup| setup.before(camera)).transpose()?.flatten() {
            Some(setup) => Ok(setup),
            None => self.before(camera, illuminant),
        }
    }

    /// Images the scene on a camera at a mean luminance of 1 cd/m². A given scene keeps its wavelength grid.
    ///
    /// # Errors
    /// When the scene does not exist or a stage fails.
    pub fn before(&self, camera: &Camera, illuminant: &Illuminant) -> Result<Setup, CameraError> {
        match self {
            Self::BuiltIn(name) => {
                let illuminant = illuminant.clone();
                let setting = Setting { luminance_cd_m2: 1.0, illuminant, ..Setting::default() };
                Setup::of_test_scene(camera, name, &setting)
            }
            Self::Given { scene, .. } => camera
                .on_grid(scene.radiance().grid())
                .and_then(|camera| Setup::new(&camera, scene.clone(), 1)),
        }
    }
}
