//! Comparisons of cameras, each with its processing, on the same scenes.

use super::error::StageContext;
use super::learning::learn_default;
use super::progress::{Stoppable, ensure_running};
use super::training_statistics::ensure_mosaic;
use super::{
    ComparedPictures, ExperimentError, ExposurePlan, ExposurePolicy, Processing, Progress, Resources,
};
use crate::camera::{
    Camera, CameraAndIsp, CameraError, Evaluation, EvaluationPictures, EvaluationSettings, LightGainSettings,
    LightGains, SceneScores, ScoreSettings, Setup, TestScene, TrainingSettings, compare_on, evaluate_with,
    light_gains,
};
use crate::isp::{Classic, Isp, WhiteBalance};
use crate::l3::{L3Error, Pipeline, Training, peak_ratio_db};
use crate::metrics::esfr::EdgeSfr;
use crate::sensor::NoiseMode;
use crate::spectrum::{Illuminant, Spectrum};

/// A camera with its processing.
#[derive(Clone, Copy)]
pub struct Contender<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The unique name of the camera in results.
    pub label: &'a str,
    /// Its processing.
    pub processing: Processing,
    /// The learned pipeline for [`Processing::L3`].
    pub pipeline: Option<&'a Pipeline>,
}

/// Settings of a comparison.
#[derive(Debug, Clone)]
pub struct ComparisonSettings {
    /// Mean luminances of the scenes, cd/m².
    pub luminances_cd_m2: Vec<f64>,
    /// Their illuminant.
    pub illuminant: Illuminant,
    /// The scenes.
    pub scenes: Vec<TestScene>,
    /// Seed of the noise.
    pub seed: u64,
    /// Viewing conditions of the scores.
    pub score: ScoreSettings,
    /// The choice of the exposure times.
    pub exposure: ExposurePolicy,
}

/// The results of a comparison.
pub struct Compared {
    /// For each contender an outcome per luminance.
    pub outcomes: Vec<Vec<Outcome>>,
    /// The exposure times.
    pub exposure: ExposurePlan,
}

/// The scores of a contender at one luminance.
pub struct Outcome {
    /// Mean luminance of the scenes, cd/m².
    pub luminance_cd_m2: f64,
    /// The scores on the targets of [`evaluate`](crate::camera::evaluate()).
    pub targets: Evaluation,
    /// The edge response; `None` when the picture shows no edge.
    pub edge: Option<EdgeSfr>,
    /// The scores on each scene, with its name.
    pub scenes: Vec<(String, SceneScores)>,
    /// For each scene, the PSNR of the fixed-point picture of the learned pipeline against single precision, dB; `None` for classic
    /// processing, and when the table has no fixed-point form for the camera.
    pub fixed_point_psnr_db: Vec<Option<f64>>,
}

impl<'a> Contender<'a> {
    /// A camera with the processing of its description.
    #[must_use]
    pub fn as_described(camera: &'a Camera, label: &'a str) -> Self {
        let processing = Processing::Classic(camera.description().isp.demosaic);
        Self { camera, label, processing, pipeline: None }
    }

    /// A camera with a learned pipeline if there is one, otherwise with the processing of its description.
    #[must_use]
    pub fn with_pipeline(camera: &'a Camera, label: &'a str, pipeline: Option<&'a Pipeline>) -> Self {
        let own = Self::as_described(camera, label);
        if pipeline.is_some() { Self { processing: Processing::L3, pipeline, ..own } } else { own }
    }

    /// The camera's label and the name of the processing.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} {}", self.label, self.processing.name())
    }

    /// Whether the processing is defined for the camera's mosaic.
    #[must_use]
    pub fn is_defined(&self) -> bool {
        self.processing.is_defined_for(self.camera.sensor.cfa.mosaic())
    }

    /// The processing for scenes under an illuminant (photons). It fails once the caller stops the work.
    fn isp<'b>(&self, light: &Spectrum, progress: &'b dyn Progress) -> Result<Box<dyn Isp + 'b>, CameraError>
    where
        'a: 'b,
    {
        let isp: Box<dyn Isp + 'b> = match (self.processing, self.pipeline) {
            (Processing::L3, Some(pipeline)) => {
                pipeline.ensure_renders(&self.camera.sensor.cfa)?;
                Box::new(pipeline)
            }
            (Processing::L3, None) => return Err(crate::l3::L3Error::NoPipeline.into()),
            (Processing::Classic(demosaic), _) => {
                let camera = self.camera.on_grid(light.grid())?;
                Box::new(Classic { demosaic, ..camera.isp(light, WhiteBalance::None)? })
            }
        };
        Ok(Box::new(Stoppable { isp, progress }))
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
        let images =
            |key: &str, make: &dyn Fn() -> Result<_, CameraError>| resources.store.optical_image(key, make);
        let isp = |light: &Spectrum| self.isp(light, resources.progress);
        evaluate_with(self.camera, settings, &images, &isp).map_err(|e| {
            let fixed = self.camera.description().exposure.time_ms.is_some();
            let hint = match &e {
                CameraError::Metric(_) if fixed => {
                    ": the camera's exposure is fixed; the scenes may be too bright or too dark for it"
                }
                _ => "",
            };
            ExperimentError::stage(format!("{} at {} cd/m²{hint}", self.label, settings.luminance_cd_m2), e)
        })
    }
}

