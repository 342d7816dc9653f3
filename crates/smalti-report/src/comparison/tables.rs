//! Tables of a comparison.

use smalti::camera::Evaluation;
use smalti::experiment::{LightVerdict, MetricVerdict, Outcome, PairwiseLightGain};
use smalti::metrics::esfr::Mtf50Reliability;
use smalti::metrics::smallest_relevant;

use super::columns::{COMPARE, COMPARE_PER_PIXEL, Column, SCENES, reliabilities};
use super::conditions::exposure_cells;
use super::figures::Scored;
use super::results::{Comparison, of_contender};
use super::text::{MTF50_AND_NOISE, gain_cell};
use crate::page::{Markup, Table, el, paragraph};
use crate::reliability::meanings;
use crate::words::time_ms;

/// The headings of [`COMPARE`] on the page.
const HEADINGS: [&str; 7] = headings("MTF50, cy/mm");
/// Those of [`COMPARE_PER_PIXEL`].
const HEADINGS_PER_PIXEL: [&str; 7] = headings("MTF50, cy/px");

const fn headings(mtf50: &'static str) -> [&'static str; 7] {
    [
        "CPSNR, dB",
        "ΔE2000, mean",
        "S-CIELAB, ΔE*ab",
        mtf50,
        "MTF50 of a 4:1 edge, cy/px",
        "Visual SNR, 1/ΔE",
        "Luminance noise, %",
    ]
}

fn text(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "–".to_owned() }
}

/// Values as text, the best with a mark. Values that do not differ from the best are marked as well: by the verdict of the metric,
/// else those nearer than the [smallest relevant difference](smallest_relevant). A single value has no mark, nor has one that cannot
/// be trusted, nor have values that are all the same.
fn marked<T>(column: &Column<T>, of: &[&T], verdict: Option<&MetricVerdict>) -> Vec<Markup> {
    let sign = if column.is_higher_better() { 1.0 } else { -1.0 };
    let is_reliable = |of: &T| column.reliability(of) == Mtf50Reliability::Reliable;
    let reliable = of.iter().filter(|of| is_reliable(of)).map(|of| (column.of)(of));
    let best = reliable.filter(|v| v.is_finite()).max_by(|a, b| (sign * a).total_cmp(&(sign * b)));
    let best = best.filter(|_| of.len() > 1);
    let is_best = |row: usize, of: &T| match (verdict, best) {
        (_, None) => false,
        (Some(verdict), _) => verdict.is_among_best(row),
        (None, Some(best)) => {
            is_reliable(of) && !smallest_relevant(column.metric).is_relevant((column.of)(of), best)
        }
    };
    let mut texts = of.iter().map(|of| column.text(of));
    let first = texts.next().unwrap_or_default();
    let all_are_same = texts.all(|text| text == first);
    let one = |(row, of): (usize, &&T)| {
        let text = column.text(of);
        if all_are_same || !is_best(row, of) {
            return text.into();
        }
        let star = el("span").attr("aria-hidden", "true").class("star").child("★");
        el("b")
            .class("best")
            .child(text)
            .child(star)
            .child(el("span").class("hidden-text").child(" best"))
            .into()
    };
    of.iter().enumerate().map(one).collect()
}

/// The meaning of the marks at the values of these columns, a paragraph each.
pub(super) fn meanings_of<T>(columns: &[Column<T>], of: &[&T]) -> Markup {
    meanings(reliabilities(columns, of)).into_iter().map(|text| paragraph("help", text)).collect()
}

/// Adds a row for each of what is scored in one light, with cells before and after its scores. The best of each score are marked;
/// `verdict` is that of the same rows, if there is one.
pub(super) fn scored<T>(
    table: Table,
    columns: &[Column<T>],
    rows: &[(Vec<String>, &T, Vec<String>)],
    verdict: Option<&LightVerdict>,
) -> Table {
    let all: Vec<&T> = rows.iter().map(|(_, of, _)| *of).collect();
    let of_metric = |name: &str| verdict?.metrics.iter().find(|m| m.metric == name);
    let columns: Vec<Vec<Markup>> = columns.iter().map(|c| marked(c, &all, of_metric(c.metric))).collect();
    rows.iter().enumerate().fold(table, |table, (i, (before, _, after))| {
        let scores = columns.iter().filter_map(|c| c.get(i).cloned());
        let cells = before.iter().map(Markup::from).chain(scores).chain(after.iter().map(Markup::from));
        table.row(cells, false)
    })
}

