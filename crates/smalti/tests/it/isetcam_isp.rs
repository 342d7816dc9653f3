//! Processing against ISETCam's. `ISETCam` demosaicks Bayer bilinearly, replicating samples at the border; other
//! mosaics it triangulates (Delaunay) at randomly jittered positions, whose mean over draws is what ours computes.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use crate::common;

use common::isetcam::mosaic;
use common::{assert_close, numbers, reference_csv, reference_json};
use serde_json::Value;
use smalti::isp::{Classic, ColorConstraint, ColorFit, ColorMatrix, Demosaic, Isp, WhiteBalance};
use smalti::numeric::Planes;
use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling};
use smalti::spectrum::{Observer, Spectrum, WavelengthGrid};

fn raw(mosaic: Mosaic, volts: &[Vec<f64>]) -> RawImage {
    let names = (0..mosaic.channels()).map(|c| c.to_string()).collect();
    let samples = RawSamples::Analog(volts.iter().flatten().map(|v| *v as f32).collect());
    RawImage::new(volts.len(), volts[0].len(), samples, Sampling::Mosaic(mosaic), names, 0.0, 1.0).unwrap()
}

fn rows_of(v: &Value) -> Vec<Vec<f64>> {
    v.as_array().unwrap().iter().map(numbers).collect()
}

/// Values of some planes within `inset` of the border.
fn interior(planes: &Planes, inset: usize) -> Vec<f64> {
    let (rows, cols) = (planes.rows(), planes.cols());
    let at = |p: &[f32], r: usize, c: usize| f64::from(p[r * cols + c]);
    planes
        .planes()
        .flat_map(|p| {
            (inset..rows - inset).flat_map(move |r| (inset..cols - inset).map(move |c| at(p, r, c)))
        })
        .collect()
}

fn planes_of(channels: &[Vec<Vec<f64>>]) -> Planes {
    let (rows, cols) = (channels[0].len(), channels[0][0].len());
    let data = channels.iter().flatten().flatten().map(|v| *v as f32).collect();
    Planes::new(rows, cols, channels.len(), data).unwrap()
}

fn rms(v: impl Iterator<Item = f64> + Clone) -> f64 {
    (v.clone().map(|e| e * e).sum::<f64>() / v.count() as f64).sqrt()
}

#[test]
fn bayer_interior_is_isetcams() {
    let isolated = reference_json("ip_demosaic_isolated.json");
    let case = &isolated["g3a"];
    let ours = Demosaic::Bilinear.apply(&raw(mosaic(&case["pattern"]), &rows_of(&case["mosaic"]))).unwrap();
    let theirs: Vec<_> = case["mean"].as_array().unwrap().iter().map(rows_of).collect();
    // ISETCam computes in single precision. The outermost pixels differ: there it repeats the border's samples.
    assert_close("isolated g3a", &interior(&ours, 1), &interior(&planes_of(&theirs), 1), 3e-7);

    let volts = reference_csv("sensor_mac_volts_noisefree_nikonD100.csv");
    let ours = Demosaic::Bilinear.apply(&raw(mosaic(&case["pattern"]), &volts)).unwrap();
    let file = |k| reference_csv(&format!("ip_mac_demosaic_nikonD100_ch{k}.csv"));
    let theirs = planes_of(&[file(1), file(2), file(3)]);
    assert_close("chart nikonD100", &interior(&ours, 1), &interior(&theirs, 1), 3e-7);
}

/// Ours is the mean of ISETCam's over random triangulations: what is left is the error of its mean of 32 draws.
#[test]
fn other_mosaics_are_isetcams_mean() {
    let isolated = reference_json("ip_demosaic_isolated.json");
    for id in ["g4a", "g5a", "g6a", "g7a"] {
        let case = &isolated[id];
        let volts = rows_of(&case["mosaic"]);
        let ours = Demosaic::Bilinear.apply(&raw(mosaic(&case["pattern"]), &volts)).unwrap();
        let planes =
            |key: &str| planes_of(&case[key].as_array().unwrap().iter().map(rows_of).collect::<Vec<_>>());
        // Eight pixels in, ISETCam's hull and its zeros outside are not felt.
        let (ours, mean, std) =
            (interior(&ours, 8), interior(&planes("mean"), 8), interior(&planes("std"), 8));
        // It divides each draw by the largest value; one factor for all brings ours to the same scale.
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let scale = dot(&ours, &mean) / dot(&ours, &ours);
        let error = rms(ours.iter().zip(&mean).map(|(o, m)| scale * o - m));
        let of_mean = rms(std.iter().copied()) / 32.0f64.sqrt();
        println!("{id}: RMS {error:.5}, expected of a mean of 32 draws {of_mean:.5}, scale {scale:.4}");
        assert!((0.98..1.02).contains(&scale), "{id}: scale {scale}");
        // The draws of neighbouring pixels hang together, so the RMS itself scatters by some 20 %.
        assert!(error < 1.4 * of_mean, "{id}: RMS {error:.5}, expected {of_mean:.5}");
    }
}

