//! The learned pipelines: where their kernels come from, and the kernels themselves for the script.

use serde_json::{Value, json};
use smalti::l3::{Origin, Pipeline};
use smalti_report::page::{Markup, Table, el, packed};

use super::figures::filter_colors;
use crate::compare::Way;
use crate::study_report::grouped;

/// Most weights of one pipeline in the page; of more levels some are left out.
const MOST_WEIGHTS: usize = 500_000;
/// Steps of a weight on either side of zero.
const STEPS: f64 = 127.0;

/// Tables of the positions, and the places where the script draws.
pub(super) fn section(learned: &[(&Way<'_>, &Pipeline)]) -> Markup {
    let mut out: Markup = el("p")
        .child(
            "A learned pipeline is a table of linear filters. Each patch of raw samples belongs to a class: the place of its centre in the \
             mosaic's tile, the level of its mean response, its texture, and which channels clip. The class says which kernels make X, Y \
             and Z of it. Classes that training saw too rarely borrow their kernels; they are marked.",
        )
        .into();
    for (number, (way, pipeline)) in learned.iter().enumerate() {
        let summary = pipeline.summary();
        let mut table = Table::new(format!("Positions of {} and where their kernels come from", way.label))
            .text("Position: row, column")
            .text("Channel")
            .number("Patches seen");
        for origin in Origin::ALL {
            table = table.number(origin.name());
        }
        for p in &summary.positions {
            let mut cells =
                vec![format!("{}, {}", p.row + 1, p.col + 1), p.channel.clone(), grouped(p.patches)];
            cells.extend(p.by_origin.iter().map(usize::to_string));
            table = table.row(cells, false);
        }
        let about = format!(
            "{} classes, {} of them seen in training, {} linear filters, {} patches, kernels of {side}\u{a0}×\u{a0}{side}.",
            grouped(summary.classes as u64),
            grouped(summary.occupied as u64),
            grouped(summary.operators as u64),
            grouped(summary.patches),
            side = pipeline.axes().side(),
        );
        out = out
            .and(el("h3").child(way.label))
            .and(el("p").child(about))
            .and(el("div").class("kernels").attr("data-learned", number.to_string()))
            .and(table);
    }
    out
}

/// The classes in which nothing clips, and their kernels: weights in steps of a 127th of the largest of the kernel.
pub(super) fn data(way: &Way<'_>, pipeline: &Pipeline) -> Value {
    let axes = pipeline.axes();
    let (side, outputs) = (axes.side(), pipeline.outputs());
    let textures = axes.textures().names();
    let each_level = axes.positions() * textures.len() * outputs.len() * axes.taps();
    let fit = (MOST_WEIGHTS / each_level.max(1)).max(1);
    let step = axes.level_count().div_ceil(fit).max(1);
    let levels: Vec<usize> = (0..axes.level_count()).step_by(step).collect();
    let (mut counts, mut origins, mut scales, mut weights, mut offsets) =
        (vec![], vec![], vec![], vec![], vec![]);
    for position in 0..axes.positions() {
        for &level in &levels {
            for texture in 0..textures.len() {
                let index = pipeline.index(position, 0, level, texture);
                let class = pipeline.classes().get(index);
                counts.push(class.map_or(0.0, |c| c.count as f64));
                origins.push(class.map_or(f64::NAN, |c| f64::from(c.origin as u8)));
                for output in 0..outputs.len() {
                    let kernel = pipeline.weights(index, output);
                    let largest = kernel.iter().fold(0.0f64, |m, w| m.max(f64::from(w.abs())));
                    let per_step = if largest > 0.0 { STEPS / largest } else { 0.0 };
                    scales.push(largest);
                    weights.extend(kernel.iter().map(|w| (f64::from(*w) * per_step).round()));
                    let offset = pipeline.kernels().offsets.get(index * outputs.len() + output);
                    offsets.push(offset.map_or(f64::NAN, |v| f64::from(*v)));
                }
            }
        }
    }
    let mosaic = axes.mosaic();
    let positions: Vec<Value> = (0..axes.positions())
        .map(|p| {
            let (row, col) = (p / mosaic.cols(), p % mosaic.cols());
            let taps: Vec<usize> = (0..side * side).map(|tap| axes.channel_of(p, tap)).collect();
            let middles: Vec<String> =
                levels.iter().map(|&l| format!("{:.3}", 100.0 * axes.levels_at(p).middle(l))).collect();
            json!({"row": row + 1, "col": col + 1, "channel": mosaic.channel_at(row, col), "taps": taps, "middles": middles})
        })
        .collect();
    let colors: Vec<String> = filter_colors(way.camera).iter().map(ToString::to_string).collect();
    json!({
        "camera": way.label,
        "side": side,
        "cols": mosaic.cols(),
        "levels": levels.iter().map(|l| l + 1).collect::<Vec<_>>(),
        "level_count": axes.level_count(),
        "saturations": pipeline.saturations().len(),
        "textures": textures,
        "outputs": outputs,
        "channels": pipeline.channel_names(),
        "colors": colors,
        "positions": positions,
        "origins": Origin::ALL.map(Origin::name),
        "steps": STEPS,
        "count": packed(&counts),
        "origin": packed(&origins),
        "scale": packed(&scales),
        "weight": packed(&weights),
        "offset": packed(&offsets),
    })
}
