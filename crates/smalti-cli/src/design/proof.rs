//! `smalti design --prove`: the array that was found and its rivals with learned pipelines, on scenes that were not used.

use std::path::Path;

use anyhow::{Context, bail};
use serde::Deserialize;
use serde_json::{Value, json};
use smalti::camera::{Camera, ScoreSettings, TestScene, TrainingSettings};
use smalti::design::search::{FilterSpace, SearchSettings};
use smalti::experiment::{
    ComparisonSettings, Entrant, ExposurePolicy, PipelineTask, Processing, Proof, Resources, RobustnessRow,
    RobustnessScenes, compare, contenders, numbered, pipelines, prove, robustness, robustness_cases,
    scene_lights,
};
use smalti::l3::Training;
use smalti::spectrum::Illuminant;
use smalti_io::comparisons::{self, ComparisonFiles};
use smalti_io::test_scenes::{TestSet, scene_label, test_scene};
use smalti_io::{cameras, memory, text, write};
use smalti_report::comparison::{CameraArgument, CommandLine, PAGE, SIDE_BY_SIDE, Stated};
use smalti_report::design::{Proved, proof_text};
use smalti_report::page::Markup;

use super::args::DesignArgs;
use super::page;
use crate::args::{Common, word_of};
use crate::numbers::ensure_distinct;
use crate::progress::Progress;
use crate::resolve;
use crate::table;

/// Everything that a search found.
pub(super) const RESULTS: &str = "results.json";
/// The camera with its own array.
pub(super) const OWN: &str = "own.toml";
/// The folder of the proof and of its comparison with pictures.
const PROOF: &str = "proof";
const COMPARISON: &str = "comparison";
/// Bytes of the crops on the page of a design.
const CROP_BYTES: usize = 2_500_000;

/// What a proof needs of the results of a search.
#[derive(Debug, Deserialize)]
struct Found {
    name: String,
    illuminants: Vec<Illuminant>,
    family: FilterSpace,
    search: SearchSettings,
    own: Own,
    rivals: Vec<Named>,
}

#[derive(Debug, Deserialize)]
struct Own {
    expected: Vec<Condition>,
}

#[derive(Debug, Deserialize)]
struct Condition {
    luminance_cd_m2: f64,
}

#[derive(Debug, Deserialize)]
struct Named {
    name: String,
}

/// The folder of a finished search as the argument of the command.
pub(super) fn of_finished(dir: &Path, args: &DesignArgs, common: &Common) -> anyhow::Result<()> {
    if !args.proof.prove {
        bail!("{}: it is the folder of a finished search; expected a design, or --prove", dir.display());
    }
    run(dir, args, common)
}

