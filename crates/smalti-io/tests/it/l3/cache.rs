//! What is kept comes back as it was, and nothing else does.

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use smalti::camera::CameraError;
use smalti::experiment::{LightFigures, PictureFigures, Store};
use smalti::l3::{Pipeline, Statistics};
use smalti::numeric::Planes;
use smalti::optics::OpticalImage;
use smalti::spectrum::{SpectralCube, WavelengthGrid};
use smalti_io::cache::{Cache, CacheLimits, EntryKind};
use smalti_io::studio::StudioAsset;

use super::fixtures::{bayer, picture_pipeline, second_stage, statistics};

fn image(side: usize, value: f32) -> OpticalImage {
    let grid = WavelengthGrid::new(400.0, 100.0 / 3.0, 4).unwrap();
    let data = (0..side * side * 4).map(|i| value + i as f32).collect();
    let planes = Planes::new(side, side, 4, data).unwrap();
    OpticalImage::new(SpectralCube::new(grid, planes).unwrap(), 1.1e-6).unwrap()
}

/// One entry of every kind; two numbers give different entries.
struct Entries {
    image: OpticalImage,
    statistics: Statistics,
    pipeline: Pipeline,
    scores: PictureFigures,
    studio: Vec<StudioAsset>,
}

fn entries(number: u8) -> Entries {
    let value = f64::from(number) + 0.1 + 0.2;
    let lights = vec![LightFigures { metrics: [vec![value, 1e-17], vec![3.0], vec![]], time_s: 0.1 }];
    Entries {
        image: image(3, f32::from(number) + 0.1),
        statistics: statistics(&bayer(), (number > 1).then_some([0.0, 1023.0])),
        pipeline: picture_pipeline().with_refinement((number > 1).then(second_stage)).unwrap(),
        scores: PictureFigures { lights },
        studio: ["a.json", "b.bin"]
            .map(|name| StudioAsset { name: name.into(), bytes: vec![number; 5] })
            .to_vec(),
    }
}

impl Entries {
    fn keep(&self, cache: &Cache, key: &str) {
        let made = Store::optical_image(cache, key, &|| Ok(self.image.clone()));
        assert_eq!(made.unwrap(), self.image);
        cache.keep_statistics(key, &self.statistics);
        cache.keep_pipeline(key, &self.pipeline);
        cache.keep_scores(key, &self.scores);
        cache.keep_studio_assets(key, &self.studio);
    }

    /// Whether the cache has the entry of a kind; it must then be this one.
    fn is_kept(&self, cache: &Cache, key: &str, kind: EntryKind) -> bool {
        let none = || Err(CameraError::Text { message: "nothing is kept".into() });
        match kind {
            EntryKind::OpticalImage => found(Store::optical_image(cache, key, &none).ok(), &self.image),
            EntryKind::Statistics => found(cache.statistics(key), &self.statistics),
            EntryKind::Pipeline => found(cache.pipeline(key), &self.pipeline),
            EntryKind::Scores => found(cache.scores(key), &self.scores),
            _ => found(cache.studio_assets(key), &self.studio),
        }
    }
}

fn found<T: PartialEq>(kept: Option<T>, expected: &T) -> bool {
    assert!(kept.as_ref().is_none_or(|kept| kept == expected), "another entry was used");
    kept.is_some()
}

fn extension(kind: EntryKind) -> &'static str {
    match kind {
        EntryKind::OpticalImage => "smalti-oi",
        EntryKind::Statistics => "smalti-l3",
        EntryKind::Pipeline => "smalti-l3-best",
        EntryKind::Scores => "smalti-scores",
        _ => "smalti-studio",
    }
}

/// The files of a kind, by their names.
fn files(dir: &Path, kind: EntryKind) -> Vec<PathBuf> {
    let paths = std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().path());
    let mut paths: Vec<PathBuf> =
        paths.filter(|p| p.extension().is_some_and(|e| e == extension(kind))).collect();
    paths.sort();
    paths
}

fn cache_in(dir: &tempfile::TempDir) -> Cache {
    Cache::within(dir.path().join("deep/cache"), CacheLimits::default())
}

#[test]
fn every_kind_comes_back_equal_and_another_key_finds_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let cache = cache_in(&dir);
    let one = entries(1);
    for kind in EntryKind::ALL {
        assert!(!one.is_kept(&cache, "a", kind));
    }
    one.keep(&cache, "a");
    one.keep(&Cache::disabled(), "a");
    for kind in EntryKind::ALL {
        assert!(one.is_kept(&cache, "a", kind), "{kind:?}");
        assert!(!one.is_kept(&cache, "b", kind), "{kind:?}");
        assert!(!one.is_kept(&Cache::disabled(), "a", kind), "{kind:?}");
    }
}

/// Two whole entries, each under the name of the other: neither is used, and both are made again.
#[test]
fn exchanged_entries_are_not_used() {
    let dir = tempfile::tempdir().unwrap();
    let cache = cache_in(&dir);
    let (one, two) = (entries(1), entries(2));
    one.keep(&cache, "a");
    two.keep(&cache, "b");
    for kind in EntryKind::ALL {
        let paths = files(cache.folder().unwrap(), kind);
        let [first, second] = paths.as_slice() else { panic!("{paths:?}") };
        let (bytes, others) = (std::fs::read(first).unwrap(), std::fs::read(second).unwrap());
        std::fs::write(first, others).unwrap();
        std::fs::write(second, bytes).unwrap();
        assert!(!one.is_kept(&cache, "a", kind) && !two.is_kept(&cache, "b", kind), "{kind:?}");
    }
    one.keep(&cache, "a");
    two.keep(&cache, "b");
    for kind in EntryKind::ALL {
        assert!(one.is_kept(&cache, "a", kind) && two.is_kept(&cache, "b", kind), "{kind:?}");
    }
}

