//! Moments of every class, gathered from pairs of raw image and target in one pass.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::classify::{Classifier, RowClasses};
use super::window::Window;
use super::{Axes, ClassKey, L3Error, Moments};
use crate::isp::source::Source;
use crate::numeric::Planes;
use crate::numeric::simd::{Kernel, dispatch};
use crate::sensor::{Mosaic, RawImage, Sampling};

/// Rows that are taken at a time: what bounds the memory.
const BAND_ROWS: usize = 128;
/// Rows that one task classifies.
const TASK_ROWS: usize = 16;
/// Patches of a class that one task sums. Sums of tasks are added in order, so that no bit depends on the threads.
const TASK_PATCHES: usize = 4096;
/// Patches that lie in the cache while they are summed.
const BATCH: usize = 64;

/// A raw image and what should come of it.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// The samples that are learned from: without noise where the noise is added by computation
    /// ([`Statistics::new`]), as taken otherwise.
    pub raw: &'a RawImage,
    /// The image that patches are classified by, of the same size: with noise, as later images will have it. `None`: `raw`.
    pub seen: Option<&'a RawImage>,
    /// One plane per output, of the size of the raw image; finite.
    pub target: &'a Planes,
}

/// Moments of every class that has been seen. Equal pairs in equal order give equal bits for any number of threads; two that
/// were gathered apart can be merged.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistics {
    axes: Axes,
    outputs: Vec<String>,
    channel_names: Vec<String>,
    levels: Option<[f64; 2]>,
    noisy: bool,
    trained: Vec<[f32; 2]>,
    classes: BTreeMap<ClassKey, Moments>,
}

impl Statistics {
    /// Of nothing yet. `noisy` tells whether the raw images hold their noise; where they do not, solving adds that of the
    /// axes to the moments.
    ///
    /// # Errors
    /// When there is no output.
    pub fn new(axes: Axes, outputs: Vec<String>, noisy: bool) -> Result<Self, L3Error> {
        if outputs.is_empty() {
            return Err(L3Error::EmptyAxis { axis: "output" });
        }
        let trained = vec![[f32::INFINITY, f32::NEG_INFINITY]; axes.positions()];
        let channel_names = (0..axes.mosaic().channels()).map(|c| c.to_string()).collect();
        Ok(Self { axes, outputs, channel_names, levels: None, noisy, trained, classes: BTreeMap::new() })
    }

    /// From moments that were saved.
    ///
    /// # Errors
    /// When moments are of another size, or a key is not one of the axes.
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
        let wrong = |reason: &str| Err(L3Error::Table { reason: reason.into() });
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

    /// How patches are classified.
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

    /// Black and white level of the raw images, once one has been seen.
    #[must_use]
    pub fn raw_levels(&self) -> Option<[f64; 2]> {
        self.levels
    }

    /// Whether the raw images hold their noise.
    #[must_use]
    pub fn noisy(&self) -> bool {
        self.noisy
    }

    /// Least and largest mean response of a patch, for each position; infinite where none was seen.
    #[must_use]
    pub fn trained(&self) -> &[[f32; 2]] {
        &self.trained
    }

    /// The moments of every class that has been seen.
    #[must_use]
    pub fn classes(&self) -> &BTreeMap<ClassKey, Moments> {
        &self.classes
    }

