//! `smalti train`: learns a pipeline and writes it to a file.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use serde_json::json;
use smalti::camera::{Camera, TrainingTarget};
use smalti::experiment::{Learned, NamedScene, TrainingSources, learn};
use smalti::l3::{Origin, Pipeline, PositionSummary, Quality};
use smalti_io::cameras::LoadedCamera;
use smalti_io::l3::CArithmetic;
use smalti_io::{l3, memory, write};

use crate::args::{CameraOptions, Common};
use crate::learning_args::LearningOptions;
use crate::numbers::positive;
use crate::output::note;
use crate::progress::Progress;
use crate::raw_args::RawOptions;
use crate::scene_args::SceneOptions;
use crate::{pairs, resolve, table};

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti train rgbw -o rgbw.l3\n  \
    smalti train my.toml --illuminants A --target-illuminant D65 -o warm.l3       white-balanced for tungsten\n  \
    smalti train bayer --scene forest.exr --scene street.exr -o mine.l3\n  \
    smalti train bayer --statistics half.l3s -o a.l3                             statistics for --continue\n  \
    smalti train nikon.toml --pair shot.dng shot.jpg --pair b.dng b.jpg -o nikon.l3\n  \
    smalti train rgbw -o rgbw.l3 --c-header rgbw_isp.h --npz rgbw.npz\n\n\
    Without --scene, --pair or --continue, the training data are the default set: dead leaves, patch charts, gradients, edges, \
    stars, gratings, steps, scenes of high dynamic range, photographs and path-traced scenes, in natural and saturated colours, \
    under daylight, tungsten and LED. --exposures determines the exposure of all scenes, and their luminance has no effect. The printed \
    table states for each position of the mosaic how many classes had training data, and the origin of the kernels of classes with too few patches.")]
pub(crate) struct Train {
    /// A built-in camera (smalti list cameras) or a TOML file; CAMERA@MOSAIC has another mosaic (smalti list cfas)
    pub(crate) camera: String,
    /// A scene to learn from instead of the default set, built in or a file; may be given more than once
    #[arg(long = "scene", value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Illuminants of the default set, which its scenes use in turn
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "D65,A,LED",
        value_name = "NAME,...",
        conflicts_with = "scenes"
    )]
    pub(crate) illuminants: Vec<String>,
    /// Illuminant of the target pictures, for illuminant correction [default: that of the capture]
    #[arg(long, value_name = "NAME")]
    pub(crate) target_illuminant: Option<String>,
    /// Quantity to estimate at every pixel: xyz, or the channels of a camera (name or TOML) [default: xyz]
    #[arg(long, value_name = "TARGET")]
    pub(crate) target: Option<String>,
    /// Exposures of each scene, as the response to its highlights, where 1 is saturation [default: from 3 down to the noise]
    #[arg(long, value_delimiter = ',', value_name = "R,...", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) exposures: Vec<f64>,
    /// A raw file (DNG) and the target picture of the same capture; may be given more than once. The picture is aligned with
    /// the raw image to a fraction of a pixel and may be cropped, shifted or scaled. Pairs cannot be combined with --scene,
    /// since raw files contain noise and scenes do not
    #[arg(long = "pair", num_args = 2, value_names = ["RAW", "PICTURE"], conflicts_with_all = ["scenes", "target", "target_illuminant"])]
    pub(crate) pairs: Vec<PathBuf>,
    /// Use the pictures of --pair without alignment, pixel by pixel
    #[arg(long, requires = "pairs")]
    pub(crate) no_align: bool,
    #[command(flatten)]
    pub(crate) raw_options: RawOptions,
    /// Continue from statistics that --statistics saved; several files are merged
    #[arg(long = "continue", value_name = "FILE")]
    pub(crate) continue_from: Vec<PathBuf>,
    /// Save the statistics of all patches, to continue from or to merge later
    #[arg(long, value_name = "FILE")]
    pub(crate) statistics: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) camera_options: CameraOptions,
    /// Also write the table as NumPy arrays
    #[arg(long, value_name = "FILE")]
    pub(crate) npz: Option<PathBuf>,
    /// Also write the table as a C header in fixed point
    #[arg(long, value_name = "FILE")]
    pub(crate) c_header: Option<PathBuf>,
    /// Also write the table as a C header in single precision, which renders the same bits as smalti
    #[arg(long, value_name = "FILE")]
    pub(crate) c_header_float: Option<PathBuf>,
    /// Print every class as JSON instead of the table
    #[arg(long)]
    pub(crate) json: bool,
    /// The learned table (safetensors)
    #[arg(short, long, value_name = "FILE.l3")]
    pub(crate) output: PathBuf,
    #[command(flatten, next_help_heading = "Properties that a --scene does not state")]
    pub(crate) scene_options: SceneOptions,
    // Last: the heading would apply to all arguments after it.
    #[command(flatten)]
    pub(crate) learning: LearningOptions,
}

