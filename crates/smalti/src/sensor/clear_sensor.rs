//! A sensor for unit tests.

use super::{Cfa, Channel, Mosaic, Pixel, Sensor};
use crate::spectrum::{Spectrum, WavelengthGrid};

/// Pixels of one row of channels that pass all light, without noise.
pub(super) fn clear_sensor(rows: usize, cols: usize, channels: u8) -> Sensor {
    let clear = Spectrum::constant(WavelengthGrid::VISIBLE, 1.0).unwrap();
    let channel = |i: u8| Channel { name: i.to_string(), transmittance: clear.clone() };
    let mosaic = Mosaic::new(1, channels.into(), (0..channels).collect()).unwrap();
    let cfa = Cfa::new("clear", mosaic, (0..channels).map(channel).collect()).unwrap();
    let pixel = Pixel {
        pitch_m: 2e-6,
        fill_factor: 1.0,
        conversion_gain_v_per_e: 1e-4,
        voltage_swing_v: 1.0,
        full_well_e: 1e4,
        dark_voltage_v_per_s: 0.0,
        read_noise_v: 0.0,
    };
    Sensor::new(rows, cols, pixel, cfa, clear)
}
