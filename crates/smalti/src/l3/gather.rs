//! Accumulation of the moments of an image, band by band.
//!
//! The pixels of a band of rows are classified and sorted by class. The patches of each class are then summed
//! in registers, a few at a time for the whole triangle of the moment matrix. Apart from the moments, memory
//! holds one band and the current sums of each thread, for any number of images. Sums run over fixed parts of
//! a band and are added in a fixed order, so results have the same bits for any number of threads.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::classify::{Classifier, RowClasses};
#[cfg(target_arch = "x86_64")]
use super::vectors::Avx512;
use super::window::Window;
use super::{Axes, ClassKey, Moments, Pair, Tiles};
use crate::isp::source::Source;
use crate::numeric::products::{LANES, add_products};
use crate::numeric::simd::{Kernel, dispatch};

/// Rows per band.
const BAND_ROWS: usize = 128;
/// Rows that one task classifies.
const TASK_ROWS: usize = 16;
/// Patches of a class per partial sum.
const PART_PATCHES: usize = 4096;
/// Size of a batch of patches, in doubles: 16 KiB, which stays in the L1 cache beside the sums and leaves
/// room for a second thread on the core.
const BATCH: usize = 2048;
/// The most bits of the class number per pass of the radix sort.
const DIGIT_BITS: u32 = 11;
/// Lists shorter than this are sorted by comparison, since a counting pass must clear up to 2¹¹ counters.
const SHORT: usize = 512;

/// Accumulates a pair of images.
pub(super) struct Gatherer<'a> {
    axes: &'a Axes,
    outputs: usize,
    classifier: Classifier,
    pair: &'a Pair<'a>,
    tiles: Tiles,
    phase: [usize; 2],
}

/// The pixels of a few rows, by class.
struct ClassifiedPixels {
    /// For each combination of clipped channels: class numbers (upper bits) with pixels of the band (lower 32
    /// bits), in ascending order.
    by_saturation: BTreeMap<u32, Vec<u64>>,
    /// Smallest and largest mean response at each position.
    trained: Vec<[f32; 2]>,
}

impl<'a> Gatherer<'a> {
    /// `phase` is the position of the first pixel in the tile.
    pub(super) fn new(
        axes: &'a Axes,
        outputs: usize,
        (pair, tiles): (&'a Pair<'a>, Tiles),
        phase: [usize; 2],
    ) -> Self {
        Self { axes, outputs, classifier: Classifier::new(axes), pair, tiles, phase }
    }

    /// Bands of the rows whose patches lie within the image.
    pub(super) fn bands(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let half = self.axes.side() / 2;
        let end = self.pair.raw.rows().saturating_sub(half);
        (half..end).step_by(BAND_ROWS).map(move |first| first..(first + BAND_ROWS).min(end))
    }

    /// Number of levels times number of textures.
    fn locals(&self) -> u64 {
        (self.axes.level_count() * self.axes.textures().count()) as u64
    }

    fn key(&self, saturation: u32, number: u64) -> ClassKey {
        let (locals, textures) = (self.locals(), self.axes.textures().count() as u64);
        ClassKey {
            position: (number / locals) as u32,
            saturation,
            level: (number % locals / textures) as u16,
            texture: (number % textures) as u16,
        }
    }

