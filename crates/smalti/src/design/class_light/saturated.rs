//! Patches that a design saturates, which the moments of the light leave out.
//!
//! A capture gives patches with a clipped sample classes of their own, when they are frequent enough to have a place on the axis of saturation.
//! Which patches these are depends on the filters, so that no class of the light can hold them. They are few, a percent of the training scene at most under automatic exposure. Their samples
//! are therefore computed for each design, and their moments are subtracted from those of the light.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::kernel::LightSystem;
use super::saturated_moments::Saturated;
use super::statistics::ClassLight;
use crate::design::pixel_light::PixelLight;
use crate::l3::{Moments, Training, nearest_saturation, saturation_axis};
use crate::numeric::Planes;
use crate::numeric::normal::normal_pair;
use crate::numeric::philox::Stream;
use crate::numeric::products::{LANES, add_products};
use crate::numeric::simd::{Kernel, dispatch};
use crate::sensor::PixelSpectra;

/// Purpose of the random numbers of noise.
const PURPOSE: u32 = 0x0053_4154;
/// Standard deviations by which noise may raise a sample to saturation.
const DEVIATIONS: f64 = 5.0;
/// Allowance for what the spectral components leave out of a sample.
const ALLOWANCE: f64 = 0.98;
/// Patches whose z are gathered together.
const BATCH: usize = 32;

/// The training scene, with its pixels in the order of their brightness.
#[derive(Debug)]
pub(in crate::design) struct BrightScene {
    light: Arc<PixelLight>,
    /// X, Y, Z of the reference at every pixel.
    target: Arc<Planes>,
    /// The pixels, the brightest first.
    order: Vec<u32>,
    /// The light of these pixels relative to the brightest of the scene, at the wavelength where this is the largest.
    brightness: Vec<f32>,
    /// The coefficients of these pixels, pixel after pixel.
    coefficients: Vec<f32>,
    /// A normal deviate for each pixel: whether its noise clips it.
    deviates: Vec<f32>,
}

impl BrightScene {
    /// `pixels` is the light that the components describe, and `brightest` its maximum at each wavelength.
    pub(in crate::design) fn new(
        light: Arc<PixelLight>,
        target: Arc<Planes>,
        pixels: &PixelSpectra,
        brightest: &[f64],
        seed: u64,
    ) -> Self {
        let window = pixels.window();
        let mut all = vec![0.0f32; window.rows * window.cols];
        for (row, line) in all.chunks_exact_mut(window.cols).enumerate() {
            for (i, most) in brightest.iter().enumerate().filter(|(_, most)| **most > 0.0) {
                let share = (1.0 / most) as f32;
                let light = pixels.line(window.row + row, i);
                line.iter_mut().zip(light).for_each(|(b, l)| *b = b.max(l * share));
            }
        }
        let mut order: Vec<u32> = (0..all.len() as u32).collect();
        order.sort_by(|a, b| all[*b as usize].total_cmp(&all[*a as usize]));
        let brightness = order.iter().map(|i| all[*i as usize]).collect();
        let planes = light.planes();
        let coefficients =
            order.iter().flat_map(|i| planes.planes().map(move |plane| plane[*i as usize])).collect();
        let mut random = Stream::new(seed, PURPOSE, 0);
        let deviates = (0..all.len().div_ceil(2))
            .flat_map(|_| {
                let (a, b) = normal_pair(random.next_u32(), random.next_u32());
                [a, b]
            })
            .collect();
        Self { light, target, order, brightness, coefficients, deviates }
    }

    /// Samples of a pixel behind a filter.
    fn sample(&self, pixel: usize, response: &[f64]) -> f64 {
        self.light.planes().planes().zip(response).map(|(plane, r)| f64::from(plane[pixel]) * r).sum()
    }

