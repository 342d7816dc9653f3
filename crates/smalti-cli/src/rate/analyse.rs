//! `smalti rate analyse`: scales the answers and compares them with the metrics.

use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use smalti::experiment::{ExperimentError, analyse_ratings};
use smalti_io::ratings;
use smalti_io::write;
use smalti_report::rating::{PAGE, RatingReport, page};

use crate::table;

/// The folder of the results within that of the experiment.
const ANALYSIS: &str = "analysis";
const RESULTS: &str = "results.json";

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti rate analyse trial\n  \
    smalti rate analyse trial --json\n  \
    smalti rate analyse trial --keep-all\n\n\
    Scores are just-objectionable differences (JOD) by Thurstone's Case V: of two conditions that differ by 1 JOD, 75 % of the choices prefer \
    the better one. The model of Bradley and Terry is fitted as well. Both fits maximise the likelihood with Jeffreys' prior. With five observers or \
    more, intervals of 95 % resample the observers. Observers are excluded who fail traps, contradict themselves on hidden repeats, or whose choices are \
    improbable given those of all others.\n\n\
    An experiment with --stops has a psychometric function instead, which states the light at which both cameras look alike.\n\n\
    Output files, in DIR/analysis: report.html, a page of all results; scale.csv, the scores; agreement.csv, the rank correlations of the metrics with \
    the observers; for an experiment with --stops instead light.csv, the light of equal appearance, and levels.csv, the choices in each amount of \
    light; answers.csv, every answer; and results.json, which is removed first and written last.")]
pub(crate) struct Analyse {
    /// Folder of an experiment with answers (smalti rate serve)
    pub(crate) folder: PathBuf,
    /// Keep all observers who have rated
    #[arg(long)]
    pub(crate) keep_all: bool,
    /// Print results.json instead of the tables
    #[arg(long)]
    pub(crate) json: bool,
}

pub(super) fn run(args: &Analyse) -> anyhow::Result<()> {
    let manifest = ratings::read(&args.folder, false)?;
    let observers = ratings::read_observers(&args.folder, &manifest)?;
    let answers = manifest.answers(&observers);
    let folder = args.folder.display().to_string();
    let analysis = analyse_ratings(&answers, args.keep_all).map_err(|e| match e {
        ExperimentError::NoObserver => anyhow!("{folder}: {e} (--keep-all)"),
        _ => anyhow!("{folder}: {e}"),
    })?;
    let report =
        RatingReport { command: &manifest.command, folder: &folder, answers: &answers, analysis: &analysis };
    let text = serde_json::to_string_pretty(&report.document()?)? + "\n";
    let dir = args.folder.join(ANALYSIS);
    let mut files = write::Files::new(&dir, &[RESULTS], &[]);
    files.write(PAGE, page(&report).as_bytes())?;
    for (name, table) in report.tables() {
        files.write(name, table.as_bytes())?;
    }
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
