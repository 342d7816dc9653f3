//! `smalti design`: finds the best filters and mosaic and writes the camera with them.

mod args;
mod benchmark;
mod files;
mod light;
mod page;
mod proof;
mod proof_options;
mod summary;

use std::path::Path;
use std::time::Instant;

use anyhow::Context;
use smalti::camera::CameraDescription;
use smalti::design::Design;
use smalti::experiment::{DesignedCfa, Learned, TrainingSources, analyse_design, design, learn};
use smalti_io::designs::{self, LoadedDesign, SearchLog, task_text};
use smalti_io::{l3, memory, write};

pub(crate) use self::args::DesignArgs;
use self::benchmark::benchmark;
use self::files::{mosaic_figure, write_filters};
use self::page::PAGE;
use self::proof::{OWN, RESULTS};
use self::summary::summary;
use crate::args::Common;
use crate::output::note;
use crate::progress::Progress;
use crate::sweep::stops_resumably;

/// Pixels of `mosaic.png` per unit of the figure: enough for print and for displays of high resolution.
const PNG_SCALE: f64 = 2.0;

pub(crate) fn run(args: &DesignArgs, common: &Common) -> anyhow::Result<()> {
    let Some(name) = &args.design else { return benchmark(args, common) };
    if Path::new(name).is_dir() {
        return proof::of_finished(Path::new(name), args, common);
    }
    let LoadedDesign { task, camera: description, notes, .. } =
        designs::load(name).map_err(anyhow::Error::from)?;
    notes.iter().for_each(|text| note(text, common));
    write::ensure_can_fill(&args.output)?;
    let progress = Progress::new(0, common.quiet);
    let begun = Instant::now();
    let statistics = light::statistics(&task, args, common, &progress)?;
    let log = SearchLog::open(&args.output, &task_text(&task, &statistics))?;
    if log.known() > 0 {
        let parts = match log.known() {
            1 => "1 part of the search is that".to_owned(),
            n => format!("{n} parts of the search are those"),
        };
        note(&format!("{parts} of an earlier run"), common);
    }
    stops_resumably(&args.output, "the search")?;
    let found = design(&task, &statistics, &log, &progress)?;
    let seconds = begun.elapsed().as_secs_f64();
    let best = found.searched.first().and_then(DesignedCfa::design).context("no mosaic was searched")?;
    let camera = smalti::camera::Camera::new(
        CameraDescription { name: task.name.clone(), ..best.camera(&description) },
        task.camera.grid(),
    )?;
    let pipeline = match args.no_pipeline {
        true => None,
        false => {
            let sources = TrainingSources::<anyhow::Error> {
                scenes: None,
                illuminants: task.illuminants.clone(),
                stored_scenes: args.learning.training_set.stored(),
                pairs: Vec::new(),
                saved: Vec::new(),
            };
            let (settings, training) = (args.learning.settings(task.search.seed), args.learning.training());
            let Learned { pipeline, .. } =
                learn(&camera, &settings, &training, &sources, &progress, memory::available_bytes())?;
            Some(pipeline)
        }
    };
    let analysis = {
        let (clear, cfa) = (task.filters.clear(), &camera.sensor.cfa);
        // Under the first illuminant.
        let statistics = statistics.first().context("expected an illuminant")?;
        analyse_design(&task.camera, statistics, &task.conditions, clear, cfa)?
    };
    progress.finish();
    let dir = &args.output;
    write::begin_folder(dir, &[RESULTS, PAGE])?;
    let own = designs::own_camera_toml(&description).map_err(anyhow::Error::from)?;
    write::bytes(&dir.join(OWN), own.as_bytes())?;
    if let Some(pipeline) = &pipeline {
        l3::write_table(&dir.join("camera.l3"), pipeline)?;
    }
    light::keep(dir, &task, &statistics)?;
    let toml = |design: &Design, name: &str| {
        designs::camera_toml(design, &description, name).map_err(anyhow::Error::from)
    };
    write::bytes(&dir.join("camera.toml"), toml(&best, &task.name)?.as_bytes())?;
    write_filters(&dir.join("filters.csv"), &best, &task)?;
    let figure = mosaic_figure(&best, &task)?;
    write::bytes(&dir.join("mosaic.svg"), figure.svg().as_bytes())?;
    write::bytes(&dir.join("mosaic.png"), &figure.png(PNG_SCALE)?)?;
    let rivals: Vec<&DesignedCfa> = found.rivals.iter().collect();
    if !rivals.is_empty() {
        write::begin_folder(&dir.join("rivals"), &[])?;
    }
    for rival in &rivals {
        let Some(design) = rival.design() else { continue };
        let text = toml(&design, &format!("{}, filters of {}", rival.name, task.name))?;
        write::bytes(&dir.join("rivals").join(format!("{}.toml", rival.name)), text.as_bytes())?;
    }
    if !found.front.is_empty() {
        write::begin_folder(&dir.join("front"), &[])?;
    }
    for (number, point) in (1..).zip(&found.front) {
        let Some(design) = point.cfa.design() else { continue };
        let text = toml(&design, &format!("{}, compromise {number}", task.name))?;
        write::bytes(&dir.join("front").join(format!("{number}.toml")), text.as_bytes())?;
    }
    let document = smalti_report::design::results(&task, &statistics, &found, &analysis, seconds)?;
    write::bytes(&dir.join(RESULTS), (serde_json::to_string_pretty(&document)? + "\n").as_bytes())?;
    page::write(dir, &document, None)?;
    if !args.json {
        crate::print(&summary(&task, &statistics, &found, (dir, seconds)))?;
    }
    if args.proof.prove {
        return proof::run(dir, args, common);
    }
    if args.json { crate::output::print_json(&document) } else { Ok(()) }
}
