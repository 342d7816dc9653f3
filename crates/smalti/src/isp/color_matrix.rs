//! Colour matrices: tristimulus values from camera channels by least squares over a set of reflectances.

use super::IspError;
use crate::numeric::least_squares::{Matrix, lstsq, lstsq_constrained};
use crate::spectrum::{Observer, Spectrum, SpectrumError};

/// Relative response to white below which a channel is excluded. At saturation of the brightest channel, about ten thousand
/// electrons, it would hold ten electrons, mostly noise, which least squares would amplify a thousandfold. An example is an
/// infrared pixel behind an infrared-cut filter.
pub(crate) const BLIND: f64 = 1e-3;

/// A constraint on the fit of a colour matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum ColorConstraint {
    /// No constraint: the least error over the reflectances.
    #[default]
    None,
    /// White of the illuminant is reproduced exactly (Finlayson and Drew 1997), so that greys have no colour cast.
    PreserveWhite,
}

/// A linear map from `N` camera channels to CIE X, Y, Z under one illuminant.
///
/// A perfect white diffuser has the value 1 in its brightest channel and Y = 1. Both scale with the exposure. Applied to channels
/// that are 1 at saturation, Y = 1 is therefore the brightest white that the sensor can record.
#[derive(Debug, Clone, PartialEq)]
pub struct ColorMatrix {
    xyz_from_camera: Vec<[f64; 3]>,
    camera_white: Vec<f64>,
    xyz_white: [f64; 3],
}

impl ColorMatrix {
    /// A known matrix: for each channel its contributions to X, Y, Z, and the channels and X, Y, Z of white.
    ///
    /// # Errors
    /// When the numbers of channels differ or are 0, a value is not finite, or the white is not positive.
    pub fn new(
        xyz_from_camera: Vec<[f64; 3]>,
        camera_white: Vec<f64>,
        xyz_white: [f64; 3],
    ) -> Result<Self, IspError> {
        let expected = xyz_from_camera.len();
        if expected == 0 {
            return Err(IspError::Empty("camera channels"));
        }
        if camera_white.len() != expected {
            return Err(IspError::Channels { what: "the camera's white", expected, got: camera_white.len() });
        }
        let parameter = |name, value, expected| IspError::Parameter { name, value, expected };
        if let Some(&v) = xyz_from_camera.iter().flatten().find(|v| !v.is_finite()) {
            return Err(parameter("a coefficient of the colour matrix", v, "a finite number"));
        }
        let positive = |v: &&f64| !(v.is_finite() && **v >= 0.0);
        if let Some(&v) = camera_white.iter().chain(&xyz_white).find(positive) {
            return Err(parameter("white", v, "a finite number of at least 0"));
        }
        if xyz_white[1] <= 0.0 {
            return Err(parameter("Y of white", xyz_white[1], "a positive number"));
        }
        Ok(Self { xyz_from_camera, camera_white, xyz_white })
    }

    /// The columns of the 3 × N matrix: for each channel its contributions to X, Y, Z.
    #[must_use]
    pub fn xyz_from_camera(&self) -> &[[f64; 3]] {
        &self.xyz_from_camera
    }

    /// The channels of a perfect white diffuser; [`ColorFit::matrix`] scales the largest to 1.
    #[must_use]
    pub fn camera_white(&self) -> &[f64] {
        &self.camera_white
    }

    /// X, Y, Z of a perfect white diffuser under the illuminant; [`ColorFit::matrix`] scales Y to 1.
    #[must_use]
    pub fn xyz_white(&self) -> [f64; 3] {
        self.xyz_white
    }

    /// The standard deviation of Y per that of independent noise of equal variance in every channel. Errors of interpolation are
    /// amplified similarly. It is about 1 for red, green and blue filters, and large for channels that are nearly sums of others if
    /// the matrix was fitted without noise.
    #[must_use]
    pub fn luminance_noise_gain(&self) -> f64 {
        self.xyz_from_camera.iter().map(|c| c[1] * c[1]).sum::<f64>().sqrt()
    }