/// ISETCam's sensor-to-XYZ matrix is the least-squares fit over the Macbeth chart under D65, up to a factor.
#[test]
fn color_matrix_is_isetcams() {
    let scene = reference_json("scene_macbeth_d65.json");
    let grid = WavelengthGrid::VISIBLE;
    let spectrum = |v: Vec<f64>| Spectrum::new(grid, v).unwrap();
    let light = spectrum(numbers(&scene["illuminant_photons_s_sr_m2_nm"]));
    let chart: Vec<_> =
        reference_csv("macbeth_reflectance_400_10_700.csv").into_iter().map(spectrum).collect();
    for id in ["nikonD100", "isetRGB", "g3a", "g4a", "g5a", "g6a", "g7a"] {
        let case = reference_json(&format!("ip_case_{id}.json"));
        let filters = rows_of(&case["filters_31xN"]);
        let channel = |c: usize| spectrum(filters.iter().map(|row| row[c]).collect());
        let channels: Vec<_> = (0..filters[0].len()).map(channel).collect();
        let fit = ColorFit::new(&chart, &light, Observer::Cie1931).unwrap();
        let m = fit.matrix(&channels, ColorConstraint::None, 0.0).unwrap();
        let (ours, theirs) = (m.xyz_from_camera().concat(), numbers(&case["T_sensor2xyz"]));
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let scale = dot(&ours, &theirs) / dot(&ours, &ours);
        let ours: Vec<f64> = ours.iter().map(|v| v * scale).collect();
        // Single precision on their side, amplified by the condition of the fit (up to 1e3 for seven channels).
        assert_close(id, &ours, &theirs, 1e-4);
    }
}

/// From ISETCam's volts, with its matrices, to its linear display RGB.
fn display_rgb(id: &str, target: &str) -> (Value, Planes) {
    let case = reference_json(&format!("ip_case_{id}.json"));
    let volts = reference_csv(&format!("sensor_{target}_volts_noisefree_{id}.csv"));
    let (t, m) = (rows_of(&case["T_sensor2xyz"]), rows_of(&case["M_xyz2display"]));
    // The display's RGB take the place of X, Y, Z: to the pipeline a matrix is a matrix.
    let column = |row: &Vec<f64>| [0, 1, 2].map(|j| (0..3).map(|k| row[k] * m[k][j]).sum::<f64>());
    let columns: Vec<_> = t.iter().map(column).collect();
    let white = vec![1.0; columns.len()];
    let isp = Classic {
        white_balance: WhiteBalance::None,
        ..Classic::new(ColorMatrix::new(columns, white, [1.0; 3]).unwrap())
    };
    let image = isp.render(&raw(mosaic(&case["pattern"]), &volts)).unwrap();
    (case, image.into_planes())
}

/// The factor by which ISETCam scales its whole picture, by least squares, applied; then its clipping to 0–1.
fn scaled_like(ours: &[f64], theirs: &[f64]) -> Vec<f64> {
    // Negative display values are clipped in theirs, so they say nothing of the scale.
    let dot = |f: fn(f64, f64) -> f64| {
        ours.iter().zip(theirs).filter(|(_, t)| **t > 0.0).map(|(o, t)| f(*o, *t)).sum::<f64>()
    };
    let scale = dot(|o, t| o * t) / dot(|o, _| o * o);
    ours.iter().map(|o| (o * scale).clamp(0.0, 1.0)).collect()
}

#[test]
fn chart_patches_come_out_as_isetcams() {
    for id in ["nikonD100", "g6a"] {
        let (case, planes) = display_rgb(id, "mac");
        let centers = rows_of(&case["mac_noisefree"]["patch_centers_rc"]);
        let half = case["mac_noisefree"]["patch_delta"].as_u64().unwrap() as usize / 2;
        let mut ours = Vec::new();
        for (&row, &col) in centers[0].iter().zip(&centers[1]) {
            let (row, col) = (row as usize - 1, col as usize - 1);
            for p in planes.planes() {
                let line = |r: usize| &p[r * planes.cols() + col - half..=r * planes.cols() + col + half];
                let patch: Vec<f32> = (row - half..=row + half).flat_map(line).copied().collect();
                ours.push(patch.iter().map(|&v| f64::from(v)).sum::<f64>() / patch.len() as f64);
            }
        }
        let theirs = numbers(&case["mac_noisefree"]["lrgb"]);
        assert_close(id, &scaled_like(&ours, &theirs), &theirs, 1e-3);
    }
}

#[test]
fn edge_comes_out_as_isetcams() {
    for (id, largest, allowed_rms) in [
        ("nikonD100", 1e-5, 1e-6),
        // One draw of its random triangulation. A draw takes one of the two diagonals where ours takes their mean: on
        // a step, at a pixel inside the square, up to a third of the step in a channel.
        ("g6a", 0.34, 0.02),
    ] {
        let (case, planes) = display_rgb(id, "bar");
        let [col, row, width, height] = numbers(&case["mtf"]["rect"])[..] else { panic!("rect") };
        let (col, row, width, height) = (col as usize - 1, row as usize - 1, width as usize, height as usize);
        let at = |p: &[f32], r: usize, c: usize| f64::from(p[r * planes.cols() + c]);
        let ours: Vec<f64> = planes
            .planes()
            .flat_map(|p| {
                (row..=row + height).flat_map(move |r| (col..=col + width).map(move |c| at(p, r, c)))
            })
            .collect();
        let file = |k| reference_csv(&format!("bar_lrgb_{id}_ch{k}.csv")).concat();
        let theirs = [file(1), file(2), file(3)].concat();
        let ours = scaled_like(&ours, &theirs);
        let error = rms(ours.iter().zip(&theirs).map(|(o, t)| o - t));
        println!("{id}: RMS {error:.2e}");
        assert!(error < allowed_rms, "{id}: RMS {error:.2e}");
        assert_close(id, &ours, &theirs, largest);
    }
}
