//! Contenders of a comparison: cameras with their processing and learned pipelines.

use std::ops::Range;

use super::error::StageContext;
use super::lights::{PipelineSet, SceneLight, ensure_lights_suffice};
use super::progress::{Stoppable, ensure_running};
use super::{ExperimentError, Processing, Progress, Resources};
use crate::camera::compare::{IntegratedScene, SeedScores};
use crate::camera::description::IspDescription;
use crate::camera::{
    Camera, CameraError, Evaluation, EvaluationPictures, EvaluationSettings, PICTURE_METRICS, SceneScores,
    ScoreSettings, Setup, evaluate_with, picture_cpsnr_db,
};
use crate::color::{ColorSpace, Image};
use crate::isp::{Classic, Isp, WhiteBalance};
use crate::l3::{L3Error, Quality, peak_ratio_db};
use crate::numeric::Number;
use crate::sensor::RawImage;
use crate::spectrum::{Illuminant, Spectrum};

/// A luminance noise gain from which on a colour matrix explains why a picture cannot be measured.
const AMPLIFIED: f64 = 5.0;

/// A camera with its processing.
#[derive(Clone, Copy)]
pub struct Contender<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The unique name of the camera in results.
    pub label: &'a str,
    /// Its processing.
    pub processing: Processing,
    /// The learned pipelines for [`Processing::L3`].
    pub pipelines: Option<&'a PipelineSet>,
}

impl<'a> Contender<'a> {
    /// A camera with the processing of its description.
    #[must_use]
    pub fn as_described(camera: &'a Camera, label: &'a str) -> Self {
        let processing = Processing::Classic(camera.description().isp.demosaic);
        Self { camera, label, processing, pipelines: None }
    }

    /// A camera with learned pipelines if there are any, otherwise with the processing of its description.
    #[must_use]
    pub fn with_pipelines(camera: &'a Camera, label: &'a str, pipelines: Option<&'a PipelineSet>) -> Self {
        let own = Self::as_described(camera, label);
        if pipelines.is_some() { Self { processing: Processing::L3, pipelines, ..own } } else { own }
    }

