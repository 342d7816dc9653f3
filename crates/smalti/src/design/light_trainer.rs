//! Pipelines of designs from statistics of the light of the training scene.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::class_light::{BrightScene, ClassLight, EvenPatches, LightSystem, Saturated};
use super::imaged_scene::brightest;
use super::latest::keep_latest;
use super::pixel_light::PixelLight;
use super::targets::{has_independent_samples, response, samples_per_rate};
use super::training_data::{ExposedDesign, SURFACE_PATCHES, TrainingData};
use crate::camera::CameraError;
use crate::l3::{Axes, ClassPool, Pipeline, Solved, Solver, representatives, turns};
use crate::numeric::dense::dot;
use crate::sensor::{Cfa, Channel, Mosaic, NoiseMode, SensorError};
use crate::spectrum::{Spectrum, WavelengthGrid};

/// The key that selects this path, for messages.
const KEY: &str = "l3.statistics";
/// Spectral components of the light. With twelve, the mean figures of 30 designs of each number of colours differ by at most 0.0025 ΔE
/// 2000, 0.05 cycles per mm and 0.001 % luminance noise.
const COMPONENTS: usize = 6;
/// Number of mosaics with different classes whose statistics are kept, about 6 MB each.
const KEPT: usize = 16;
/// The largest sample of the light of the training scene, relative to saturation, that is described. Pipelines from light have no classes of
/// saturated patches. Automatic exposure places the white patch of the ColorChecker at 95 % of saturation, and thus a perfect white at 105 %.
const MAX_SAMPLE: f64 = 1.1;

/// Largest number of levels: the sums of a class take 0.4 MB while they are gathered.
const MAX_LEVELS: usize = 64;

/// What the classes of a neutral array depend on: the size of the tile, the translations of the mosaic, and the rotations and reflections
/// that map it onto itself, a bit each.
type Key = ([usize; 2], [[isize; 2]; 2], u8);

/// The statistics for a mosaic, and for all with the same key.
#[derive(Debug)]
struct Kept {
    mosaic: Mosaic,
    key: Key,
    classes: Arc<ClassLight>,
}

/// Learns pipelines from the light of the training scene. It keeps the statistics of the latest mosaics.
#[derive(Debug, Clone)]
pub(super) struct LightTrainer {
    light: Arc<PixelLight>,
    scene: Arc<BrightScene>,
    /// Maximum over the pixels at each wavelength, photons s⁻¹ nm⁻¹.
    brightest: Arc<Vec<f64>>,
    kept: Arc<Mutex<VecDeque<Kept>>>,
}

impl LightTrainer {
    pub(super) fn new(data: &TrainingData) -> Result<Self, CameraError> {
        let TrainingData { camera, settings, pixels, .. } = data;
        let refused = |message: &str| Err(CameraError::Key { key: KEY.into(), message: message.into() });
        if !has_independent_samples(&camera.sensor) {
            return refused(
                "\"light\" needs a sensor whose samples each see one filter, without binning and crosstalk; \"patches\" \
                 serves every sensor",
            );
        }
        if settings.solver != Solver::Wiener {
            return refused("\"light\" needs the solver \"wiener\"; \"patches\" serves every solver");
        }
        if settings.levels > MAX_LEVELS {
            return refused("\"light\" has at most 64 levels; \"patches\" has up to 256");
        }
        let light = Arc::new(PixelLight::new(&camera.sensor, pixels, COMPONENTS)?);
        let brightest = brightest(pixels);
        let scene = BrightScene::new(light.clone(), data.seen.clone(), pixels, &brightest, data.seed);
        Ok(Self { light, scene: Arc::new(scene), brightest: Arc::new(brightest), kept: Arc::default() })
    }

    /// The statistics for a mosaic are gathered, if they are not known yet.
    pub(super) fn prepare(&self, data: &TrainingData, mosaic: &Mosaic) -> Result<(), CameraError> {
        self.classes(data, mosaic).map(|_| ())
    }

