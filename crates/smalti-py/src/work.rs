//! Long work: without the lock of the interpreter, ended by Ctrl-C.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;
use smalti::color::Image;
use smalti::isp::{Isp, IspError};
use smalti::sensor::RawImage;

/// How often Python is asked for signals, and told of progress.
const TICK: Duration = Duration::from_millis(50);

/// What long work and the thread that waits for it tell each other.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    stop: AtomicBool,
    done: AtomicU64,
}

impl Watch {
    /// An error once the work should end. Work asks between steps that are whole in themselves.
    pub(crate) fn check(&self) -> PyResult<()> {
        if self.stop.load(Ordering::Relaxed) { Err(PyKeyboardInterrupt::new_err(())) } else { Ok(()) }
    }

    /// Counts a step as done.
    pub(crate) fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }
}

/// A pipeline of which each picture is a step; it stops when the work is asked to end.
pub(crate) struct InSteps<'a> {
    pub(crate) isp: Box<dyn Isp + 'a>,
    pub(crate) watch: &'a Watch,
}

impl Isp for InSteps<'_> {
    fn render(&self, raw: &RawImage) -> Result<Image, IspError> {
        if self.watch.check().is_err() {
            return Err(IspError::Stopped);
        }
        let picture = self.isp.render(raw)?;
        self.watch.step();
        Ok(picture)
    }
}

/// Does work that may take long on a thread of its own, while this one, without the lock, listens for signals and calls
/// `progress` with the number of steps done. After Ctrl-C, or when `progress` raises, the work is asked to end and waited for:
/// what it borrows must outlive it.
///
/// # Errors
/// Those of the work; what Ctrl-C or `progress` raised; RuntimeError for a fault of the library.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
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
        let mut told = 0;
        loop {
            let next = py.detach(|| match receiver.lock() {
                Ok(receiver) => receiver.recv_timeout(TICK),
                Err(_) => Err(RecvTimeoutError::Disconnected),
            });
            let asked = || -> PyResult<()> {
                py.check_signals()?;
                let done = watch.done.load(Ordering::Relaxed);
                if let Some(progress) = progress.filter(|_| done != told) {
                    told = done;
                    progress.call1((done,))?;
                }
                Ok(())
            };
            if raised.is_none()
                && let Err(e) = { asked }()
            {
                watch.stop.store(true, Ordering::Relaxed);
                raised = Some(e);
            }
            match next {
                Ok(result) => return raised.map_or(result, Err),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Err(fault("a thread ended without a word")),
            }
        }
    })
}

/// Work of a fraction of a second, without the lock.
///
/// # Errors
/// Those of the work; RuntimeError for a fault of the library.
pub(crate) fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    py.detach(|| caught(work))
}

/// The library does not panic; should it, Python sees an exception that programs can catch.
fn caught<T>(work: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        Err(fault(text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("unknown")))
    })
}

fn fault(what: &str) -> PyErr {
    PyRuntimeError::new_err(format!("a fault in smalti, please report it: {what}"))
}
