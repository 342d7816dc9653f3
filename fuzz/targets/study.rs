//! Studies: files that users write (TOML), and studies that were resolved before (JSON). Cameras, lights and filters that are named are
//! looked for where there are none. Of a resolved study, what stands behind a zero byte are its scenes in files.
#![no_main]

mod rarely;

use std::path::PathBuf;

use smalti_io::{TomlSource, studies};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let mut parts = data.splitn(2, |b| *b == 0);
    let Ok(text) = std::str::from_utf8(parts.next().unwrap_or_default()) else { return };
    let scenes = parts.next().unwrap_or_default();
    let done = if text.trim_start().starts_with('{') {
        studies::from_json("fuzz.json", text, scenes)
    // Scenes are slow to make, not wrong; and of files anywhere nothing is known.
    } else if text.contains("scenes") || text.contains("file") || text.contains('/') {
        return;
    // Filters that are fitted to a curve take a thousand times as long as others.
    } else if text.contains("rule") && !rarely::one_in(32, data) {
        return;
    } else {
        let source =
            TomlSource { name: "fuzz.toml".into(), folder: PathBuf::from("absent"), text: text.into() };
        studies::from_source(&source)
    };
    if let Err(e) = done {
        let _ = e.to_string();
    }
});
