//! Heavy work of the studio: the page asks over a WebSocket, the library works with all processors.
//!
//! The experiments are those of the command: a table is that of `smalti train`, a capture that of `smalti simulate`, a search that of `smalti design`, a
//! report that of `smalti compare`, a sweep scores a design over light and deviations of its filters. The page sends designs and names of scenes; no message names a file.

mod capture;
mod design;
mod error;
mod jobs;
mod material;
mod message;
mod report;
mod search;
mod socket;
mod sweep;
mod watch;

use std::sync::Arc;

use axum::Router;
use axum::routing::any;

pub use error::JobError;
pub use material::Native;
pub use message::{Capture, Job, MOST_MESSAGE_BYTES, MessageError, Report, Request, Search, Sweep};

/// The path of the connection, below the token.
pub(super) const PATH: &str = "native";

/// The connection, for pages below the token.
pub(super) fn routes(native: Arc<Native>) -> Router {
    Router::new().route(&format!("/{PATH}"), any(socket::connect)).with_state(native)
}
