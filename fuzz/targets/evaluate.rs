//! Cameras with changed values, through the whole of `smalti evaluate`: every figure of a camera that is accepted is a number, or absent.
#![no_main]

mod leaves;

use smalti::camera::{EvaluationSettings, evaluate};
use smalti_io::cameras;

/// Photosites of a sensor that is still evaluated. More are slow, not wrong.
const LARGEST: usize = 1 << 18;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((&light, rest)) = data.split_first() else { return };
    let Some(source) = leaves::changed(cameras::names(), rest) else { return };
    let settings = EvaluationSettings {
        luminance_cd_m2: (f64::from(light) / 16.0 - 8.0).exp2(),
        ..EvaluationSettings::default()
    };
    let camera = match cameras::from_source(&source, &[], None) {
        Ok(camera) => camera,
        Err(e) => return drop(e.to_string()),
    };
    if camera.description().sensor.rows * camera.description().sensor.cols > LARGEST {
        return;
    }
    match evaluate(&camera, &settings, &|_, make| make()) {
        Ok((scores, _)) => {
            let figures = toml::Value::try_from(&scores).expect("scores are tables of figures");
            assert!(is_finite(&figures), "{figures}");
        }
        Err(e) => drop(e.to_string()),
    }
});

/// TOML, unlike JSON, has numbers that are none.
fn is_finite(value: &toml::Value) -> bool {
    match value {
        toml::Value::Float(number) => number.is_finite(),
        toml::Value::Array(items) => items.iter().all(is_finite),
        toml::Value::Table(table) => table.values().all(is_finite),
        _ => true,
    }
}
