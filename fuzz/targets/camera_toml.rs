//! Camera files and `--set` overrides: the text up to a camera, without the files that it names.
#![no_main]

use std::path::PathBuf;

use smalti::camera::Camera;
use smalti::spectrum::WavelengthGrid;
use smalti_io::{Override, TomlSource};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let source = TomlSource { name: "fuzz.toml".into(), folder: PathBuf::new(), text: text.into() };
    let overrides: Vec<Override> = text.lines().take(3).filter_map(|l| l.parse().ok()).collect();
    for overrides in [&[][..], &overrides] {
        match source.describe(overrides) {
            // Large random tiles are slow to make, not wrong.
            Ok(d) if format!("{:?}", d.sensor.cfa.pattern).contains("random") => {}
            Ok(d) => drop(Camera::new(d, WavelengthGrid::VISIBLE).map_err(|e| e.to_string())),
            Err(e) => drop(e.to_string()),
        }
    }
});
