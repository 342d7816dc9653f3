//! The ranges of the numbers in a camera file.

use std::fmt;

use super::CameraError;
use crate::numeric::Number;

/// The range of a number in a camera file, in the unit of its key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeyRange {
    /// Dotted path of the key, such as `optics.f_number`. For a key of a filter, which several keys may have, it is the path within the
    /// filter with a leading dot, such as `.gaussian.sigma_nm`.
    pub key: &'static str,
    /// The least value.
    pub low: f64,
    /// The largest value.
    pub high: f64,
}

impl fmt::Display for KeyRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to {}", Number(self.low), Number(self.high))
    }
}

const fn range(key: &'static str, low: f64, high: f64) -> KeyRange {
    KeyRange { key, low, high }
}

/// Wavelengths of photodiodes. A value of 0.61 is probably a wavelength in µm.
const NM: [f64; 2] = [100.0, 1e5];
const WIDTH_NM: [f64; 2] = [1e-6, 1e5];

const fn of_nm(key: &'static str) -> KeyRange {
    range(key, NM[0], NM[1])
}

const fn of_width(key: &'static str) -> KeyRange {
    range(key, WIDTH_NM[0], WIDTH_NM[1])
}

const fn of_share(key: &'static str) -> KeyRange {
    range(key, 0.0, 1.0)
}

/// The ranges of all keys that are numbers. They are far outside real devices, yet every value within them has a meaning and keeps single
/// precision from overflow.
pub const KEY_RANGES: &[KeyRange] = &[
    of_nm("wavelengths_nm"),
    // The numerical aperture in air is below 1.
    range("optics.f_number", 0.5, 1e3),
    range("optics.focal_length_mm", 1e-3, 1e5),
    of_share(".flat"),
    of_nm(".gaussian.center_nm"),
    of_width(".gaussian.sigma_nm"),
    of_share(".gaussian.peak"),
    of_nm(".box.low_nm"),
    of_nm(".box.high_nm"),
    of_share(".box.peak"),
    of_nm(".raised_cosine.center_nm"),
    of_width(".raised_cosine.fwhm_nm"),
    of_share(".raised_cosine.peak"),
    of_nm(".long_pass.edge_nm"),
    of_width(".long_pass.width_nm"),
    of_share(".long_pass.peak"),
    of_nm(".short_pass.edge_nm"),
    of_width(".short_pass.width_nm"),
    of_share(".short_pass.peak"),
    of_nm(".butterworth.center_nm"),
    of_width(".butterworth.fwhm_nm"),
    of_share(".butterworth.peak"),
    range(".butterworth.order", 1.0, 100.0),
    of_share(".dye.peak"),
    of_share(".dye.leakage"),
    of_nm(".samples.start_nm"),
    of_width(".samples.step_nm"),
    range("optics.low_pass_separation_um", 0.0, 1e3),
    range("optics.defocus_dioptres", -1e4, 1e4),
    of_nm("optics.chromatic_reference_nm"),
    range("optics.chromatic_dioptres_per_um", -1e4, 1e4),
    range("optics.zernike_um", -1e3, 1e3),
    range("optics.psf.spacing_um", 1e-6, 1e4),
    of_nm("optics.psf.start_nm"),
    of_width("optics.psf.step_nm"),
    range("sensor.rows", 1.0, 1e8),
    range("sensor.cols", 1.0, 1e8),
    range("sensor.adc_bits", 0.0, 16.0),
    range("sensor.black_level_dn", 0.0, 65535.0),
    range("sensor.prnu_percent", 0.0, 100.0),
    range("sensor.dsnu_mv", 0.0, 1e5),
    range("sensor.dsnu_e", 0.0, 1e6),
    range("sensor.row_noise_mv", 0.0, 1e5),
    range("sensor.column_noise_mv", 0.0, 1e5),
    range("sensor.dead_pixels_ppm", 0.0, 1e6),
    range("sensor.hot_pixels_ppm", 0.0, 1e6),
    range("sensor.hot_pixel_dark_voltage_v_per_s", 0.0, 1e3),
    range("sensor.serial", 0.0, i64::MAX as f64),
    range("sensor.crosstalk_percent", 0.0, 100.0),
    range("sensor.binning.side", 2.0, 8.0),
    range("sensor.pixel.pitch_um", 1e-3, 1e3),
    range("sensor.pixel.fill_factor", 1e-6, 1.0),
    range("sensor.pixel.conversion_gain_uv_per_e", 1e-6, 1e6),
    range("sensor.pixel.voltage_swing_v", 1e-6, 1e3),
    range("sensor.pixel.full_well_e", 1.0, 1e9),
    range("sensor.pixel.dark_voltage_v_per_s", 0.0, 1e3),
    range("sensor.pixel.dark_current_e_per_s", 0.0, 1e6),
    range("sensor.pixel.temperature_c", -200.0, 200.0),
    range("sensor.pixel.dark_doubling_c", 1.0, 100.0),
    range("sensor.pixel.read_noise_mv", 0.0, 1e5),
    range("sensor.pixel.read_noise_e", 0.0, 1e6),
    range("sensor.pixel.low_conversion_gain_uv_per_e", 1e-6, 1e6),
    range("sensor.pixel.low_gain_read_noise_mv", 0.0, 1e5),
    range("sensor.pixel.low_gain_read_noise_e", 0.0, 1e6),
    of_share("sensor.cfa.mixtures"),
    range("exposure.time_ms", 0.0, 1e9),
    range("exposure.auto_target", 1e-6, 1.0),
    range("exposure.auto_percentile", 0.0, 100.0),
    range("exposure.analog_gain", 1e-6, 1e6),
    range("exposure.analog_offset_mv", -1e5, 1e5),
    range("isp.color_noise_percent", 0.0, 100.0),
];