    pub(super) fn pipeline(
        &self,
        data: &TrainingData,
        design: &ExposedDesign,
    ) -> Result<Pipeline, CameraError> {
        let ExposedDesign { camera, exposure, scale, axes, .. } = design;
        let bounds = self.largest_samples(design)?;
        let classes = self.classes(data, axes.mosaic())?;
        let gain = samples_per_rate(&camera.sensor, exposure)?;
        let channels = camera.sensor.cfa.channels();
        let responses = |c: &Channel| self.electrons(&c.transmittance).iter().map(|e| gain * e).collect();
        let responses = channels.iter().map(responses).collect();
        let positions = representatives(axes);
        let taps = |position: &usize| (0..axes.taps()).map(|tap| axes.channel_of(*position, tap)).collect();
        let share = 1.0 / axes.positions() as f64;
        // The mean response of a patch to white.
        let white = |position: usize| {
            (0..axes.taps()).map(|tap| design.white[axes.channel_of(position, tap)]).sum::<f64>()
                / axes.taps() as f64
        };
        let even = Surfaces::new(data, design, &positions);
        let mut system = LightSystem {
            responses,
            scale: *scale,
            channels: positions.iter().map(taps).collect(),
            positions,
            share,
            noise: *axes.noise(),
            even: &|position, pool| even.pooled(position, pool),
            saturated: Saturated::default(),
            counts: classes.patch_counts(axes),
        };
        let cells: Vec<usize> = system.positions.iter().map(|p| system.counts.cells(*p)).collect();
        system.saturated = classes.saturated(&self.scene, &system, axes.clip(), &bounds, &cells);
        let system = system;
        let textures = axes.textures().count();
        let count = |position: usize, level: usize, texture: usize| {
            let of_light = classes.pixels().get(level * textures + texture).copied().unwrap_or(0.0);
            let Ok(at) = system.positions.binary_search(&position) else { return (of_light * share) as u64 };
            let pool = ClassPool { level: Some(level), texture: Some(texture) };
            let uniform = even.pooled(at, pool).map_or(0.0, |even| even.count);
            ((of_light - system.saturated.count(at, level, texture)) * share + uniform) as u64
        };
        let levels = camera.sensor.raw_levels(exposure)?;
        let source = classes.kernels(&system);
        let solved = Solved {
            axes,
            outputs: ["X", "Y", "Z"].map(String::from).to_vec(),
            channel_names: channels.iter().map(|c| c.name.clone()).collect(),
            levels: [levels.black, levels.white],
            trained: (0..axes.positions()).map(|p| classes.range().map(|r| r * white(p) as f32)).collect(),
            count: &count,
            source: &source,
        };
        Ok(solved.pipeline(String::new())?)
    }

    /// The statistics for a mosaic.
    fn classes(&self, data: &TrainingData, mosaic: &Mosaic) -> Result<Arc<ClassLight>, CameraError> {
        let kept = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = kept().iter().find(|k| k.mosaic == *mosaic) {
            return Ok(found.classes.clone());
        }
        let clear = Spectrum::constant(data.camera.grid(), 1.0)?;
        let channel = |c: usize| Channel { name: c.to_string(), transmittance: clear.clone() };
        let channels = (0..mosaic.channels()).map(channel).collect();
        let neutral = Cfa::new("neutral", mosaic.clone(), channels).map_err(SensorError::from)?;
        let neutral = data.exposed(&neutral)?;
        let key = key(&neutral.axes);
        let known = kept().iter().find(|k| k.key == key).map(|k| k.classes.clone());
        // The lock is open while this is computed: a thread that waits for others may take up work that needs it.
        let gather = || {
            let (sensor, exposure) = (&neutral.camera.sensor, &neutral.exposure);
            let seen = sensor.capture(&*data.pixels, exposure, NoiseMode::All, data.seed)?;
            let (axes, white) = (&neutral.axes, neutral.full as f32);
            let even = f64::from(SURFACE_PATCHES) * data.surfaces.len() as f64 / axes.level_count() as f64;
            let classes = ClassLight::new(&self.light, &data.seen, axes, &seen, white, even)?;
            Ok::<_, CameraError>(Arc::new(classes))
        };
        let classes = known.map_or_else(gather, Ok)?;
        let new = Kept { mosaic: mosaic.clone(), key, classes: classes.clone() };
        keep_latest(&mut kept(), KEPT, new);
        Ok(classes)
    }

    /// Bounds of the samples of each channel of a design.
    ///
    /// # Errors
    /// [`CameraError::TrainingSaturates`] when the light of the training scene saturates a channel by more than [`MAX_SAMPLE`].
    fn largest_samples(&self, design: &ExposedDesign) -> Result<Vec<f64>, CameraError> {
        let sensor = &design.camera.sensor;
        let gain = samples_per_rate(sensor, &design.exposure)?;
        let mut bounds = Vec::new();
        for (channel, response) in sensor.cfa.channels().iter().zip(response(sensor, self.grid())?) {
            let bound: f64 = response.iter().zip(&*self.brightest).map(|(r, b)| r * b).sum();
            if bound * gain > MAX_SAMPLE && self.largest(&channel.transmittance) * gain > MAX_SAMPLE {
                return Err(CameraError::TrainingSaturates { channel: channel.name.clone() });
            }
            bounds.push(bound * gain);
        }
        Ok(bounds)
    }

    fn grid(&self) -> WavelengthGrid {
        self.light.spectra().first().map(Spectrum::grid).unwrap_or_default()
    }