    /// Adds the patches around the pixels of a band.
    pub(super) fn add(
        &self,
        band: Range<usize>,
        trained: &mut [[f32; 2]],
        classes: &mut BTreeMap<ClassKey, Moments>,
    ) {
        let mosaic = self.axes.mosaic();
        let (half, tile) = (self.axes.side() / 2, [mosaic.rows(), mosaic.cols()]);
        let mut window = Window::default();
        let (sorted, ()) = rayon::join(
            || self.sorted(&band),
            || window.read(Source::of(self.pair.raw), band.start, band.len(), [half, half], tile),
        );
        let mut members: BTreeMap<ClassKey, Vec<u32>> = BTreeMap::new();
        let parts = sorted.len();
        for part in sorted {
            for (mine, its) in trained.iter_mut().zip(part.trained) {
                *mine = [mine[0].min(its[0]), mine[1].max(its[1])];
            }
            for (saturation, pixels) in part.by_saturation {
                for run in pixels.chunk_by(|a, b| a >> 32 == b >> 32) {
                    let key = self.key(saturation, run[0] >> 32);
                    // The other parts have about as many.
                    let list = members.entry(key).or_insert_with(|| Vec::with_capacity(parts * run.len()));
                    list.extend(run.iter().map(|&p| p as u32));
                }
            }
        }
        for key in members.keys() {
            classes.entry(*key).or_insert_with(|| Moments::new(self.axes.taps(), self.outputs));
        }
        // Both lists are in the order of keys.
        let mut lists = members.into_iter().peekable();
        let work: Vec<(&mut Moments, Vec<u32>)> = classes
            .iter_mut()
            .filter_map(|(key, moments)| {
                lists.next_if(|(k, _)| k == key).map(|(_, pixels)| (moments, pixels))
            })
            .collect();
        let target = self.pair.target;
        let patches = Patches {
            window: &window,
            targets: target.planes().map(|p| p.get(band.start * target.cols()..).unwrap_or(&[])).collect(),
            side: self.axes.side(),
            outputs: self.outputs,
        };
        work.into_par_iter().for_each_init(Scratch::default, |scratch, (moments, pixels)| {
            if pixels.len() <= PART_PATCHES {
                patches.sum(&pixels, scratch);
                moments.add_square(&scratch.sums, patches.stride());
            } else {
                let of_part = |part| {
                    let mut scratch = Scratch::default();
                    patches.sum(part, &mut scratch);
                    scratch.sums
                };
                let sums: Vec<Vec<f64>> = pixels.par_chunks(PART_PATCHES).map(of_part).collect();
                sums.iter().for_each(|s| moments.add_square(s, patches.stride()));
            }
        });
    }

    /// The pixels of a band by class, a few rows at a time.
    fn sorted(&self, band: &Range<usize>) -> Vec<ClassifiedPixels> {
        let tasks: Vec<usize> = (0..band.len()).step_by(TASK_ROWS).collect();
        tasks
            .into_par_iter()
            .map_init(SortScratch::default, |scratch, at| {
                let rows = at..(at + TASK_ROWS).min(band.len());
                self.sort_rows(band.start, rows, scratch)
            })
            .collect()
    }

    fn sort_rows(
        &self,
        first: usize,
        rows: Range<usize>,
        SortScratch { window, classes, other }: &mut SortScratch,
    ) -> ClassifiedPixels {
        let mosaic = self.axes.mosaic();
        let tile = [mosaic.rows(), mosaic.cols()];
        let (half, cols, locals) = (self.axes.side() / 2, self.pair.raw.cols(), self.locals());
        let seen = Source::of(self.pair.seen.unwrap_or(self.pair.raw));
        window.read(seen, first + rows.start, rows.len(), self.classifier.margin(), tile);
        let mut trained = vec![[f32::INFINITY, f32::NEG_INFINITY]; self.axes.positions()];
        let mut open: Vec<u64> = Vec::with_capacity(rows.len() * cols);
        let mut by_saturation: BTreeMap<u32, Vec<u64>> = BTreeMap::new();
        for row in rows.clone() {
            let at = self.phase[0] + first + row;
            let (tile_row, down) = (at / tile[0], at % tile[0]);
            self.classifier.row(window, row - rows.start, [down, self.phase[1]], 0..cols, classes);
            let pixels = (row * cols) as u64;
            let start = self.phase[1] + half;
            // The pixels of one column of the tile at a time: their mean responses have a range in common.
            for right in 0..tile[1] {
                let at = start + (right + tile[1] - start % tile[1]) % tile[1];
                let (step, skipped) = self.tiles.step_and_skipped(tile_row, at / tile[1]);
                let position = down * tile[1] + right;
                let [mut least, mut most] = trained[position];
                for col in (at + skipped * tile[1] - self.phase[1]..cols - half).step_by(step * tile[1]) {
                    let mean = classes.mean[col];
                    least = if mean < least { mean } else { least };
                    most = if mean > most { mean } else { most };
                    let number = position as u64 * locals + u64::from(classes.local[col]);
                    let entry = number << 32 | (pixels + col as u64);
                    match classes.saturation[col] {
                        0 => open.push(entry),
                        clipped => by_saturation.entry(clipped).or_default().push(entry),
                    }
                }
                trained[position] = [least, most];
            }
        }
        if !open.is_empty() {
            by_saturation.insert(0, open);
        }
        let most = self.axes.positions() as u64 * locals;
        by_saturation.values_mut().for_each(|list| sort(list, other, most));
        ClassifiedPixels { by_saturation, trained }
    }
}

