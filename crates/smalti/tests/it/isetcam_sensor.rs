//! Everything that the reference values of ISETCam say about a uniform field, and the patches of its chart.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use crate::common;
use crate::sensor_kit;

use common::isetcam::{self, Case, image_of};
use common::{assert_close, numbers, reference_csv, reference_json};
use sensor_kit::*;
use smalti::optics::OpticalImage;
use smalti::sensor::*;
use smalti::spectrum::Spectrum;

fn filters(name: &str) -> [Spectrum; 3] {
    let rows = reference_csv(&format!("filters_{name}_400_10_700.csv"));
    [0, 1, 2].map(|c| Spectrum::new(GRID, rows.iter().map(|r| r[c]).collect()).unwrap())
}

fn reference_sensor(rows: usize, cols: usize, cfa: Cfa) -> Sensor {
    Sensor::new(rows, cols, isetcam::pixel(), cfa, Spectrum::constant(GRID, 1.0).unwrap())
}

#[test]
fn uniform_field() {
    let reference = reference_json("sensor_uniform.json");
    let irradiance = numbers(&reference["irradiance_photons"]);
    let image = flat_spectrum(11, 11, 1e-4, &irradiance);
    let lux = f64::from(image.illuminance_lux().unwrap()[0]);
    assert_close("illuminance", &[lux], &numbers(&reference["illuminance_lux"]), 1e-3);
    for set in ["nikonD100", "isetRGB"] {
        for ms in [10, 40] {
            let case = &reference[format!("{set}_{ms}ms")];
            let mut s = reference_sensor(146, 146, bayer(filters(set)));
            let exposure = Exposure::new(case["exp_time_s"].as_f64().unwrap());
            let free = s.expected_volts(&image, &exposure).unwrap();
            let means: Vec<f64> = (0..3).map(|c| moments(&of_channel(&s, free.data(), c)).0).collect();
            let electrons: Vec<f64> = means.iter().map(|v| v / 1e-4).collect();
            // The irradiance is that of the middle, the volts are means over the sensor. Between them, the tails of
            // the PSF take light over the edge of the field: 1e-4, in proportion to wavelength.
            assert_close("volts", &means, &numbers(&case["volts_rgb_noisefree"]), 2e-4);
            assert_close("electrons", &electrons, &numbers(&case["electrons_rgb_noisefree"]), 2e-4);

            for bits in [10, 12] {
                s.adc.bits = bits;
                let raw = s.capture(&image, &exposure, NoiseMode::None, 0).unwrap();
                let dn: Vec<f64> = (0..3).map(|c| moments(&of_channel(&s, &values(&raw), c)).0).collect();
                assert_eq!(dn, numbers(&case[format!("dv{bits}_rgb")]), "{set} {ms} ms");
            }
            s.adc.bits = 0;

            let mut all: [Vec<f32>; 3] = Default::default();
            for seed in 0..8 {
                let raw = values(&s.capture(&image, &exposure, NoiseMode::All, seed).unwrap());
                (0..3).for_each(|c| all[c].extend(of_channel(&s, &raw, c)));
            }
            let (mean, std) = (numbers(&case["noise2_mean_volts"]), numbers(&case["noise2_std_volts"]));
            let expected = numbers(&case["noise2_std_expected"]);
            for c in 0..3 {
                let (m, variance) = moments(&all[c]);
                // Two samples of equal size: √2 of the standard error of one.
                let se = expected[c] * (2.0 / all[c].len() as f64).sqrt();
                assert!((m - mean[c]).abs() < 4.0 * se, "{set} {ms} ms mean {m} for {}", mean[c]);
                assert!((variance / expected[c].powi(2) - 1.0).abs() < 0.02, "{variance}");
                // Their draw has an error of its own, up to 1.6 % of the variance.
                assert!((variance / std[c].powi(2) - 1.0).abs() < 0.04, "{variance}");
                let model = s.noise_variance(electrons[c], &exposure).unwrap().total().sqrt();
                assert_close("closed form", &[model], &[expected[c]], 1e-4);
            }
        }
        let s = reference_sensor(146, 146, bayer(filters(set)));
        let rule = AutoExposure::Specular { fraction: 0.95 };
        let time = rule.exposure_time(&s, &image, &Exposure::new(0.0)).unwrap();
        // ISETCam's has read noise in it: the largest of 64 (R, B) or 128 (G) pixels of a block of 8×8 tiles lies
        // 2.35 or 2.6 standard deviations above the mean, 1 mV each.
        let excess = if set == "isetRGB" { 2.35e-3 } else { 2.6e-3 };
        let with_noise = 0.95 / (0.95 / time + excess);
        let theirs = reference["auto_exposure"][set]["mean_s"].as_f64().unwrap();
        assert_close("automatic exposure", &[with_noise], &[theirs], 1e-3);
    }
}

