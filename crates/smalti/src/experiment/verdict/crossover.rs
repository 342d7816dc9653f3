//! The luminance at which one camera overtakes another.

use serde::Serialize;

use crate::numeric::crossing::Differences;

/// Two contenders, each leading the other at one of two luminances, between which no other shows a lead of either.
///
/// What is known is that the lead changes between the two. Where it does is an interpolation, whose error by the shape of the curves is
/// larger than that by noise and has no interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Crossover {
    /// The name of the metric.
    pub metric: &'static str,
    /// The contender that is better in less light.
    pub below: usize,
    /// The contender that is better in more light.
    pub above: usize,
    /// Where they are equal, cd/m², if the difference is linear in the logarithm of the luminance between luminances that were compared.
    pub interpolated_cd_m2: f64,
    /// The nearest luminances at which they differ, cd/m².
    pub between_cd_m2: [f64; 2],
    /// Whether each is the best of all contenders, or does not differ from the best, at the luminance where it leads.
    pub is_of_best: bool,
}

/// Of leads in order of light, positive for one contender and negative for the other, the pairs of places between which the lead
/// changes. `None` is a place without a lead.
pub(super) fn changes(leads: &[Option<f64>]) -> Vec<[usize; 2]> {
    let shown: Vec<(usize, f64)> = leads.iter().enumerate().filter_map(|(i, l)| Some((i, (*l)?))).collect();
    shown.windows(2).filter(|w| (w[0].1 > 0.0) != (w[1].1 > 0.0)).map(|w| [w[0].0, w[1].0]).collect()
}

/// The luminance at which two contenders are equal, by interpolation. `leads` are luminances in ascending order, and in each the leads
/// of the contender that is better in more light, picture by picture.
pub(super) fn equal_at(leads: impl IntoIterator<Item = (f64, Vec<f64>)>) -> f64 {
    let differences = Differences::new(leads.into_iter().map(|(cd_m2, lead)| (cd_m2.ln(), lead)));
    differences.zero().map_or(f64::NAN, f64::exp)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lead_changes_across_lights_without_one() {
        let (a, b) = (Some(1.0), Some(-1.0));
        assert_eq!(changes(&[a, b]), [[0, 1]]);
        assert_eq!(changes(&[a, None, None, b]), [[0, 3]]);
        assert_eq!(changes(&[None, a, None, a, b, None, a]), [[3, 4], [4, 6]]);
        assert!(changes(&[a, None, a]).is_empty() && changes(&[None, b]).is_empty());
    }

    /// The difference rises by 1 per factor of 10 and is 0 at 10 cd/m², in both scenes.
    #[test]
    fn the_luminance_is_interpolated_in_its_logarithm() {
        let leads = [(1.0, vec![-1.0, -1.0]), (3.0, vec![-0.523, -0.523]), (100.0, vec![1.0, 1.0])];
        let at = equal_at(leads);
        assert!((at - 10.0).abs() < 0.01, "{at}");
    }
}