pub(crate) fn run(args: &Train, common: &Common) -> anyhow::Result<()> {
    let LoadedCamera { camera, notes, .. } = resolve::camera(&args.camera, &args.camera_options)?;
    notes.iter().for_each(|text| note(text, common));
    let mut settings = args.learning.settings(args.camera_options.seed);
    settings.target = target(args)?;
    settings.target_light =
        args.target_illuminant.as_deref().map(|n| resolve::illuminant(n, common)).transpose()?;
    settings.exposures.clone_from(&args.exposures);
    let training = args.learning.training();
    if training.quality == Quality::Best && settings.target != TrainingTarget::Xyz {
        bail!("--quality best refines pictures in X, Y, Z; expected no --target, or --quality fast");
    }
    if args.raw_options.raw_cfa.is_some() && args.pairs.is_empty() {
        bail!(
            "--raw-cfa states the mosaic of the raw files of --pair; expected --pair, or --cfa for the mosaic of the camera"
        );
    }
    let lights = args
        .illuminants
        .iter()
        .map(|n| resolve::illuminant(n, common))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let headers = [
        (args.c_header.as_ref(), CArithmetic::Integers),
        (args.c_header_float.as_ref(), CArithmetic::SinglePrecision),
    ];
    let [fixed, float] = headers.map(|(file, _)| file);
    let files = [Some(&args.output), args.statistics.as_ref(), args.npz.as_ref(), fixed, float];
    for file in files.into_iter().flatten() {
        match folder_to_make(file) {
            Some(folder) => write::ensure_can_fill(folder)?,
            None => write::ensure_can_write(file)?,
        }
    }
    let saved = |file: &PathBuf| anyhow::Ok((file.display().to_string(), l3::read_statistics(file)?));
    let progress = Progress::new(0, common.quiet);
    let pairs = args.pairs.chunks_exact(2).map(|files| {
        let noise = camera.sensor.signal_noise(&camera.nominal_exposure()?)?;
        anyhow::Ok(pairs::pair([&files[0], &files[1]], &args.raw_options, !args.no_align, noise, &progress))
    });
    let sources = TrainingSources {
        scenes: scenes(args, &camera, common)?,
        illuminants: lights,
        stored_scenes: args.learning.training_set.stored(),
        pairs: pairs.collect::<anyhow::Result<_>>()?,
        saved: args.continue_from.iter().map(saved).collect::<anyhow::Result<_>>()?,
    };
    let Learned { statistics, pipeline, alignments } =
        learn(&camera, &settings, &training, &sources, &progress, memory::available_bytes())?;
    // All results are computed before the first file is written.
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
    for (file, arithmetic) in headers {
        if let Some(file) = file {
            l3::write_c_header(file, &pipeline, &l3::c_prefix(file), arithmetic)?;
        }
    }
    progress.finish();
    let reports: Vec<pairs::Report<'_>> =
        args.pairs.chunks_exact(2).zip(&alignments).map(Into::into).collect();
    let text = if args.json {
        json_summary(&pipeline, &reports)?
    } else {
        let pairs: String = reports.iter().map(pairs::Report::line).collect();
        return crate::print(&(pairs + &summary(&pipeline, &args.output)));
    };
    crate::output::print_document(&text)
}

