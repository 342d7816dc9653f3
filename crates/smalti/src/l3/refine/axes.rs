//! The class axes of the second stage.

use serde::{Deserialize, Serialize};

use super::super::error::within;
use super::super::{L3Error, Levels};

/// Thresholds of the trace of the structure tensor, in variances of the noise of one sample. The picture that is classified has been
/// smoothed, so that flat areas stay below the first.
const STRENGTHS: [f32; 10] = [0.02, 0.1, 0.5, 2.5, 12.5, 62.5, 312.5, 1562.5, 7812.5, 39_062.5];
/// Orientations of edges.
const ORIENTATIONS: usize = 8;
/// Greatest number of strengths.
pub(super) const MAX_STRENGTHS: usize = 12;

/// Classes of pixels by brightness and structure: level × (flat, or strength × (texture, or an edge in one of the orientations)).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stated")]
pub struct RefinementAxes {
    levels: Levels,
    noise: [f32; 3],
    strengths: Vec<f32>,
    orientations: usize,
}

/// The fields of axes that are not checked yet.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Stated {
    levels: Levels,
    noise: [f32; 3],
    #[serde(default = "strengths_of_version_2")]
    strengths: Vec<f32>,
    #[serde(default = "orientations_of_version_2")]
    orientations: usize,
}

fn strengths_of_version_2() -> Vec<f32> {
    vec![0.02, 0.1, 0.5]
}

fn orientations_of_version_2() -> usize {
    4
}

impl TryFrom<Stated> for RefinementAxes {
    type Error = L3Error;

    fn try_from(stated: Stated) -> Result<Self, L3Error> {
        Self::new(stated.levels, stated.noise)?.with_structures(stated.strengths, stated.orientations)
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
        Ok(Self { levels, noise, strengths: STRENGTHS.to_vec(), orientations: ORIENTATIONS })
    }

    /// The same with other structures: thresholds of the trace of the structure tensor, in variances of the noise of one sample, and the
    /// number of orientations of edges.
    ///
    /// # Errors
    /// When there are no thresholds or more than twelve, they are not above 0 and ascending, or there are not 4 or 8 orientations.
    pub fn with_structures(self, strengths: Vec<f32>, orientations: usize) -> Result<Self, L3Error> {
        let (count, expected) = (strengths.len() as f64, "1 to 12");
        within("the number of strengths of structure", count, 1.0..=MAX_STRENGTHS as f64, expected)?;
        let mut last = 0.0;
        for &strength in &strengths {
            let least = f64::from(f32::next_up(last));
            within(
                "a strength of structure",
                f64::from(strength),
                least..=1e6,
                "above the one before, at most 1e6",
            )?;
            last = strength;
        }
        if ![4, 8].contains(&orientations) {
            let reason = format!("{orientations} orientations of the second stage; expected 4 or 8");
            return Err(L3Error::Table(reason));
        }
        Ok(Self { strengths, orientations, ..self })
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

    /// The standard deviation of the noise of one sample at Y = 0, in units of Y.
    #[must_use]
    pub fn dark_noise(&self) -> f32 {
        self.noise[0].sqrt()
    }

    /// Thresholds of the strengths of structure, in variances of the noise of one sample.
    #[must_use]
    pub fn strengths(&self) -> &[f32] {
        &self.strengths
    }

    /// Number of orientations of edges, 4 or 8.
    #[must_use]
    pub fn orientations(&self) -> usize {
        self.orientations
    }

    /// Number of classes.
    #[must_use]
    pub fn count(&self) -> usize {
        self.levels.count() * self.structures()
    }

    /// Number of structures of each level: flat, and texture and edges of each strength.
    #[must_use]
    pub fn structures(&self) -> usize {
        1 + self.strengths.len() * self.kinds()
    }

    /// Structures of each strength: texture, and an edge in each orientation.
    pub(super) fn kinds(&self) -> usize {
        1 + self.orientations
    }

    /// Strength and kind, from 0, of a structure that is not flat.
    fn strength_and_kind(&self, structure: usize) -> Option<[usize; 2]> {
        structure.checked_sub(1).map(|i| [i / self.kinds(), i % self.kinds()])
    }

    /// The level of a class, and its strength of structure from 1 on; 0 where it is flat.
    pub(super) fn level_and_strength(&self, class: u32) -> (usize, usize) {
        let (level, structure) = (class as usize / self.structures(), class as usize % self.structures());
        (level, self.strength_and_kind(structure).map_or(0, |[strength, _]| 1 + strength))
    }

    /// Y in the middle of a level, whose ends are open at the first and the last one: half of the least cut, and the greatest. Half of white where there
    /// is one level.
    pub(super) fn brightness(&self, level: usize) -> f32 {
        let cuts = self.levels.cuts();
        match (level.checked_sub(1).and_then(|i| cuts.get(i)), cuts.get(level)) {
            (Some(from), Some(to)) => (from * to).sqrt(),
            (Some(from), None) => *from,
            (None, Some(to)) => 0.5 * to,
            (None, None) => 0.5,
        }
    }

    /// Steps of level or strength, whichever are more, between two classes of the same texture or orientation. `None` for other classes.
    pub(super) fn steps_between(&self, a: u32, b: u32) -> Option<usize> {
        let structures = self.structures();
        let [(level_a, a), (level_b, b)] =
            [a, b].map(|c| (c as usize / structures, self.strength_and_kind(c as usize % structures)));
        let levels = level_a.abs_diff(level_b);
        match (a, b) {
            (None, None) => Some(levels),
            (Some([a, kind_a]), Some([b, kind_b])) if kind_a == kind_b => Some(levels.max(a.abs_diff(b))),
            _ => None,
        }
    }

    /// The most steps between two classes.
    pub(super) fn longest(&self) -> usize {
        self.levels.count().max(self.strengths.len()) - 1
    }

    /// The name of a structure.
    #[must_use]
    pub fn structure_name(&self, structure: usize) -> String {
        match self.strength_and_kind(structure) {
            None => "flat".into(),
            Some([strength, 0]) => format!("texture, strength {}", 1 + strength),
            Some([strength, kind]) => {
                let angle = 180.0 / self.orientations as f64 * (kind - 1) as f64;
                format!("edge {angle}°, strength {}", 1 + strength)
            }
        }
    }
}

/// The structure of a strength and a kind, both from 0 for flat and for texture, among `kinds` of each strength.
#[inline(always)]
pub(super) fn structure(strength: u32, kind: u32, kinds: u32) -> u32 {
    if strength == 0 { 0 } else { 1 + (strength - 1) * kinds + kind }
}
