//! Moments of every class, accumulated from pairs of raw image and target in one pass.

use std::collections::BTreeMap;

use super::error::{ensure_finite, ensure_same_size};
use super::gather::Gatherer;
use super::{Axes, ClassKey, L3Error, Moments, Pair, Tiles};
use crate::sensor::{Cfa, Mosaic, RawImage, Sampling};

/// Moments of every class in the training data. Equal pairs in equal order give equal bits for any number of
/// threads. Separately accumulated statistics can be merged.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistics {
    axes: Axes,
    outputs: Vec<String>,
    channel_names: Vec<String>,
    levels: Option<[f64; 2]>,
    noisy: bool,
    white: Option<[f64; 3]>,
    trained: Vec<[f32; 2]>,
    classes: BTreeMap<ClassKey, Moments>,
}

impl Statistics {
    /// Empty statistics. `noisy` states whether the raw images contain their noise; if not, training adds
    /// that of the axes to the moments.
    ///
    /// # Errors
    /// When there is no output.
    pub fn new(axes: Axes, outputs: Vec<String>, noisy: bool) -> Result<Self, L3Error> {
        if outputs.is_empty() {
            return Err(L3Error::EmptyAxis("output"));
        }
        let trained = vec![[f32::INFINITY, f32::NEG_INFINITY]; axes.positions()];
        let channel_names = (0..axes.mosaic().channels()).map(|c| c.to_string()).collect();
        Ok(Self {
            axes,
            outputs,
            channel_names,
            levels: None,
            noisy,
            white: None,
            trained,
            classes: BTreeMap::new(),
        })
    }

    /// Statistics from stored moments.
    ///
    /// # Errors
    /// When moments have the wrong size, or a key is not on the axes.
    #[allow(clippy::too_many_arguments)]
    pub fn from_parts(
        axes: Axes,
        outputs: Vec<String>,
        channel_names: Vec<String>,
        levels: Option<[f64; 2]>,
        noisy: bool,
        trained: Vec<[f32; 2]>,
        classes: BTreeMap<ClassKey, Moments>,
    ) -> Result<Self, L3Error> {
        let empty = Self::new(axes, outputs, noisy)?;
        let size = 1 + empty.axes.taps() + empty.outputs.len();
        let channels = empty.axes.mosaic().channels();
        let wrong = |reason: &str| Err(L3Error::Table(reason.into()));
        if classes.values().any(|m| m.size() != size) {
            return wrong("moments of another size than patch and outputs");
        }
        let fits = |k: &ClassKey| {
            (k.position as usize) < empty.axes.positions()
                && u64::from(k.saturation) < 1u64 << channels
                && usize::from(k.level) < empty.axes.level_count()
                && usize::from(k.texture) < empty.axes.textures().count()
        };
        if !classes.keys().all(fits) {
            return wrong("a class beyond the axes");
        }
        if trained.len() != empty.trained.len() || channel_names.len() != channels {
            return wrong("trained ranges or channel names do not match the mosaic");
        }
        if levels.is_some_and(|[black, white]| !(black.is_finite() && white.is_finite() && white > black)) {
            return wrong("white level must lie above black level");
        }
        Ok(Self { channel_names, levels, trained, classes, ..empty })
    }

    /// The class axes.
    #[must_use]
    pub fn axes(&self) -> &Axes {
        &self.axes
    }

    /// Names of the outputs.
    #[must_use]
    pub fn outputs(&self) -> &[String] {
        &self.outputs
    }

    /// Names of the channels of the raw images.
    #[must_use]
    pub fn channel_names(&self) -> &[String] {
        &self.channel_names
    }

    /// Black and white level of the raw images, after the first one.
    #[must_use]
    pub fn raw_levels(&self) -> Option<[f64; 2]> {
        self.levels
    }

    /// The statistics with the white point of the targets, X, Y, Z with Y = 1, which pipelines inherit
    /// ([`super::Pipeline::white`]).
    #[must_use]
    pub fn with_white(self, white: Option<[f64; 3]>) -> Self {
        Self { white, ..self }
    }

    /// White point of the targets, X, Y, Z with Y = 1, if it is known.
    #[must_use]
    pub fn white(&self) -> Option<[f64; 3]> {
        self.white
    }

    /// Whether the raw images contain their noise.
    #[must_use]
    pub fn noisy(&self) -> bool {
        self.noisy
    }

    /// Smallest and largest mean response of a patch, for each position; infinite where there is no data.
    #[must_use]
    pub fn trained(&self) -> &[[f32; 2]] {
        &self.trained
    }

