//! Colour accuracy on a chart: ΔE 1976, 1994 and 2000 per patch.

use super::MetricError;
use crate::color::{DeltaE, lab_from_xyz};

/// The white that CIELAB refers to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LabWhite {
    /// The white patch of the reference, for both: a cast of the measured white counts as an error.
    #[default]
    Reference,
    /// Each its own white patch: a cast of the whole picture does not count.
    Own,
}

/// A colour difference over the patches.
#[derive(Debug, Clone, PartialEq)]
pub struct PatchDifferences {
    /// Per patch, in the order given.
    pub per_patch: Vec<f64>,
    /// Their mean.
    pub mean: f64,
    /// The largest.
    pub max: f64,
}

/// Colour differences between measured and reference patches.
#[derive(Debug, Clone, PartialEq)]
pub struct ColorAccuracy {
    /// CIE 1976, the distance in CIELAB.
    pub delta_e_76: PatchDifferences,
    /// CIE 1994, graphic arts weights, the reference as the standard.
    pub delta_e_94: PatchDifferences,
    /// CIEDE2000.
    pub delta_e_2000: PatchDifferences,
    /// CIELAB of the measured patches.
    pub measured_lab: Vec<[f64; 3]>,
    /// CIELAB of the reference patches.
    pub reference_lab: Vec<[f64; 3]>,
}

/// Compares the XYZ of patches with those of a reference, both first scaled so that the white patch (index
/// `white_patch`; 3 on the Macbeth chart read column by column, 18 row by row) has Y = 100: exposure does not count.
///
/// # Errors
/// When the numbers of patches differ, the white patch is not there, a value is not finite, or the Y (or another
/// component) of a white patch is not above 0.
pub fn color_accuracy(
    measured_xyz: &[[f64; 3]],
    reference_xyz: &[[f64; 3]],
    white_patch: usize,
    lab_white: LabWhite,
) -> Result<ColorAccuracy, MetricError> {
    if measured_xyz.len() != reference_xyz.len() {
        let (expected, got) = (reference_xyz.len(), measured_xyz.len());
        return Err(MetricError::Count { what: "measured patches", expected, got });
    }
    let (measured, measured_white) = scaled("the measured patches", measured_xyz, white_patch)?;
    let (reference, reference_white) = scaled("the reference patches", reference_xyz, white_patch)?;
    let lab = |patches: &[[f64; 3]], white| patches.iter().map(|&p| lab_from_xyz(p, white)).collect();
    let measured_lab: Vec<_> = match lab_white {
        LabWhite::Reference => lab(&measured, reference_white),
        LabWhite::Own => lab(&measured, measured_white),
    };
    let reference_lab: Vec<_> = lab(&reference, reference_white);
    let differences = |formula: DeltaE| {
        let pairs = reference_lab.iter().zip(&measured_lab);
        let per_patch: Vec<f64> = pairs.map(|(&r, &m)| formula.between(r, m)).collect();
        let mean = per_patch.iter().sum::<f64>() / per_patch.len() as f64;
        let max = per_patch.iter().copied().fold(0.0, f64::max);
        PatchDifferences { per_patch, mean, max }
    };
    Ok(ColorAccuracy {
        delta_e_76: differences(DeltaE::Cie1976),
        delta_e_94: differences(DeltaE::Cie1994),
        delta_e_2000: differences(DeltaE::Ciede2000),
        measured_lab,
        reference_lab,
    })
}

/// The patches with Y of the white patch at 100, and the white patch among them.
fn scaled(
    what: &'static str,
    patches: &[[f64; 3]],
    white_patch: usize,
) -> Result<(Vec<[f64; 3]>, [f64; 3]), MetricError> {
    if let Some(index) = patches.iter().flatten().position(|v| !v.is_finite()) {
        return Err(MetricError::NotFinite { what, index });
    }
    let Some(&white) = patches.get(white_patch) else {
        return Err(MetricError::TooFew { what, minimum: white_patch.saturating_add(1), got: patches.len() });
    };
    if white.iter().any(|&v| v <= 0.0) {
        let reason = "X, Y and Z of the white patch must be above 0";
        return Err(MetricError::Undefined { quantity: "CIELAB", reason });
    }
    let scale = |p: [f64; 3]| p.map(|v| 100.0 * v / white[1]);
    Ok((patches.iter().map(|&p| scale(p)).collect(), scale(white)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHART: [[f64; 3]; 3] = [[20.0, 15.0, 5.0], [90.0, 95.0, 100.0], [10.0, 12.0, 30.0]];

    #[test]
    fn exposure_does_not_count() {
        let brighter = CHART.map(|p| p.map(|v| 3.0 * v));
        let r = color_accuracy(&brighter, &CHART, 1, LabWhite::Reference).unwrap();
        assert!(r.delta_e_2000.max < 1e-9 && r.delta_e_76.max < 1e-9 && r.delta_e_94.max < 1e-9);
        assert!((r.reference_lab[1][0] - 100.0).abs() < 1e-9);
    }

    #[test]
    fn a_cast_counts_against_the_reference_white_alone() {
        let cast = CHART.map(|[x, y, z]| [1.1 * x, y, 0.9 * z]);
        assert!(color_accuracy(&cast, &CHART, 1, LabWhite::Own).unwrap().delta_e_76.max < 1e-9);
        let r = color_accuracy(&cast, &CHART, 1, LabWhite::Reference).unwrap();
        assert!(r.delta_e_76.per_patch[1] > 5.0);
        assert!(r.delta_e_76.mean <= r.delta_e_76.max);
    }

    #[test]
    fn what_cannot_be_compared_is_refused() {
        let run = |m: &[[f64; 3]], white| color_accuracy(m, &CHART, white, LabWhite::Own).unwrap_err();
        assert!(matches!(run(&CHART[..2], 1), MetricError::Count { .. }));
        assert!(matches!(run(&CHART, 3), MetricError::TooFew { minimum: 4, .. }));
        assert!(matches!(run(&[[0.0; 3]; 3], 1), MetricError::Undefined { .. }));
        assert!(matches!(run(&[[f64::NAN; 3]; 3], 1), MetricError::NotFinite { .. }));
        assert!(matches!(color_accuracy(&[], &[], 0, LabWhite::Own), Err(MetricError::TooFew { .. })));
    }
}