    /// X, Y, Z of one set of channels. Channels beyond those of the matrix are ignored.
    #[must_use]
    pub fn xyz(&self, camera: &[f64]) -> [f64; 3] {
        let mut xyz = [0.0; 3];
        for (column, v) in self.xyz_from_camera.iter().zip(camera) {
            (0..3).for_each(|i| xyz[i] += column[i] * v);
        }
        xyz
    }
}

/// The data for fitting colour matrices: reflectances under an illuminant and their X, Y, Z. It does not depend on the camera.
#[derive(Debug, Clone)]
pub struct ColorFit {
    light: Spectrum,
    /// One per surface.
    reflectances: Vec<Spectrum>,
    /// X, Y, Z per surface, with Y = 1 for white.
    xyz: Vec<f64>,
    xyz_white: [f64; 3],
}

impl ColorFit {
    /// Reflectances under an illuminant (photons per nm, in any unit), with X, Y, Z of an observer.
    ///
    /// # Errors
    /// When there is no reflectance, grids differ, or the illuminant is dark to the observer.
    pub fn new(
        reflectances: &[Spectrum],
        illuminant_photons: &Spectrum,
        observer: Observer,
    ) -> Result<Self, IspError> {
        if reflectances.is_empty() {
            return Err(IspError::Empty("reflectances"));
        }
        let eye = under(illuminant_photons, &observer.photon_weights(illuminant_photons.grid())?)?;
        let white: Vec<f64> = eye.iter().map(Spectrum::integral).collect();
        let [x, y, z] = white[..] else { return Err(IspError::NoResponse("the observer")) };
        if y <= 0.0 {
            return Err(IspError::NoResponse("the observer"));
        }
        Ok(Self {
            light: illuminant_photons.clone(),
            reflectances: reflectances.to_vec(),
            xyz: responses(reflectances, &eye, y)?,
            xyz_white: [x / y, 1.0, z / y],
        })
    }

    /// The matrix with the least squared error of X, Y, Z over the surfaces.
    ///
    /// `responsivities` are those of the channels per photon (filter times lens times quantum efficiency, up to a common
    /// factor), on the grid of the illuminant.
    ///
    /// The number of channels is arbitrary. If the fit is underdetermined, because channels outnumber the degrees of freedom of
    /// the reflectances (about six to eight) or are mixtures of others, the matrix has the least norm, which amplifies noise
    /// least. A channel whose response to white is below a thousandth of the brightest is excluded.
    ///
    /// `noise` is the standard deviation of independent noise in every channel, relative to the brightest white. The minimised
    /// error includes the noise after the matrix (ridge regression); 0 is ordinary least squares. Without noise, channels that
    /// are nearly sums of others, such as white next to red, green and blue, would get large coefficients of opposite sign,
    /// whose gain in colour accuracy is invisible and whose noise is visible.
    ///
    /// # Errors
    /// When there is no channel, grids differ, the solver fails, the noise is negative, or the illuminant is dark to the
    /// camera.
    pub fn matrix(
        &self,
        responsivities: &[Spectrum],
        constraint: ColorConstraint,
        noise: f64,
    ) -> Result<ColorMatrix, IspError> {
        if !(noise.is_finite() && noise >= 0.0) {
            let expected = "a finite number, 0 or more";
            return Err(IspError::Parameter { name: "noise", value: noise, expected });
        }
        if responsivities.is_empty() {
            return Err(IspError::Empty("camera channels"));
        }
        let camera = under(&self.light, responsivities)?;
        let camera_white: Vec<f64> = camera.iter().map(Spectrum::integral).collect();
        let brightest = camera_white.iter().copied().fold(0.0, f64::max);
        if brightest <= 0.0 {
            return Err(IspError::NoResponse("the camera"));
        }
        let sees =
            |(c, &white): (Spectrum, &f64)| if white < BLIND * brightest { c.scaled(0.0) } else { Ok(c) };
        let seeing = camera.into_iter().zip(&camera_white).map(sees).collect::<Result<Vec<_>, _>>()?;
        let (channels, samples) = (responsivities.len(), self.reflectances.len());
        let (mut a, mut b) = (responses(&self.reflectances, &seeing, brightest)?, self.xyz.clone());
        // Noise adds its variance to the diagonal of the normal equations, that is one row per channel.
        let noise_rows = if noise > 0.0 { channels } else { 0 };
        for channel in 0..noise_rows {
            a.extend((0..channels).map(|c| if c == channel { noise * (samples as f64).sqrt() } else { 0.0 }));
            b.extend([0.0; 3]);
        }
        let rows = samples + noise_rows;
        let camera_white: Vec<f64> = camera_white.iter().map(|v| v / brightest).collect();
        let (a, b) = (Matrix::new(rows, channels, &a), Matrix::new(rows, 3, &b));
        let x = match constraint {
            ColorConstraint::None => lstsq(a, b)?,
            ColorConstraint::PreserveWhite => {
                let white = seeing.iter().map(|c| c.integral() / brightest).collect::<Vec<f64>>();
                let (white, seen) = (Matrix::new(1, channels, &white), Matrix::new(1, 3, &self.xyz_white));
                lstsq_constrained(a, b, white, seen)?
            }
        };
        let columns = x.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        ColorMatrix::new(columns, camera_white, self.xyz_white)
    }
}

