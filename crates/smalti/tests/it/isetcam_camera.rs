//! End to end against ISETCam: same scenes, lens, pattern, filters, exposure times and scoring; every stage is ours.
//!
//! Deliberate differences, each below the tolerance (docs/validation.md has the figures): light is integrated over the
//! photodetector (ISETCam blurs with a Gaussian over the whole pixel), the working f-number includes the magnification,
//! negative X, Y, Z are kept (ISETCam sets them to zero), and for more than three channels missing samples are interpolated on
//! the exact lattice (ISETCam jitters it at random).
#![allow(missing_docs, clippy::unwrap_used)]

use crate::common;

use common::isetcam::{self, Case, GRID, image_of};
use common::{numbers, reference_csv, reference_json};
use smalti::color::difference::delta_e_76;
use smalti::color::display::Primaries;
use smalti::color::lab_from_xyz;
use smalti::color::matrix::apply;
use smalti::isp::{Classic, ColorConstraint, ColorFit, Demosaic, Isp, WhiteBalance};
use smalti::metrics::esfr::{EsfrOptions, ISETCAM_LUMINANCE_WEIGHTS, picture_sfr};
use smalti::metrics::luminance_noise::luminance_noise;
use smalti::metrics::{Rect, patch_means};
use smalti::numeric::Planes;
use smalti::optics::OpticalImage;
use smalti::sensor::{Aperture, AutoExposure, Exposure, NoiseMode, RawImage, Sensor};
use smalti::spectrum::{Observer, Spectrum};

const CASES: [&str; 7] = ["nikonD100", "isetRGB", "g3a", "g4a", "g5a", "g6a", "g7a"];

/// Raw numbers to X, Y, Z. ISETCam fits its matrix to the reflectances of the chart under its light.
fn pipeline(case: &Case) -> Classic {
    let spectrum = |v| Spectrum::new(GRID, v).unwrap();
    let reference = reference_json("scene_macbeth_d65.json");
    let light = spectrum(numbers(&reference["illuminant_photons_s_sr_m2_nm"]));
    let reflectances = reference_csv("macbeth_reflectance_400_10_700.csv");
    let reflectances: Vec<Spectrum> = reflectances.into_iter().map(spectrum).collect();
    let responses: Vec<Spectrum> = case.cfa.channels().iter().map(|c| c.transmittance.clone()).collect();
    let fit = ColorFit::new(&reflectances, &light, Observer::Cie1931).unwrap();
    let matrix = fit.matrix(&responses, ColorConstraint::None, 0.0).unwrap();
    Classic { white_balance: WhiteBalance::None, ..Classic::new(matrix) }
}

fn raw(case: &Case, sensor: &Sensor, image: &OpticalImage, target: &str) -> RawImage {
    sensor.capture(image, &case.exposure(target), NoiseMode::None, 1).unwrap()
}

/// Row vector times the transposed layout that the reference files use.
fn times(v: [f64; 3], m: &[f64]) -> [f64; 3] {
    std::array::from_fn(|j| (0..3).map(|i| v[i] * m[i * 3 + j]).sum())
}

#[test]
fn colour_of_the_chart_within_five_percent() {
    let spd = reference_csv("ip_display_spd_rgb_400_10_700.csv");
    let chart = image_of(&isetcam::chart());
    let reference = reference_json("scene_macbeth_d65.json");
    let ideal = numbers(&reference["ideal_XYZ_maxY100"]);
    let ideal: Vec<[f64; 3]> = ideal.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect();
    // XYZ of the display's primaries, up to a factor.
    let observer = reference_csv("xyz_1931_400_10_700.csv");
    let xyz_of_primary =
        |p: usize, k: usize| spd.iter().zip(&observer).map(|(s, o)| s[p] * o[k]).sum::<f64>();
    let display: Vec<f64> = (0..9).map(|i| xyz_of_primary(i / 3, i % 3)).collect();
    for id in CASES {
        let case = Case::new(id);
        let raw = raw(&case, &case.sensor("mac"), &chart, "mac");
        let picture = pipeline(&case).render(&raw).unwrap();
        let rects = patches(&case);
        let measured: Vec<[f64; 3]> =
            patch_means(picture.planes(), &rects).unwrap().iter().map(|m| [m[0], m[1], m[2]]).collect();
        let to_display = numbers(&case.json["M_xyz2display"]);
        let mean_delta_e = |xyz: &[[f64; 3]]| {
            let scale = 100.0 / xyz[3][1];
            let lab = |v: [f64; 3]| lab_from_xyz(v, ideal[3]);
            let each = xyz.iter().zip(&ideal).map(|(m, i)| delta_e_76(lab(m.map(|v| v * scale)), lab(*i)));
            each.sum::<f64>() / 24.0
        };
        // As ISETCam scores with its own display ("custom"): to display primaries, clipped, and back.
        let shown: Vec<[f64; 3]> =
            measured.iter().map(|&v| times(times(v, &to_display).map(|p| p.max(0.0)), &display)).collect();
        let expected = case.number("/mac_noisefree/custom/mean_dE1976");
        let (got, direct) = (mean_delta_e(&shown), mean_delta_e(&measured));
        eprintln!("{id}: ΔE76 {got:.4} through the display, {direct:.4} from XYZ; ISETCam {expected:.4}");
        assert!((got / expected - 1.0).abs() < 0.05, "{id}: ΔE76 {got:.4}, ISETCam {expected:.4}");
    }
}

