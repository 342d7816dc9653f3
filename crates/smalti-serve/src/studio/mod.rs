//! The studio: the page on which a mosaic and its filters are drawn and their picture is seen.
//!
//! The page computes in the browser. The same files, written to a folder, work from any web server. Behind the server of the command, [`Native`] does
//! heavy work for it. The page opens with the camera in [`START`].

mod files;
pub mod native;

use std::sync::Arc;

use axum::Router;
use axum::body::Bytes;
use axum::http::header::{CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::routing::get;

use files::PAGE;
pub use files::{Opening, PINNED, PageFile, START, files};
pub use native::Native;

/// As for other pages, and the module of the simulator may be compiled.
const POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; \
                      worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The files of the page and the connection for heavy work, for [`LocalServer::run`](crate::LocalServer::run).
pub fn routes(files: Vec<PageFile>, native: Native) -> Router {
    files.into_iter().fold(native::routes(Arc::new(native)), |routes, file| {
        let path = if file.path == PAGE { "/".to_owned() } else { format!("/{}", file.path) };
        let headers = [(CONTENT_TYPE, file.media_type()), (CONTENT_SECURITY_POLICY, POLICY)];
        let content = match file.content {
            std::borrow::Cow::Borrowed(content) => Bytes::from_static(content),
            std::borrow::Cow::Owned(content) => Bytes::from(content),
        };
        routes.route(&path, get(move || async move { (headers, content) }))
    })
}
