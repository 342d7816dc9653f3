//! `smalti rate analyse`: scales the answers and compares them with the metrics.

use std::path::PathBuf;

use anyhow::{bail, ensure};
use clap::Args;
use smalti::camera::PICTURE_METRICS;
use smalti::metrics::{Better, metric_info};
use smalti::rating::{ObserverChoices, Question, equality, scale, screen};
use smalti_io::ratings::{self, Manifest, Observer};
use smalti_io::write;
use smalti_report::rating::{PAGE, RatedObserver, RatingReport, RatingResult, page};

use crate::table;

/// The folder of the results within that of the experiment.
const ANALYSIS: &str = "analysis";
const RESULTS: &str = "results.json";

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti rate analyse trial\n  \
    smalti rate analyse trial --json\n  \
    smalti rate analyse trial --keep-all\n\n\
    Scores are those of Thurstone's Case V in JOD (of two conditions that differ by 1 JOD, 75 % of the choices prefer the better one) and of the \
    model of Bradley and Terry, by maximum likelihood with Jeffreys' prior. Intervals of 95 % resample observers, from five of them on. Observers are \
    left out who fail traps, contradict themselves on hidden repeats or whose choices the others do not explain.\n\n\
    An experiment with --stops has a psychometric function instead, with the light at which both cameras look alike.\n\n\
    Output files, in DIR/analysis: report.html, a page of all results; scale.csv; answers.csv, every answer; and results.json, which is removed \
    first and written last.")]
pub(crate) struct Analyse {
    /// Folder of an experiment with answers (smalti rate serve)
    pub(crate) folder: PathBuf,
    /// Keep all observers
    #[arg(long)]
    pub(crate) keep_all: bool,
    /// Print results.json instead of the tables
    #[arg(long)]
    pub(crate) json: bool,
}

pub(super) fn run(args: &Analyse) -> anyhow::Result<()> {
    let manifest = ratings::read(&args.folder, false)?;
    let observers = ratings::read_observers(&args.folder, &manifest)?;
    let answered = |o: &Observer| o.trials.iter().filter(|t| t.answer.is_some()).count();
    if !observers.iter().any(|o| answered(o) > 0) {
        bail!("{}: it has no answers yet; smalti rate serve {0} records them", args.folder.display());
    }
    let choices: Vec<ObserverChoices> = observers.iter().map(|o| ratings::choices(&manifest, o)).collect();
    let rated: Vec<RatedObserver> = observers
        .iter()
        .zip(&choices)
        .zip(screen(&choices))
        .map(|((observer, choices), screening)| RatedObserver {
            number: observer.number,
            answered: [answered(observer), manifest.schedule.trials()],
            choices: choices.clone(),
            is_kept: choices.scenes.iter().any(|s| s.total() > 0.0)
                && (args.keep_all || screening.reasons.is_empty()),
            screening,
            device_pixel_ratio: observer.display.device_pixel_ratio,
            gamma: observer.display.gamma,
        })
        .collect();
    let kept: Vec<&ObserverChoices> = rated.iter().filter(|o| o.is_kept).map(|o| &o.choices).collect();
    ensure!(
        !kept.is_empty(),
        "{}: no observer with ratings is left after screening; --keep-all leaves out nobody who has rated",
        args.folder.display()
    );
    let result = match manifest.question {
        Question::Scale => scaled(&manifest, &kept),
        Question::Light { standard } => light(&manifest, &kept, standard),
    };
    let conditions: Vec<String> = manifest.conditions.iter().map(|c| c.name.clone()).collect();
    let scenes: Vec<String> = manifest.scenes.iter().map(|s| s.name.clone()).collect();
    let folder = args.folder.display().to_string();
    let report = RatingReport {
        title: &manifest.title,
        command: &manifest.command,
        folder: &folder,
        conditions: &conditions,
        scenes: &scenes,
        observers: &rated,
        result: &result,
    };
    let text = serde_json::to_string_pretty(&report.document()?)? + "\n";
    let dir = args.folder.join(ANALYSIS);
    let mut files = write::Files::new(&dir, &[RESULTS], &[]);
    files.write(PAGE, page(&report).as_bytes())?;
    files.write("scale.csv", report.csv().as_bytes())?;
    ratings::write_table(&dir.join("answers.csv"), &manifest, &observers)?;
    files.write(RESULTS, text.as_bytes())?;
    if args.json {
        return crate::output::print_document(&text);
    }
    crate::print(&format!(
        "{}\nsee {}; all results are in {}\n",
        report.text(&table::render),
        dir.join(PAGE).display(),
        dir.join(RESULTS).display()
    ))
}

/// The scales, and the agreement with each metric of the pictures.
fn scaled(manifest: &Manifest, kept: &[&ObserverChoices]) -> RatingResult {
    let scales = scale(kept, manifest.conditions.len(), manifest.seed);
    let mut names: Vec<&String> = Vec::new();
    for picture in manifest.scenes.iter().flat_map(|s| &s.pictures) {
        names.extend(picture.metrics.keys().filter(|name| !names.contains(name)).collect::<Vec<_>>());
    }
    // Those of the pictures first.
    let place =
        |name: &&String| PICTURE_METRICS.iter().position(|m| m == name).unwrap_or(PICTURE_METRICS.len());
    names.sort_by_key(place);
    let agreement = |name: &&String| {
        let sign = match metric_info(name).map(|info| info.better) {
            Ok(Better::Lower) => -1.0,
            _ => 1.0,
        };
        let value = |p: &ratings::PictureFile| p.metrics.get(*name).map_or(f64::NAN, |v| sign * v);
        let values: Vec<Vec<f64>> =
            manifest.scenes.iter().map(|s| s.pictures.iter().map(value).collect()).collect();
        ((*name).clone(), scales.agreement(&values, manifest.seed))
    };
    let agreement = names.iter().map(agreement).collect();
    RatingResult::Scale { agreement, scales }
}

/// The light at which the varied camera looks like the standard.
fn light(manifest: &Manifest, kept: &[&ObserverChoices], standard: usize) -> RatingResult {
    let levels: Vec<Vec<_>> = kept.iter().map(|c| ratings::levels(manifest, c)).collect();
    let mut all = levels.first().cloned().unwrap_or_default();
    for own in levels.iter().skip(1) {
        for (sum, level) in all.iter_mut().zip(own) {
            sum.chosen += level.chosen;
            sum.asked += level.asked;
        }
    }
    let varied = manifest.levels().first().and_then(|c| manifest.conditions.get(*c));
    RatingResult::Light {
        varied: varied.map_or_else(String::new, |c| format!("{} {}", c.camera, c.processing)),
        standard: manifest.conditions.get(standard).map_or_else(String::new, |c| c.name.clone()),
        fit: equality(&levels, manifest.seed),
        levels: all,
    }
}
