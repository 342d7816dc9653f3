//! Files of pages, embedded in the program.

use axum::Router;
use axum::http::header::CONTENT_TYPE;
use axum::response::IntoResponse;
use axum::routing::get;

/// A file: its path below the token, its type and its content.
pub(crate) struct Asset {
    pub(crate) path: &'static str,
    pub(crate) media_type: &'static str,
    pub(crate) content: &'static str,
}

/// A file of the folder `pages`, whose type follows from its extension.
macro_rules! asset {
    ($file:literal, $media_type:literal) => {
        $crate::pages::Asset {
            path: concat!("/", $file),
            media_type: $media_type,
            content: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/pages/", $file)),
        }
    };
}
pub(crate) use asset;

/// Routes of a page and its files.
pub(crate) fn routes<S: Clone + Send + Sync + 'static>(page: Asset, files: &'static [Asset]) -> Router<S> {
    let answer = |file: &Asset| {
        let (media_type, content) = (file.media_type, file.content);
        get(move || async move { ([(CONTENT_TYPE, media_type)], content).into_response() })
    };
    files
        .iter()
        .fold(Router::new().route("/", answer(&page)), |routes, file| routes.route(file.path, answer(file)))
}
