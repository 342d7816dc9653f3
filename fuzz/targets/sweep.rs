//! Studies with changed values, through the scoring of their first and last trials, as `smalti sweep --dry-run` does it.
#![no_main]

mod leaves;

use smalti::design::Sweep;
use smalti_io::studies;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some(source) = leaves::changed(studies::names(), data) else { return };
    let trials = match studies::from_source(&source) {
        Ok((trials, _)) => trials,
        Err(e) => return drop(e.to_string()),
    };
    let Some(last) = trials.len().checked_sub(1) else { return };
    let images = |_: &str, make: &dyn Fn() -> _| make();
    if let Err(e) = Sweep::new(&trials, &images).score_numbers(&[0, last], &|| true) {
        let _ = e.to_string();
    }
});
