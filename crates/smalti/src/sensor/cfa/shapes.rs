//! Shapes of transmittance curves, 0 to 1.

/// A Gaussian with its peak at `center_nm`.
pub(super) fn gaussian(nm: f64, center_nm: f64, sigma_nm: f64) -> f64 {
    libm::exp(-0.5 * ((nm - center_nm) / sigma_nm).powi(2))
}

/// The logistic function; it does not overflow for large arguments.
pub(super) fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-x))
}