    /// The channels that light and noise clip somewhere, with the pixels where they do. `bounds` are the largest samples that the scene may have behind each filter.
    fn clipped(&self, system: &LightSystem<'_>, clip: f64, bounds: &[f64]) -> Vec<(usize, BitRows)> {
        let (rows, cols, count) = (self.target.rows(), self.target.cols(), self.light.spectra().len());
        let sigma = |x: f64| system.noise.own(x, x * x).max(0.0).sqrt();
        let of_channel = |(channel, (response, bound)): (usize, (&Vec<f64>, &f64))| {
            let least = (clip - DEVIATIONS * sigma(clip)) * ALLOWANCE / bound;
            let bright = self.brightness.partition_point(|b| f64::from(*b) >= least);
            let mut found: Option<BitRows> = None;
            for (pixel, light) in self.order[..bright].iter().zip(self.coefficients.chunks_exact(count)) {
                let x: f64 = light.iter().zip(response).map(|(l, r)| f64::from(*l) * r).sum();
                if x + sigma(x) * f64::from(self.deviates[*pixel as usize]) >= clip {
                    let (row, col) = (*pixel as usize / cols, *pixel as usize % cols);
                    found.get_or_insert_with(|| BitRows::new(rows, cols)).set(row, col);
                }
            }
            found.map(|bits| (channel, bits))
        };
        system.responses.iter().zip(bounds).enumerate().filter_map(of_channel).collect()
    }
}

/// A bit for each pixel.
struct BitRows {
    /// Words of a row, with one more that is 0.
    words: usize,
    bits: Vec<u64>,
}

impl BitRows {
    fn new(rows: usize, cols: usize) -> Self {
        let words = cols.div_ceil(64) + 1;
        Self { words, bits: vec![0; rows * words] }
    }

    fn set(&mut self, row: usize, col: usize) {
        self.bits[row * self.words + col / 64] |= 1 << (col % 64);
    }

    fn row(&self, row: usize) -> &[u64] {
        &self.bits[row * self.words..(row + 1) * self.words]
    }

    /// The bits from a column of a row on.
    #[inline(always)]
    fn from(words: &[u64], col: usize) -> u64 {
        let (word, shift) = (col / 64, col % 64);
        words[word] >> shift | if shift == 0 { 0 } else { words[word + 1] << (64 - shift) }
    }

    /// The pixels of the patch of `side` × `side` pixels from (row, col) on, a bit each.
    #[inline(always)]
    fn patch(&self, row: usize, col: usize, side: usize) -> u128 {
        let line = |r: usize| u128::from(Self::from(self.row(row + r), col) & ((1 << side) - 1));
        (0..side).fold(0, |bits, r| bits | line(r) << (r * side))
    }
}

/// The patches that have a bit in some of the planes, by row and column of their first pixel, in ascending order.
fn patches_with_a_bit(planes: &[(usize, BitRows)], [rows, cols]: [usize; 2], side: usize) -> Vec<[usize; 2]> {
    let Some(words) = planes.first().map(|(_, bits)| bits.words) else { return Vec::new() };
    let mut found = Vec::new();
    let mut line = vec![0u64; words];
    for row in 0..rows {
        line.fill(0);
        for (_, bits) in planes {
            for r in row..row + side {
                line.iter_mut().zip(bits.row(r)).for_each(|(sum, bits)| *sum |= bits);
            }
        }
        for first in (0..cols).step_by(64) {
            let mut rest = (0..side).fold(0, |bits, c| bits | BitRows::from(&line, first + c));
            while rest != 0 {
                let col = first + rest.trailing_zeros() as usize;
                rest &= rest - 1;
                if col < cols {
                    found.push([row, col]);
                }
            }
        }
    }
    found
}

/// The channels of the pixels of a patch at a position, before some rotations and reflections of the patch that lead to the same ones.
struct Arrangement {
    /// The index of the position.
    at: usize,
    channels: Vec<usize>,
    turns: Vec<usize>,
    /// For each channel, the pixels that have it, a bit each.
    taps: Vec<u128>,
}

