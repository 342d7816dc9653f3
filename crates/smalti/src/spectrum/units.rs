//! Physical constants (exact, SI 2019) and the conversion from energy to photons.

/// Planck's constant, J s.
pub const PLANCK_J_S: f64 = 6.626_070_15e-34;
/// Speed of light in vacuum, m/s.
pub const LIGHT_M_PER_S: f64 = 299_792_458.0;
/// Boltzmann's constant, J/K.
pub const BOLTZMANN_J_PER_K: f64 = 1.380_649e-23;
/// Charge of the electron, C.
pub const ELECTRON_C: f64 = 1.602_176_634e-19;
/// Luminous efficacy that scales CIE colour matching functions to luminance, lm/W (CIE 15:2018).
pub const EFFICACY_LM_PER_W: f64 = 683.0;

/// Photons per joule at a wavelength.
#[must_use]
pub fn photons_per_joule(wavelength_nm: f64) -> f64 {
    wavelength_nm * 1e-9 / (PLANCK_J_S * LIGHT_M_PER_S)
}
