//! Patches that a design saturates, which the moments of the light leave out.
//!
//! A capture gives patches with a clipped sample classes of their own, when they are frequent enough to have a place on the axis of saturation.
//! Which patches these are depends on the filters, so that no class of the light can hold them. They are few, a percent of the training scene at most under automatic exposure. Their samples
//! are therefore computed for each design, and their moments are subtracted from those of the light.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::LightSystem;
use super::statistics::ClassLight;
use crate::design::pixel_light::PixelLight;
use crate::l3::{ClassPool, Moments, Training, nearest_saturation, saturation_axis};
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
        let mut random = Stream::new(seed, PURPOSE, 0);
        let deviates = (0..all.len().div_ceil(2))
            .flat_map(|_| {
                let (a, b) = normal_pair(random.next_u32(), random.next_u32());
                [a, b]
            })
            .collect();
        Self { light, target, order, brightness, deviates }
    }

    /// Samples of a pixel behind a filter.
    fn sample(&self, pixel: usize, response: &[f64]) -> f64 {
        self.light.planes().planes().zip(response).map(|(plane, r)| f64::from(plane[pixel]) * r).sum()
    }

    /// A bit for each channel that noise and light clip at each pixel. `bounds` are the largest samples that the scene may have behind each filter.
    fn clipped(&self, system: &LightSystem<'_>, clip: f64, bounds: &[f64]) -> (Vec<u32>, Vec<u32>) {
        let (mut bits, mut pixels) = (vec![0u32; self.order.len()], Vec::new());
        let sigma = |x: f64| system.noise.own(x, x * x).max(0.0).sqrt();
        for (channel, (response, bound)) in system.responses.iter().zip(bounds).enumerate() {
            let least = (clip - DEVIATIONS * sigma(clip)) * ALLOWANCE / bound;
            let count = self.brightness.partition_point(|b| f64::from(*b) >= least);
            for &pixel in &self.order[..count] {
                let x = self.sample(pixel as usize, response);
                if x + sigma(x) * f64::from(self.deviates[pixel as usize]) >= clip {
                    if bits[pixel as usize] == 0 {
                        pixels.push(pixel);
                    }
                    bits[pixel as usize] |= 1 << channel;
                }
            }
        }
        (bits, pixels)
    }
}

/// The moments of the samples of saturated patches, by position and class.
#[derive(Debug, Default)]
pub(in crate::design) struct Saturated {
    pub(super) classes: Vec<Option<Moments>>,
    /// Classes of a position, and textures of a level.
    pub(super) counts: [usize; 2],
}

impl Saturated {
    /// The moments of a pool at a position (by index), if there are any.
    pub(super) fn of(&self, at: usize, pool: ClassPool) -> Option<Moments> {
        let [classes, textures] = self.counts;
        let mut sum: Option<Moments> = None;
        for (class, moments) in self.classes.iter().skip(at * classes).take(classes).enumerate() {
            let fits = pool.level.is_none_or(|level| level == class / textures)
                && pool.texture.is_none_or(|texture| texture == class % textures);
            if let Some(moments) = moments.as_ref().filter(|_| fits) {
                match &mut sum {
                    Some(sum) => sum.merge(moments),
                    None => sum = Some(moments.clone()),
                }
            }
        }
        sum
    }

