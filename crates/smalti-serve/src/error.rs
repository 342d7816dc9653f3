//! Errors of the server.

use std::io;

use smalti_io::IoError;
use thiserror::Error;

/// Why the server does not start, or ends.
#[derive(Debug, Error)]
pub enum ServeError {
    /// The port cannot be had.
    #[error("port {port} of 127.0.0.1 cannot be opened: {source}; expected a free port (--port)")]
    Port {
        /// The port.
        port: u16,
        /// What the system says.
        source: io::Error,
    },
    /// The system gives no random numbers for a token.
    #[error("the system gives no random numbers for a token")]
    Random,
    /// The file that leads a browser to the page cannot be made.
    #[error("the temporary folder for the browser cannot be made: {0}")]
    Opening(io::Error),
    /// The server failed.
    #[error("the server failed: {0}")]
    Server(io::Error),
    /// A file of the experiment cannot be read or written.
    #[error(transparent)]
    Files(#[from] IoError),
}
