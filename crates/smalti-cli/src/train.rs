//! `smalti train`: a learned pipeline as a file.

use std::path::Path;

use anyhow::{Context, bail};
use serde_json::json;
use smalti::camera::{Camera, TrainingTarget};
use smalti::color::ColorSpace;
use smalti::l3::{Origin, Pair, Pipeline, PositionSummary, Statistics};
use smalti::sensor::Channel;
use smalti::spectrum::Illuminant;
use smalti_io::exr::ReadOptions;
use smalti_io::{Limits, dng, l3, picture};

use crate::args::{Common, Train};
use crate::learn::{self, Material};
use crate::progress::Progress;
use crate::{resolve, table};

pub(crate) fn run(args: &Train, common: &Common) -> anyhow::Result<()> {
    let camera = resolve::camera(&args.camera, &args.camera_options, None)?;
    let mut settings = args.learning.settings(args.camera_options.seed);
    settings.target = target(args)?;
    settings.target_light = args.target_illuminant.as_deref().map(resolve::illuminant).transpose()?;
    settings.exposures.clone_from(&args.exposures);
    let training = args.learning.training();
    let lights =
        args.illuminants.iter().map(|n| resolve::illuminant(n)).collect::<anyhow::Result<Vec<_>>>()?;
    let material = material(args, &camera, &lights)?;
    let mut statistics = match &material {
        Some(m) => camera.training_statistics(&settings, &m.light(&camera)?)?,
        None => camera.training_statistics(&settings, &lights[0].photons(camera.grid())?)?,
    };
    let mut sources = Vec::new();
    if !args.pairs.is_empty() {
        // Real raw files hold their noise.
        statistics = Statistics::new(statistics.axes().clone(), statistics.outputs().to_vec(), true)?;
    }
    for file in &args.continue_from {
        statistics.merge(&l3::read_statistics(file)?).with_context(|| file.display().to_string())?;
        sources.push(format!("statistics {}", file.display()));
    }
    let steps = material.as_ref().map_or(0, Material::len) + args.pairs.len() / 2;
    let progress = Progress::new(steps as u64 + 1, common.quiet);
    for pair in args.pairs.chunks_exact(2) {
        progress.begin(format!("{} and {}", pair[0].display(), pair[1].display()));
        add_pair(&mut statistics, &pair[0], &pair[1])?;
        sources.push(format!("{} and {}", pair[0].display(), pair[1].display()));
        progress.done();
    }
    if let Some(material) = &material {
        learn::gather(&camera, &settings, material, &mut statistics, &progress)?;
        sources.extend(material.names());
    }
    progress.begin("solving");
    let story = learn::provenance(&camera, &settings, &training, &sources, statistics.count())?;
    let pipeline = training.solve(&statistics, story)?;
    // Everything is computed before anything is written.
    if let Some(file) = &args.statistics {
        l3::write_statistics(file, &statistics)?;
    }
    l3::write_table(&args.output, &pipeline)?;
    if let Some(file) = &args.npz {
        l3::write_npz(file, &pipeline)?;
    }
    if let Some(file) = &args.c_header {
        l3::write_c_header(file, &pipeline, &prefix(file))?;
    }
    progress.finish();
    let text = if args.json { json_summary(&pipeline)? } else { summary(&pipeline, &args.output) };
    crate::print(&text)
}

/// Names in a C header begin with the name of its file.
fn prefix(file: &Path) -> String {
    let stem = file.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let plain: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if plain.starts_with(|c: char| c.is_ascii_alphabetic()) { plain } else { format!("l3_{plain}") }
}

/// What is learned from; `None` when pairs or saved statistics are all.
fn material(args: &Train, camera: &Camera, lights: &[Illuminant]) -> anyhow::Result<Option<Material>> {
    if !args.scenes.is_empty() {
        let scene = |name: &String| {
            let scene = resolve::scene_for(name, &args.scene_options, camera)?;
            anyhow::Ok((name.clone(), resolve::on_sensor(scene, resolve::is_file(name), camera)?))
        };
        return Ok(Some(Material::Scenes(args.scenes.iter().map(scene).collect::<anyhow::Result<_>>()?)));
    }
    let others = !args.pairs.is_empty() || !args.continue_from.is_empty();
    Ok((!others).then(|| Material::Default(lights.to_vec())))
}

