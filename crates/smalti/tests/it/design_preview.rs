//! The light of a scene as few components, and the model of the read-out, against captures.
#![allow(clippy::unwrap_used)]

use smalti::camera::description::AutoExposureName;
use smalti::camera::{Camera, CameraDescription, Setup};
use smalti::design::{PixelLight, ReadoutModel, metered_electrons};
use smalti::scene::Setting;
use smalti::sensor::Cfa;
use smalti::spectrum::WavelengthGrid;

use crate::design_targets::{SETS, cfa};

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;
const LEAVES: &str = "dead-leaves?rows=96&cols=128&seed=3";

fn setup(change: impl FnOnce(&mut CameraDescription), spec: &str) -> Setup {
    let mut description = CameraDescription::default();
    change(&mut description);
    let camera = Camera::new(description, GRID).unwrap();
    let setting = Setting { luminance_cd_m2: 30.0, ..Setting::default() };
    Setup::of_test_scene(&camera, spec, &setting).unwrap()
}

/// The weight of each component in each channel, electrons per second.
fn weights(light: &PixelLight, cfa: &Cfa) -> Vec<Vec<f64>> {
    let one = |c: &smalti::sensor::Channel| {
        light.spectra().iter().map(|s| s.times(&c.transmittance).unwrap().integral()).collect()
    };
    cfa.channels().iter().map(one).collect()
}

/// Samples without noise from the components, 0 at black and 1 at saturation, where nothing clips.
fn samples(light: &PixelLight, cfa: &Cfa, readout: &ReadoutModel, time_s: f64) -> Vec<f64> {
    let (planes, weights) = (light.planes(), weights(light, cfa));
    let rate = |i: usize| {
        let channel = cfa.mosaic().channel_at(i / planes.cols(), i % planes.cols());
        planes.planes().zip(&weights[channel]).map(|(p, w)| f64::from(p[i]) * w).sum::<f64>()
    };
    let volts =
        |electrons: f64| (electrons * readout.gain_v_per_e + readout.analog_offset_v) * readout.analog_gain;
    let normal = |v: f64| (v - readout.black_v) / (readout.white_v - readout.black_v);
    (0..planes.plane_len()).map(|i| normal(volts(rate(i) * time_s).min(readout.swing_v))).collect()
}

/// Root mean square of what differs from a capture by a real converter's levels, of saturation.
fn error(setup: &Setup, most: usize, cfa: &Cfa) -> f64 {
    let camera = setup.camera.with_cfa(cfa.clone());
    let setup = setup.before(&camera).unwrap().unwrap();
    let raw = setup.camera.sensor.capture_ideal(&setup.image, &setup.exposure).unwrap();
    let light = PixelLight::new(&setup, most).unwrap();
    let readout = ReadoutModel::new(&setup.camera).unwrap();
    let found = samples(&light, cfa, &readout, setup.exposure.time_s);
    let squares: f64 = raw.normalized().iter().zip(&found).map(|(a, b)| (f64::from(*a) - b).powi(2)).sum();
    (squares / found.len() as f64).sqrt()
}

#[test]
fn few_components_hold_what_filters_see() {
    let change = |d: &mut CameraDescription| {
        d.exposure.analog_gain = 1.5;
        d.exposure.analog_offset_mv = 8.0;
    };
    let leaves = setup(change, LEAVES);
    let rings = setup(change, "zone-plate?size=128&frequency=0.25");
    for set in SETS {
        let cfa = cfa(set);
        // Single precision of the pictures.
        assert!(error(&leaves, GRID.len(), &cfa) < 2e-6, "{}", error(&leaves, GRID.len(), &cfa));
        assert!(error(&leaves, 8, &cfa) < 6e-3, "{}", error(&leaves, 8, &cfa));
        assert!(error(&rings, 3, &cfa) < 2e-4, "{}", error(&rings, 3, &cfa));
    }
}

