//! Quantities of a description that no real camera has.

use super::CameraDescription;
use super::optics::OpticsModelName;
use crate::sensor::cfa::Filter;

impl CameraDescription {
    /// The quantities with ideal values, in words and in the order of the light. Defaults that a file does not state are often ideal and
    /// flatter the camera.
    #[must_use]
    pub fn ideal_quantities(&self) -> Vec<&'static str> {
        let (optics, sensor, pixel) = (&self.optics, &self.sensor, &self.sensor.pixel);
        let is_one = |filter: &Filter| matches!(filter, Filter::Flat(share) if *share == 1.0);
        // A quantity in electrons replaces that in volts.
        let is_zero = |volts: f64, electrons: Option<f64>| electrons.unwrap_or(volts) == 0.0;
        let aberrations = optics.defocus_dioptres != 0.0 || optics.chromatic_dioptres_per_um != 0.0;
        [
            (optics.model == OpticsModelName::Pinhole, "no diffraction"),
            (optics.model == OpticsModelName::Diffraction && !aberrations, "no aberrations"),
            (is_one(&optics.transmittance), "lens of transmittance 1"),
            (is_one(&sensor.quantum_efficiency), "quantum efficiency 1"),
            (pixel.fill_factor == 1.0, "fill factor 1"),
            (sensor.crosstalk_percent == 0.0, "no crosstalk"),
            (is_zero(pixel.dark_voltage_v_per_s, pixel.dark_current_e_per_s), "no dark current"),
            (is_zero(pixel.read_noise_mv, pixel.read_noise_e), "no read noise"),
            (sensor.prnu_percent == 0.0, "no PRNU"),
            (is_zero(sensor.dsnu_mv, sensor.dsnu_e), "no DSNU"),
            (sensor.row_noise_mv == 0.0, "no row noise"),
            (sensor.column_noise_mv == 0.0, "no column noise"),
            (sensor.dead_pixels_ppm == 0.0 && sensor.hot_pixels_ppm == 0.0, "no defective pixels"),
            (sensor.adc_bits == 0, "no quantisation"),
        ]
        .into_iter()
        .filter_map(|(is_ideal, words)| is_ideal.then_some(words))
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_quantities_with_ideal_values_are_named() {
        let mut d = CameraDescription::default();
        let named = d.ideal_quantities();
        for ideal in
            ["no aberrations", "lens of transmittance 1", "quantum efficiency 1", "no PRNU", "no DSNU"]
        {
            assert!(named.contains(&ideal), "{ideal}: {named:?}");
        }
        assert!(!named.contains(&"no read noise") && !named.contains(&"fill factor 1"), "{named:?}");
        d.sensor.quantum_efficiency = Filter::Flat(0.7);
        d.sensor.prnu_percent = 1.0;
        // The quantity in electrons counts.
        d.sensor.dsnu_e = Some(2.0);
        d.sensor.pixel.read_noise_e = Some(0.0);
        d.optics.model = OpticsModelName::Pinhole;
        let named = d.ideal_quantities();
        for real in ["quantum efficiency 1", "no PRNU", "no DSNU", "no aberrations"] {
            assert!(!named.contains(&real), "{real}: {named:?}");
        }
        assert!(named.contains(&"no read noise") && named.contains(&"no diffraction"), "{named:?}");
    }
}