    /// Number of patches seen.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.classes.values().map(Moments::count).sum()
    }

    /// Adds what another has seen.
    ///
    /// # Errors
    /// When axes, outputs, levels or noise differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), L3Error> {
        let differ = |what| Err(L3Error::Mismatch { what });
        if self.axes != other.axes {
            return differ("mosaic, patch, levels or noise");
        }
        if self.outputs != other.outputs {
            return differ("outputs");
        }
        if self.noisy != other.noisy {
            return differ("whether raw images hold noise");
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

    fn class_mut(&mut self, key: ClassKey) -> &mut Moments {
        let (taps, outputs) = (self.axes.taps(), self.outputs.len());
        self.classes.entry(key).or_insert_with(|| Moments::new(taps, outputs))
    }

    /// Adds every patch of a pair that lies within the image.
    ///
    /// # Errors
    /// When sizes, mosaics or levels do not match those before, the image is smaller than patch or tile, or a value is not finite.
    /// Nothing has been added then.
    pub fn add(&mut self, pair: &Pair<'_>) -> Result<(), L3Error> {
        let phase = self.check(pair)?;
        let (rows, cols, half) = (pair.raw.rows(), pair.raw.cols(), self.axes.side() / 2);
        let classifier = Classifier::new(&self.axes);
        let mut first = half;
        while first + half < rows {
            let band = BAND_ROWS.min(rows - half - first);
            self.add_band(pair, &classifier, phase, first, band, half..cols - half);
            first += band;
        }
        Ok(())
    }

    /// The place in the tile of the image's first pixel, when all is as it should be.
    fn check(&mut self, pair: &Pair<'_>) -> Result<[usize; 2], L3Error> {
        let raw = pair.raw;
        let phase = phase_in(self.axes.mosaic(), raw)?;
        let (rows, cols) = (raw.rows(), raw.cols());
        check_size(&self.axes, rows, cols)?;
        let size = |what, got_rows, got_cols| {
            let same = (rows, cols) == (got_rows, got_cols);
            if same { Ok(()) } else { Err(L3Error::PairSize { what, rows, cols, got_rows, got_cols }) }
        };
        size("the target", pair.target.rows(), pair.target.cols())?;
        let levels = [raw.black_level(), raw.white_level()];
        if let Some(seen) = pair.seen {
            size("the image it is classified by", seen.rows(), seen.cols())?;
            if seen.sampling() != raw.sampling() {
                return Err(L3Error::Mismatch { what: "the mosaics of the two raw images" });
            }
        }
        if pair.target.count() != self.outputs.len() {
            return Err(L3Error::Outputs { expected: self.outputs.len(), got: pair.target.count() });
        }
        let finite = |what: String, values: &[f32]| match values.iter().position(|v| !v.is_finite()) {
            None => Ok(()),
            Some(i) => Err(L3Error::Value { what, row: i / cols, col: i % cols, value: values[i] }),
        };
        for (plane, name) in pair.target.planes().zip(&self.outputs) {
            finite(format!("plane {name} of the target"), plane)?;
        }
        for image in [Some(raw), pair.seen].into_iter().flatten() {
            if let crate::sensor::RawSamples::Analog(v) = image.samples() {
                finite("the raw image".into(), v)?;
            }
        }
        match self.levels {
            Some([black, white]) if [black, white] != levels => {
                Err(L3Error::RawLevels { black, white, got_black: levels[0], got_white: levels[1] })
            }
            _ => {
                self.levels = Some(levels);
                self.channel_names = raw.channel_names().to_vec();
                Ok(phase)
            }
        }
    }

    fn add_band(
        &mut self,
        pair: &Pair<'_>,
        classifier: &Classifier,
        phase: [usize; 2],
        first: usize,
        rows: usize,
        cols: std::ops::Range<usize>,
    ) {
        let tile = [self.axes.mosaic().rows(), self.axes.mosaic().cols()];
        let (half, side, outputs) = (self.axes.side() / 2, self.axes.side(), self.outputs.len());
        let textures = self.axes.textures().count() as u32;
        let seen = Source::of(pair.seen.unwrap_or(pair.raw));
        // Which class, and which pixel: sorted by class, in order of pixels within.
        let tasks: Vec<usize> = (0..rows).step_by(TASK_ROWS).collect();
        let classified: Vec<(BTreeMap<ClassKey, Vec<u32>>, Vec<[f32; 2]>)> = tasks
            .into_par_iter()
            .map_init(<(Window, RowClasses)>::default, |(window, classes), at| {
                let count = TASK_ROWS.min(rows - at);
                window.read(seen, first + at, count, classifier.margin(), tile);
                let mut found: BTreeMap<ClassKey, Vec<u32>> = BTreeMap::new();
                let mut trained = vec![[f32::INFINITY, f32::NEG_INFINITY]; self.axes.positions()];
                for r in 0..count {
                    let down = (phase[0] + first + at + r) % tile[0];
                    classifier.row(window, r, [down, phase[1]], 0..pair.raw.cols(), classes);
                    for col in cols.clone() {
                        let position = (down * tile[1] + (phase[1] + col) % tile[1]) as u32;
                        let local = classes.local[col];
                        let key = ClassKey {
                            position,
                            saturation: classes.saturation[col],
                            level: (local / textures) as u16,
                            texture: (local % textures) as u16,
                        };
                        let range = &mut trained[position as usize];
                        *range = [range[0].min(classes.mean[col]), range[1].max(classes.mean[col])];
                        let pixel = (at + r) * pair.raw.cols() + col;
                        found.entry(key).or_default().push(pixel as u32);
                    }
                }
                (found, trained)
            })
            .collect();
        let mut members: BTreeMap<ClassKey, Vec<u32>> = BTreeMap::new();
        for (found, trained) in classified {
            for (mine, its) in self.trained.iter_mut().zip(trained) {
                *mine = [mine[0].min(its[0]), mine[1].max(its[1])];
            }
            for (key, mut pixels) in found {
                members.entry(key).or_default().append(&mut pixels);
            }
        }
        let mut window = Window::default();
        window.read(Source::of(pair.raw), first, rows, [half, half], tile);
        let tasks: Vec<(ClassKey, &[u32])> = members
            .iter()
            .flat_map(|(key, pixels)| pixels.chunks(TASK_PATCHES).map(move |part| (*key, part)))
            .collect();
        let patches = Patches { window: &window, target: pair.target, first_row: first, side, outputs };
        let sums: Vec<(ClassKey, Vec<f64>)> =
            tasks.into_par_iter().map(|(key, pixels)| (key, patches.sums(pixels))).collect();
        for (key, sums) in sums {
            let moments = self.class_mut(key);
            let size = moments.size();
            let padded = size.next_multiple_of(LANES);
            for i in 0..size {
                for j in i..size {
                    moments.add_at(i, j, sums[i * padded + j]);
                }
            }
        }
    }
}