    /// The moments of every class in the training data.
    #[must_use]
    pub fn classes(&self) -> &BTreeMap<ClassKey, Moments> {
        &self.classes
    }

    /// Number of training patches.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.classes.values().map(Moments::count).sum()
    }

    /// Adds other statistics.
    ///
    /// # Errors
    /// When axes, outputs, levels or noise differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), L3Error> {
        let differ = |what| Err(L3Error::Mismatch(what));
        if self.axes != other.axes {
            return differ("mosaic, patch, levels or noise");
        }
        if self.outputs != other.outputs {
            return differ("outputs");
        }
        if self.noisy != other.noisy {
            return differ("raw images (with and without noise)");
        }
        if self.white != other.white {
            return differ("target whites");
        }
        if self.levels.is_some() && other.levels.is_some() && self.levels != other.levels {
            return differ("black and white levels");
        }
        self.levels = self.levels.or(other.levels);
        if other.levels.is_some() {
            self.channel_names.clone_from(&other.channel_names);
        }
        for (mine, its) in self.trained.iter_mut().zip(&other.trained) {
            *mine = [mine[0].min(its[0]), mine[1].max(its[1])];
        }
        for (key, moments) in &other.classes {
            self.class_mut(*key).merge(moments);
        }
        Ok(())
    }

    pub(super) fn class_mut(&mut self, key: ClassKey) -> &mut Moments {
        let (taps, outputs) = (self.axes.taps(), self.outputs.len());
        self.classes.entry(key).or_insert_with(|| Moments::new(taps, outputs))
    }

    /// Adds every patch of a pair that lies completely within the image.
    ///
    /// # Errors
    /// When sizes, mosaics or levels do not match earlier pairs, the image is smaller than patch or tile, or
    /// a value is not finite. The statistics are then unchanged.
    pub fn add(&mut self, pair: &Pair<'_>) -> Result<(), L3Error> {
        self.add_tiles(pair, Tiles::All)
    }

    /// Adds the patches around the pixels of some tiles that lie completely within the image.
    ///
    /// # Errors
    /// As [`Statistics::add`].
    pub fn add_tiles(&mut self, pair: &Pair<'_>, tiles: Tiles) -> Result<(), L3Error> {
        let phase = self.check(pair)?;
        let gatherer = Gatherer::new(&self.axes, self.outputs.len(), (pair, tiles), phase);
        for band in gatherer.bands() {
            gatherer.add(band, &mut self.trained, &mut self.classes);
        }
        Ok(())
    }

    /// Widens the range of mean responses that patches at a position have been learned from.
    pub(super) fn widen_trained(&mut self, position: usize, mean: f32) {
        let range = &mut self.trained[position];
        *range = [range[0].min(mean), range[1].max(mean)];
    }

    /// Checks a pair and returns the position of the image's first pixel in the tile.
    fn check(&mut self, pair: &Pair<'_>) -> Result<[usize; 2], L3Error> {
        let raw = pair.raw;
        // The names of the channels are those of the first image.
        let names = self.levels.map_or(&[][..], |_| &self.channel_names);
        let phase = phase_in(self.axes.mosaic(), names, raw)?;
        let (rows, cols) = (raw.rows(), raw.cols());
        check_size(&self.axes, rows, cols)?;
        ensure_same_size("the target", [rows, cols], [pair.target.rows(), pair.target.cols()])?;
        // Images to render later have the levels of the classified image; the training image may be in volts.
        let as_seen = pair.seen.unwrap_or(raw);
        let levels = [as_seen.black_level(), as_seen.white_level()];
        if let Some(seen) = pair.seen {
            let got = [seen.rows(), seen.cols()];
            ensure_same_size("the image that determines its classes", [rows, cols], got)?;
            if seen.sampling() != raw.sampling() {
                return Err(L3Error::Mosaics);
            }
        }
        if pair.target.count() != self.outputs.len() {
            return Err(L3Error::Outputs { expected: self.outputs.len(), got: pair.target.count() });
        }
        for (plane, name) in pair.target.planes().zip(&self.outputs) {
            ensure_finite(&format!("plane {name} of the target"), plane, cols)?;
        }
        for image in [Some(raw), pair.seen].into_iter().flatten() {
            if let crate::sensor::RawSamples::Analog(v) = image.samples() {
                ensure_finite("the raw image", v, cols)?;
            }
        }
        match self.levels {
            Some(expected) if expected != levels => Err(L3Error::RawLevels { expected, got: levels }),
            _ => {
                self.levels = Some(levels);
                self.channel_names = raw.channel_names().to_vec();
                Ok(phase)
            }
        }
    }
}

