//! Tristimulus values from camera channels by least squares over a set of reflectances.

use super::IspError;
use crate::numeric::least_squares::{Matrix, lstsq, lstsq_constrained};
use crate::spectrum::{Observer, Spectrum, SpectrumError};

/// A channel that sees white this much fainter than the brightest one takes no part in colour: when that one is full,
/// at ten thousand electrons or so, the faint one holds ten, which is noise. An infrared pixel behind an infrared-cut
/// filter, or on wavelengths that end before its band, is such a one; least squares would amplify its noise thousandfold.
const BLIND: f64 = 1e-3;

/// What a colour matrix must hold exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum ColorConstraint {
    /// Nothing: the smallest error over the reflectances.
    #[default]
    None,
    /// The illuminant's white comes out as it is (Finlayson and Drew 1997), so greys carry no cast.
    PreserveWhite,
}

/// A linear map from `N` camera channels to CIE X, Y, Z under one illuminant.
///
/// Scale: camera values are such that a perfect white diffuser puts the channel that sees it brightest at 1, and its
/// Y is 1. For a picture that is exposed less, both are less by the same factor; so, applied to channels that are 1
/// at saturation, Y = 1 is the brightest white the sensor can hold.
#[derive(Debug, Clone, PartialEq)]
pub struct ColorMatrix {
    xyz_from_camera: Vec<[f64; 3]>,
    camera_white: Vec<f64>,
    xyz_white: [f64; 3],
}

impl ColorMatrix {
    /// A matrix that is known: per channel its part in X, Y, Z; what the channels and X, Y, Z are for white.
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
            return Err(IspError::Empty { what: "camera channels" });
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

    /// Per channel, its part in X, Y, Z: the columns of the 3 × N matrix.
    #[must_use]
    pub fn xyz_from_camera(&self) -> &[[f64; 3]] {
        &self.xyz_from_camera
    }

    /// The channels for a perfect white diffuser, the largest 1 where [`color_matrix`] made it.
    #[must_use]
    pub fn camera_white(&self) -> &[f64] {
        &self.camera_white
    }

    /// X, Y, Z of a perfect white diffuser under the illuminant, Y = 1 where [`color_matrix`] made it.
    #[must_use]
    pub fn xyz_white(&self) -> [f64; 3] {
        self.xyz_white
    }

    /// X, Y, Z of one set of channels. Channels beyond those of the matrix are left out.
    #[must_use]
    pub fn xyz(&self, camera: &[f64]) -> [f64; 3] {
        let mut xyz = [0.0; 3];
        for (column, v) in self.xyz_from_camera.iter().zip(camera) {
            (0..3).for_each(|i| xyz[i] += column[i] * v);
        }
        xyz
    }
}

/// What colour matrices are fitted to: the reflectances of surfaces under an illuminant, and X, Y, Z of them. The same for
/// every camera.
#[derive(Debug, Clone)]
pub struct ColorFit {
    light: Spectrum,
    /// One per surface.
    reflectances: Vec<Spectrum>,
    /// X, Y, Z per surface, 1 for Y of white.
    xyz: Vec<f64>,
    xyz_white: [f64; 3],
}

impl ColorFit {
    /// Surfaces under an illuminant, in photons per nm, in any unit, as an observer sees them.
    ///
    /// # Errors
    /// When there is no reflectance, grids differ, or the illuminant is dark to the observer.
    pub fn new(
        reflectances: &[Spectrum],
        illuminant_photons: &Spectrum,
        observer: Observer,
    ) -> Result<Self, IspError> {
        if reflectances.is_empty() {
            return Err(IspError::Empty { what: "reflectances" });
        }
        let eye = under(illuminant_photons, &observer.photon_weights(illuminant_photons.grid())?)?;
        let white: Vec<f64> = eye.iter().map(Spectrum::integral).collect();
        let [x, y, z] = white[..] else { return Err(IspError::NoResponse { what: "the observer" }) };
        if y <= 0.0 {
            return Err(IspError::NoResponse { what: "the observer" });
        }
        Ok(Self {
            light: illuminant_photons.clone(),
            reflectances: reflectances.to_vec(),
            xyz: responses(reflectances, &eye, y)?,
            xyz_white: [x / y, 1.0, z / y],
        })
    }

