//! What is done about the colour of the light.

use super::ColorMatrix;

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
    /// The colour matrix's white comes out as D65 by Bradford adaptation, its Y kept.
    #[default]
    Illuminant,
}

/// D65 as IEC 61966-2-1 and SMPTE EG 432-1 have it, x = 0.3127, y = 0.3290.
const D65_WHITE: [f64; 3] = [0.3127 / 0.3290, 1.0, (1.0 - 0.3127 - 0.3290) / 0.3290];

/// Cone-like responses from X, Y, Z: Lam 1985, as in ICC.1:2022 annex E.
const BRADFORD: [[f64; 3]; 3] =
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

type Matrix3 = [[f64; 3]; 3];

/// The X, Y, Z of a camera's channels as the picture shall show them, rows X, Y, Z by channels.
/// `means` are the channels averaged over the picture.
pub(super) fn output_matrix(colors: &ColorMatrix, balance: WhiteBalance, means: &[f64]) -> Vec<[f64; 3]> {
    let columns = colors.xyz_from_camera();
    let adaptation = adaptation_to_d65(colors.xyz_white());
    match balance {
        WhiteBalance::None => columns.to_vec(),
        WhiteBalance::Illuminant => columns.iter().map(|c| product(&adaptation, c)).collect(),
        WhiteBalance::GrayWorld => {
            let gains = gray_world_gains(colors, means);
            columns.iter().zip(gains).map(|(c, g)| product(&adaptation, c).map(|v| v * g)).collect()
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
    let from = product(&BRADFORD, &white.map(|v| v / white[1]));
    let to = product(&BRADFORD, &D65_WHITE);
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    if !from.iter().all(|v| v.is_finite() && *v > 0.0) {
        return identity;
    }
    let mut scaled = BRADFORD;
    for (i, row) in scaled.iter_mut().enumerate() {
        *row = row.map(|v| v * to[i] / from[i]);
    }
    let back = inverse(&BRADFORD);
    let column = |j: usize| product(&back, &[scaled[0][j], scaled[1][j], scaled[2][j]]);
    let columns = [column(0), column(1), column(2)];
    [0, 1, 2].map(|i| [columns[0][i], columns[1][i], columns[2][i]])
}

fn product(m: &Matrix3, v: &[f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// By cofactors; the matrix is not singular.
fn inverse(m: &Matrix3) -> Matrix3 {
    let cofactor = |i: usize, j: usize| {
        let (r, s, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[r][c] * m[s][d] - m[r][d] * m[s][c]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum();
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| cofactor(j, i) / determinant))
}