impl KeyRange {
    /// The range of a key; `None` for a key that is no number.
    #[must_use]
    pub fn of(key: &str) -> Option<&'static Self> {
        let whole = KEY_RANGES.iter().find(|r| r.key == key);
        whole.or_else(|| KEY_RANGES.iter().find(|r| r.key.starts_with('.') && key.ends_with(r.key)))
    }
}

/// The value of a key within its range. NaN is in none.
pub(super) fn checked(key: &str, value: f64) -> Result<f64, CameraError> {
    checked_as(key, key, value)
}

/// As [`checked`], for one of several numbers of a key, which the error names.
pub(super) fn checked_as(key: &str, name: &str, value: f64) -> Result<f64, CameraError> {
    let range = KeyRange::of(key).copied().unwrap_or(range("", -f64::MAX, f64::MAX));
    if range.low <= value && value <= range.high {
        return Ok(value);
    }
    let message = format!("{} is out of range; expected {range}", Number(value));
    Err(CameraError::Key { key: name.to_owned(), message })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_has_one_range_and_nothing_beyond_it() {
        for (i, r) in KEY_RANGES.iter().enumerate() {
            assert!(r.low < r.high && r.low.is_finite() && r.high.is_finite(), "{}", r.key);
            assert!(KEY_RANGES[..i].iter().all(|other| other.key != r.key), "{} twice", r.key);
            assert_eq!(checked(r.key, r.low), Ok(r.low));
            assert_eq!(checked(r.key, r.high), Ok(r.high));
            for wrong in [r.low.next_down(), r.high.next_up(), f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let error = checked(r.key, wrong).unwrap_err().to_string();
                assert!(error.contains(r.key) && error.contains(&r.to_string()), "{error}");
            }
        }
        let of_filter = KeyRange::of("sensor.cfa.filters.R.gaussian.sigma_nm").unwrap();
        assert_eq!(of_filter.key, ".gaussian.sigma_nm");
        assert_eq!(KeyRange::of("sensor.cfa.pattern"), None);
    }

    #[test]
    fn large_and_small_numbers_are_short() {
        let error = checked("sensor.prnu_percent", 1e308).unwrap_err().to_string();
        assert_eq!(error, "`sensor.prnu_percent`: 1e308 is out of range; expected 0 to 100");
        let error = checked("optics.f_number", 1e-300).unwrap_err().to_string();
        assert_eq!(error, "`optics.f_number`: 1e-300 is out of range; expected 0.5 to 1000");
    }
}