/// Curves multiplied by an illuminant.
fn under(light: &Spectrum, curves: &[Spectrum]) -> Result<Vec<Spectrum>, IspError> {
    curves.iter().map(|s| Ok(s.times(light)?)).collect()
}

/// The response of each curve to each reflectance, divided by `scale`: one row per reflectance.
fn responses(reflectances: &[Spectrum], curves: &[Spectrum], scale: f64) -> Result<Vec<f64>, IspError> {
    let mut rows = Vec::with_capacity(reflectances.len() * curves.len());
    for r in reflectances {
        for s in curves {
            if r.grid() != s.grid() {
                return Err(SpectrumError::GridMismatch { left: r.grid(), right: s.grid() }.into());
            }
            let sum: f64 = r.values().iter().zip(s.values()).map(|(r, s)| r * s).sum();
            rows.push(sum * r.grid().step_nm() / scale);
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::generated::COLORCHECKER;
    use crate::spectrum::{Extrapolation, Illuminant, WavelengthGrid};
    use approx::assert_abs_diff_eq;

    const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

    fn gaussian(center_nm: f64, sigma_nm: f64) -> Spectrum {
        Spectrum::from_fn(GRID, |nm| (-0.5 * ((nm - center_nm) / sigma_nm).powi(2)).exp()).unwrap()
    }

    fn chart() -> Vec<Spectrum> {
        (0..24).map(|i| COLORCHECKER.spectrum(i, GRID, Extrapolation::Error).unwrap()).collect()
    }

    fn matrix(channels: &[Spectrum], constraint: ColorConstraint) -> ColorMatrix {
        let light = Illuminant::D65.photons(GRID).unwrap();
        let fit = ColorFit::new(&chart(), &light, Observer::Cie1931).unwrap();
        fit.matrix(channels, constraint, 0.0).unwrap()
    }

    /// The fit is exact for a camera that meets the Luther condition.
    #[test]
    fn luther_camera_is_exact() {
        let eye = Observer::Cie1931.photon_weights(GRID).unwrap();
        for constraint in [ColorConstraint::None, ColorConstraint::PreserveWhite] {
            let m = matrix(&eye, constraint);
            let back = m.xyz(m.camera_white());
            (0..3).for_each(|i| assert_abs_diff_eq!(back[i], m.xyz_white()[i], epsilon = 1e-12));
            assert_abs_diff_eq!(m.xyz_from_camera()[0][1], 0.0, epsilon = 1e-10);
        }
    }

    #[test]
    fn white_is_preserved_exactly_by_any_number_of_channels() {
        for n in 1..=31 {
            let channels: Vec<_> =
                (0..n).map(|i| gaussian(410.0 + 280.0 * i as f64 / n as f64, 25.0)).collect();
            let m = matrix(&channels, ColorConstraint::PreserveWhite);
            let back = m.xyz(m.camera_white());
            (0..3).for_each(|i| assert_abs_diff_eq!(back[i], m.xyz_white()[i], epsilon = 1e-9));
        }
    }

    #[test]
    fn a_channel_twice_shares_its_part() {
        let (r, g, b) = (gaussian(600.0, 35.0), gaussian(540.0, 40.0), gaussian(460.0, 30.0));
        let once = matrix(&[r.clone(), g.clone(), b.clone()], ColorConstraint::None);
        let twice = matrix(&[r, g.clone(), b, g], ColorConstraint::None);
        for i in 0..3 {
            assert_abs_diff_eq!(twice.xyz_from_camera()[1][i], twice.xyz_from_camera()[3][i], epsilon = 1e-9);
            assert_abs_diff_eq!(
                twice.xyz_from_camera()[1][i],
                once.xyz_from_camera()[1][i] / 2.0,
                epsilon = 1e-9
            );
        }
    }

    /// The slight red response of an infrared channel would reduce the error, but amplify noise.
    #[test]
    fn a_channel_that_is_all_but_blind_takes_no_part() {
        let (r, g, b) = (gaussian(600.0, 35.0), gaussian(540.0, 40.0), gaussian(460.0, 30.0));
        let infrared = gaussian(850.0, 35.0);
        for constraint in [ColorConstraint::None, ColorConstraint::PreserveWhite] {
            let without = matrix(&[r.clone(), g.clone(), b.clone()], constraint);
            let with = matrix(&[r.clone(), g.clone(), b.clone(), infrared.clone()], constraint);
            assert_eq!(with.xyz_from_camera()[3], [0.0; 3]);
            for (w, o) in with.xyz_from_camera().iter().zip(without.xyz_from_camera()) {
                (0..3).for_each(|i| assert_abs_diff_eq!(w[i], o[i], epsilon = 1e-9));
            }
        }
    }

    #[test]
    fn a_blind_camera_is_refused() {
        let light = Illuminant::D65.photons(GRID).unwrap();
        let dark = [Spectrum::constant(GRID, 0.0).unwrap()];
        let fit = |c: &[Spectrum], r: &[Spectrum]| {
            ColorFit::new(r, &light, Observer::Cie1931)?.matrix(c, ColorConstraint::None, 0.0)
        };
        assert!(matches!(fit(&dark, &chart()), Err(IspError::NoResponse(_))));
        assert!(matches!(fit(&dark, &[]), Err(IspError::Empty("reflectances"))));
        assert!(matches!(fit(&[], &chart()), Err(IspError::Empty(_))));
        let other = Spectrum::constant(WavelengthGrid::new(400.0, 5.0, 61).unwrap(), 1.0).unwrap();
        assert!(matches!(fit(&[other], &chart()), Err(IspError::Spectrum(_))));
    }

    /// White is nearly the sum of red, green and blue: without noise, the coefficients are large and of opposite sign.
    #[test]
    fn noise_keeps_the_factors_small_at_hardly_any_cost_in_colour() {
        let bands = [gaussian(610.0, 40.0), gaussian(540.0, 40.0), gaussian(460.0, 40.0)];
        let sum =
            Spectrum::from_fn(GRID, |nm| bands.iter().filter_map(|b| b.at(nm)).sum::<f64>() * 0.7 + 0.01)
                .unwrap();
        let channels = [&bands[..], &[sum]].concat();
        let light = Illuminant::D65.photons(GRID).unwrap();
        let fit = ColorFit::new(&chart(), &light, Observer::Cie1931).unwrap();
        let fit = |noise| fit.matrix(&channels, ColorConstraint::None, noise).unwrap();
        let gain = |m: &ColorMatrix| m.xyz_from_camera().iter().map(|c| c[1] * c[1]).sum::<f64>().sqrt();
        let (plain, noisy) = (fit(0.0), fit(0.01));
        assert!(gain(&noisy) < 0.5 * gain(&plain), "{} {}", gain(&noisy), gain(&plain));
        let white = noisy.xyz(noisy.camera_white());
        assert_abs_diff_eq!(white[1], 1.0, epsilon = 0.02);
    }
}
