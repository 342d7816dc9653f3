//! What every request must have, and what every answer states.

use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::address::Address;

/// Scripts, styles and requests of the own origin alone; pictures also from the memory of the page.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; base-uri 'none'; \
                      form-action 'none'; frame-ancestors 'none'";

/// The headers of every answer.
const HEADERS: [(&str, &str); 7] = [
    ("content-security-policy", POLICY),
    ("cache-control", "no-store"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
    ("referrer-policy", "no-referrer"),
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
];

/// What requests are compared with.
#[derive(Debug)]
pub(crate) struct Guard {
    token: String,
    /// The names by which this server may be called.
    hosts: [String; 2],
}

impl Guard {
    pub(crate) fn new(address: &Address) -> Arc<Self> {
        let hosts = ["127.0.0.1", "localhost"].map(|host| format!("{host}:{}", address.port));
        Arc::new(Self { token: address.token.clone(), hosts })
    }

    /// Why a request is refused.
    fn refusal(&self, method: &Method, path: &str, headers: &HeaderMap) -> Option<&'static str> {
        let text = |name: HeaderName| headers.get(name).map(|v| v.to_str().unwrap_or("\u{fffd}"));
        // Another name that leads to 127.0.0.1 would make a foreign page one of the own origin.
        if !text(header::HOST).is_some_and(|host| self.hosts.iter().any(|own| own == host)) {
            return Some("this host is not served");
        }
        let origin = text(header::ORIGIN);
        let is_own = |origin: &str| self.hosts.iter().any(|own| origin.strip_prefix("http://") == Some(own));
        // A WebSocket begins with a request that reads, but what follows commands. Browsers state the origin of every one.
        let is_read =
            (*method == Method::GET || *method == Method::HEAD) && !headers.contains_key(header::UPGRADE);
        if !origin.map_or(is_read, is_own) {
            return Some("requests of other origins are refused");
        }
        // Browsers state which page sends a request also where they state no origin. A file of this machine leads a window to the page.
        let fetch = |name: &'static str| text(HeaderName::from_static(name));
        let site = fetch("sec-fetch-site");
        let is_window =
            fetch("sec-fetch-mode") == Some("navigate") && fetch("sec-fetch-dest") == Some("document");
        if !(is_read && is_window || site.is_none_or(|site| site == "same-origin" || site == "none")) {
            return Some("requests of other sites are refused");
        }
        let token = path.strip_prefix('/').and_then(|path| path.split('/').next()).unwrap_or_default();
        (!is_same(token, &self.token)).then_some("the token of the address is wrong")
    }
}

/// Compares in a time that does not depend on where texts of equal length differ.
fn is_same(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |sum, (x, y)| sum | (x ^ y)) == 0
}

/// Refuses what does not come from the own page, and adds the headers.
pub(crate) async fn guard(State(own): State<Arc<Guard>>, request: Request, next: Next) -> Response {
    let refusal = own.refusal(request.method(), request.uri().path(), request.headers());
    let mut response = match refusal {
        Some(why) => (StatusCode::FORBIDDEN, why).into_response(),
        None => next.run(request).await,
    };
    for (name, value) in HEADERS {
        // A page may state a policy of its own.
        let header = response.headers_mut().entry(HeaderName::from_static(name));
        header.or_insert(HeaderValue::from_static(value));
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(method: Method, path: &str, headers: &[(&'static str, &str)]) -> Option<&'static str> {
        let address = Address { port: 8080, token: "00112233445566778899aabbccddeeff".into() };
        let map =
            headers.iter().map(|(n, v)| (HeaderName::from_static(n), HeaderValue::from_str(v).unwrap()));
        Guard::new(&address).refusal(&method, path, &map.collect())
    }

    #[test]
    fn only_the_own_page_with_the_token_is_admitted() {
        let path = "/00112233445566778899aabbccddeeff/api/answer";
        let (host, origin) = (("host", "127.0.0.1:8080"), ("origin", "http://127.0.0.1:8080"));
        assert_eq!(refusal(Method::GET, path, &[host]), None);
        assert_eq!(refusal(Method::POST, path, &[host, origin]), None);
        assert_eq!(refusal(Method::GET, path, &[host, origin, ("upgrade", "websocket")]), None);
        let (cross, navigates) = (("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate"));
        let window = ("sec-fetch-dest", "document");
        assert_eq!(refusal(Method::GET, path, &[host, cross, navigates, window]), None);
        assert_eq!(refusal(Method::POST, path, &[host, origin, ("sec-fetch-site", "same-origin")]), None);
        for (method, headers) in [
            (Method::GET, &[][..]),
            (Method::GET, &[("host", "evil.example:8080")]),
            (Method::GET, &[("host", "127.0.0.1:80")]),
            (Method::POST, &[host]),
            (Method::POST, &[host, ("origin", "null")]),
            (Method::GET, &[host, ("upgrade", "websocket")]),
            (Method::GET, &[host, ("upgrade", "websocket"), ("origin", "http://evil.example")]),
            (Method::POST, &[host, ("origin", "http://evil.example")]),
            (Method::GET, &[host, ("origin", "https://127.0.0.1:8080")]),
            (Method::GET, &[host, ("sec-fetch-site", "cross-site")]),
            (Method::GET, &[host, ("sec-fetch-site", "same-site")]),
            (Method::GET, &[host, cross, navigates, ("sec-fetch-dest", "iframe")]),
            (Method::GET, &[host, cross, ("sec-fetch-mode", "no-cors"), window]),
            (Method::POST, &[host, cross, navigates, window]),
            (Method::POST, &[host, origin, cross, navigates, window]),
        ] {
            assert!(refusal(method.clone(), path, headers).is_some(), "{method} {headers:?}");
        }
        for wrong in
            ["/", "", "//", "/00112233445566778899aabbccddeef", "/00112233445566778899aabbccddeefe/", "/../"]
        {
            assert_eq!(
                refusal(Method::GET, wrong, &[host]),
                Some("the token of the address is wrong"),
                "{wrong}"
            );
        }
    }
}