    /// The camera's label and the name of the processing.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} {}", self.label, self.method())
    }

    /// The name of the processing, with the quality of learned pipelines that is not the usual one: `l3 best`.
    #[must_use]
    pub fn method(&self) -> String {
        let name = self.processing.name();
        match self.quality() {
            Some(quality) if quality != Quality::default() => format!("{name} {}", quality.name()),
            _ => name.to_owned(),
        }
    }

    /// The quality of learned pipelines.
    #[must_use]
    pub fn quality(&self) -> Option<Quality> {
        self.pipelines.map(|pipelines| pipelines.main().quality())
    }

    /// Whether it can render scenes under a light (photons): its pipeline for the light may be still to be learned.
    pub(super) fn is_ready_for(&self, light: &Spectrum) -> bool {
        self.processing != Processing::L3
            || self.pipelines.is_some_and(|pipelines| pipelines.for_light(light).is_some())
    }

    /// Whether the processing is defined for the camera's mosaic.
    #[must_use]
    pub fn is_defined(&self) -> bool {
        self.processing.is_defined_for(self.camera.sensor.cfa.mosaic())
    }

    /// Whether a method for Bayer mosaics treats another channel than green as green, in words: of an array such as RCCB, the clear
    /// channel. `None` for all other contenders.
    #[must_use]
    pub fn other_than_green(&self) -> Option<String> {
        let cfa = &self.camera.sensor.cfa;
        let phase = match self.processing {
            Processing::Classic(demosaic) if demosaic.is_for_bayer() => cfa.mosaic().bayer_phase()?,
            Processing::Classic(_) | Processing::L3 => return None,
        };
        let channel = &cfa.channels().get(phase.diagonal)?.name;
        (!channel.eq_ignore_ascii_case("g")).then(|| {
            format!(
                "{}: the method takes channel {channel} for the green of a Bayer mosaic, whose correlation with red and blue it relies on",
                self.name()
            )
        })
    }

    /// The processing for scenes under an illuminant (photons). It fails once the caller stops the work.
    pub(super) fn isp<'b>(
        &self,
        light: &Spectrum,
        progress: &'b dyn Progress,
    ) -> Result<Box<dyn Isp + 'b>, CameraError>
    where
        'a: 'b,
    {
        let isp: Box<dyn Isp + 'b> = match (self.processing, self.pipelines) {
            (Processing::L3, Some(pipelines)) => {
                let pipeline = pipelines.for_light(light).ok_or(L3Error::NoPipeline)?;
                pipeline.ensure_renders(&self.camera.sensor.cfa)?;
                Box::new(pipeline)
            }
            (Processing::L3, None) => return Err(L3Error::NoPipeline.into()),
            (Processing::Classic(demosaic), _) => {
                let camera = self.camera.on_grid(light.grid())?;
                Box::new(Classic { demosaic, ..camera.isp(light, WhiteBalance::None)? })
            }
        };
        Ok(Box::new(Stoppable { isp, progress }))
    }

    /// [`ColorMatrix::luminance_noise_gain`](crate::isp::ColorMatrix::luminance_noise_gain) of classic processing. `None` without a colour
    /// matrix.
    fn luminance_noise_gain(&self, illuminant: &Illuminant) -> Option<f64> {
        let Processing::Classic(_) = self.processing else { return None };
        let light = illuminant.photons(self.camera.grid()).ok()?;
        let isp = self.camera.isp(&light, WhiteBalance::None).ok()?;
        Some(isp.color_matrix.luminance_noise_gain())
    }

    /// Scores the camera on the built-in targets; see [`evaluate_with`].
    ///
    /// # Errors
    /// When a stage fails, a metric cannot be computed, or the work is stopped.
    pub fn evaluate(
        &self,
        settings: &EvaluationSettings,
        resources: Resources<'_>,
    ) -> Result<(Evaluation, EvaluationPictures), ExperimentError> {
        let lights = [SceneLight { illuminant: settings.illuminant.clone(), grid: None }];
        ensure_lights_suffice([(self.label, self.camera)], &lights)?;
        let isp = |light: &Spectrum| self.isp(light, resources.progress);
        evaluate_with(self.camera, settings, &resources.images(), &isp).map_err(|e| {
            let gain = self.luminance_noise_gain(&settings.illuminant).filter(|gain| *gain > AMPLIFIED);
            let matrix = match (&e, gain) {
                (CameraError::Metric(_), Some(gain)) => format!(
                    ": the colour matrix amplifies noise and interpolation errors {gain:.0} times, since `isp.color_noise_percent` is {}; \
                     expected a larger value, such as {}",
                    self.camera.description().isp.color_noise_percent,
                    IspDescription::default().color_noise_percent,
                ),
                _ => String::new(),
            };
            ExperimentError::stage(format!("{} at {} cd/m²{matrix}", self.label, Number(settings.luminance_cd_m2)), e)
        })
    }
}

/// Checks that a kind of processing is defined for the mosaic of a camera, before any work for the comparison.
///
/// # Errors
/// [`ExperimentError::NothingToCompare`].
pub fn ensure_any_defined(cameras: &[Camera], processing: &[Processing]) -> Result<(), ExperimentError> {
    let is_defined = |c: &Camera| processing.iter().any(|p| p.is_defined_for(c.sensor.cfa.mosaic()));
    if cameras.iter().any(is_defined) { Ok(()) } else { Err(ExperimentError::NothingToCompare) }
}

/// Every camera with every kind of processing, each once, and the names of those that are left out because the processing is not
/// defined for the mosaic.
///
/// # Errors
/// [`ExperimentError::NothingToCompare`].
pub fn contenders<'a>(
    cameras: &'a [Camera],
    labels: &'a [String],
    pipelines: &'a [Option<PipelineSet>],
    processing: &[Processing],
) -> Result<(Vec<Contender<'a>>, Vec<String>), ExperimentError> {
    let (mut defined, mut left_out) = (Vec::new(), Vec::new());
    for ((camera, label), pipelines) in cameras.iter().zip(labels).zip(pipelines) {
        let unique = |(i, kind): &(usize, &Processing)| !processing[..*i].contains(kind);
        for (_, &kind) in processing.iter().enumerate().filter(unique) {
            let contender = Contender { camera, label, processing: kind, pipelines: pipelines.as_ref() };
            if contender.is_defined() { defined.push(contender) } else { left_out.push(contender.name()) }
        }
    }
    if defined.is_empty() { Err(ExperimentError::NothingToCompare) } else { Ok((defined, left_out)) }
}

