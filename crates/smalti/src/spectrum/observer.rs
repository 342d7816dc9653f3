//! CIE standard observers.

use super::generated::{CIE_1931_2DEG, CIE_1964_10DEG, CIE_2015_2DEG, Table};
use super::{Outside, Spectrum, SpectrumError, WavelengthGrid};
use crate::numeric::Planes;
use crate::spectrum::units::{EFFICACY_LM_PER_W, photons_per_joule};

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
    /// Never for a valid grid; the table itself is checked by a test.
    pub fn matching_functions(self, grid: WavelengthGrid) -> Result<[Spectrum; 3], SpectrumError> {
        let t = self.table();
        Ok([
            t.spectrum(0, grid, Outside::Zero)?,
            t.spectrum(1, grid, Outside::Zero)?,
            t.spectrum(2, grid, Outside::Zero)?,
        ])
    }

    /// Weights that turn photons (s⁻¹ m⁻² sr⁻¹ nm⁻¹) into absolute X, Y, Z by a plain sum; Y in cd/m².
    /// From photon irradiance (no sr⁻¹) Y comes out in lux.
    ///
    /// # Errors
    /// As [`Observer::matching_functions`].
    pub fn photon_weights(self, grid: WavelengthGrid) -> Result<[Spectrum; 3], SpectrumError> {
        let scale = EFFICACY_LM_PER_W * grid.step_nm();
        Ok(self.matching_functions(grid)?.map(|f| f.map(|nm, v| v * scale / photons_per_joule(nm))))
    }

    /// Absolute tristimulus values of a photon radiance (Y in cd/m²) or irradiance (Y in lux).
    ///
    /// # Errors
    /// As [`Observer::matching_functions`].
    pub fn xyz_from_photons(self, photons: &Spectrum) -> Result<[f64; 3], SpectrumError> {
        let weights = self.photon_weights(photons.grid())?;
        Ok(weights.map(|w| w.values().iter().zip(photons.values()).map(|(a, b)| a * b).sum()))
    }

    /// Three planes X, Y, Z of a spectral image of photons, absolute as in [`Observer::xyz_from_photons`].
    ///
    /// # Errors
    /// As [`Observer::matching_functions`].
    pub fn xyz_planes_from_photons(self, cube: &super::SpectralCube) -> Result<Planes, SpectrumError> {
        let weights = self.photon_weights(cube.grid())?;
        let mut out = Planes::zeros(cube.rows(), cube.cols(), 3);
        for (c, w) in weights.iter().enumerate() {
            let sum = out.plane_mut(c);
            for (plane, &k) in cube.planes().planes().zip(w.values()) {
                // Photon counts near 1e16 times weights near 1e-14: within f32 at every step.
                let k = k as f32;
                for (s, &v) in sum.iter_mut().zip(plane) {
                    *s += k * v;
                }
            }
        }
        Ok(out)
    }
}