/// Where in the tile the first pixel of a raw image lies.
pub(super) fn phase_in(mosaic: &Mosaic, raw: &RawImage) -> Result<[usize; 2], L3Error> {
    let Sampling::Mosaic(got) = raw.sampling() else { return Err(L3Error::NoMosaic) };
    let cells = (0..mosaic.rows()).flat_map(|r| (0..mosaic.cols()).map(move |c| [r, c]));
    let mut shifts = cells.filter(|&[r, c]| mosaic.shifted(r, c) == *got);
    shifts.next().ok_or_else(|| L3Error::Mosaic {
        rows: mosaic.rows(),
        cols: mosaic.cols(),
        expected: listed(mosaic),
        got_rows: got.rows(),
        got_cols: got.cols(),
        got: listed(got),
    })
}

/// The cells of a tile, a few of them.
fn listed(mosaic: &Mosaic) -> String {
    let cells = mosaic.cells();
    let shown: Vec<String> = cells.iter().take(16).map(u8::to_string).collect();
    shown.join(" ") + if cells.len() > 16 { " …" } else { "" }
}

/// An image must hold a patch, and every phase of the tile.
pub(super) fn check_size(axes: &Axes, rows: usize, cols: usize) -> Result<(), L3Error> {
    let (need_rows, need_cols) =
        (axes.side().max(axes.mosaic().rows()), axes.side().max(axes.mosaic().cols()));
    if rows < need_rows || cols < need_cols {
        return Err(L3Error::Size { rows, cols, need_rows, need_cols });
    }
    Ok(())
}

/// Doubles in a register.
const LANES: usize = 8;
/// Rows of Σ z zᵀ that are summed in registers at a time.
const BLOCK: usize = 8;