/// Captures a scene at a mean luminance, renders the raw image and scores the picture, for the first seed; then the figures of
/// the pictures for every seed. `setup` is the scene at 1 cd/m². The exposure time is `time_s`, s, or that of the camera's
/// description.
///
/// # Errors
/// When a stage fails, the scene is dark, there is no seed, or the work is stopped.
pub fn score_scene(
    contender: &Contender<'_>,
    setup: &Setup,
    light: (f64, Option<f64>),
    seeds: Range<u64>,
    score: &ScoreSettings,
    progress: &dyn Progress,
) -> Result<ScoredScene, ExperimentError> {
    let integrated = IntegratedScene::new(setup.clone());
    let scene = integrated.in_context(|| format!("{} at {} cd/m²", contender.name(), Number(light.0)))?;
    score_integrated(contender, &scene, light, seeds, score, progress)
}

/// [`score_scene`] for a scene that is integrated over wavelength.
pub(super) fn score_integrated(
    contender: &Contender<'_>,
    scene: &IntegratedScene,
    (luminance_cd_m2, time_s): (f64, Option<f64>),
    seeds: Range<u64>,
    score: &ScoreSettings,
    progress: &dyn Progress,
) -> Result<ScoredScene, ExperimentError> {
    ensure_running(progress)?;
    let scored = || -> Result<_, CameraError> {
        let (light, exposure) = (scene.light(luminance_cd_m2)?, scene.exposure(luminance_cd_m2, time_s)?);
        let isp = contender.isp(&light, progress)?;
        let at = (luminance_cd_m2, &exposure);
        let SeedScores { first, raw, figures } = scene.compare_seeds(at, &*isp, seeds, score)?;
        let fixed_point = fixed_point(contender, &light, &raw, &first, score)?;
        Ok(ScoredScene { scores: first, by_seed: figures, fixed_point })
    };
    scored().in_context(|| format!("{} at {} cd/m²", contender.name(), Number(luminance_cd_m2)))
}

/// The scores of a contender on a scene at one luminance.
#[derive(Debug, Clone)]
pub struct ScoredScene {
    /// The scores for the first seed, with the picture.
    pub scores: SceneScores,
    /// The values of [`PICTURE_METRICS`] for every seed.
    pub by_seed: Vec<[f64; PICTURE_METRICS.len()]>,
    /// What fixed point costs the learned pipeline for the first seed; `None` for classic processing, and when the table has no fixed-point
    /// form for the camera.
    pub fixed_point: Option<FixedPointScore>,
}

/// The fixed-point picture of a learned pipeline beside the one in single precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedPointScore {
    /// PSNR against the picture in single precision, dB.
    pub psnr_db: f64,
    /// CPSNR of the picture in single precision less that of the fixed-point picture, both against the reference, dB.
    pub cpsnr_loss_db: f64,
}

impl ScoredScene {
    /// Means of [`PICTURE_METRICS`] over the seeds.
    #[must_use]
    pub fn means(&self) -> [f64; PICTURE_METRICS.len()] {
        let count = self.by_seed.len().max(1) as f64;
        std::array::from_fn(|metric| self.by_seed.iter().map(|f| f[metric]).sum::<f64>() / count)
    }
}

