//! Clouds of designs, their means and fronts.

use smalti::design::statistics::{Objective, Summary, pareto_front, quantile_of_sorted};

use super::book::Book;
use super::filters;
use super::sections::{Group, Section};
use crate::{Corner, Histogram, Line, OKABE_ITO, Panels, Plot, Points, ReportError, Rgb, Scale, Symbol};

/// All figures that a report may have.
const NAMES: [&str; 13] = [
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
const BEST_WHERE: &str = "The best designs are at the lower right.";
/// Quantiles of the designs that bound the axis of MTF50: a few outliers would compress the others.
const SHOWN: [f64; 2] = [0.002, 0.99];
/// The axis of ΔE is logarithmic above this ratio of the largest to the smallest value.
const LOGARITHMIC: f64 = 6.0;
/// Quantiles of the designs that bound histograms.
const HISTOGRAM: [f64; 2] = [0.005, 0.98];
/// The largest number of designs by rule, or of a front, that are drawn as marks.
pub(super) const MAX_MARKS: usize = 400;
const SYMBOLS: [Symbol; 5] =
    [Symbol::Circle, Symbol::TriangleUp, Symbol::Star, Symbol::Diamond, Symbol::TriangleDown];
const INK: Rgb = Rgb(30, 30, 30);

/// The names of all files that the figures of a report may have in a folder, so that those of an earlier report can be removed.
#[must_use]
pub fn figure_files() -> Vec<String> {
    NAMES.iter().flat_map(|name| ["svg", "png"].map(|extension| format!("{name}.{extension}"))).collect()
}

/// The colour that stands for a number of colours in all figures.
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

/// The ends of an axis: quantiles that leave out outliers. An axis that would leave out little more than its margin
/// shows all designs.
fn ends(values: &[f64], shares: [f64; 2]) -> Option<(f64, f64)> {
    let sorted = sorted(values.to_vec());
    let (first, last) = (*sorted.first()?, *sorted.last()?);
    let [low, high] = shares.map(|share| quantile_of_sorted(&sorted, share));
    let reach = 0.25 * (high - low);
    let low = if first > low - reach { first } else { low };
    let high = if last < high + reach { last } else { high };
    (low < high).then_some((low, high))
}

/// Sets the axis of ΔE: logarithmic where designs differ by a large ratio.
fn with_delta_e(plot: Plot, values: impl Iterator<Item = f64>) -> Plot {
    let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
    if low > 0.0 && high > LOGARITHMIC * low {
        return plot.y_scale(Scale::Log).y_range(low / 1.15, high * 1.15);
    }
    if high > 0.0 { plot.y_range(0.0, 1.05 * high) } else { plot }
}

/// The axes that all clouds of a section share.
fn axes(section: &Section<'_>) -> Plot {
    let [mtf50, delta_e, _] = columns(section, section.rows.clone());
    let plot = with_delta_e(Plot::new(MTF50, DELTA_E), delta_e.iter().copied());
    match ends(&mtf50, SHOWN) {
        Some((low, high)) => {
            // The best designs must be visible.
            let best = section.groups.iter().filter_map(|g| Some(section.scores(*g.best.first()?)[1]));
            let (low, high) = best.fold((low, high), |(l, h), v| (l.min(v), h.max(v)));
            let margin = 0.03 * (high - low);
            plot.x_range(low - margin, high + margin)
        }
        None => plot,
    }
}

/// Figures of one condition with one processing.
pub(super) fn of_section(section: &Section<'_>, book: &mut Book<'_>) -> Result<(), ReportError> {
    if !section.results.has_plane() {
        return filters::of_section(section, book);
    }
    let (title, axes) = (section.title(), axes(section));
    let count = section.groups.iter().map(|g| g.delta_e.count).sum::<usize>();
    let mut cloud = axes
        .clone()
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
        .note(format!("Squares are means; bars contain 90 % of the designs. {BEST_WHERE}"))
        .without_legend();
    for group in &section.groups {
        let [x, y, _] = columns(section, section.rows_of(group.colors));
        let mut plot = axes
            .clone()
            .title(colours(group.colors))
            .points(Points::new("", &x, &y).color(pale(group.colors)));
        if group.delta_e.count > 0 {
            plot = plot.points(mean(group, "").color(color(group.colors)));
        }
        panels = panels.panel(plot);
    }
    book.save("panels-by-colours", &panels.draw()?, 2.0)?;
    drop(panels);

    let [x, y, noise] = columns(section, section.rows.clone());
    let mut plot = axes
        .clone()
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

    front(section, &axes, book)?;
    histograms(section, "histogram-delta-e", "Colour error", DELTA_E, 1, |g| &g.delta_e, book)?;
    histograms(section, "histogram-mtf50", "Resolution", MTF50, 0, |g| &g.mtf50, book)?;
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

/// The front above the cloud. The line is the front of ΔE and MTF50 alone.
fn front(section: &Section<'_>, axes: &Plot, book: &mut Book<'_>) -> Result<(), ReportError> {
    let [x, y, _] = columns(section, section.rows.clone());
    let mut plot = axes
        .clone()
        .title(format!("Pareto front, {}", section.title()))
        .note("Dots: designs that no other design beats in ΔE, MTF50 and luminance noise at once. Line: the front of ΔE and MTF50 alone.")
        .points(Points::new("all designs", &x, &y).color(Rgb(215, 215, 215)));
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
            let points = Points::new(colours(group.colors), &x, &y).color(color(group.colors)).radius(4.0);
            plot = plot.points(if section.front.len() <= MAX_MARKS { points.marks() } else { points });
        }
    }
    book.save("pareto-front", &plot.draw()?, 2.0)
}

