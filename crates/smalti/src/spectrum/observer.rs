//! CIE standard observers.

use rayon::prelude::*;

use super::generated::{CIE_1931_2DEG, CIE_1964_10DEG, CIE_2015_2DEG, Table};
use super::{Extrapolation, SpectralCube, Spectrum, SpectrumError, WavelengthGrid};
use crate::numeric::Planes;
use crate::spectrum::units::{EFFICACY_LM_PER_W, photons_per_joule};

/// Pixels per task: few enough to stay in the cache over all wavelengths.
const CHUNK: usize = 4096;

/// Colour matching functions to turn spectra into tristimulus values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Observer {
    /// CIE 1931 2° (ISO/CIE 11664-1).
    #[default]
    Cie1931,
    /// CIE 1964 10° (ISO/CIE 11664-1).
    Cie1964,
    /// CIE 2006/2015 2° physiological (CIE 170-2).
    Cie2015,
}

impl Observer {
    fn table(self) -> &'static Table<3> {
        match self {
            Self::Cie1931 => &CIE_1931_2DEG,
            Self::Cie1964 => &CIE_1964_10DEG,
            Self::Cie2015 => &CIE_2015_2DEG,
        }
    }

    /// x̄, ȳ, z̄ on a grid; zero outside the tabulated range.
    ///
    /// # Errors
    /// Never for a valid grid; a test checks the table.
    pub fn matching_functions(self, grid: WavelengthGrid) -> Result<[Spectrum; 3], SpectrumError> {
        let t = self.table();
        Ok([
            t.spectrum(0, grid, Extrapolation::Zero)?,
            t.spectrum(1, grid, Extrapolation::Zero)?,
            t.spectrum(2, grid, Extrapolation::Zero)?,
        ])
    }

    /// Weights whose sum with photons (s⁻¹ m⁻² sr⁻¹ nm⁻¹) gives absolute X, Y, Z, with Y in cd/m². For photon
    /// irradiance (without sr⁻¹), Y is in lux.
    ///
    /// # Errors
    /// As [`Observer::matching_functions`].
    pub fn photon_weights(self, grid: WavelengthGrid) -> Result<[Spectrum; 3], SpectrumError> {
        let scale = EFFICACY_LM_PER_W * grid.step_nm();
        let weights = |f: Spectrum| f.map(|nm, v| v * scale / photons_per_joule(nm));
        let [x, y, z] = self.matching_functions(grid)?.map(weights);
        Ok([x?, y?, z?])
    }

    /// Absolute tristimulus values of a photon radiance (Y in cd/m²) or irradiance (Y in lux).
    ///
    /// # Errors
    /// As [`Observer::matching_functions`].
    pub fn xyz_from_photons(self, photons: &Spectrum) -> Result<[f64; 3], SpectrumError> {
        let weights = self.photon_weights(photons.grid())?;
        Ok(weights.map(|w| w.values().iter().zip(photons.values()).map(|(a, b)| a * b).sum()))
    }

    /// X, Y, Z of a photon spectrum, normalised to Y = 1. NaN where the luminance is zero.
    ///
    /// # Errors
    /// As [`Observer::matching_functions`].
    pub fn white(self, photons: &Spectrum) -> Result<[f64; 3], SpectrumError> {
        let white = self.xyz_from_photons(photons)?;
        Ok(white.map(|v| v / white[1]))
    }

    /// Three planes X, Y, Z of a spectral image of photons, absolute as in [`Observer::xyz_from_photons`].
    ///
    /// # Errors
    /// As [`Observer::matching_functions`].
    pub fn xyz_planes_from_photons(self, cube: &SpectralCube) -> Result<Planes, SpectrumError> {
        let weights = self.photon_weights(cube.grid())?;
        let mut out = Planes::zeros(cube.rows(), cube.cols(), 3);
        let n = out.plane_len();
        out.data_mut().par_chunks_mut(n).zip(&weights).for_each(|(sum, w)| add_weighted(cube, w, sum));
        Ok(out)
    }

    /// The plane Y of [`Observer::xyz_planes_from_photons`].
    ///
    /// # Errors
    /// As [`Observer::matching_functions`].
    pub fn luminance_from_photons(self, cube: &SpectralCube) -> Result<Vec<f32>, SpectrumError> {
        let mut out = vec![0.0; cube.planes().plane_len()];
        add_weighted(cube, &self.photon_weights(cube.grid())?[1], &mut out);
        Ok(out)
    }
}

