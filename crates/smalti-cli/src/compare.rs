//! `smalti compare`: cameras with their learned pipelines before the same scenes.

use std::path::Path;

use anyhow::{Context, bail};
use serde_json::{Value, json};
use smalti::camera::{
    Camera, CameraError, Contender, Evaluation, EvaluationSettings, LightGainSettings, LightGains,
    SceneScores, ScoreSettings, Setup, compare_on, evaluate_with, light_gains, test_scenes,
};
use smalti::color::Image;
use smalti::isp::{Classic, Demosaic, Isp, WhiteBalance};
use smalti::l3::Pipeline;
use smalti::scene::Setting;
use smalti::spectrum::{Illuminant, Observer, Spectrum};
use smalti_io::cache::Cache;
use smalti_io::picture::{self, Depth};
use smalti_io::{l3, write};

use crate::args::{Common, Compare, Processing};
use crate::evaluate::{cached, folder_name};
use crate::learn;
use crate::pictures::{dark_and_bright, kernels, shown, side_by_side};
use crate::progress::Progress;
use crate::{resolve, table};

/// A camera with one way of processing.
struct Way<'a> {
    camera: &'a Camera,
    processing: Processing,
    pipeline: Option<&'a Pipeline>,
}

/// What one way scores in one light.
struct Outcome {
    luminance_cd_m2: f64,
    targets: Evaluation,
    scenes: Vec<(String, SceneScores)>,
}