/// Histograms of column `column` of [`columns`], a panel for each number of colours.
fn histograms(
    section: &Section<'_>,
    name: &str,
    title: &str,
    label: &str,
    column: usize,
    summary: fn(&Group) -> &Summary,
    book: &mut Book<'_>,
) -> Result<(), ReportError> {
    let values = |rows: &mut dyn Iterator<Item = usize>| {
        columns(section, rows).into_iter().nth(column).unwrap_or_default()
    };
    let mut panels = Panels::new(3)
        .title(format!("{title}, {}", section.title()))
        .note("Above the bars: the mean, and the interval that contains 90 % of the designs.")
        .without_legend();
    let range = ends(&values(&mut section.rows.clone()), HISTOGRAM).map(|range| {
        let bounds = section.groups.iter().flat_map(|g| [summary(g).p05.value, summary(g).p95.value]);
        let (low, high) = bounds.fold(range, |(l, h), v| (l.min(v), h.max(v)));
        let margin = 0.04 * (high - low);
        (low - margin, high + margin)
    });
    if section.groups.iter().all(|g| summary(g).count == 0) {
        return Ok(());
    }
    for group in section.groups.iter().filter(|g| summary(g).count > 0) {
        let Summary { mean, p05, p95, .. } = summary(group);
        let histogram = Histogram::new("", &values(&mut section.rows_of(group.colors)))
            .color(color(group.colors))
            .interval(p05.value, mean.value, p95.value);
        let mut plot = Plot::new(label, "Designs per bin")
            .title(format!(
                "{}: mean {:.*}",
                colours(group.colors),
                if mean.value < 20.0 { 2 } else { 1 },
                mean.value
            ))
            .histogram(histogram);
        if let Some((low, high)) = range {
            plot = plot.x_range(low, high);
        }
        panels = panels.panel(plot);
    }
    book.save(name, &panels.draw()?, 2.0)
}