impl ClassLight {
    /// The patches that a design saturates. `bounds` are the largest samples that the scene may have behind each of its filters, and `cells` the number of positions
    /// that each of those of the system represents.
    pub(in crate::design) fn saturated(
        &self,
        scene: &BrightScene,
        system: &LightSystem<'_>,
        clip: f64,
        bounds: &[f64],
        cells: &[usize],
    ) -> Saturated {
        let (side, cols, inner) = (self.map.first * 2 + 1, scene.target.cols(), self.map.cols);
        let clipped = scene.clipped(system, clip, bounds);
        if clipped.is_empty() {
            return Saturated::default();
        }
        let patches = patches_with_a_bit(&clipped, [self.map.local.len() / inner, inner], side);
        let arrangements = self.arrangements(system);
        // Saturated patches by arrangement, and the combination of clipped channels.
        let mut found: Vec<(usize, [usize; 2], u32)> = Vec::new();
        // There are few combinations, and neighbouring patches mostly have the same.
        let mut counts: Vec<(u32, f64)> = Vec::new();
        let mut taps = vec![0u128; clipped.len()];
        for patch in patches {
            taps.iter_mut()
                .zip(&clipped)
                .for_each(|(t, (_, bits))| *t = bits.patch(patch[0], patch[1], side));
            for (number, arrangement) in arrangements.iter().enumerate() {
                let mut mask = 0u32;
                for (taps, (channel, _)) in taps.iter().zip(&clipped) {
                    mask |= u32::from(taps & arrangement.taps[*channel] != 0) << channel;
                }
                if mask != 0 {
                    let share = arrangement.turns.len() as f64 / self.turns.len() as f64;
                    let patches = share * cells[arrangement.at] as f64;
                    match counts.iter_mut().find(|(known, _)| *known == mask) {
                        Some((_, count)) => *count += patches,
                        None => counts.push((mask, patches)),
                    }
                    found.push((number, patch, mask));
                }
            }
        }
        let total = self.map.local.len() as f64 * cells.iter().sum::<usize>() as f64;
        let counts: BTreeMap<u32, f64> = counts.into_iter().collect();
        let axis = saturation_axis(&counts, total, Training::default().saturation_share);
        if axis.len() == 1 {
            return Saturated::default();
        }
        let offsets: Vec<usize> = (0..self.taps).map(|tap| tap / side * cols + tap % side).collect();
        let classes = self.counts.len();
        // The first pixels of the patches of each arrangement and class, in ascending order.
        let mut of_class: Vec<Vec<u32>> = vec![Vec::new(); arrangements.len() * classes];
        let mut all: Vec<u32> = Vec::new();
        for (number, [row, col], mask) in found {
            if axis[nearest_saturation(&axis, mask)] != 0 {
                let patch = (row * cols + col) as u32;
                of_class[number * classes + usize::from(self.map.local[row * inner + col])].push(patch);
                if all.last() != Some(&patch) {
                    all.push(patch);
                }
            }
        }
        self.summed(scene, system, &arrangements, &offsets, (&of_class, &all))
    }

    fn arrangements(&self, system: &LightSystem<'_>) -> Vec<Arrangement> {
        let mut all: Vec<Arrangement> = Vec::new();
        for (at, of_patch) in system.channels.iter().enumerate() {
            for (number, turn) in self.turns.iter().enumerate() {
                let channels: Vec<usize> = turn.taps.iter().map(|to| of_patch[*to]).collect();
                if let Some(known) = all.iter_mut().find(|a| a.at == at && a.channels == channels) {
                    known.turns.push(number);
                    continue;
                }
                let mut taps = vec![0u128; system.responses.len()];
                channels.iter().enumerate().for_each(|(tap, channel)| taps[*channel] |= 1 << tap);
                all.push(Arrangement { at, channels, turns: vec![number], taps });
            }
        }
        all
    }

    /// The moments of patches, given by their first pixels for each arrangement and class, and all together.
    fn summed(
        &self,
        scene: &BrightScene,
        system: &LightSystem<'_>,
        arrangements: &[Arrangement],
        offsets: &[usize],
        (of_class, all): (&[Vec<u32>], &[u32]),
    ) -> Saturated {
        let (classes, filters) = (self.counts.len(), system.responses.len());
        let mut slots = vec![u32::MAX; scene.order.len()];
        let mut samples: Vec<f32> = Vec::new();
        for pixel in all.iter().flat_map(|patch| offsets.iter().map(|o| *patch as usize + o)) {
            if slots[pixel] == u32::MAX {
                slots[pixel] = (samples.len() / filters) as u32;
                samples.extend(system.responses.iter().map(|r| scene.sample(pixel, r) as f32));
            }
        }
        let targets: Vec<&[f32]> = scene.target.planes().collect();
        let stride = (1 + self.taps + targets.len()).next_multiple_of(LANES);
        let mut moments_of: Vec<Option<Moments>> = vec![None; classes * system.positions.len()];
        let mut places: Vec<usize> = (0..1 + self.taps + targets.len()).collect();
        let mut batch = vec![0.0; BATCH * stride];
        for (number, run) in of_class.iter().enumerate().filter(|(_, run)| !run.is_empty()) {
            let (arrangement, class) = (&arrangements[number / classes], number % classes);
            let mut sums = vec![0.0; stride * stride];
            for part in run.chunks(BATCH) {
                dispatch(AddSamples {
                    patches: part,
                    offsets,
                    channels: &arrangement.channels,
                    slots: &slots,
                    samples: &samples,
                    filters,
                    targets: &targets,
                    scale: system.scale,
                    batch: &mut batch[..part.len() * stride],
                    stride,
                    sums: &mut sums,
                });
            }
            let mut moments = Moments::new(self.taps, targets.len());
            moments.add_square(&sums, stride);
            moments.divide(self.turns.len() as f64);
            for number in &arrangement.turns {
                let turn = &self.turns[*number];
                let turned = class / self.textures * self.textures + turn.textures[class % self.textures];
                places[1..].iter_mut().zip(&turn.taps).for_each(|(place, tap)| *place = 1 + tap);
                moments_of[arrangement.at * classes + turned]
                    .get_or_insert_with(|| Moments::new(self.taps, targets.len()))
                    .merge_permuted(&moments, &places);
            }
        }
        Saturated { classes: moments_of, counts: [classes, self.textures] }
    }
}

