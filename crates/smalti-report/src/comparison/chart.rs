//! The ColorChecker: split patches and a plot of a* and b* for each camera.

use smalti::camera::Evaluation;
use smalti::scene::macbeth;
use smalti::spectrum::{WavelengthGrid, reflectance};

use super::figures::{Scored, drawn};
use crate::page::{Markup, el, figure, paragraph};
use crate::svg::{FRAME, INK};
use crate::{Line, Plot, Points, Rgb, SplitPatches};

/// Width and height of the plot, pixels, for a square panel.
const SIZE: (f64, f64) = (560.0, 607.0);
/// The largest number of characters of a name in the title of the plot. A title of two lines would make the panel lower than wide.
const MAX_NAME: usize = 32;
/// Share of the range of the colours that is left free around them.
const AIR: f64 = 0.07;

/// The names of the patches, with their numbers from 1.
pub(super) fn names() -> Vec<String> {
    // This grid is valid, so there is no error.
    let patches = reflectance::colorchecker(WavelengthGrid::VISIBLE).unwrap_or_default();
    // The name without the density of the patch.
    let name = |(i, (name, _)): (usize, &(&str, _))| {
        format!("{} {}", i + 1, name.split(" (").next().unwrap_or(name))
    };
    patches.iter().enumerate().map(name).collect()
}

/// The drawings for every luminance, those of the highest unfolded.
pub(super) fn colors(lights: &[Vec<Scored<'_>>]) -> Markup {
    let luminance = |light: &Vec<Scored<'_>>| light.first().map_or(f64::NAN, |s| s.luminance_cd_m2);
    let mut order: Vec<&Vec<Scored<'_>>> = lights.iter().collect();
    order.sort_by(|a, b| luminance(b).total_cmp(&luminance(a)));
    let names = names();
    let of_light = |light: &[Scored<'_>]| -> Markup {
        charts(light.iter().map(|scored| patches(scored, &names))).and(charts(light.iter().map(plane)))
    };
    let about = "Patches of the ColorChecker without noise. The upper half of each patch is the reference, the lower half what the camera \
                 renders, with their ΔE2000. White is the white patch of the reference, shown as the white of the display.";
    let folded = order.iter().skip(1).map(|light| {
        let summary = el("summary").child(format!("The same at {} cd/m²", luminance(light)));
        el("details").child(summary).child(of_light(light))
    });
    let first: Markup = order.first().map(|light| of_light(light)).into_iter().collect();
    paragraph("help", about).and(first).and(folded.collect::<Markup>())
}

/// Drawings side by side, narrower than other figures.
fn charts(drawings: impl IntoIterator<Item = Markup>) -> Markup {
    el("div").class("beside charts").children(drawings).into()
}

fn of_patches(evaluation: &Evaluation) -> impl Iterator<Item = ([f64; 3], [f64; 3], f64)> {
    let colors = &evaluation.patch_colors;
    let lab = colors.reference_lab.iter().zip(&colors.rendered_lab);
    lab.zip(&evaluation.delta_e_2000.per_patch).map(|((reference, rendered), d)| (*reference, *rendered, *d))
}

fn patches(scored: &Scored<'_>, names: &[String]) -> Markup {
    let Scored { name, luminance_cd_m2, evaluation, .. } = scored;
    let mean = evaluation.delta_e_2000.mean;
    let mut drawing = SplitPatches::new(macbeth::COLS)
        .title(format!("{name}, {luminance_cd_m2} cd/m²"))
        .note(format!("Mean ΔE2000 {mean:.2}. Above: reference. Below: rendered."));
    for ((reference, rendered, difference), name) in of_patches(evaluation).zip(names) {
        drawing = drawing.patch(name, reference, rendered, difference);
    }
    drawing.draw().map_or_else(|e| paragraph("none", format!("No drawing: {e}.")), |f| figure(&f))
}

/// The patches in the plane of a* and b*, with arrows from the reference to the rendering.
fn plane(scored: &Scored<'_>) -> Markup {
    let all: Vec<_> = of_patches(scored.evaluation).collect();
    let range = |axis: usize| {
        let values = all.iter().flat_map(|(reference, rendered, _)| [reference[axis], rendered[axis]]);
        values.filter(|v| v.is_finite()).fold((0.0f64, 0.0f64), |(low, high), v| (low.min(v), high.max(v)))
    };
    // One scale for both axes.
    let (a, b) = (range(1), range(2));
    let half = (0.5 + AIR) * (a.1 - a.0).max(b.1 - b.0).max(10.0);
    let around = |(low, high): (f64, f64)| (0.5 * (low + high) - half, 0.5 * (low + high) + half);
    let (a, b) = (around(a), around(b));
    let axis = |x: [f64; 2], y: [f64; 2]| Line::new("", &x, &y).color(FRAME).width(1.0);
    let mut plot = Plot::new("a* (green to red)", "b* (blue to yellow)")
        .title(format!("{}, {} cd/m²", shortened(&scored.name), scored.luminance_cd_m2))
        .note("Circles are the reference, arrows lead to what the camera renders.")
        .x_range(a.0, a.1)
        .y_range(b.0, b.1)
        .size(SIZE.0, SIZE.1)
        .line(axis([a.0, a.1], [0.0; 2]))
        .line(axis([0.0; 2], [b.0, b.1]));
    for (reference, rendered, _) in &all {
        let (x, y) = ([reference[1], rendered[1]], [reference[2], rendered[2]]);
        plot = plot.line(Line::new("", &x, &y).color(INK).width(1.8).arrow());
    }
    // A ring around each circle, since patches may have the colour of the background.
    for (radius, ring) in [(7.0, true), (5.2, false)] {
        for (reference, _, _) in &all {
            let color = if ring { FRAME } else { Rgb::of_lab(*reference) };
            plot = plot.points(
                Points::new("", &reference[1..2], &reference[2..3]).color(color).radius(radius).marks(),
            );
        }
    }
    drawn(&plot)
}

/// A name with an ellipsis in place of what exceeds [`MAX_NAME`].
fn shortened(name: &str) -> String {
    if name.chars().count() <= MAX_NAME {
        return name.to_owned();
    }
    name.chars().take(MAX_NAME - 1).chain(['…']).collect()
}
