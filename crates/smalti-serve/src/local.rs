//! The server: a port of 127.0.0.1 and a token.

use std::net::{Ipv4Addr, SocketAddr, TcpListener};

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::http::StatusCode;
use axum::middleware::from_fn_with_state;

use crate::ServeError;
use crate::address::{Address, random_token};
use crate::guard::{Guard, guard};

/// The largest body of a request, bytes.
const MOST_BYTES: usize = 4096;

/// A server before it runs.
#[derive(Debug)]
pub struct LocalServer {
    listener: TcpListener,
    address: Address,
}

impl LocalServer {
    /// Opens a port of 127.0.0.1: the given one, else that of the earlier address if it is free, else any. The token is that of the earlier
    /// address, so that pages that are open find the server again.
    ///
    /// # Errors
    /// When the given port is not free.
    pub fn bind(port: Option<u16>, earlier: Option<Address>) -> Result<Self, ServeError> {
        let earlier = earlier.filter(Address::is_valid);
        let open = |port: u16| TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port)));
        let listener = match (port, &earlier) {
            (Some(port), _) => open(port),
            (None, Some(earlier)) => open(earlier.port).or_else(|_| open(0)),
            (None, None) => open(0),
        };
        let listener = listener.map_err(|source| ServeError::Port { port: port.unwrap_or(0), source })?;
        let port = listener.local_addr().map_err(ServeError::Server)?.port();
        let token = match earlier {
            Some(earlier) => earlier.token,
            None => random_token()?,
        };
        Ok(Self { listener, address: Address { port, token } })
    }

    /// Where it is reached.
    #[must_use]
    pub fn address(&self) -> Address {
        self.address.clone()
    }

    /// The address for a browser.
    #[must_use]
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.address.port, self.address.token)
    }

    /// Serves pages below the token until the process ends.
    ///
    /// # Errors
    /// When the server fails.
    pub fn run(self, pages: Router) -> Result<(), ServeError> {
        let Self { listener, address } = self;
        let state = Guard::new(&address);
        let routes = Router::new()
            .nest("/{token}/", pages)
            .fallback(|| async { StatusCode::NOT_FOUND })
            .layer(DefaultBodyLimit::max(MOST_BYTES))
            .layer(from_fn_with_state(state, guard));
        // One thread answers; work on files is done by others.
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build();
        runtime.map_err(ServeError::Server)?.block_on(async {
            listener.set_nonblocking(true).map_err(ServeError::Server)?;
            let listener = tokio::net::TcpListener::from_std(listener).map_err(ServeError::Server)?;
            axum::serve(listener, routes).await.map_err(ServeError::Server)
        })
    }
}