/// Proves the design in a folder.
pub(super) fn run(dir: &Path, args: &DesignArgs, common: &Common) -> anyhow::Result<()> {
    let options = &args.proof;
    ensure_distinct("--proof-patch", &options.proof_patch)?;
    ensure_distinct("--proof-scene", &options.scenes)?;
    let results = dir.join(RESULTS);
    let text = text::read_to_string(&results)
        .with_context(|| format!("{}: it has no results of a search", dir.display()))?;
    let document: Value = serde_json::from_str(&text).with_context(|| results.display().to_string())?;
    let found: Found = serde_json::from_value(document.clone())
        .with_context(|| format!("{}: search again with this version", results.display()))?;
    let entrants = entrants(dir, &found, options.rivals)?;
    let (winner, others) = entrants.split_first().context("there is no camera")?;
    let illuminant = found.illuminants.first().context("the search has no illuminant")?;
    // Those under one illuminant; the robustness table has others.
    let count = found.own.expected.len() / found.illuminants.len();
    let luminances_cd_m2 = found.own.expected.iter().take(count).map(|c| c.luminance_cd_m2).collect();
    let settings = ComparisonSettings {
        luminances_cd_m2,
        illuminant: illuminant.clone(),
        scenes: scenes(args, illuminant)?,
        seed: found.search.seed,
        seed_count: options.seeds,
        score: ScoreSettings::default(),
        exposure: ExposurePolicy::Own,
    };
    let proof_dir = dir.join(PROOF);
    write::ensure_can_fill(&proof_dir)?;
    let cache = resolve::cache(options.no_cache)?;
    let progress = Progress::new(0, common.quiet);
    let resources = Resources {
        store: &cache,
        training_scenes: args.learning.training_set.stored(),
        progress: &progress,
        memory_bytes: memory::available_bytes(),
    };
    let training = args.learning.training();
    let learning = |side: usize| TrainingSettings { side, ..args.learning.settings(found.search.seed) };
    let mut proofs = Vec::new();
    for &side in &options.proof_patch {
        proofs.push(prove(winner, others, &settings, (&learning(side), &training), resources)?);
    }
    // The first other one is the camera's own array.
    let rival = others.get(1).or(others.first()).context("there is no rival")?;
    let side = options.proof_patch.first().copied().unwrap_or(args.learning.patch);
    let learning = learning(side);
    let rows = if options.no_robustness {
        Vec::new()
    } else {
        let under = |illuminant: &Illuminant| relit(args, illuminant);
        let is_natural = options.scenes.is_empty() && options.set != TestSet::Charts;
        let other = is_natural.then(|| ("charts".to_owned(), TestScene::charts()));
        let scenes = RobustnessScenes { under: &under, other };
        let clear = found.family.clear();
        let cases = robustness_cases(winner, rival, &settings, clear, scenes)?;
        robustness(&cases, (&learning, &training), resources)?
    };
    let pictured: Vec<&Entrant> = match others.get(1) {
        Some(rival) => vec![winner, rival, &others[0]],
        None => vec![winner, rival],
    };
    write::begin_folder(&proof_dir, &[RESULTS])?;
    let command = comparison_command(&pictured, &settings, args);
    let crops = pictures(
        &pictured,
        &settings,
        (&learning, &training),
        resources,
        (&proof_dir.join(COMPARISON), &command),
    )?;
    progress.finish();
    let document_of_proof = proof_document(&found.name, &proofs, &rows, &rival.label)?;
    let text = serde_json::to_string_pretty(&document_of_proof)? + "\n";
    write::bytes(&proof_dir.join(RESULTS), text.as_bytes())?;
    let proved = Proved {
        proofs: &proofs,
        robustness: &rows,
        rival: &rival.label,
        crops,
        comparison: &format!("{PROOF}/{COMPARISON}/{PAGE}"),
    };
    page::write(dir, &document, Some(&proved))?;
    if args.json {
        return crate::output::print_document(&text);
    }
    crate::print(&format!(
        "{}\n{} has the figures; see {}, and {} for the pictures\n",
        proof_text(&proved, &table::render),
        proof_dir.join(RESULTS).display(),
        dir.join(page::PAGE).display(),
        proof_dir.join(COMPARISON).join(PAGE).display(),
    ))
}

/// The array that was found, the camera's own, and the best published ones.
fn entrants(dir: &Path, found: &Found, most: Option<usize>) -> anyhow::Result<Vec<Entrant>> {
    let camera = |file: &str| -> anyhow::Result<Camera> {
        let path = dir.join(file);
        let loaded = cameras::load_with_notes(&path.to_string_lossy(), &[], None);
        Ok(loaded.map_err(anyhow::Error::from)?.camera)
    };
    let own = camera(OWN)?;
    let own_label = format!("{} (own)", own.description().name);
    let mut all = vec![(found.name.clone(), camera("camera.toml")?), (own_label, own)];
    for Named { name } in found.rivals.iter().take(most.unwrap_or(usize::MAX)) {
        all.push((name.clone(), camera(&format!("rivals/{name}.toml"))?));
    }
    let (labels, cameras): (Vec<String>, Vec<Camera>) = all.into_iter().unzip();
    Ok(numbered(labels).into_iter().zip(cameras).map(|(label, camera)| Entrant::new(label, camera)).collect())
}

