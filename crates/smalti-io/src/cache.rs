//! Optical images, training statistics and scores kept on disk between runs, found by the hash of what they were computed from.
//!
//! A cache may lose anything at any time: what is absent, cut short or damaged is `None`, and the caller computes
//! it again. Entries are written atomically, so that several processes may share a folder.

use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use blake3::{Hash, Hasher};
use rayon::prelude::*;
use smalti::camera::CameraError;
use smalti::experiment::{PictureFigures, Store};
use smalti::l3::{Pipeline, Statistics};
use smalti::numeric::Planes;
use smalti::optics::{OPTICAL_IMAGE_REVISION, OpticalImage};
use smalti::spectrum::{SpectralCube, WavelengthGrid};

use crate::scene_file::blocks::little_endian;
use crate::{IoError, l3, write};

impl Store for Cache {
    fn optical_image(
        &self,
        key: &str,
        make: &dyn Fn() -> Result<OpticalImage, CameraError>,
    ) -> Result<OpticalImage, CameraError> {
        Cache::optical_image(self, key, make)
    }

    fn statistics(&self, key: &str) -> Option<Statistics> {
        self.kept(&statistics_key(key), STATISTICS_EXTENSION, |path| l3::read_statistics(path).ok())
    }

    fn keep_statistics(&self, key: &str, statistics: &Statistics) {
        self.keep(&statistics_key(key), STATISTICS_EXTENSION, |path| l3::write_statistics(path, statistics));
    }

    fn pipeline(&self, key: &str) -> Option<Pipeline> {
        self.kept(&pipeline_key(key), PIPELINE_EXTENSION, |path| l3::read_table(path).ok())
    }

    fn keep_pipeline(&self, key: &str, pipeline: &Pipeline) {
        self.keep(&pipeline_key(key), PIPELINE_EXTENSION, |path| l3::write_table(path, pipeline));
    }

    fn scores(&self, key: &str) -> Option<PictureFigures> {
        let read = |path: &Path| serde_json::from_slice(&fs::read(path).ok()?).ok();
        self.kept(&scores_key(key), SCORES_EXTENSION, read)
    }

    fn keep_scores(&self, key: &str, scores: &PictureFigures) {
        if let Ok(text) = serde_json::to_vec(scores) {
            self.keep(&scores_key(key), SCORES_EXTENSION, |path| write::bytes(path, &text));
        }
    }
}

fn pipeline_key(key: &str) -> Hash {
    hash(&[("pipeline", key.as_bytes())])
}

fn scores_key(key: &str) -> Hash {
    hash(&[("scores", key.as_bytes())])
}

fn statistics_key(key: &str) -> Hash {
    hash(&[("statistics", key.as_bytes())])
}

/// The largest size of a cache, bytes.
const LIMIT_BYTES: u64 = 2 << 30;

const MAGIC: &[u8; 8] = b"SMALTIOI";
// Part of every entry: one of another version is ignored.
const VERSION: u32 = 1;
const HEADER_LEN: usize = 8 + 4 + 32 + 3 * 8 + 3 * 8 + 4 + 4;
const EXTENSION: &str = "smalti-oi";
const STATISTICS_EXTENSION: &str = "smalti-l3";
const PIPELINE_EXTENSION: &str = "smalti-l3-best";
const SCORES_EXTENSION: &str = "smalti-scores";

/// The hash of labelled parts. The lengths of labels and parts are hashed too: `("a", "bc")` and `("ab", "c")` differ.
fn hash(parts: &[(&str, &[u8])]) -> Hash {
    let mut hasher = Hasher::new();
    for part in parts.iter().flat_map(|(label, value)| [label.as_bytes(), value]) {
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part);
    }
    hasher.finalize()
}

/// A folder of optical images, of statistics that pipelines are learned from, and of scores.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cache {
    dir: Option<PathBuf>,
    limit_bytes: u64,
}

impl Cache {
    /// A cache in `dir`, else in `$SMALTI_CACHE_DIR`, else in `smalti` below `$XDG_CACHE_HOME`, `~/.cache` or
    /// `%LOCALAPPDATA%`. Without any of these it is disabled. The folder is made with the first entry.
    #[must_use]
    pub fn open(dir: Option<PathBuf>) -> Self {
        let variable = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        let dir = dir
            .or_else(|| variable("SMALTI_CACHE_DIR"))
            .or_else(|| variable("XDG_CACHE_HOME").map(|d| d.join("smalti")))
            .or_else(|| variable("HOME").map(|d| d.join(".cache").join("smalti")))
            .or_else(|| variable("LOCALAPPDATA").map(|d| d.join("smalti")));
        Self { dir, limit_bytes: LIMIT_BYTES }
    }

