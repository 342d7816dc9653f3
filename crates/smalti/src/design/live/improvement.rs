//! What better designs are to the studio, whether its page or the native library searches them.

use serde::Deserialize;

use crate::camera::Camera;
use crate::design::screen::ScreenCondition;
use crate::design::search::{Dichroic, FilterSpace, FreeCurves, Objective, Over, Pigments};

/// The longest exposure of cameras that state no time, s, as in the built-in designs.
const LONGEST_S: f64 = 0.033;
/// Weight of a unit of CIEDE2000 beside a decibel, as in the built-in designs.
const DELTA_E_2000: f64 = 2.0;

/// The filters that can be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LiveFamily {
    /// Any smooth curve.
    #[default]
    Free,
    /// Layers of pigments.
    Pigments,
    /// Bands between two edges.
    Dichroic,
}

impl LiveFamily {
    /// The filters of the family; `free` are the smooth curves.
    #[must_use]
    pub fn space(self, free: FreeCurves) -> FilterSpace {
        match self {
            Self::Free => FilterSpace::Free(free),
            Self::Pigments => FilterSpace::Pigments(Pigments::default()),
            Self::Dichroic => FilterSpace::Dichroic(Dichroic::default()),
        }
    }
}

/// The conditions of a camera at some mean luminances, cd/m².
#[must_use]
pub fn live_conditions(camera: &Camera, luminances_cd_m2: &[f64]) -> Vec<ScreenCondition> {
    luminances_cd_m2.iter().map(|l| ScreenCondition::of_camera(camera, *l, LONGEST_S)).collect()
}

/// What is minimised: the worst of the conditions.
#[must_use]
pub fn live_objective() -> Objective {
    Objective { delta_e_2000: DELTA_E_2000, over: Over::Worst, ..Objective::default() }
}
