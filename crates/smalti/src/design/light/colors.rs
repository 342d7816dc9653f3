//! The colours of the middle pixels of patches, in a few groups: the distribution about which errors are seen.

use super::classes::hue;
use crate::color::cie1976::lab_from_xyz;

/// Cuts between groups in L*.
const LIGHTNESS_CUTS: [f64; 3] = [25.0, 50.0, 75.0];
const HUES: usize = 5;
/// Number of groups: four ranges of lightness L* (below 25, 50, 75, and above), each with neutral, red, yellow, green and blue colours.
pub const COLOR_GROUPS: usize = (LIGHTNESS_CUTS.len() + 1) * HUES;

/// For each group of colours, the number of patches and the sums of X, Y, Z of their middle pixels relative to display white.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassColors(pub(super) [[f64; 4]; COLOR_GROUPS]);

impl Default for ClassColors {
    fn default() -> Self {
        Self([[0.0; 4]; COLOR_GROUPS])
    }
}

impl ClassColors {
    /// Adds a pixel; `white` is X, Y, Z of the illuminant with Y = 1.
    pub(super) fn add(&mut self, relative_xyz: [f64; 3], white: [f64; 3]) {
        let lab = lab_from_xyz(relative_xyz, white);
        let group = LIGHTNESS_CUTS.partition_point(|cut| *cut <= lab[0]) * HUES + hue(lab);
        let [count, sums @ ..] = &mut self.0[group];
        *count += 1.0;
        sums.iter_mut().zip(relative_xyz).for_each(|(s, v)| *s += v);
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened()).for_each(|(a, b)| *a += b);
    }

    /// Number of patches, and Σ X, Y, Z relative to display white, of each group: lightness varies slowest.
    #[must_use]
    pub fn groups(&self) -> &[[f64; 4]; COLOR_GROUPS] {
        &self.0
    }

    /// The mean colours of the groups that have patches, X, Y, Z relative to display white, with their shares of the patches.
    pub fn means(&self) -> impl Iterator<Item = ([f64; 3], f64)> + '_ {
        let total: f64 = self.0.iter().map(|group| group[0]).sum();
        let groups = self.0.iter().filter(|group| group[0] > 0.0);
        groups.map(move |[count, sums @ ..]| (sums.map(|s| s / count), count / total))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: [f64; 3] = [0.9504, 1.0, 1.0888];

    #[test]
    fn colours_are_grouped_by_lightness_and_hue() {
        let mut colors = ClassColors::default();
        let grey = |y: f64| WHITE.map(|w| w * y);
        // L* 10, 38, 64 and 96, and a dark red.
        for xyz in [grey(0.011), grey(0.1), grey(0.3), grey(0.32), grey(0.9), [0.1, 0.05, 0.01]] {
            colors.add(xyz, WHITE);
        }
        let counts: Vec<f64> = colors.groups().iter().map(|g| g[0]).collect();
        let at = |lightness: usize, hue: usize| counts[lightness * HUES + hue];
        assert_eq!([at(0, 0), at(1, 0), at(2, 0), at(3, 0), at(1, 1)], [1.0, 1.0, 2.0, 1.0, 1.0]);
        assert_eq!(counts.iter().sum::<f64>(), 6.0);
        let means: Vec<([f64; 3], f64)> = colors.means().collect();
        assert_eq!(means.len(), 5);
        assert!(
            means
                .iter()
                .any(|(xyz, share)| (xyz[1] - 0.31).abs() < 1e-12 && (share - 1.0 / 3.0).abs() < 1e-12)
        );
        let mut twice = colors.clone();
        twice.merge(&colors);
        assert_eq!(
            twice.means().map(|(xyz, _)| xyz).collect::<Vec<_>>(),
            means.iter().map(|m| m.0).collect::<Vec<_>>()
        );
    }
}
