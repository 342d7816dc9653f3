//! The connection of a page: requests come in, answers go out.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::State;
use axum::extract::ws::{CloseFrame, Message, WebSocket, WebSocketUpgrade, close_code};
use axum::response::Response;
use futures_util::future::{Either, select};
use futures_util::{SinkExt, StreamExt};
use tokio::sync::Notify;
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

use super::error::JobError;
use super::jobs;
use super::material::{Found, Native};
use super::message::{FileSaid, Job, MOST_MESSAGE_BYTES, Request, Said};
use super::watch::Watch;

/// Time between two reports of progress.
const REPORT: Duration = Duration::from_millis(150);

pub(super) async fn connect(State(native): State<Arc<Native>>, upgrade: WebSocketUpgrade) -> Response {
    upgrade
        .max_message_size(MOST_MESSAGE_BYTES)
        .max_frame_size(MOST_MESSAGE_BYTES)
        .on_upgrade(|socket| serve(socket, native))
}

/// A job of the page.
#[derive(Debug, Clone, Default)]
struct Running {
    id: u32,
    watch: Arc<Watch>,
    /// Wakes a job that waits for another one.
    cancelled: Arc<Notify>,
}

impl Running {
    fn stop(&self) {
        self.watch.stop();
        self.cancelled.notify_one();
    }
}

/// What requests and jobs of a page share.
#[derive(Clone)]
struct Session {
    native: Arc<Native>,
    out: UnboundedSender<Message>,
    running: Arc<Mutex<Option<Running>>>,
}

async fn serve(socket: WebSocket, native: Arc<Native>) {
    let (mut sink, mut received) = socket.split();
    let (out, mut waiting) = unbounded_channel();
    let writer = tokio::spawn(async move {
        while let Some(message) = waiting.recv().await {
            if sink.send(message).await.is_err() {
                break;
            }
        }
    });
    let session = Session { native, out, running: Arc::default() };
    let wrong = loop {
        match received.next().await {
            Some(Ok(Message::Text(text))) => match Request::from_bytes(text.as_bytes()) {
                Ok(request) => session.answer(request),
                Err(error) => break Some((close_code::POLICY, error.to_string())),
            },
            Some(Ok(Message::Binary(_))) => {
                break Some((close_code::UNSUPPORTED, "a binary message; expected text".to_owned()));
            }
            Some(Ok(Message::Ping(_) | Message::Pong(_))) => {}
            // Longer than admitted, or no WebSocket.
            Some(Err(error)) => break Some((close_code::SIZE, error.to_string())),
            Some(Ok(Message::Close(_))) | None => break None,
        }
    };
    if let Some((code, message)) = wrong {
        session.say(&Said::Refused { message });
        let _ = session.out.send(Message::Close(Some(CloseFrame { code, reason: "".into() })));
    }
    // Nobody waits for the result.
    if let Some(running) = session.running() {
        running.stop();
    }
    drop(session);
    let _ = writer.await;
}

impl Session {
    fn running(&self) -> Option<Running> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Sends an answer. A page that is gone receives nothing.
    fn say(&self, said: &Said) {
        if let Ok(text) = serde_json::to_string(said) {
            let _ = self.out.send(Message::Text(text.into()));
        }
    }

    fn answer(&self, request: Request) {
        match request {
            Request::Cancel { id } => {
                if let Some(running) = self.running().filter(|running| running.id == id) {
                    running.stop();
                }
            }
            Request::Start { id, job } => {
                let mut slot = self.running.lock().unwrap_or_else(PoisonError::into_inner);
                if slot.is_some() {
                    drop(slot);
                    let message = "another job of this page is at work; expected one at a time".to_owned();
                    return self.say(&Said::Failed { id, message });
                }
                let running = Running { id, ..Running::default() };
                *slot = Some(running.clone());
                drop(slot);
                tokio::spawn(self.clone().work(running, job));
            }
        }
    }

    /// Does a job and tells of it.
    async fn work(self, running: Running, job: Job) {
        let outcome = self.outcome(&running, job).await;
        let notes = running.watch.notes();
        *self.running.lock().unwrap_or_else(PoisonError::into_inner) = None;
        let id = running.id;
        match outcome {
            Ok(Found { mut said, files }) => {
                said["notes"] = notes.into();
                let about = |(kind, bytes): &(&'static str, Vec<u8>)| FileSaid { kind, bytes: bytes.len() };
                self.say(&Said::Result { id, said, files: files.iter().map(about).collect() });
                for (_, bytes) in files {
                    let _ = self.out.send(Message::Binary(Bytes::from(bytes)));
                }
            }
            Err(JobError::Stopped) => self.say(&Said::Cancelled { id }),
            Err(error) => self.say(&Said::Failed { id, message: error.to_string() }),
        }
    }

    async fn outcome(&self, running: &Running, job: Job) -> Result<Found, JobError> {
        // One job at a time has all processors and the memory; those of other pages wait.
        let progress = |step: String, done, of| self.say(&Said::Progress { id: running.id, step, done, of });
        if self.native.turn.available_permits() == 0 {
            progress("waiting for the job of another page".to_owned(), 0, 0);
        }
        let turn = Box::pin(self.native.turn.acquire());
        let Either::Left((Ok(_turn), _)) = select(turn, Box::pin(running.cancelled.notified())).await else {
            return Err(JobError::Stopped);
        };
        let (native, watch) = (self.native.clone(), running.watch.clone());
        let mut work = tokio::task::spawn_blocking(move || jobs::run(&native, &job, &watch));
        let mut told = None;
        loop {
            match select(&mut work, Box::pin(tokio::time::sleep(REPORT))).await {
                Either::Left((done, _)) => return done.unwrap_or(Err(JobError::Broken)),
                Either::Right(_) => {
                    let state = running.watch.state();
                    if told.as_ref() != Some(&state) {
                        let (step, done, of) = state.clone();
                        progress(step, done, of);
                        told = Some(state);
                    }
                }
            }
        }
    }
}
