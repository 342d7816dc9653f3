//! `smalti design`: finds the best filters and mosaic and writes the camera with them.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use clap::Args;
use serde_json::{Value, json};
use smalti::design::Design;
use smalti::design::light::{LightClasses, LightSettings, LightStatistics};
use smalti::design::screen::{ExpectedError, Figures, FilterResponses, Screen, ScreenCondition};
use smalti::experiment::{
    DesignTask, DesignedCfa, Designs, Learned, Resources, TrainingSources, design, learn, light_statistics,
};
use smalti::sensor::Mosaic;
use smalti::spectrum::Spectrum;
use smalti_io::designs::{self, LoadedDesign};
use smalti_io::{l3, memory, spectrum_csv, write};
use smalti_report::Figure;

use crate::args::Common;
use crate::learning_args::LearningOptions;
use crate::output::note;
use crate::progress::Progress;
use crate::table;

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti design pigments-4 -o best                       the best four filters of pigments in 2 × 2\n  \
    smalti compare best/camera.toml bayer --luminance 1,10,80   what they are worth on scenes that were not used\n  \
    smalti design my-design.toml -o mine                   your own camera, pigments, light (smalti list design-keys)\n  \
    smalti design --benchmark                              colour filter arrays that this machine screens per second\n\n\
    The search minimises the expected error of the best linear pipeline in closed form. It needs the statistics of the light on the \
    pixels, from the scenes that pipelines learn from, and simulates no picture. The printed figures are such expectations: they rank \
    colour filter arrays as learned pipelines do and are not their scores. DIR holds the camera with the array that was found \
    (camera.toml, filters.csv, mosaic.svg, camera.l3), the published mosaics with the best filters of the same kind (rivals/) and results.json.")]
pub(crate) struct DesignArgs {
    /// A built-in design (smalti list designs) or a TOML file
    #[arg(required_unless_present = "benchmark", conflicts_with = "benchmark")]
    pub(crate) design: Option<String>,
    /// Folder for the results, created if needed
    #[arg(short, long, default_value = "design", value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Measure how many colour filter arrays per second this machine screens; write nothing
    #[arg(long)]
    pub(crate) benchmark: bool,
    /// Do not learn a pipeline for the array that was found
    #[arg(long)]
    pub(crate) no_pipeline: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    // Last: the heading would apply to all arguments after it.
    #[command(flatten)]
    pub(crate) learning: LearningOptions,
}

/// Published mosaics that are written as cameras.
const WRITTEN_RIVALS: usize = 5;
/// Rows of the printed table for each kind of mosaic.
const PRINTED: usize = 8;

pub(crate) fn run(args: &DesignArgs, common: &Common) -> anyhow::Result<()> {
    let Some(name) = &args.design else { return benchmark(args, common) };
    let LoadedDesign { task, camera: description, notes, .. } =
        designs::load(name).map_err(|e| anyhow::anyhow!("{e}"))?;
    notes.iter().for_each(|text| note(text, common));
    write::ensure_can_fill(&args.output)?;
    let progress = Progress::new(0, common.quiet);
    let begun = Instant::now();
    let statistics = statistics(&task, args, &progress)?;
    let found = design(&task, &statistics, &progress)?;
    let seconds = begun.elapsed().as_secs_f64();
    let best = found.searched.first().and_then(DesignedCfa::design).context("no mosaic was searched")?;
    let camera = smalti::camera::Camera::new(
        smalti::camera::description::CameraDescription {
            name: task.name.clone(),
            ..best.camera(&description)
        },
        task.camera.grid(),
    )?;
    let pipeline = match args.no_pipeline {
        true => None,
        false => {
            let sources = TrainingSources::<anyhow::Error> {
                scenes: None,
                illuminants: vec![task.illuminant.clone()],
                stored_scenes: args.learning.training_set.stored(),
                pairs: Vec::new(),
                saved: Vec::new(),
            };
            let (settings, training) = (args.learning.settings(task.search.seed), args.learning.training());
            let Learned { pipeline, .. } =
                learn(&camera, &settings, &training, sources, &progress, memory::available_bytes())?;
            Some(pipeline)
        }
    };
    progress.finish();
    let dir = &args.output;
    write::begin_folder(dir, &["results.json"])?;
    if let Some(pipeline) = &pipeline {
        l3::write_table(&dir.join("camera.l3"), pipeline)?;
    }
    let toml = |design: &Design, name: &str| {
        designs::camera_toml(design, &description, name).map_err(|e| anyhow::anyhow!("{e}"))
    };
    write::bytes(&dir.join("camera.toml"), toml(&best, &task.name)?.as_bytes())?;
    write_filters(&dir.join("filters.csv"), &best, &task)?;
    let figure = mosaic_figure(&best, &task)?;
    write::bytes(&dir.join("mosaic.svg"), figure.svg().as_bytes())?;
    let rivals: Vec<&DesignedCfa> = found.rivals.iter().take(WRITTEN_RIVALS).collect();
    if !rivals.is_empty() {
        write::begin_folder(&dir.join("rivals"), &[])?;
    }
    for rival in &rivals {
        let Some(design) = rival.design() else { continue };
        let text = toml(&design, &format!("{}, filters of {}", rival.name, task.name))?;
        write::bytes(&dir.join("rivals").join(format!("{}.toml", rival.name)), text.as_bytes())?;
    }
    let document = document(&task, &statistics, &found, seconds);
    write::bytes(&dir.join("results.json"), (serde_json::to_string_pretty(&document)? + "\n").as_bytes())?;
    if args.json {
        return crate::output::print_json(&document);
    }
    crate::print(&summary(&task, &statistics, &found, (dir, seconds)))
}

