//! Writing a file whole or not at all.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::IoError;

/// Where an atomic write goes: buffered and seekable.
pub type Target = BufWriter<File>;

/// Removes the temporary file or folder unless it was renamed.
struct Temporary {
    path: PathBuf,
    keep: bool,
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.keep {
            // Nothing more can be done about what cannot be removed; the write itself has already failed.
            let _ =
                if self.path.is_dir() { fs::remove_dir_all(&self.path) } else { fs::remove_file(&self.path) };
        }
    }
}

/// Writes a file by `fill` under a temporary name in the same folder, then renames it over `path`. On any failure
/// (of `fill` too, or a panic in it) the temporary file is removed and `path` is as it was.
///
/// The data are handed to the operating system, not forced to the disk: a loss of power may lose the file.
///
/// # Errors
/// What `fill` returns, or [`IoError::Write`].
pub fn atomic(path: &Path, fill: impl FnOnce(&mut Target) -> Result<(), IoError>) -> Result<(), IoError> {
    let io = IoError::writing(path);
    let (file, mut temporary) = create_beside(path).map_err(io)?;
    let mut target = BufWriter::with_capacity(1 << 18, file);
    fill(&mut target)?;
    let file = target.into_inner().map_err(|e| io(e.into_error()))?;
    drop(file);
    fs::rename(&temporary.path, path).map_err(io)?;
    temporary.keep = true;
    Ok(())
}

/// As [`atomic`], where only writing can fail.
pub(crate) fn stream(path: &Path, fill: impl FnOnce(&mut Target) -> io::Result<()>) -> Result<(), IoError> {
    atomic(path, |out| fill(out).map_err(IoError::writing(path)))
}

/// Writes `bytes` as by [`atomic`].
pub fn bytes(path: &Path, bytes: &[u8]) -> Result<(), IoError> {
    stream(path, |out| out.write_all(bytes))
}

/// As [`bytes()`], and the data are on the disk before the file has its name: after a loss of power it is whole or absent.
pub fn durable(path: &Path, bytes: &[u8]) -> Result<(), IoError> {
    stream(path, |out| {
        out.write_all(bytes)?;
        out.flush()?;
        out.get_ref().sync_data()
    })
}

/// Flushes the directory entries of a folder to disk, where the system supports it. Errors are ignored: the names of new files may then be lost with the power.
pub(crate) fn sync_folder(dir: &Path) {
    if let Ok(folder) = fs::File::open(dir) {
        let _ = folder.sync_all();
    }
}

/// As [`bytes()`]; where the system has such permissions, only the user who runs the program can read the file.
///
/// # Errors
/// [`IoError::Write`].
pub fn secret(path: &Path, bytes: &[u8]) -> Result<(), IoError> {
    stream(path, |out| {
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            out.get_ref().set_permissions(fs::Permissions::from_mode(0o600))?;
        }
        out.write_all(bytes)
    })
}

