//! `smalti design --benchmark`: how many colour filter arrays per second this machine screens.

use std::time::Instant;

use anyhow::Context;
use serde_json::json;
use smalti::design::light::{LightClasses, LightSettings};
use smalti::design::screen::{Figures, FilterResponses, Screen};
use smalti::experiment::DesignTask;
use smalti::sensor::Mosaic;
use smalti_io::designs;

use super::args::DesignArgs;
use super::light::statistics;
use crate::args::Common;
use crate::progress::Progress;

/// Sets of filters that are screened together in the benchmark.
const BENCHMARK_SETS: usize = 2048;

/// Screens random filters: 2 × 2 with four filters and 4 × 4 with sixteen, 15 classes, three luminances.
pub(super) fn benchmark(args: &DesignArgs, common: &Common) -> anyhow::Result<()> {
    let task = designs::load("free-4").map_err(anyhow::Error::from)?.task;
    let classes = LightClasses {
        luminance_cuts: vec![0.15, 0.4, 0.9, 1.8],
        contrast_cuts: vec![0.03, 0.15],
        ..LightClasses::default()
    };
    let task = DesignTask { light: LightSettings { classes, ..task.light }, ..task };
    let progress = Progress::new(0, common.quiet);
    let statistics = statistics(&task, args, common, &progress)?.pop().context("expected an illuminant")?;
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