    /// The matrix that makes the smallest squared error of X, Y, Z over the surfaces.
    ///
    /// `responsivities` are those of the channels per photon (filter times lens times quantum efficiency; a factor common
    /// to all does not matter), on the grid of the illuminant.
    ///
    /// Any number of channels will do. Where there are more than the reflectances can tell apart (their spectra have some
    /// six to eight degrees of freedom), or channels are mixtures of others, the matrix of smallest norm is taken, which
    /// amplifies noise least. A channel that is all but blind under the illuminant (below a thousandth of the brightest
    /// one's white) gets no part.
    ///
    /// `noise` is the standard deviation of independent noise that every channel is taken to carry, relative to the
    /// brightest white; the error that is minimised then includes what the matrix makes of it (ridge regression). 0 is
    /// plain least squares. Channels that are nearly sums of others, such as white beside red, green and blue, would
    /// otherwise be subtracted from one another with large factors, for a gain in colour that no eye sees and a loss by
    /// noise that every eye does.
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
            return Err(IspError::Empty { what: "camera channels" });
        }
        let camera = under(&self.light, responsivities)?;
        let camera_white: Vec<f64> = camera.iter().map(Spectrum::integral).collect();
        let brightest = camera_white.iter().copied().fold(0.0, f64::max);
        if brightest <= 0.0 {
            return Err(IspError::NoResponse { what: "the camera" });
        }
        let sees = |(c, &white): (Spectrum, &f64)| if white < BLIND * brightest { c.scaled(0.0) } else { c };
        let seeing: Vec<Spectrum> = camera.into_iter().zip(&camera_white).map(sees).collect();
        let (channels, samples) = (responsivities.len(), self.reflectances.len());
        let (mut a, mut b) = (responses(&self.reflectances, &seeing, brightest)?, self.xyz.clone());
        // Noise adds its variance, once per sample, to the diagonal of the normal equations: one more row per channel.
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

/// Curves times a light.
fn under(light: &Spectrum, curves: &[Spectrum]) -> Result<Vec<Spectrum>, IspError> {
    curves.iter().map(|s| Ok(s.times(light)?)).collect()
}

/// What each curve sees of each reflectance, over `scale`: a row per reflectance.
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

/// The colour matrix over `reflectances` under an illuminant, once: see [`ColorFit::new`] and [`ColorFit::matrix`].
///
/// # Errors
/// As these.
pub fn color_matrix(
    responsivities: &[Spectrum],
    reflectances: &[Spectrum],
    illuminant_photons: &Spectrum,
    observer: Observer,
    constraint: ColorConstraint,
    noise: f64,
) -> Result<ColorMatrix, IspError> {
    ColorFit::new(reflectances, illuminant_photons, observer)?.matrix(responsivities, constraint, noise)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::generated::COLORCHECKER;
    use crate::spectrum::{Illuminant, Outside, WavelengthGrid};
    use approx::assert_abs_diff_eq;

    const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

    fn gaussian(center_nm: f64, sigma_nm: f64) -> Spectrum {
        Spectrum::from_fn(GRID, |nm| (-0.5 * ((nm - center_nm) / sigma_nm).powi(2)).exp())
    }

    fn chart() -> Vec<Spectrum> {
        (0..24).map(|i| COLORCHECKER.spectrum(i, GRID, Outside::Error).unwrap()).collect()
    }

    fn matrix(channels: &[Spectrum], constraint: ColorConstraint) -> ColorMatrix {
        let light = Illuminant::D65.photons(GRID).unwrap();
        color_matrix(channels, &chart(), &light, Observer::Cie1931, constraint, 0.0).unwrap()
    }

    /// A camera that meets the Luther condition sees as the observer does: the fit is exact.
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

    /// An infrared channel on visible wavelengths: its trace of red would lower the error and drown the picture in noise.
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
        let dark = [Spectrum::constant(GRID, 0.0)];
        let fit = |c: &[Spectrum], r: &[Spectrum]| {
            color_matrix(c, r, &light, Observer::Cie1931, ColorConstraint::None, 0.0)
        };
        assert!(matches!(fit(&dark, &chart()), Err(IspError::NoResponse { .. })));
        assert!(matches!(fit(&dark, &[]), Err(IspError::Empty { what: "reflectances" })));
        assert!(matches!(fit(&[], &chart()), Err(IspError::Empty { .. })));
        let other = Spectrum::constant(WavelengthGrid::new(400.0, 5.0, 61).unwrap(), 1.0);
        assert!(matches!(fit(&[other], &chart()), Err(IspError::Spectrum(_))));
    }

    /// White is nearly the sum of red, green and blue: without noise the fit subtracts them with large factors.
    #[test]
    fn noise_keeps_the_factors_small_at_hardly_any_cost_in_colour() {
        let bands = [gaussian(610.0, 40.0), gaussian(540.0, 40.0), gaussian(460.0, 40.0)];
        let sum =
            Spectrum::from_fn(GRID, |nm| bands.iter().filter_map(|b| b.at(nm)).sum::<f64>() * 0.7 + 0.01);
        let channels = [&bands[..], &[sum]].concat();
        let light = Illuminant::D65.photons(GRID).unwrap();
        let fit = |noise| {
            let none = ColorConstraint::None;
            color_matrix(&channels, &chart(), &light, Observer::Cie1931, none, noise).unwrap()
        };
        let gain = |m: &ColorMatrix| m.xyz_from_camera().iter().map(|c| c[1] * c[1]).sum::<f64>().sqrt();
        let (plain, noisy) = (fit(0.0), fit(0.01));
        assert!(gain(&noisy) < 0.5 * gain(&plain), "{} {}", gain(&noisy), gain(&plain));
        let white = noisy.xyz(noisy.camera_white());
        assert_abs_diff_eq!(white[1], 1.0, epsilon = 0.02);
    }
}