/// Finds out, before long work, whether [`atomic`] will be able to write a file: makes a temporary one beside it and removes
/// it.
///
/// # Errors
/// [`IoError::Write`].
pub fn ensure_can_write(path: &Path) -> Result<(), IoError> {
    let io = IoError::writing(path);
    if path.is_dir() {
        return Err(io(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder; expected a file")));
    }
    create_beside(path).map(drop).map_err(io)
}

/// Finds out, before long work, whether [`begin_folder`] will be able to make a folder and files to be written in it. Nothing is
/// made that stays.
///
/// # Errors
/// [`IoError::Write`].
pub fn ensure_can_fill(dir: &Path) -> Result<(), IoError> {
    let io = IoError::writing(dir);
    if dir.is_file() {
        return Err(io(not_a_folder()));
    }
    // The folder itself, or the nearest above it that is there.
    let there = dir.ancestors().find(|d| d.exists() || d.as_os_str().is_empty()).unwrap_or(dir);
    create_beside(&there.join("smalti")).map(drop).map_err(io)
}

fn not_a_folder() -> io::Error {
    io::Error::new(io::ErrorKind::NotADirectory, "it is a file; expected a folder")
}

/// Makes a folder where it is absent and removes from it the files that list its content. Their new versions are to be
/// written last: as long as they are absent, the other files may come from two runs.
///
/// # Errors
/// [`IoError::Write`].
pub fn begin_folder(dir: &Path, indices: &[&str]) -> Result<(), IoError> {
    if dir.is_file() {
        return Err(IoError::writing(dir)(not_a_folder()));
    }
    create_folder(dir)?;
    for index in indices {
        let path = dir.join(index);
        if let Err(source) = fs::remove_file(&path)
            && source.kind() != io::ErrorKind::NotFound
        {
            return Err(IoError::Write { path, source });
        }
    }
    Ok(())
}

/// Files of a folder and the folders in it, written one after the other. Folders are made as they are needed. Files that an earlier
/// run left in a folder are removed before the first new file is written to it.
#[derive(Debug)]
pub struct Files {
    folder: PathBuf,
    indices: Vec<String>,
    earlier: Vec<String>,
    begun: BTreeSet<PathBuf>,
}

impl Files {
    /// Of `folder`. Earlier files with the names `indices` are removed from it; those with the names `earlier` also from the folders
    /// in it. Nothing is removed before the first write.
    #[must_use]
    pub fn new(folder: &Path, indices: &[&str], earlier: &[String]) -> Self {
        let indices = indices.iter().map(|&name| name.to_owned()).collect();
        Self { folder: folder.to_owned(), indices, earlier: earlier.to_vec(), begun: BTreeSet::new() }
    }

    /// Writes a file as by [`bytes()`]; `name` is its path relative to the folder.
    pub fn write(&mut self, name: &str, content: &[u8]) -> Result<(), IoError> {
        let path = self.folder.join(name);
        let parent = path.parent().unwrap_or(&self.folder);
        for (folder, indices) in [(self.folder.as_path(), self.indices.as_slice()), (parent, &[])] {
            if !self.begun.contains(folder) {
                let names: Vec<&str> = indices.iter().chain(&self.earlier).map(String::as_str).collect();
                begin_folder(folder, &names)?;
                self.begun.insert(folder.to_owned());
            }
        }
        bytes(&path, content)
    }
}

/// Makes a folder, and the folders around it, where it is absent.
pub(crate) fn create_folder(dir: &Path) -> Result<(), IoError> {
    fs::create_dir_all(dir).map_err(IoError::writing(dir))
}

/// Finds out, before long work, whether a folder is absent or empty, as [`folder`] needs it.
///
/// # Errors
/// [`IoError::Write`].
pub fn ensure_is_new(dir: &Path) -> Result<(), IoError> {
    let io = IoError::writing(dir);
    match fs::read_dir(dir).map(|mut there| there.next().is_some()) {
        Ok(true) => {
            let kind = io::ErrorKind::DirectoryNotEmpty;
            Err(io(io::Error::new(kind, "the folder is not empty; expected a new or an empty one")))
        }
        Err(e) if e.kind() == io::ErrorKind::NotADirectory => Err(io(not_a_folder())),
        _ => Ok(()),
    }
}

/// Writes a folder whole or not at all: its files, by their paths relative to it, go into a folder with a temporary name beside it, which is
/// then renamed. The folder must be absent or empty.
///
/// # Errors
/// [`IoError::Write`], also when there is a file or a folder with content in its place.
pub fn folder<'a>(dir: &Path, files: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> Result<(), IoError> {
    ensure_is_new(dir)?;
    let io = IoError::writing(dir);
    // The path as a whole, so that `out/` and `.` have a name and a folder beside them.
    let whole = std::path::absolute(dir).map_err(io)?;
    let around = whole.parent().filter(|_| whole.file_name().is_some());
    let around = around.ok_or_else(|| io(io::Error::other("expected the name of a new folder")))?;
    create_folder(around)?;
    let ((), mut temporary) = beside(&whole, |path| fs::create_dir(path)).map_err(io)?;
    for (name, content) in files {
        let path = temporary.path.join(name);
        create_folder(path.parent().unwrap_or(&temporary.path))?;
        fs::write(&path, content).map_err(io)?;
    }
    fs::rename(&temporary.path, &whole).map_err(io)?;
    temporary.keep = true;
    Ok(())
}

/// A new file in the folder of `path`, under a name no other process or thread has.
fn create_beside(path: &Path) -> io::Result<(File, Temporary)> {
    beside(path, |path| OpenOptions::new().write(true).create_new(true).open(path))
}

/// Makes a new file or folder in the folder of `path`, under a name no other process or thread has.
fn beside<T>(path: &Path, make: impl Fn(&Path) -> io::Result<T>) -> io::Result<(T, Temporary)> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let Some(name) = path.file_name() else {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"));
    };
    let mut last = io::Error::from(io::ErrorKind::AlreadyExists);
    for _ in 0..64 {
        let number = COUNTER.fetch_add(1, Ordering::Relaxed);
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}-{number}.tmp", std::process::id()));
        let beside = path.with_file_name(hidden);
        match make(&beside) {
            Ok(made) => return Ok((made, Temporary { path: beside, keep: false })),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => last = error,
            Err(error) => return Err(error),
        }
    }
    Err(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(dir: &Path) -> Vec<String> {
        fs::read_dir(dir).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_file_is_replaced_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        bytes(&path, b"one").unwrap();
        bytes(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(names(dir.path()), ["a.txt"]);
    }

    #[test]
    fn a_writer_that_fails_midway_leaves_everything_as_it_was() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        bytes(&path, b"one").unwrap();
        let result = atomic(&path, |out| {
            // More than the buffer, so that something has reached the file.
            out.write_all(&vec![7; 1 << 20]).unwrap();
            Err(IoError::Write { path: path.clone(), source: io::Error::other("the disk is full") })
        });
        assert!(result.unwrap_err().to_string().ends_with("a.txt: the disk is full"));
        assert_eq!(fs::read(&path).unwrap(), b"one");
        assert_eq!(names(dir.path()), ["a.txt"]);
    }

    #[test]
    fn a_writer_that_panics_leaves_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        let caught = std::panic::catch_unwind(|| atomic(&path, |_| panic!("midway")));
        assert!(caught.is_err());
        assert!(names(dir.path()).is_empty());
    }

    #[test]
    fn a_folder_begins_without_its_index_and_with_all_else() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("a/b");
        begin_folder(&out, &["index.json"]).unwrap();
        bytes(&out.join("index.json"), b"{}").unwrap();
        bytes(&out.join("data"), b"x").unwrap();
        begin_folder(&out, &["index.json"]).unwrap();
        assert_eq!(names(&out), ["data"]);
        let error = begin_folder(&out.join("data"), &[]).unwrap_err().to_string();
        assert!(error.ends_with("data: it is a file; expected a folder"), "{error}");
    }

    #[test]
    fn files_replace_those_of_an_earlier_run() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("out");
        for name in ["index.json", "a.svg", "mine.txt", "in/a.svg", "in/index.json"] {
            Files::new(&out, &[], &[]).write(name, b"old").unwrap();
        }
        let mut files = Files::new(&out, &["index.json"], &["a.svg".into()]);
        assert!(out.join("index.json").exists(), "nothing is removed before the first write");
        files.write("in/b.svg", b"new").unwrap();
        let mut there = names(&out);
        there.sort();
        assert_eq!(there, ["in", "mine.txt"]);
        let mut there = names(&out.join("in"));
        there.sort();
        assert_eq!(there, ["b.svg", "index.json"]);
    }

    #[test]
    fn what_cannot_be_written_is_known_before_and_nothing_stays() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        ensure_can_write(&at("new")).unwrap();
        ensure_can_fill(&at("deep/er")).unwrap();
        ensure_can_fill(dir.path()).unwrap();
        assert!(names(dir.path()).is_empty());
        bytes(&at("file"), b"kept").unwrap();
        ensure_can_write(&at("file")).unwrap();
        for error in [
            ensure_can_write(dir.path()),
            ensure_can_write(&at("no/file")),
            ensure_can_write(&at("file/in")),
            ensure_can_fill(&at("file")),
            ensure_can_fill(&at("file/in")),
        ] {
            assert!(matches!(error, Err(IoError::Write { .. })), "{error:?}");
        }
        assert_eq!((names(dir.path()), fs::read(at("file")).unwrap()), (vec!["file".into()], b"kept".into()));
    }

    #[test]
    fn a_folder_or_a_missing_folder_is_an_error_that_names_the_file() {
        let dir = tempfile::tempdir().unwrap();
        assert!(bytes(dir.path(), b"x").is_err());
        let error = bytes(&dir.path().join("no/such.txt"), b"x").unwrap_err();
        assert!(error.to_string().contains("such.txt"));
        assert!(names(dir.path()).is_empty());
        assert!(bytes(Path::new("/"), b"x").is_err());
    }

    #[test]
    fn a_folder_is_written_whole_or_not_at_all() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("deep/out");
        let files = [("a.txt", &b"one"[..]), ("in/b.txt", b"two")];
        folder(&out, files).unwrap();
        assert_eq!(fs::read(out.join("in/b.txt")).unwrap(), b"two");
        let error = folder(&out, files).unwrap_err().to_string();
        assert!(error.ends_with("the folder is not empty; expected a new or an empty one"), "{error}");
        let error = folder(&out.join("a.txt"), files).unwrap_err().to_string();
        assert!(error.ends_with("it is a file; expected a folder"), "{error}");
        // The second file cannot be written, since the first has the name of its folder.
        let other = dir.path().join("other");
        assert!(folder(&other, [("a", &b"one"[..]), ("a/b", b"two")]).is_err());
        assert_eq!(names(dir.path()), ["deep"]);
        fs::create_dir(&other).unwrap();
        folder(&other, files).unwrap();
        assert_eq!(names(&other).len(), 2);
    }
}