/// The pipeline of each camera of a comparison: the given one; or one learned under the illuminant, if [`Processing::L3`] is
/// compared; or none. Each is one step of progress. `labels` are the unique names of the cameras in progress and errors.
///
/// # Errors
/// As [`learn_default`], with the label of the camera.
pub fn pipelines(
    cameras: &[Camera],
    labels: &[String],
    given: Vec<Option<Pipeline>>,
    processing: &[Processing],
    learning: (&TrainingSettings, &Training),
    illuminant: &Illuminant,
    resources: Resources<'_>,
) -> Result<Vec<Option<Pipeline>>, ExperimentError> {
    let learns = processing.contains(&Processing::L3);
    let labelled = || cameras.iter().zip(labels);
    if learns {
        labelled().try_for_each(|(camera, label)| ensure_mosaic(camera, label))?;
    }
    resources.progress.expect(cameras.len() as u64);
    let mut given = given.into_iter();
    let own = |(camera, label): (&Camera, &String)| {
        resources.progress.begin(&format!("{label}: pipeline"));
        let pipeline = match given.next().flatten() {
            None if learns => {
                let learned = learn_default(camera, label, learning, illuminant, resources);
                Some(learned.map_err(|e| e.of_camera(label))?)
            }
            given => given,
        };
        resources.progress.done();
        Ok(pipeline)
    };
    labelled().map(own).collect()
}

/// Every camera with every kind of processing, each once, and the names of those that are left out because the processing is not
/// defined for the mosaic.
///
/// # Errors
/// [`ExperimentError::NothingToCompare`].
pub fn contenders<'a>(
    cameras: &'a [Camera],
    labels: &'a [String],
    pipelines: &'a [Option<Pipeline>],
    processing: &[Processing],
) -> Result<(Vec<Contender<'a>>, Vec<String>), ExperimentError> {
    let (mut defined, mut left_out) = (Vec::new(), Vec::new());
    for ((camera, label), pipeline) in cameras.iter().zip(labels).zip(pipelines) {
        let unique = |(i, kind): &(usize, &Processing)| !processing[..*i].contains(kind);
        for (_, &kind) in processing.iter().enumerate().filter(unique) {
            let contender = Contender { camera, label, processing: kind, pipeline: pipeline.as_ref() };
            if contender.is_defined() { defined.push(contender) } else { left_out.push(contender.name()) }
        }
    }
    if defined.is_empty() { Err(ExperimentError::NothingToCompare) } else { Ok((defined, left_out)) }
}

/// Captures a scene at a mean luminance, renders the raw image and scores the picture. `setup` is the scene at 1 cd/m². The exposure
/// time is `time_s`, s, or that of the camera's description.
///
/// # Errors
/// When a stage fails, the scene is dark, or the work is stopped.
pub fn score_scene(
    contender: &Contender<'_>,
    setup: &Setup,
    (luminance_cd_m2, time_s): (f64, Option<f64>),
    seed: u64,
    score: &ScoreSettings,
    progress: &dyn Progress,
) -> Result<(SceneScores, Option<f64>), ExperimentError> {
    ensure_running(progress)?;
    let scored = || -> Result<_, CameraError> {
        let lit = setup.in_light(luminance_cd_m2)?.exposed(time_s)?;
        let isp = contender.isp(&lit.light, progress)?;
        let scores = compare_on(&lit, &*isp, seed, score)?;
        let fixed_point_db = fixed_point_psnr_db(contender, &lit, &scores, seed)?;
        Ok((scores, fixed_point_db))
    };
    scored().in_context(|| format!("{} at {luminance_cd_m2} cd/m²", contender.name()))
}

/// PSNR of the fixed-point picture of a scene against the picture that was scored, dB.
fn fixed_point_psnr_db(
    contender: &Contender<'_>,
    setup: &Setup,
    scored: &SceneScores,
    seed: u64,
) -> Result<Option<f64>, CameraError> {
    let (Processing::L3, Some(pipeline)) = (contender.processing, contender.pipeline) else {
        return Ok(None);
    };
    let raw = setup.camera.sensor.capture(&setup.image, &setup.exposure, NoiseMode::All, seed)?;
    let fixed = match pipeline.render_fixed(&raw) {
        Ok(fixed) => fixed,
        // Raw images in volts, and kernels beyond 16 bits, have no fixed-point form.
        Err(L3Error::NotDigital | L3Error::NoFixedPoint(_)) => return Ok(None),
        Err(error) => return Err(error.into()),
    };
    Ok(peak_ratio_db(scored.picture.planes(), &fixed.planes).filter(|v| v.is_finite()))
}

