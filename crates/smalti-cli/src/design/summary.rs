//! The printed result of a search.

use std::path::Path;

use smalti::design::light::LightStatistics;
use smalti::design::screen::ExpectedError;
use smalti::experiment::{DesignTask, DesignedCfa, Designs, FrontPoint};
use smalti::sensor::Mosaic;
use smalti::spectrum::Illuminant;

use crate::table;

/// Rows of the printed table for each kind of mosaic.
const PRINTED: usize = 8;

fn tile_size(mosaic: &Mosaic) -> String {
    format!("{} × {}", mosaic.rows(), mosaic.cols())
}

/// The expected figures of all conditions, separated by slashes.
fn figures(expected: &[ExpectedError]) -> [String; 4] {
    let joined =
        |of: &dyn Fn(&ExpectedError) -> String| expected.iter().map(of).collect::<Vec<_>>().join(" / ");
    [
        joined(&|e| format!("{:.2}", e.cpsnr_db)),
        joined(&|e| format!("{:.2}", e.delta_e_2000)),
        joined(&|e| format!("{:.2}", e.scielab)),
        joined(&|e| format!("{:.1}", e.time_s * 1e3)),
    ]
}

pub(super) fn summary(
    task: &DesignTask,
    statistics: &[LightStatistics],
    found: &Designs,
    (dir, seconds): (&Path, f64),
) -> String {
    let lights: Vec<String> = task.conditions.iter().map(|c| c.luminance_cd_m2.to_string()).collect();
    let row = |design: &DesignedCfa| {
        let Some(best) = design.best() else { return Vec::new() };
        let [cpsnr, delta_e, scielab, time] = figures(&best.expected);
        let colors = design.mosaic.channels().to_string();
        let (name, size) = (design.name.clone(), tile_size(&design.mosaic));
        vec![name, size, colors, format!("{:.3}", best.cost), cpsnr, delta_e, scielab, time]
    };
    let header = ["mosaic", "tile", "filters", "cost", "CPSNR, dB", "ΔE2000", "S-CIELAB", "exposure, ms"];
    let mut rows: Vec<Vec<String>> = found.searched.iter().take(PRINTED).map(row).collect();
    let own = &task.camera.sensor.cfa;
    let [cpsnr, delta_e, scielab, time] = figures(&found.own);
    let cost = format!("{:.3}", found.goal.cost(&found.own));
    let (size, filters) = (tile_size(own.mosaic()), own.channels().len().to_string());
    rows.push(vec!["the camera's own".into(), size, filters, cost, cpsnr, delta_e, scielab, time]);
    let mut out = format!(
        "{}: {} searched in {seconds:.0} s; {} at {} cd/m²\n\n{}",
        task.name,
        match found.searched.len() {
            1 => "one mosaic".to_owned(),
            n => format!("{n} mosaics"),
        },
        task.illuminants.iter().map(Illuminant::name).collect::<Vec<_>>().join(", then "),
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
    out += &front(task, &found.front);
    let dir = dir.display();
    let rival = found.rivals.first().map_or_else(String::new, |r| format!(" {dir}/rivals/{}.toml", r.name));
    let order = if task.illuminants.len() > 1 { "illuminants, then of the luminances" } else { "luminances" };
    out + &format!(
        "\nFigures are expectations of the closed form from {} patches of {} scenes, in the order of the {order}. They rank arrays as\n\
         learned pipelines do; their absolute values differ from scores. A search from random starts may miss the best filters.\n\
         {dir}/camera.toml is the camera. Its scores on scenes that were not used, with intervals:\n\
         smalti compare {dir}/camera.toml{rival} bayer --luminance {}\n",
        statistics.iter().map(LightStatistics::patches).sum::<u64>(),
        statistics.iter().map(LightStatistics::scenes).sum::<u64>(),
        lights.join(","),
    )
}

/// The compromises of a front, best in the first aim first.
fn front(task: &DesignTask, points: &[FrontPoint]) -> String {
    let Some(front) = task.front.as_ref().filter(|_| !points.is_empty()) else { return String::new() };
    let names = front.aims.iter().map(|aim| aim.name.as_str());
    let header: Vec<&str> = ["camera", "mosaic", "filters"]
        .into_iter()
        .chain(names)
        .chain(["CPSNR, dB", "ΔE2000", "S-CIELAB"])
        .collect();
    let row = |(number, point): (usize, &FrontPoint)| {
        let [cpsnr, delta_e, scielab, _] = figures(point.cfa.best().map_or(&[], |best| &best.expected));
        let mut cells = vec![
            format!("front/{}.toml", number + 1),
            point.cfa.name.clone(),
            point.cfa.mosaic.channels().to_string(),
        ];
        let costs = point.costs.iter().take(front.aims.len());
        cells.extend(costs.map(|cost| format!("{cost:.3}")));
        cells.extend([cpsnr, delta_e, scielab]);
        cells
    };
    let rows: Vec<Vec<String>> = points.iter().enumerate().map(row).collect();
    format!(
        "\nThe front: no array that was found{} is better in every aim than one of these. Aims are costs, less is better:\n\n{}",
        if front.filters { " with as few filters" } else { "" },
        table::render(&header, &rows)
    )
}
