//! Optical images, training statistics, pipelines, scores and the light of the studio kept on disk between runs, found by the hash of what they were
//! computed from.
//!
//! A cache may lose anything at any time: what is absent, cut short, damaged or the entry of another key is `None`, and the caller
//! computes it again. Entries are written atomically, so that several processes may share a folder.

mod entry;
mod image;
mod kind;
mod limits;

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use blake3::Hash;
use smalti::camera::CameraError;
use smalti::experiment::{PictureFigures, Store};
use smalti::l3::{Pipeline, Statistics};
use smalti::optics::OpticalImage;

pub use self::kind::EntryKind;
pub use self::limits::CacheLimits;
use crate::studio::StudioAsset;
use crate::{IoError, l3, write};

/// The entries of one kind in a cache.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CacheUse {
    /// What they hold.
    pub kind: EntryKind,
    /// How many there are, with the unfinished ones of processes that stopped.
    pub entries: usize,
    /// Bytes that they take.
    pub bytes: u64,
    /// When the one that was not used for longest was last used.
    pub oldest_use: Option<SystemTime>,
}

/// A folder of optical images, of statistics that pipelines are learned from, of pipelines and of scores.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cache {
    dir: Option<PathBuf>,
    limits: CacheLimits,
}

impl Cache {
    /// A cache in `dir`, else in `$SMALTI_CACHE_DIR`, else in `smalti` below `$XDG_CACHE_HOME`, `~/.cache` or
    /// `%LOCALAPPDATA%`. Without any of these it is disabled. The folder is made with the first entry. The limits are those of
    /// [`CacheLimits::from_environment`].
    ///
    /// # Errors
    /// [`IoError::Environment`] when a variable states no limit.
    pub fn open(dir: Option<PathBuf>) -> Result<Self, IoError> {
        let variable = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        let dir = dir
            .or_else(|| variable("SMALTI_CACHE_DIR"))
            .or_else(|| variable("XDG_CACHE_HOME").map(|d| d.join("smalti")))
            .or_else(|| variable("HOME").map(|d| d.join(".cache").join("smalti")))
            .or_else(|| variable("LOCALAPPDATA").map(|d| d.join("smalti")));
        Ok(Self { dir, limits: CacheLimits::from_environment()? })
    }

    /// A cache in `dir` within the limits.
    #[must_use]
    pub fn within(dir: PathBuf, limits: CacheLimits) -> Self {
        Self { dir: Some(dir), limits }
    }

    /// A cache that keeps nothing.
    #[must_use]
    pub fn disabled() -> Self {
        Self { dir: None, limits: CacheLimits { bytes: 0, unused: Duration::ZERO } }
    }

    /// Its folder; `None` when it is disabled.
    #[must_use]
    pub fn folder(&self) -> Option<&Path> {
        self.dir.as_deref()
    }

    /// Its limits.
    #[must_use]
    pub fn limits(&self) -> CacheLimits {
        self.limits
    }

    /// What the folder holds, for each kind. A folder that is not there holds nothing.
    ///
    /// # Errors
    /// [`IoError::Read`].
    pub fn content(&self) -> Result<Vec<CacheUse>, IoError> {
        let files = limits::files(self.folder())?;
        let of = |kind: EntryKind| {
            let files = files.iter().filter(|f| f.kind == kind);
            CacheUse {
                kind,
                entries: files.clone().count(),
                bytes: files.clone().map(|f| f.bytes).sum(),
                oldest_use: files.map(|f| f.used).min(),
            }
        };
        Ok(EntryKind::ALL.map(of).to_vec())
    }

    /// Removes all entries and returns how many bytes they took. Other files of the folder stay.
    ///
    /// # Errors
    /// [`IoError::Read`], [`IoError::Write`].
    pub fn clear(&self) -> Result<u64, IoError> {
        let mut bytes = 0;
        for file in limits::files(self.folder())? {
            limits::remove(&file.path)?;
            bytes += file.bytes;
        }
        Ok(bytes)
    }

    fn path(&self, kind: EntryKind, key: &Hash) -> Option<PathBuf> {
        self.dir.as_ref().map(|d| d.join(format!("{key}.{}", kind.extension())))
    }

    /// Reads an entry, if there is one of that key that is whole.
    fn kept<T>(
        &self,
        kind: EntryKind,
        description: &str,
        read: impl FnOnce(&Path, &Hash) -> Option<T>,
    ) -> Option<T> {
        let key = kind.key(description);
        let path = self.path(kind, &key)?;
        let found = read(&path, &key)?;
        limits::mark_used(&path);
        Some(found)
    }

