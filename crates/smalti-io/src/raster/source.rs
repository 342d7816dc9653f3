//! Bytes that are read from any place.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

use crate::IoError;

/// A source that several readers hold.
pub(crate) type Shared<'a> = Arc<dyn Source + 'a>;

/// A file, or memory in its place; read from several threads at once.
pub(crate) trait Source: Send + Sync {
    /// Length, bytes.
    fn len(&self) -> u64;

    /// Fills `out` from an offset; an error where the source ends before.
    fn read_at(&self, offset: u64, out: &mut [u8]) -> io::Result<()>;

    /// All bytes, where they are in memory.
    fn memory(&self) -> Option<&[u8]> {
        None
    }

    /// Whether bytes can only be read in their order: to read earlier bytes again, reading starts from the beginning.
    fn is_stream(&self) -> bool {
        false
    }
}

impl Source for &[u8] {
    fn len(&self) -> u64 {
        <[u8]>::len(self) as u64
    }

    fn read_at(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        let from = usize::try_from(offset).ok().and_then(|at| self.get(at..)?.get(..out.len()));
        out.copy_from_slice(from.ok_or(io::ErrorKind::UnexpectedEof)?);
        Ok(())
    }

    fn memory(&self) -> Option<&[u8]> {
        Some(self)
    }
}

impl Source for Vec<u8> {
    fn len(&self) -> u64 {
        Self::len(self) as u64
    }

    fn read_at(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        self.as_slice().read_at(offset, out)
    }

    fn memory(&self) -> Option<&[u8]> {
        Some(self)
    }
}

/// An open file.
#[derive(Debug)]
pub(crate) struct FileSource {
    #[cfg(unix)]
    file: File,
    #[cfg(not(unix))]
    file: std::sync::Mutex<File>,
    len: u64,
}

impl FileSource {
    pub(crate) fn open(path: &Path) -> Result<Self, IoError> {
        let io = IoError::reading(path);
        let file = File::open(path).map_err(io)?;
        let metadata = file.metadata().map_err(io)?;
        if metadata.is_dir() {
            return Err(io(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder; expected a file")));
        }
        let len = metadata.len();
        #[cfg(not(unix))]
        let file = std::sync::Mutex::new(file);
        Ok(Self { file, len })
    }
}

impl Source for FileSource {
    fn len(&self) -> u64 {
        self.len
    }

    #[cfg(unix)]
    fn read_at(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, out, offset)
    }

    #[cfg(not(unix))]
    fn read_at(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        let mut file = self.file.lock().map_err(|_| io::Error::other("a reader has failed before"))?;
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(out)
    }
}

/// A part of a source, read as a file of its own.
pub(crate) struct Span<'a> {
    source: Shared<'a>,
    begin: u64,
    end: u64,
    at: u64,
}

impl<'a> Span<'a> {
    /// From a place to another, at most the end of the source.
    pub(crate) fn new(source: &Shared<'a>, begin: u64, end: u64) -> Self {
        let end = end.min(source.len()).max(begin);
        Self { source: Arc::clone(source), begin, end, at: begin }
    }

    pub(crate) fn whole(source: &Shared<'a>) -> Self {
        Self::new(source, 0, source.len())
    }
}

impl Read for Span<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let len = out.len().min(usize::try_from(self.end.saturating_sub(self.at)).unwrap_or(usize::MAX));
        let out = out.get_mut(..len).unwrap_or_default();
        self.source.read_at(self.at, out)?;
        self.at += len as u64;
        Ok(len)
    }
}

impl Seek for Span<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let at = match to {
            SeekFrom::Start(at) => self.begin.checked_add(at),
            SeekFrom::End(by) => self.end.checked_add_signed(by),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
        };
        self.at = at.filter(|at| *at >= self.begin).ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.at - self.begin)
    }
}

/// A part of a source as a vector. No memory is allocated for bytes beyond its end.
pub(crate) fn part(source: &dyn Source, offset: u64, len: usize) -> io::Result<Vec<u8>> {
    if offset.checked_add(len as u64).is_none_or(|end| end > source.len()) {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    let mut out = vec![0; len];
    source.read_at(offset, &mut out)?;
    Ok(out)
}

/// As [`part`], with an error that names what the file lacks.
pub(crate) fn bytes_at(
    source: &dyn Source,
    offset: u64,
    len: u64,
    what: &'static str,
    path: &Path,
) -> Result<Vec<u8>, IoError> {
    let have = source.len().saturating_sub(offset);
    match usize::try_from(len) {
        Ok(count) if len <= have => part(source, offset, count).map_err(IoError::reading(path)),
        _ => Err(IoError::truncated(path, what, len, have)),
    }
}
