//! Filter curves and quantum efficiency.
#![allow(clippy::unwrap_used, clippy::panic)]

use smalti::sensor::cfa::{AbsorptionBand, CfaError, Filter, builtin_filters};
use smalti::sensor::{QuantumEfficiency, silicon_absorption_per_m};
use smalti::spectrum::{Spectrum, SpectrumError, WavelengthGrid};

const VISIBLE: WavelengthGrid = WavelengthGrid::VISIBLE;

fn near_infrared() -> WavelengthGrid {
    WavelengthGrid::new(400.0, 10.0, 61).unwrap()
}

fn builtin(name: &str, grid: WavelengthGrid) -> Spectrum {
    Filter::Builtin(name.into()).spectrum(grid).unwrap()
}

fn close(got: f64, expected: f64, tolerance: f64) {
    assert!((got - expected).abs() <= tolerance, "got {got}, expected {expected} within {tolerance}");
}

#[test]
fn a_gaussian_has_its_area_and_its_width() {
    let filter = Filter::Gaussian { center_nm: 550.0, sigma_nm: 20.0, peak: 0.8 };
    let spectrum = filter.spectrum(WavelengthGrid::new(400.0, 1.0, 301).unwrap()).unwrap();
    // The sum of a smooth function is its integral but for the tails beyond 7.5 deviations.
    close(spectrum.integral(), 0.8 * 20.0 * (2.0 * std::f64::consts::PI).sqrt(), 1e-9);
    close(spectrum.at(570.0).unwrap(), 0.8 * (-0.5f64).exp(), 1e-15);
    assert_eq!(spectrum.max(), 0.8);
}

#[test]
fn a_box_keeps_its_area_wherever_its_edges_fall() {
    for low_nm in [445.0, 447.3, 450.0, 451.0, 452.5, 455.0] {
        for width in [3.0, 10.0, 61.7] {
            let filter = Filter::Box { low_nm, high_nm: low_nm + width, peak: 0.7 };
            close(filter.spectrum(VISIBLE).unwrap().integral(), 0.7 * width, 1e-9);
        }
    }
    let aligned = Filter::Box { low_nm: 495.0, high_nm: 515.0, peak: 1.0 }.spectrum(VISIBLE).unwrap();
    let lit: Vec<f64> = VISIBLE.wavelengths_nm().filter(|&nm| aligned.at(nm).unwrap() > 0.0).collect();
    assert_eq!(lit, [500.0, 510.0]);
    let half = Filter::Box { low_nm: 500.0, high_nm: 600.0, peak: 1.0 }.spectrum(VISIBLE).unwrap();
    assert_eq!(half.at(500.0), Some(0.5));
}

#[test]
fn raised_cosines_side_by_side_add_up() {
    let spectrum =
        |center_nm| Filter::RaisedCosine { center_nm, fwhm_nm: 50.0, peak: 0.9 }.spectrum(VISIBLE).unwrap();
    let (a, b) = (spectrum(500.0), spectrum(550.0));
    for nm in [500.0, 510.0, 520.0, 530.0, 540.0, 550.0] {
        close(a.at(nm).unwrap() + b.at(nm).unwrap(), 0.9, 1e-12);
    }
    assert_eq!(a.at(550.0), Some(0.0));
    assert_eq!(a.at(690.0), Some(0.0));
}

#[test]
fn edges_lie_where_they_should() {
    let (edge_nm, width_nm, peak) = (600.0, 5.0, 0.8);
    let long = Filter::LongPass { edge_nm, width_nm, peak }.spectrum(VISIBLE).unwrap();
    let short = Filter::ShortPass { edge_nm, width_nm, peak }.spectrum(VISIBLE).unwrap();
    for (l, s) in long.values().iter().zip(short.values()) {
        close(l + s, 0.8, 1e-12);
    }
    assert_eq!(long.at(600.0), Some(0.4));
    assert!(long.at(700.0).unwrap() > 0.79 && long.at(400.0).unwrap() < 1e-15);
    // Far from the edge nothing overflows.
    let steep = Filter::LongPass { edge_nm, width_nm: 1e-6, peak }.spectrum(VISIBLE).unwrap();
    assert_eq!((steep.at(590.0), steep.at(610.0)), (Some(0.0), Some(0.8)));

    let band = |order| {
        Filter::Butterworth { center_nm: 550.0, fwhm_nm: 40.0, peak: 1.0, order }.spectrum(VISIBLE).unwrap()
    };
    close(band(1).at(570.0).unwrap(), 0.5, 1e-12);
    close(band(8).at(530.0).unwrap(), 0.5, 1e-12);
    assert!(band(8).at(540.0) > band(1).at(540.0) && band(8).at(600.0) < band(1).at(600.0));
}

