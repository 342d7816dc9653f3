//! Clouds of designs, their means and fronts.

use smalti::design::statistics::{Objective, Summary, pareto_front, quantile_of_sorted};
use smalti_report::{Corner, Histogram, Line, OKABE_ITO, Panels, Plot, Points, Rgb, Symbol};

use super::answers::{Group, Section};
use super::{Book, filters};

/// All figures there are: those of an earlier report are removed.
pub(super) const NAMES: [&str; 13] = [
    "cloud-by-colours",
    "panels-by-colours",
    "means",
    "cloud-by-noise",
    "filters-by-rule",
    "pareto-front",
    "histogram-delta-e",
    "histogram-mtf50",
    "filters-best",
    "filters-worst",
    "mosaics",
    "zone-plates",
    "scene",
];
const MTF50: &str = "MTF50 (cy/mm)";
const DELTA_E: &str = "Mean colour difference ΔE*ab";
const BEST_WHERE: &str = "Lower right is best.";
/// Share of the designs that the range of ΔE shows: few bad ones would press the others to the axis.
const SHOWN: f64 = 0.995;
/// Most designs of filters by rule that are drawn as marks.
const MAX_MARKS: usize = 400;
const SYMBOLS: [Symbol; 5] =
    [Symbol::Circle, Symbol::TriangleUp, Symbol::Star, Symbol::Diamond, Symbol::TriangleDown];
const INK: Rgb = Rgb(30, 30, 30);

/// One colour for a number of colours, in all figures.
fn color(colors: u8) -> Rgb {
    let place = (usize::from(colors) + OKABE_ITO.len() - 3) % OKABE_ITO.len();
    OKABE_ITO.get(place).copied().unwrap_or(INK)
}

fn pale(colors: u8) -> Rgb {
    color(colors).mix(Rgb(255, 255, 255), 0.55)
}

fn colours(colors: u8) -> String {
    format!("{colors} colours")
}