    /// A cache that keeps nothing.
    #[must_use]
    pub fn disabled() -> Self {
        Self { dir: None, limit_bytes: 0 }
    }

    fn path(&self, key: &Hash, extension: &str) -> Option<PathBuf> {
        self.dir.as_ref().map(|d| d.join(format!("{key}.{extension}")))
    }

    /// Reads an entry, if there is one that can be read.
    fn kept<T>(&self, key: &Hash, extension: &str, read: impl FnOnce(&Path) -> Option<T>) -> Option<T> {
        let path = self.path(key, extension)?;
        let found = read(&path)?;
        mark_used(&path);
        Some(found)
    }

    /// Writes an entry. A cache that cannot be written costs time, not the result.
    fn keep(&self, key: &Hash, extension: &str, write: impl FnOnce(&Path) -> Result<(), IoError>) {
        let (Some(dir), Some(path)) = (&self.dir, self.path(key, extension)) else { return };
        let _ = write::create_folder(dir).and_then(|()| {
            self.evict(dir, &path, self.limit_bytes);
            write(&path)
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
        // A cache must not outlive a correction.
        let key = hash(&[
            ("revision", &OPTICAL_IMAGE_REVISION.to_le_bytes()),
            ("version", env!("CARGO_PKG_VERSION").as_bytes()),
            ("target", description.as_bytes()),
        ]);
        if let Some(image) = self.get(&key) {
            return Ok(image);
        }
        let image = make()?;
        let _ = self.put(&key, &image);
        Ok(image)
    }

    /// The image of that key, bit for bit as it was put; `None` when it is absent or damaged.
    fn get(&self, key: &Hash) -> Option<OpticalImage> {
        let path = self.path(key, EXTENSION)?;
        let mut file = File::open(&path).ok()?;
        let mut header = [0; HEADER_LEN];
        file.read_exact(&mut header).ok()?;
        let header = Header::parse(&header, key)?;
        // Before memory is taken, the file must have the length its header asks for.
        let values = header.rows.checked_mul(header.cols)?.checked_mul(header.grid.len())?;
        let expected = (values as u64).checked_mul(4)?.checked_add(HEADER_LEN as u64)?;
        if file.metadata().ok()?.len() != expected {
            return None;
        }
        let mut data = vec![0f32; values];
        if read_values(&path, &mut data)? != header.checksum {
            return None;
        }
        if cfg!(target_endian = "big") {
            data = little_endian(&data).into_owned();
        }
        let planes = Planes::new(header.rows, header.cols, header.grid.len(), data).ok()?;
        let cube = SpectralCube::new(header.grid, planes).ok()?;
        mark_used(&path);
        OpticalImage::new(cube, header.sample_spacing_m).ok()
    }

    /// Keeps an image, and removes those not used for longest until the cache is within its limit. An image larger
    /// than the limit is not kept; a disabled cache does nothing.
    fn put(&self, key: &Hash, image: &OpticalImage) -> Result<(), IoError> {
        let (Some(dir), Some(path)) = (&self.dir, self.path(key, EXTENSION)) else { return Ok(()) };
        let cube = image.irradiance();
        let data = cube.planes().data();
        let size = (data.len() as u64).saturating_mul(4).saturating_add(HEADER_LEN as u64);
        if size > self.limit_bytes {
            return Ok(());
        }
        write::create_folder(dir)?;
        let data = little_endian(data);
        let bytes: &[u8] = bytemuck::cast_slice(&data);
        let header = Header {
            rows: cube.rows(),
            cols: cube.cols(),
            grid: cube.grid(),
            sample_spacing_m: image.sample_spacing_m(),
            checksum: crc32fast::hash(bytes),
        };
        self.evict(dir, &path, self.limit_bytes - size);
        write::stream(&path, |out| {
            out.write_all(&header.bytes(key))?;
            out.write_all(bytes)
        })
    }

    /// Removes the entries (and temporary files of processes that died) not used for longest, beside `kept`, until
    /// at most `bytes` are left. What cannot be removed stays: another process may have been faster.
    fn evict(&self, dir: &Path, kept: &Path, bytes: u64) {
        let Ok(listing) = fs::read_dir(dir) else { return };
        let mut entries: Vec<(SystemTime, u64, PathBuf)> = listing
            .flatten()
            .map(|e| (e.path(), e.metadata()))
            .filter(|(path, _)| is_entry(path) && path != kept)
            .filter_map(|(path, metadata)| {
                let metadata = metadata.ok().filter(fs::Metadata::is_file)?;
                Some((metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH), metadata.len(), path))
            })
            .collect();
        entries.sort();
        let mut total: u64 = entries.iter().map(|(_, len, _)| len).sum();
        for (_, len, path) in entries {
            if total <= bytes {
                break;
            }
            let _ = fs::remove_file(path);
            total -= len;
        }
    }
}

/// The time of the last use decides which entries are removed first. Without it, another order does no harm.
fn mark_used(path: &Path) {
    let _ = File::options().append(true).open(path).and_then(|f| f.set_modified(SystemTime::now()));
}

/// Whether a file is of a cache, finished or not.
fn is_entry(path: &Path) -> bool {
    let name = path.to_string_lossy();
    [EXTENSION, STATISTICS_EXTENSION, PIPELINE_EXTENSION, SCORES_EXTENSION].iter().any(|e| name.contains(e))
}

/// Fills `data` with what follows the header, and returns its CRC-32. Most of the time goes into the pages the
/// operating system copies and hands out, so several threads share the work.
fn read_values(path: &Path, data: &mut [f32]) -> Option<u32> {
    const PER_THREAD: usize = 1 << 21;
    // Small enough to be in the processor's cache still when it is summed up.
    const STEP: usize = 1 << 18;
    let pieces: Vec<crc32fast::Hasher> = data
        .par_chunks_mut(PER_THREAD)
        .enumerate()
        .map(|(i, piece)| {
            let mut file = File::open(path).ok()?;
            file.seek(SeekFrom::Start((HEADER_LEN + 4 * PER_THREAD * i) as u64)).ok()?;
            let mut sum = crc32fast::Hasher::new();
            for bytes in bytemuck::cast_slice_mut::<f32, u8>(piece).chunks_mut(STEP) {
                file.read_exact(bytes).ok()?;
                sum.update(bytes);
            }
            Some(sum)
        })
        .collect::<Option<_>>()?;
    let mut whole = crc32fast::Hasher::new();
    pieces.iter().for_each(|piece| whole.combine(piece));
    Some(whole.finalize())
}

struct Header {
    rows: usize,
    cols: usize,
    grid: WavelengthGrid,
    sample_spacing_m: f64,
    /// CRC-32 of the values: it finds damage, not malice.
    checksum: u32,
}

impl Header {
    fn bytes(&self, key: &Hash) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        out.extend(VERSION.to_le_bytes());
        out.extend(key.as_bytes());
        for n in [self.rows, self.cols, self.grid.len()] {
            out.extend((n as u64).to_le_bytes());
        }
        for v in [self.grid.start_nm(), self.grid.step_nm(), self.sample_spacing_m] {
            out.extend(v.to_le_bytes());
        }
        out.extend(self.checksum.to_le_bytes());
        let own = crc32fast::hash(&out);
        out.extend(own.to_le_bytes());
        out
    }