    /// Writes an entry, in pieces, and removes those not used for longest until the cache is within its limits. An entry larger than
    /// the limit is not kept. A cache that cannot be written costs time, not the result.
    fn keep(&self, kind: EntryKind, description: &str, pieces: &[&[u8]]) {
        let key = kind.key(description);
        let (Some(dir), Some(path)) = (&self.dir, self.path(kind, &key)) else { return };
        let size = entry::size(pieces);
        if size > self.limits.bytes {
            return;
        }
        let _ = write::create_folder(dir).and_then(|()| {
            limits::evict(dir, &path, CacheLimits { bytes: self.limits.bytes - size, ..self.limits });
            entry::write(&path, &key, pieces)
        });
    }

    /// Returns the cached optical image, or computes and caches it. Entries of other versions are ignored.
    ///
    /// # Errors
    /// Those of `make`. A cache that cannot be written costs time, not the result.
    pub fn optical_image<E>(
        &self,
        description: &str,
        make: &dyn Fn() -> Result<OpticalImage, E>,
    ) -> Result<OpticalImage, E> {
        let kind = EntryKind::OpticalImage;
        if let Some(image) = self.kept(kind, description, image::read) {
            return Ok(image);
        }
        let image = make()?;
        image::with_pieces(&image, |pieces| self.keep(kind, description, pieces));
        Ok(image)
    }
}

impl Store for Cache {
    fn optical_image(
        &self,
        key: &str,
        make: &dyn Fn() -> Result<OpticalImage, CameraError>,
    ) -> Result<OpticalImage, CameraError> {
        Cache::optical_image(self, key, make)
    }

    fn statistics(&self, key: &str) -> Option<Statistics> {
        self.kept(EntryKind::Statistics, key, |path, key| {
            l3::statistics_from_bytes(&entry::read(path, key)?, path).ok()
        })
    }

    fn keep_statistics(&self, key: &str, statistics: &Statistics) {
        self.keep_learned(EntryKind::Statistics, key, l3::statistics_pieces(statistics));
    }

    fn pipeline(&self, key: &str) -> Option<Pipeline> {
        self.kept(EntryKind::Pipeline, key, |path, key| {
            l3::table_from_bytes(&entry::read(path, key)?, path).ok()
        })
    }

    fn keep_pipeline(&self, key: &str, pipeline: &Pipeline) {
        self.keep_learned(EntryKind::Pipeline, key, l3::table_pieces(pipeline));
    }

    fn scores(&self, key: &str) -> Option<PictureFigures> {
        self.kept(EntryKind::Scores, key, |path, key| serde_json::from_slice(&entry::read(path, key)?).ok())
    }

    fn keep_scores(&self, key: &str, scores: &PictureFigures) {
        if let Ok(text) = serde_json::to_vec(scores) {
            self.keep(EntryKind::Scores, key, &[&text]);
        }
    }
}

impl Cache {
    /// The files of the studio that were kept, if there are any.
    #[must_use]
    pub fn studio_assets(&self, key: &str) -> Option<Vec<StudioAsset>> {
        self.kept(EntryKind::StudioLight, key, |path, key| {
            let content = entry::read(path, key)?;
            let (length, rest) = content.split_first_chunk::<8>()?;
            let (index, mut rest) =
                rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
            let index: Vec<(String, usize)> = serde_json::from_slice(index).ok()?;
            let asset = |(name, bytes)| {
                let (own, others) = rest.split_at_checked(bytes)?;
                rest = others;
                Some(StudioAsset { name, bytes: own.to_vec() })
            };
            index.into_iter().map(asset).collect()
        })
    }

    /// Keeps the files of the studio.
    pub fn keep_studio_assets(&self, key: &str, assets: &[StudioAsset]) {
        let index: Vec<(&str, usize)> = assets.iter().map(|a| (a.name.as_str(), a.bytes.len())).collect();
        if let Ok(index) = serde_json::to_vec(&index) {
            let length = (index.len() as u64).to_le_bytes();
            let head = [&length[..], &index];
            let pieces: Vec<&[u8]> =
                head.into_iter().chain(assets.iter().map(|a| a.bytes.as_slice())).collect();
            self.keep(EntryKind::StudioLight, key, &pieces);
        }
    }

    fn keep_learned(&self, kind: EntryKind, key: &str, pieces: Result<Vec<Vec<u8>>, IoError>) {
        if let Ok(pieces) = pieces {
            self.keep(kind, key, &pieces.iter().map(Vec::as_slice).collect::<Vec<_>>());
        }
    }
}
