//! Colour accuracy on a chart: ΔE 1976, 1994 and 2000 per patch.

use super::MetricError;
use super::error::finite;
use crate::color::{DeltaE, lab_from_xyz};

/// The white that CIELAB refers to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LabWhite {
    /// The white patch of the reference for both: a colour cast counts as an error.
    #[default]
    Reference,
    /// The own white patch of each: an overall colour cast does not count.
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

/// Compares X, Y, Z of patches with those of a reference. Both are scaled so that the white patch (index `white_patch`; 18 on the
/// Macbeth chart in row order, 3 in column order) has Y = 100, so that exposure does not count.
///
/// # Errors
/// When the numbers of patches differ, the white patch does not exist, a value is not finite, or X, Y or Z of a white patch is
/// not above 0.
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
    finite(what, patches.iter().flatten().copied())?;
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

    /// Four patches of a case of ISETCam (true display model), in its order: the first column of the
    /// chart, white last. Its CIE 1994 takes the measured colour for the standard and is left out.
    #[test]
    fn isetcam_scores_alike() {
        let reference = [
            [14.559363638404493, 12.80967814876669, 7.72241697263944],
            [45.268065052940045, 36.903060446110935, 7.501173892707602],
            [10.49101522724143, 8.32095446318704, 33.288980253726166],
            [95.60563350083007, 100.0, 97.91107939625356],
        ];
        let measured = [
            [14.944634698804155, 13.076617798099655, 8.020924710085842],
            [45.02628066145714, 36.7880233078866, 7.493890556407223],
            [9.84892995579425, 8.151865193286408, 31.98512570448407],
            [95.2315303782242, 100.0, 97.38658843859672],
        ];
        let r = color_accuracy(&measured, &reference, 3, LabWhite::Reference).unwrap();
        let check = |got: &PatchDifferences, expected: [f64; 4]| {
            for (g, e) in got.per_patch.iter().zip(expected) {
                assert!((g - e).abs() < 1e-6, "{g}, expected {e}");
            }
        };
        check(&r.delta_e_76, [0.8212436778867107, 0.35497208516444323, 3.731077170760853, 0.744595492986193]);
        check(
            &r.delta_e_2000,
            [0.731423565915419, 0.1709686578101885, 1.834276705562981, 1.0189065019062236],
        );
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