    /// Photoelectrons per second of a unit of each component behind a filter.
    fn electrons(&self, transmittance: &Spectrum) -> Vec<f64> {
        let step = self.grid().step_nm();
        let of = |s: &Spectrum| step * dot(s.values(), transmittance.values());
        self.light.spectra().iter().map(of).collect()
    }

    /// The most photoelectrons per second of a pixel of the training scene behind a filter.
    fn largest(&self, transmittance: &Spectrum) -> f64 {
        let electrons = self.electrons(transmittance);
        let planes = self.light.planes();
        let of = |i: usize| planes.planes().zip(&electrons).map(|(p, e)| f64::from(p[i]) * e).sum::<f64>();
        (0..planes.plane_len()).map(of).fold(0.0, f64::max)
    }
}

fn key(axes: &Axes) -> Key {
    let tile = [axes.mosaic().rows(), axes.mosaic().cols()];
    let bits = turns(axes).iter().fold(0, |bits, turn| bits | 1u8 << turn.number);
    (tile, axes.contrast_pairs().map(|p| p.shift), bits)
}

/// Samples of each channel and X, Y, Z of a uniform surface.
type Field = (Vec<f64>, [f64; 3]);

/// The uniform surfaces at the positions of a design.
struct Surfaces {
    fields: Vec<Field>,
    /// The level of each, by position.
    levels: Vec<Vec<usize>>,
    /// By position and level, and last all levels.
    pooled: Vec<Vec<Option<EvenPatches>>>,
}

impl Surfaces {
    fn new(data: &TrainingData, design: &ExposedDesign, positions: &[usize]) -> Self {
        let axes = &design.axes;
        let fields: Vec<Field> = data
            .surfaces
            .iter()
            .map(|(radiance, xyz)| (design.samples(radiance), xyz.map(|v| v * design.full)))
            .filter(|(samples, _)| samples.iter().all(|v| *v < axes.clip()))
            .collect();
        let of_position = |position: &usize| -> Vec<usize> {
            // The share of each channel in the patch.
            let mut shares = vec![0.0; axes.mosaic().channels()];
            for tap in 0..axes.taps() {
                shares[axes.channel_of(*position, tap)] += 1.0 / axes.taps() as f64;
            }
            let levels = axes.levels_at(*position);
            fields.iter().map(|(samples, _)| levels.level_of(dot(samples, &shares) as f32)).collect()
        };
        let levels: Vec<Vec<usize>> = positions.iter().map(of_position).collect();
        let mut this = Self { fields, levels, pooled: Vec::new() };
        let count = axes.level_count();
        this.pooled = (0..positions.len())
            .map(|at| (0..=count).map(|l| this.even(at, (l < count).then_some(l))).collect())
            .collect();
        this
    }

    /// The uniform patches of a pool, which are flat.
    fn pooled(&self, position: usize, pool: ClassPool) -> Option<EvenPatches> {
        if pool.texture.is_some_and(|t| t != 0) {
            return None;
        }
        let of = self.pooled.get(position)?;
        of.get(pool.level.unwrap_or(of.len() - 1))?.clone()
    }

    fn even(&self, position: usize, level: Option<usize>) -> Option<EvenPatches> {
        let fits = |l: &usize| level.is_none_or(|level| level == *l);
        let members = || {
            self.fields.iter().zip(&self.levels[position]).filter(|(_, l)| fits(l)).map(|(field, _)| field)
        };
        let channels = members().next()?.0.len();
        let share = 1.0 / members().count() as f64;
        let (mut mean, mut target) = (vec![0.0; channels], [0.0; 3]);
        for (samples, xyz) in members() {
            mean.iter_mut().zip(samples).for_each(|(m, v)| *m += share * v);
            target.iter_mut().zip(xyz).for_each(|(t, v)| *t += share * v);
        }
        let (mut covariance, mut crossed) = (vec![0.0; channels * channels], vec![[0.0; 3]; channels]);
        let mut from_mean = vec![0.0; channels];
        for (samples, xyz) in members() {
            from_mean.iter_mut().zip(samples.iter().zip(&mean)).for_each(|(d, (v, m))| *d = v - m);
            let of_target = [0, 1, 2].map(|o| share * (xyz[o] - target[o]));
            let rows = covariance.chunks_exact_mut(channels).zip(&mut crossed);
            for ((row, crossed), &d) in rows.zip(&from_mean) {
                row.iter_mut().zip(&from_mean).for_each(|(c, e)| *c += share * d * e);
                crossed.iter_mut().zip(of_target).for_each(|(c, t)| *c += d * t);
            }
        }
        let count = f64::from(SURFACE_PATCHES) / share;
        Some(EvenPatches { count, mean, covariance, target, crossed })
    }
}
