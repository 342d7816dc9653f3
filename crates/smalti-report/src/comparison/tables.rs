//! Tables of a comparison.

use smalti::experiment::{Outcome, PairwiseLightGain};

use super::figures::Scored;
use super::results::{Comparison, mean};
use crate::page::{Markup, Table, el};

/// A column of scores.
struct Column {
    heading: &'static str,
    digits: usize,
    higher: bool,
    of: fn(&Outcome) -> f64,
}

const COLUMNS: [Column; 6] = [
    Column { heading: "CPSNR, dB", digits: 2, higher: true, of: |o| mean(o, |s| s.scores.cpsnr_db) },
    Column {
        heading: "ΔE2000, mean",
        digits: 2,
        higher: false,
        of: |o| mean(o, |s| s.scores.pixel_delta_e_2000_mean),
    },
    Column {
        heading: "S-CIELAB, ΔE*ab",
        digits: 2,
        higher: false,
        of: |o| mean(o, |s| s.scores.scielab_mean),
    },
    Column { heading: "MTF50, cy/mm", digits: 1, higher: true, of: |o| o.targets.mtf50_cy_per_mm },
    Column { heading: "Visual SNR, 1/ΔE", digits: 3, higher: true, of: |o| o.targets.visual_snr.median },
    Column {
        heading: "Luminance noise, %",
        digits: 1,
        higher: false,
        of: |o| o.targets.luminance_noise_percent.mean,
    },
];
/// The number of columns that single scenes have as well.
const OF_SCENES: usize = 3;