/// The folder of a file, if it does not exist.
fn folder_to_make(file: &Path) -> Option<&Path> {
    file.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.exists())
}

/// The scenes of the command line.
fn scenes(args: &Train, camera: &Camera, common: &Common) -> anyhow::Result<Option<Vec<NamedScene>>> {
    if !args.scenes.is_empty() {
        let scene = |name: &String| {
            let scene = resolve::scene_for(name, &args.scene_options, camera, common)?;
            let keeps_fov = args.scene_options.states_fov(name);
            Ok(NamedScene::for_camera(camera, name.clone(), scene, resolve::is_file(name), keeps_fov)?)
        };
        return args.scenes.iter().map(scene).collect::<anyhow::Result<_>>().map(Some);
    }
    if args.scene_options != SceneOptions::default() {
        bail!(
            "--illuminant, --luminance, --distance, --fov and --wavelengths apply to scenes of --scene; use --illuminants and \
             --exposures for the default set"
        );
    }
    Ok(None)
}

/// The target: XYZ, or the channels of another camera.
fn target(args: &Train) -> anyhow::Result<TrainingTarget> {
    let Some(name) = &args.target else { return Ok(TrainingTarget::Xyz) };
    if name.eq_ignore_ascii_case("xyz") {
        return Ok(TrainingTarget::Xyz);
    }
    let options = CameraOptions { overrides: Vec::new(), cfa: None, seed: 1 };
    let other = resolve::camera(name, &options)
        .with_context(|| format!("--target {name}: expected xyz, a built-in camera or a TOML file"))?;
    Ok(TrainingTarget::channels_of(&other.camera)?)
}

/// The table of classes and the origins of their kernels.
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
    let clipped: Vec<String> = pipeline.saturations().iter().map(|&m| pipeline.clipped_names(m)).collect();
    format!(
        "{}\nA class is a combination of position in the mosaic (row, column, from 0), response level, texture and clipped channels. An occupied class has patches.\n\
         Its kernels are learned from its patches, interpolated between levels, pooled with similar classes, or those of the nearest level.\n\
         {} of {} classes had training data ({} patches, {} kernels); the others use the kernels of similar classes\n\
         levels: {}; textures: {}; clipped channels: {}\n{}\n\n{}\n",
        table::render(&header, &rows),
        s.occupied,
        s.classes,
        s.patches,
        s.operators,
        pipeline.axes().level_count(),
        pipeline.axes().textures().names().join(", "),
        clipped.join(", "),
        quality_line(pipeline),
        file.display(),
    )
}

/// The quality, and the classes of the second stage.
fn quality_line(pipeline: &Pipeline) -> String {
    let name = pipeline.quality().name();
    pipeline.refinement().map_or_else(
        || format!("quality: {name}, one stage"),
        |refinement| {
            let classes = refinement.classes();
            let learned = classes.iter().filter(|c| c.is_learned).count();
            format!(
                "quality: {name}, two stages; {learned} of {} classes of the second stage had enough training data",
                classes.len()
            )
        },
    )
}

fn json_summary(pipeline: &Pipeline, pairs: &[pairs::Report<'_>]) -> anyhow::Result<String> {
    let s = pipeline.summary();
    let document = json!({
        "quality": pipeline.quality().name(),
        "classes_that_occur": s.occupied,
        "operators": s.operators,
        "patches": s.patches,
        "pairs": pairs.iter().map(pairs::Report::json).collect::<Vec<_>>(),
        "classes": pipeline.class_records(),
    });
    Ok(serde_json::to_string_pretty(&document)? + "\n")
}
