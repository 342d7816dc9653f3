//! `smalti compare`: cameras with their learned pipelines before the same scenes.

use anyhow::{Context, bail, ensure};
use smalti::camera::{
    Camera, CameraError, Contender, Evaluation, EvaluationSettings, LightGainSettings, LightGains,
    SceneScores, ScoreSettings, Setup, compare_on, evaluate_with, light_gains, test_scenes,
};
use smalti::isp::{Classic, Demosaic, Isp, WhiteBalance};
use smalti::l3::{Pipeline, peak_ratio_db};
use smalti::metrics::esfr::EdgeSfr;
use smalti::scene::Setting;
use smalti::sensor::NoiseMode;
use smalti::spectrum::{Illuminant, Spectrum};
use smalti_io::cache::Cache;
use smalti_io::write;

use crate::args::{Common, Compare, Processing};
use crate::compare_page;
use crate::compare_report::{self, Report};
use crate::progress::Progress;
use crate::{learn, names, resolve};

/// A camera with one way of processing.
pub(crate) struct Way<'a> {
    pub(crate) camera: &'a Camera,
    /// What the camera is called, numbered where two have one name.
    pub(crate) label: &'a str,
    pub(crate) processing: Processing,
    pub(crate) pipeline: Option<&'a Pipeline>,
}

/// What one way scores in one light.
pub(crate) struct Outcome {
    pub(crate) luminance_cd_m2: f64,
    pub(crate) targets: Evaluation,
    /// The response to the edge.
    pub(crate) edge: Option<EdgeSfr>,
    pub(crate) scenes: Vec<(String, SceneScores)>,
    /// For each scene, how far the learned pipeline's picture in fixed point is from that in single precision, dB; `None` for other
    /// processing, and where the table has no fixed-point form for the camera.
    pub(crate) fixed_point_psnr_db: Vec<Option<f64>>,
}

/// How much more light one way needs to equal another.
pub(crate) struct Gain {
    pub(crate) first: String,
    pub(crate) other: String,
    pub(crate) scenes: Vec<String>,
    pub(crate) gains: LightGains,
}

pub(crate) fn run(args: &Compare, common: &Common) -> anyhow::Result<()> {
    let illuminant = resolve::illuminant(&args.illuminant)?;
    let cameras = args
        .cameras
        .iter()
        .map(|name| resolve::camera(name, &args.camera_options, None))
        .collect::<anyhow::Result<Vec<Camera>>>()?;
    if args.processing.contains(&Processing::L3) {
        cameras.iter().try_for_each(learn::ensure_mosaic)?;
    }
    ensure!(
        !args.light_gain || cameras.len() > 1,
        "--light-gain holds cameras against each other: name two or more"
    );
    write::ensure_can_fill(&args.output)?;
    let seed = args.camera_options.seed;
    let cache = if args.no_cache { Cache::disabled() } else { Cache::open(None) };
    let (settings, training) = (args.learning.settings(seed), args.learning.training());
    let ways_each = args.processing.len();
    let gains = if args.light_gain { args.luminance.len() * (cameras.len() - 1) } else { 0 };
    let steps = cameras.len() * (1 + ways_each * args.luminance.len()) + gains;
    let progress = Progress::new(steps as u64, common.quiet);
    let labels = names::numbered(cameras.iter().map(|c| c.description().name.clone()).collect());
    let (mut ways, mut left_out) = (Vec::new(), Vec::new());
    let given = given_pipelines(args)?;
    let mut pipelines = Vec::new();
    for (number, (camera, label)) in cameras.iter().zip(&labels).enumerate() {
        progress.begin(format!("{label}: its pipeline"));
        let learned = if let Some(pipeline) = given.get(number) {
            Some(pipeline.clone())
        } else if args.processing.contains(&Processing::L3) {
            let learned = learn::learned(camera, &settings, &training, &illuminant, &cache, &progress);
            Some(learned.with_context(|| label.clone())?)
        } else {
            None
        };
        pipelines.push(learned);
        progress.done();
    }
    for ((camera, label), pipeline) in cameras.iter().zip(&labels).zip(&pipelines) {
        for (i, &processing) in args.processing.iter().enumerate() {
            let way = Way { camera, label, processing, pipeline: pipeline.as_ref() };
            if !way.is_defined() {
                progress.note(&format!("{} is left out: it is defined for Bayer mosaics", way.name()));
                left_out.push(way.name());
            } else if !args.processing[..i].contains(&processing) {
                ways.push(way);
            }
        }
    }
    ensure!(
        !ways.is_empty(),
        "nothing is left to compare: --processing names nothing that takes these mosaics"
    );
    let scenes = scenes(args);
    let mut outcomes: Vec<Vec<Outcome>> = Vec::new();
    let mut setups: Vec<Setup> = Vec::new();
    for way in &ways {
        // Forming images takes longest; cameras of one lens and pitch share them.
        setups = scenes
            .iter()
            .enumerate()
            .map(|(i, name)| match setups.get(i).map(|s| s.before(way.camera)).transpose()?.flatten() {
                Some(setup) => Ok(setup),
                None => setup(way.camera, name, args, &illuminant).with_context(|| name.clone()),
            })
            .collect::<anyhow::Result<_>>()?;
        outcomes.push(outcomes_of(way, args, &scenes, &setups, &illuminant, &cache, &progress)?);
    }
    let gains = if args.light_gain {
        light_gains_of(&ways, args, &scenes, &illuminant, &progress)?
    } else {
        Vec::new()
    };
    let report = Report {
        args,
        cameras: &cameras,
        labels: &labels,
        ways: &ways,
        left_out: &left_out,
        outcomes: &outcomes,
        gains: &gains,
    };
    let text = serde_json::to_string_pretty(&report.document()?)? + "\n";
    progress.begin("writing");
    report.write(&text)?;
    progress.finish();
    if args.json {
        return crate::print(&text);
    }
    let over =
        if scenes.len() == 1 { "of one scene".into() } else { format!("means over {} scenes", scenes.len()) };
    crate::print(&format!(
        "{}{}{}\n{over}; to look at: {}; figures in {}\n",
        report.scores_table(),
        report.fixed_point_line(),
        report.gains_table(),
        args.output.join(compare_page::FILE).display(),
        args.output.join(compare_report::RESULTS).display(),
    ))
}

