//! The requests of the page.

use std::sync::{Arc, Mutex, PoisonError};

use axum::Router;
use axum::body::Bytes;
use axum::extract::{Path, State};
use axum::http::header::{AUTHORIZATION, CONTENT_TYPE};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::experiment::{Experiment, Refused};
use crate::ServeError;
use crate::pages::{self, Asset, asset};

type Shared = Arc<Mutex<Experiment>>;

const PAGE: Asset = asset!("rating.html", "text/html; charset=utf-8");
const FILES: &[Asset] = &[
    asset!("rating.css", "text/css; charset=utf-8"),
    asset!("rating.js", "text/javascript; charset=utf-8"),
    asset!("server.js", "text/javascript; charset=utf-8"),
    asset!("display.js", "text/javascript; charset=utf-8"),
    asset!("observers.js", "text/javascript; charset=utf-8"),
    asset!("pair.js", "text/javascript; charset=utf-8"),
];

/// The page of an experiment and its requests, for [`LocalServer::run`](crate::LocalServer::run).
pub fn routes(experiment: Experiment) -> Router {
    pages::routes(PAGE, FILES)
        .route("/api/experiment", get(about))
        .route("/api/observers", post(join))
        .route("/api/pair", get(pair))
        .route("/api/picture/{number}/{which}", get(picture))
        .route("/api/answer", post(answer))
        .with_state(Arc::new(Mutex::new(experiment)))
}

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        match self {
            Self::Invalid(why) => (StatusCode::BAD_REQUEST, why).into_response(),
            Self::Unknown => (StatusCode::UNAUTHORIZED, "there is no such observer").into_response(),
            Self::Other => (StatusCode::CONFLICT, "another pair is judged now").into_response(),
            Self::Absent => (StatusCode::NOT_FOUND, "there is no such picture").into_response(),
            // No failure of the server, after which the page would try again.
            Self::Full => (StatusCode::FORBIDDEN, "the experiment admits no more observers").into_response(),
            Self::Failed(error) => {
                // Paths of this machine are for the one who runs the server.
                eprintln!("error: {}", smalti::names::in_one_line(&error.to_string()));
                (StatusCode::INTERNAL_SERVER_ERROR, "the server cannot store or read this").into_response()
            }
        }
    }
}

/// Runs work on files away from the thread that answers.
async fn working<T: Send + 'static>(
    shared: Shared,
    work: impl FnOnce(&mut Experiment) -> Result<T, Refused> + Send + 'static,
) -> Result<T, Refused> {
    let run = move || work(&mut shared.lock().unwrap_or_else(PoisonError::into_inner));
    let failed = |e| Err(Refused::Failed(ServeError::Server(std::io::Error::other(e))));
    tokio::task::spawn_blocking(run).await.unwrap_or_else(failed)
}

fn json(value: Result<impl Serialize, Refused>) -> Response {
    match value.map(|v| serde_json::to_vec(&v)) {
        Ok(Ok(text)) => ([(CONTENT_TYPE, "application/json")], text).into_response(),
        Ok(Err(_)) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
        Err(refused) => refused.into_response(),
    }
}

/// The content of a request, strictly.
fn parsed<T: DeserializeOwned>(headers: &HeaderMap, body: &Bytes) -> Result<T, Refused> {
    let is_json = headers.get(CONTENT_TYPE).is_some_and(|t| t == "application/json");
    if !is_json {
        return Err(Refused::Invalid("expected JSON (application/json)"));
    }
    serde_json::from_slice(body).map_err(|_| Refused::Invalid("the JSON is not that of this request"))
}

fn secret(headers: &HeaderMap) -> Result<String, Refused> {
    let text = headers.get(AUTHORIZATION).and_then(|v| v.to_str().ok());
    text.and_then(|v| v.strip_prefix("Bearer ")).map(str::to_owned).ok_or(Refused::Unknown)
}

async fn about(State(shared): State<Shared>) -> Response {
    json(working(shared, |e| Ok(e.about())).await)
}

async fn join(State(shared): State<Shared>, headers: HeaderMap, body: Bytes) -> Response {
    let request = match parsed(&headers, &body) {
        Ok(request) => request,
        Err(refused) => return refused.into_response(),
    };
    json(working(shared, move |e| e.join(&request)).await)
}

async fn pair(State(shared): State<Shared>, headers: HeaderMap) -> Response {
    json(working(shared, move |e| e.pair(&secret(&headers)?)).await)
}

async fn answer(State(shared): State<Shared>, headers: HeaderMap, body: Bytes) -> Response {
    let request = match parsed(&headers, &body) {
        Ok(request) => request,
        Err(refused) => return refused.into_response(),
    };
    json(working(shared, move |e| e.answer(&secret(&headers)?, &request)).await)
}

async fn picture(
    State(shared): State<Shared>,
    Path((_, number, which)): Path<(String, String, String)>,
    headers: HeaderMap,
) -> Response {
    let found = working(shared, move |e| {
        let number = number.parse().map_err(|_| Refused::Absent)?;
        let (dir, picture) = e.picture(&secret(&headers)?, number, &which)?;
        Ok(picture.read(&dir)?)
    });
    match found.await {
        Ok(bytes) => ([(CONTENT_TYPE, "image/png")], bytes).into_response(),
        Err(refused) => refused.into_response(),
    }
}
