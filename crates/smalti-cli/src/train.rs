//! `smalti train`: a learned pipeline as a file.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use serde_json::json;
use smalti::camera::{Camera, TrainingTarget};
use smalti::color::SRGB_WHITE;
use smalti::l3::{Axes, Origin, Pipeline, PositionSummary, Statistics};
use smalti::sensor::Channel;
use smalti::spectrum::Illuminant;
use smalti_io::{l3, write};

use crate::args::{Common, Train};
use crate::learn::{self, Material};
use crate::progress::Progress;
use crate::scene_args::SceneOptions;
use crate::{pairs, resolve, table};

pub(crate) fn run(args: &Train, common: &Common) -> anyhow::Result<()> {
    let camera = resolve::camera(&args.camera, &args.camera_options, None)?;
    let mut settings = args.learning.settings(args.camera_options.seed);
    settings.target = target(args)?;
    settings.target_light = args.target_illuminant.as_deref().map(resolve::illuminant).transpose()?;
    settings.exposures.clone_from(&args.exposures);
    let training = args.learning.training();
    let lights =
        args.illuminants.iter().map(|n| resolve::illuminant(n)).collect::<anyhow::Result<Vec<_>>>()?;
    learn::ensure_mosaic(&camera)?;
    let files = [Some(&args.output), args.statistics.as_ref(), args.npz.as_ref(), args.c_header.as_ref()];
    for file in files.into_iter().flatten() {
        match folder_to_make(file) {
            Some(folder) => write::ensure_can_fill(folder)?,
            None => write::ensure_can_write(file)?,
        }
    }
    let material = material(args, &camera, &lights)?;
    let light = match &material {
        Some(m) => m.light(&camera)?,
        None => lights.first().unwrap_or(&Illuminant::D65).photons(camera.grid())?,
    };
    let mut statistics = camera.training_statistics(&settings, &light)?;
    learn::ensure_memory(statistics.axes(), statistics.outputs().len())?;
    if !args.pairs.is_empty() {
        // Real raw files hold their noise; pictures are in sRGB.
        statistics = Statistics::new(statistics.axes().clone(), statistics.outputs().to_vec(), true)?
            .with_white(Some(SRGB_WHITE));
    }
    let (mut sources, mut reports) = (Vec::new(), Vec::new());
    if let Some((first, others)) = args.continue_from.split_first() {
        statistics = continued(first, others, statistics, material.is_some() || !args.pairs.is_empty())?;
        sources.extend(args.continue_from.iter().map(|f| format!("statistics {}", f.display())));
    }
    let steps = material.as_ref().map_or(0, Material::len) + args.pairs.len() / 2;
    let progress = Progress::new(steps as u64 + 1, common.quiet);
    for pair in args.pairs.chunks_exact(2) {
        progress.begin(format!("{} and {}", pair[0].display(), pair[1].display()));
        let files: [&Path; 2] = [&pair[0], &pair[1]];
        reports.push(pairs::add(&mut statistics, &camera, files, !args.no_align, &progress)?);
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
    for folder in files.into_iter().flatten().filter_map(|f| folder_to_make(f)) {
        write::begin_folder(folder, &[])?;
    }
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
    let text = if args.json {
        json_summary(&pipeline, &reports)?
    } else {
        let pairs: String = reports.iter().map(pairs::Report::line).collect();
        pairs + &summary(&pipeline, &args.output)
    };
    crate::print(&text)
}

/// The folder of a file, where it is absent.
fn folder_to_make(file: &Path) -> Option<&Path> {
    file.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.exists())
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
            anyhow::Ok((name.clone(), camera.fitted(scene, resolve::is_file(name))?))
        };
        return Ok(Some(Material::Scenes(args.scenes.iter().map(scene).collect::<anyhow::Result<_>>()?)));
    }
    if args.scene_options != SceneOptions::default() {
        bail!(
            "--illuminant, --luminance, --distance, --fov and --wavelengths are for scenes of --scene; the lights of the \
             default set are --illuminants, its exposures --exposures"
        );
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

/// Saved statistics, merged. When more is to be added (`more`) they must be as `fresh` ones are; else it is enough that they
/// are of the camera and of the settings that were typed, in whatever light they were gathered.
fn continued(first: &Path, others: &[PathBuf], fresh: Statistics, more: bool) -> anyhow::Result<Statistics> {
    let mut statistics = l3::read_statistics(first)?;
    let (its, own) = (statistics.axes(), fresh.axes());
    let name = first.display();
    if its.mosaic() != own.mosaic() {
        bail!("{name}: statistics of another mosaic than that of the camera");
    }
    if its.side() != own.side() {
        bail!("{name}: statistics of patches of {0} × {0}; --patch is {1}", its.side(), own.side());
    }
    if its.level_count() != own.level_count() {
        bail!("{name}: statistics of {} levels; --levels is {}", its.level_count(), own.level_count());
    }
    if its.textures() != own.textures() {
        let names = |a: &Axes| a.textures().names().join(", ");
        bail!("{name}: statistics of the textures {}; --textures asks for {}", names(its), names(own));
    }
    if its.noise() != own.noise() {
        bail!("{name}: statistics of a camera with other noise (or of another exposure)");
    }
    if statistics.outputs() != fresh.outputs() {
        let names = |s: &Statistics| s.outputs().join(", ");
        bail!("{name}: statistics with targets {}; {} were asked for", names(&statistics), names(&fresh));
    }
    if more {
        if statistics.noisy() != fresh.noisy() {
            bail!(
                "{name}: raw files hold their noise and scenes do not: statistics of the one cannot go on with the other"
            );
        }
        statistics
            .merge(&fresh)
            .with_context(|| format!("{name}, gathered in another light or with other settings"))?;
    }
    for file in others {
        let other = l3::read_statistics(file)?;
        statistics.merge(&other).with_context(|| format!("{name} and {}", file.display()))?;
    }
    Ok(statistics)
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
        "{}\nA class is a position in the mosaic, a level of light, a texture, and which channels are clipped. Occupied: it has patches;\n\
         learned: enough of them; interpolated: from the levels on both sides; pooled: learned with the classes beside it.\n\
         {} classes occur, with {} operators, learned from {} patches; the rest of the {} in the table fall back\n\
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

fn json_summary(pipeline: &Pipeline, pairs: &[pairs::Report]) -> anyhow::Result<String> {
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
        "pairs": pairs.iter().map(pairs::Report::json).collect::<Vec<_>>(),
        "classes": classes,
    });
    Ok(serde_json::to_string_pretty(&document)? + "\n")
}
