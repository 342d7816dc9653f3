//! Bytes read where they are needed: a file, or memory.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

use crate::{IoError, Limits};

/// Bytes that are read at any place, by several threads at once.
pub(crate) trait ByteSource: Send + Sync {
    /// How many there are.
    fn len(&self) -> u64;

    /// Fills `into` with the bytes from `offset` on.
    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()>;

    /// The bytes themselves, where they lie in memory.
    fn slice(&self, _offset: u64, _len: usize) -> Option<&[u8]> {
        None
    }
}

/// As the readers hold it.
pub(crate) type Source = Arc<dyn ByteSource>;

impl ByteSource for Vec<u8> {
    fn len(&self) -> u64 {
        Vec::len(self) as u64
    }

    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        let bytes = self.slice(offset, into.len()).ok_or(io::ErrorKind::UnexpectedEof)?;
        into.copy_from_slice(bytes);
        Ok(())
    }

    fn slice(&self, offset: u64, len: usize) -> Option<&[u8]> {
        let start = usize::try_from(offset).ok()?;
        self.get(start..start.checked_add(len)?)
    }
}

/// A file of known length.
struct Opened {
    file: File,
    len: u64,
}

impl ByteSource for Opened {
    fn len(&self) -> u64 {
        self.len
    }

    #[cfg(unix)]
    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, into, offset)
    }

    #[cfg(windows)]
    fn read_at(&self, mut offset: u64, mut into: &mut [u8]) -> io::Result<()> {
        while !into.is_empty() {
            match std::os::windows::fs::FileExt::seek_read(&self.file, into, offset)? {
                0 => return Err(io::ErrorKind::UnexpectedEof.into()),
                n => {
                    into = into.get_mut(n..).unwrap_or_default();
                    offset += n as u64;
                }
            }
        }
        Ok(())
    }
}

/// A file, within the limits. It is not read yet.
pub(crate) fn open(path: &Path, limits: Limits) -> Result<Source, IoError> {
    let io = |source| IoError::Read { path: path.to_owned(), source };
    let file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    if metadata.is_dir() {
        return Err(io(io::ErrorKind::IsADirectory.into()));
    }
    let (bytes, limit) = (metadata.len(), limits.file_bytes);
    if bytes > limit {
        return Err(IoError::TooLarge { path: path.to_owned(), what: "the file", bytes, limit });
    }
    // A pipe or device has no places to read at.
    if metadata.is_file() {
        return Ok(Arc::new(Opened { file, len: bytes }));
    }
    Ok(Arc::new(crate::file::read(path, limit)?))
}

/// Some bytes of a source; an error says that the file ends before them.
pub(crate) fn bytes_at(
    source: &dyn ByteSource,
    offset: u64,
    len: u64,
    what: &'static str,
    path: &Path,
) -> Result<Vec<u8>, IoError> {
    let have = source.len().saturating_sub(offset);
    let truncated = || IoError::Truncated { path: path.to_owned(), what, need: len, have };
    if len > have {
        return Err(truncated());
    }
    let mut bytes = vec![0; usize::try_from(len).map_err(|_| truncated())?];
    source.read_at(offset, &mut bytes).map_err(|source| IoError::Read { path: path.to_owned(), source })?;
    Ok(bytes)
}