/// The middle of each patch of the chart, as a flat field of its irradiance, under both mosaics.
#[test]
fn chart_patches() {
    let irradiance = reference_csv("oi_macbeth_irradiance_photons_cos4th_on.csv");
    for id in ["nikonD100", "g6a"] {
        let case = Case::new(id);
        let volts = reference_csv(&format!("sensor_mac_volts_noisefree_{id}.csv"));
        let n = case.cfa.channels().len();
        let (tile_rows, tile_cols) = (case.cfa.mosaic().rows(), case.cfa.mosaic().cols());
        let s = reference_sensor(tile_rows, tile_cols, case.cfa.clone());
        let exposure = case.exposure("mac");
        let centres = numbers(&case.json["mac_noisefree"]["patch_centers_rc"]);
        let (mut got, mut expected) = (Vec::new(), Vec::new());
        for (patch, light) in irradiance.iter().enumerate() {
            let flat = s.expected_volts(&flat_spectrum(3, 3, 1e-3, light), &exposure).unwrap();
            let (row, col) = (centres[patch] as usize - 1, centres[24 + patch] as usize - 1);
            for c in 0..n {
                let near = (row - 4..=row + 4).flat_map(|r| (col - 4..=col + 4).map(move |k| (r, k)));
                let theirs: Vec<f32> = near
                    .filter(|&(r, k)| s.cfa.mosaic().channel_at(r, k) == c)
                    .map(|(r, k)| volts[r][k] as f32)
                    .collect();
                expected.push(moments(&theirs).0);
                got.push(moments(&of_channel(&s, flat.data(), c)).0);
            }
        }
        assert_close(id, &got, &expected, 1e-3);
    }
}

/// Compares the volts of a whole mosaic, dark signal included.
fn assert_mosaic(target: &str, id: &str, image: &OpticalImage, tolerance: f64) {
    let case = Case::new(id);
    let mut s = case.sensor(target);
    s.aperture = Aperture::Point;
    let volts = s.expected_volts(image, &case.exposure(target)).unwrap();
    let volts: Vec<f64> = volts.data().iter().map(|&v| f64::from(v)).collect();
    let expected = reference_csv(&format!("sensor_{target}_volts_noisefree_{id}.csv")).concat();
    assert_close(&format!("{target} {id}"), &volts, &expected, tolerance);
}

/// Samples of 3.5 µm under pixels of 2.8 µm: ISETCam interpolates linearly, without a blur. Largest difference 1.6e-4,
/// RMS 1.2e-5 (the dark signal, 7e-5, is in both).
#[test]
fn whole_mosaics_of_the_chart() {
    let chart = isetcam::chart();
    let image = image_of(&chart);
    for id in ["nikonD100", "g6a"] {
        assert_mosaic("mac", id, &image, 1e-3);
    }
}

/// Samples of 0.66 µm under pixels of 2.8 µm: ISETCam blurs and then interpolates linearly. Largest difference 2.4e-4, RMS 3.2e-5.
#[test]
fn whole_mosaics_of_the_edge() {
    let image = isetcam::blurred_for_the_edge(&image_of(&isetcam::bar()));
    for id in ["nikonD100", "g6a"] {
        assert_mosaic("bar", id, &image, 1e-3);
    }
}
