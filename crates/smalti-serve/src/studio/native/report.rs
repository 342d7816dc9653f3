//! The comparison of two designs as a page.

use smalti::camera::{Camera, ScoreSettings, TrainingSettings};
use smalti::experiment::{
    ComparisonSettings, ExposurePolicy, PipelineTask, Pipelines, Processing, Progress as _,
    compare_while_learning, contenders, light_notes, numbered, scene_lights, without_infrared,
};
use smalti::l3::Training;
use smalti_io::studio;
use smalti_io::test_scenes::{TestSet, scene_label, test_scene};
use smalti_report::comparison::{CameraArgument, CommandLine, Stated, page};
use smalti_report::names;

use super::capture::{LIGHT, SEED};
use super::design::camera;
use super::error::JobError;
use super::material::{Found, Native};
use super::message::Report;
use super::watch::Watch;

/// Noise realisations of each scene, as by default of the command.
const SEEDS: u64 = 3;

/// A comparison as by `smalti compare`.
pub(super) fn report(native: &Native, wanted: &Report, watch: &Watch) -> Result<Found, JobError> {
    let cameras: Vec<Camera> =
        std::iter::once(&wanted.design).chain(&wanted.rival).map(camera).collect::<Result<_, _>>()?;
    let labels = numbered(cameras.iter().map(|c| c.description().name.clone()).collect());
    let scenes = match &wanted.scene {
        None => TestSet::default().scenes(&LIGHT)?,
        Some(id) => vec![test_scene(studio::catalogue_name(id).ok_or(JobError::Broken)?, &LIGHT)?],
    };
    for (camera, label) in cameras.iter().zip(&labels) {
        let notes = light_notes(camera, &LIGHT.photons(camera.grid())?)?;
        notes.iter().for_each(|text| watch.note(&format!("{label}: {text}")));
    }
    without_infrared(&cameras, &scenes, &LIGHT)?.iter().for_each(|text| watch.note(text));
    let (processing, resources) = ([Processing::L3], native.resources(watch));
    let lights = scene_lights(&LIGHT, &scenes)?;
    let training = Training { quality: wanted.quality, ..Training::default() };
    let learning = (&TrainingSettings::default(), &training);
    let task = PipelineTask::learned((&cameras, &labels), learning, &lights);
    let learned = Pipelines::begin(task, resources)?;
    let (contenders, left_out) = contenders(&cameras, &labels, learned.sets(), &processing)?;
    let settings = ComparisonSettings {
        luminances_cd_m2: wanted.luminances_cd_m2.clone(),
        illuminant: LIGHT,
        scenes,
        seed: SEED,
        seed_count: SEEDS,
        score: ScoreSettings::default(),
        exposure: ExposurePolicy::default(),
    };
    let compared = compare_while_learning(&contenders, &learned, &settings, resources)?;
    watch.begin("writing");
    let files: Vec<String> =
        names::file_names(labels.iter().map(String::as_str)).into_iter().map(|n| n + ".toml").collect();
    let command = command(wanted, &files);
    let stated = Stated::new((&cameras, &labels), &contenders, &settings, scene_label)?;
    let comparison = stated.report(&command, &left_out, &compared);
    let said = serde_json::json!({"verdict": comparison.verdict_text()});
    Ok(Found { said, files: vec![("page", page(&comparison)?.into_bytes())] })
}

/// The command that makes the same page of the files of the cameras.
fn command(wanted: &Report, files: &[String]) -> CommandLine {
    let luminances: Vec<String> = wanted.luminances_cd_m2.iter().map(f64::to_string).collect();
    let scene = wanted.scene.as_deref().and_then(studio::catalogue_name);
    let mut words = vec!["compare".to_owned()];
    words.extend_from_slice(files);
    words.extend(["--luminance".to_owned(), luminances.join(",")]);
    words.extend(scene.into_iter().flat_map(|name| ["--scene".to_owned(), name.to_owned()]));
    if wanted.quality != Training::default().quality {
        words.extend(["--quality".to_owned(), wanted.quality.name().to_owned()]);
    }
    let cameras = files.iter().map(|word| CameraArgument { word: word.clone(), is_built_in: false });
    CommandLine { words, cameras: cameras.collect() }
}