/// MTF50, ΔE and noise of rows.
fn columns(section: &Section<'_>, rows: impl Iterator<Item = usize>) -> [Vec<f64>; 3] {
    let mut out = [Vec::new(), Vec::new(), Vec::new()];
    for [delta_e, mtf50, noise] in rows.map(|r| section.scores(r)).filter(|s| s[0].is_finite()) {
        out.iter_mut().zip([mtf50, delta_e, noise]).for_each(|(column, v)| column.push(v));
    }
    out
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.retain(|v| v.is_finite());
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// The end of the axis of ΔE.
fn top(delta_e: &[f64]) -> Option<f64> {
    let sorted = sorted(delta_e.to_vec());
    let (top, last) = (quantile_of_sorted(&sorted, SHOWN), *sorted.last()?);
    // An axis that leaves nothing out needs no note.
    Some(1.04 * if last < 1.3 * top { last } else { top })
}

/// The axes that all clouds of a section share.
fn axes(section: &Section<'_>) -> Plot {
    let [mtf50, delta_e, _] = columns(section, section.rows.clone());
    let plot = Plot::new(MTF50, DELTA_E);
    let mtf50 = sorted(mtf50);
    match (top(&delta_e), mtf50.first(), mtf50.last()) {
        (Some(top), Some(first), Some(last)) if top > 0.0 && first < last => {
            let margin = 0.03 * (last - first);
            plot.y_range(0.0, top).x_range(first - margin, last + margin)
        }
        _ => plot,
    }
}

/// Figures of one condition with one processing.
pub(super) fn of_section(section: &Section<'_>, book: &mut Book) -> anyhow::Result<()> {
    let title = section.title();
    let count = section.groups.iter().map(|g| g.delta_e.count).sum::<usize>();
    let mut cloud = axes(section)
        .title(format!("Colour against resolution, {title}"))
        .note(format!("{count} designs. {BEST_WHERE}"));
    for group in &section.groups {
        let [x, y, _] = columns(section, section.rows_of(group.colors));
        cloud = cloud.points(Points::new(colours(group.colors), &x, &y).color(color(group.colors)));
    }
    book.save("cloud-by-colours", &cloud.draw()?, 2.0)?;
    drop(cloud);

    let mut panels = Panels::new(3)
        .title(format!("Colour against resolution by number of colours, {title}"))
        .note(format!("Squares are means, bars hold 90 % of the designs. {BEST_WHERE}"))
        .without_legend();
    for group in &section.groups {
        let [x, y, _] = columns(section, section.rows_of(group.colors));
        let plot = axes(section)
            .title(colours(group.colors))
            .points(Points::new("", &x, &y).color(pale(group.colors)))
            .points(mean(group, "").color(color(group.colors)));
        panels = panels.panel(plot);
    }
    book.save("panels-by-colours", &panels.draw()?, 2.0)?;
    drop(panels);

    let [x, y, noise] = columns(section, section.rows.clone());
    let mut plot = axes(section)
        .title(format!("Luminance noise, {title}"))
        .note(BEST_WHERE)
        .values("Luminance noise (%)");
    let by_size = sorted(noise.clone());
    let (low, high) = (quantile_of_sorted(&by_size, 0.0), quantile_of_sorted(&by_size, 0.98));
    if low < high {
        plot = plot.value_range(low, high);
    }
    book.save("cloud-by-noise", &plot.points(Points::new("", &x, &y).values(&noise)).draw()?, 2.0)?;
    drop((x, y, noise));

    front(section, book)?;
    for (name, label, digits, of) in [
        ("histogram-delta-e", DELTA_E, 1, (|g| g.delta_e) as fn(&Group) -> Summary),
        ("histogram-mtf50", MTF50, 0, |g| g.mtf50),
    ] {
        histograms(section, name, label, digits, of, book)?;
    }
    filters::of_section(section, book)
}

/// The mean of a number of colours; bars hold 90 % of the designs.
fn mean(group: &Group, name: &str) -> Points {
    let interval = |s: &Summary| [(s.p05.value, s.p95.value)];
    Points::new(name, &[group.mtf50.mean.value], &[group.delta_e.mean.value])
        .symbol(Symbol::Square)
        .x_intervals(&interval(&group.mtf50))
        .y_intervals(&interval(&group.delta_e))
}

/// The front over the cloud: the line is that of ΔE and MTF50 alone.
fn front(section: &Section<'_>, book: &mut Book) -> anyhow::Result<()> {
    let [x, y, _] = columns(section, section.rows.clone());
    let mut plot = axes(section)
        .title(format!("Pareto front, {}", section.title()))
        .note("Dots: no other design is better in ΔE, MTF50 and luminance noise at once. Line: the same of ΔE and MTF50 alone.")
        .points(Points::new("all designs", &x, &y).color(Rgb(205, 205, 205)));
    let mut line: Vec<(f64, f64)> = pareto_front(&[Objective::lower(&y), Objective::higher(&x)])?
        .rows
        .iter()
        .filter_map(|&r| Some((*x.get(r)?, *y.get(r)?)))
        .collect();
    line.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (x, y): (Vec<f64>, Vec<f64>) = line.into_iter().unzip();
    plot = plot.line(Line::new("front of ΔE and MTF50", &x, &y).corner(Corner::YFirst).color(INK).width(1.8));
    for group in &section.groups {
        let own =
            section.front.iter().copied().filter(|r| section.results.colors.get(*r) == Some(&group.colors));
        let [x, y, _] = columns(section, own);
        if !x.is_empty() {
            plot = plot
                .points(Points::new(colours(group.colors), &x, &y).color(color(group.colors)).radius(3.5));
        }
    }
    book.save("pareto-front", &plot.draw()?, 2.0)
}

fn histograms(
    section: &Section<'_>,
    name: &str,
    label: &str,
    digits: usize,
    of: fn(&Group) -> Summary,
    book: &mut Book,
) -> anyhow::Result<()> {
    let mut panels = Panels::new(3)
        .title(format!(
            "{}, {}",
            if name.ends_with("mtf50") { "Resolution" } else { "Colour error" },
            section.title()
        ))
        .note("Above the bars: the mean, and the interval that holds 90 % of the designs.")
        .without_legend();
    let all = columns(section, section.rows.clone());
    let column = |c: &[Vec<f64>; 3]| if name.ends_with("mtf50") { c[0].clone() } else { c[1].clone() };
    let range = if name.ends_with("mtf50") {
        let all = sorted(column(&all));
        all.first().copied().zip(all.last().copied())
    } else {
        top(&column(&all)).map(|t| (0.0, t))
    };
    for group in section.groups.iter().filter(|g| of(g).count > 0) {
        let summary = of(group);
        let values = column(&columns(section, section.rows_of(group.colors)));
        let mut plot = Plot::new(label, "Designs per bin")
            .title(format!("{}: {:.digits$}", colours(group.colors), summary.mean.value))
            .histogram(Histogram::new("", &values).color(color(group.colors)).interval(
                summary.p05.value,
                summary.mean.value,
                summary.p95.value,
            ));
        if let Some((low, high)) = range.filter(|(low, high)| low < high) {
            plot = plot.x_range(low, high);
        }
        panels = panels.panel(plot);
    }
    book.save(name, &panels.draw()?, 2.0)
}

/// Figures of all sections at once: means, and filters by rule over the cloud.
pub(super) fn together(sections: &[&Section<'_>], book: &mut Book) -> anyhow::Result<()> {
    let several = sections.len() > 1;
    let shown = sections.get(..SYMBOLS.len().min(sections.len())).unwrap_or_default();
    let title = if several {
        String::from("Means")
    } else {
        format!("Means, {}", shown.first().map_or_else(String::new, |s| s.title()))
    };
    let mut plot =
        Plot::new(MTF50, DELTA_E).title(title).note(format!("Bars hold 90 % of the designs. {BEST_WHERE}"));
    for (section, symbol) in shown.iter().zip([Symbol::Square].iter().chain(&SYMBOLS)) {
        for group in section.groups.iter().filter(|g| g.delta_e.count > 0) {
            let name = if several { section.title() } else { colours(group.colors) };
            plot = plot.points(mean(group, &name).color(color(group.colors)).symbol(*symbol));
        }
    }
    book.save("means", &plot.draw()?, 2.0)?;
    let marks: Vec<&&Section<'_>> =
        sections.iter().filter(|s| !s.labels.is_empty() && s.rows.len() <= MAX_MARKS).collect();
    let Some(rules) = marks.first() else { return Ok(()) };
    let cloud = sections.iter().find(|s| !s.results.is_named());
    by_rule(rules, cloud.copied(), book)
}

/// Filters by rule, over the designs and means of a cloud where there is one.
fn by_rule(rules: &Section<'_>, cloud: Option<&Section<'_>>, book: &mut Book) -> anyhow::Result<()> {
    let mut plot = match cloud {
        Some(cloud) => axes(cloud).title(format!("{} over {}", rules.title(), cloud.title())),
        None => Plot::new(MTF50, DELTA_E).title(rules.title()),
    };
    plot = plot.note(if cloud.is_some() {
        format!(
            "Squares are the means of {}, dots its designs. {BEST_WHERE}",
            cloud.map_or_else(String::new, |c| c.title())
        )
    } else {
        BEST_WHERE.into()
    });
    for (cloud, group) in cloud.iter().flat_map(|c| c.groups.iter().map(move |g| (c, g))) {
        let [x, y, _] = columns(cloud, cloud.rows_of(group.colors));
        let (m, d) = ([group.mtf50.mean.value], [group.delta_e.mean.value]);
        plot = plot
            .points(Points::new("", &x, &y).color(color(group.colors).mix(Rgb(255, 255, 255), 0.75)))
            .points(
                Points::new(colours(group.colors), &m, &d)
                    .symbol(Symbol::Square)
                    .color(color(group.colors))
                    .marks(),
            );
    }
    for ((label, groups), symbol) in rules.labels.iter().zip(SYMBOLS.iter().cycle()) {
        for (colors, rows) in groups {
            let [x, y, _] = columns(rules, rows.iter().copied());
            plot = plot.points(Points::new(label, &x, &y).symbol(*symbol).color(color(*colors)).marks());
        }
    }
    book.save("filters-by-rule", &plot.draw()?, 2.0)
}