#[test]
fn dyes_follow_beer_and_lambert() {
    let band = |center_nm, absorbance| AbsorptionBand { center_nm, fwhm_nm: 80.0, absorbance };
    let dye = |bands: &[AbsorptionBand], peak, leakage| {
        Filter::Dye { bands: bands.to_vec(), peak, leakage }
            .spectrum(WavelengthGrid::new(400.0, 1.0, 301).unwrap())
            .unwrap()
    };
    // An absorbance of 1 passes a tenth; mixed, transmittances multiply; twice the dye squares them.
    let (yellow, magenta) = (dye(&[band(440.0, 1.0)], 1.0, 0.0), dye(&[band(540.0, 1.0)], 1.0, 0.0));
    close(yellow.at(440.0).unwrap(), 0.1, 1e-12);
    let (red, twice) =
        (dye(&[band(440.0, 1.0), band(540.0, 1.0)], 1.0, 0.0), dye(&[band(440.0, 2.0)], 1.0, 0.0));
    for (i, (r, t)) in red.values().iter().zip(twice.values()).enumerate() {
        close(*r, yellow.values()[i] * magenta.values()[i], 1e-12);
        close(*t, yellow.values()[i].powi(2), 1e-12);
    }
    // Half the absorbance half a width of frequency away: at λ₀ / (1 ± ½ fwhm / λ₀).
    let edge = dye(&[AbsorptionBand { center_nm: 500.0, fwhm_nm: 1000.0 / 9.0, absorbance: 1.0 }], 1.0, 0.0);
    close(edge.at(450.0).unwrap(), 10f64.powf(-0.5), 1e-12);
    // Light beside the dye stays; without a dye the glass is clear.
    let thick = dye(&[band(540.0, 100.0)], 0.9, 0.02);
    close(thick.at(540.0).unwrap(), 0.02, 1e-12);
    close(dye(&[], 0.9, 0.02).at(540.0).unwrap(), 0.9, 1e-12);
}

#[test]
fn impossible_parameters_are_refused() {
    let nan = f64::NAN;
    let dye = |center_nm, fwhm_nm, absorbance, leakage| Filter::Dye {
        bands: vec![AbsorptionBand { center_nm, fwhm_nm, absorbance }],
        peak: 0.9,
        leakage,
    };
    for filter in [
        Filter::Flat(1.1),
        Filter::Flat(-0.1),
        Filter::Flat(nan),
        Filter::Gaussian { center_nm: 550.0, sigma_nm: 0.0, peak: 1.0 },
        Filter::Gaussian { center_nm: 550.0, sigma_nm: nan, peak: 1.0 },
        Filter::Gaussian { center_nm: -550.0, sigma_nm: 10.0, peak: 1.0 },
        Filter::Gaussian { center_nm: 550.0, sigma_nm: 10.0, peak: 1.5 },
        Filter::Box { low_nm: 500.0, high_nm: 500.0, peak: 1.0 },
        Filter::Box { low_nm: 500.0, high_nm: f64::INFINITY, peak: 1.0 },
        Filter::Box { low_nm: nan, high_nm: 500.0, peak: 1.0 },
        Filter::RaisedCosine { center_nm: 550.0, fwhm_nm: -1.0, peak: 1.0 },
        Filter::LongPass { edge_nm: 550.0, width_nm: f64::INFINITY, peak: 1.0 },
        Filter::ShortPass { edge_nm: 0.0, width_nm: 5.0, peak: 1.0 },
        Filter::Butterworth { center_nm: 550.0, fwhm_nm: 40.0, peak: 1.0, order: 0 },
        Filter::Butterworth { center_nm: 550.0, fwhm_nm: 40.0, peak: 1.0, order: 101 },
        dye(550.0, 40.0, -0.1, 0.0),
        dye(550.0, 40.0, 101.0, 0.0),
        dye(550.0, 0.0, 1.0, 0.0),
        dye(0.0, 40.0, 1.0, 0.0),
        dye(550.0, 40.0, 1.0, 0.95),
        dye(550.0, 40.0, nan, 0.0),
    ] {
        assert!(matches!(filter.spectrum(VISIBLE), Err(CfaError::Parameter { .. })), "{filter:?}");
    }
}

