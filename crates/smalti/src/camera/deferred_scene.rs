//! Scenes of comparisons that are loaded when they are first needed.

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use super::CameraError;
use crate::scene::Scene;
use crate::spectrum::{Spectrum, WavelengthGrid};

/// Makes a scene, or says why it cannot.
type Load = Box<dyn Fn() -> Result<Scene, String> + Send + Sync>;

/// A scene at a mean luminance of 1 cd/m² that is loaded when it is first needed, and then kept.
pub struct DeferredScene {
    name: String,
    grid: WavelengthGrid,
    own_light: Option<Spectrum>,
    load: Load,
    loaded: Mutex<Option<Arc<Scene>>>,
}

impl DeferredScene {
    /// A scene that `load` makes, on the grid. `own_light` is its illuminant (photons) at any level, on the grid; without one, `load`
    /// relights the scene under the illuminant of the comparison.
    #[must_use]
    pub fn new(
        name: impl Into<String>,
        grid: WavelengthGrid,
        own_light: Option<Spectrum>,
        load: impl Fn() -> Result<Scene, String> + Send + Sync + 'static,
    ) -> Self {
        let loaded = Mutex::new(None);
        Self { name: name.into(), grid, own_light, load: Box::new(load), loaded }
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its wavelengths.
    #[must_use]
    pub fn grid(&self) -> WavelengthGrid {
        self.grid
    }

    /// Its illuminant, photons, at any level; `None` if it has that of the comparison.
    #[must_use]
    pub fn own_light(&self) -> Option<&Spectrum> {
        self.own_light.as_ref()
    }

    /// The scene.
    ///
    /// # Errors
    /// When it cannot be loaded, or has other wavelengths than stated.
    pub fn scene(&self) -> Result<Arc<Scene>, CameraError> {
        let kept = || self.loaded.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(scene) = &*kept() {
            return Ok(scene.clone());
        }
        // Not within the lock, which another task of this thread may want meanwhile.
        let scene = (self.load)().map_err(CameraError::DeferredScene)?;
        let (grid, own) = (scene.radiance().grid(), self.grid);
        if grid != own {
            return Err(CameraError::DeferredScene(format!("the scene has light at {grid}; expected {own}")));
        }
        Ok(kept().get_or_insert(Arc::new(scene)).clone())
    }
}

impl fmt::Debug for DeferredScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, grid, own_light, .. } = self;
        let mut written = f.debug_struct("DeferredScene");
        written.field("name", name).field("grid", grid).field("own_light", own_light).finish_non_exhaustive()
    }
}

impl PartialEq for DeferredScene {
    /// Whether they are one and the same: two may load different scenes.
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}
