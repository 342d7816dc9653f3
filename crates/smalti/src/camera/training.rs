//! Training pairs by simulation: raw images of a camera and their target pictures.

use super::chart::LUMINANCE;
use super::reference::Witness;
use super::score::{Brightness, limit_brightness};
use super::{Camera, CameraError, LevelRule, SceneNoise, TrainingSettings, TrainingTarget};
use crate::isp::IspError;
use crate::l3::{Axes, L3Error, Learner, Levels, Pair, RefinementAxes, Share, Statistics, Tiles};
use crate::numeric::Planes;
use crate::numeric::simd::{Kernel, dispatch};
use crate::optics::{Optics, OpticsModel};
use crate::scene::{self, Scene, Setting};
use crate::sensor::{Channel, ElectronRates, Exposure, FixedPattern, NoiseMode, Sensor};
use crate::spectrum::{Extrapolation, Illuminant, Observer, Spectrum};

/// The quantile of the response that defines an exposure.
const BRIGHT: f64 = 0.99;
/// Limits of the largest default exposure, at which white saturates the darkest channel. Beyond it, white carries no further
/// information, and colours would dominate the classes of clipped patches, which contain highlights in real pictures.
const OVEREXPOSED: [f64; 2] = [1.2, 3.0];
/// Largest ratio between adjacent default exposures, so that every level contains both bright and dark parts of scenes.
const EXPOSURE_RATIO: f64 = 2.5;
/// Least mean luminous efficiency of the response of a channel for it to indicate luminance: about 0.05 for blue, 0.001 for near
/// infrared.
const MIN_SEEN: f64 = 0.01;
/// Highest cut between response levels, relative to saturation.
pub(crate) const HIGHEST_CUT: f64 = 0.85;
/// Levels of the second stage.
const REFINEMENT_LEVELS: usize = 12;

/// A scene in training.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrainingItem {
    /// Identifies the scene, so that every scene has its own noise.
    number: u64,
    times: u32,
    is_halved: bool,
}

impl From<u64> for TrainingItem {
    /// All patches of the scene of a number, which counts once.
    fn from(number: u64) -> Self {
        Self { number, times: 1, is_halved: false }
    }
}

impl TrainingItem {
    /// The scene of a number, which counts several times, with half of its patches at each exposure: the other half at the next one
    /// ([`Tiles`]). In a set of many scenes, the rest would teach little that is new. Scenes of even and of odd numbers begin with
    /// different halves, so that no exposure is learned from one half alone.
    pub(super) fn halved(number: u64, times: u32) -> Self {
        Self { number, times, is_halved: true }
    }

    /// What to learn from at exposure number `i`.
    fn share(self, i: u64) -> Share {
        let half = [Tiles::Even, Tiles::Odd][((self.number ^ i) & 1) as usize];
        Share { tiles: if self.is_halved { half } else { Tiles::All }, times: self.times }
    }
}

/// A camera before a scene, ready to learn from its light.
pub(crate) struct Stand {
    /// The camera, as large as the scene.
    camera: Camera,
    exposure: Exposure,
    /// Its sensor in the light that the scene is built under.
    sensor: Sensor,
    /// The sensitivities of the target in the same light.
    witness: Witness,
    /// The illuminant, photons.
    light: Spectrum,
}

impl Stand {
    /// The sensors of camera and target, whose rates [`Stand::learn`] needs.
    pub(crate) fn sensors(&self) -> [&Sensor; 2] {
        [&self.sensor, &self.witness.sensor]
    }

    /// Adds the scene at every exposure. The fixed pattern is kept from scene to scene, and the noise is shared by cameras before the same scene.
    pub(crate) fn learn(
        &self,
        learner: &mut dyn Learner,
        [rates, witnessed]: [ElectronRates; 2],
        (pattern, noise): (&mut FixedPattern, Option<&SceneNoise>),
        settings: &TrainingSettings,
        item: TrainingItem,
    ) -> Result<(), CameraError> {
        let Self { camera, exposure, witness, light, .. } = self;
        let rates = &rates.with_kept_pattern(&self.sensor, pattern);
        let seen = witness.seen((&witnessed, 1.0))?;
        let target = &camera.target_as_exposed(seen, &settings.target, exposure, light)?;
        camera.add_exposures(learner, SeenScene { rates, target, light, noise }, exposure, settings, item)
    }
}

/// A scene on a camera.
#[derive(Clone, Copy)]
struct SeenScene<'a> {
    rates: &'a ElectronRates,
    /// One plane for each output, on the scale of the rates.
    target: &'a Planes,
    /// The illuminant, photons.
    light: &'a Spectrum,
    noise: Option<&'a SceneNoise>,
}

