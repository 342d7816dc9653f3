//! Training settings for the pipelines of designs.

use serde::{Deserialize, Serialize};

use crate::l3::{L3Error, Solver, Textures};

/// What the pipeline of a design is learned from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum LearningStatistics {
    /// The patches of a capture of the training scene by the design.
    #[default]
    Patches,
    /// Statistics of the light of the training scene, which are gathered once for all designs. This takes an eighth of the time. For
    /// sensors whose samples each see one filter, and for the solver `wiener`.
    Light,
}

/// Training settings for the pipelines of designs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct LearningSettings {
    /// Side of the patch, pixels: 3, 5, 7, 9 or 11.
    pub side: usize,
    /// Number of response levels, 1 to 256. Few suffice, since all targets are exposed like the training scene.
    pub levels: usize,
    /// Texture classes.
    pub textures: Textures,
    /// Solver of the kernels.
    pub solver: Solver,
    /// Side of the training scene, pixels, 16 to 1024. Training time is proportional to its square, for `statistics = "light"` only
    /// that of the preparation.
    pub size_px: usize,
    /// What pipelines are learned from: the `patches` of a capture by each design, or statistics of the `light`.
    #[serde(skip_serializing_if = "is_default")]
    pub statistics: LearningStatistics,
    /// Number of the training scene, 0 to 1000: scenes of other numbers have other leaves.
    #[serde(skip_serializing_if = "is_default")]
    pub scene: u32,
}

impl Default for LearningSettings {
    fn default() -> Self {
        Self {
            side: 7,
            levels: 4,
            textures: Textures::Oriented,
            solver: Solver::Wiener,
            size_px: 320,
            statistics: LearningStatistics::default(),
            scene: 0,
        }
    }
}

impl LearningSettings {
    /// Checks every field.
    ///
    /// # Errors
    /// [`L3Error::Parameter`] with the first field that is out of its range.
    pub fn validate(&self) -> Result<(), L3Error> {
        let range = |name, value: usize, fits: bool, expected| {
            if fits { Ok(()) } else { Err(L3Error::Parameter { name, value: value as f64, expected }) }
        };
        range("side", self.side, [3, 5, 7, 9, 11].contains(&self.side), "3, 5, 7, 9 or 11 pixels")?;
        range("levels", self.levels, (1..=256).contains(&self.levels), "1 to 256")?;
        range("size_px", self.size_px, (16..=1024).contains(&self.size_px), "16 to 1024 pixels")?;
        range("scene", self.scene as usize, self.scene <= 1000, "0 to 1000")
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
