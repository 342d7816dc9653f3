//! Dynamic range of a sensor: the ratio of saturation to the signal whose signal-to-noise ratio is 1.

use super::MetricError;
use super::error::not_negative;
use super::snr::decibels;

/// The range between saturation and the signal whose signal-to-noise ratio is 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DynamicRange {
    /// Signal at saturation, electrons.
    pub saturation_e: f64,
    /// Signal with a signal-to-noise ratio of 1, electrons.
    pub minimum_e: f64,
    /// `20 · log10(saturation / minimum)`.
    pub db: f64,
    /// `log2(saturation / minimum)`.
    pub stops: f64,
}

/// Dynamic range as EMVA 1288 defines it (release 4, section 2.6): the smallest signal is that at which
/// signal and total temporal noise are equal, µ² = µ + σ² with σ² = σ_dark² + q² / 12, so
/// µ = ½ + √(¼ + σ²).
///
/// `saturation_e` is the saturation capacity, `dark_noise_e` the temporal noise in the dark (read noise and shot
/// noise of the dark current), `step_e` one step of the converter in electrons, 0 when there is none.
///
/// # Errors
/// When a value is negative or not finite, or saturation is not above the smallest signal.
pub fn dynamic_range(saturation_e: f64, dark_noise_e: f64, step_e: f64) -> Result<DynamicRange, MetricError> {
    not_negative("saturation_e", saturation_e)?;
    not_negative("dark_noise_e", dark_noise_e)?;
    not_negative("step_e", step_e)?;
    let noise_squared = dark_noise_e * dark_noise_e + step_e * step_e / 12.0;
    let minimum_e = 0.5 + (0.25 + noise_squared).sqrt();
    if saturation_e <= minimum_e {
        let reason = "saturation lies below the smallest signal that stands out of the noise";
        return Err(MetricError::Undefined { quantity: "dynamic range", reason });
    }
    let stops = (saturation_e / minimum_e).log2();
    Ok(DynamicRange { saturation_e, minimum_e, db: decibels(saturation_e, minimum_e), stops })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_signal_equals_its_noise() {
        let r = dynamic_range(10_000.0, 10.0, 4.0).unwrap();
        let noise = (r.minimum_e + 100.0 + 16.0 / 12.0).sqrt();
        assert!((r.minimum_e - noise).abs() < 1e-12);
        assert!((r.db / r.stops - 20.0 * 2f64.log10()).abs() < 1e-12);
        // Without noise the smallest signal is one electron.
        assert_eq!(dynamic_range(1024.0, 0.0, 0.0).unwrap().stops, 10.0);
    }

    #[test]
    fn impossible_sensors_are_refused() {
        assert!(matches!(dynamic_range(-1.0, 1.0, 0.0), Err(MetricError::Parameter { .. })));
        assert!(matches!(dynamic_range(1.0, f64::NAN, 0.0), Err(MetricError::Parameter { .. })));
        assert!(matches!(dynamic_range(5.0, 10.0, 0.0), Err(MetricError::Undefined { .. })));
    }
}
