//! `smalti compare`: renders the same scenes with cameras and their learned pipelines.

use std::path::{Path, PathBuf};

use anyhow::ensure;
use clap::Args;
use smalti::camera::ScoreSettings;
use smalti::experiment::{ComparisonSettings, Progress as _, compare_while_learning, light_gains_to_first};
use smalti_io::comparisons::{self, ComparisonFiles, RESULTS};
use smalti_io::test_scenes::scene_label;
use smalti_report::comparison::{Comparison, PAGE, SIDE_BY_SIDE, Stated};

use crate::args::Common;
use crate::contest::{Contest, ContestOptions};
use crate::learning_args::LearningOptions;
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
    #[command(flatten)]
    pub(crate) contest: ContestOptions,
    /// Number of noise realisations of each scene, with seeds from --seed on. More of them narrow the intervals of the verdict a
    /// little
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub(crate) seeds: u64,
    /// Also measure for each metric the light gain: the additional light, in stops, with which the first camera matches each other
    /// camera, with the first processing method. Takes a minute or more for each camera and luminance
    #[arg(long)]
    pub(crate) light_gain: bool,
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

/// `words` are the command line, for the page.
pub(crate) fn run(args: &Compare, words: &[String], common: &Common) -> anyhow::Result<()> {
    ensure!(
        !args.light_gain || args.cameras.len() > 1,
        "--light-gain compares cameras; expected two or more"
    );
    let options = &args.contest;
    let seed = options.camera_options.seed;
    let (cache, progress) = (resolve::cache(options.no_cache)?, Progress::new(0, common.quiet));
    let resources = args.learning.resources(&cache, &progress);
    let contest = options.resolve(&args.cameras, &args.learning, &args.output, resources, common)?;
    let Contest { cameras, labels, .. } = &contest;
    let (contenders, left_out) = contest.contenders(&options.processing, &progress)?;
    let settings = ComparisonSettings {
        luminances_cd_m2: options.luminance.clone(),
        illuminant: contest.illuminant.clone(),
        scenes: contest.scenes.clone(),
        seed,
        seed_count: args.seeds,
        score: ScoreSettings::default(),
        exposure: options.exposure.policy(),
    };
    let compared = compare_while_learning(&contenders, &contest.pipelines, &settings, resources)?;
    let gains = if args.light_gain {
        light_gains_to_first(&contenders, &settings, &compared.exposure, &progress)?
    } else {
        Vec::new()
    };
    let stated = Stated::new((cameras, labels), &contenders, &settings, scene_label)?;
    let stated = stated.with_illuminant(&options.illuminant);
    let command = resolve::command_line(words, &args.cameras);
    let report = stated.report(&command, &left_out, &compared);
    let report = Comparison { gains: &gains, ..report };
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
        report.conditions.text(&table::render),
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
