//! Stored scenes of the default training set: photographs that are painted with the reflectances of training, and path-traced scenes
//! that were made of them.

use std::fmt::Display;

use smalti::camera::{NoStoredScenes, StoredTrainingScenes};
use smalti::color::repaint::Repaint;
use smalti::numeric::Planes;
use smalti::scene::{Scene, Setting};
use smalti::spectrum::{Illuminant, Observer, SpectralCube, Spectrum, SpectrumError, WavelengthGrid};

use super::components;
use super::photograph::{decode, reflectances};

/// The training scenes that are stored in this crate. None of them is a test scene, nor shows what one shows.
#[derive(Debug, Clone, Copy, Default)]
pub struct BuiltInTrainingScenes;

/// The scenes that pipelines learn from by default.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum TrainingSet {
    /// Scenes of the catalogue, photographs and path-traced scenes.
    #[default]
    All,
    /// Scenes of the catalogue alone.
    Catalog,
}

impl TrainingSet {
    /// All sets with their names and summaries.
    pub const NAMED: [(&'static str, &'static str, Self); 2] = [
        ("all", "Scenes of the catalogue, photographs and path-traced scenes", Self::All),
        ("catalog", "Scenes of the catalogue alone", Self::Catalog),
    ];

    /// Those of its scenes that come from files.
    #[must_use]
    pub fn stored(self) -> &'static dyn StoredTrainingScenes {
        match self {
            Self::All => &BuiltInTrainingScenes,
            Self::Catalog => &NoStoredScenes,
        }
    }
}

/// The names of the training scenes that are stored, photographs and path-traced scenes.
pub(crate) const NAMES: [&str; 7] = [
    "training-clutter-1",
    "training-clutter-2",
    "training-coffee",
    "training-dandelion",
    "training-drum",
    "training-mountain",
    "training-spaniels",
];

/// The file of a training scene.
pub(crate) fn file(name: &str) -> Option<&'static [u8]> {
    Some(match name {
        "training-clutter-1" => smalti_scenes::CLUTTER_1,
        "training-clutter-2" => smalti_scenes::CLUTTER_2,
        "training-coffee" => include_bytes!("../../scenes/training-coffee.jpg"),
        "training-dandelion" => include_bytes!("../../scenes/training-dandelion.jpg"),
        "training-drum" => include_bytes!("../../scenes/training-drum.jpg"),
        "training-mountain" => include_bytes!("../../scenes/training-mountain.jpg"),
        "training-spaniels" => include_bytes!("../../scenes/training-spaniels.jpg"),
        _ => return None,
    })
}

impl StoredTrainingScenes for BuiltInTrainingScenes {
    fn names(&self) -> Vec<&'static str> {
        NAMES.to_vec()
    }

    fn load(&self, name: &str, grid: WavelengthGrid, painted_with: &[Spectrum]) -> Result<Scene, String> {
        let bytes = file(name).ok_or_else(|| format!("there is no training scene {name}"))?;
        scene(name, bytes, grid, painted_with)
    }
}

/// The scene of a file: a photograph as JPEG, which is painted, or components of spectral radiance under lamps of one spectrum.
///
/// # Errors
/// Why the scene cannot be read.
pub(crate) fn scene(
    name: &str,
    bytes: &[u8],
    grid: WavelengthGrid,
    painted_with: &[Spectrum],
) -> Result<Scene, String> {
    let cube = if components::is_file(bytes) {
        let scene = components::decode(name, bytes).and_then(|f| f.into_scene(&Setting::default()));
        relative_to_light(&scene.map_err(text)?, grid).map_err(text)?
    } else {
        let image = decode(name, bytes).map_err(text)?;
        let repaint = Repaint::with(grid, Observer::Cie1931, painted_with.iter().cloned()).map_err(text)?;
        repaint.repaint_image(&image).map_err(text)?
    };
    let setting = Setting { illuminant: Illuminant::E, grid, ..Setting::default() };
    reflectances(name, cube).into_scene(&setting).map_err(text)
}

/// Radiance relative to that of a white in the scene's light, interpolated to a grid and held constant beyond the wavelengths of the
/// scene.
fn relative_to_light(scene: &Scene, grid: WavelengthGrid) -> Result<SpectralCube, SpectrumError> {
    let (from, light) = (scene.radiance(), scene.illuminant().values());
    let bands = from.grid();
    let mut planes = Planes::zeros(from.rows(), from.cols(), grid.len());
    for (k, plane) in planes.planes_mut().enumerate() {
        let at = (grid.wavelength_nm(k) - bands.start_nm()) / bands.step_nm();
        let at = at.clamp(0.0, (bands.len() - 1) as f64);
        let (low, share) = (at as usize, at.fract());
        let high = (low + 1).min(bands.len() - 1);
        let weights = [(1.0 - share) / light[low], share / light[high]].map(|w| w as f32);
        let (low, high) = (from.planes().plane(low)?, from.planes().plane(high)?);
        for ((to, a), b) in plane.iter_mut().zip(low).zip(high) {
            *to = weights[0] * a + weights[1] * b;
        }
    }
    SpectralCube::new(grid, planes)
}

fn text(error: impl Display) -> String {
    error.to_string()
}

#[cfg(test)]
mod tests {
    use smalti::camera::training_reflectances;

    use super::*;

    /// On wavelengths beyond those of the stored scenes, as a camera for near infrared has them.
    #[test]
    fn scenes_load_on_any_wavelengths() {
        let grid = WavelengthGrid::new(380.0, 124.0, 6).unwrap();
        let reflectances = training_reflectances(grid).unwrap();
        for name in BuiltInTrainingScenes.names() {
            let scene = BuiltInTrainingScenes.load(name, grid, &reflectances).unwrap();
            assert_eq!(scene.radiance().grid(), grid, "{name}");
            assert!(scene.illuminant().values().iter().all(|&v| v > 0.0), "{name}");
            let relit = scene.relit(&Illuminant::A).unwrap();
            assert!(relit.radiance().planes().data().iter().all(|v| v.is_finite()), "{name}");
        }
        let unknown = BuiltInTrainingScenes.load("training-tea", grid, &reflectances);
        assert_eq!(unknown.unwrap_err(), "there is no training scene training-tea");
    }

    /// A path-traced scene on its own wavelengths, relit with an equal-energy illuminant, is the stored scene up to its luminance.
    #[test]
    fn an_equal_energy_illuminant_leaves_the_colours_of_a_rendered_scene() {
        let loaded = BuiltInTrainingScenes.load("training-clutter-1", WavelengthGrid::VISIBLE, &[]).unwrap();
        let (name, bytes) = (loaded.name(), file(loaded.name()).unwrap());
        let stored = components::decode(name, bytes).unwrap().into_scene(&Setting::default()).unwrap();
        let (a, b) = (loaded.radiance().pixel(300, 200).unwrap(), stored.radiance().pixel(300, 200).unwrap());
        let ratios: Vec<f64> = a.values().iter().zip(b.values()).map(|(a, b)| a / b).collect();
        assert!(ratios.iter().all(|r| (r / ratios[0] - 1.0).abs() < 1e-5), "{ratios:?}");
    }
}