/// Values as text, the best with a mark. Values with the same text as the best are marked as well. A single value has no mark.
pub(super) fn marked(values: &[f64], digits: usize, higher: bool) -> Vec<Markup> {
    let sign = if higher { 1.0 } else { -1.0 };
    let text = |v: f64| if v.is_finite() { format!("{v:.digits$}") } else { "–".to_owned() };
    let best =
        values.iter().copied().filter(|v| v.is_finite()).max_by(|a, b| (sign * a).total_cmp(&(sign * b)));
    let best = best.filter(|_| values.len() > 1).map(text);
    let one = |&v: &f64| {
        let text = text(v);
        if best.as_ref() != Some(&text) {
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
    values.iter().map(one).collect()
}

/// The means over the scenes. The best at each luminance are marked.
pub(super) fn scores(report: &Comparison<'_>) -> Markup {
    let scenes = report.scene_count();
    let over = if scenes == 1 { "one scene".into() } else { format!("means over {scenes} scenes") };
    let mut table =
        Table::new(format!("Scores, {over}")).text("Camera").text("Processing").number("Luminance, cd/m²");
    for column in &COLUMNS {
        table = table.number(column.heading);
    }
    for light in 0..report.light_count() {
        let all: Vec<&Outcome> = report.outcomes.iter().filter_map(|o| o.get(light)).collect();
        let columns: Vec<Vec<Markup>> = COLUMNS
            .iter()
            .map(|c| marked(&all.iter().map(|o| (c.of)(o)).collect::<Vec<_>>(), c.digits, c.higher))
            .collect();
        for (i, (contender, outcome)) in report.contenders.iter().zip(&all).enumerate() {
            let mut cells: Vec<Markup> = vec![
                contender.label.into(),
                contender.processing.name().into(),
                outcome.luminance_cd_m2.to_string().into(),
            ];
            cells.extend(columns.iter().filter_map(|c| c.get(i).cloned()));
            table = table.row(cells, false);
        }
    }
    Markup::from(table).and(el("p").class("help").child(
        "★ marks the best value in this light. Higher is better for CPSNR, MTF50 and visual SNR, lower for the other columns. CPSNR, ΔE and \
         S-CIELAB compare whole pictures with the scene as the standard observer sees it. MTF50 is that of a slanted edge; visual SNR and \
         noise are those of the grey patches of a ColorChecker.",
    ))
}

/// The scores of each scene.
pub(super) fn scenes(report: &Comparison<'_>) -> Markup {
    let mut table = Table::new("Scores of each scene")
        .text("Scene")
        .text("Camera")
        .text("Processing")
        .number("Luminance, cd/m²");
    for column in COLUMNS.iter().take(OF_SCENES) {
        table = table.number(column.heading);
    }
    table = table.number("Clipped, %").number("Exposure, ms");
    for scene in 0..report.scene_count() {
        for light in 0..report.light_count() {
            let all: Vec<_> =
                report.outcomes.iter().filter_map(|o| o.get(light)?.scenes.get(scene)).collect();
            let of = |f: fn(&smalti::camera::SceneScores) -> f64| {
                all.iter().map(|(_, s)| f(s)).collect::<Vec<_>>()
            };
            let columns = [
                marked(&of(|s| s.scores.cpsnr_db), 2, true),
                marked(&of(|s| s.scores.pixel_delta_e_2000_mean), 2, false),
                marked(&of(|s| s.scores.scielab_mean), 2, false),
            ];
            for (i, (contender, (_, s))) in report.contenders.iter().zip(&all).enumerate() {
                let luminance = report.luminance(light).to_string();
                let mut cells: Vec<Markup> = vec![
                    report.scene_label(scene).into(),
                    contender.label.into(),
                    contender.processing.name().into(),
                    luminance.into(),
                ];
                cells.extend(columns.iter().filter_map(|c| c.get(i).cloned()));
                cells.push(format!("{:.1}", s.saturated_percent).into());
                cells.push(format!("{:.2}", s.exposure_time_s * 1e3).into());
                table = table.row(cells, false);
            }
        }
    }
    table.into()
}

/// The label of a metric of the light gain.
pub(super) fn metric_name(metric: &str) -> &str {
    match metric {
        "cpsnr_db" => "CPSNR, dB",
        "pixel_delta_e_2000_mean" => "ΔE2000, mean",
        "scielab_mean" => "S-CIELAB, ΔE*ab",
        "visual_snr" => "Visual SNR, 1/ΔE",
        "luminance_noise_percent" => "Luminance noise, %",
        other => other,
    }
}

/// How much more light the first camera needs.
pub(super) fn gains(gains: &[PairwiseLightGain]) -> Markup {
    let table = |PairwiseLightGain { first, other, gains, .. }: &PairwiseLightGain| {
        let light = gains.luminance_cd_m2;
        let mut table =
            Table::new(format!("More light that {first} needs to equal {other} at {light} cd/m²"))
                .text("Metric")
                .number(first)
                .number(other)
                .number("Light gain, stops");
        for m in &gains.metrics {
            let cells = [
                metric_name(m.metric).to_owned(),
                format!("{:.3}", m.own),
                format!("{:.3}", m.target),
                m.gain.to_string().replace(" stops", ""),
            ];
            table = table.row(cells, false);
        }
        Markup::from(table)
    };
    gains.iter().map(table).collect()
}

/// A row per patch, with a column of values per name.
pub(super) fn patches(
    caption: String,
    heading: &str,
    names: &[String],
    columns: &[(String, Vec<f64>)],
    digits: usize,
) -> Markup {
    let mut table = Table::new(caption).text(heading);
    for (name, _) in columns {
        table = table.number(name);
    }
    for (i, name) in names.iter().enumerate() {
        let values: Vec<f64> = columns.iter().map(|(_, v)| v.get(i).copied().unwrap_or(f64::NAN)).collect();
        let text = |v: &f64| if v.is_finite() { format!("{v:.digits$}") } else { "–".to_owned() };
        table = table.row(std::iter::once(name.clone()).chain(values.iter().map(text)), false);
    }
    table.into()
}

/// The noise of each grey patch as tables, folded.
pub(super) fn noise(scored: &[Vec<Scored<'_>>]) -> Markup {
    let table = |of_light: &Vec<Scored<'_>>| {
        let first = of_light.first()?;
        let columns: Vec<(String, Vec<f64>)> = of_light
            .iter()
            .map(|s| (s.name.clone(), s.evaluation.luminance_noise_percent.per_patch.clone()))
            .collect();
        let count = columns.first().map_or(0, |(_, v)| v.len());
        let names: Vec<String> = (1..=count).map(|p| p.to_string()).collect();
        let caption =
            format!("Luminance noise at {} cd/m², %, by grey patch from white", first.luminance_cd_m2);
        Some(patches(caption, "Patch", &names, &columns, 2))
    };
    el("details").child(el("summary").child("The values")).children(scored.iter().filter_map(table)).into()
}
