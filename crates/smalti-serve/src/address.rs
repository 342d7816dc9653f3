//! Where a server is reached, and tokens.

use serde::{Deserialize, Serialize};

use crate::ServeError;

/// Bytes of a token, written as two hexadecimal digits each.
const TOKEN_BYTES: usize = 16;

/// Where a server is reached.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Address {
    /// The port of 127.0.0.1.
    pub port: u16,
    /// The token.
    pub token: String,
}

impl Address {
    /// Whether the token is one that [`LocalServer::bind`](crate::LocalServer::bind) makes.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        is_token(&self.token)
    }
}

/// Whether a text has the form of [`random_token`].
pub(crate) fn is_token(text: &str) -> bool {
    text.len() == 2 * TOKEN_BYTES && text.bytes().all(|b| b.is_ascii_hexdigit())
}

/// Random bytes as hexadecimal digits.
///
/// # Errors
/// [`ServeError::Random`].
pub(crate) fn random_token() -> Result<String, ServeError> {
    let mut bytes = [0; TOKEN_BYTES];
    getrandom::fill(&mut bytes).map_err(|_| ServeError::Random)?;
    Ok(bytes.iter().map(|b| format!("{b:02x}")).collect())
}