#[test]
fn descriptions_are_strict() {
    let read = |text: &str| serde_json::from_str::<Filter>(text);
    assert_eq!(
        read(r#"{"gaussian": {"center_nm": 610, "sigma_nm": 40, "peak": 0.9}}"#).unwrap(),
        Filter::Gaussian { center_nm: 610.0, sigma_nm: 40.0, peak: 0.9 }
    );
    assert_eq!(read(r#"{"flat": 0.95}"#).unwrap(), Filter::Flat(0.95));
    assert_eq!(read(r#"{"builtin": "nikon-d5100/B"}"#).unwrap(), Filter::Builtin("nikon-d5100/B".into()));
    assert_eq!(
        read(r#"{"gaussian": {"center_nm": 610, "sigma_nm": 40}}"#).unwrap(),
        Filter::Gaussian { center_nm: 610.0, sigma_nm: 40.0, peak: 1.0 }
    );
    assert!(read(r#"{"gaussian": {"center_nm": 610, "peak": 0.9}}"#).is_err());
    assert!(read(r#"{"gaussian": {"center_nm": 610, "sigma_nm": 40, "peak": 0.9, "x": 1}}"#).is_err());
    assert!(read(r#"{"bell": 1}"#).is_err());
}

#[test]
fn every_named_filter_is_a_transmittance_on_any_grid() {
    let mut names: Vec<&str> = builtin_filters().iter().map(|f| f.name).collect();
    for grid in [VISIBLE, near_infrared(), WavelengthGrid::new(380.0, 5.0, 81).unwrap()] {
        for name in &names {
            let spectrum = builtin(name, grid);
            assert!(spectrum.values().iter().all(|v| (0.0..=1.0).contains(v)), "{name}");
        }
    }
    let all = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), all);
}

#[test]
fn a_name_that_is_not_there_is_answered_with_the_nearest() {
    let error = Filter::Builtin("nikon-d5100/r".into()).spectrum(VISIBLE).unwrap_err();
    assert!(error.to_string().contains("no built-in filter is called 'nikon-d5100/r'"), "{error}");
    assert!(error.to_string().contains("did you mean 'nikon-d5100/R'?"), "{error}");
    for bad in ["band-0-of-9", "band-10-of-9", "band-1-of-65", "band-x-of-9", "band-1-of-", ""] {
        let result = Filter::Builtin(bad.into()).spectrum(VISIBLE);
        assert!(matches!(result, Err(CfaError::UnknownName { .. })), "{bad}");
    }
}

#[test]
fn generic_primaries_share_the_light() {
    for grid in [VISIBLE, near_infrared()] {
        let [r, g, b, c, m, y] =
            ["red", "green", "blue", "cyan", "magenta", "yellow"].map(|n| builtin(n, grid));
        for i in 0..grid.len() {
            let at = |s: &Spectrum| s.values()[i];
            assert!(at(&r) + at(&g) + at(&b) <= 0.9 + 1e-12);
            close(at(&c), at(&g) + at(&b), 1e-12);
            close(at(&m), at(&r) + at(&b), 1e-12);
            close(at(&y), at(&r) + at(&g), 1e-12);
        }
        // On the infrared side nothing is left of them.
        assert!(r.at(700.0).unwrap() < 0.04);
    }
    let infrared = builtin("infrared", near_infrared());
    assert!(infrared.at(700.0).unwrap() < 1e-3 && infrared.at(850.0).unwrap() > 0.89);
    assert!(builtin("green+infrared", near_infrared()).at(850.0).unwrap() > 0.89);
    assert!(builtin("green", near_infrared()).at(850.0).unwrap() < 1e-9);
}

#[test]
fn bands_side_by_side_meet_at_half_their_peak() {
    let [a, b] = ["band-4-of-10", "band-5-of-10"].map(|n| builtin(n, VISIBLE));
    // Ten bands of 30 nm from 400 nm: the fourth and fifth meet at 520 nm.
    close(a.at(520.0).unwrap(), 0.45, 1e-9);
    close(b.at(520.0).unwrap(), 0.45, 1e-9);
}

#[test]
fn measured_cameras_are_those_published() {
    // Maxima and some values of the data of Darrodi et al. (2015).
    for (name, peak_nm, at_nm, value) in [
        ("nikon-d5100/R", 595.0, 600.0, 0.9631),
        ("nikon-d5100/G", 530.0, 500.0, 0.6165),
        ("nikon-d5100/B", 460.0, 500.0, 0.5671),
        ("sigma-sd-merrill/R", 630.0, 550.0, 0.4449),
        ("sigma-sd-merrill/G", 590.0, 550.0, 0.9573),
        ("sigma-sd-merrill/B", 480.0, 550.0, 0.8679),
    ] {
        let spectrum = builtin(name, WavelengthGrid::new(380.0, 5.0, 125).unwrap());
        assert_eq!(spectrum.at(peak_nm), Some(1.0), "{name}");
        close(spectrum.at(at_nm).unwrap(), value, 5e-5);
        assert_eq!(spectrum.at(1000.0), Some(0.0));
    }
}

#[test]
fn silicon_absorbs_as_others_have_measured() {
    let alpha = silicon_absorption_per_m(WavelengthGrid::new(300.0, 10.0, 91).unwrap()).unwrap();
    // Up to 500 nm Green and Keevers (1995), above it Schinke et al. (2015, at 295 K), whose own uncertainty is larger
    // than the difference.
    for (nm, per_cm) in [
        (300.0, 1.73e6),
        (350.0, 1.04e6),
        (400.0, 9.52e4),
        (430.0, 3.92e4),
        (500.0, 1.11e4),
        (650.0, 2793.0),
        (700.0, 1907.0),
        (750.0, 1276.0),
    ] {
        let got = alpha.at(nm).unwrap() / 100.0;
        assert!((got / per_cm - 1.0).abs() < 0.03, "{nm} nm: {got} against {per_cm} cm⁻¹");
    }
    assert_eq!(silicon_absorption_per_m(WavelengthGrid::new(1250.0, 10.0, 2).unwrap()).unwrap().max(), 0.0);
    let deep_uv = WavelengthGrid::new(290.0, 10.0, 3).unwrap();
    assert!(matches!(silicon_absorption_per_m(deep_uv), Err(SpectrumError::Coverage { .. })));
}

#[test]
fn quantum_efficiency_has_its_limits() {
    let curve = |qe: QuantumEfficiency| qe.spectrum(near_infrared()).unwrap();
    assert!(curve(QuantumEfficiency::Ideal).values().iter().all(|&v| v == 1.0));
    assert!(curve(QuantumEfficiency::Flat(0.6)).values().iter().all(|&v| v == 0.6));
    let silicon =
        |depth_m, dead_layer_m| QuantumEfficiency::Silicon { depth_m, dead_layer_m, transmission: 0.8 };
    // Deep silicon collects all that enters; thin silicon in proportion to its depth; a dead layer costs blue most.
    close(curve(silicon(1.0, 0.0)).at(900.0).unwrap(), 0.8, 1e-12);
    let alpha = silicon_absorption_per_m(near_infrared()).unwrap().at(900.0).unwrap();
    close(curve(silicon(1e-9, 0.0)).at(900.0).unwrap() / (0.8 * alpha * 1e-9), 1.0, 1e-4);
    let lost = |nm| curve(silicon(1.0, 1e-7)).at(nm).unwrap() / 0.8;
    assert!(lost(400.0) < 0.5 && lost(700.0) > 0.97);

    let typical = curve(QuantumEfficiency::SILICON);
    assert!(typical.values().iter().all(|v| (0.0..=1.0).contains(v)));
    close(typical.at(500.0).unwrap(), 0.816, 5e-3);
    close(typical.at(850.0).unwrap(), 0.145, 5e-3);
}

#[test]
fn impossible_photodiodes_are_refused() {
    let silicon = |depth_m, dead_layer_m, transmission| QuantumEfficiency::Silicon {
        depth_m,
        dead_layer_m,
        transmission,
    };
    for qe in [
        QuantumEfficiency::Flat(1.01),
        QuantumEfficiency::Flat(f64::NAN),
        silicon(0.0, 0.0, 1.0),
        silicon(f64::INFINITY, 0.0, 1.0),
        silicon(1e-6, -1e-9, 1.0),
        silicon(1e-6, f64::NAN, 1.0),
        silicon(1e-6, 0.0, 1.1),
    ] {
        assert!(matches!(qe.spectrum(VISIBLE), Err(SpectrumError::Parameter { .. })), "{qe:?}");
    }
}

#[test]
fn published_curves_are_those_published() {
    let fine = WavelengthGrid::new(380.0, 5.0, 125).unwrap();
    for (name, nm, value, tolerance) in [
        // The traces in percent, relative to their largest value.
        ("imx219/R", 595.0, 97.078_233 / 99.457_3, 1e-4),
        ("imx219/G", 550.0, 88.047_229 / 99.457_3, 1e-4),
        ("imx219/B", 480.0, 72.044_536 / 99.457_3, 1e-4),
        ("ov5647/R", 605.0, 83.021_33 / 100.031_8, 1e-4),
        ("ov5647/B", 460.0, 96.525_58 / 100.031_8, 1e-4),
        // rawtoaces-data.
        ("sony-ilce-7rm2/R", 590.0, 0.581_007_79, 1e-4),
        ("sony-ilce-7rm2/B", 465.0, 0.854_527_37, 1e-4),
        ("canon-eos-5d-mark-ii/R", 600.0, 0.5136, 1e-9),
        ("canon-eos-5d-mark-ii/B", 460.0, 0.8515, 1e-9),
        // Points of the traces; those of cyan and yellow are interpolated.
        ("kodak-dcs620x/C", 540.0, 0.2628, 0.0005),
        ("kodak-dcs620x/M", 640.0, 0.3469, 0.001),
        ("kodak-dcs620x/Y", 600.0, 0.3887, 0.001),
        // The figure of the datasheet, to its line width.
        ("cmv12000/mono", 555.0, 0.465, 0.0035),
        ("cmv12000/R", 605.0, 0.392, 0.0035),
        ("cmv12000/B", 460.0, 0.390, 0.0035),
        // Extrema that the report prints as absorbances.
        ("hot-mirror", 405.0, 10f64.powf(-7.0373e-2), 0.005),
        ("hot-mirror", 500.0, 10f64.powf(-2.6536e-2), 0.005),
        ("hot-mirror", 555.0, 10f64.powf(-4.2524e-3), 0.005),
        ("hot-mirror", 785.0, 10f64.powf(-3.0391), 1e-4),
    ] {
        close(builtin(name, fine).at(nm).unwrap(), value, tolerance);
    }
    for camera in ["imx219", "ov5647", "sony-ilce-7rm2", "canon-eos-5d-mark-ii"] {
        let curves = ["R", "G", "B"].map(|c| builtin(&format!("{camera}/{c}"), fine));
        assert_eq!(curves[1].max(), 1.0, "{camera}");
        assert!(curves.iter().all(|c| c.at(900.0) == Some(0.0)), "{camera}");
    }
}

#[test]
fn pigments_on_the_monochrome_device_give_the_colour_device() {
    let mono = builtin("cmv12000/mono", VISIBLE);
    for channel in ["R", "G", "B"] {
        let pigment = builtin(&format!("pigment/{channel}"), VISIBLE);
        let color = builtin(&format!("cmv12000/{channel}"), VISIBLE);
        // Interference fringes of the two devices remain; without pigments the curves differ by 0.45.
        for ((nm, t), (m, c)) in
            VISIBLE.wavelengths_nm().zip(pigment.values()).zip(mono.values().iter().zip(color.values()))
        {
            assert!((t * m - c).abs() < 0.03, "{channel} at {nm} nm: {} and {c}", t * m);
        }
    }
    // Half transmission: blue to green near 500 nm, green to red near 580 nm, as in the cameras' curves.
    let [r, g, b] = ["R", "G", "B"].map(|c| builtin(&format!("pigment/{c}"), VISIBLE));
    assert!(g.at(490.0) < b.at(490.0) && g.at(510.0) > b.at(510.0));
    assert!(r.at(570.0) < g.at(570.0) && r.at(600.0) > g.at(600.0));
}

#[test]
fn a_hot_mirror_cuts_what_silicon_would_see() {
    let grid = WavelengthGrid::new(380.0, 1.0, 621).unwrap();
    let mirror = builtin("hot-mirror", grid);
    let half = |from: f64, rises: bool| {
        let at = |nm: &f64| (mirror.at(*nm).unwrap() >= 0.5) == rises;
        (0..250).map(|i| from + f64::from(i)).find(at).unwrap()
    };
    close(half(380.0, true), 392.0, 1.5);
    close(half(500.0, false), 644.0, 1.5);
    assert!((420..=620).all(|nm| mirror.at(f64::from(nm)).unwrap() > 0.91));
    assert!((680..=1000).all(|nm| mirror.at(f64::from(nm)).unwrap() < 0.02));
}