/// The patches of the ColorChecker where ISETCam measures them, in its order: column by column.
fn patches(case: &Case) -> Vec<Rect> {
    let centers = numbers(&case.json["mac_noisefree"]["patch_centers_rc"]);
    let patch = |i: usize| Rect {
        row: centers[i] as usize - 13,
        col: centers[24 + i] as usize - 13,
        rows: 25,
        cols: 25,
    };
    (0..24).map(patch).collect()
}

/// MTF50 in cycles/mm of three planes in ISETCam's region.
fn mtf50_of(case: &Case, planes: &Planes) -> f64 {
    let rect = numbers(&case.json["mtf"]["rect"]);
    let rect = Rect {
        row: rect[1] as usize - 1,
        col: rect[0] as usize - 1,
        rows: rect[3] as usize + 1,
        cols: rect[2] as usize + 1,
    };
    let sfr = picture_sfr(planes, rect, &ISETCAM_LUMINANCE_WEIGHTS, &EsfrOptions::isetcam()).unwrap();
    sfr.luminance.mtf50_cy_per_mm(2.8e-6).unwrap()
}

/// MTF50 of a raw image as ISETCam's display shows it. X, Y, Z below `least_xyz` take that value first.
fn mtf50_shown(case: &Case, raw: &RawImage, least_xyz: f64) -> f64 {
    let picture = pipeline(case).render(raw).unwrap();
    let to_display = numbers(&case.json["M_xyz2display"]);
    let planes = picture.planes();
    let mut shown = Planes::zeros(planes.rows(), planes.cols(), 3);
    for i in 0..planes.plane_len() {
        let xyz = std::array::from_fn(|k| f64::from(planes.plane(k).unwrap()[i]).max(least_xyz));
        let rgb = times(xyz, &to_display);
        (0..3).for_each(|k| shown.plane_mut(k).unwrap()[i] = rgb[k].max(0.0) as f32);
    }
    mtf50_of(case, &shown)
}

/// With all noise, the mean of three captures; and on the demosaicked raw of the three-colour cameras. 3 % for the aperture as
/// without noise, and as much again as the three noisy results of ISETCam spread.
#[test]
fn resolution_with_noise_and_on_the_raw_channels() {
    let bar = isetcam::bar();
    let bar = image_of(&bar);
    for id in CASES {
        let case = Case::new(id);
        let capture =
            |noise, seed| case.sensor("bar").capture(&bar, &case.exposure("bar"), noise, seed).unwrap();
        let shown = |seed| mtf50_shown(&case, &capture(NoiseMode::All, seed), f64::NEG_INFINITY);
        let got = (1..=3).map(shown).sum::<f64>() / 3.0;
        let theirs = numbers(&case.json["mtf_noise2"]);
        let expected = theirs.iter().sum::<f64>() / 3.0;
        let spread = theirs.iter().fold(0.0f64, |m, v| m.max((v - expected).abs()));
        eprintln!("{id}: MTF50 with noise {got:.2} cy/mm, ISETCam {expected:.2} ± {spread:.2}");
        assert!((got - expected).abs() < 0.03 * expected + spread, "{id}: {got:.2}, ISETCam {expected:.2}");
        if let Some(expected) = case.json["ieISO12233_sensorspace"]["mtf50"].as_f64() {
            let channels = Demosaic::Bilinear.apply(&capture(NoiseMode::None, 1)).unwrap();
            let got = mtf50_of(&case, &channels);
            eprintln!("{id}: MTF50 of the raw channels {got:.2} cy/mm, ISETCam {expected:.2}");
            assert!((got / expected - 1.0).abs() < 0.03, "{id}: {got:.2}, ISETCam {expected:.2}");
        }
    }
}