/// Means of all sections together.
pub(super) fn means(sections: &[&Section<'_>]) -> Option<Plot> {
    let sections: Vec<&&Section<'_>> = sections.iter().filter(|s| s.results.has_plane()).collect();
    let several = sections.len() > 1;
    let symbols = [Symbol::Square].into_iter().chain(SYMBOLS);
    let first = sections.first()?;
    let mut note = format!("Bars contain 90 % of the designs. {BEST_WHERE}");
    if several {
        note = format!("Squares: {}. {note}", first.title());
    }
    let shown: Vec<_> = sections.iter().zip(symbols).collect();
    let bounds =
        shown.iter().flat_map(|(s, _)| &s.groups).flat_map(|g| [g.delta_e.p05.value, g.delta_e.p95.value]);
    let mut plot = with_delta_e(Plot::new(MTF50, DELTA_E), bounds.filter(|v| v.is_finite()))
        .title(if several { "Means".to_owned() } else { format!("Means, {}", first.title()) })
        .note(note);
    for (i, (section, symbol)) in shown.iter().enumerate() {
        for group in section.groups.iter().filter(|g| g.delta_e.count > 0) {
            let name = if i > 0 { section.title() } else { colours(group.colors) };
            plot = plot.points(mean(group, &name).color(color(group.colors)).symbol(*symbol));
        }
    }
    Some(plot)
}

/// Figures of all sections together: means, and filters by rule above the cloud.
pub(super) fn together(sections: &[&Section<'_>], book: &mut Book<'_>) -> Result<(), ReportError> {
    let Some(means) = means(sections) else { return Ok(()) };
    book.save("means", &means.draw()?, 2.0)?;
    let marks: Vec<&&Section<'_>> = sections
        .iter()
        .filter(|s| s.results.has_plane() && !s.labels.is_empty() && s.rows.len() <= MAX_MARKS)
        .collect();
    let Some(rules) = marks.first() else { return Ok(()) };
    let cloud = sections.iter().find(|s| s.results.has_plane() && !s.results.is_named());
    by_rule(rules, cloud.copied(), book)
}

/// Filters by rule, above the designs and means of a cloud where there is one.
fn by_rule(rules: &Section<'_>, cloud: Option<&Section<'_>>, book: &mut Book<'_>) -> Result<(), ReportError> {
    let own = rules.rows.clone().map(|r| rules.scores(r));
    let means = cloud.iter().flat_map(|c| &c.groups).map(|g| [g.delta_e.mean.value, g.mtf50.mean.value, 0.0]);
    let marks: Vec<[f64; 3]> = own.chain(means).filter(|s| s[0].is_finite()).collect();
    let mut plot = with_delta_e(Plot::new(MTF50, DELTA_E), marks.iter().map(|m| m[0])).size(900.0, 760.0);
    let (low, high) = marks.iter().fold((f64::INFINITY, 0.0f64), |(l, h), m| (l.min(m[1]), h.max(m[1])));
    if low < high {
        let margin = 0.15 * (high - low);
        plot = plot.x_range(low - margin, high + margin);
    }
    let (title, note) = match cloud.map(Section::title) {
        Some(cloud) => (
            format!("{} over {cloud}", rules.title()),
            format!("Dots: designs of {cloud}, squares: their means. {BEST_WHERE}"),
        ),
        None => (rules.title(), BEST_WHERE.to_owned()),
    };
    plot = plot.title(title).note(note);
    let scored = |g: &&Group| g.delta_e.count > 0;
    for (cloud, group) in cloud.iter().flat_map(|c| c.groups.iter().filter(scored).map(move |g| (c, g))) {
        let [x, y, _] = columns(cloud, cloud.rows_of(group.colors));
        let (m, d) = ([group.mtf50.mean.value], [group.delta_e.mean.value]);
        let mean =
            Points::new(colours(group.colors), &m, &d).symbol(Symbol::Square).color(color(group.colors));
        let dots = Points::new("", &x, &y).color(color(group.colors).mix(Rgb(255, 255, 255), 0.7));
        plot = plot.points(dots).points(mean.marks());
    }
    for ((label, groups), symbol) in rules.labels.iter().zip(SYMBOLS.iter().cycle()) {
        for (colors, rows_of) in groups {
            let [x, y, _] = columns(rules, rows_of.iter().copied());
            plot = plot.points(Points::new(label, &x, &y).symbol(*symbol).color(color(*colors)).marks());
        }
    }
    // Without a cloud, the legend does not explain the colours yet.
    if cloud.is_none() {
        for group in &rules.groups {
            plot =
                plot.line(Line::new(colours(group.colors), &[], &[]).color(color(group.colors)).width(6.0));
        }
    }
    book.save("filters-by-rule", &plot.draw()?, 2.0)
}