/// Adds Σ z zᵀ of the samples and targets of some patches.
struct AddSamples<'a> {
    patches: &'a [u32],
    offsets: &'a [usize],
    channels: &'a [usize],
    slots: &'a [u32],
    samples: &'a [f32],
    filters: usize,
    targets: &'a [&'a [f32]],
    scale: f64,
    batch: &'a mut [f64],
    stride: usize,
    sums: &'a mut [f64],
}

impl Kernel for AddSamples<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { patches, offsets, channels, slots, samples, filters, .. } = self;
        let Self { targets, scale, batch, stride, sums, .. } = self;
        let middle = offsets[offsets.len() / 2];
        for (z, patch) in batch.chunks_exact_mut(stride).zip(patches) {
            let patch = *patch as usize;
            z.fill(0.0);
            z[0] = 1.0;
            for (z, (offset, channel)) in z[1..].iter_mut().zip(offsets.iter().zip(channels)) {
                *z = f64::from(samples[slots[patch + offset] as usize * filters + channel]);
            }
            for (z, plane) in z[1 + offsets.len()..].iter_mut().zip(targets) {
                // `add_products` needs numbers of single precision.
                *z = f64::from((f64::from(plane[patch + middle]) * scale) as f32);
            }
        }
        add_products(batch, stride, sums);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, CameraDescription};
    use crate::l3::{Axes, ClassPool, Levels, representatives};
    use crate::scene::{Setting, catalog};
    use crate::sensor::{Cfa, Channel, Mosaic, NoiseMode, SignalNoise};
    use crate::spectrum::{Spectrum, WavelengthGrid};

    const SIDE: usize = 3;
    const SIZE: usize = 40;

    /// The moments are those of every patch, position and turn in which a sample clips, one by one.
    #[test]
    fn moments_are_those_of_the_patches_with_a_clipped_sample() {
        let camera = Camera::new(CameraDescription::default(), WavelengthGrid::VISIBLE).unwrap();
        let camera = camera.with_size(SIZE, SIZE);
        let reflectances: Vec<Spectrum> = (1..9)
            .map(|i| {
                Spectrum::from_fn(camera.grid(), |nm| 0.5 + 0.4 * libm::sin(nm / 20.0 / f64::from(i)))
                    .unwrap()
            })
            .collect();
        let setting = Setting { grid: camera.grid(), ..Setting::default() };
        let scene = catalog::build("dead-leaves?rows=80&cols=80&seed=3", &setting, &reflectances).unwrap();
        let deg = camera.field_of_view_deg(SIZE, setting.distance_m).unwrap();
        let image = camera.optics.image(&scene.with_fov(deg).unwrap()).unwrap();
        let pixels = PixelSpectra::new(&camera.sensor, &image).unwrap();
        let light = Arc::new(PixelLight::new(&camera.sensor, &pixels, 3).unwrap());
        let target = Arc::new(camera.seen_by_observer(&image).unwrap());
        let brightest = crate::design::imaged_scene::brightest(&pixels);
        let scene = BrightScene::new(light.clone(), target.clone(), &pixels, &brightest, 5);
        // A mosaic that a half turn maps onto itself, whose patches have several arrangements.
        let mosaic = Mosaic::new(2, 3, vec![0, 1, 2, 1, 0, 2]).unwrap();
        let noise = SignalNoise { constant: 1e-5, per_signal: 1e-4, ..SignalNoise::default() };
        let axes = Axes::new(mosaic.clone(), SIDE, Levels::new(vec![0.4]).unwrap(), noise).unwrap();
        let clear = Spectrum::constant(camera.grid(), 1.0).unwrap();
        let channel = |c: usize| Channel { name: c.to_string(), transmittance: clear.clone() };
        let camera = camera.with_cfa(Cfa::new("clear", mosaic, (0..3).map(channel).collect()).unwrap());
        let exposure = camera.exposure(&image).unwrap();
        let seen = camera.sensor.capture(&image, &exposure, NoiseMode::All, 1).unwrap();
        let classes = ClassLight::new(&light, &target, &axes, &seen, 1.0, 0.0).unwrap();
        // The brightest pixels of two filters lie above saturation.
        let unit = |k: usize| -> f64 {
            let plane = light.planes().plane(k).unwrap();
            f64::from(plane.iter().fold(0.0f32, |m, v| m.max(v.abs())))
        };
        let filter = |a: f64, b: f64| vec![a / unit(0), b / unit(1), 0.02 / unit(2)];
        let responses = vec![filter(1.02, 0.05), filter(0.6, 0.1), filter(1.0, -0.1)];
        let sample = |c: usize, i: usize| scene.sample(i, &responses[c]);
        let bounds: Vec<f64> =
            (0..3).map(|c| 1.5 * (0..SIZE * SIZE).map(|i| sample(c, i)).fold(0.0, f64::max)).collect();
        let positions = representatives(&axes);
        let counts = classes.patch_counts(&axes);
        let cells: Vec<usize> = positions.iter().map(|p| counts.cells(*p)).collect();
        let channels = |p: &usize| (0..axes.taps()).map(|tap| axes.channel_of(*p, tap)).collect();
        let system = LightSystem {
            responses: responses.clone(),
            scale: 0.5,
            channels: positions.iter().map(channels).collect(),
            positions,
            share: 1.0,
            noise,
            even: &|_, _| None,
            saturated: Saturated::default(),
            counts,
        };
        let clip = axes.clip();
        let found = classes.saturated(&scene, &system, clip, &bounds, &cells);
        let clips = |c: usize, i: usize| {
            let x = sample(c, i);
            x + noise.own(x, x * x).sqrt() * f64::from(scene.deviates[i]) >= clip
        };
        let (inner, textures) = (SIZE - 2, classes.textures);
        let mut total = 0.0;
        for (at, of_patch) in system.channels.iter().enumerate() {
            let mut expected = vec![Moments::new(9, 3); classes.counts.len()];
            for turn in &classes.turns {
                for (place, class) in classes.map.local.iter().enumerate() {
                    let pixel = |tap: usize| (place / inner + tap / 3) * SIZE + place % inner + tap % 3;
                    let mut z = vec![1.0; 13];
                    let mut is_clipped = false;
                    for (tap, to) in turn.taps.iter().enumerate() {
                        z[1 + to] = f64::from(sample(of_patch[*to], pixel(tap)) as f32);
                        is_clipped |= clips(of_patch[*to], pixel(tap));
                    }
                    for (z, plane) in z[10..].iter_mut().zip(target.planes()) {
                        *z = 0.5 * f64::from(plane[pixel(4)]);
                    }
                    if is_clipped {
                        let class = usize::from(*class);
                        let turned = class / textures * textures + turn.textures[class % textures];
                        expected[turned].add(&z, 1.0 / classes.turns.len() as f64);
                    }
                }
            }
            for (class, expected) in expected.iter().enumerate() {
                let pool = ClassPool { level: Some(class / textures), texture: Some(class % textures) };
                total += expected.get(0, 0);
                match found.of(at, pool) {
                    Some(found) => {
                        let pairs = found.sums().iter().zip(expected.sums());
                        pairs.for_each(|(a, b)| assert!((a - b).abs() <= 1e-9 * b.abs().max(1.0), "{a} {b}"));
                    }
                    None => assert!(expected.get(0, 0) == 0.0, "class {class} at {at}"),
                }
            }
        }
        let all = (classes.map.local.len() * system.positions.len()) as f64;
        assert!(total > 0.01 * all && total < 0.5 * all, "{total} of {all}");
    }
}
