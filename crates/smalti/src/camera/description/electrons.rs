//! Quantities of a pixel in electrons, which are comparable between cameras of different conversion gains.

use super::CameraDescription;

/// Significant digits of quantities in electrons: those in volts are products of two values.
const DIGITS: usize = 6;

fn rounded(electrons: f64) -> f64 {
    format!("{electrons:.*e}", DIGITS - 1).parse().unwrap_or(electrons)
}

impl CameraDescription {
    /// The description with the quantities that have a key in volts and a key in electrons stated in electrons, with six significant
    /// digits. Their keys in volts are 0, or absent where they can be.
    #[must_use]
    pub fn in_electrons(&self) -> Self {
        let mut out = self.clone();
        let (sensor, gain_uv) = (&mut out.sensor, self.sensor.pixel.conversion_gain_uv_per_e);
        let take = |volts: &mut f64, electrons: &mut Option<f64>, microvolts: f64| {
            let volts = std::mem::take(volts);
            *electrons = Some(electrons.unwrap_or_else(|| rounded(volts * microvolts / gain_uv)));
        };
        take(&mut sensor.dsnu_mv, &mut sensor.dsnu_e, 1e3);
        let pixel = &mut sensor.pixel;
        take(&mut pixel.dark_voltage_v_per_s, &mut pixel.dark_current_e_per_s, 1e6);
        take(&mut pixel.read_noise_mv, &mut pixel.read_noise_e, 1e3);
        if let Some(low_uv) = pixel.low_conversion_gain_uv_per_e
            && let Some(mv) = pixel.low_gain_read_noise_mv.take()
        {
            pixel.low_gain_read_noise_e = Some(rounded(mv * 1e3 / low_uv));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_come_back_as_they_were_stated() {
        let mut d = CameraDescription::default();
        d.sensor.pixel.conversion_gain_uv_per_e = 110.0;
        (d.sensor.dsnu_mv, d.sensor.pixel.read_noise_mv) = (1.0 * 110.0 * 1e-3, 2.0 * 110.0 * 1e-3);
        d.sensor.pixel.dark_voltage_v_per_s = 5.0 * 110.0 * 1e-6;
        d.sensor.pixel.low_conversion_gain_uv_per_e = Some(30.0);
        d.sensor.pixel.low_gain_read_noise_mv = Some(3.0 * 30.0 * 1e-3);
        let found = d.in_electrons();
        let pixel = &found.sensor.pixel;
        assert_eq!((found.sensor.dsnu_e, pixel.read_noise_e), (Some(1.0), Some(2.0)));
        assert_eq!((pixel.dark_current_e_per_s, pixel.low_gain_read_noise_e), (Some(5.0), Some(3.0)));
        assert_eq!(
            (found.sensor.dsnu_mv, pixel.read_noise_mv, pixel.low_gain_read_noise_mv),
            (0.0, 0.0, None)
        );
        assert_eq!(found.in_electrons(), found);
    }
}
