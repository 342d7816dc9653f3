//! Scenes of comparisons.

use std::sync::Arc;

use super::{Camera, CameraError, DeferredScene, Setup, TEST_SAMPLES_PER_PX, test_scenes};
use crate::scene::{Scene, SceneError, Setting};
use crate::spectrum::{Illuminant, Spectrum, WavelengthGrid};

/// A scene on which cameras are compared.
#[derive(Debug, Clone, PartialEq)]
pub enum TestScene {
    /// A scene of the catalogue, by its name and parameters, with [`TEST_SAMPLES_PER_PX`] samples per pixel in each direction,
    /// under the illuminant of the comparison.
    BuiltIn(String),
    /// A scene that is loaded when it is first needed, with [`TEST_SAMPLES_PER_PX`] samples per pixel in each direction.
    Deferred(Arc<DeferredScene>),
    /// A given scene.
    Given {
        /// Its name.
        name: String,
        /// The scene; its mean luminance is 1 cd/m².
        scene: Arc<Scene>,
        /// Samples per pixel in each direction, at least 1.
        samples_per_px: usize,
        /// Whether the scene keeps its own light. Otherwise the caller has relit it under the illuminant of the comparison.
        keeps_light: bool,
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

    /// The scenes of the set `charts`, [`test_scenes`].
    #[must_use]
    pub fn charts() -> Vec<Self> {
        test_scenes().iter().map(|name| Self::built_in(name)).collect()
    }

    /// A given scene under the illuminant of the comparison, with a number of samples per pixel in each direction. Its mean luminance
    /// is 1 cd/m².
    #[must_use]
    pub fn relit(name: impl Into<String>, scene: Scene, samples_per_px: usize) -> Self {
        Self::Given { name: name.into(), scene: Arc::new(scene), samples_per_px, keeps_light: false }
    }

    /// A given scene in its own light, at a mean luminance of 1 cd/m² and with [`TEST_SAMPLES_PER_PX`] samples per pixel in each
    /// direction.
    ///
    /// # Errors
    /// When the scene is dark.
    pub fn in_own_light(name: impl Into<String>, scene: Scene) -> Result<Self, SceneError> {
        let scene = Arc::new(scene.with_mean_luminance(1.0)?);
        Ok(Self::Given { name: name.into(), scene, samples_per_px: TEST_SAMPLES_PER_PX, keeps_light: true })
    }

    /// The name of the scene.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::BuiltIn(name) | Self::Given { name, .. } => name,
            Self::Deferred(scene) => scene.name(),
        }
    }

    /// Whether the scene keeps its own light instead of that of the comparison.
    #[must_use]
    pub fn keeps_light(&self) -> bool {
        match self {
            Self::BuiltIn(_) => false,
            Self::Deferred(scene) => scene.own_light().is_some(),
            Self::Given { keeps_light, .. } => *keeps_light,
        }
    }

    /// Its wavelengths; `None` for a scene of the catalogue, which has those of each camera.
    #[must_use]
    pub fn grid(&self) -> Option<WavelengthGrid> {
        match self {
            Self::BuiltIn(_) => None,
            Self::Deferred(scene) => Some(scene.grid()),
            Self::Given { scene, .. } => Some(scene.radiance().grid()),
        }
    }

    /// Its illuminant at any level, photons, on its own wavelengths, or on these if it has none of its own. `illuminant` is that of the
    /// comparison.
    ///
    /// # Errors
    /// When the illuminant does not cover the wavelengths.
    pub fn light(&self, illuminant: &Illuminant, grid: WavelengthGrid) -> Result<Spectrum, CameraError> {
        let own = match self {
            Self::BuiltIn(_) => None,
            Self::Deferred(scene) => scene.own_light(),
            Self::Given { scene, .. } => Some(scene.illuminant()),
        };
        let of_comparison = || illuminant.photons(self.grid().unwrap_or(grid));
        Ok(own.map_or_else(of_comparison, |light| Ok(light.clone()))?)
    }

    /// The scene with its samples per pixel in each direction; `None` for one of the catalogue, which every camera builds.
    ///
    /// # Errors
    /// When it cannot be loaded.
    pub fn loaded(&self) -> Result<Option<(Arc<Scene>, usize)>, CameraError> {
        match self {
            Self::BuiltIn(_) => Ok(None),
            Self::Deferred(scene) => Ok(Some((scene.scene()?, TEST_SAMPLES_PER_PX))),
            Self::Given { scene, samples_per_px, .. } => Ok(Some((scene.clone(), *samples_per_px))),
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
        let on_its_grid = self.grid().map_or_else(|| Ok(camera.clone()), |grid| camera.on_grid(grid))?;
        match other.map(|setup| setup.before(&on_its_grid)).transpose()?.flatten() {
            Some(setup) => Ok(setup),
            None => self.before(&on_its_grid, illuminant),
        }
    }

    /// Images the scene on a camera at a mean luminance of 1 cd/m². A given scene keeps its wavelength grid.
    ///
    /// # Errors
    /// When the scene does not exist or a stage fails.
    pub fn before(&self, camera: &Camera, illuminant: &Illuminant) -> Result<Setup, CameraError> {
        let Some((scene, samples_per_px)) = self.loaded()? else {
            let illuminant = illuminant.clone();
            let setting = Setting { luminance_cd_m2: 1.0, illuminant, ..Setting::default() };
            return Setup::of_test_scene(camera, self.name(), &setting);
        };
        let camera = camera.on_grid(scene.radiance().grid())?;
        Setup::new(&camera, Scene::clone(&scene), samples_per_px)
    }
}
