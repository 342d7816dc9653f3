//! Learned pipelines: the origin of their kernels, and the kernels as data for the script.

use serde_json::{Value, json};
use smalti::experiment::Contender;
use smalti::l3::{Origin, Pipeline};

use super::figures::filter_colors;
use super::kernels::weights as weights_of;
use crate::ReportError;
use crate::page::{Markup, Table, el, packed};
use crate::words::grouped;

/// The largest number of weights of one pipeline in the page. Some levels are left out where there are more.
const MAX_WEIGHTS: usize = 500_000;
/// The largest number of levels of a combination of clipped channels.
const MAX_CLIPPED_LEVELS: usize = 8;
/// Quantization steps of a weight on either side of zero.
const STEPS: f64 = 127.0;

/// Tables of the positions, and the places for the kernels, which the script draws.
pub(super) fn section(learned: &[(&Contender<'_>, &Pipeline, String)]) -> Markup {
    let mut out: Markup = el("p")
        .child(
            "A learned pipeline is a table of linear kernels. Each patch of raw samples belongs to a class, defined by the position of its centre in the \
             tile of the mosaic, the level of its mean response, its texture, and the channels that clip. The kernels of its class compute X, Y \
             and Z. Classes with too few training patches use the kernels of other classes; they are marked. A pipeline of quality fast has this \
             stage alone. One of quality best has a second stage, which refines the picture and is not drawn here.",
        )
        .into();
    for (number, (contender, pipeline, _)) in learned.iter().enumerate() {
        let summary = pipeline.summary();
        let mut table =
            Table::new(format!("Positions of {} and the origin of their kernels", contender.label))
                .text("Position: row, column, from 0")
                .text("Channel")
                .number("Patches seen");
        table = Origin::ALL.iter().fold(table, |table, origin| table.number(origin.name()));
        for p in &summary.positions {
            let mut cells = vec![format!("{}, {}", p.row, p.col), p.channel.clone(), grouped(p.patches)];
            cells.extend(p.by_origin.iter().map(usize::to_string));
            table = table.row(cells, false);
        }
        let about = format!(
            "Quality {}: {} classes, {} of them seen in training, {} kernels, {} patches; kernels of {side}\u{a0}×\u{a0}{side}{second}.",
            pipeline.quality().name(),
            grouped(summary.classes as u64),
            grouped(summary.occupied as u64),
            grouped(summary.operators as u64),
            grouped(summary.patches),
            side = pipeline.axes().side(),
            second = pipeline.refinement().map_or_else(String::new, |refinement| {
                let classes = refinement.classes();
                let learned = classes.iter().filter(|c| c.is_learned).count();
                let [all, learned] = [classes.len(), learned].map(|n| grouped(n as u64));
                format!("; a second stage of {all} classes, {learned} of them with kernels of their own")
            }),
        );
        out = out
            .and(el("h3").child(contender.label))
            .and(el("p").child(about))
            .and(el("div").class("kernels").attr("data-learned", number.to_string()))
            .and(table);
    }
    out
}

/// All kernels by combination of clipped channels. Weights are in steps of 1/127 of the largest weight of their kernel.
pub(super) fn data(contender: &Contender<'_>, pipeline: &Pipeline) -> Result<Value, ReportError> {
    let axes = pipeline.axes();
    let (side, outputs) = (axes.side(), pipeline.outputs());
    let mosaic = axes.mosaic();
    let positions: Vec<Value> = (0..axes.positions())
        .map(|p| {
            let (row, col) = (p / mosaic.cols(), p % mosaic.cols());
            let taps: Vec<usize> = (0..side * side).map(|tap| axes.channel_of(p, tap)).collect();
            json!({"row": row, "col": col, "channel": mosaic.channel_at(row, col), "taps": taps})
        })
        .collect();
    let each_level = axes.positions() * axes.textures().count() * outputs.len() * axes.taps();
    let most_levels = (MAX_WEIGHTS / each_level.max(1)).max(1);
    let clipped = (0..pipeline.saturations().len()).map(|s| of_saturation(pipeline, s, most_levels));
    let clipped = clipped.collect::<Result<Vec<_>, _>>()?;
    let colors: Vec<String> = filter_colors(contender.camera).iter().map(ToString::to_string).collect();
    Ok(json!({
        "camera": contender.label,
        "side": side,
        "cols": mosaic.cols(),
        "level_count": axes.level_count(),
        "textures": axes.textures().names(),
        "outputs": outputs,
        "channels": pipeline.channel_names(),
        "colors": colors,
        "positions": positions,
        "origins": Origin::ALL.map(Origin::name),
        "steps": STEPS,
        "clipped": clipped.into_iter().flatten().collect::<Vec<_>>(),
    }))
}

/// The classes of one combination of clipped channels. Where channels clip, only a few levels that occurred in training.
fn of_saturation(
    pipeline: &Pipeline,
    saturation: usize,
    most_levels: usize,
) -> Result<Option<Value>, ReportError> {
    let axes = pipeline.axes();
    let outputs = pipeline.outputs().len();
    let textures = axes.textures().count();
    let seen = |level: &usize| {
        let all = (0..axes.positions()).flat_map(|p| (0..textures).map(move |t| (p, t)));
        let class = |(p, t)| pipeline.classes().get(pipeline.index(p, saturation, *level, t));
        all.filter_map(class).any(|c| c.count > 0)
    };
    let (met, most): (Vec<usize>, usize) = match saturation {
        0 => ((0..axes.level_count()).collect(), most_levels),
        _ => ((0..axes.level_count()).filter(seen).collect(), most_levels.min(MAX_CLIPPED_LEVELS)),
    };
    let levels: Vec<usize> = met.iter().copied().step_by(met.len().div_ceil(most).max(1)).collect();
    if levels.is_empty() {
        return Ok(None);
    }
    let (mut counts, mut origins, mut scales, mut weights, mut offsets) =
        (vec![], vec![], vec![], vec![], vec![]);
    for position in 0..axes.positions() {
        for (&level, texture) in levels.iter().flat_map(|l| (0..textures).map(move |t| (l, t))) {
            let index = pipeline.index(position, saturation, level, texture);
            let class = pipeline.classes().get(index);
            counts.push(class.map_or(0.0, |c| c.count as f64));
            origins.push(class.map_or(f64::NAN, |c| f64::from(c.origin as u8)));
            for output in 0..outputs {
                let kernel = weights_of(pipeline, index, output)?;
                let largest = kernel.iter().fold(0.0f64, |m, w| m.max(f64::from(w.abs())));
                let per_step = if largest > 0.0 { STEPS / largest } else { 0.0 };
                scales.push(largest);
                weights.extend(kernel.iter().map(|w| (f64::from(*w) * per_step).round()));
                let offset = pipeline.kernels().offsets.get(index * outputs + output);
                offsets.push(offset.map_or(f64::NAN, |v| f64::from(*v)));
            }
        }
    }
    let middle = |p: usize| {
        let of = levels.iter().map(|&l| format!("{:.3}", 100.0 * axes.levels_at(p).middle(l)));
        of.collect::<Vec<_>>()
    };
    let bits = pipeline.saturations().get(saturation).copied().unwrap_or_default();
    let names = pipeline.channel_names().iter().enumerate();
    let clipping: Vec<&String> = names.filter(|(c, _)| bits >> c & 1 == 1).map(|(_, name)| name).collect();
    Ok(Some(json!({
        "channels": clipping,
        "levels": levels.iter().map(|l| l + 1).collect::<Vec<_>>(),
        "met": met.len(),
        "middles": (0..axes.positions()).map(middle).collect::<Vec<_>>(),
        "count": packed(&counts),
        "origin": packed(&origins),
        "scale": packed(&scales),
        "weight": packed(&weights),
        "offset": packed(&offsets),
    })))
}
