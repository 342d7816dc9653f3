//! Non-uniformity of pixels, and row and column noise.

use super::SensorError;
use crate::numeric::require;

/// Non-uniformity of a device. Everything except row noise is fixed-pattern noise: it depends on the serial
/// number of the device and on the absolute position of the pixel, and is equal in every exposure and window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NonUniformity {
    /// Standard deviation of the pixels' gain (PRNU), as a fraction: 0.01 is 1 %.
    pub prnu_fraction: f64,
    /// Standard deviation of the pixels' offset (DSNU), V before the analog gain.
    pub dsnu_v: f64,
    /// Standard deviation of an offset common to a row, new in every capture, V before the analog gain.
    pub row_noise_v: f64,
    /// Standard deviation of a fixed offset common to a column, V before the analog gain.
    pub column_noise_v: f64,
    /// Fraction of pixels without any response to light, and without dark current.
    pub dead_pixel_fraction: f64,
    /// Fraction of pixels whose dark signal is `hot_pixel_dark_voltage_v_per_s`.
    pub hot_pixel_fraction: f64,
    /// Dark signal of a hot pixel at the reference temperature, V/s.
    pub hot_pixel_dark_voltage_v_per_s: f64,
    /// Serial number: devices with different numbers have independent patterns.
    pub device_serial: u64,
}

impl Default for NonUniformity {
    /// An ideal device. Hot pixels, if there are any, have a dark signal of 1 V/s.
    fn default() -> Self {
        Self {
            prnu_fraction: 0.0,
            dsnu_v: 0.0,
            row_noise_v: 0.0,
            column_noise_v: 0.0,
            dead_pixel_fraction: 0.0,
            hot_pixel_fraction: 0.0,
            hot_pixel_dark_voltage_v_per_s: 1.0,
            device_serial: 0,
        }
    }
}

impl NonUniformity {
    /// Whether pixels differ in gain or offset, or some are defective.
    pub(super) fn differs(&self) -> bool {
        let of_pixels = [self.prnu_fraction, self.dsnu_v, self.dead_pixel_fraction, self.hot_pixel_fraction];
        of_pixels != [0.0; 4]
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), SensorError> {
        let deviations = [
            ("dsnu_v", self.dsnu_v),
            ("row_noise_v", self.row_noise_v),
            ("column_noise_v", self.column_noise_v),
            ("hot_pixel_dark_voltage_v_per_s", self.hot_pixel_dark_voltage_v_per_s),
        ];
        for (field, value) in deviations {
            require((0.0..=1e3).contains(&value), field, value, "0 to 1e3")?;
        }
        let fractions = [
            ("prnu_fraction", self.prnu_fraction),
            ("dead_pixel_fraction", self.dead_pixel_fraction),
            ("hot_pixel_fraction", self.hot_pixel_fraction),
            ("dead and hot pixel fraction together", self.dead_pixel_fraction + self.hot_pixel_fraction),
        ];
        for (field, value) in fractions {
            require((0.0..=1.0).contains(&value), field, value, "0 to 1")?;
        }
        Ok(())
    }
}
