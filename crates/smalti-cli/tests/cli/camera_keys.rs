//! Every key of a camera file states its range and holds it.

use serde_json::Value;
use smalti_io::npy;
use smalti_io::{Override, cameras};

use crate::Place;

const VALUES: [&str; 7] = ["0", "-1", "1e308", "1e-300", "nan", "inf", "text"];

/// Keys whose value is a text of any kind; what they name is looked for.
const TEXTS: [&str; 1] = ["name"];

struct Key {
    name: String,
    /// Numbers have one.
    range: Option<[f64; 2]>,
}

fn keys(place: &Place) -> Vec<Key> {
    let listed: Vec<Value> = serde_json::from_str(&place.ok("list camera-keys --json")).unwrap();
    let key = |v: &Value| {
        let name = v["key"].as_str().unwrap().to_owned();
        let range = v["range"].as_array().map(|r| [r[0].as_f64().unwrap(), r[1].as_f64().unwrap()]);
        assert!(range.is_some() || !v["default"].is_number(), "{name} is a number without a range");
        Key { name, range }
    };
    listed.iter().map(key).collect()
}

/// The settings without which a key has no meaning.
fn context(place: &Place, key: &str) -> Vec<Override> {
    let psf = format!("optics.psf={{ file = {:?}, spacing_um = 1.0 }}", place.path("psf.npy"));
    let filter = |form: &str| {
        let value = match form {
            "gaussian" => "{ center_nm = 550, sigma_nm = 50 }",
            "box" => "{ low_nm = 500, high_nm = 600 }",
            "raised_cosine" => "{ center_nm = 550, fwhm_nm = 100 }",
            "long_pass" | "short_pass" => "{ edge_nm = 550, width_nm = 10 }",
            "butterworth" => "{ center_nm = 550, fwhm_nm = 100, order = 4 }",
            "dye" => "{ bands = [] }",
            "samples" => "{ start_nm = 400, step_nm = 100, values = [1, 1, 1, 1] }",
            _ => return Vec::new(),
        };
        vec![format!("optics.transmittance={{ {form} = {value} }}")]
    };
    let settings = match key {
        k if k.starts_with("optics.psf") => vec!["optics.model=psf".into(), psf],
        k if k.starts_with("optics.zernike_um") => vec!["optics.model=zernike".into()],
        k if k.starts_with("optics.transmittance.") => filter(k.split('.').nth(2).unwrap()),
        k if k.starts_with("sensor.binning.") => {
            vec![
                "sensor.cfa.pattern=quad-bayer".into(),
                "sensor.binning={ side = 2, mode = \"charge\" }".into(),
            ]
        }
        k if k.starts_with("sensor.pixel.low_gain") => {
            vec!["sensor.pixel.low_conversion_gain_uv_per_e=50".into()]
        }
        _ => Vec::new(),
    };
    settings.iter().map(|s| s.parse().unwrap()).collect()
}

/// The error of a camera with a key set, if it is one.
fn refused(place: &Place, key: &str, value: &str) -> Option<String> {
    let set = match key {
        "optics.zernike_um" => "optics.zernike_um.4".to_owned(),
        "sensor.cfa.mixtures" => "sensor.cfa.mixtures.a.R".to_owned(),
        key => key.to_owned(),
    };
    let mut overrides = context(place, key);
    let of_mixture =
        ["sensor.cfa.pattern=[\"Ra\"]", "sensor.cfa.filters={ R = { flat = 1 }, G = { flat = 1 } }"];
    if key == "sensor.cfa.mixtures" {
        overrides.extend(of_mixture.map(|s| s.parse().unwrap()));
    }
    let loads = |overrides: &[Override]| cameras::load_with_notes("bayer", overrides, None).err();
    if let Some(error) = loads(&overrides).filter(|_| key != "sensor.cfa.mixtures") {
        panic!("{key} without a value: {error}");
    }
    overrides.push(format!("{set}={value}").parse().unwrap());
    loads(&overrides).map(|e| e.to_string())
}

#[test]
fn every_key_refuses_what_it_cannot_mean() {
    let place = Place::new();
    npy::write(&place.path("psf.npy"), &[31, 3, 3], &[1f32; 31 * 9]).unwrap();
    let keys = keys(&place);
    assert!(keys.iter().filter(|k| k.range.is_some()).count() > 60, "{}", keys.len());
    for Key { name, range } in &keys {
        for value in VALUES {
            let error = refused(&place, name, value);
            if let Some(error) = &error {
                assert!(error.len() < 3000 && !error.contains("0000000000"), "{name}={value}: {error}");
            }
            let number = value.parse::<f64>().ok();
            let may_be = match (number, range) {
                (None, _) => TEXTS.contains(&name.as_str()),
                (Some(number), Some([low, high])) => *low <= number && number <= *high,
                (Some(_), None) => false,
            };
            // A value within the range may contradict another key, which the error then names.
            match error {
                _ if may_be => {}
                None => panic!("{name}={value} is accepted"),
                Some(error) => assert!(error.contains(name.as_str()), "{name}={value} is not named: {error}"),
            }
        }
        // Beyond the ends.
        let Some([low, high]) = range else { continue };
        for wrong in [low - (high - low) / 2.0 - 1.0, high * 2.0 + 1.0] {
            let error = refused(&place, name, &format!("{wrong:?}"));
            assert!(error.is_some(), "{name}={wrong} is accepted, and its range is {low} to {high}");
        }
    }
}

/// The list, the reference and the messages state the same range.
#[test]
fn ranges_are_listed() {
    let place = Place::new();
    for (args, text) in [
        (&["list", "camera-keys"][..], "Range: 0.5 to 1000."),
        (&["list", "camera-keys", "--markdown"], "above 25. Range: -200 to 200."),
        (
            &["evaluate", "bayer", "--set", "optics.f_number=0.01"],
            "0.01 is out of range; expected 0.5 to 1000",
        ),
    ] {
        let run = place.run(args);
        assert!(run.out.contains(text) || run.err.contains(text), "{args:?}: {} {}", run.out, run.err);
    }
}