fn statistics(task: &DesignTask, args: &DesignArgs, progress: &Progress) -> anyhow::Result<LightStatistics> {
    let resources =
        Resources { training_scenes: args.learning.training_set.stored(), progress, ..Resources::default() };
    Ok(light_statistics(&task.camera, &task.illuminant, None, &task.light, resources)?)
}

/// The transmittances as a table with a column for each letter.
fn write_filters(path: &Path, design: &Design, task: &DesignTask) -> anyhow::Result<()> {
    let cfa = design.cfa(task.camera.grid())?;
    let columns: Vec<(&str, &Spectrum)> =
        cfa.channels().iter().map(|c| (c.name.as_str(), &c.transmittance)).collect();
    Ok(spectrum_csv::write(path, &columns)?)
}

fn mosaic_figure(design: &Design, task: &DesignTask) -> anyhow::Result<Figure> {
    let cfa = design.cfa(task.camera.grid())?;
    crate::show::mosaic_figure(&cfa)
}

fn tile_size(mosaic: &Mosaic) -> String {
    format!("{} × {}", mosaic.rows(), mosaic.cols())
}

/// The expected figures of all conditions, separated by slashes.
fn figures(expected: &[ExpectedError]) -> [String; 3] {
    let joined =
        |of: &dyn Fn(&ExpectedError) -> String| expected.iter().map(of).collect::<Vec<_>>().join(" / ");
    [
        joined(&|e| format!("{:.2}", e.cpsnr_db)),
        joined(&|e| format!("{:.2}", e.delta_e_2000)),
        joined(&|e| format!("{:.1}", e.time_s * 1e3)),
    ]
}

fn summary(
    task: &DesignTask,
    statistics: &LightStatistics,
    found: &Designs,
    (dir, seconds): (&Path, f64),
) -> String {
    let lights: Vec<String> = task.conditions.iter().map(|c| c.luminance_cd_m2.to_string()).collect();
    let row = |design: &DesignedCfa| {
        let Some(best) = design.best() else { return Vec::new() };
        let [cpsnr, delta_e, time] = figures(&best.expected);
        let colors = design.mosaic.channels().to_string();
        let (name, size) = (design.name.clone(), tile_size(&design.mosaic));
        vec![name, size, colors, format!("{:.3}", best.cost), cpsnr, delta_e, time]
    };
    let header = ["mosaic", "tile", "filters", "cost", "CPSNR, dB", "ΔE2000", "exposure, ms"];
    let mut rows: Vec<Vec<String>> = found.searched.iter().take(PRINTED).map(row).collect();
    let own = &task.camera.sensor.cfa;
    let [cpsnr, delta_e, time] = figures(&found.own);
    let cost = format!("{:.3}", task.objective.cost(&found.own));
    let (size, filters) = (tile_size(own.mosaic()), own.channels().len().to_string());
    rows.push(vec!["the camera's own".into(), size, filters, cost, cpsnr, delta_e, time]);
    let mut out = format!(
        "{}: {} searched in {seconds:.0} s; {} at {} cd/m²\n\n{}",
        task.name,
        match found.searched.len() {
            1 => "one mosaic".to_owned(),
            n => format!("{n} mosaics"),
        },
        task.illuminant.name(),
        lights.join(" / "),
        table::render(&header, &rows),
    );
    if !found.rivals.is_empty() {
        let rows: Vec<Vec<String>> = found.rivals.iter().take(PRINTED).map(row).collect();
        out += &format!(
            "\nThe best of {} published mosaics, each with the best filters of the same kind:\n\n{}",
            found.rivals.len(),
            table::render(&header, &rows)
        );
    }
    let dir = dir.display();
    let rival = found.rivals.first().map_or_else(String::new, |r| format!(" {dir}/rivals/{}.toml", r.name));
    out + &format!(
        "\nFigures are expectations of the closed form from {} patches of {} scenes, in the order of the luminances. They rank arrays as\n\
         learned pipelines do; their absolute values differ from scores. A search from random starts may miss the best filters.\n\
         {dir}/camera.toml is the camera. Its scores on scenes that were not used, with intervals:\n\
         smalti compare {dir}/camera.toml{rival} bayer --luminance {}\n",
        statistics.patches(),
        statistics.scenes(),
        lights.join(","),
    )
}

