//! The files of the studio.

use axum::body::Bytes;
use serde_json::json;
use smalti::design::live::LiveFamily;
use smalti_io::studio::StudioAsset;

use super::native;

/// The page.
pub(super) const PAGE: &str = "index.html";
/// The camera with which the page opens, a camera file.
pub const START: &str = "start.toml";
/// The camera with which it is compared at first, a camera file, if there is one.
pub const PINNED: &str = "pinned.toml";
/// What the page can ask for.
const OFFER: &str = "server.json";
/// The folder of the simulator and its data.
const ENGINE: &str = "engine";

/// The path of a file in the folder of the simulator.
pub(super) fn of_engine(name: &str) -> String {
    format!("{ENGINE}/{name}")
}

/// A file of the page.
#[derive(Debug, Clone)]
pub struct PageFile {
    /// Its path relative to the page, with `/` between folders.
    pub path: String,
    /// Its content.
    pub content: Bytes,
}

impl PageFile {
    /// A file in the folder of the simulator.
    pub(super) fn of_engine(asset: StudioAsset) -> Self {
        Self { path: of_engine(&asset.name), content: asset.bytes.into() }
    }

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

static EMBEDDED: [(&str, &[u8]); 42] = embedded![
    "bench.js",
    "design.js",
    "designs.js",
    "dom.js",
    "drawings.css",
    "engine-worker.js",
    "engine.js",
    "exchange.js",
    "fetched.js",
    "files.js",
    "filter-plot.js",
    "filters.js",
    "improve.js",
    "index.html",
    "kinds.js",
    "labels.js",
    "light-plot.js",
    "lights.js",
    "main.js",
    "mosaic.js",
    "native.js",
    "numbers.js",
    "opening.js",
    "own-files.js",
    "parts.css",
    "photographs.js",
    "picture.js",
    "report-page.js",
    "report.css",
    "report.js",
    "scores.js",
    "sensor.js",
    "shapes.js",
    "share.js",
    "store.js",
    "studio.css",
    "sweep.js",
    "theme.js",
    "thickness.js",
    "tile-drawing.js",
    "tokens.css",
    "work.js",
];

/// The library as WebAssembly, deflated: `tools/wasm/build` makes it.
static MODULE: &[u8] = include_bytes!("../../vendor/studio.wasm.deflate");

/// With what the page opens.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Opening {
    /// A camera file.
    pub camera: String,
    /// One that it is compared with.
    pub pinned: Option<String>,
    /// The family of which its filters were made, if it is known.
    pub family: Option<LiveFamily>,
}

/// The files of the page. `assets` are the gathered light of its scenes behind the lens of its camera, and the sources of other light. `is_served` says that a
/// server with [`routes`](super::routes) stands behind it.
#[must_use]
pub fn files(opening: &Opening, assets: Vec<StudioAsset>, is_served: bool) -> Vec<PageFile> {
    let pinned = opening.pinned.as_deref();
    let file = |path: &str, content: Bytes| PageFile { path: path.to_owned(), content };
    let embedded = EMBEDDED.iter().map(|&(path, content)| file(path, Bytes::from_static(content)));
    let camera = |path: &str, text: &str| file(path, text.to_owned().into());
    let cameras =
        std::iter::once(camera(START, &opening.camera)).chain(pinned.map(|text| camera(PINNED, text)));
    let offer = json!({
        "native": is_served.then_some(native::PATH),
        "most_message_bytes": native::MOST_MESSAGE_BYTES,
        "pinned": pinned.map(|_| PINNED),
        "version": env!("CARGO_PKG_VERSION"),
        "family": opening.family,
    });
    let offer = file(OFFER, offer.to_string().into());
    let module = file(&of_engine("studio.wasm.deflate"), Bytes::from_static(MODULE));
    embedded
        .chain(cameras)
        .chain([offer, module])
        .chain(assets.into_iter().map(PageFile::of_engine))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_the_page_is_embedded_and_has_a_type() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/pages/studio");
        let mut there: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        let mut known: Vec<String> = EMBEDDED.iter().map(|(path, _)| (*path).to_owned()).collect();
        there.sort();
        known.sort();
        assert_eq!(there, known);
        assert!(known.iter().any(|path| path == PAGE));
        let asset = StudioAsset { name: "scene.bin".into(), bytes: vec![1] };
        let opening = Opening { camera: "name = \"x\"".into(), ..Opening::default() };
        let files = files(&opening, vec![asset], true);
        let type_of = |path: &str| files.iter().find(|f| f.path == path).map(PageFile::media_type);
        assert_eq!(type_of("engine/scene.bin"), Some("application/octet-stream"));
        assert_eq!(type_of("main.js"), Some("text/javascript; charset=utf-8"));
        assert_eq!(type_of(OFFER), Some("application/json"));
        assert_eq!(type_of(START), Some("text/plain; charset=utf-8"));
    }
}