impl Camera {
    /// The nominal exposure of training: the stated one, or the automatic exposure for a white field of 100 cd/m².
    ///
    /// # Errors
    /// When no exposure is found.
    pub fn nominal_exposure(&self) -> Result<Exposure, CameraError> {
        let setting = Setting { grid: self.grid(), ..Setting::default() };
        let white = scene::uniform(8, 8, &setting)?;
        let camera = self.with_size(4, 4);
        camera.exposure(&camera.optics.image(&white)?)
    }

    /// The class axes of a pipeline for this camera, with levels cut for white under an illuminant (photons).
    ///
    /// # Errors
    /// When a setting is invalid for the camera.
    pub fn training_axes(&self, settings: &TrainingSettings, light: &Spectrum) -> Result<Axes, CameraError> {
        self.ensure_one_gain()?;
        let noise = self.sensor.signal_noise(&self.nominal_exposure()?)?;
        let dark = noise.variance(0.0).sqrt();
        let levels = match settings.level_rule {
            LevelRule::Logarithmic => {
                Levels::logarithmic(settings.levels, (dark / 2.0).max(1e-5), HIGHEST_CUT)?
            }
            LevelRule::NoiseSteps => Levels::noise_steps(settings.levels, &noise, HIGHEST_CUT)?,
        };
        // A channel that does not respond to the illuminant, such as infrared under LED light, gets levels within its noise.
        let (white, brightest) = self.white_responses(light)?;
        let white: Vec<f64> = white.iter().map(|w| w.max(1e-3 * brightest)).collect();
        let axes = Axes::new(self.sensor.cfa.mosaic().clone(), settings.side, levels, noise)?;
        Ok(axes.with_levels_by_position(&white)?.with_textures(settings.textures))
    }

    /// The class axes of the second stage of a pipeline, in units of the Y of a white diffuser under an illuminant (photons) that
    /// just saturates its brightest channel.
    ///
    /// # Errors
    /// When no exposure is found, or the camera does not respond to the illuminant.
    pub fn refinement_axes(&self, light: &Spectrum) -> Result<RefinementAxes, CameraError> {
        let ((white, brightest), cells) = (self.white_responses(light)?, self.sensor.cfa.mosaic().cells());
        let mean = cells.iter().map(|&c| white[usize::from(c)] / brightest).sum::<f64>() / cells.len() as f64;
        self.refinement_axes_at(mean)
    }

    /// The class axes of the second stage of a pipeline whose pictures have Y = 1 where the mean of the normalised samples is
    /// `mean_of_white`.
    ///
    /// # Errors
    /// When no exposure is found, or the mean is not above 0.
    pub fn refinement_axes_at(&self, mean_of_white: f64) -> Result<RefinementAxes, CameraError> {
        let (noise, mean) = (self.sensor.signal_noise(&self.nominal_exposure()?)?, mean_of_white);
        let of_y =
            [(noise.variance(0.0) / (mean * mean)).max(1e-12), noise.per_signal / mean, noise.quadratic()];
        let levels = Levels::logarithmic(REFINEMENT_LEVELS, of_y[0].sqrt() / 2.0, HIGHEST_CUT)?;
        Ok(RefinementAxes::new(levels, of_y.map(|v| v as f32))?)
    }

    /// The responses of the channels to white under an illuminant (photons), and the largest of them.
    fn white_responses(&self, light: &Spectrum) -> Result<(Vec<f64>, f64), CameraError> {
        let response = |s: &Spectrum| Ok::<f64, CameraError>(s.times(light)?.integral());
        let white = self.responsivities()?.iter().map(response).collect::<Result<Vec<_>, _>>()?;
        let brightest = white.iter().copied().fold(0.0, f64::max);
        if brightest <= 0.0 {
            return Err(IspError::NoResponse("the camera").into());
        }
        Ok((white, brightest))
    }

