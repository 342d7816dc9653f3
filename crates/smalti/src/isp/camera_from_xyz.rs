//! The matrix from XYZ to camera values for raw files (`ColorMatrix1` of DNG 1.7).

use super::IspError;
use crate::numeric::least_squares::{Matrix, lstsq};
use crate::spectrum::{Observer, Spectrum};

/// Camera values from XYZ under an illuminant (photons), one row per channel: the least-squares fit over the given reflectances.
///
/// `responsivities` are those of the channels, including the lens. A perfect white diffuser has Y = 1 and the value 1 in its
/// brightest channel.
///
/// # Errors
/// When wavelength grids differ or the solver fails.
pub fn camera_from_xyz(
    responsivities: &[Spectrum],
    surfaces: &[Spectrum],
    light: &Spectrum,
    observer: Observer,
) -> Result<Vec<[f64; 3]>, IspError> {
    let observer = observer.photon_weights(light.grid())?;
    let white = |s: &Spectrum| Ok::<f64, IspError>(s.times(light)?.integral());
    let camera_white = responsivities.iter().map(white).collect::<Result<Vec<_>, _>>()?;
    let camera_scale = camera_white.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let observer_scale = white(&observer[1])?;
    let (mut xyz, mut camera) = (Vec::new(), Vec::new());
    for surface in surfaces {
        let lit = surface.times(light)?;
        for (list, curves, scale) in
            [(&mut xyz, &observer[..], observer_scale), (&mut camera, responsivities, camera_scale)]
        {
            for curve in curves {
                list.push(curve.times(&lit)?.integral() / scale);
            }
        }
    }
    let (rows, channels) = (surfaces.len(), responsivities.len());
    let solved = lstsq(Matrix::new(rows, 3, &xyz), Matrix::new(rows, channels, &camera))?;
    let columns: Vec<&[f64]> = solved.chunks_exact(channels.max(1)).collect();
    Ok((0..channels).map(|c| std::array::from_fn(|row| columns[row][c])).collect())
}
