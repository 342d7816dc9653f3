//! `smalti evaluate`: scores cameras, as a table or as JSON.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;
use smalti::camera::{Camera, Evaluation, EvaluationPictures, EvaluationSettings};
use smalti::color::ColorSpace;
use smalti::experiment::{
    ComparedPictures, Contender, ExposurePlan, IspKeys, PipelineSet, Progress as _, Resources,
    camera_differences,
};
use smalti::l3::Quality;
use smalti::spectrum::{Observer, WavelengthGrid};
use smalti_io::picture::{self, Depth};
use smalti_io::write;
use smalti_report::comparison::{
    Conditions, Evaluations, PAGE, aliasing_picture, evaluation_page, evaluation_text,
};
use smalti_report::names;

use crate::args::{CameraOptions, Common};
use crate::exposure_args::ExposureOptions;
use crate::numbers::{ensure_distinct, number};
use crate::output::note;
use crate::progress::Progress;
use crate::{resolve, table};

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti evaluate bayer rgbw\n  \
    smalti evaluate bayer my.toml --luminance 1,10,100 --illuminant A --json\n  \
    smalti evaluate bayer bayer@quad-bayer -o quad\n  \
    smalti evaluate rgbw --pipeline rgbw.l3\n\n\
    smalti list metrics explains the columns of the table, with their units and sources.\n\
    results.json is removed first and written last, so a folder that contains it is complete.")]
pub(crate) struct Evaluate {
    /// Built-in cameras (smalti list cameras) or TOML files; CAMERA@MOSAIC has another mosaic (smalti list cfas)
    #[arg(required = true)]
    pub(crate) cameras: Vec<String>,
    /// Mean luminance of the targets, cd/m²; one or several, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "75", value_name = "CD_M2", value_parser = number)]
    pub(crate) luminance: Vec<f64>,
    /// Illuminant of the targets: a name (smalti list illuminants) or a CSV of wavelength_nm and relative power
    #[arg(long, default_value = "D65", value_name = "NAME")]
    pub(crate) illuminant: String,
    /// A learned table (smalti train) that renders the pictures, instead of the camera's own processing; one for each camera, in
    /// their order
    #[arg(long = "pipeline", value_name = "FILE.l3")]
    pub(crate) pipelines: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) exposure: ExposureOptions,
    #[command(flatten)]
    pub(crate) camera_options: CameraOptions,
    /// Do not use the cache of optical images ($SMALTI_CACHE_DIR, else the user's cache folder)
    #[arg(long)]
    pub(crate) no_cache: bool,
    /// Print one JSON document instead of the table
    #[arg(long)]
    pub(crate) json: bool,
    /// Write report.html, results.json and the pictures of the targets to this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
}

