//! What is done about the colour of the light.

use super::ColorMatrix;
use crate::color::Adaptation;
use crate::color::display::Primaries;
use crate::color::matrix::{IDENTITY, Matrix3, apply};

/// Which light is taken for white, and whether the picture shows it as such.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum WhiteBalance {
    /// Nothing: X, Y, Z as they are under the scene's light, linear in the raw samples. This is what colour is scored
    /// from.
    None,
    /// The mean of the picture is taken for the light. Each channel is scaled so that the mean has the proportions of
    /// the colour matrix's white, its Y kept; then as [`WhiteBalance::Illuminant`].
    GrayWorld,
    /// A white surface, as the camera sees it, comes out as D65 by Bradford adaptation, its Y kept.
    #[default]
    Illuminant,
}

/// The X, Y, Z of a camera's channels as the picture shall show them, rows X, Y, Z by channels.
/// `means` are the channels averaged over the picture.
pub(super) fn output_matrix(colors: &ColorMatrix, balance: WhiteBalance, means: &[f64]) -> Vec<[f64; 3]> {
    let columns = colors.xyz_from_camera();
    // White is what the matrix makes of the camera's white. A matrix that is fitted to surfaces misses the light itself by a
    // little, and no tint of a white wall is forgiven.
    let adaptation = adaptation_to_d65(colors.xyz(colors.camera_white()));
    match balance {
        WhiteBalance::None => columns.to_vec(),
        WhiteBalance::Illuminant => columns.iter().map(|c| apply(&adaptation, *c)).collect(),
        WhiteBalance::GrayWorld => {
            let gains = gray_world_gains(colors, means);
            columns.iter().zip(gains).map(|(c, g)| apply(&adaptation, *c).map(|v| v * g)).collect()
        }
    }
}

/// Factors that make the means proportional to the camera's white and leave Y of the mean as it is. All 1 where the
/// picture is dark; 1 for a channel that sees nothing of the white or of the picture.
fn gray_world_gains(colors: &ColorMatrix, means: &[f64]) -> Vec<f64> {
    let white = colors.camera_white();
    let level = colors.xyz(means)[1] / colors.xyz(white)[1];
    if !(level.is_finite() && level > 0.0) {
        return vec![1.0; white.len()];
    }
    let gain = |(&w, &m): (&f64, &f64)| if w > 0.0 && m > 0.0 { level * w / m } else { 1.0 };
    white.iter().zip(means).map(gain).collect()
}

/// Bradford adaptation of a white to D65 of the same Y; the identity where the white is beyond it (a cone response
/// that is not positive).
fn adaptation_to_d65(white: [f64; 3]) -> Matrix3 {
    let white = white.map(|v| v / white[1]);
    let bradford = Adaptation::Bradford;
    let seen = apply(&bradford.cone_from_xyz(), white).iter().all(|v| v.is_finite() && *v > 0.0);
    let matrix = || bradford.matrix(Primaries::SRGB.white_xyz()?, white);
    if seen { matrix().unwrap_or(IDENTITY) } else { IDENTITY }
}