/// The position of a raw image's first pixel in the tile. `names` are the names of the tile's channels, which the image must have as
/// well; empty where they are not known.
pub(super) fn phase_in(mosaic: &Mosaic, names: &[String], raw: &RawImage) -> Result<[usize; 2], L3Error> {
    let Sampling::Mosaic(got) = raw.sampling() else { return Err(L3Error::NoMosaic) };
    let same_names = names.is_empty() || names == raw.channel_names();
    let cells = (0..mosaic.rows()).flat_map(|r| (0..mosaic.cols()).map(move |c| [r, c]));
    let mut shifts = cells.filter(|&[r, c]| same_names && mosaic.shifted(r, c) == *got);
    shifts.next().ok_or_else(|| L3Error::Mosaic {
        expected: listed(mosaic, names),
        got: listed(got, raw.channel_names()),
    })
}

/// Checks that a raw image has the mosaic of a colour filter array, at any phase, and the names of its channels.
///
/// # Errors
/// [`L3Error::NoMosaic`] or [`L3Error::Mosaic`].
pub fn ensure_mosaic_of(cfa: &Cfa, raw: &RawImage) -> Result<(), L3Error> {
    let names: Vec<String> = cfa.channels().iter().map(|c| c.name.clone()).collect();
    phase_in(cfa.mosaic(), &names, raw).map(drop)
}

/// Size and cells of a tile, abbreviated.
pub(super) fn listed(mosaic: &Mosaic, names: &[String]) -> String {
    let cells = mosaic.cells();
    let name = |&c: &u8| names.get(usize::from(c)).cloned().unwrap_or_else(|| c.to_string());
    let shown: Vec<String> = cells.iter().take(16).map(name).collect();
    let rest = if cells.len() > 16 { " …" } else { "" };
    format!("{} × {} with channels {}{rest}", mosaic.rows(), mosaic.cols(), shown.join(" "))
}