/// Compares contenders on scenes. The result holds an outcome for each contender and luminance; each is one step of progress.
/// Cameras with the same lens and pixel pitch share the optical images.
///
/// # Errors
/// When a contender lacks its pipeline, a stage fails, or the work is stopped.
pub fn compare(
    contenders: &[Contender<'_>],
    settings: &ComparisonSettings,
    resources: Resources<'_>,
) -> Result<Compared, ExperimentError> {
    resources.progress.expect((contenders.len() * settings.luminances_cd_m2.len()) as u64);
    let cameras: Vec<(&str, &Camera)> = contenders.iter().map(|c| (c.label, c.camera)).collect();
    // The first camera's images serve the exposure times as well.
    let mut setups = contenders.first().map_or(Ok(Vec::new()), |c| imaged(c, settings, &[], resources))?;
    let pictures = ComparedPictures {
        scenes: &settings.scenes,
        luminances_cd_m2: &settings.luminances_cd_m2,
        illuminant: &settings.illuminant,
        setups: &setups,
    };
    let exposure = ExposurePlan::new(settings.exposure, &cameras, pictures, resources)?;
    let mut outcomes = Vec::with_capacity(contenders.len());
    for (i, contender) in contenders.iter().enumerate() {
        if contender.processing == Processing::L3 && contender.pipeline.is_none() {
            return Err(ExperimentError::NoPipeline { camera: contender.label.to_owned() });
        }
        if i > 0 {
            setups = imaged(contender, settings, &setups, resources)?;
        }
        let at = |light: usize| outcome(contender, light, &setups, settings, &exposure, resources);
        outcomes.push((0..settings.luminances_cd_m2.len()).map(at).collect::<Result<_, _>>()?);
    }
    Ok(Compared { outcomes, exposure })
}

/// The scenes on the camera of a contender, with the optical images of another camera where possible.
fn imaged(
    contender: &Contender<'_>,
    settings: &ComparisonSettings,
    others: &[Setup],
    resources: Resources<'_>,
) -> Result<Vec<Setup>, ExperimentError> {
    let on_camera = |(i, scene): (usize, &TestScene)| {
        ensure_running(resources.progress)?;
        let setup = scene.before_sharing(contender.camera, &settings.illuminant, others.get(i));
        setup.in_context(|| scene.name().to_owned())
    };
    settings.scenes.iter().enumerate().map(on_camera).collect()
}

fn outcome(
    contender: &Contender<'_>,
    light: usize,
    setups: &[Setup],
    settings: &ComparisonSettings,
    exposure: &ExposurePlan,
    resources: Resources<'_>,
) -> Result<Outcome, ExperimentError> {
    let (progress, luminance_cd_m2) = (resources.progress, settings.luminances_cd_m2[light]);
    progress.begin(&format!("{} at {luminance_cd_m2} cd/m²", contender.name()));
    let illuminant = settings.illuminant.clone();
    let targets = EvaluationSettings {
        luminance_cd_m2,
        illuminant,
        seed: settings.seed,
        exposure: exposure.targets(light),
    };
    let (targets, pictures) = contender.evaluate(&targets, resources)?;
    let (mut scenes, mut fixed_point) = (Vec::new(), Vec::new());
    for (i, (scene, setup)) in settings.scenes.iter().zip(setups).enumerate() {
        let light = (luminance_cd_m2, exposure.scene_s(i, light));
        let scored = score_scene(contender, setup, light, settings.seed, &settings.score, progress);
        let (scores, fixed_point_db) = scored.map_err(|e| match e {
            ExperimentError::Stage { context, source } => {
                ExperimentError::Stage { context: format!("{context}, {}", scene.name()), source }
            }
            other => other,
        })?;
        fixed_point.push(fixed_point_db);
        scenes.push((scene.name().to_owned(), scores));
    }
    progress.done();
    Ok(Outcome {
        luminance_cd_m2,
        targets,
        edge: pictures.edge_sfr().in_context(|| contender.name())?,
        scenes,
        fixed_point_psnr_db: fixed_point,
    })
}

/// The light gain of a pair of contenders.
pub struct PairwiseLightGain {
    /// The contender whose light changes.
    pub first: String,
    /// The contender that it is to equal.
    pub other: String,
    /// The gains by each metric.
    pub gains: LightGains,
}

/// How much more light contender `a` needs to equal contender `b`, by every metric.
///
/// # Errors
/// When a stage fails, or the work is stopped.
pub fn light_gain_between(
    a: &Contender<'_>,
    b: &Contender<'_>,
    settings: &LightGainSettings,
    progress: &dyn Progress,
) -> Result<LightGains, ExperimentError> {
    let isp_a = |light: &Spectrum| a.isp(light, progress);
    let isp_b = |light: &Spectrum| b.isp(light, progress);
    let (a, b) =
        (CameraAndIsp { camera: a.camera, isp: &isp_a }, CameraAndIsp { camera: b.camera, isp: &isp_b });
    light_gains(a, b, settings).in_context(|| format!("light gain at {} cd/m²", settings.luminance_cd_m2))
}

/// The light gains of the first contender against every other contender with the same processing, at each luminance. Each is one
/// step of progress. Scenes and exposure times are those of the comparison.
///
/// # Errors
/// When a stage fails, or the work is stopped.
pub fn light_gains_to_first(
    contenders: &[Contender<'_>],
    settings: &ComparisonSettings,
    exposure: &ExposurePlan,
    progress: &dyn Progress,
) -> Result<Vec<PairwiseLightGain>, ExperimentError> {
    let Some((first, rest)) = contenders.split_first() else { return Ok(Vec::new()) };
    let mut gains = Vec::new();
    for other in rest.iter().filter(|c| c.processing == first.processing) {
        for (light, &luminance_cd_m2) in settings.luminances_cd_m2.iter().enumerate() {
            progress.begin(&format!("light gain of {} at {luminance_cd_m2} cd/m²", other.name()));
            let settings = LightGainSettings {
                luminance_cd_m2,
                illuminant: settings.illuminant.clone(),
                seed: settings.seed,
                scenes: settings.scenes.clone(),
                times_s: (0..settings.scenes.len()).map(|scene| exposure.scene_s(scene, light)).collect(),
                chart_s: exposure.targets(light).map(|t| t.macbeth_s),
                score: settings.score,
            };
            let found = light_gain_between(first, other, &settings, progress)?;
            gains.push(PairwiseLightGain { first: first.name(), other: other.name(), gains: found });
            progress.done();
        }
    }
    Ok(gains)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::CameraDescription;
    use crate::l3::{Axes, Class, Kernels, Levels, Origin, PipelineParts};
    use crate::scene::{Setting, uniform};
    use crate::sensor::{RawImage, Sampling, SignalNoise};
    use crate::spectrum::WavelengthGrid;

    /// A pipeline of three equal outputs for this raw image, with these weights.
    fn pipeline(raw: &RawImage, white_level: f64, weight: f32) -> Pipeline {
        let Sampling::Mosaic(mosaic) = raw.sampling() else { panic!("the default camera has a mosaic") };
        let (constant, per_signal) = (1e-6, 1e-4);
        let noise = SignalNoise { constant, per_signal, per_signal_squared: 0.0, row: 0.0, column: 0.0 };
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
    fn only_a_pipeline_without_a_fixed_point_form_has_no_ratio() {
        let setup_with = |adc_bits| {
            let mut description = CameraDescription::default();
            description.sensor.adc_bits = adc_bits;
            let camera = Camera::new(description, WavelengthGrid::VISIBLE).unwrap();
            Setup::new(&camera, uniform(48, 48, &Setting::default()).unwrap(), 1).unwrap()
        };
        let setup = setup_with(12);
        let isp = setup.camera.isp(&setup.light, WhiteBalance::None).unwrap();
        let scores = compare_on(&setup, &isp, 1, &ScoreSettings::default()).unwrap();
        let ratio = |setup: &Setup, pipeline: &Pipeline| {
            let contender = Contender::with_pipeline(&setup.camera, "a", Some(pipeline));
            fixed_point_psnr_db(&contender, setup, &scores, 1)
        };
        let raw = |setup: &Setup| {
            setup.camera.sensor.capture(&setup.image, &setup.exposure, NoiseMode::All, 1).unwrap()
        };
        let digital = raw(&setup);
        let white = digital.white_level();
        assert!(ratio(&setup, &pipeline(&digital, white, 0.1)).unwrap().is_some());
        assert_eq!(ratio(&setup, &pipeline(&digital, white, 1e6)), Ok(None));
        let volts = setup_with(0);
        let analog = raw(&volts);
        assert_eq!(ratio(&volts, &pipeline(&analog, analog.white_level(), 0.1)), Ok(None));
        let other = ratio(&setup, &pipeline(&digital, white - 1.0, 0.1));
        assert!(matches!(other, Err(CameraError::L3(L3Error::RawLevels { .. }))), "{other:?}");
    }
}
