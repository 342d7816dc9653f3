//! The sensor measured as a camera maker would, in the manner of EMVA 1288: what was put in comes back.
#![allow(missing_docs, clippy::unwrap_used)]

use smalti::metrics::photon_transfer::{FlatPair, FrameStacks, photon_transfer};
use smalti::numeric::Planes;
use smalti::optics::OpticalImage;
use smalti::sensor::{
    Adc, Cfa, Channel, Exposure, Mosaic, NoiseMode, NonUniformity, Pixel, RawSamples, Sensor,
};
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;
const SIDE: usize = 192;
const GAIN_V_PER_E: f64 = 60e-6;
const READ_E: f64 = 4.0;
const FULL_WELL_E: f64 = 12_000.0;
const PRNU: f64 = 0.008;
const DSNU_E: f64 = 3.0;
const SWING_V: f64 = 0.9;

fn sensor() -> Sensor {
    let clear = Channel { name: "W".into(), transmittance: Spectrum::constant(GRID, 1.0).unwrap() };
    let cfa = Cfa::new("mono", Mosaic::new(1, 1, vec![0]).unwrap(), vec![clear]).unwrap();
    let pixel = Pixel {
        pitch_m: 3e-6,
        fill_factor: 1.0,
        conversion_gain_v_per_e: GAIN_V_PER_E,
        voltage_swing_v: SWING_V,
        full_well_e: FULL_WELL_E,
        dark_voltage_v_per_s: 0.0,
        read_noise_v: READ_E * GAIN_V_PER_E,
    };
    Sensor {
        nonuniformity: NonUniformity {
            prnu_fraction: PRNU,
            dsnu_v: DSNU_E * GAIN_V_PER_E,
            device_serial: 7,
            ..NonUniformity::default()
        },
        adc: Adc { bits: 14, black_level_dn: 256.0 },
        ..Sensor::new(SIDE, SIDE, pixel, cfa, Spectrum::constant(GRID, 1.0).unwrap())
    }
}

fn frame(light: &OpticalImage, time_s: f64, seed: u64) -> Vec<f32> {
    let raw = sensor().capture(light, &Exposure::new(time_s), NoiseMode::All, seed).unwrap();
    match raw.samples() {
        RawSamples::Digital(v) => v.iter().map(|&x| f32::from(x)).collect(),
        RawSamples::Analog(v) => v.clone(),
    }
}

#[test]
fn what_was_put_in_comes_back() {
    let planes = Planes::new(SIDE, SIDE, GRID.len(), vec![1e13; SIDE * SIDE * GRID.len()]).unwrap();
    let light = OpticalImage::new(SpectralCube::new(GRID, planes).unwrap(), 3e-6).unwrap();
    // 1e13 photons s⁻¹ m⁻² nm⁻¹ over 310 nm and 9 µm²: electrons per second.
    let rate = 1e13 * 310.0 * 9e-12;
    let times: Vec<f64> = (1..=45).map(|i| FULL_WELL_E / rate * f64::from(i) * 0.025).collect();
    let frames: Vec<[Vec<f32>; 4]> = times
        .iter()
        .enumerate()
        .map(|(i, &t)| {
            let seed = 10 * i as u64;
            [
                frame(&light, t, seed),
                frame(&light, t, seed + 1),
                frame(&light, 0.0, seed + 2),
                frame(&light, 0.0, seed + 3),
            ]
        })
        .collect();
    let pairs: Vec<FlatPair<'_>> = times
        .iter()
        .zip(&frames)
        .map(|(&exposure, [a, b, c, d])| FlatPair { exposure, bright: [a, b], dark: [c, d] })
        .collect();
    let stack = |time_s: f64, first: u64| -> Vec<Vec<f32>> {
        (0..48).map(|i| frame(&light, time_s, first + i)).collect()
    };
    let (bright, dark) = (stack(0.5 * FULL_WELL_E / rate, 10_000), stack(0.0, 20_000));
    let (bright, dark): (Vec<&[f32]>, Vec<&[f32]>) =
        (bright.iter().map(Vec::as_slice).collect(), dark.iter().map(Vec::as_slice).collect());
    let stacks = FrameStacks { bright: &bright, dark: &dark };
    let m = photon_transfer(&pairs, Some(&stacks), 1.0).unwrap();
    let volts_per_dn = SWING_V / 16384.0;
    let within = |what: &str, got: f64, put_in: f64, percent: f64| {
        let off = 100.0 * (got / put_in - 1.0);
        eprintln!("{what}: {got:.5} measured, {put_in:.5} put in, {off:+.2} %");
        assert!(off.abs() <= percent, "{what}: {got} measured, {put_in} put in, {off:+.2} %");
    };
    // Limits: some four standard errors of the estimators with 192² pixels, 45 levels and stacks of 48 frames.
    within("conversion gain, µV/e⁻", m.conversion_gain_v_per_e(volts_per_dn) * 1e6, GAIN_V_PER_E * 1e6, 1.0);
    within("read noise, e⁻", m.dark_noise_e, READ_E, 2.0);
    // The level at which variance peaks lies a step of exposure (2.5 %) and the spread by PRNU below the well.
    within("full well, e⁻", m.full_well_e.unwrap(), FULL_WELL_E, 1.0);
    within("PRNU, %", m.prnu_percent.unwrap(), PRNU * 100.0, 3.0);
    within("DSNU, e⁻", m.dsnu_e.unwrap(), DSNU_E, 3.0);
}