/// An image must contain a patch and every phase of the tile.
pub(super) fn check_size(axes: &Axes, rows: usize, cols: usize) -> Result<(), L3Error> {
    let (size, least) =
        ([rows, cols], [axes.mosaic().rows(), axes.mosaic().cols()].map(|n| n.max(axes.side())));
    let fits = rows >= least[0] && cols >= least[1];
    if fits { Ok(()) } else { Err(L3Error::Size { size, least }) }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::l3::Levels;
    use crate::numeric::Planes;
    use crate::numeric::philox::Stream;
    use crate::sensor::{RawSamples, SignalNoise};

    fn pair(rows: usize, cols: usize, seed: u64) -> (RawImage, Planes) {
        let mut random = Stream::new(seed, 1, 2);
        let samples = (0..rows * cols).map(|_| 64 + (random.next_u32() % 961) as u16).collect();
        let mosaic = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
        let names = ["R", "G", "B"].map(String::from).to_vec();
        let sampling = Sampling::Mosaic(mosaic);
        let raw =
            RawImage::new(rows, cols, RawSamples::Digital(samples), sampling, names, 64.0, 1023.0).unwrap();
        let target = (0..2 * rows * cols).map(|_| random.uniform() as f32).collect();
        (raw, Planes::new(rows, cols, 2, target).unwrap())
    }

    pub(in crate::l3) fn axes() -> Axes {
        let mosaic = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
        let noise = SignalNoise { constant: 1e-6, per_signal: 1e-4, ..SignalNoise::default() };
        Axes::new(mosaic, 5, Levels::logarithmic(4, 0.1, 0.8).unwrap(), noise).unwrap()
    }

    /// Every patch is counted once, and the sums follow the definition.
    #[test]
    fn sums_are_what_they_say() {
        let (raw, target) = pair(150, 41, 3);
        let mut s = Statistics::new(axes(), vec!["a".into(), "b".into()], true).unwrap();
        s.add(&Pair { raw: &raw, seen: None, target: &target }).unwrap();
        assert_eq!(s.count(), (150 - 4) * (41 - 4));
        let mut total = Moments::new(25, 2);
        s.classes().values().for_each(|m| total.merge(m));
        let x = raw.normalized();
        let mut expected = 0.0;
        for r in 2..148 {
            for c in 2..39 {
                // The top left sample of the patch times the second target.
                expected +=
                    f64::from(x[(r - 2) * 41 + c - 2]) * f64::from(target.plane(1).unwrap()[r * 41 + c]);
            }
        }
        assert!((total.get(1, 27) - expected).abs() < 1e-9 * expected);
    }

    #[test]
    fn parts_merge_to_the_whole() {
        let pairs = [pair(70, 64, 1), pair(140, 33, 2)];
        let outputs = || vec!["a".to_owned(), "b".to_owned()];
        let gather = |list: &[&(RawImage, Planes)]| {
            let mut s = Statistics::new(axes(), outputs(), true).unwrap();
            list.iter().for_each(|(raw, target)| s.add(&Pair { raw, seen: None, target }).unwrap());
            s
        };
        let whole = gather(&[&pairs[0], &pairs[1]]);
        let mut parts = gather(&[&pairs[0]]);
        parts.merge(&gather(&[&pairs[1]])).unwrap();
        assert_eq!(whole.count(), parts.count());
        for (key, moments) in whole.classes() {
            let other = &parts.classes()[key];
            for (a, b) in moments.sums().iter().zip(other.sums()) {
                assert!((a - b).abs() <= 1e-12 * a.abs(), "{key:?}");
            }
        }
    }

    /// Every patch belongs to one of the halves, and each position of the tile has as many in both.
    #[test]
    fn halves_merge_to_the_whole() {
        // One column more than whole tiles, so that the tiles at the right are cut.
        let (raw, target) = pair(140, 61, 4);
        let gather = |tiles| {
            let mut s = Statistics::new(axes(), vec!["a".into(), "b".into()], true).unwrap();
            s.add_tiles(&Pair { raw: &raw, seen: None, target: &target }, tiles).unwrap();
            s
        };
        let (whole, even, odd) = (gather(Tiles::All), gather(Tiles::Even), gather(Tiles::Odd));
        let at = |s: &Statistics, position: u32| {
            let classes = s.classes().iter().filter(|(key, _)| key.position == position);
            classes.map(|(_, m)| m.count()).sum::<u64>()
        };
        for position in 0..4 {
            let [all, even, odd] = [&whole, &even, &odd].map(|s| at(s, position));
            assert!(even + odd == all && even.abs_diff(odd) <= all / 20, "{position}: {even} and {odd}");
        }
        let mut merged = even;
        merged.merge(&odd).unwrap();
        assert_eq!(merged.trained(), whole.trained());
        for (key, moments) in whole.classes() {
            let other = &merged.classes()[key];
            assert_eq!(moments.count(), other.count());
            for (a, b) in moments.sums().iter().zip(other.sums()) {
                assert!((a - b).abs() <= 1e-12 * a.abs(), "{key:?}");
            }
        }
    }

    #[test]
    fn statistics_are_their_parts() {
        let (raw, target) = pair(40, 33, 5);
        let mut s = Statistics::new(axes(), vec!["a".into(), "b".into()], true).unwrap();
        s.add(&Pair { raw: &raw, seen: None, target: &target }).unwrap();
        let of = |outputs: Vec<String>, names: &[String], levels, trained: &[[f32; 2]]| {
            let (names, trained) = (names.to_vec(), trained.to_vec());
            Statistics::from_parts(axes(), outputs, names, levels, true, trained, s.classes().clone())
        };
        let (names, levels, trained) = (s.channel_names(), s.raw_levels(), s.trained());
        assert!(trained.iter().all(|[least, most]| least < most && least.is_finite()));
        assert_eq!(of(s.outputs().to_vec(), names, levels, trained), Ok(s.clone()));
        let refused = |found: Result<Statistics, L3Error>| matches!(found, Err(L3Error::Table(_)));
        let outputs = || s.outputs().to_vec();
        assert!(refused(of(vec!["a".into()], names, levels, trained)));
        assert!(refused(of(outputs(), &names[1..], levels, trained)));
        assert!(refused(of(outputs(), names, Some([64.0, 64.0]), trained)));
        assert!(refused(of(outputs(), names, levels, &trained[1..])));
        let off_axis = |change: fn(&mut ClassKey)| {
            let mut key = *s.classes().keys().next().unwrap();
            change(&mut key);
            let classes = BTreeMap::from([(key, Moments::new(25, 2))]);
            let (names, trained) = (names.to_vec(), trained.to_vec());
            Statistics::from_parts(axes(), outputs(), names, levels, true, trained, classes)
        };
        assert!(off_axis(|_| ()).is_ok());
        let changes: [fn(&mut ClassKey); 4] =
            [|k| k.position = 4, |k| k.saturation = 8, |k| k.level = 4, |k| k.texture = 2];
        assert!(changes.into_iter().all(|change| refused(off_axis(change))));
    }
}