#[test]
fn components_are_orthonormal_ordered_and_what_is_left_out_is_known() {
    let setup = setup(|_| {}, LEAVES);
    let light = PixelLight::new(&setup, 6).unwrap();
    for (i, a) in light.spectra().iter().enumerate() {
        for (j, b) in light.spectra().iter().enumerate() {
            let product: f64 = a.values().iter().zip(b.values()).map(|(a, b)| a * b).sum();
            assert!((product - f64::from(u8::from(i == j))).abs() < 1e-9);
        }
    }
    let squares = |l: &PixelLight| -> Vec<f64> {
        l.planes().planes().map(|p| p.iter().map(|v| f64::from(*v).powi(2)).sum()).collect()
    };
    let (few, all) = (squares(&light), squares(&PixelLight::new(&setup, GRID.len()).unwrap()));
    assert!(few.is_sorted_by(|a, b| a > b), "{few:?}");
    let lost = (1.0 - few.iter().sum::<f64>() / all.iter().sum::<f64>()).sqrt();
    assert!((lost - light.lost()).abs() < 1e-4 && lost > 1e-3, "{lost}, {}", light.lost());
    assert!(light.brightest() >= all.iter().sum::<f64>().sqrt() / (light.planes().plane_len() as f64).sqrt());
}

/// On a fine grid the components are found from some of the pixels.
#[test]
fn a_fine_grid_takes_no_longer_and_loses_no_more() {
    let grid = WavelengthGrid::new(400.0, 1.0, 301).unwrap();
    let camera = Camera::new(CameraDescription::default(), grid).unwrap();
    let setting = Setting { grid, ..Setting::default() };
    let fine = Setup::of_test_scene(&camera, LEAVES, &setting).unwrap();
    let (fine, coarse) =
        (PixelLight::new(&fine, 8).unwrap(), PixelLight::new(&setup(|_| {}, LEAVES), 8).unwrap());
    assert!(fine.lost() < 1.5 * coarse.lost(), "{}, {}", fine.lost(), coarse.lost());
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let setup = setup(|_| {}, LEAVES);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| PixelLight::new(&setup, 8).unwrap())
    };
    let (one, three) = (with(1), with(3));
    assert_eq!(one.planes(), three.planes());
    assert_eq!(one.spectra(), three.spectra());
}

#[test]
fn the_model_finds_the_exposure_of_each_rule() {
    for rule in [AutoExposureName::Specular, AutoExposureName::Luminance, AutoExposureName::Mean] {
        let change = |d: &mut CameraDescription| {
            d.exposure.auto = Some(rule);
            d.exposure.analog_offset_mv = 8.0;
            d.sensor.pixel.dark_voltage_v_per_s = 3e-3;
        };
        let setup = setup(change, LEAVES);
        let (light, readout) =
            (PixelLight::new(&setup, GRID.len()).unwrap(), ReadoutModel::new(&setup.camera).unwrap());
        let cfa = &setup.camera.sensor.cfa;
        let metered = metered_electrons(&setup).unwrap();
        let rate = match &metered {
            Some(spectrum) => {
                let channel =
                    |c: &smalti::sensor::Channel| spectrum.times(&c.transmittance).unwrap().integral();
                cfa.channels().iter().map(channel).fold(0.0, f64::max)
            }
            None => {
                let plain = ReadoutModel {
                    gain_v_per_e: 1.0,
                    analog_offset_v: 0.0,
                    analog_gain: 1.0,
                    black_v: 0.0,
                    white_v: 1.0,
                    swing_v: f64::INFINITY,
                    ..readout.clone()
                };
                let rates = samples(&light, cfa, &plain, 1.0);
                rates.iter().sum::<f64>() / rates.len() as f64
            }
        };
        assert_eq!((metered.is_none(), readout.time_s), (rule == AutoExposureName::Mean, None));
        let time_s = readout.metered_v.unwrap() / ((rate + readout.dark_e_per_s) * readout.gain_v_per_e);
        assert!(
            (time_s / setup.exposure.time_s - 1.0).abs() < 1e-5,
            "{rule:?}: {time_s}, {}",
            setup.exposure.time_s
        );
    }
    let fixed = setup(|d| d.exposure.time_ms = Some(7.0), LEAVES);
    let readout = ReadoutModel::new(&fixed.camera).unwrap();
    assert_eq!((readout.time_s, readout.metered_v), (Some(0.007), None));
}
