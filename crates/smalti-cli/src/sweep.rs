//! `smalti sweep`: scores the trials of a study and writes the results in parts.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use clap::Args;
use serde_json::json;
use smalti::camera::OpticalImages;
use smalti::design::{LearningSettings, LearningStatistics, Study, Sweep, TrialProcessing, Trials};
use smalti::names::in_one_line;
use smalti_io::dataset::{self, ColumnKind, Plan, Shard};
use smalti_io::studies::{self, LoadedStudy};
use smalti_io::sweeps::{self, SweepRun, SweepSummary};
use smalti_report::names;

use crate::args::Common;
use crate::output::{note, tell};
use crate::progress::Progress;
use crate::resolve;
use crate::table;
use smalti::experiment::Progress as _;

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti sweep table2 -o study && smalti report study   score 5000 trials and report them\n  \
    smalti sweep my-study.toml -o mine                    your own study; repeat the command to resume\n  \
    smalti sweep my-study.toml --dry-run                  number of trials, duration, size and folder\n  \
    smalti sweep my-study.toml --shard 3/16 -o mine       one of sixteen machines with a shared folder\n  \
    smalti sweep --merge part1 part2 -o mine              merge the folders of shards\n\n\
    DIR/trials/*.parquet has a row for each trial; pandas, Polars and DuckDB read it directly.")]
pub(crate) struct SweepArgs {
    /// A built-in study (smalti list studies), a TOML file, or the manifest.json of its results
    #[arg(required_unless_present = "merge", conflicts_with = "merge")]
    pub(crate) study: Option<String>,
    /// Folder for the results, created if needed; an incomplete study in it is resumed [default: a folder here with the name of the
    /// study]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Score only the I-th of N shards of the study
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    /// Trials per file of results; an interrupted run loses at most two files [default: by the size of the study]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=dataset::MAX_CHUNK))]
    pub(crate) part_size: Option<u64>,
    /// Print the number of trials, the expected duration and the size of the results; write nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Measure how many trials per second this machine scores; write nothing
    #[arg(long, conflicts_with = "dry_run")]
    pub(crate) benchmark: bool,
    /// Merge the results of shards that ran in separate folders into the folder of -o
    #[arg(long, value_name = "DIR", num_args = 1.., requires = "output", conflicts_with_all = ["shard", "dry_run", "benchmark"])]
    pub(crate) merge: Vec<PathBuf>,
    /// Do not use the cache of optical images
    #[arg(long)]
    pub(crate) no_cache: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// The exit code after Ctrl-C, as shells define it.
const STOPPED: i32 = 130;

pub(crate) fn run(args: &SweepArgs, common: &Common) -> anyhow::Result<()> {
    if !args.merge.is_empty() {
        let output = args.output.as_ref().context("--merge needs the folder of the result: -o DIR")?;
        dataset::merge(&args.merge, output)?;
        return crate::print(&format!(
            "{} contains the results of {} folders\n",
            output.display(),
            args.merge.len()
        ));
    }
    let Some(name) = &args.study else {
        bail!("expected a built-in study (smalti list studies) or a TOML file")
    };
    let LoadedStudy { trials, about, notes } = studies::load_with_notes(name).map_err(anyhow::Error::from)?;
    notes.iter().for_each(|text| note(text, common));
    let output = args.output.clone().unwrap_or_else(|| folder_of(&trials.study().name));
    let cache = resolve::cache(args.no_cache)?;
    let images = |key: &str, make: &dyn Fn() -> _| cache.optical_image(key, make);
    let sweep = Sweep::new(&trials, &images);
    if args.dry_run {
        let plan = sweeps::plan(&trials, about, args.part_size, &output)?;
        return dry_run(args, &output, &trials, &plan, &sweep);
    }
    if args.benchmark {
        return benchmark(args, &trials, &images);
    }
    let run = SweepRun::open(&trials, about, args.part_size, &output, args.shard)?;
    let to_do = run.trials();
    let progress = Progress::new(0, common.quiet);
    progress.begin(&trials.study().name);
    if args.output.is_none() && !common.quiet {
        progress.note(&format!(
            "the results are written to the folder {}; -o DIR chooses another",
            output.display()
        ));
    }
    if to_do < trials.len() && args.shard.is_none() {
        progress.note(&format!("{} of {} trials are already scored", trials.len() - to_do, trials.len()));
    }
    for (colors, _, _) in trials.groups().filter(|&(_, sets, mosaics)| sets == 0 || mosaics == 0) {
        progress.note(&format!("the study has no design of {colors} colours"));
    }
    if !common.quiet {
        stops_resumably(&output, "the study")?;
    }
    let SweepSummary { scored, seconds, parts_missing } = run.run(&sweep, &progress)?;
    progress.finish();
    let rate = if seconds > 0.0 { scored as f64 / seconds } else { 0.0 };
    let done = match scored {
        0 => "nothing was left to do".to_owned(),
        n => format!("{n} trials in {seconds:.1} s ({rate:.0} per second)"),
    };
    let dir = output.display();
    if args.json {
        let document = json!({
            "study": trials.study().name, "output": output, "trials": trials.len(), "scored": scored,
            "seconds": seconds, "trials_per_s": rate, "parts_missing": parts_missing,
        });
        return crate::output::print_json(&document);
    }
    let next = if parts_missing == 0 {
        format!("{dir} is complete; `smalti report {dir}` reports it")
    } else {
        format!("{dir} lacks {parts_missing} parts of other shards")
    };
    crate::print(&format!("{done}; {next}\n"))
}

/// The folder of a study's results where none is given: a folder here with the name of the study, as far as it can be a name of a file.
fn folder_of(study: &str) -> PathBuf {
    let name = names::file_names(std::iter::once(study)).concat();
    PathBuf::from(if name.is_empty() { "study" } else { &name })
}

/// Reports on Ctrl-C how to resume. Every part on disk is complete, so the program can end at any moment.
pub(crate) fn stops_resumably(output: &Path, what: &'static str) -> anyhow::Result<()> {
    let dir = in_one_line(&output.display().to_string()).into_owned();
    ctrlc::set_handler(move || {
        tell(&format!("\nstopped; {dir} keeps the results so far, and the same command resumes {what}"));
        std::process::exit(STOPPED);
    })
    .context("listening for Ctrl-C")
}

/// Scores trials from all of the study for about `time`; the number scored, and trials per second.
fn rate(trials: &Trials, sweep: &Sweep<'_>, time: Duration) -> anyhow::Result<(u64, f64)> {
    let of_first = trials.end_of_condition(0).min(trials.len());
    // Trials are ordered by number of colours: equal steps sample all of them.
    let numbers = |part: u64, done: u64| -> Vec<u64> {
        let stride = (of_first / part).max(1);
        (0..part).map(|i| (i * stride + done % stride).min(of_first - 1)).collect()
    };
    // The preparation of a study and of its mosaics is not part of the rate.
    sweep.score_numbers(&numbers(of_first.min(16), 0), &|| true)?;
    let (start, mut done, mut size) = (Instant::now(), 0, 32);
    loop {
        let part = size.min(of_first);
        sweep.score_numbers(&numbers(part, done), &|| true)?;
        done += part;
        let elapsed = start.elapsed();
        if elapsed >= time {
            return Ok((done, done as f64 / elapsed.as_secs_f64()));
        }
        size = (size * 2).min(4096);
    }
}

fn dry_run(
    args: &SweepArgs,
    output: &Path,
    trials: &Trials,
    plan: &Plan,
    sweep: &Sweep<'_>,
) -> anyhow::Result<()> {
    let (_, per_s) = rate(trials, sweep, Duration::from_secs(1)).context("scoring some trials")?;
    let study = trials.study();
    let own = (0..plan.chunks()).filter(|&c| args.shard.is_none_or(|s| s.owns(c)));
    let to_do = plan.trials_in(own);
    let (colors, count) = trials.groups().fold((0, 0), |(c, n), (colors, sets, mosaics)| {
        let here = sets * mosaics as u64;
        (c + colors as u64 * here, n + here)
    });
    let mean_colors = colors as f64 / count.max(1) as f64;
    let bytes = |kind: ColumnKind| match kind {
        ColumnKind::Int => 1.5,
        ColumnKind::Float => 8.0,
        ColumnKind::Text => 1.5,
        ColumnKind::Floats => 2.0 * mean_colors,
    };
    let megabytes = to_do as f64 * plan.schema.iter().map(|c| bytes(c.kind)).sum::<f64>() * 1e-6;
    let seconds = to_do as f64 / per_s;
    if args.json {
        let groups: Vec<_> = trials
            .groups()
            .map(|(colors, sets, mosaics)| json!({"colors": colors, "filter_sets": sets, "mosaics": mosaics}))
            .collect();
        let document = json!({
            "study": study.name, "trials": to_do, "groups": groups, "conditions": study.conditions.len(),
            "processing": study.processing, "parts": plan.chunks(), "trials_per_part": plan.chunk,
            "trials_per_s": per_s, "seconds": seconds, "megabytes": megabytes,
        });
        return crate::output::print_json(&document);
    }
    let mut out = format!("{}\n\n", in_one_line(&study.name));
    let row = |(colors, sets, mosaics): (usize, u64, usize)| {
        vec![colors.to_string(), sets.to_string(), mosaics.to_string(), (sets * mosaics as u64).to_string()]
    };
    let rows: Vec<_> = trials.groups().map(row).collect();
    out += &table::render(&["colours", "filter sets", "mosaics", "designs"], &rows);
    let with: Vec<String> = study.processing.iter().map(|p| p.name().to_owned()).collect();
    let conditions = match study.conditions.len() {
        1 => "one condition".to_owned(),
        n => format!("each trial under {n} conditions"),
    };
    out += &format!(
        "\n{to_do} trials to score ({conditions}), with {} processing\n\
         {} files of at most {} trials, about {megabytes:.1} MB, in the folder {}\n\
         about {} at {per_s:.0} trials per second (measured now)\n",
        with.join(" and "),
        plan.chunks(),
        plan.chunk,
        output.display(),
        duration(seconds),
    );
    crate::print(&out)
}

fn benchmark(args: &SweepArgs, trials: &Trials, images: OpticalImages<'_>) -> anyhow::Result<()> {
    let threads = rayon::current_num_threads();
    let study = trials.study();
    let time = Duration::from_secs(5);
    // Studies with learned pipelines are measured with both ways of learning, their own first.
    let mut measured = vec![(None, rate(trials, &Sweep::new(trials, images), time)?)];
    if study.processing.contains(&TrialProcessing::L3) {
        measured[0].0 = Some(study.l3.statistics);
        let other = match study.l3.statistics {
            LearningStatistics::Patches => LearningStatistics::Light,
            LearningStatistics::Light => LearningStatistics::Patches,
        };
        let l3 = LearningSettings { statistics: other, ..study.l3.clone() };
        let others = Trials::new(Study { l3, ..study.clone() })?;
        let sweep = Sweep::new(&others, images);
        // Cameras that this way of learning cannot serve have no rate of it.
        if sweep.score(0..1, &|| true).is_ok_and(|scored| scored.iter().all(|s| s.scores.is_ok())) {
            measured.push((Some(other), rate(&others, &sweep, time)?));
        }
    }
    if args.json {
        let rates: Vec<_> = measured
            .iter()
            .map(|(statistics, (done, per_s))| {
                json!({"statistics": statistics, "trials": done, "trials_per_s": per_s})
            })
            .collect();
        let (done, per_s) = measured[0].1;
        let document = json!({
            "study": study.name, "trials": done, "trials_per_s": per_s, "threads": threads, "rates": rates,
        });
        return crate::output::print_json(&document);
    }
    for (statistics, (done, per_s)) in measured {
        let learned = match statistics {
            Some(LearningStatistics::Patches) => ", pipelines learned from patches",
            Some(LearningStatistics::Light) => ", pipelines learned from statistics of light",
            None => "",
        };
        crate::print(&format!(
            "{per_s:.0} trials per second on {threads} threads ({done} trials with all scenes, noise and metrics; nothing \
             written{learned})\n"
        ))?;
    }
    Ok(())
}

/// A duration in seconds, minutes or hours.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{s:.1} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
