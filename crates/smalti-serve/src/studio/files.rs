//! The files of the studio.

use std::borrow::Cow;

use super::{PAGE, START};

/// A file of the page.
#[derive(Debug, Clone)]
pub struct PageFile {
    /// Its path relative to the page, with `/` between folders.
    pub path: String,
    /// Its content.
    pub content: Cow<'static, [u8]>,
}

impl PageFile {
    /// Its media type, which follows from its extension.
    pub(super) fn media_type(&self) -> &'static str {
        match self.path.rsplit_once('.').map_or("", |(_, extension)| extension) {
            "html" => "text/html; charset=utf-8",
            "css" => "text/css; charset=utf-8",
            "js" => "text/javascript; charset=utf-8",
            "json" => "application/json",
            "toml" => "text/plain; charset=utf-8",
            _ => "application/octet-stream",
        }
    }
}

/// Files of the folder `pages/studio`.
macro_rules! embedded {
    ($($file:literal),* $(,)?) => {
        [$((
            $file,
            include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/pages/studio/", $file)) as &'static [u8],
        )),*]
    };
}

static EMBEDDED: [(&str, &[u8]); 20] = embedded![
    "design.js",
    "dom.js",
    "engine-worker.js",
    "engine.js",
    "files.js",
    "filters.js",
    "improve.js",
    "index.html",
    "main.js",
    "mosaic.js",
    "parts.css",
    "picture.js",
    "scores.js",
    "sensor.js",
    "shapes.js",
    "share.js",
    "store.js",
    "studio.css",
    "theme.js",
    "work.js",
];

/// All files of the page, which opens with the camera of a camera file.
#[must_use]
pub fn files(start: &str) -> Vec<PageFile> {
    debug_assert!(EMBEDDED.iter().any(|(path, _)| *path == PAGE));
    let embedded = EMBEDDED.iter().map(|&(path, content)| (path.to_owned(), Cow::Borrowed(content)));
    let start = (START.to_owned(), Cow::Owned(start.as_bytes().to_vec()));
    embedded.chain([start]).map(|(path, content)| PageFile { path, content }).collect()
}
