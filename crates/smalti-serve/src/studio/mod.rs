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

/// Files in the folder of the simulator that are still being gathered when serving begins. A request for one waits until [`set`](Self::set).
#[derive(Debug, Clone, Default)]
pub struct LateFiles(Arc<SetOnce<Result<Vec<PageFile>, String>>>);

impl LateFiles {
    /// Supplies the gathered files, or the reason why there are none, which the page shows. Only the first call has an effect. Requests for any other name in the
    /// folder are then answered by 404.
    pub fn set(&self, gathered: Result<Vec<StudioAsset>, String>) {
        // Only a second call fails.
        _ = self.0.set(gathered.map(|assets| assets.into_iter().map(PageFile::of_engine).collect()));
    }

    /// The answer to a request for a file at a path below the token.
    async fn answer(self, path: Uri) -> Result<impl IntoResponse, (StatusCode, String)> {
        let is_asked = |file: &&PageFile| path.path().strip_prefix('/') == Some(&file.path);
        match self.0.wait().await {
            Ok(files) => files
                .iter()
                .find(is_asked)
                .cloned()
                .map(answer)
                .ok_or_else(|| (StatusCode::NOT_FOUND, String::new())),
            Err(reason) => Err((StatusCode::INTERNAL_SERVER_ERROR, reason.clone())),
        }
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