/// Adds the planes of a cube, each times its weight.
fn add_weighted(cube: &SpectralCube, weights: &Spectrum, sum: &mut [f32]) {
    sum.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, sum)| {
        for (plane, &k) in cube.planes().planes().zip(weights.values()) {
            // Photon counts near 1e16 times weights near 1e-14 stay within the range of f32.
            let k = k as f32;
            for (s, &v) in sum.iter_mut().zip(&plane[chunk * CHUNK..]) {
                *s += k * v;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Observer; 3] = [Observer::Cie1931, Observer::Cie1964, Observer::Cie2015];

    fn one_nm() -> WavelengthGrid {
        WavelengthGrid::new(360.0, 1.0, 471).unwrap()
    }

    /// Equal energy is white within 3e-4, the residual of the published tables (1931: 106.865, 106.857,
    /// 106.892).
    #[test]
    fn equal_energy_is_white() {
        for observer in ALL {
            let [x, y, z] = observer.matching_functions(one_nm()).unwrap().map(|f| f.integral());
            assert!((x / y - 1.0).abs() < 4e-4 && (z / y - 1.0).abs() < 4e-4, "{observer:?}: {x} {y} {z}");
        }
    }

    /// Printed values of CIE 15:2004, tables T.4 and T.5; for 2015 the Stockman-Sharpe cone fundamentals through the
    /// matrix of CIE 170-2:2015 (1.94735469 −1.41445123 0.36476327; 0.68990272 0.34832189 0; 0 0 1.93485343).
    #[test]
    fn tabulated_values() {
        for (observer, nm, expected) in [
            (Observer::Cie1931, 555.0, [0.512050, 1.000000, 0.005750]),
            (Observer::Cie1931, 445.0, [0.34806, 0.0298, 1.78260]),
            (Observer::Cie1931, 600.0, [1.0622, 0.6310, 0.0008]),
            (Observer::Cie1964, 555.0, [0.616053, 0.999110, 0.001091]),
            (Observer::Cie1964, 600.0, [1.123990, 0.658341, 0.0]),
            (Observer::Cie2015, 450.0, [0.3224636, 0.0647235, 1.8485454]),
            (Observer::Cie2015, 555.0, [0.5280234, 0.9994606, 0.0023272]),
        ] {
            let functions = observer.matching_functions(one_nm()).unwrap();
            for (f, expected) in functions.iter().zip(expected) {
                let got = f.at(nm).unwrap();
                assert!(
                    (got - expected).abs() < 6e-7 + 1e-4 * expected,
                    "{observer:?} {nm}: {got}, not {expected}"
                );
            }
        }
    }

    #[test]
    fn a_watt_at_555_nm_is_683_lumen() {
        let grid = WavelengthGrid::new(555.0, 1.0, 1).unwrap();
        let photons = Spectrum::constant(grid, photons_per_joule(555.0)).unwrap();
        let [_, y, _] = Observer::Cie1931.xyz_from_photons(&photons).unwrap();
        assert!((y - EFFICACY_LM_PER_W).abs() < 1e-9, "{y}");
    }

    #[test]
    fn planes_hold_the_values_of_each_pixel() {
        let grid = WavelengthGrid::VISIBLE;
        let data: Vec<f32> = (0..31 * 6).map(|i| 1e15 * (1 + i % 7) as f32).collect();
        let cube = super::super::SpectralCube::new(grid, Planes::new(2, 3, 31, data).unwrap()).unwrap();
        for observer in ALL {
            let planes = observer.xyz_planes_from_photons(&cube).unwrap();
            for at in 0..6 {
                let pixel = cube.pixel(at / 3, at % 3).unwrap();
                let expected = observer.xyz_from_photons(&pixel).unwrap();
                for (c, e) in expected.into_iter().enumerate() {
                    // Sums of 31 single-precision products.
                    assert!((f64::from(planes.plane(c).unwrap()[at]) / e - 1.0).abs() < 1e-5);
                }
            }
        }
    }
}