    /// Empty statistics for [`Camera::train_on`].
    ///
    /// # Errors
    /// As [`Camera::training_axes`].
    pub fn training_statistics(
        &self,
        settings: &TrainingSettings,
        light: &Spectrum,
    ) -> Result<Statistics, CameraError> {
        let outputs = match &settings.target {
            TrainingTarget::Xyz => ["X", "Y", "Z"].map(String::from).to_vec(),
            TrainingTarget::Channels(channels) => channels.iter().map(|c| c.name.clone()).collect(),
        };
        let white = match (&settings.target, &settings.target_light) {
            (TrainingTarget::Channels(_), _) => None,
            (TrainingTarget::Xyz, None) => Some(light.clone()),
            (TrainingTarget::Xyz, Some(other)) => Some(other.photons(self.grid())?),
        };
        let xyz = |light: &Spectrum| Ok::<_, CameraError>(Observer::Cie1931.xyz_from_photons(light)?);
        // Rounding to nine digits lets statistics of scenes merge whose luminances differ, and with them the last bits of white.
        let relative = |w: [f64; 3]| w.map(|v| (v / w[1] * 1e9).round() / 1e9);
        let white = white.as_ref().map(xyz).transpose()?.map(relative);
        Ok(Statistics::new(self.training_axes(settings, light)?, outputs, false)?.with_white(white))
    }

    /// Adds a scene at every exposure: patches without noise, classified with noise, and their targets.
    ///
    /// # Errors
    /// When a stage fails.
    pub fn train_on(
        &self,
        learner: &mut dyn Learner,
        scene: &Scene,
        settings: &TrainingSettings,
        item: impl Into<TrainingItem>,
    ) -> Result<(), CameraError> {
        let (image, item) = (self.training_image(scene, self.training_sampling(scene)?)?, item.into());
        if settings.has_own_images() {
            let camera = self.with_scene_size(scene)?;
            let exposure = camera.nominal_exposure()?;
            let target = camera.training_target(scene, settings, &exposure)?;
            let rates = &ElectronRates::new(&camera.sensor, &image)?.with_pattern_of(&camera.sensor);
            let seen = SeenScene { rates, target: &target, light: scene.illuminant(), noise: None };
            return camera.add_exposures(learner, seen, &exposure, settings, item);
        }
        let stand = self.stand(scene, None, settings)?;
        let rates = ElectronRates::of_each(stand.sensors(), &image)?;
        stand.learn(learner, rates, (&mut FixedPattern::default(), None), settings, item)
    }

    /// This camera before a scene, whose target has no optical image of its own. With an illuminant, the scene is as if under it, which
    /// may differ from the relit scene by a common factor and by rounding: the ratio of the lights multiplies the sensitivities instead.
    pub(crate) fn stand(
        &self,
        scene: &Scene,
        illuminant: Option<&Illuminant>,
        settings: &TrainingSettings,
    ) -> Result<Stand, CameraError> {
        let camera = self.with_scene_size(scene)?;
        let exposure = camera.nominal_exposure()?;
        let channels = camera.target_channels(&settings.target)?;
        let Some(illuminant) = illuminant else {
            let (sensor, light) = (camera.sensor.clone(), scene.illuminant().clone());
            return Ok(Stand { witness: camera.witness(&channels)?, camera, exposure, sensor, light });
        };
        let light = illuminant.photons(self.grid())?;
        let ratios = scene.ratios_to(&light)?;
        // At most 1, so that a quantum efficiency remains one.
        let largest = ratios.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let ratios = Spectrum::new(self.grid(), ratios.iter().map(|r| r / largest).collect())?;
        let in_light = |curve: &Spectrum, beyond| curve.resampled(self.grid(), beyond)?.times(&ratios);
        let relit = |c: &Channel| -> Result<Channel, CameraError> {
            let transmittance = in_light(&c.transmittance, Extrapolation::Zero)?;
            Ok(Channel { name: c.name.clone(), transmittance })
        };
        let channels = channels.iter().map(relit).collect::<Result<Vec<_>, _>>()?;
        let quantum_efficiency = in_light(&camera.sensor.quantum_efficiency, Extrapolation::Error)?;
        let sensor = Sensor { quantum_efficiency, ..camera.sensor.clone() };
        Ok(Stand { witness: camera.witness(&channels)?, camera, exposure, sensor, light })
    }

    /// Adds a scene at every exposure. This camera has as many pixels as the scene covers.
    fn add_exposures(
        &self,
        learner: &mut dyn Learner,
        SeenScene { rates, target, light, noise }: SeenScene<'_>,
        exposure: &Exposure,
        settings: &TrainingSettings,
        item: TrainingItem,
    ) -> Result<(), CameraError> {
        let (base, bright) = self.bright_response(rates, exposure)?;
        let most = self.knowable_luminance(light)?;
        let exposures = if settings.exposures.is_empty() {
            let dark = learner.axes().noise().variance(0.0).sqrt().max(1e-4);
            default_exposures(most, 2.0 * dark)
        } else {
            settings.exposures.clone()
        };
        let mut limited = Planes::zeros(target.rows(), target.cols(), target.count());
        for (response, i) in exposures.into_iter().zip(0..) {
            let factor = base * response / bright;
            let ideal = self.sensor.capture_ideal((rates, factor), exposure)?;
            let seed = settings.seed.wrapping_add((item.number << 16) + i);
            let drawn = noise.and_then(|noise| noise.at(i, &self.sensor, seed));
            let seen = self.sensor.capture_with((rates, factor), exposure, (NoiseMode::All, seed), drawn)?;
            dispatch(Scaled { from: target.data(), factor, to: limited.data_mut() });
            bound(&mut limited, &settings.target, most)?;
            let target = &limited;
            learner.add_share(&Pair { raw: &ideal, seen: Some(&seen), target }, item.share(i))?;
        }
        Ok(())
    }

