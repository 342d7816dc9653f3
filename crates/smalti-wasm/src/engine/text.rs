//! Designs as JSON, camera files, and what is built in.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde_json::{Value, json};
use smalti::camera::{CameraDescription, KEY_RANGES};
use smalti::metrics::{Relevance, smallest_relevant};
use smalti::sensor::cfa;
use smalti_io::{TomlSource, cameras, designs};

use super::EngineError;
use super::warnings::SATURATED_PERCENT;

/// Characters of the longest camera file.
const MAX_TEXT: usize = 1 << 20;

/// The scores of the page, by their names in the catalogue of metrics.
const SCORED: [&str; 12] = [
    "cpsnr_db",
    "pixel_delta_e_2000_mean",
    "pixel_delta_e_2000_p95",
    "scielab_mean",
    "mtf50_low_contrast_cy_per_px",
    "luminance_noise_percent",
    "saturated_percent",
    "photon_efficiency",
    "luminance_noise_gain",
    "vora_value",
    "sensitivity_metamerism_index",
    "condition_number",
];

/// The camera file of a design.
pub(super) fn toml(design: Value) -> Result<String, EngineError> {
    Ok(designs::own_camera_toml(&cameras::from_json(design)?)?)
}

/// The description in a camera file, as it states it.
pub(super) fn parse(text: &str) -> Result<CameraDescription, EngineError> {
    if text.len() > MAX_TEXT {
        return Err(EngineError::TooLong { bytes: text.len(), limit: MAX_TEXT });
    }
    let source = TomlSource { name: "camera.toml".into(), folder: PathBuf::new(), text: text.to_owned() };
    Ok(cameras::from_source_with_notes(&source, &[], None)?.stated)
}

/// The mosaics, filters and cameras that are built in, the ranges of the keys of camera files, the smallest relevant differences of the scores, and the share of the
/// samples beyond which a design clips noticeably.
pub(super) fn catalogue() -> Result<Value, EngineError> {
    let of_cfa = |info: &cfa::CfaInfo| -> Result<Value, EngineError> {
        let tile = cfa::pattern(info.name).map_err(smalti::camera::CameraError::from)?;
        let named = cfa::default_filters(info.name).map_err(smalti::camera::CameraError::from)?;
        let filters: BTreeMap<String, Value> =
            named.into_iter().map(|(letter, name)| (letter.to_string(), json!({"builtin": name}))).collect();
        Ok(json!({"name": info.name, "aliases": info.aliases, "tile": tile, "filters": filters}))
    };
    let cfas = cfa::names().iter().map(of_cfa).collect::<Result<Vec<_>, _>>()?;
    let filters: Vec<&str> = cfa::builtin_filters().iter().map(|f| f.name).collect();
    let camera = |file: &smalti_io::BuiltinFile| parse(file.toml);
    let cameras = cameras::names().iter().map(camera).collect::<Result<Vec<_>, _>>()?;
    let ranges: BTreeMap<&str, [f64; 2]> = KEY_RANGES.iter().map(|r| (r.key, [r.low, r.high])).collect();
    let relevance = |metric: &&'static str| match smallest_relevant(metric) {
        Relevance::Absolute(least) => (*metric, json!({"absolute": least})),
        Relevance::Relative(share) => (*metric, json!({"relative": share})),
    };
    let relevances: BTreeMap<&str, Value> = SCORED.iter().map(relevance).collect();
    Ok(json!({
        "cfas": cfas,
        "filters": filters,
        "cameras": cameras,
        "ranges": ranges,
        "relevances": relevances,
        "saturated_percent": SATURATED_PERCENT,
    }))
}
