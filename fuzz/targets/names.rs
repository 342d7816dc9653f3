//! The small languages of the command line: scenes and arrays with parameters, illuminants.
#![no_main]

use smalti::scene::{Setting, catalog};
use smalti::sensor::cfa;
use smalti::spectrum::Illuminant;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let _ = Illuminant::from_name(text);
    let _ = cfa::pattern(text);
    // Pictures of more than a few thousand pixels are slow to make, not wrong.
    if text.chars().filter(char::is_ascii_digit).count() <= 4 {
        let _ = catalog::build(text, &Setting::default(), &[]);
    }
});