/// Tables that are used as they are, one for each camera; none when all are to be learned.
fn given_pipelines(args: &Compare) -> anyhow::Result<Vec<Pipeline>> {
    let (given, cameras) = (args.pipelines.len(), args.cameras.len());
    if given != 0 && given != cameras {
        bail!("--pipeline: {given} given for {cameras} cameras; expected one for each, in their order");
    }
    args.pipelines
        .iter()
        .map(|file| {
            let pipeline = smalti_io::l3::read_table(file)?;
            if pipeline.outputs() != ["X", "Y", "Z"] {
                bail!("{}: gives {}, expected X, Y, Z", file.display(), pipeline.outputs().join(", "));
            }
            Ok(pipeline)
        })
        .collect()
}

/// The scenes to compare on: those asked for, else the built-in ones, which nothing is trained on.
fn scenes(args: &Compare) -> Vec<String> {
    match args.scenes.is_empty() {
        true => test_scenes().iter().map(|s| (*s).to_owned()).collect(),
        // A name alone is the scene of that name among the built-in ones to compare on: those of the catalogue are smaller.
        false => args.scenes.iter().map(|name| of_test_set(name).unwrap_or(name).to_owned()).collect(),
    }
}

fn of_test_set(name: &str) -> Option<&'static str> {
    test_scenes().iter().copied().find(|s| s.split('?').next() == Some(name.trim()))
}

impl Way<'_> {
    pub(crate) fn name(&self) -> String {
        format!("{} {}", self.label, self.processing.name())
    }

    /// Whether the processing is one for the camera's mosaic.
    fn is_defined(&self) -> bool {
        match self.processing {
            Processing::L3 | Processing::Bilinear => true,
            Processing::Malvar2004 | Processing::Adaptive => {
                self.camera.sensor.cfa.mosaic().bayer_phase().is_some()
            }
        }
    }

    /// The processing for scenes under a light.
    fn isp<'a>(&'a self, light: &Spectrum) -> Result<Box<dyn Isp + 'a>, CameraError> {
        let demosaic = match (self.processing, self.pipeline) {
            (Processing::L3, Some(pipeline)) => return Ok(Box::new(pipeline)),
            (Processing::Malvar2004, _) => Demosaic::Malvar2004,
            (Processing::Adaptive, _) => Demosaic::Adaptive,
            (Processing::L3 | Processing::Bilinear, _) => Demosaic::Bilinear,
        };
        Ok(Box::new(Classic { demosaic, ..self.camera.isp(light, WhiteBalance::None)? }))
    }

    /// How far the picture of a scene in fixed point is from the one that was scored.
    fn fixed_point_psnr_db(
        &self,
        setup: &Setup,
        scored: &SceneScores,
        seed: u64,
    ) -> Result<Option<f64>, CameraError> {
        let (Processing::L3, Some(pipeline)) = (self.processing, self.pipeline) else { return Ok(None) };
        let raw = setup.camera.sensor.capture(&setup.image, &setup.exposure, NoiseMode::All, seed)?;
        // Volts, and kernels beyond 16 bits, have no fixed point.
        let fixed = pipeline.render_fixed(&raw).ok();
        Ok(fixed.and_then(|f| peak_ratio_db(scored.picture.planes(), &f.planes)).filter(|v| v.is_finite()))
    }
}