/// What fixed point costs on a raw image under a light (photons) whose picture in single precision was scored.
fn fixed_point(
    contender: &Contender<'_>,
    light: &Spectrum,
    raw: &RawImage,
    scored: &SceneScores,
    settings: &ScoreSettings,
) -> Result<Option<FixedPointScore>, CameraError> {
    let (Processing::L3, Some(pipelines)) = (contender.processing, contender.pipelines) else {
        return Ok(None);
    };
    let pipeline = pipelines.for_light(light).ok_or(L3Error::NoPipeline)?;
    let fixed = match pipeline.render_fixed(raw) {
        Ok(fixed) => Image::new(ColorSpace::Xyz, fixed.planes)?,
        // Raw images in volts, and kernels beyond 16 bits, have no fixed-point form.
        Err(L3Error::NotDigital | L3Error::NoFixedPoint(_)) => return Ok(None),
        Err(error) => return Err(error.into()),
    };
    let ratio = peak_ratio_db(scored.picture.planes(), fixed.planes()).filter(|v| v.is_finite());
    let Some(psnr_db) = ratio else { return Ok(None) };
    let cpsnr_loss_db = scored.scores.cpsnr_db - picture_cpsnr_db(&fixed, &scored.reference, settings)?;
    Ok(Some(FixedPointScore { psnr_db, cpsnr_loss_db }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{CameraDescription, compare_on};
    use crate::l3::{Axes, Class, Kernels, Levels, Origin, Pipeline, PipelineParts};
    use crate::scene::{Setting, uniform};
    use crate::sensor::{NoiseMode, Sampling, SignalNoise};
    use crate::spectrum::WavelengthGrid;

    /// A pipeline of three equal outputs for this raw image, with these weights.
    fn pipeline(raw: &RawImage, white_level: f64, weight: f32) -> Pipeline {
        let Sampling::Mosaic(mosaic) = raw.sampling() else { panic!("the default camera has a mosaic") };
        let (constant, per_signal) = (1e-6, 1e-4);
        let noise =
            SignalNoise { constant, per_signal, per_signal_squared: 0.0, row: 0.0, column: 0.0, above: None };
        let levels = Levels::logarithmic(2, 0.05, 0.8).unwrap();
        let axes = Axes::new(mosaic.clone(), 3, levels, noise).unwrap();
        let count = axes.positions() * axes.level_count() * axes.textures().count();
        let parts = PipelineParts {
            saturations: vec![0],
            outputs: ["X", "Y", "Z"].map(String::from).to_vec(),
            channel_names: raw.channel_names().to_vec(),
            black_level: raw.black_level(),
            white_level,
            trained: vec![[0.0, 1.0]; axes.positions()],
            classes: vec![Class { count: 1, origin: Origin::Learned }; count],
            kernels: Kernels {
                weights: vec![weight; count * 3 * axes.taps()],
                offsets: vec![0.0; count * 3],
            },
            provenance: String::new(),
            axes,
        };
        Pipeline::from_parts(parts).unwrap()
    }

    #[test]
    fn only_a_pipeline_without_a_fixed_point_form_has_no_score() {
        let setup_with = |adc_bits| {
            let mut description = CameraDescription::default();
            description.sensor.adc_bits = adc_bits;
            let camera = Camera::new(description, WavelengthGrid::VISIBLE).unwrap();
            Setup::new(&camera, uniform(48, 48, &Setting::default()).unwrap(), 1).unwrap()
        };
        let setup = setup_with(12);
        let isp = setup.camera.isp(&setup.light, WhiteBalance::None).unwrap();
        let scores = compare_on(&setup, &isp, 1, &ScoreSettings::default()).unwrap();
        let raw = |setup: &Setup| {
            setup.camera.sensor.capture(&setup.image, &setup.exposure, NoiseMode::All, 1).unwrap()
        };
        let score = |setup: &Setup, pipeline: &Pipeline| {
            let set = PipelineSet::of_any_light(&Illuminant::D65, &setup.camera, pipeline.clone());
            let contender = Contender::with_pipelines(&setup.camera, "a", Some(&set));
            fixed_point(&contender, &setup.light, &raw(setup), &scores, &ScoreSettings::default())
        };
        let digital = raw(&setup);
        let white = digital.white_level();
        assert!(score(&setup, &pipeline(&digital, white, 0.1)).unwrap().is_some());
        assert_eq!(score(&setup, &pipeline(&digital, white, 1e6)), Ok(None));
        let volts = setup_with(0);
        let analog = raw(&volts);
        assert_eq!(score(&volts, &pipeline(&analog, analog.white_level(), 0.1)), Ok(None));
        let other = score(&setup, &pipeline(&digital, white - 1.0, 0.1));
        assert!(matches!(other, Err(CameraError::L3(L3Error::RawLevels { .. }))), "{other:?}");
    }
}