/// Perfect XYZ, shown on one display and read as sRGB, is 4.85 ΔE off: why colour is scored from XYZ.
#[test]
fn reading_one_display_as_another_has_a_floor() {
    let floor = reference_json("ip_display_floor.json");
    let ideal = numbers(&reference_json("scene_macbeth_d65.json")["ideal_XYZ_maxY100"]);
    let ideal: Vec<[f64; 3]> = ideal.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect();
    let to_display = numbers(&Case::new("nikonD100").json["M_xyz2display"]);
    let xyz_from_rgb = Primaries::SRGB.xyz_from_rgb().unwrap();
    let read: Vec<[f64; 3]> =
        ideal.iter().map(|&v| apply(&xyz_from_rgb, times(v, &to_display).map(|p| p.max(0.0)))).collect();
    let scale = 100.0 / read[3][1];
    let lab = |v: [f64; 3]| lab_from_xyz(v, ideal[3]);
    let each = read.iter().zip(&ideal).map(|(r, i)| delta_e_76(lab(r.map(|v| v * scale)), lab(*i)));
    let got = each.sum::<f64>() / 24.0;
    let expected = floor["mean_dE1976_srgb_path"].as_f64().unwrap();
    // The sRGB matrix of ISETCam has four decimals.
    assert!((got / expected - 1.0).abs() < 2e-3, "{got}, ISETCam {expected}");
    let rgb_from_xyz = Primaries::SRGB.rgb_from_xyz().unwrap();
    let linear: Vec<f64> = ideal
        .iter()
        .flat_map(|v| apply(&rgb_from_xyz, v.map(|v| v / 100.0)).map(|c| c.clamp(0.0, 1.0)))
        .collect();
    let theirs = numbers(&reference_json("scene_macbeth_d65.json")["ideal_lrgb_clipped"]);
    common::assert_close("ideal linear sRGB", &linear, &theirs, 5e-4);
}

/// The edge behind the lens, and the same under ISETCam's aperture.
fn edge_images() -> [OpticalImage; 2] {
    let bar = image_of(&isetcam::bar());
    let blurred = isetcam::blurred_for_the_edge(&bar);
    [bar, blurred]
}

/// MTF50 of the edge without noise in cycles/mm, with the pixel's own aperture; and with ISETCam's, and negative X, Y, Z set to zero as
/// in ISETCam.
fn edge_mtf50(case: &Case, [bar, blurred]: &[OpticalImage; 2]) -> [f64; 2] {
    let sensor = case.sensor("bar");
    let mut point = sensor.clone();
    point.aperture = Aperture::Point;
    let of =
        |sensor: &Sensor, image, least_xyz| mtf50_shown(case, &raw(case, sensor, image, "bar"), least_xyz);
    [of(&sensor, bar, f64::NEG_INFINITY), of(&point, blurred, 0.0)]
}

/// 3 % for the aperture. Three colours have no random choice: with ISETCam's aperture and clipping 1e-3 is left for differences 2
/// and 3 of docs/validation.md in the lens (2.5e-4 reached).
#[test]
fn resolution_of_the_edge_within_three_percent() {
    let jitter = reference_json("mtf50_multichannel_jitter.json");
    let images = edge_images();
    for id in CASES {
        let case = Case::new(id);
        let [got, isetcam] = edge_mtf50(&case, &images);
        let (expected, spread) = match jitter.get(id) {
            Some(j) => (j["mean"].as_f64().unwrap(), j["std"].as_f64().unwrap()),
            None => (case.number("/mtf/mtf50_exact"), 0.0),
        };
        eprintln!(
            "{id}: MTF50 {got:.2} cy/mm ({isetcam:.2} with ISETCam's aperture and clipping); ISETCam {expected:.2} ± {spread:.2}"
        );
        if spread == 0.0 {
            assert!((isetcam / expected - 1.0).abs() < 1e-3, "{id}: {isetcam:.3}, ISETCam {expected:.3}");
        }
        assert!(
            (got - expected).abs() < 0.03 * expected + spread,
            "{id}: MTF50 {got:.2}, ISETCam {expected:.2} ± {spread:.2}"
        );
    }
}

/// ISETCam demosaicks more than three colours with one random triangulation per picture. Ours is the mean over triangulations, so
/// that the MTF50 of the mean of ISETCam's pictures is its counterpart, without an allowance for the spread of the draws. The
/// triangulation of `t5-irregular` is unique: with ISETCam's aperture and clipping 1e-3 is left, as with three colours (4e-4 reached).
#[test]
fn resolution_of_tiles_4x4_within_three_percent() {
    let images = edge_images();
    for case in Case::tiles_4x4() {
        let [got, isetcam] = edge_mtf50(&case, &images);
        let id = case.cfa.name();
        let [expected, draw, spread] =
            ["mtf50_of_mean_picture", "mean", "std"].map(|key| case.number(&format!("/mtf/{key}")));
        eprintln!(
            "{id}: MTF50 {got:.2} cy/mm ({isetcam:.2} with ISETCam's aperture and clipping); ISETCam {expected:.2} (one draw {draw:.2} ± {spread:.2})"
        );
        for mtf50 in [got, isetcam] {
            assert!((mtf50 / expected - 1.0).abs() < 0.03, "{id}: MTF50 {mtf50:.2}, ISETCam {expected:.2}");
        }
        assert_eq!(spread < 1e-5 * draw, id == "t5-irregular", "{id}: ± {spread}");
        if id == "t5-irregular" {
            assert!((isetcam / expected - 1.0).abs() < 1e-3, "{id}: {isetcam:.3}, ISETCam {expected:.3}");
        }
    }
}

