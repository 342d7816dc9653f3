//! `smalti compare`: renders the same scenes with cameras and their learned pipelines.

use std::path::{Path, PathBuf};

use anyhow::ensure;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use smalti::camera::{Camera, ScoreSettings, TestScene};
use smalti::experiment::{
    ComparisonSettings, Contender, IspKeys, Processing, Progress as _, Resources, camera_differences,
    compare, contenders, ensure_any_defined, light_gains_to_first, pipelines, scene_lights,
};
use smalti::isp::Demosaic;
use smalti::spectrum::Illuminant;
use smalti_io::cache::Cache;
use smalti_io::comparisons::{self, ComparisonFiles, RESULTS};
use smalti_io::test_scenes::{TestSet, test_scene};
use smalti_io::{memory, write};
use smalti_report::comparison::{Comparison, Conditions, PAGE, SIDE_BY_SIDE};
use smalti_report::names;

use crate::args::{CameraOptions, Common, choice, word_of};
use crate::exposure_args::ExposureOptions;
use crate::learning_args::LearningOptions;
use crate::numbers::{ensure_distinct, positive};
use crate::output::note;
use crate::progress::Progress;
use crate::{resolve, table};

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti compare bayer rgbw --luminance 1,80\n  \
    smalti compare bayer rgbw --luminance 1 --light-gain\n  \
    smalti compare bayer@quad-bayer bayer@rgbw-sony --luminance 1\n  \
    smalti compare bayer --processing l3,bilinear,malvar2004,hamilton-adams1997 --luminance 1,10,80\n  \
    smalti compare bayer rgbw clarity kodak wang --luminance 1 --scene photo.png -o slides\n\n\
    The verdict states which camera is better at which light, with 95 % confidence intervals from the scatter between scenes and noise \
    realisations, and how much more light the other camera needs to reach the same CPSNR.\n\n\
    CPSNR (in XYZ), ΔE2000 and S-CIELAB are means over the pictures of all scenes. MTF50 is measured on a slanted edge, visual \
    SNR and noise on the grey patches of a chart (smalti list metrics). The cache stores the learned pipelines, so that the next \
    comparison takes seconds.\n\n\
    Output files: report.html, a page of all results; side-by-side/, for each scene and luminance one picture (the reference, then the \
    cameras in the order of the table) and one of error maps (ΔE2000, S-CIELAB); CAMERA.l3 (for smalti render); CAMERA-kernels.png; \
    and results.json, which is removed first and written last, so a folder that contains it is complete.")]
pub(crate) struct Compare {
    /// Built-in cameras (smalti list cameras) or TOML files; CAMERA@MOSAIC has another mosaic (smalti list cfas)
    #[arg(required = true)]
    pub(crate) cameras: Vec<String>,
    /// Mean luminance of the scenes, cd/m²; one or several, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "1,80", value_name = "CD_M2", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) luminance: Vec<f64>,
    /// The set of test scenes. None is used for training
    #[arg(long = "scenes", value_name = "SET", value_parser = choice(&TestSet::NAMED), default_value = word_of(&TestSet::NAMED, &TestSet::default()), conflicts_with = "scenes")]
    pub(crate) set: TestSet,
    /// A scene to compare on instead of a set, built in or a file; may be given more than once. A chart named
    /// without parameters has the size that it has in the set `charts`
    #[arg(long = "scene", value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Number of noise realisations of each scene, with seeds from --seed on. More of them narrow the intervals of the verdict a
    /// little
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub(crate) seeds: u64,
    /// Illuminant of charts, files and targets, and of the training for them: a name (smalti list illuminants) or a CSV. Natural
    /// scenes keep their own light, and each light has a pipeline of its own
    #[arg(long, default_value = DEFAULT_LIGHT, value_name = "NAME")]
    pub(crate) illuminant: String,
    /// Processing methods, separated by commas
    #[arg(long, value_delimiter = ',', value_parser = processing(), default_value = "l3")]
    pub(crate) processing: Vec<Processing>,
    /// Also measure for each metric the light gain: the additional light, in stops, with which the first camera matches each other
    /// camera, with the first processing method. Takes a minute or more for each camera and luminance
    #[arg(long)]
    pub(crate) light_gain: bool,
    /// A learned table (smalti train) to use instead of training; one for each camera, in their order
    #[arg(long = "pipeline", value_name = "FILE.l3")]
    pub(crate) pipelines: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) exposure: ExposureOptions,
    #[command(flatten)]
    pub(crate) camera_options: CameraOptions,
    /// Do not use the cache of optical images and pipelines ($SMALTI_CACHE_DIR, else the user's cache folder)
    #[arg(long)]
    pub(crate) no_cache: bool,
    /// Print results.json instead of the table
    #[arg(long)]
    pub(crate) json: bool,
    /// Folder for the results, created if needed
    #[arg(short, long, default_value = "out", value_name = "DIR")]
    pub(crate) output: PathBuf,
    // Last: the heading would apply to all arguments after it.
    #[command(flatten)]
    pub(crate) learning: LearningOptions,
}

