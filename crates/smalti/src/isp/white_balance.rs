//! White balance.

use serde::{Deserialize, Serialize};

use super::ColorMatrix;
use crate::color::ImageError;
use crate::color::adaptation::bradford;
use crate::color::display::D65_XYZ;
use crate::color::matrix::{Matrix3, apply};

/// The white balance of a picture.
///
/// Without one, X, Y, Z are linear in the raw samples, as for scores of colour. [`WhiteBalance::Illuminant`] adapts the white of
/// the camera to D65 (Bradford) and keeps its Y. [`WhiteBalance::GrayWorld`] first scales the channels so that the mean of the
/// picture has the chromaticity of the white of the colour matrix and keeps its Y.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum WhiteBalance {
    /// None: colours as they are under the scene's light.
    None,
    /// The mean of the picture is made grey.
    GrayWorld,
    /// The scene's illuminant is made white.
    #[default]
    Illuminant,
}

/// The matrix from camera channels to X, Y, Z of the picture, one row for each of X, Y, Z. `means` are the channels averaged
/// over the picture.
///
/// # Errors
/// [`ImageError::White`] when the camera's white cannot be adapted.
pub(super) fn output_matrix(
    colors: &ColorMatrix,
    balance: WhiteBalance,
    means: &[f64],
) -> Result<Vec<[f64; 3]>, ImageError> {
    let columns = colors.xyz_from_camera();
    // White is the X, Y, Z that the matrix gives for the camera's white. A fitted matrix reproduces the illuminant only
    // approximately, and even a slight tint of white is visible.
    let adaptation = || adaptation_to_d65(colors.xyz(colors.camera_white()));
    Ok(match balance {
        WhiteBalance::None => columns.to_vec(),
        WhiteBalance::Illuminant => {
            let adaptation = adaptation()?;
            columns.iter().map(|c| apply(&adaptation, *c)).collect()
        }
        WhiteBalance::GrayWorld => {
            let (adaptation, gains) = (adaptation()?, gray_world_gains(colors, means));
            columns.iter().zip(gains).map(|(c, g)| apply(&adaptation, *c).map(|v| v * g)).collect()
        }
    })
}

/// Factors that make the means proportional to the camera's white and keep Y of the mean. They are 1 for a dark picture, and for
/// a channel without response to white or to the picture.
fn gray_world_gains(colors: &ColorMatrix, means: &[f64]) -> Vec<f64> {
    let white = colors.camera_white();
    let level = colors.xyz(means)[1] / colors.xyz(white)[1];
    if !(level.is_finite() && level > 0.0) {
        return vec![1.0; white.len()];
    }
    let gain = |(&w, &m): (&f64, &f64)| if w > 0.0 && m > 0.0 { level * w / m } else { 1.0 };
    white.iter().zip(means).map(gain).collect()
}

/// Bradford adaptation of a white to D65 of the same Y.
fn adaptation_to_d65(white: [f64; 3]) -> Result<Matrix3, ImageError> {
    let white = white.map(|v| v / white[1]);
    bradford(D65_XYZ, white).ok_or(ImageError::White(white))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::matrix::{IDENTITY, apply};

    fn colors(white: [f64; 3]) -> ColorMatrix {
        ColorMatrix::new(IDENTITY.to_vec(), white.to_vec(), [1.0; 3]).unwrap()
    }

    #[test]
    fn white_comes_out_as_d65() {
        let white = [1.0985, 1.0, 0.3558];
        let columns = output_matrix(&colors(white), WhiteBalance::Illuminant, &[]).unwrap();
        let [r, g, b] = [columns[0], columns[1], columns[2]];
        let xyz_from_camera = [0, 1, 2].map(|i| [r[i], g[i], b[i]]);
        let shown = apply(&xyz_from_camera, white);
        assert!(shown.iter().zip(D65_XYZ).all(|(s, d)| (s - d).abs() < 1e-12), "{shown:?}");
    }

    /// A violet outside the spectral locus has a negative cone response.
    #[test]
    fn a_white_that_cannot_be_adapted_is_an_error() {
        let colors = colors([0.1, 0.01, 20.0]);
        for balance in [WhiteBalance::Illuminant, WhiteBalance::GrayWorld] {
            let got = output_matrix(&colors, balance, &[1.0; 3]);
            assert!(matches!(got, Err(ImageError::White(_))), "{balance:?}: {got:?}");
        }
        assert_eq!(output_matrix(&colors, WhiteBalance::None, &[]).unwrap(), IDENTITY.to_vec());
    }
}