/// Expected errors with the luminances of their conditions.
fn expected(expected: &[ExpectedError], task: &DesignTask) -> Vec<Value> {
    let of = |(e, c): (&ExpectedError, &ScreenCondition)| {
        json!({
            "luminance_cd_m2": c.luminance_cd_m2, "cpsnr_db": e.cpsnr_db,
            "delta_e_2000": e.delta_e_2000, "time_s": e.time_s,
        })
    };
    expected.iter().zip(&task.conditions).map(of).collect()
}

fn document(task: &DesignTask, statistics: &LightStatistics, found: &Designs, seconds: f64) -> Value {
    let design = |d: &DesignedCfa| {
        let best = d.best();
        let expected = expected(best.map_or(&[], |b| &b.expected), task);
        let arranged = d.design();
        json!({
            "name": d.name, "published": d.is_published, "tile": arranged.as_ref().map(Design::tile),
            "filters": d.mosaic.channels(), "cost": best.map(|b| b.cost), "expected": expected,
            "costs_of_starts": d.found.iter().map(|f| f.cost).collect::<Vec<_>>(),
            "transmittances": best.map(|b| b.transmittances.iter().map(|t| t.values().to_vec()).collect::<Vec<_>>()),
        })
    };
    json!({
        "name": task.name,
        "camera": task.camera.description().name,
        "illuminant": task.illuminant.name(),
        "objective": task.objective,
        "search": task.search,
        "family": task.filters,
        "wavelengths_nm": task.camera.grid().wavelengths_nm().collect::<Vec<_>>(),
        "light": {
            "scenes": statistics.scenes(), "patches": statistics.patches(),
            "components": statistics.basis().len(), "energy_left_out": statistics.basis().left_out(),
            "luminance_error": statistics.luminance_error(),
        },
        "seconds": seconds,
        "own": { "cost": task.objective.cost(&found.own), "expected": expected(&found.own, task) },
        "searched": found.searched.iter().map(design).collect::<Vec<_>>(),
        "rivals": found.rivals.iter().map(design).collect::<Vec<_>>(),
    })
}

/// Sets of filters that are screened together in the benchmark.
const BENCHMARK_SETS: usize = 2048;

/// Screens random filters: 2 × 2 with four filters and 4 × 4 with sixteen, 15 classes, three luminances.
fn benchmark(args: &DesignArgs, common: &Common) -> anyhow::Result<()> {
    let task = designs::load("free-4").map_err(|e| anyhow::anyhow!("{e}"))?.task;
    let classes = LightClasses {
        luminance_cuts: vec![0.15, 0.4, 0.9, 1.8],
        contrast_cuts: vec![0.03, 0.15],
        ..LightClasses::default()
    };
    let task = DesignTask { light: LightSettings { classes, ..task.light }, ..task };
    let progress = Progress::new(0, common.quiet);
    let statistics = statistics(&task, args, &progress)?;
    progress.finish();
    let screen = Screen::new(&task.camera, &statistics, &task.conditions)?;
    let components = statistics.basis().len();
    let rate = |side: usize, filters: usize| -> anyhow::Result<f64> {
        let cells = (0..side * side).map(|i| (i % filters) as u8).collect();
        let mosaic = Mosaic::new(side, side, cells)?;
        let response = |set: usize, filter: usize| {
            (0..components).map(|k| (1 + (set * 7 + filter * 3 + k * 5) % 11) as f64).collect()
        };
        let sets: Vec<FilterResponses> = (0..BENCHMARK_SETS)
            .map(|set| FilterResponses::new((0..filters).map(|f| response(set, f)).collect()))
            .collect();
        // The first pass warms the caches.
        let _ = screen.expected_of(&mosaic, &sets[..64], Figures::Cpsnr);
        let (begun, mut count) = (Instant::now(), 0);
        while begun.elapsed().as_secs_f64() < 3.0 {
            count += screen.expected_of(&mosaic, &sets, Figures::Cpsnr).len();
        }
        Ok(count as f64 / begun.elapsed().as_secs_f64())
    };
    let (small, large) = (rate(2, 4)?, rate(4, 4)?);
    let threads = rayon::current_num_threads();
    if args.json {
        let document = json!({
            "cfas_per_s_2x2": small, "cfas_per_s_4x4": large, "classes": screen.classes(),
            "components": components, "luminances": screen.conditions(), "threads": threads,
        });
        return crate::output::print_json(&document);
    }
    crate::print(&format!(
        "{small:.0} colour filter arrays of 2 × 2 and {large:.0} of 4 × 4 pixels per second, four filters each, on {threads} threads\n\
         ({} classes, patches of {} × {} pixels, {components} spectral components, {} luminances; CPSNR)\n",
        screen.classes(),
        statistics.settings().side,
        statistics.settings().side,
        screen.conditions(),
    ))
}