/// The specular rule finds ISETCam's times. Patches are flat; the brightest point of the edge depends a little on the lens's
/// ringing and the pixel's aperture.
#[test]
fn exposure_times_within_a_thousandth() {
    let (chart, bar) = (isetcam::chart(), isetcam::bar());
    let rule = AutoExposure::Specular { fraction: 0.95 };
    for (target, image) in [("mac", image_of(&chart)), ("bar", image_of(&bar))] {
        for id in CASES {
            let case = Case::new(id);
            let got = rule.exposure_time(&case.sensor(target), &image, &Exposure::new(1.0)).unwrap();
            let expected = case.exposure(target).time_s;
            eprintln!("{id} {target}: {:.3} ms, ISETCam {:.3} ms", got * 1e3, expected * 1e3);
            assert!((got / expected - 1.0).abs() < 1e-3, "{id} {target}: {got} s, ISETCam {expected} s");
        }
    }
}

/// Luminance noise of the grey series with all noise, the mean of three captures as in ISETCam's. Six patches of 625 pixels
/// that demosaicking correlates leave a standard error of about 2 % on either side: 6 % is two of the difference. With more
/// than three colours ours is lower, never higher: it takes the mean over the triangulations of which ISETCam draws one, and a
/// mean over more samples carries less noise.
#[test]
fn luminance_noise_as_isetcams() {
    let chart = isetcam::chart();
    let image = image_of(&chart);
    for id in CASES {
        let case = Case::new(id);
        let isp = pipeline(&case);
        let greys: Vec<Rect> = patches(&case).into_iter().skip(3).step_by(4).collect();
        let percent = |seed| {
            let raw =
                case.sensor("mac").capture(&image, &case.exposure("mac"), NoiseMode::All, seed).unwrap();
            luminance_noise(isp.render(&raw).unwrap().planes(), 1, &greys).unwrap().mean_percent
        };
        let got = (1..=3).map(percent).sum::<f64>() / 3.0;
        let theirs = numbers(&case.json["mac_noise2"]["lumnoise_mean"]);
        let expected = theirs.iter().sum::<f64>() / theirs.len() as f64;
        eprintln!("{id}: luminance noise {got:.3} %, ISETCam {expected:.3} %");
        let lowest = if case.cfa.channels().len() > 3 { -0.20 } else { -0.06 };
        assert!((lowest..0.06).contains(&(got / expected - 1.0)), "{id}: {got} %, ISETCam {expected} %");
    }
}

/// ISETCam's grey world and white world are gains on X, Y, Z that give the mean of the picture, or of what is brighter than
/// 0.7 of its brightest Y, the chromaticity of D65. Ours balance elsewhere; but from our picture its gains follow.
/// What remains is in Z alone, the same 0.2 to 0.4 % in both: a white of slightly other blue than that of the scene's light.
#[test]
fn white_balance_gains_of_isetcam_follow_from_our_picture() {
    let reference = reference_json("scene_macbeth_d65.json");
    let d65 = numbers(&reference["illuminant_energy_W_sr_m2_nm"]);
    let observer = reference_csv("xyz_1931_400_10_700.csv");
    let white: [f64; 3] = std::array::from_fn(|k| d65.iter().zip(&observer).map(|(s, o)| s * o[k]).sum());
    let case = Case::new("nikonD100");
    let image = image_of(&isetcam::chart());
    let picture = pipeline(&case).render(&raw(&case, &case.sensor("mac"), &image, "mac")).unwrap();
    let planes = picture.planes();
    let brightest = planes.plane(1).unwrap().iter().copied().fold(0.0f32, f32::max);
    for (name, above) in [("gray_world", -1.0), ("white_world", 0.7 * brightest)] {
        let mean: [f64; 3] = std::array::from_fn(|k| {
            let of = planes.plane(k).unwrap().iter().zip(planes.plane(1).unwrap());
            of.filter(|(_, y)| **y > above).map(|(v, _)| f64::from(*v)).sum()
        });
        let gains: Vec<f64> = (0..3).map(|k| mean[0] / mean[k] * white[k] / white[0]).collect();
        let expected = numbers(&case.json["wb"][name]["D"]);
        let expected = [expected[0], expected[4], expected[8]];
        eprintln!("{name}: {gains:.4?}, ISETCam {expected:.4?}");
        common::assert_close(name, &gains[..2], &expected[..2], 5e-4);
        common::assert_close(name, &gains, &expected, 5e-3);
    }
}
