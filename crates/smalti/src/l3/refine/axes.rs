//! The class axes of the second stage.

use serde::{Deserialize, Serialize};

use super::super::error::within;
use super::super::{L3Error, Levels};

/// Thresholds of the trace of the structure tensor, in variances of the noise of one sample. The picture that is classified has been
/// smoothed, so that flat areas stay below the first.
pub(super) const STRENGTHS: [f32; 3] = [0.02, 0.1, 0.5];
/// Structures of each strength: texture, and edges in four orientations.
const PER_STRENGTH: usize = 5;
/// Structures: flat, and those of each strength.
pub(super) const STRUCTURES: usize = 1 + STRENGTHS.len() * PER_STRENGTH;

/// Classes of pixels by brightness and structure: level × (flat, or strength × (texture, edge 0°, 45°, 90°, 135°)).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stated")]
pub struct RefinementAxes {
    levels: Levels,
    noise: [f32; 3],
}

/// The fields of axes that are not checked yet.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Stated {
    levels: Levels,
    noise: [f32; 3],
}

impl TryFrom<Stated> for RefinementAxes {
    type Error = L3Error;

    fn try_from(Stated { levels, noise }: Stated) -> Result<Self, L3Error> {
        Self::new(levels, noise)
    }
}

impl RefinementAxes {
    /// Axes with the levels of Y and the noise of one sample in units of Y: its variance at Y is `noise[0] + noise[1] Y + noise[2] Y²`.
    ///
    /// # Errors
    /// When a coefficient is negative or not finite, or there is no noise at Y = 0.
    pub fn new(levels: Levels, noise: [f32; 3]) -> Result<Self, L3Error> {
        let expected = "above 0, at most 1e6";
        within("the variance of the noise at Y = 0", f64::from(noise[0]), 1e-20..=1e6, expected)?;
        for value in noise {
            within("a variance of the noise of the picture", f64::from(value), 0.0..=1e6, "0 to 1e6")?;
        }
        Ok(Self { levels, noise })
    }

    /// Levels of Y.
    #[must_use]
    pub fn levels(&self) -> &Levels {
        &self.levels
    }

    /// Coefficients of 1, Y and Y² in the variance of the noise of one sample, in units of Y.
    #[must_use]
    pub fn noise(&self) -> [f32; 3] {
        self.noise
    }

    /// Number of classes.
    #[must_use]
    pub fn count(&self) -> usize {
        self.levels.count() * STRUCTURES
    }

    /// Number of structures of each level.
    #[must_use]
    pub fn structures(&self) -> usize {
        STRUCTURES
    }

    /// The name of a structure.
    #[must_use]
    pub fn structure_name(structure: usize) -> String {
        const KINDS: [&str; PER_STRENGTH] = ["texture", "edge 0°", "edge 45°", "edge 90°", "edge 135°"];
        match structure.checked_sub(1) {
            None => "flat".into(),
            Some(i) => format!("{}, strength {}", KINDS[i % PER_STRENGTH], 1 + i / PER_STRENGTH),
        }
    }
}

/// The structure of a strength from 0 and a kind: texture 0, then the edges.
#[inline(always)]
pub(super) fn structure(strength: u32, kind: u32) -> u32 {
    if strength == 0 { 0 } else { 1 + (strength - 1) * PER_STRENGTH as u32 + kind }
}