    fn parse(bytes: &[u8; HEADER_LEN], key: &Hash) -> Option<Self> {
        let (body, own) = bytes.split_last_chunk::<4>()?;
        if crc32fast::hash(body) != u32::from_le_bytes(*own) {
            return None;
        }
        let rest =
            body.strip_prefix(MAGIC)?.strip_prefix(&VERSION.to_le_bytes())?.strip_prefix(key.as_bytes())?;
        let (numbers, rest) = rest.as_chunks::<8>();
        let [rows, cols, count, start_nm, step_nm, spacing] = numbers.first_chunk::<6>()?;
        let size = |b: &[u8; 8]| usize::try_from(u64::from_le_bytes(*b)).ok();
        let float = |b: &[u8; 8]| f64::from_le_bytes(*b);
        Some(Self {
            rows: size(rows)?,
            cols: size(cols)?,
            grid: WavelengthGrid::new(float(start_nm), float(step_nm), size(count)?).ok()?,
            sample_spacing_m: float(spacing),
            checksum: u32::from_le_bytes(*rest.first_chunk()?),
        })
    }
}

#[cfg(test)]
mod tests {
    use smalti::experiment::LightFigures;

    use super::*;

    fn image(rows: usize, cols: usize, value: f32) -> OpticalImage {
        let grid = WavelengthGrid::new(400.0, 100.0 / 3.0, 4).unwrap();
        let data = (0..rows * cols * 4).map(|i| value + i as f32).collect();
        let planes = Planes::new(rows, cols, 4, data).unwrap();
        OpticalImage::new(SpectralCube::new(grid, planes).unwrap(), 1.1e-6).unwrap()
    }

