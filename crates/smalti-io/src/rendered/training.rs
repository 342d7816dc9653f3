//! Stored scenes of the default training set: photographs that are painted with the reflectances of training.

use std::fmt::Display;

use smalti::camera::StoredTrainingScenes;
use smalti::color::repaint::Repaint;
use smalti::scene::{Scene, Setting};
use smalti::spectrum::{Illuminant, Observer, Spectrum, WavelengthGrid};

use super::photograph::{decode, reflectances};

/// The training scenes that are stored in this crate. None of them is a test scene, nor shows what one shows.
#[derive(Debug, Clone, Copy, Default)]
pub struct BuiltInTrainingScenes;

macro_rules! photographs {
    ($($name:literal),*) => {
        [$(($name, include_bytes!(concat!("../../scenes/", $name, ".jpg")))),*]
    };
}

/// Photographs as JPEG, by their names.
static PHOTOGRAPHS: [(&str, &[u8]); 5] = photographs![
    "training-coffee",
    "training-dandelion",
    "training-drum",
    "training-mountain",
    "training-spaniels"
];

impl StoredTrainingScenes for BuiltInTrainingScenes {
    fn names(&self) -> Vec<&'static str> {
        PHOTOGRAPHS.iter().map(|(name, _)| *name).collect()
    }

    fn load(&self, name: &str, grid: WavelengthGrid, painted_with: &[Spectrum]) -> Result<Scene, String> {
        let stored = PHOTOGRAPHS.iter().find(|(known, _)| *known == name);
        let (_, bytes) = stored.ok_or_else(|| format!("there is no training scene {name}"))?;
        let image = decode(name, bytes).map_err(text)?;
        let repaint = Repaint::with(grid, Observer::Cie1931, painted_with.iter().cloned()).map_err(text)?;
        let cube = repaint.repaint_image(&image).map_err(text)?;
        let setting = Setting { illuminant: Illuminant::E, grid, ..Setting::default() };
        reflectances(name, cube).into_scene(&setting).map_err(text)
    }
}

fn text(error: impl Display) -> String {
    error.to_string()
}