/// Parses the names of processing methods, including a former name.
fn processing() -> impl TypedValueParser<Value = Processing> {
    let value = |p: Processing| {
        let value = PossibleValue::new(p.name());
        match p {
            Processing::L3 => value.help("The learned pipeline"),
            Processing::Classic(Demosaic::Malvar2004) => {
                value.help("Malvar, He and Cutler 2004 with a colour matrix, for Bayer mosaics")
            }
            Processing::Classic(Demosaic::HamiltonAdams1997) => value
                .alias("adaptive")
                .help("Hamilton and Adams 1997 with a colour matrix, for Bayer mosaics"),
            Processing::Classic(_) => {
                value.help("Bilinear demosaicking with a colour matrix, for any mosaic")
            }
        }
    };
    PossibleValuesParser::new(Processing::all().into_iter().map(value)).try_map(|typed| {
        let typed = if typed == "adaptive" { "hamilton-adams1997" } else { &typed };
        Processing::all().into_iter().find(|p| p.name() == typed).ok_or("unknown processing")
    })
}

/// The illuminant of a comparison where none is stated.
const DEFAULT_LIGHT: &str = "D65";

/// `words` are the command line, for the page.
pub(crate) fn run(args: &Compare, words: &[String], common: &Common) -> anyhow::Result<()> {
    let illuminant = resolve::illuminant(&args.illuminant, common)?;
    let cameras = resolve::cameras(&args.cameras, &args.camera_options, &illuminant, common)?;
    ensure!(!args.light_gain || cameras.len() > 1, "--light-gain compares cameras; expected two or more");
    ensure_distinct("--luminance", &args.luminance)?;
    ensure_distinct("--scene", &args.scenes)?;
    ensure_any_defined(&cameras, &args.processing)?;
    let labels = names::numbered(cameras.iter().map(|c| c.description().name.clone()).collect());
    if args.pipelines.is_empty() {
        resolve::note_identical(&cameras, &labels, common);
    }
    args.exposure.note().iter().for_each(|text| note(text, common));
    write::ensure_can_fill(&args.output)?;
    let seed = args.camera_options.seed;
    let cache = if args.no_cache { Cache::disabled() } else { Cache::open(None)? };
    let (settings, training) = (args.learning.settings(seed), args.learning.training());
    let progress = Progress::new(0, common.quiet);
    let resources = Resources {
        store: &cache,
        training_scenes: args.learning.training_set.stored(),
        progress: &progress,
        memory_bytes: memory::available_bytes(),
    };
    let learning = (&settings, &training);
    let given = resolve::pipelines(&args.pipelines, cameras.len())?;
    resolve::ensure_tables_fit(&args.pipelines, cameras.iter().zip(&given))?;
    let scenes = scenes(args, &illuminant)?;
    let lights = scene_lights(&illuminant, &scenes)?;
    if args.illuminant != DEFAULT_LIGHT && scenes.iter().all(TestScene::keeps_light) {
        note(
            &format!(
                "every scene keeps its own light; {} illuminates the chart and the edge alone",
                args.illuminant
            ),
            common,
        );
    }
    resolve::without_infrared(&cameras, &scenes, &illuminant)?.iter().for_each(|text| note(text, common));
    let pipelines = pipelines(&cameras, &labels, given, &args.processing, learning, &lights, resources)?;
    let (contenders, left_out) = contenders(&cameras, &labels, &pipelines, &args.processing)?;
    for name in &left_out {
        progress.note(&format!(
            "{name} is left out, since the method is defined for Bayer mosaics only; l3 and bilinear are defined for any mosaic"
        ));
    }
    contenders.iter().filter_map(Contender::other_than_green).for_each(|text| progress.note(&text));
    // The table of differences is about the cameras that are compared.
    let is_compared = |label: &String| contenders.iter().any(|c| c.label == label);
    let (compared_cameras, compared_labels): (Vec<Camera>, Vec<String>) =
        cameras.iter().cloned().zip(labels.iter().cloned()).filter(|(_, label)| is_compared(label)).unzip();
    let settings = ComparisonSettings {
        luminances_cd_m2: args.luminance.clone(),
        illuminant,
        scenes,
        seed,
        seed_count: args.seeds,
        score: ScoreSettings::default(),
        exposure: args.exposure.policy(),
    };
    let compared = compare(&contenders, &settings, resources)?;
    let gains = if args.light_gain {
        light_gains_to_first(&contenders, &settings, &compared.exposure, &progress)?
    } else {
        Vec::new()
    };
    let scene_labels: Vec<String> = settings.scenes.iter().map(|s| scene_label(s.name())).collect();
    let own_light: Vec<bool> = settings.scenes.iter().map(TestScene::keeps_light).collect();
    let learned_only = contenders.iter().all(|c| c.processing == Processing::L3);
    let isp = if learned_only { IspKeys::Unused } else { IspKeys::ColorMatrix };
    let conditions = Conditions {
        exposure: compared.exposure.applied(),
        cameras: &compared_cameras,
        differences: &camera_differences(&compared_cameras, isp)?,
        limiting: compared.exposure.limiting(),
        labels: &compared_labels,
    };
    let report = Comparison {
        command: &resolve::command_line(words, &args.cameras),
        cameras: &cameras,
        labels: &labels,
        contenders: &contenders,
        left_out: &left_out,
        outcomes: &compared.outcomes,
        conditions,
        gains: &gains,
        scene_labels: &scene_labels,
        own_light: &own_light,
        illuminant: &args.illuminant,
        seed,
        verdict: &compared.verdict,
    };
    let text = serde_json::to_string_pretty(&report.document()?)? + "\n";
    progress.begin("writing");
    write_files(&report, &args.output, &text)?;
    progress.finish();
    if args.json {
        return crate::output::print_document(&text);
    }
    let verdict = match report.verdict_text() {
        text if text.is_empty() => text,
        text => text + "\n",
    };
    crate::print(&format!(
        "{verdict}{}\n{}{}{}\n{}; see {}; all results are in {}\n",
        conditions.text(&table::render),
        report.scores_table(&table::render),
        report.fixed_point_line(),
        report.gains_table(&table::render),
        report.over(),
        args.output.join(PAGE).display(),
        args.output.join(RESULTS).display(),
    ))
}

/// Writes everything; `document` is the content of results.json.
fn write_files(report: &Comparison<'_>, dir: &Path, document: &str) -> anyhow::Result<()> {
    let content = ComparisonFiles {
        page: PAGE,
        pictures: SIDE_BY_SIDE,
        files: &report.files(),
        tables: &report.tables(),
        document,
    };
    comparisons::write(
        dir,
        &content,
        |store| Ok(report.draw(&mut |name, content| Ok(store(name, content)?))?),
    )
}

/// The name of a scene without its folder, parameters and extension.
pub(crate) fn scene_label(scene: &str) -> String {
    let name = if resolve::is_file(scene) { scene } else { scene.split('?').next().unwrap_or(scene) };
    Path::new(name).file_stem().map_or_else(|| scene.to_owned(), |s| s.to_string_lossy().into_owned())
}

/// The scenes of the command line, else those of the set.
fn scenes(args: &Compare, illuminant: &Illuminant) -> anyhow::Result<Vec<TestScene>> {
    if args.scenes.is_empty() {
        return Ok(args.set.scenes(illuminant)?);
    }
    Ok(args.scenes.iter().map(|name| test_scene(name, illuminant)).collect::<Result<_, _>>()?)
}
