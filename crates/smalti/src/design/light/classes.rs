//! Classes of patches by luminance, contrast, direction and hue of the light itself. No colour filter array changes them.

use serde::{Deserialize, Serialize};

use super::super::error::DesignError;
use crate::color::cie1976::lab_from_xyz;

/// Chroma C*ab below which a patch counts as neutral.
const NEUTRAL_CHROMA: f64 = 10.0;
/// Ratio of the contrasts along rows and along columns from which a patch has a direction.
const DIRECTED: f64 = 2.0;

/// The rule that assigns a patch to its class.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct LightClasses {
    /// Ascending cuts between levels of the mean luminance of a patch, relative to the mean luminance of its scene.
    pub luminance_cuts: Vec<f64>,
    /// Ascending cuts between levels of contrast: the standard deviation of the luminance within a patch divided by its mean.
    pub contrast_cuts: Vec<f64>,
    /// Whether patches of the highest contrast are divided into those without a direction, those that vary mostly along rows, and
    /// those that vary mostly along columns.
    pub directions: bool,
    /// Whether patches are divided by their mean colour into neutral, red, yellow, green and blue ones.
    pub hues: bool,
}

impl Default for LightClasses {
    /// Two classes, of low and high contrast. They rank arrays best as learned pipelines do in the dark, where noise hides finer classes
    /// from a pipeline, and nearly best in bright light (docs/designs.md).
    fn default() -> Self {
        Self { luminance_cuts: Vec::new(), contrast_cuts: vec![0.15], directions: false, hues: false }
    }
}

/// What the class of a patch follows from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PatchFigures {
    /// Mean luminance relative to the mean of the scene.
    pub(super) mean_y: f64,
    /// Standard deviation of the luminance divided by its mean.
    pub(super) contrast: f64,
    /// Sums of absolute differences of the luminance along rows and along columns.
    pub(super) along: [f64; 2],
    /// Mean X, Y, Z relative to display white of the scene.
    pub(super) xyz: [f64; 3],
}

impl LightClasses {
    /// Checks that the cuts ascend.
    ///
    /// # Errors
    /// [`DesignError::Key`] with the first list that does not.
    pub fn validate(&self) -> Result<(), DesignError> {
        for (key, cuts) in [("luminance_cuts", &self.luminance_cuts), ("contrast_cuts", &self.contrast_cuts)]
        {
            let ascends = cuts.windows(2).all(|w| w[0] < w[1]);
            if !(ascends && cuts.len() <= 30 && cuts.iter().all(|c| c.is_finite() && *c > 0.0)) {
                return Err(DesignError::key(key, "expected at most 30 ascending numbers above 0"));
            }
        }
        Ok(())
    }

    /// Number of levels of luminance.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.luminance_cuts.len() + 1
    }

    /// Number of classes of one level: contrasts with their directions.
    fn textures(&self) -> usize {
        self.contrast_cuts.len() + if self.directions { 3 } else { 1 }
    }

    fn hue_count(&self) -> usize {
        if self.hues { 5 } else { 1 }
    }

    /// Number of classes.
    #[must_use]
    pub fn count(&self) -> usize {
        self.levels() * self.textures() * self.hue_count()
    }

    /// The level of contrast of a class, from 0 for the lowest.
    pub(in crate::design) fn contrast_of(&self, class: usize) -> usize {
        (class / self.hue_count() % self.textures()).min(self.contrast_cuts.len())
    }

    /// The classes that differ from a class in their hue alone, itself included.
    pub(in crate::design) fn of_all_hues(&self, class: usize) -> std::ops::Range<usize> {
        let hues = self.hue_count();
        class / hues * hues..(class / hues + 1) * hues
    }

    /// The class of a patch; `white` is X, Y, Z of the illuminant with Y = 1.
    pub(super) fn class_of(&self, patch: &PatchFigures, white: [f64; 3]) -> usize {
        let level = self.luminance_cuts.partition_point(|cut| *cut <= patch.mean_y);
        let contrast = self.contrast_cuts.partition_point(|cut| *cut <= patch.contrast);
        let [rows, cols] = patch.along;
        let direction = match contrast == self.contrast_cuts.len() && self.directions {
            true if rows > DIRECTED * cols => 1,
            true if cols > DIRECTED * rows => 2,
            _ => 0,
        };
        let hue = if self.hues { hue(lab_from_xyz(patch.xyz, white)) } else { 0 };
        (level * self.textures() + contrast + direction) * self.hue_count() + hue
    }
}

/// 0 for neutral, then red, yellow, green and blue: quadrants about 0, 90, 180 and 270°.
pub(super) fn hue([_, a, b]: [f64; 3]) -> usize {
    if a * a + b * b < NEUTRAL_CHROMA * NEUTRAL_CHROMA {
        return 0;
    }
    match (a.abs() >= b.abs(), a > 0.0, b > 0.0) {
        (true, true, _) => 1,
        (false, _, true) => 2,
        (true, false, _) => 3,
        (false, _, false) => 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: [f64; 3] = [0.9504, 1.0, 1.0888];

    fn fine() -> LightClasses {
        let (luminance_cuts, contrast_cuts) = (vec![0.15, 0.4, 0.9, 1.8], vec![0.03, 0.15]);
        LightClasses { luminance_cuts, contrast_cuts, ..LightClasses::default() }
    }

    fn grey(mean_y: f64, contrast: f64, along: [f64; 2]) -> PatchFigures {
        PatchFigures { mean_y, contrast, along, xyz: WHITE.map(|v| 0.2 * v) }
    }

    #[test]
    fn every_class_has_its_own_number() {
        let classes = LightClasses { directions: true, hues: true, ..fine() };
        assert_eq!(classes.count(), 5 * 5 * 5);
        let mut seen = std::collections::BTreeSet::new();
        for mean_y in [0.1, 0.2, 0.5, 1.0, 2.0] {
            for (contrast, along) in [
                (0.01, [1.0, 1.0]),
                (0.1, [9.0, 1.0]),
                (0.2, [1.0, 1.0]),
                (0.2, [9.0, 1.0]),
                (0.2, [1.0, 9.0]),
            ] {
                for xyz in
                    [[0.2, 0.2, 0.2], [0.4, 0.2, 0.02], [0.3, 0.3, 0.02], [0.1, 0.3, 0.1], [0.1, 0.1, 0.9]]
                {
                    let patch = PatchFigures { xyz, ..grey(mean_y, contrast, along) };
                    seen.insert(classes.class_of(&patch, [1.0; 3]));
                }
            }
        }
        assert_eq!(seen.len(), classes.count());
        assert_eq!(seen.last(), Some(&(classes.count() - 1)));
    }

    #[test]
    fn cuts_belong_to_the_class_above() {
        let classes = fine();
        assert_eq!(classes.class_of(&grey(0.15, 0.03, [0.0; 2]), WHITE), 3 + 1);
        assert_eq!(classes.class_of(&grey(0.149, 0.029, [0.0; 2]), WHITE), 0);
        assert_eq!(classes.of_all_hues(4), 4..5);
    }

    #[test]
    fn cuts_must_ascend() {
        let classes = |cuts: &[f64]| LightClasses { contrast_cuts: cuts.to_vec(), ..LightClasses::default() };
        for bad in [&[0.2, 0.1][..], &[0.0], &[f64::NAN], &[0.1, 0.1]] {
            assert!(
                matches!(classes(bad).validate(), Err(DesignError::Key { key, .. }) if key == "contrast_cuts")
            );
        }
        assert!(classes(&[]).validate().is_ok());
    }
}