    /// Number of patches of a class at a position (by index), over all pixels.
    pub(in crate::design) fn count(&self, at: usize, level: usize, texture: usize) -> f64 {
        let [classes, textures] = self.counts;
        let of = self.classes.get(at * classes + level * textures + texture);
        of.and_then(Option::as_ref).map_or(0.0, |m| m.get(0, 0))
    }
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
        let side = self.map.first * 2 + 1;
        let cols = scene.target.cols();
        let (bits, pixels) = scene.clipped(system, clip, bounds);
        if pixels.is_empty() {
            return Saturated::default();
        }
        // The patches with a clipped pixel, by the index of their first pixel.
        let (rows, inner) = (self.map.local.len() / self.map.cols, self.map.cols);
        let mut is_found = vec![false; rows * cols];
        let mut patches = Vec::new();
        for pixel in pixels {
            let (row, col) = (pixel as usize / cols, pixel as usize % cols);
            for r in (row + 1).saturating_sub(side)..(row + 1).min(rows) {
                for c in (col + 1).saturating_sub(side)..(col + 1).min(inner) {
                    if !std::mem::replace(&mut is_found[r * cols + c], true) {
                        patches.push(r * cols + c);
                    }
                }
            }
        }
        patches.sort_unstable();
        let offsets: Vec<usize> = (0..self.taps).map(|tap| tap / side * cols + tap % side).collect();
        let arrangements = self.arrangements(system);
        // Saturated patches by arrangement, and the combination of clipped channels.
        let mut found: Vec<(usize, usize, u32)> = Vec::new();
        let mut counts: BTreeMap<u32, f64> = BTreeMap::new();
        let mut clipped = vec![0u128; system.responses.len()];
        for patch in patches {
            clipped.fill(0);
            for (tap, offset) in offsets.iter().enumerate() {
                let mut rest = bits[patch + offset];
                while rest != 0 {
                    clipped[rest.trailing_zeros() as usize] |= 1 << tap;
                    rest &= rest - 1;
                }
            }
            for (number, arrangement) in arrangements.iter().enumerate() {
                let of = |(channel, (a, b)): (usize, (&u128, &u128))| u32::from(a & b != 0) << channel;
                let mask = clipped.iter().zip(&arrangement.taps).enumerate().map(of).sum::<u32>();
                if mask != 0 {
                    let share = arrangement.turns.len() as f64 / self.turns.len() as f64;
                    *counts.entry(mask).or_insert(0.0) += share * cells[arrangement.at] as f64;
                    found.push((number, patch, mask));
                }
            }
        }
        let total = self.map.local.len() as f64 * cells.iter().sum::<usize>() as f64;
        let axis = saturation_axis(&counts, total, Training::default().saturation_share);
        let is_kept = |mask| axis[nearest_saturation(&axis, mask)] != 0;
        let class_of = |patch: usize| usize::from(self.map.local[patch / cols * inner + patch % cols]);
        let mut entries: Vec<(usize, usize, u32)> = found
            .into_iter()
            .filter(|(.., mask)| is_kept(*mask))
            .map(|(number, patch, _)| (number, class_of(patch), patch as u32))
            .collect();
        entries.sort_unstable();
        self.summed(scene, system, &arrangements, &offsets, &entries)
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

    /// The moments of patches, given by arrangement, class and first pixel in ascending order.
    fn summed(
        &self,
        scene: &BrightScene,
        system: &LightSystem<'_>,
        arrangements: &[Arrangement],
        offsets: &[usize],
        entries: &[(usize, usize, u32)],
    ) -> Saturated {
        let (classes, filters) = (self.counts.len(), system.responses.len());
        let mut slots = vec![u32::MAX; scene.order.len()];
        let mut samples: Vec<f32> = Vec::new();
        for pixel in entries.iter().flat_map(|(.., patch)| offsets.iter().map(|o| *patch as usize + o)) {
            if slots[pixel] == u32::MAX {
                slots[pixel] = (samples.len() / filters) as u32;
                samples.extend(system.responses.iter().map(|r| scene.sample(pixel, r) as f32));
            }
        }
        let targets: Vec<&[f32]> = scene.target.planes().collect();
        let stride = (1 + self.taps + targets.len()).next_multiple_of(LANES);
        let mut all: Vec<Option<Moments>> = vec![None; classes * system.positions.len()];
        let mut places: Vec<usize> = (0..1 + self.taps + targets.len()).collect();
        let mut batch = vec![0.0; BATCH * stride];
        for run in entries.chunk_by(|a, b| a.0 == b.0 && a.1 == b.1) {
            let (arrangement, class) = (&arrangements[run[0].0], run[0].1);
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
                all[arrangement.at * classes + turned]
                    .get_or_insert_with(|| Moments::new(self.taps, targets.len()))
                    .merge_permuted(&moments, &places);
            }
        }
        Saturated { classes: all, counts: [classes, self.textures] }
    }
}

/// Adds Σ z zᵀ of the samples and targets of some patches.
struct AddSamples<'a> {
    patches: &'a [(usize, usize, u32)],
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
        for (z, (.., patch)) in batch.chunks_exact_mut(stride).zip(patches) {
            let patch = *patch as usize;
            z.fill(0.0);
            z[0] = 1.0;
            for (z, (offset, channel)) in z[1..].iter_mut().zip(offsets.iter().zip(channels)) {
                *z = f64::from(samples[slots[patch + offset] as usize * filters + channel]);
            }
            for (z, plane) in z[1 + offsets.len()..].iter_mut().zip(targets) {
                *z = f64::from(plane[patch + middle]) * scale;
            }
        }
        add_products(batch, stride, sums);
    }
}
