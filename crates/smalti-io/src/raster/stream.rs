//! Sequential reading of a decompressed stream.

use std::io::{self, Read};
use std::sync::{Mutex, PoisonError};

use super::source::Source;
use crate::file::caught;

type Reader<'a> = Box<dyn Read + Send + 'a>;

/// A stream that keeps its position: bytes that are read in their order are unpacked once. To read earlier bytes, it starts again
/// from the beginning. No unpacked bytes are kept.
pub(crate) struct Stream<'a> {
    /// What a message calls it.
    name: String,
    len: u64,
    start: Box<dyn Fn() -> io::Result<Reader<'a>> + Send + Sync + 'a>,
    reached: Mutex<Option<(u64, Reader<'a>)>>,
}

impl<'a> Stream<'a> {
    /// Of so many bytes, which `start` begins to read from the first.
    pub(crate) fn new(
        name: &str,
        len: u64,
        start: impl Fn() -> io::Result<Reader<'a>> + Send + Sync + 'a,
    ) -> Self {
        Self { name: name.to_owned(), len, start: Box::new(start), reached: Mutex::new(None) }
    }

    fn advance(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        let mut reached = self.reached.lock().unwrap_or_else(PoisonError::into_inner);
        let (at, mut stream) = match reached.take() {
            Some((at, stream)) if at <= offset => (at, stream),
            _ => (0, (self.start)()?),
        };
        if io::copy(&mut (&mut stream).take(offset - at), &mut io::sink())? < offset - at {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        stream.read_exact(out)?;
        let at = offset + out.len() as u64;
        // A stream that has been read to its end is closed.
        if at < self.len {
            *reached = Some((at, stream));
        }
        Ok(())
    }
}

impl Source for Stream<'_> {
    fn len(&self) -> u64 {
        self.len
    }

    /// An error of kind [`io::ErrorKind::InvalidData`] where it is the stream that is not as it should be.
    fn read_at(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        let wrong = |what: &str| io::Error::new(io::ErrorKind::InvalidData, format!("{}: {what}", self.name));
        match caught(|| self.advance(offset, out)) {
            Ok(Err(e)) if e.raw_os_error().is_none() => Err(wrong(&e.to_string())),
            Ok(Err(e)) => Err(io::Error::new(e.kind(), format!("{}: {e}", self.name))),
            Ok(done) => done,
            Err(message) => Err(wrong(message)),
        }
    }

    fn is_stream(&self) -> bool {
        true
    }
}