/// The means over the scenes. The best at each luminance are marked.
pub(super) fn scores(report: &Comparison<'_>) -> Markup {
    let over = report.over();
    let table =
        Table::new(format!("Scores: {over}")).text("Camera").text("Processing").number("Luminance, cd/m²");
    let headings = if report.has_one_pitch() { HEADINGS } else { HEADINGS_PER_PIXEL };
    let mut table = headings.into_iter().chain(["Exposure, ms", "Saturated, %"]).fold(table, Table::number);
    for light in 0..report.light_count() {
        let rows = report.in_light(light);
        let rows =
            rows.map(|(c, o)| (of_contender(c, o.luminance_cd_m2).to_vec(), o, exposure_cells(o).to_vec()));
        table = scored(table, report.columns(), &rows.collect::<Vec<_>>(), report.verdict.lights.get(light));
    }
    let all: Vec<&Outcome> = report.outcomes.iter().flatten().collect();
    let meanings = meanings_of(report.columns(), &all);
    let times = report.target_times().into_iter().map(|line| paragraph("help", line)).collect::<Markup>();
    report.conditions.markup().and(Markup::from(table)).and(times).and(meanings).and(paragraph(
        "help",
        "★ marks the best value in this light and those that do not differ from it: where the verdict finds no difference, and within 5 % for \
         MTF50 and 10 % for visual SNR and noise, which are single measurements. Higher is better for CPSNR, MTF50 and visual SNR, lower for the \
         other columns. CPSNR, ΔE and S-CIELAB compare whole pictures with the scene as the standard observer sees it. MTF50 is that of a slanted \
         edge; visual SNR and noise are those of the grey patches of a ColorChecker.",
    ))
    .and(paragraph("help", MTF50_AND_NOISE))
}

/// The scores of each scene.
pub(super) fn scenes(report: &Comparison<'_>) -> Markup {
    let table = Table::new("Scores of each scene")
        .text("Scene")
        .text("Camera")
        .text("Processing")
        .number("Luminance, cd/m²");
    let table = HEADINGS.into_iter().take(SCENES.len()).fold(table, Table::number);
    let mut table = table.number("Saturated, %").number("Exposure, ms");
    for scene in 0..report.scene_count() {
        for (light, luminance_cd_m2) in report.luminances().into_iter().enumerate() {
            let rows = report.of_scene(light, scene).map(|(contender, s)| {
                let mut before = vec![report.scene_label(scene).to_owned()];
                before.extend(of_contender(contender, luminance_cd_m2));
                let exposure_ms = time_ms(s.scores.exposure_time_s * 1e3);
                (before, s, vec![format!("{:.1}", s.scores.saturated_percent), exposure_ms])
            });
            table = scored(table, &SCENES, &rows.collect::<Vec<_>>(), None);
        }
    }
    Markup::from(table).and(paragraph(
        "help",
        format!(
            "★ marks the best value of each scene and those less than {} dB (CPSNR) or {} (ΔE) from it. These differences have no confidence interval.",
            smallest_relevant("cpsnr_db"),
            smallest_relevant("scielab_mean"),
        ),
    ))
}

/// The label of a metric of the light gain.
pub(super) fn metric_name(metric: &str) -> &str {
    let all = COMPARE.iter().zip(HEADINGS).chain(COMPARE_PER_PIXEL.iter().zip(HEADINGS_PER_PIXEL));
    let mut named = all.filter(|(c, _)| c.metric == metric);
    named.next().map_or(metric, |(_, heading)| heading)
}

/// How much more light the first camera needs.
pub(super) fn gains(gains: &[PairwiseLightGain]) -> Markup {
    let table = |PairwiseLightGain { first, other, gains, .. }: &PairwiseLightGain| {
        let light = gains.luminance_cd_m2;
        let mut table = Table::new(format!("Additional light for {first} to match {other} at {light} cd/m²"))
            .text("Metric")
            .number(first)
            .number(other)
            .number("Light gain, stops");
        for m in &gains.metrics {
            let cells = [
                metric_name(m.metric).to_owned(),
                format!("{:.3}", m.own),
                format!("{:.3}", m.target),
                gain_cell(m, ""),
            ];
            table = table.row(cells, false);
        }
        Markup::from(table)
    };
    gains.iter().map(table).collect()
}

/// For each light a table with a row per patch and a column per camera.
pub(super) fn patches(
    lights: &[Vec<Scored<'_>>],
    caption: impl Fn(f64) -> String,
    names: &[String],
    of: fn(&Evaluation) -> &[f64],
) -> Markup {
    let table = |scored: &Vec<Scored<'_>>| {
        let table = Table::new(caption(scored.first()?.luminance_cd_m2)).text("Patch");
        let mut table = scored.iter().fold(table, |table, s| table.number(&s.name));
        for (i, name) in names.iter().enumerate() {
            let value = |s: &Scored<'_>| text(of(s.evaluation).get(i).copied().unwrap_or(f64::NAN), 2);
            table = table.row(std::iter::once(name.clone()).chain(scored.iter().map(value)), false);
        }
        Some(table)
    };
    lights.iter().filter_map(table).collect()
}

/// The noise of each grey patch as tables, folded.
pub(super) fn noise(lights: &[Vec<Scored<'_>>]) -> Markup {
    let of: fn(&Evaluation) -> &[f64] = |e| &e.luminance_noise_percent.per_patch;
    let first = lights.first().and_then(|scored| scored.first());
    let count = first.map_or(0, |s| of(s.evaluation).len());
    let names: Vec<String> = (1..=count).map(|p| p.to_string()).collect();
    let caption = |cd_m2| format!("Luminance noise at {cd_m2} cd/m², %, by grey patch from white");
    let tables = patches(lights, caption, &names, of);
    el("details").child(el("summary").child("The values")).child(tables).into()
}