#[test]
fn any_damage_is_found_and_mended() {
    let dir = tempfile::tempdir().unwrap();
    let cache = cache_in(&dir);
    let one = entries(1);
    one.keep(&cache, "a");
    for kind in EntryKind::ALL {
        let path = files(cache.folder().unwrap(), kind).remove(0);
        let good = std::fs::read(&path).unwrap();
        let header = 60;
        // All of the header, and the content in steps.
        for at in (0..header).chain((header..good.len()).step_by(1 + good.len() / 200)) {
            let mut bad = good.clone();
            bad[at] ^= 0x10;
            std::fs::write(&path, &bad).unwrap();
            assert!(!one.is_kept(&cache, "a", kind), "{kind:?}: byte {at}");
        }
        for cut in [0, 10, header, good.len() - 1] {
            std::fs::write(&path, &good[..cut]).unwrap();
            assert!(!one.is_kept(&cache, "a", kind), "{kind:?}: cut at {cut}");
        }
        std::fs::write(&path, [good.as_slice(), b"x"].concat()).unwrap();
        assert!(!one.is_kept(&cache, "a", kind), "{kind:?}: longer");
        std::fs::write(&path, "{}").unwrap();
        assert!(!one.is_kept(&cache, "a", kind), "{kind:?}: another file");
        one.keep(&cache, "a");
        assert!(one.is_kept(&cache, "a", kind), "{kind:?}");
    }
}

/// A pipe in the place of an entry has no writer: to open it would take forever.
#[cfg(target_os = "linux")]
#[test]
fn a_pipe_is_no_entry() {
    let dir = tempfile::tempdir().unwrap();
    let cache = cache_in(&dir);
    let one = entries(1);
    one.keep(&cache, "a");
    for kind in EntryKind::ALL {
        let path = files(cache.folder().unwrap(), kind).remove(0);
        std::fs::remove_file(&path).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        assert!(!one.is_kept(&cache, "a", kind), "{kind:?}");
        one.keep(&cache, "a");
        assert!(one.is_kept(&cache, "a", kind), "{kind:?}");
    }
}

fn ago(days: f64) -> SystemTime {
    let span = Duration::from_secs_f64(days.abs() * 86400.0);
    if days < 0.0 { SystemTime::now() + span } else { SystemTime::now() - span }
}

/// Keeps an image, last used so many days ago.
fn used(cache: &Cache, key: &str, side: usize, days: f64) {
    let before = files(cache.folder().unwrap(), EntryKind::OpticalImage);
    cache.optical_image(key, &|| Ok::<_, CameraError>(image(side, 1.0))).unwrap();
    let mut after = files(cache.folder().unwrap(), EntryKind::OpticalImage);
    after.retain(|path| !before.contains(path));
    let time = ago(days);
    std::fs::File::options().append(true).open(after.remove(0)).unwrap().set_modified(time).unwrap();
}

fn has(cache: &Cache, key: &str) -> bool {
    cache.optical_image(key, &|| Err(())).is_ok()
}

#[test]
fn the_least_recently_used_goes_first() {
    let dir = tempfile::tempdir().unwrap();
    let one = (60 + 48 + 4 * 4 * 100) as u64;
    let limits = CacheLimits { bytes: 3 * one, ..CacheLimits::default() };
    let cache = Cache::within(dir.path().to_owned(), limits);
    let others = ["mine.smalti-oi", "notes.txt"].map(|name| dir.path().join(name));
    others.iter().for_each(|path| std::fs::write(path, [0; 5000]).unwrap());
    for (key, days) in [("a", 3.0), ("b", 2.0), ("c", 1.0)] {
        used(&cache, key, 10, days);
    }
    assert!(has(&cache, "a"));
    used(&cache, "d", 10, 0.0);
    assert_eq!(["a", "b", "c", "d"].map(|key| has(&cache, key)), [true, false, true, true]);
    let content = cache.content().unwrap();
    assert_eq!((content[0].entries, content[0].bytes), (3, 3 * one));
    // One larger than the limit is not kept and displaces nothing.
    cache.optical_image("big", &|| Ok::<_, CameraError>(image(40, 1.0))).unwrap();
    assert_eq!(["big", "d"].map(|key| has(&cache, key)), [false, true]);
    // All kinds count.
    cache.keep_scores("s", &entries(1).scores);
    assert!(total(&cache) <= 3 * one);
    let content = cache.content().unwrap();
    assert_eq!([content[0].entries, content[3].entries], [2, 1], "an image made room for scores");
    assert_eq!(cache.clear().unwrap(), content.iter().map(|u| u.bytes).sum::<u64>());
    assert_eq!(total(&cache), 0);
    others.iter().for_each(|path| assert!(path.exists(), "{} is no entry", path.display()));
}

fn total(cache: &Cache) -> u64 {
    cache.content().unwrap().iter().map(|u| u.bytes).sum()
}

#[test]
fn what_was_not_used_for_long_goes_whatever_the_size() {
    let dir = tempfile::tempdir().unwrap();
    let limits = CacheLimits { unused: Duration::from_secs(10 * 86400), ..CacheLimits::default() };
    let cache = Cache::within(dir.path().to_owned(), limits);
    for (key, days) in [("a", 12.0), ("b", 8.0), ("c", -3.0)] {
        used(&cache, key, 4, days);
    }
    // Reading is a use; "a" was not read.
    used(&cache, "d", 4, 0.0);
    assert_eq!(["a", "b", "c", "d"].map(|key| has(&cache, key)), [false, true, true, true]);
}
