//! The small languages of the command line: scenes and arrays with parameters, illuminants.
#![no_main]

mod rarely;

use std::sync::LazyLock;

use smalti::scene::{MAX_VALUES, Setting, catalog};
use smalti::sensor::cfa;
use smalti::spectrum::{Illuminant, Spectrum, WavelengthGrid};

/// A natural reflectance, so that those of the ColorChecker are not asked for.
static NATURAL: LazyLock<[Spectrum; 1]> =
    LazyLock::new(|| [Spectrum::new(WavelengthGrid::VISIBLE, vec![0.5; 31]).expect("a reflectance")]);

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let _ = Illuminant::from_name(text);
    let _ = cfa::pattern(text);
    // With so many wavelengths every scene is too large, which is found when all its parameters have been read.
    let grid = WavelengthGrid::new(400.0, 1e-9, MAX_VALUES + 1).expect("a grid");
    assert!(catalog::build(text, &Setting { grid, ..Setting::default() }, &*NATURAL).is_err());
    // Scenes are slow to make, not wrong: one in 4096 is made, and none of more than a few thousand pixels.
    if rarely::one_in(4096, data) && text.chars().filter(char::is_ascii_digit).count() <= 4 {
        let _ = catalog::build(text, &Setting::default(), &[]);
    }
});