/// `words` are the command line, for the page.
pub(crate) fn run(args: &Evaluate, words: &[String], common: &Common) -> anyhow::Result<()> {
    let illuminant = resolve::illuminant(&args.illuminant, common)?;
    let cameras = resolve::cameras(&args.cameras, &args.camera_options, &illuminant, common)?;
    ensure_distinct("--luminance", &args.luminance)?;
    let labels = names::numbered(cameras.iter().map(|c| c.description().name.clone()).collect());
    if args.pipelines.is_empty() {
        resolve::note_identical(&cameras, &labels, common);
    }
    args.exposure.note().iter().for_each(|text| note(text, common));
    let tables = resolve::pipelines(&args.pipelines, cameras.len())?;
    resolve::ensure_tables_fit(&args.pipelines, cameras.iter().zip(&tables))?;
    if let Some(dir) = &args.output {
        write::ensure_can_fill(dir)?;
    }
    let cache = resolve::cache(args.no_cache)?;
    let progress = Progress::new((cameras.len() * args.luminance.len()) as u64, common.quiet);
    let resources = Resources { store: &cache, progress: &progress, ..Resources::default() };
    let tables = tables.into_iter().chain(std::iter::repeat_with(|| None));
    let set = |(camera, table): (&Camera, Option<_>)| {
        table.map(|pipeline| PipelineSet::of_any_light(&illuminant, camera, pipeline))
    };
    let sets: Vec<Option<PipelineSet>> = cameras.iter().zip(tables).map(set).collect();
    let labelled = cameras.iter().zip(&labels).zip(&sets);
    let contenders: Vec<_> =
        labelled.map(|((c, label), set)| Contender::with_pipelines(c, label, set.as_ref())).collect();
    let pictures = ComparedPictures {
        scenes: &[],
        luminances_cd_m2: &args.luminance,
        illuminant: &illuminant,
        setups: &[],
    };
    let labelled: Vec<(&str, &Camera)> = contenders.iter().map(|c| (c.label, c.camera)).collect();
    let exposure = ExposurePlan::new(args.exposure.policy(), &labelled, pictures, resources)?;
    let (mut results, mut shots) = (Vec::new(), Vec::new());
    for contender in &contenders {
        for (light, &luminance_cd_m2) in args.luminance.iter().enumerate() {
            progress.begin(&format!("{} at {luminance_cd_m2} cd/m²", contender.label));
            let settings = EvaluationSettings {
                luminance_cd_m2,
                illuminant: illuminant.clone(),
                seed: args.camera_options.seed,
                exposure: exposure.targets(light),
                ..EvaluationSettings::default()
            };
            let scored = contender.evaluate(&settings, resources);
            let (scores, pictures) = scored.map_err(|e| exposure.explained(contender.label, e))?;
            shots.extend(args.output.is_some().then_some(pictures));
            results.push((contender.camera, scores));
            progress.done();
        }
    }
    progress.finish();
    // A learned pipeline replaces the processing of its camera.
    let isp = if sets.iter().all(Option::is_some) { IspKeys::Unused } else { IspKeys::Own };
    let conditions = Conditions {
        exposure: exposure.applied(),
        cameras: &cameras,
        differences: &camera_differences(&cameras, isp)?,
        limiting: exposure.limiting(),
        labels: &labels,
    };
    // Pictures of learned pipelines state their quality.
    let titles: Vec<String> =
        contenders.iter().map(|c| c.pipelines.map_or_else(|| c.label.to_owned(), |_| c.name())).collect();
    let qualities =
        contenders.iter().flat_map(|c| args.luminance.iter().map(|_| c.quality().map(Quality::name)));
    let entries = results.iter().zip(qualities).map(|((c, s), quality)| entry(c, s, quality));
    let entries = entries.collect::<anyhow::Result<Vec<_>>>()?;
    let document = json!({
        "smalti_version": env!("CARGO_PKG_VERSION"),
        "illuminant": args.illuminant,
        "exposure": conditions.exposure_as_json(),
        "differences": conditions.differences_as_json(),
        "cameras": entries,
    });
    let text = serde_json::to_string_pretty(&document)? + "\n";
    // All results are computed before the first file is written; results.json marks a complete folder.
    if let Some(dir) = &args.output {
        write::begin_folder(dir, &["results.json"])?;
        let white = Observer::Cie1931.white(&illuminant.photons(WavelengthGrid::VISIBLE)?)?;
        let page = evaluation_page(&Evaluations {
            command: &resolve::command_line(words, &args.cameras),
            cameras: &cameras,
            labels: &titles,
            conditions,
            luminances_cd_m2: &args.luminance,
            illuminant: &args.illuminant,
            white,
            seed: args.camera_options.seed,
            learned: !args.pipelines.is_empty(),
            results: &results,
            pictures: &shots,
        })?;
        let names = names::of_cameras(&cameras);
        let runs = names.iter().flat_map(|name| args.luminance.iter().map(move |cd_m2| (name, cd_m2)));
        for ((name, cd_m2), pictures) in runs.zip(&shots) {
            write_pictures(&dir.join(format!("{name}-{cd_m2}-cd-m2")), pictures)?;
        }
        write::bytes(&dir.join(PAGE), page.as_bytes())?;
        write::bytes(&dir.join("results.json"), text.as_bytes())?;
    }
    if args.json {
        return crate::output::print_document(&text);
    }
    let names = titles.iter().flat_map(|label| args.luminance.iter().map(move |_| label.as_str()));
    let scores: Vec<_> = names.zip(results.iter().map(|(_, scores)| scores)).collect();
    let scores = evaluation_text(&scores, &args.illuminant, !args.pipelines.is_empty(), &table::render);
    crate::print(&(conditions.text(&table::render) + "\n" + &scores))
}

/// `quality` is that of a learned pipeline.
fn entry(camera: &Camera, scores: &Evaluation, quality: Option<&str>) -> anyhow::Result<serde_json::Value> {
    let mut entry = json!({"camera": camera.description().name, "quality": quality});
    if let (Some(into), serde_json::Value::Object(scores)) =
        (entry.as_object_mut(), serde_json::to_value(scores)?)
    {
        into.extend(scores);
        into.insert("description".into(), serde_json::to_value(camera.description())?);
    }
    Ok(entry)
}

fn write_pictures(dir: &Path, pictures: &EvaluationPictures) -> anyhow::Result<()> {
    write::begin_folder(dir, &[])?;
    for (name, image) in
        [("macbeth", &pictures.macbeth), ("edge", &pictures.edge), ("zone-plate", &pictures.zone_plate)]
    {
        let shown = image.converted(ColorSpace::Srgb)?;
        picture::write_png(&dir.join(format!("{name}.png")), &shown, Depth::Eight)?;
    }
    picture::write_png(&dir.join("aliasing.png"), &aliasing_picture(pictures)?, Depth::Eight)?;
    Ok(())
}
