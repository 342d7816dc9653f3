//! `smalti report`: what a study found, as tables, a page, figures and one document.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use smalti::experiment::Progress as _;
use smalti_io::dataset::Dataset;
use smalti_io::sweeps::{read_results, read_trials};
use smalti_io::write;
use smalti_report::study::{DOCUMENT, PAGE, Report, ReportSettings, Results, camera_toml, figure_files};

use crate::args::Common;
use crate::progress::Progress;
use crate::table;

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti sweep table2 -o study && smalti report study   score a study, then tables and figures\n  \
    smalti report study theory -o both                    two studies: filters by rule and all filters\n  \
    smalti report study --json > study.json               all results as one JSON document\n  \
    smalti report study -o study.html                     only the page\n  \
    smalti report study --picture 4711,17                 embed the pictures of these trials\n  \
    smalti report study --draw 'f-number 2.8'             only the tables and figures of these conditions\n  \
    smalti report study --camera 4711 > found.toml        the design of a trial as a camera file for other commands\n\n\
    ΔE is the mean over the ColorChecker (CIELAB 1976), MTF50 that of a slanted edge in cycles/mm on the sensor, and noise that of the \
    luminance of grey patches in percent. For each number of colours, the best design has the least ΔE among the designs whose \
    MTF50 is at least the median; where only mosaics differ, it has the largest MTF50. A study whose first metric is another one ranks by it.\n\n\
    report.html is a single page that works offline, with interactive plots and a filter of the trials. Figures are written as SVG \
    and PNG. report.json is removed first and written last, so a folder that contains it is complete.")]
pub(crate) struct ReportArgs {
    /// Folders of results (smalti sweep), complete or not
    #[arg(required = true, value_name = "DIR")]
    pub(crate) results: Vec<PathBuf>,
    /// Folder for report.html, figures and report.json, created if needed; or FILE.html for the page only [default: report in the
    /// first DIR]
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: Option<PathBuf>,
    /// Number of trials with learned pipelines whose pictures are embedded in the page: the best, the worst, then those of the
    /// Pareto front
    #[arg(long, default_value_t = 16, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1000))]
    pub(crate) pictures: u16,
    /// Further trials of the first DIR, by number, whose pictures are embedded in the page
    #[arg(long, value_delimiter = ',', value_name = "TRIAL")]
    pub(crate) picture: Vec<u64>,
    /// Print tables and draw figures of the conditions and processing methods whose name in the tables contains TEXT; may be given
    /// more than once [default: tables of the first 3, figures of the first 8]
    #[arg(long, value_name = "TEXT")]
    pub(crate) draw: Vec<String>,
    /// Print only the camera file of a trial of the first DIR, by its number
    #[arg(long, value_name = "TRIAL", conflicts_with_all = ["output", "json"])]
    pub(crate) camera: Option<u64>,
    /// Print report.json instead of the tables
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &ReportArgs, common: &Common) -> anyhow::Result<()> {
    let first =
        args.results.first().context("no results are given; expected a folder that `smalti sweep` wrote")?;
    if let Some(number) = args.camera {
        return crate::print(&camera(first, number)?);
    }
    let page_alone =
        args.output.as_ref().filter(|o| o.extension().is_some_and(|e| e.eq_ignore_ascii_case("html")));
    let folder = args.output.clone().unwrap_or_else(|| first.join("report"));
    let progress = Progress::new(args.results.len() as u64 + 1, common.quiet);
    let mut studies = Vec::new();
    for dir in &args.results {
        progress.begin(&dir.display().to_string().replace(char::is_control, " "));
        studies.push(Results::new(read_results(dir)?)?);
        progress.done();
    }
    match page_alone {
        Some(file) => write::ensure_can_write(file)?,
        None => write::ensure_can_fill(&folder)?,
    }
    let settings = ReportSettings {
        pictures: usize::from(args.pictures),
        requested: args.picture.clone(),
        draw: args.draw.clone(),
    };
    let mut report = Report::new(&studies, &settings)?;
    let text = report.text(&table::render)?;
    progress.begin("page");
    let page = report.page(&progress)?;
    progress.done();
    let (document, written) = if let Some(file) = page_alone {
        write::bytes(file, page.as_bytes())?;
        (report.document()?, format!("See {}\n", file.display()))
    } else {
        progress.begin("figures");
        let mut files = write::Files::new(&folder, &[DOCUMENT, PAGE], &figure_files());
        let document = report.store(&page, &mut |name, bytes| Ok(files.write(name, bytes)?), &progress)?;
        let (count, folder) = (report.figure_count(), folder.display());
        (
            document,
            format!(
                "{count} figures are in {folder}, with all results in {folder}/{DOCUMENT}; see {folder}/{PAGE}\n"
            ),
        )
    };
    progress.finish();
    report.notes().iter().for_each(|note| progress.note(note));
    if args.json { crate::output::print_document(&document) } else { crate::print(&(text + &written)) }
}

/// The camera of a trial as TOML.
fn camera(dir: &Path, number: u64) -> anyhow::Result<String> {
    camera_toml(&read_trials(&Dataset::open(dir)?)?, number).with_context(|| dir.display().to_string())
}
