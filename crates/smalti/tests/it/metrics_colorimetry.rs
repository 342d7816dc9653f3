//! Vora value, sensitivity metamerism index and metamer mismatch of sensors.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use proptest::prelude::*;
use serde_json::Value;
use smalti::camera::{Camera, CameraDescription, ColorimetricObserver};
use smalti::metrics::MetricError;
use smalti::metrics::iso17321::MetamerismIndex;
use smalti::metrics::logvinenko2014::MetamerMismatch;
use smalti::metrics::vora1993::vora_value;
use smalti::sensor::Filter;
use smalti::spectrum::{Illuminant, Observer, Spectrum, WavelengthGrid};

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

fn light() -> Spectrum {
    Illuminant::D65.photons(GRID).unwrap()
}

struct Figures {
    vora: f64,
    index: f64,
    mismatch: [f64; 3],
}

fn figures(channels: &[Spectrum]) -> Figures {
    Figures {
        vora: vora_value(channels).unwrap(),
        index: MetamerismIndex::new(&light()).unwrap().of(channels).unwrap(),
        mismatch: MetamerMismatch::new(&light()).unwrap().percent(channels).unwrap(),
    }
}

fn builtin(name: &str) -> Spectrum {
    Filter::Builtin(name.to_owned()).spectrum(GRID).unwrap()
}

/// The sensitivities of cameras, and a clear channel where named.
fn sensor(parts: &[&str]) -> Vec<Spectrum> {
    let channels = |part: &&str| match *part {
        "flat" => vec![Spectrum::constant(GRID, 1.0).unwrap()],
        camera => ["R", "G", "B"].iter().map(|c| builtin(&format!("{camera}/{c}"))).collect(),
    };
    parts.iter().flat_map(channels).collect()
}

/// Row after row of weights, a channel each.
fn mixed(channels: &[Spectrum], weights: &[f64]) -> Vec<Spectrum> {
    let mix = |row: &[f64]| {
        let at = |i: usize| channels.iter().zip(row).map(|(c, w)| w * c.values()[i]).sum();
        Spectrum::new(GRID, (0..GRID.len()).map(at).collect()).unwrap()
    };
    weights.chunks(channels.len()).map(mix).collect()
}

/// The colour matching functions per photon.
fn observer() -> Vec<Spectrum> {
    Observer::Cie1931.photon_weights(GRID).unwrap().to_vec()
}

#[test]
fn a_sensor_that_spans_the_matching_functions_is_ideal() {
    let rgb = mixed(&observer(), &[2.0, -0.5, -0.2, -1.0, 1.9, 0.05, 0.06, -0.2, 1.1]);
    // A fourth channel takes nothing away.
    let more = [&rgb[..], &sensor(&["imx219"])[..1]].concat();
    for channels in [observer(), rgb, more] {
        let found = figures(&channels);
        assert!((found.vora - 1.0).abs() < 1e-12, "{}", found.vora);
        assert!((found.index - 100.0).abs() < 1e-6, "{}", found.index);
        assert!(found.mismatch.iter().all(|m| *m < 1e-6), "{:?}", found.mismatch);
    }
}

/// A sensor with some of the matching functions, in any mixture, spans as many of their three dimensions: 1/3 and 2/3.
#[test]
fn each_matching_function_is_a_third_of_the_vora_value() {
    let functions = observer();
    for count in [1, 2] {
        let value = vora_value(&functions[..count]).unwrap();
        assert!((value - count as f64 / 3.0).abs() < 1e-9, "{count}: {value}");
    }
    let mixed = mixed(&functions, &[0.3, 0.7, 0.0]);
    assert!((vora_value(&mixed).unwrap() - 1.0 / 3.0).abs() < 1e-9);
}