    /// The Y of a white diffuser that just saturates its darkest channel, at least 1. The raw image does not determine the
    /// luminance of brighter light. Channels with little luminous efficiency, such as near infrared, are ignored.
    pub(crate) fn knowable_luminance(&self, light: &Spectrum) -> Result<f64, CameraError> {
        let y = &Observer::Cie1931.photon_weights(light.grid())?[1];
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        for channel in self.responsivities()? {
            let response = channel.times(light)?;
            let (white, seen) = (response.integral(), response.times(y)?.integral() / y.max());
            most = most.max(white);
            if seen > MIN_SEEN * white {
                least = least.min(white);
            }
        }
        Ok((most / least).clamp(1.0, 1e3))
    }

    /// The camera with as many pixels as a scene covers, all of them read.
    pub(crate) fn with_scene_size(&self, scene: &Scene) -> Result<Self, CameraError> {
        let large = self.with_size(1 << 14, 1 << 14);
        let window = large.window_on(scene)?;
        let mut camera = self.with_size(window.rows, window.cols);
        camera.sensor.window = None;
        Ok(camera)
    }

    /// The targets of a scene, one plane per output.
    fn training_target(
        &self,
        scene: &Scene,
        settings: &TrainingSettings,
        exposure: &Exposure,
    ) -> Result<Planes, CameraError> {
        let optics = match (self.training_optics(), settings.sharp) {
            (optics, true) => Optics { model: OpticsModel::Pinhole, ..optics },
            (optics, false) => optics,
        };
        let image = match &settings.target_light {
            Some(other) => optics.image_of_scene(&relit_white(scene, other)?)?,
            None => optics.image_of_scene(scene)?,
        };
        let seen = self.seen_by(&image, &self.target_channels(&settings.target)?)?;
        self.target_as_exposed(seen, &settings.target, exposure, scene.illuminant())
    }

    /// The sensitivities of a target.
    fn target_channels(&self, target: &TrainingTarget) -> Result<Vec<Channel>, CameraError> {
        match target {
            TrainingTarget::Xyz => self.observer_channels(),
            TrainingTarget::Channels(channels) => Ok(channels.clone()),
        }
    }

    /// The response of the target's sensitivities, scaled to an exposure under an illuminant.
    fn target_as_exposed(
        &self,
        seen: Planes,
        target: &TrainingTarget,
        exposure: &Exposure,
        light: &Spectrum,
    ) -> Result<Planes, CameraError> {
        match target {
            TrainingTarget::Xyz => Ok(self.as_exposed(seen, exposure, light)?.into_planes()),
            TrainingTarget::Channels(channels) => self.channels_as_exposed(&seen, channels, exposure, light),
        }
    }

    /// The responses `seen` by other sensitivities, scaled so that a white of Y = 1 is 1 in the largest response.
    fn channels_as_exposed(
        &self,
        seen: &Planes,
        channels: &[Channel],
        exposure: &Exposure,
        light: &Spectrum,
    ) -> Result<Planes, CameraError> {
        let mut scale = f64::INFINITY;
        for channel in channels {
            // The largest response to white has the smallest factor; channels without response are skipped.
            match self.exposure_scale(exposure, light, &channel.transmittance) {
                Err(CameraError::Isp(IspError::NoResponse("the target"))) => {}
                found => scale = scale.min(found?),
            }
        }
        if !scale.is_finite() {
            return Err(IspError::NoResponse("the target").into());
        }
        Ok(scaled(seen, scale))
    }