/// Where the z of a pixel is read.
struct Patches<'a> {
    window: &'a Window,
    target: &'a Planes,
    first_row: usize,
    side: usize,
    outputs: usize,
}

impl Patches<'_> {
    /// Σ z zᵀ over pixels of the band, rows padded to whole registers; right and above the diagonal.
    fn sums(&self, pixels: &[u32]) -> Vec<f64> {
        let size = 1 + self.side * self.side + self.outputs;
        let padded = size.next_multiple_of(LANES);
        let mut sums = vec![0.0; padded * padded];
        let mut batch = vec![0.0; BATCH * padded];
        for part in pixels.chunks(BATCH) {
            for (z, &pixel) in batch.chunks_exact_mut(padded).zip(part) {
                self.gather(pixel as usize, z);
            }
            dispatch(Products { batch: &batch[..part.len() * padded], padded, sums: &mut sums });
        }
        sums
    }

    /// z of one pixel: 1, the patch row by row, the targets.
    #[inline(always)]
    fn gather(&self, pixel: usize, z: &mut [f64]) {
        let (row, col) = (pixel / self.window.cols, pixel % self.window.cols);
        z[0] = 1.0;
        let half = (self.side / 2) as isize;
        let taps = z[1..].chunks_exact_mut(self.side).take(self.side);
        for (r, out) in taps.enumerate() {
            // The margin of this window is half a patch: columns of a patch start at the pixel's own.
            let line = &self.window.line(row as isize + r as isize - half)[col..col + self.side];
            out.iter_mut().zip(line).for_each(|(o, &v)| *o = f64::from(v));
        }
        let from = 1 + self.side * self.side;
        let at = (self.first_row + row) * self.target.cols() + col;
        for (o, plane) in z[from..from + self.outputs].iter_mut().zip(self.target.planes()) {
            *o = f64::from(plane[at]);
        }
    }
}

/// `sums += Σ z zᵀ` over the rows z of a batch, on and right of the diagonal.
struct Products<'a> {
    batch: &'a [f64],
    padded: usize,
    sums: &'a mut [f64],
}

impl Kernel for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.padded;
        for i in (0..n).step_by(BLOCK) {
            let mut j = i;
            while j + 2 * LANES <= n {
                block::<{ 2 * LANES }>(self.batch, n, i, j, self.sums);
                j += 2 * LANES;
            }
            if j < n {
                block::<LANES>(self.batch, n, i, j, self.sums);
            }
        }
    }
}

/// Rows `i..i + BLOCK`, columns `j..j + W`.
#[inline(always)]
fn block<const W: usize>(batch: &[f64], n: usize, i: usize, j: usize, sums: &mut [f64]) {
    let mut acc = [[0.0f64; W]; BLOCK];
    for z in batch.chunks_exact(n) {
        let (Some(left), Some(right)) = (
            z.get(i..i + BLOCK).and_then(|s| s.first_chunk::<BLOCK>()),
            z.get(j..j + W).and_then(|s| s.first_chunk::<W>()),
        ) else {
            return;
        };
        for r in 0..BLOCK {
            for c in 0..W {
                acc[r][c] += left[r] * right[c];
            }
        }
    }
    for (r, row) in acc.iter().enumerate() {
        let at = (i + r) * n + j;
        if let Some(out) = sums.get_mut(at..at + W) {
            out.iter_mut().zip(row).for_each(|(o, v)| *o += v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::l3::Levels;
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

    fn axes() -> Axes {
        let mosaic = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
        let noise = SignalNoise { constant: 1e-6, per_signal: 1e-4, ..SignalNoise::default() };
        Axes::new(mosaic, 5, Levels::logarithmic(4, 0.1, 0.8).unwrap(), noise).unwrap()
    }

    /// Every patch is counted once, and the sums are those of the plain definition.
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
                // The top left of the patch times the second target.
                expected += f64::from(x[(r - 2) * 41 + c - 2]) * f64::from(target.plane(1)[r * 41 + c]);
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
}