/// A channel of constant sensitivity at all wavelengths but that of a narrow line: what it says of colour is known in closed form.
#[test]
fn a_sensor_of_one_line_knows_one_wavelength() {
    let line = |nm: f64| Spectrum::from_fn(GRID, |at| f64::from(u8::from(at == nm))).unwrap();
    let found = figures(&[line(550.0)]);
    // The share of the line in each matching function is all that a reflectance is known by.
    let weights = Observer::Cie1931.photon_weights(GRID).unwrap();
    for (found, w) in found.mismatch.iter().zip(&weights) {
        let seen = w.times(&light()).unwrap();
        let expected = 100.0 * (1.0 - seen.at(550.0).unwrap() / (seen.integral() / GRID.step_nm()));
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
    // All lines together see everything.
    let lines: Vec<Spectrum> = GRID.wavelengths_nm().map(line).collect();
    let all = figures(&lines);
    assert!((all.vora - 1.0).abs() < 1e-12 && all.mismatch.iter().all(|m| *m < 1e-6) && all.index > 99.99);
}

/// Against an independent computation by `tools/colorimetry.py`, of cameras of three to six channels.
#[test]
fn published_cameras_have_the_figures_of_an_independent_computation() {
    let text = include_str!("../data/colorimetry/expected.json");
    let cases: Vec<Value> = serde_json::from_str(text).unwrap();
    assert!(cases.len() >= 5);
    for case in &cases {
        let parts: Vec<&str> =
            case["filters"].as_array().unwrap().iter().map(|p| p.as_str().unwrap()).collect();
        let found = figures(&sensor(&parts));
        let expected = |key: &str| case[key].as_f64().unwrap();
        assert!((found.vora - expected("vora_value")).abs() < 1e-5, "{parts:?}: {}", found.vora);
        // The search of the script may end a little short of the largest index.
        let index = expected("sensitivity_metamerism_index");
        assert!(
            (found.index - index).abs() < 0.1 && found.index > index - 0.01,
            "{parts:?}: {}",
            found.index
        );
        for (found, expected) in
            found.mismatch.iter().zip(case["metamer_mismatch_percent"].as_array().unwrap())
        {
            let expected = expected.as_f64().unwrap();
            assert!((found / expected - 1.0).abs() < 1e-4, "{parts:?}: {found}, expected {expected}");
        }
    }
}

#[test]
fn a_further_channel_never_costs_anything() {
    let three = sensor(&["imx219"]);
    let four = [&three[..], &[builtin("pigment/G")]].concat();
    let (three, four) = (figures(&three), figures(&four));
    assert!(four.vora > three.vora && four.index >= three.index);
    assert!(four.mismatch.iter().zip(&three.mismatch).all(|(more, less)| *more <= less + 1e-9));
    // A channel that is a sum of others adds nothing.
    let rgb = sensor(&["imx219"]);
    let sum = mixed(&rgb, &[0.3, 0.5, 0.2]);
    let found = figures(&[&rgb[..], &sum].concat());
    assert!((found.vora - three.vora).abs() < 1e-9 && (found.index - three.index).abs() < 1e-3);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// A mixture of channels that can be undone changes no figure: the colour matrix undoes it.
    #[test]
    fn mixing_channels_changes_nothing(
        clear in any::<bool>(),
        weights in prop::collection::vec(-0.9f64..0.9, 16),
        scale in 1e-3f64..1e3,
    ) {
        let channels = if clear { sensor(&["sony-ilce-7rm2", "flat"]) } else { sensor(&["sony-ilce-7rm2"]) };
        let count = channels.len();
        // Rows whose diagonal outweighs the others are independent.
        let weight = |i: usize| if i.is_multiple_of(count + 1) { count as f64 * scale } else { weights[i % 16] * scale };
        let mixed = mixed(&channels, &(0..count * count).map(weight).collect::<Vec<_>>());
        let (own, other) = (figures(&channels), figures(&mixed));
        prop_assert!((own.vora - other.vora).abs() < 1e-9);
        prop_assert!((own.index - other.index).abs() < 1e-3, "{} {}", own.index, other.index);
        for (a, b) in own.mismatch.iter().zip(other.mismatch) {
            prop_assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
    }
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let coarse = Spectrum::constant(WavelengthGrid::new(400.0, 20.0, 16).unwrap(), 1.0).unwrap();
    let dark = Spectrum::constant(GRID, 0.0).unwrap();
    let index = MetamerismIndex::new(&light()).unwrap();
    let mismatch = MetamerMismatch::new(&light()).unwrap();
    for refused in [vora_value(&[]), index.of(&[]), mismatch.mean_percent(&[])] {
        assert!(matches!(refused, Err(MetricError::TooFew { .. })), "{refused:?}");
    }
    let one = std::slice::from_ref(&dark);
    for refused in [vora_value(one), index.of(one), mismatch.mean_percent(one)] {
        assert!(matches!(refused, Err(MetricError::Undefined { .. })), "{refused:?}");
    }
    let one = std::slice::from_ref(&coarse);
    for refused in [index.of(one), mismatch.mean_percent(one)] {
        assert!(matches!(refused, Err(MetricError::Spectrum(_))), "{refused:?}");
    }
    assert!(matches!(MetamerismIndex::new(&dark), Err(MetricError::Undefined { .. })));
    assert!(matches!(MetamerMismatch::new(&dark), Err(MetricError::Undefined { .. })));
}

/// The sensitivities of a camera include lens, infrared cut and photodiode.
#[test]
fn a_camera_is_scored_with_all_that_its_light_passes() {
    let observer = ColorimetricObserver::new(&light()).unwrap();
    let of = |change: &dyn Fn(&mut CameraDescription)| {
        let mut d = CameraDescription::default();
        change(&mut d);
        observer.colorimetry(&Camera::new(d, GRID).unwrap()).unwrap()
    };
    let own = of(&|_| ());
    assert!((0.0..=1.0).contains(&own.vora_value) && own.sensitivity_metamerism_index <= 100.0);
    assert_ne!(own, of(&|d| d.optics.ir_cut = Some(Filter::Builtin("hot-mirror".into()))));
    assert_ne!(own, of(&|d| d.sensor.quantum_efficiency = Filter::Flat(0.6)));
    // A darker lens changes nothing.
    let darker = of(&|d| d.optics.transmittance = Filter::Flat(0.25));
    assert!((darker.sensitivity_metamerism_index - own.sensitivity_metamerism_index).abs() < 1e-6);
}