    /// A factor on the light at which few pixels clip, and the bright quantile of the response at this light.
    fn bright_response(&self, rates: &ElectronRates, exposure: &Exposure) -> Result<(f64, f64), CameraError> {
        let mut factor = 1.0;
        for _ in 0..12 {
            let raw = self.sensor.capture_ideal((rates, factor), exposure)?;
            let mut values = raw.normalized();
            let at = ((values.len() - 1) as f64 * BRIGHT) as usize;
            let (_, &mut bright, _) = values.select_nth_unstable_by(at, f32::total_cmp);
            if bright > 0.0 && bright < 0.98 {
                return Ok((factor, f64::from(bright)));
            }
            factor *= if bright > 0.0 { 0.01 } else { 1e4 };
        }
        Err(L3Error::Dark.into())
    }
}

/// The scene under another illuminant, with the same luminance of a white diffuser.
fn relit_white(scene: &Scene, other: &Illuminant) -> Result<Scene, CameraError> {
    let y = &Observer::Cie1931.photon_weights(scene.radiance().grid())?[1];
    let white = |s: &Scene| Ok::<f64, CameraError>(s.illuminant().times(y)?.integral());
    let (before, lit) = (white(scene)?, scene.clone().relit(other)?);
    let luminance = lit.mean_luminance_cd_m2()? * before / white(&lit)?;
    Ok(lit.with_mean_luminance(luminance)?)
}

/// Planes times a factor.
fn scaled(planes: &Planes, factor: f64) -> Planes {
    let mut out = Planes::zeros(planes.rows(), planes.cols(), planes.count());
    dispatch(Scaled { from: planes.data(), factor, to: out.data_mut() });
    out
}

/// Values times a factor, rounded once.
struct Scaled<'a> {
    from: &'a [f32],
    factor: f64,
    to: &'a mut [f32],
}

impl Kernel for Scaled<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (to, v) in self.to.iter_mut().zip(self.from) {
            *to = (f64::from(*v) * self.factor) as f32;
        }
    }
}

/// Exposures from the brightest down to the least response, including 1.
fn default_exposures(knowable: f64, least: f64) -> Vec<f64> {
    let [low, high] = OVEREXPOSED;
    let most = knowable.clamp(low, high);
    let above = (most.ln() / EXPOSURE_RATIO.ln()).ceil().max(1.0) as i32;
    let below = ((1.0 / least).ln() / EXPOSURE_RATIO.ln()).ceil().max(0.0) as i32;
    let over = (0..above).map(|i| most.powf(1.0 - f64::from(i) / f64::from(above)));
    over.chain((0..=below).map(|i| EXPOSURE_RATIO.powi(-i))).collect()
}

/// Limits the brightness of targets (Y, or the largest of other outputs) to `most` and keeps their ratios. Targets that the raw image cannot
/// determine would distort the kernels of their classes.
fn bound(target: &mut Planes, kind: &TrainingTarget, most: f64) -> Result<(), CameraError> {
    let brightness = match kind {
        TrainingTarget::Xyz => Brightness::Plane(LUMINANCE),
        TrainingTarget::Channels(_) => Brightness::Largest,
    };
    Ok(limit_brightness(target, most as f32, brightness)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposures_run_from_beyond_saturation_to_the_dark_by_way_of_one() {
        for (knowable, first) in [(1.0, 1.2), (1.6, 1.6), (2.9, 2.9), (1e3, 3.0)] {
            let all = default_exposures(knowable, 0.02);
            assert!((all[0] - first).abs() < 1e-12 && all.contains(&1.0), "{all:?}");
            assert!(*all.last().unwrap() <= 0.02 && all[all.len() - 2] > 0.02);
            assert!(all.windows(2).all(|w| w[0] > w[1] && w[0] <= w[1] * EXPOSURE_RATIO * 1.0001), "{all:?}");
        }
        assert_eq!(default_exposures(1.0, 2.0), [1.2, 1.0]);
    }

    #[test]
    fn what_cannot_be_known_is_not_a_target() {
        let bounded = |kind: &TrainingTarget, most| {
            let values = vec![0.5, 4.0, 0.0, 1.0, 2.0, 0.0, 0.2, 1.0, 0.0];
            let mut planes = Planes::new(1, 3, 3, values).unwrap();
            bound(&mut planes, kind, most).unwrap();
            planes
        };
        let xyz = bounded(&TrainingTarget::Xyz, 1.5);
        assert_eq!(xyz.data(), [0.5, 3.0, 0.0, 1.0, 1.5, 0.0, 0.2, 0.75, 0.0]);
        // For other outputs, the largest one is limited.
        let bands = bounded(&TrainingTarget::Channels(Vec::new()), 1.0);
        assert_eq!(bands.data(), [0.5, 1.0, 0.0, 1.0, 0.5, 0.0, 0.2, 0.25, 0.0]);
    }
}