/// Memory that a thread reuses between the rows that it sorts.
#[derive(Default)]
struct SortScratch {
    window: Window,
    classes: RowClasses,
    other: Vec<u64>,
}

/// Stable sort of entries by the bits above their lower 32, whose value is below `most`. `other` is scratch memory.
fn sort(entries: &mut Vec<u64>, other: &mut Vec<u64>, most: u64) {
    if entries.len() < SHORT {
        // The lower bits ascend within each class already, so that comparing whole entries keeps their order.
        entries.sort_unstable();
        return;
    }
    let bits = u64::BITS - (most.max(1) - 1).leading_zeros();
    let passes = bits.div_ceil(DIGIT_BITS);
    // Clearing and summing counters beyond those that a pass needs would take as long as sorting.
    let digit_bits = bits.div_ceil(passes.max(1));
    other.resize(entries.len(), 0);
    let mut counters = [0usize; 1 << DIGIT_BITS];
    for pass in 0..passes {
        let digit = |entry: u64| (entry >> (32 + pass * digit_bits)) as usize & ((1 << digit_bits) - 1);
        let places = &mut counters[..1 << digit_bits];
        places.fill(0);
        entries.iter().for_each(|&e| places[digit(e)] += 1);
        let mut sum = 0;
        for place in places.iter_mut() {
            sum += std::mem::replace(place, sum);
        }
        for &entry in entries.iter() {
            let place = &mut places[digit(entry)];
            other[*place] = entry;
            *place += 1;
        }
        std::mem::swap(entries, other);
    }
}

/// z with its padding is never shorter.
const WIDTH: usize = 2 * LANES;

/// Memory that a thread reuses between classes.
#[derive(Default)]
struct Scratch {
    sums: Vec<f64>,
    batch: Vec<f64>,
}

/// The source of the z of a pixel.
struct Patches<'a> {
    window: &'a Window,
    /// The planes of the target, from the first row of the band.
    targets: Vec<&'a [f32]>,
    side: usize,
    outputs: usize,
}

impl Patches<'_> {
    /// Length of z, rounded up to whole registers.
    fn stride(&self) -> usize {
        (1 + self.side * self.side + self.outputs).next_multiple_of(LANES).max(WIDTH)
    }

    /// Σ z zᵀ over pixels of the band. Only the upper triangle, with the diagonal, is valid.
    fn sum(&self, pixels: &[u32], scratch: &mut Scratch) {
        let stride = self.stride();
        scratch.sums.clear();
        scratch.sums.resize(stride * stride, 0.0);
        let count = (BATCH / stride).max(1);
        // Rows of a patch are copied in whole registers, which may extend beyond the last z.
        let len = count * stride + 2 * LANES;
        scratch.batch.resize(len + LANES, 0.0);
        // Reading a register that spans two cache lines takes twice as long.
        let first = scratch.batch.as_ptr().align_offset(LANES * size_of::<f64>()).min(LANES);
        let (batch, sums) = (&mut scratch.batch[first..first + len], &mut scratch.sums);
        for part in pixels.chunks(count) {
            dispatch(Products { patches: self, pixels: part, batch, stride, sums });
        }
    }

    /// For each pixel, the index in the lines of the window of the first sample of its patch.
    #[inline(always)]
    fn starts(&self, pixels: &[u32]) -> impl Iterator<Item = usize> {
        let window = self.window;
        let (cols, top) = (window.cols as u32, window.margin[0] - self.side / 2);
        // The margin of this window is half a patch, so the columns of a patch start at the pixel's own index.
        pixels.iter().map(move |&p| ((p / cols) as usize + top) * window.stride + (p % cols) as usize)
    }

    /// Gathers the first part of z of some pixels: 1 and the patch of `side` rows, each in a register of `W` samples. What follows within the
    /// stride is arbitrary.
    #[inline(always)]
    fn gather<const W: usize>(&self, side: usize, pixels: &[u32], batch: &mut [f64], stride: usize) {
        let (window, lines) = (self.window, self.window.lines());
        for (k, mut from) in self.starts(pixels).enumerate() {
            let z = &mut batch[k * stride..];
            z[0] = 1.0;
            for r in 0..side {
                let to = 1 + r * side;
                // Windows extend beyond their last column by a whole vector. Reading the whole line before
                // writing lets the compiler copy it through one register.
                let (Some(&line), Some(out)) = (
                    lines.get(from..from + W).and_then(|s| s.first_chunk::<W>()),
                    z.get_mut(to..to + W).and_then(|s| s.first_chunk_mut::<W>()),
                ) else {
                    return;
                };
                *out = line.map(f64::from);
                from += window.stride;
            }
        }
    }

    /// Gathers the last part of z of some pixels: the targets.
    #[inline(always)]
    fn gather_targets(&self, pixels: &[u32], batch: &mut [f64], stride: usize) {
        let first = 1 + self.side * self.side;
        // Three targets, such as X, Y, Z, need no inner loop.
        if let &[x, y, z] = &*self.targets {
            for (out, &pixel) in batch.chunks_mut(stride).zip(pixels) {
                let at = pixel as usize;
                if let Some(out) = out.get_mut(first..).and_then(|out| out.first_chunk_mut()) {
                    *out = [x[at], y[at], z[at]].map(f64::from);
                }
            }
            return;
        }
        for (out, &pixel) in batch.chunks_mut(stride).zip(pixels) {
            let targets = out[first..].iter_mut().zip(&self.targets);
            targets.for_each(|(o, plane)| *o = f64::from(plane[pixel as usize]));
        }
    }
}