/// What should come out: XYZ, or what another camera sees.
fn target(args: &Train) -> anyhow::Result<TrainingTarget> {
    let Some(name) = &args.target else { return Ok(TrainingTarget::Xyz) };
    if name.eq_ignore_ascii_case("xyz") {
        return Ok(TrainingTarget::Xyz);
    }
    let other =
        resolve::camera(name, &crate::args::CameraOptions { overrides: Vec::new(), seed: 1 }, None)
            .with_context(|| format!("--target {name}: expected xyz, a built-in camera or a TOML file"))?;
    let curves = other.sensor.spectral_responsivity_on(other.grid())?;
    let channels = other.sensor.cfa.channels().iter().zip(curves);
    Ok(TrainingTarget::Channels(
        channels.map(|(c, curve)| Channel { name: c.name.clone(), transmittance: curve }).collect(),
    ))
}

/// A raw file and the picture that should come of it, pixel by pixel.
fn add_pair(statistics: &mut Statistics, raw: &Path, target: &Path) -> anyhow::Result<()> {
    let image = dng::read(raw, Limits::default())?;
    let wanted = picture::read(target, &ReadOptions::default())?.image.converted(ColorSpace::Xyz)?;
    if statistics.outputs().len() != 3 {
        bail!("a picture is a target in XYZ; --target {:?} has other outputs", statistics.outputs());
    }
    let pair = Pair { raw: &image.raw, seen: None, target: wanted.planes() };
    statistics.add(&pair).with_context(|| format!("{} with {}", raw.display(), target.display()))
}

/// The table of classes: what was learned, and where it was not.
fn summary(pipeline: &Pipeline, file: &Path) -> String {
    let s = pipeline.summary();
    let header =
        ["position", "channel", "patches", "occupied", "learned", "interpolated", "pooled", "nearest level"];
    let row = |p: &PositionSummary| {
        let of = |wanted: &[Origin]| -> usize { wanted.iter().map(|&o| p.by_origin[o as usize]).sum() };
        vec![
            format!("({}, {})", p.row, p.col),
            p.channel.clone(),
            p.patches.to_string(),
            p.occupied.to_string(),
            of(&[Origin::Learned]).to_string(),
            of(&[Origin::Interpolated]).to_string(),
            of(&[Origin::PooledTextures, Origin::PooledSaturations, Origin::PooledLevels]).to_string(),
            of(&[Origin::NearestLevel]).to_string(),
        ]
    };
    let rows: Vec<Vec<String>> = s.positions.iter().map(row).collect();
    let names = pipeline.channel_names();
    let clipped: Vec<String> = pipeline.saturations().iter().map(|&m| channels_of(m, names)).collect();
    format!(
        "{}\n{} classes occur, with {} operators, learned from {} patches; the rest of the {} in the table fall back\n\
         levels: {}; textures: {}; clipped channels: {}\n\n{}\n",
        table::render(&header, &rows),
        s.occupied,
        s.operators,
        s.patches,
        s.classes,
        pipeline.axes().level_count(),
        pipeline.axes().textures().names().join(", "),
        clipped.join(", "),
        file.display(),
    )
}

/// Names of the channels of a combination.
fn channels_of(mask: u32, names: &[String]) -> String {
    if mask == 0 {
        return "none".into();
    }
    let set = names.iter().enumerate().filter(|(c, _)| mask >> c & 1 == 1);
    set.map(|(_, n)| n.as_str()).collect::<Vec<_>>().join("")
}

fn json_summary(pipeline: &Pipeline) -> anyhow::Result<String> {
    let s = pipeline.summary();
    let classes: Vec<serde_json::Value> = pipeline
        .classes()
        .iter()
        .enumerate()
        .map(|(i, class)| {
            let key = pipeline.key(i);
            json!({
                "position": key.position,
                "clipped": channels_of(key.saturation, pipeline.channel_names()),
                "level": key.level,
                "texture": pipeline.axes().textures().names()[usize::from(key.texture)],
                "patches": class.count,
                "origin": class.origin.name(),
            })
        })
        .collect();
    let document = json!({
        "classes_that_occur": s.occupied,
        "operators": s.operators,
        "patches": s.patches,
        "classes": classes,
    });
    Ok(serde_json::to_string_pretty(&document)? + "\n")
}