pub(crate) fn run(args: &Compare, common: &Common) -> anyhow::Result<()> {
    let illuminant = resolve::illuminant(&args.illuminant)?;
    let cameras = args
        .cameras
        .iter()
        .map(|name| resolve::camera(name, &args.camera_options, None))
        .collect::<anyhow::Result<Vec<Camera>>>()?;
    let seed = args.camera_options.seed;
    let cache = if args.no_cache { Cache::disabled() } else { Cache::open(None) };
    let (settings, training) = (args.learning.settings(seed), args.learning.training());
    let ways_each = args.processing.len();
    let gains = if args.light_gain { args.luminance.len() * (cameras.len() - 1) } else { 0 };
    let steps = cameras.len() * (1 + ways_each * args.luminance.len()) + gains;
    let progress = Progress::new(steps as u64, common.quiet);
    let given = given_pipelines(args)?;
    let mut pipelines = Vec::new();
    for (number, camera) in cameras.iter().enumerate() {
        let name = &camera.description().name;
        progress.begin(format!("{name}: its pipeline"));
        let learned = if let Some(pipeline) = given.get(number) {
            Some(pipeline.clone())
        } else if args.processing.contains(&Processing::L3) {
            let learned = learn::learned(camera, &settings, &training, &illuminant, &cache, &progress);
            Some(learned.with_context(|| name.clone())?)
        } else {
            None
        };
        pipelines.push(learned);
        progress.done();
    }
    let ways: Vec<Way<'_>> = cameras
        .iter()
        .zip(&pipelines)
        .flat_map(|(camera, pipeline)| {
            let way = move |&processing: &Processing| Way { camera, processing, pipeline: pipeline.as_ref() };
            args.processing.iter().map(way).filter(Way::is_defined)
        })
        .collect();
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
    let document = document(args, &ways, &outcomes, &gains)?;
    let text = serde_json::to_string_pretty(&document)? + "\n";
    progress.begin("writing");
    write_all(args, &ways, &outcomes, &text)?;
    progress.finish();
    if args.json {
        return crate::print(&text);
    }
    let pictures = args.output.join("side-by-side");
    crate::print(&format!(
        "{}{}\nmeans over {} scenes; pictures in {}, figures in {}\n",
        scores_table(&ways, &outcomes),
        gains_table(&gains),
        scenes.len(),
        pictures.display(),
        args.output.join("results.json").display(),
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
            let pipeline = l3::read_table(file)?;
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
        false => args.scenes.clone(),
    }
}

impl Way<'_> {
    fn name(&self) -> String {
        format!("{} {}", self.camera.description().name, self.processing.name())
    }

    /// Whether the processing is one for the camera's mosaic; said if not.
    fn is_defined(&self) -> bool {
        let defined = match self.processing {
            Processing::L3 | Processing::Bilinear => true,
            Processing::Malvar2004 | Processing::Adaptive => {
                self.camera.sensor.cfa.mosaic().bayer_phase().is_some()
            }
        };
        if !defined {
            eprintln!("note: {} is left out: it is defined for Bayer mosaics", self.name());
        }
        defined
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
}

/// A scene before a camera, at the mean luminance of 1 cd/m².
fn setup(camera: &Camera, name: &str, args: &Compare, illuminant: &Illuminant) -> anyhow::Result<Setup> {
    if !resolve::is_file(name) {
        let setting = Setting { luminance_cd_m2: 1.0, illuminant: illuminant.clone(), ..Setting::default() };
        return Ok(Setup::of_test_scene(camera, name, &setting)?);
    }
    let options = crate::args::SceneOptions {
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
        let images = |key: &str, make: &dyn Fn() -> Result<_, CameraError>| cached(cache, key, make);
        let (targets, _) =
            evaluate_with(way.camera, &settings, &images, &|light| way.isp(light)).with_context(context)?;
        let mut scored = Vec::new();
        for (name, setup) in scenes.iter().zip(setups) {
            let lit = setup.in_light(luminance_cd_m2)?.exposed()?;
            let isp = way.isp(&lit.light)?;
            let scores = compare_on(&lit, &*isp, seed, &ScoreSettings::default());
            scored.push((name.clone(), scores.with_context(|| format!("{}, {name}", context()))?));
        }
        outcomes.push(Outcome { luminance_cd_m2, targets, scenes: scored });
        progress.done();
    }
    Ok(outcomes)
}

/// How much more light the first way needs to equal each of the others.
fn light_gains_of(
    ways: &[Way<'_>],
    args: &Compare,
    scenes: &[String],
    illuminant: &Illuminant,
    progress: &Progress,
) -> anyhow::Result<Vec<(String, String, LightGains)>> {
    let mut gains = Vec::new();
    let Some(first) = ways.first() else { return Ok(gains) };
    let others = ways.iter().filter(|w| w.processing == first.processing).skip(1);
    for other in others {
        for &luminance_cd_m2 in &args.luminance {
            progress.begin(format!("light gain of {} at {luminance_cd_m2} cd/m²", other.name()));
            let built_in = scenes.iter().filter(|s| !resolve::is_file(s)).take(2).cloned();
            let settings = LightGainSettings {
                luminance_cd_m2,
                illuminant: illuminant.clone(),
                seed: args.camera_options.seed,
                scenes: built_in.collect(),
                score: ScoreSettings::default(),
            };
            let (a, b) = (|light: &Spectrum| first.isp(light), |light: &Spectrum| other.isp(light));
            let found = light_gains(
                Contender { camera: first.camera, isp: &a },
                Contender { camera: other.camera, isp: &b },
                &settings,
            )?;
            gains.push((first.name(), other.name(), found));
            progress.done();
        }
    }
    Ok(gains)
}

/// The mean of a score over the scenes.
fn mean(outcome: &Outcome, of: impl Fn(&SceneScores) -> f64) -> f64 {
    outcome.scenes.iter().map(|(_, s)| of(s)).sum::<f64>() / outcome.scenes.len().max(1) as f64
}

fn scores_table(ways: &[Way<'_>], outcomes: &[Vec<Outcome>]) -> String {
    let header = [
        "camera",
        "pipeline",
        "cd/m²",
        "CPSNR dB",
        "ΔE2000",
        "S-CIELAB",
        "MTF50 cy/mm",
        "visual SNR",
        "noise %",
    ];
    let mut rows = Vec::new();
    let lights = outcomes.first().map_or(0, Vec::len);
    for light in 0..lights {
        for (way, outcomes) in ways.iter().zip(outcomes) {
            let o = &outcomes[light];
            rows.push(vec![
                way.camera.description().name.clone(),
                way.processing.name().to_owned(),
                o.luminance_cd_m2.to_string(),
                format!("{:.2}", mean(o, |s| s.scores.cpsnr_db)),
                format!("{:.2}", mean(o, |s| s.scores.pixel_delta_e_2000_mean)),
                format!("{:.2}", mean(o, |s| s.scores.scielab_mean)),
                format!("{:.1}", o.targets.mtf50_cy_per_mm),
                format!("{:.3}", o.targets.visual_snr.median),
                format!("{:.1}", o.targets.luminance_noise_percent.mean),
            ]);
        }
    }
    table::render(&header, &rows)
}

fn gains_table(gains: &[(String, String, LightGains)]) -> String {
    let mut out = String::new();
    for (first, other, gains) in gains {
        let header = ["metric", first.as_str(), other.as_str(), "light gain"];
        let row = |g: &smalti::camera::MetricGain| {
            vec![g.metric.to_owned(), format!("{:.3}", g.own), format!("{:.3}", g.target), g.gain.to_string()]
        };
        let rows: Vec<Vec<String>> = gains.metrics.iter().map(row).collect();
        out += &format!(
            "\nmore light that {first} needs to equal {other} at {} cd/m²\n{}",
            gains.luminance_cd_m2,
            table::render(&header, &rows)
        );
    }
    out
}

fn document(
    args: &Compare,
    ways: &[Way<'_>],
    outcomes: &[Vec<Outcome>],
    gains: &[(String, String, LightGains)],
) -> anyhow::Result<Value> {
    let mut entries = Vec::new();
    for (way, outcomes) in ways.iter().zip(outcomes) {
        for o in outcomes {
            let scenes: Vec<Value> = o
                .scenes
                .iter()
                .map(|(name, s)| Ok(json!({"scene": name, "scores": serde_json::to_value(s)?})))
                .collect::<anyhow::Result<_>>()?;
            entries.push(json!({
                "camera": way.camera.description().name,
                "pipeline": way.processing.name(),
                "luminance_cd_m2": o.luminance_cd_m2,
                "cpsnr_db": mean(o, |s| s.scores.cpsnr_db),
                "pixel_delta_e_2000_mean": mean(o, |s| s.scores.pixel_delta_e_2000_mean),
                "scielab_mean": mean(o, |s| s.scores.scielab_mean),
                "targets": serde_json::to_value(&o.targets)?,
                "scenes": scenes,
            }));
        }
    }
    let learned =
        ways.iter().filter_map(|w| Some((w, w.pipeline?))).filter(|(w, _)| w.processing == Processing::L3);
    Ok(json!({
        "smalti_version": env!("CARGO_PKG_VERSION"),
        "illuminant": args.illuminant,
        "seed": args.camera_options.seed,
        "results": entries,
        "light_gains": gains.iter().map(|(a, b, g)| Ok(json!({
            "needs_more_light": a, "to_equal": b, "gains": serde_json::to_value(g)?,
        }))).collect::<anyhow::Result<Vec<Value>>>()?,
        "learned": learned.map(|(w, p)| kernels_as_json(w.camera, p)).collect::<Vec<_>>(),
        "cameras": ways.iter().filter(|w| w.processing == args.processing[0])
            .map(|w| serde_json::to_value(w.camera.description())).collect::<Result<Vec<_>, _>>()?,
    }))
}

/// The classes of a pipeline in numbers, and the kernels that are drawn.
fn kernels_as_json(camera: &Camera, pipeline: &Pipeline) -> Value {
    let summary = pipeline.summary();
    let drawn: Vec<Value> = dark_and_bright(pipeline)
        .into_iter()
        .map(|class| {
            let key = pipeline.key(class);
            let outputs: serde_json::Map<String, Value> = pipeline
                .outputs()
                .iter()
                .enumerate()
                .map(|(o, name)| (name.clone(), json!(pipeline.weights(class, o))))
                .collect();
            json!({
                "position": key.position,
                "level": key.level,
                "texture": pipeline.axes().textures().names()[usize::from(key.texture)],
                "weights": outputs,
            })
        })
        .collect();
    json!({
        "camera": camera.description().name,
        "classes": summary.classes,
        "classes_that_occur": summary.occupied,
        "operators": summary.operators,
        "patches": summary.patches,
        "kernels": drawn,
    })
}

fn write_all(args: &Compare, ways: &[Way<'_>], outcomes: &[Vec<Outcome>], text: &str) -> anyhow::Result<()> {
    // A folder that has results.json is whole: that of an earlier run goes first, the new one comes last.
    let dir = &args.output;
    write::begin_folder(dir, &["results.json"])?;
    let pictures = dir.join("side-by-side");
    write::begin_folder(&pictures, &[])?;
    let lights = outcomes.first().map_or(&[][..], Vec::as_slice);
    for (l, light) in lights.iter().enumerate() {
        for (s, (scene, first)) in light.scenes.iter().enumerate() {
            let mut row = vec![as_seen(first, &first.reference, args)?];
            for outcomes in outcomes {
                let scores = &outcomes[l].scenes[s].1;
                row.push(as_seen(scores, &scores.picture, args)?);
            }
            let name = format!("{}-{}-cd-m2.png", plain(scene), light.luminance_cd_m2);
            picture::write_png(&pictures.join(name), &side_by_side(&row, 4)?, Depth::Eight)?;
        }
    }
    let cameras: Vec<Camera> = args_cameras(ways);
    let learned = ways.iter().filter(|w| w.processing == Processing::L3);
    for (number, way) in learned.enumerate() {
        let Some(pipeline) = way.pipeline else { continue };
        let name = folder_name(way.camera, number, &cameras);
        picture::write_png(
            &dir.join(format!("{name}-kernels.png")),
            &kernels(way.camera, pipeline)?,
            Depth::Eight,
        )?;
        l3::write_table(&dir.join(format!("{name}.l3")), pipeline)?;
    }
    write::bytes(&dir.join("results.json"), text.as_bytes())?;
    Ok(())
}

fn args_cameras(ways: &[Way<'_>]) -> Vec<Camera> {
    ways.iter().filter(|w| w.processing == Processing::L3).map(|w| w.camera.clone()).collect()
}

/// A picture of a scored scene as shown on a screen: white is that of the reference.
fn as_seen(scores: &SceneScores, picture: &Image, args: &Compare) -> anyhow::Result<Image> {
    let grid = smalti::spectrum::WavelengthGrid::VISIBLE;
    let white = Observer::Cie1931.xyz_from_photons(&resolve::illuminant(&args.illuminant)?.photons(grid)?)?;
    shown(picture, white.map(|v| v / white[1]), 1.0 / scores.scores.white_y)
}

/// The name of a scene as part of a file's.
fn plain(scene: &str) -> String {
    let name = Path::new(scene.split('?').next().unwrap_or(scene));
    let stem = name.file_stem().map_or_else(|| scene.into(), |s| s.to_string_lossy());
    stem.chars().map(|c| if c.is_alphanumeric() || "-_".contains(c) { c } else { '-' }).collect()
}