/// A scene before a camera, at the mean luminance of 1 cd/m².
fn setup(camera: &Camera, name: &str, args: &Compare, illuminant: &Illuminant) -> anyhow::Result<Setup> {
    if !resolve::is_file(name) {
        let setting = Setting { luminance_cd_m2: 1.0, illuminant: illuminant.clone(), ..Setting::default() };
        return Ok(Setup::of_test_scene(camera, name, &setting)?);
    }
    let options = crate::scene_args::SceneOptions {
        luminance: Some(1.0),
        illuminant: Some(args.illuminant.clone()),
        ..Default::default()
    };
    Ok(Setup::new(camera, resolve::scene_for(name, &options, camera)?, 1)?)
}

fn outcomes_of(
    way: &Way<'_>,
    args: &Compare,
    scenes: &[String],
    setups: &[Setup],
    illuminant: &Illuminant,
    cache: &Cache,
    progress: &Progress,
) -> anyhow::Result<Vec<Outcome>> {
    let seed = args.camera_options.seed;
    let mut outcomes = Vec::new();
    for &luminance_cd_m2 in &args.luminance {
        progress.begin(format!("{} at {luminance_cd_m2} cd/m²", way.name()));
        let context = || format!("{} at {luminance_cd_m2} cd/m²", way.name());
        let settings = EvaluationSettings { luminance_cd_m2, illuminant: illuminant.clone(), seed };
        let images = |key: &str, make: &dyn Fn() -> Result<_, CameraError>| cache.optical_image(key, make);
        let (targets, pictures) = evaluate_with(way.camera, &settings, &images, &|light| way.isp(light))
            .with_context(|| {
                let exposed = way.camera.description().exposure.time_ms.is_some();
                let hint = if exposed {
                    ": the camera's exposure is fixed; the scenes may be too bright or too dark for it"
                } else {
                    ""
                };
                format!("{}{hint}", context())
            })?;
        let (mut scored, mut fixed_point) = (Vec::new(), Vec::new());
        for (name, setup) in scenes.iter().zip(setups) {
            let lit = setup.in_light(luminance_cd_m2)?.exposed()?;
            let isp = way.isp(&lit.light)?;
            let scores = compare_on(&lit, &*isp, seed, &ScoreSettings::default());
            let scores = scores.with_context(|| format!("{}, {name}", context()))?;
            fixed_point.push(way.fixed_point_psnr_db(&lit, &scores, seed)?);
            scored.push((name.clone(), scores));
        }
        outcomes.push(Outcome {
            luminance_cd_m2,
            targets,
            edge: pictures.edge_sfr().ok(),
            scenes: scored,
            fixed_point_psnr_db: fixed_point,
        });
        progress.done();
    }
    Ok(outcomes)
}

/// How much more light the first way needs to equal each of the others that process alike.
fn light_gains_of(
    ways: &[Way<'_>],
    args: &Compare,
    scenes: &[String],
    illuminant: &Illuminant,
    progress: &Progress,
) -> anyhow::Result<Vec<Gain>> {
    let mut gains = Vec::new();
    // Each is taken some twenty times: two are enough. Files have no name that builds them again; the default stands in.
    let built_in: Vec<String> = scenes.iter().filter(|s| !resolve::is_file(s)).take(2).cloned().collect();
    let of = if built_in.is_empty() { LightGainSettings::default().scenes } else { built_in };
    if !args.scenes.is_empty() && of != scenes {
        progress.note(&format!("light gains are those of {}", of.join(" and ")));
    }
    let Some(first) = ways.first() else { return Ok(gains) };
    let others = ways.iter().filter(|w| w.processing == first.processing).skip(1);
    for other in others {
        for &luminance_cd_m2 in &args.luminance {
            progress.begin(format!("light gain of {} at {luminance_cd_m2} cd/m²", other.name()));
            let settings = LightGainSettings {
                luminance_cd_m2,
                illuminant: illuminant.clone(),
                seed: args.camera_options.seed,
                scenes: of.clone(),
                score: ScoreSettings::default(),
            };
            let (a, b) = (|light: &Spectrum| first.isp(light), |light: &Spectrum| other.isp(light));
            let found = light_gains(
                Contender { camera: first.camera, isp: &a },
                Contender { camera: other.camera, isp: &b },
                &settings,
            );
            let found = found.with_context(|| format!("light gain at {luminance_cd_m2} cd/m²"))?;
            gains.push(Gain { first: first.name(), other: other.name(), scenes: of.clone(), gains: found });
            progress.done();
        }
    }
    Ok(gains)
}