/// The scenes of the command line, else those of the set.
fn scenes(args: &DesignArgs, illuminant: &Illuminant) -> anyhow::Result<Vec<TestScene>> {
    let options = &args.proof;
    if options.scenes.is_empty() {
        return Ok(options.set.scenes(illuminant)?);
    }
    Ok(options.scenes.iter().map(|name| test_scene(name, illuminant)).collect::<Result<_, _>>()?)
}

/// Those that can be relit.
fn relit(args: &DesignArgs, illuminant: &Illuminant) -> anyhow::Result<Vec<TestScene>> {
    Ok(scenes(args, illuminant)?.into_iter().filter(|s| !s.keeps_light()).collect())
}

/// The command that makes the comparison with pictures again.
fn comparison_command(
    pictured: &[&Entrant],
    settings: &ComparisonSettings,
    args: &DesignArgs,
) -> CommandLine {
    // Words that stand for the files of the cameras.
    let files: Vec<String> = pictured.iter().map(|e| format!("{}.toml", e.label)).collect();
    let joined = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    let mut words = vec!["compare".to_owned()];
    words.extend(files.iter().cloned());
    words.push(format!("--luminance={}", joined(&settings.luminances_cd_m2)));
    words.push(format!("--illuminant={}", settings.illuminant.name()));
    words.push(format!("--patch={}", args.proof.proof_patch.first().unwrap_or(&args.learning.patch)));
    words.push(format!("--seed={}", settings.seed));
    words.push(format!("--seeds={}", settings.seed_count));
    words.push("--exposure=own".into());
    match args.proof.scenes.is_empty() {
        true => {
            words.push(format!("--scenes={}", word_of(&TestSet::NAMED, &args.proof.set).unwrap_or_default()))
        }
        false => words.extend(args.proof.scenes.iter().map(|scene| format!("--scene={scene}"))),
    }
    let cameras = files.into_iter().map(|word| CameraArgument { word, is_built_in: false }).collect();
    CommandLine { words, cameras }
}

/// Compares cameras as `smalti compare` does, writes the folder of the comparison, and returns its crops for the page of the design.
fn pictures(
    entrants: &[&Entrant],
    settings: &ComparisonSettings,
    (learning, training): (&TrainingSettings, &Training),
    resources: Resources<'_>,
    (dir, command): (&Path, &CommandLine),
) -> anyhow::Result<Markup> {
    let cameras: Vec<Camera> = entrants.iter().map(|e| e.camera.clone()).collect();
    let labels: Vec<String> = entrants.iter().map(|e| e.label.clone()).collect();
    let lights = scene_lights(&settings.illuminant, &settings.scenes)?;
    let processing = [Processing::L3];
    let task = PipelineTask::learned((&cameras, &labels), (learning, training), &lights);
    let sets = pipelines(task, resources)?;
    let (contenders, left_out) = contenders(&cameras, &labels, &sets, &processing)?;
    let compared = compare(&contenders, settings, resources)?;
    let stated = Stated::new((&cameras, &labels), &contenders, settings, scene_label)?;
    let report = stated.report(command, &left_out, &compared);
    resources.progress.begin("writing");
    let text = serde_json::to_string_pretty(&report.document()?)? + "\n";
    let content = ComparisonFiles {
        page: PAGE,
        pictures: SIDE_BY_SIDE,
        files: &report.files(),
        tables: &report.tables(),
        document: &text,
    };
    comparisons::write(dir, &content, |store| {
        Ok::<_, anyhow::Error>(report.draw(&mut |name, content| Ok(store(name, content)?))?)
    })?;
    Ok(report.telling_crops(CROP_BYTES)?)
}

fn proof_document(
    name: &str,
    proofs: &[Proof],
    rows: &[RobustnessRow],
    rival: &str,
) -> anyhow::Result<Value> {
    Ok(json!({
        "smalti_version": env!("CARGO_PKG_VERSION"),
        "name": name,
        "metrics": smalti::camera::PICTURE_METRICS,
        "beats_all": proofs.iter().all(Proof::beats_all),
        "proofs": serde_json::to_value(proofs)?,
        "robustness": { "rival": rival, "rows": serde_json::to_value(rows)? },
    }))
}