    fn key(text: &str) -> Hash {
        hash(&[("test", text.as_bytes())])
    }

    #[test]
    fn an_image_comes_back_equal_and_another_key_finds_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::open(Some(dir.path().join("deep/cache")));
        assert_eq!(cache.get(&key("a")), None);
        cache.put(&key("a"), &image(5, 7, 0.1)).unwrap();
        assert_eq!(cache.get(&key("a")).unwrap(), image(5, 7, 0.1));
        assert_eq!(cache.get(&key("b")), None);
        let disabled = Cache::disabled();
        disabled.put(&key("a"), &image(5, 7, 0.1)).unwrap();
        assert_eq!(disabled.get(&key("a")), None);
    }

    #[test]
    fn labels_and_lengths_are_part_of_the_key() {
        assert_ne!(hash(&[("a", b"bc")]), hash(&[("ab", b"c")]));
        assert_ne!(hash(&[("a", b"b"), ("c", b"d")]), hash(&[("a", b"bcd")]));
        assert_eq!(hash(&[("x", b"y")]), hash(&[("x", b"y")]));
    }

    #[test]
    fn any_damage_is_found_and_mended() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::open(Some(dir.path().to_owned()));
        let k = key("a");
        cache.put(&k, &image(2, 3, 0.1)).unwrap();
        let path = cache.path(&k, EXTENSION).unwrap();
        let good = fs::read(&path).unwrap();
        for i in 0..good.len() {
            let mut bad = good.clone();
            bad[i] ^= 0x10;
            fs::write(&path, &bad).unwrap();
            assert_eq!(cache.get(&k), None, "byte {i}");
        }
        for cut in [0, 10, HEADER_LEN, good.len() - 1] {
            fs::write(&path, &good[..cut]).unwrap();
            assert_eq!(cache.get(&k), None, "cut at {cut}");
        }
        cache.put(&k, &image(2, 3, 0.1)).unwrap();
        assert_eq!(cache.get(&k).unwrap(), image(2, 3, 0.1));
    }

    #[test]
    fn scores_come_back_bit_for_bit() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::open(Some(dir.path().to_owned()));
        let lights = vec![LightFigures { metrics: [vec![0.1 + 0.2, 1e-17], vec![3.0], vec![]], time_s: 0.1 }];
        let scores = PictureFigures { lights };
        cache.keep_scores("a", &scores);
        assert_eq!(cache.scores("a"), Some(scores));
        assert_eq!(cache.scores("b"), None);
        let path = cache.path(&scores_key("a"), SCORES_EXTENSION).unwrap();
        fs::write(&path, "{").unwrap();
        assert_eq!(cache.scores("a"), None);
    }

    #[test]
    fn the_least_recently_used_goes_first() {
        let dir = tempfile::tempdir().unwrap();
        let one = (HEADER_LEN + 4 * 4 * 100) as u64;
        let cache = Cache { dir: Some(dir.path().to_owned()), limit_bytes: 3 * one };
        for name in ["a", "b", "c"] {
            cache.put(&key(name), &image(10, 10, 1.0)).unwrap();
            std::thread::sleep(std::time::Duration::from_millis(15));
        }
        assert!(cache.get(&key("a")).is_some());
        cache.put(&key("d"), &image(10, 10, 1.0)).unwrap();
        let there: Vec<bool> = ["a", "b", "c", "d"].iter().map(|n| cache.get(&key(n)).is_some()).collect();
        assert_eq!(there, [true, false, true, true]);
        cache.put(&key("big"), &image(40, 40, 1.0)).unwrap();
        assert!(cache.get(&key("big")).is_none());
        assert!(cache.get(&key("d")).is_some());
    }
}