/// `sums += Σ z zᵀ` over a batch of pixels, upper triangle only.
struct Products<'a, 'b> {
    patches: &'a Patches<'b>,
    pixels: &'a [u32],
    batch: &'a mut [f64],
    stride: usize,
    sums: &'a mut [f64],
}

impl Kernel for Products<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.stride;
        let (patches, pixels) = (self.patches, self.pixels);
        if !copied_by_registers(patches, pixels, self.batch, n) {
            // A side that the compiler knows needs no loop.
            match patches.side {
                3 => patches.gather::<LANES>(3, pixels, self.batch, n),
                5 => patches.gather::<LANES>(5, pixels, self.batch, n),
                7 => patches.gather::<LANES>(7, pixels, self.batch, n),
                side if side <= LANES => patches.gather::<LANES>(side, pixels, self.batch, n),
                side => patches.gather::<{ 2 * LANES }>(side, pixels, self.batch, n),
            }
        }
        patches.gather_targets(pixels, self.batch, n);
        add_products(&self.batch[..self.pixels.len() * n], n, self.sums);
    }
}

/// [`Patches::gather`] with rows that are shifted to their places in registers, if the processor can.
#[inline(always)]
#[cfg_attr(not(target_arch = "x86_64"), allow(unused_variables))]
fn copied_by_registers(patches: &Patches<'_>, pixels: &[u32], batch: &mut [f64], stride: usize) -> bool {
    #[cfg(target_arch = "x86_64")]
    if let Some(set) = Avx512::detect() {
        let lines = (patches.window.lines(), patches.window.stride);
        set.copy_patches(patches.side, lines, patches.starts(pixels), (batch, stride));
        return true;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::l3::Levels;
    use crate::numeric::Planes;
    use crate::numeric::philox::Stream;
    use crate::numeric::simd::{Set, with_widest};
    use crate::sensor::{Mosaic, RawImage, RawSamples, Sampling, SignalNoise};

    #[test]
    fn sorting_is_stable_for_any_range() {
        let (mut random, mut other) = (Stream::new(8, 0, 1), Vec::new());
        for (count, most) in [(0, 1), (100, 7), (5000, 1), (5000, 240), (5000, 2049), (9000, 1 << 24)] {
            let entries: Vec<u64> = (0..count).map(|i| u64::from(random.below(most)) << 32 | i).collect();
            let (mut sorted, mut expected) = (entries.clone(), entries);
            sort(&mut sorted, &mut other, u64::from(most));
            expected.sort_by_key(|e| e >> 32);
            assert_eq!(sorted, expected);
        }
    }

    /// Moments have the same bits with every instruction set, at every side and for several numbers of outputs.
    #[test]
    fn every_instruction_set_gives_the_same_moments() {
        let mut random = Stream::new(3, 4, 5);
        let (rows, cols) = (40, 61);
        let samples = RawSamples::Analog((0..rows * cols).map(|_| random.uniform() as f32).collect());
        let mosaic = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
        let names = ["R", "G", "B"].map(String::from).to_vec();
        let raw =
            RawImage::new(rows, cols, samples, Sampling::Mosaic(mosaic.clone()), names, 0.0, 1.0).unwrap();
        for side in [3, 5, 7, 9, 11] {
            let levels = Levels::logarithmic(4, 0.05, 0.95).unwrap();
            let axes = Axes::new(mosaic.clone(), side, levels, SignalNoise::default()).unwrap();
            for outputs in [1, 3, 4] {
                let values = (0..outputs * rows * cols).map(|_| random.uniform() as f32).collect();
                let target = Planes::new(rows, cols, outputs, values).unwrap();
                let pair = Pair { raw: &raw, seen: None, target: &target };
                let gatherer = Gatherer::new(&axes, outputs, (&pair, Tiles::All), [0, 0]);
                let gathered = |set| {
                    let (mut trained, mut classes) = (vec![[0.5; 2]; 4], BTreeMap::new());
                    let add = |band| gatherer.add(band, &mut trained, &mut classes);
                    with_widest(set, || gatherer.bands().for_each(add));
                    (trained, classes)
                };
                let plain = gathered(Set::Plain);
                assert!(plain == gathered(Set::Avx2) && plain == gathered(Set::Avx512), "{side}, {outputs}");
            }
        }
    }

    /// The classes of this tile have numbers of more than one digit of the sort.
    #[test]
    fn pixels_are_sorted_by_class() {
        let (rows, cols, phase) = (40, 70, [1, 4]);
        let mosaic = Mosaic::new(6, 6, (0..36).map(|i| i % 5 * (i % 7) % 4).collect()).unwrap();
        let levels = Levels::logarithmic(64, 0.05, 0.95).unwrap();
        let axes = Axes::new(mosaic.clone(), 3, levels, SignalNoise::default()).unwrap();
        let mut random = Stream::new(9, 0, 1);
        let samples = RawSamples::Analog((0..rows * cols).map(|_| random.uniform() as f32).collect());
        let names = (0..mosaic.channels()).map(|c| c.to_string()).collect();
        let sampling = Sampling::Mosaic(mosaic.shifted(phase[0], phase[1]));
        let raw = RawImage::new(rows, cols, samples, sampling, names, 0.0, 1.0).unwrap();
        let target = Planes::zeros(rows, cols, 1);
        let pair = Pair { raw: &raw, seen: None, target: &target };
        // The patches of the outermost pixels do not lie within the image.
        let inside = |i: usize| (1..rows - 1).contains(&(i / cols)) && (1..cols - 1).contains(&(i % cols));
        for tiles in [Tiles::All, Tiles::Even, Tiles::Odd] {
            let gatherer = Gatherer::new(&axes, 1, (&pair, tiles), phase);
            let mut seen = vec![0; rows * cols];
            for band in gatherer.bands() {
                let parts = gatherer.sorted(&band).into_iter();
                for (saturation, list) in parts.flat_map(|part| part.by_saturation) {
                    assert!(list.is_sorted());
                    for entry in list {
                        let pixel = entry as u32 as usize;
                        let (row, col) = (band.start + pixel / cols, pixel % cols);
                        seen[row * cols + col] += 1;
                        let key = gatherer.key(saturation, entry >> 32);
                        let position = (phase[0] + row) % 6 * 6 + (phase[1] + col) % 6;
                        assert_eq!((key.position as usize, key.saturation), (position, saturation));
                        let (texture, level) = (usize::from(key.texture), usize::from(key.level));
                        assert!(texture < axes.textures().count() && level < axes.level_count());
                    }
                }
            }
            let chosen = |i: usize| {
                let tile = (phase[0] + i / cols) / 6 + (phase[1] + i % cols) / 6;
                inside(i) && (tiles == Tiles::All || tile.is_multiple_of(2) == (tiles == Tiles::Even))
            };
            assert!(seen.iter().enumerate().all(|(i, n)| *n == u32::from(chosen(i))), "{tiles:?}");
        }
    }
}
