//! Long work without the lock of the interpreter, which Ctrl-C stops.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;
use smalti::experiment::Progress;

/// The interval at which signals are checked and progress is reported.
const TICK: Duration = Duration::from_millis(50);

/// A Python function that is told of the progress.
#[derive(Clone, Copy)]
pub(crate) enum Told<'a, 'py> {
    /// It is called with the numbers of finished and of expected steps.
    Steps(&'a Bound<'py, PyAny>),
    /// It is called with the number of rendered pictures.
    Pictures(&'a Bound<'py, PyAny>),
}

/// State shared by long work and the thread that waits for it.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    stop: AtomicBool,
    expected: AtomicU64,
    done: AtomicU64,
    pictures: AtomicU64,
}

impl Watch {
    /// Returns an error once the work should end. Work calls this between complete steps.
    pub(crate) fn check(&self) -> PyResult<()> {
        if self.stop.load(Ordering::Relaxed) { Err(PyKeyboardInterrupt::new_err(())) } else { Ok(()) }
    }
}

impl Progress for Watch {
    fn expect(&self, steps: u64) {
        self.expected.fetch_add(steps, Ordering::Relaxed);
    }

    fn done(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    fn picture(&self) {
        self.pictures.fetch_add(1, Ordering::Relaxed);
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Runs long work on another thread. This thread, without the lock, checks signals and calls `progress` when its numbers have
/// changed. After Ctrl-C, or when `progress` raises, it requests the work to end and waits for it, since the work borrows from here.
///
/// # Errors
/// Errors of the work, exceptions of Ctrl-C and `progress`, and RuntimeError for a fault of the library.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<Told<'_, '_>>,
    work: impl FnOnce(&Watch) -> PyResult<T> + Send,
) -> PyResult<T> {
    let watch = Watch::default();
    let (sender, receiver) = sync_channel(1);
    let receiver = std::sync::Mutex::new(receiver);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let result = caught(|| work(&watch));
            // The receiver lives until the scope ends.
            let _ = sender.send(result);
        });
        let mut raised: Option<PyErr> = None;
        let mut reported = (0, 0);
        loop {
            let next = py.detach(|| match receiver.lock() {
                Ok(receiver) => receiver.recv_timeout(TICK),
                Err(_) => Err(RecvTimeoutError::Disconnected),
            });
            let poll = || -> PyResult<()> {
                py.check_signals()?;
                let now = |count: &AtomicU64| count.load(Ordering::Relaxed);
                match progress {
                    Some(Told::Steps(call)) => {
                        let numbers = (now(&watch.done), now(&watch.expected));
                        if std::mem::replace(&mut reported, numbers) != numbers {
                            call.call1(numbers)?;
                        }
                    }
                    Some(Told::Pictures(call)) => {
                        let numbers = (now(&watch.pictures), 0);
                        if std::mem::replace(&mut reported, numbers) != numbers {
                            call.call1((numbers.0,))?;
                        }
                    }
                    None => {}
                }
                Ok(())
            };
            if raised.is_none()
                && let Err(e) = { poll }()
            {
                watch.stop.store(true, Ordering::Relaxed);
                raised = Some(e);
            }
            match next {
                Ok(result) => return raised.map_or(result, Err),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Err(fault("a thread ended without a result")),
            }
        }
    })
}

/// Runs work of a fraction of a second without the lock.
///
/// # Errors
/// Errors of the work, and RuntimeError for a fault of the library.
pub(crate) fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    py.detach(|| caught(work))
}

/// Converts a panic, which would be a fault of the library, to an exception.
fn caught<T>(work: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        Err(fault(text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("unknown")))
    })
}

fn fault(what: &str) -> PyErr {
    PyRuntimeError::new_err(format!("a fault in smalti, please report it: {what}"))
}
