//! The studio: the page on which a mosaic and its filters are drawn and their picture is seen.
//!
//! The page computes in the browser. The same files, written to a folder, work from any web server. Behind the server of the command, [`Native`] does
//! heavy work for it. The page opens with the camera in [`START`].

mod files;
pub mod native;

use std::sync::Arc;

use axum::Router;
use axum::http::header::{CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::http::{StatusCode, Uri};
use axum::response::IntoResponse;
use axum::routing::get;
use smalti_io::studio::StudioAsset;
use tokio::sync::SetOnce;

use files::PAGE;
pub use files::{Opening, PINNED, PageFile, START, files};
pub use native::Native;

/// As for other pages, and the module of the simulator may be compiled.
const POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; \
                      worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Files of the page that are gathered while it is served: those in the folder of the simulator that [`routes`] was not given. Requests for them wait.
#[derive(Debug, Clone, Default)]
pub struct LateFiles(Arc<SetOnce<Vec<PageFile>>>);

impl LateFiles {
    /// Hands the files over that were gathered, at the first call. Requests for others in the folder are then answered by "not found".
    pub fn set(&self, assets: Vec<StudioAsset>) {
        // Only a second call fails.
        _ = self.0.set(assets.into_iter().map(PageFile::of_engine).collect());
    }

    /// The answer to a request for a file at a path below the token.
    async fn answer(self, path: Uri) -> Result<impl IntoResponse, StatusCode> {
        let is_asked = |file: &&PageFile| path.path().strip_prefix('/') == Some(&file.path);
        let file = self.0.wait().await.iter().find(is_asked);
        file.cloned().map(answer).ok_or(StatusCode::NOT_FOUND)
    }
}

/// The files of the page and the connection for heavy work, for [`LocalServer::run`](crate::LocalServer::run).
pub fn routes(files: Vec<PageFile>, late: LateFiles, native: Native) -> Router {
    let late = |path: Uri| late.answer(path);
    let others =
        native::routes(Arc::new(native)).route(&format!("/{}", files::of_engine("{name}")), get(late));
    files.into_iter().fold(others, |routes, file| {
        let path = if file.path == PAGE { "/".to_owned() } else { format!("/{}", file.path) };
        routes.route(&path, get(move || async move { answer(file) }))
    })
}

/// A file of the page.
fn answer(file: PageFile) -> impl IntoResponse {
    ([(CONTENT_TYPE, file.media_type()), (CONTENT_SECURITY_POLICY, POLICY)], file.content)
}
