//! The beginning of the page of a comparison: the verdict for each light, and the scores against light.

use smalti::experiment::{Estimate, Outcome};
use smalti::numeric::bootstrap::Interval;

use super::figures::{LIGHT_SIZE, Named, against_light, beside, drawn, height, look};
use super::results::Comparison;
use super::verdict::{LightWords, ONCE, WORDS, amount};
use crate::page::{Markup, Table, el, paragraph};
use crate::words::listed;
use crate::{Line, Plot, Points, Scale};

/// The distance of the intervals of adjacent contenders, as a share of the luminance axis, so that they do not cover each other.
const APART: f64 = 0.022;

/// The verdict and the summary of all scores.
pub(super) fn summary(report: &Comparison<'_>) -> Markup {
    if report.contenders.len() < 2 {
        let none = paragraph("none", "One camera was scored; a verdict needs two.");
        return none.and(beside(score_figure(report)));
    }
    let mut lights = report.verdict_words(listed);
    lights.sort_by(|a, b| a.luminance_cd_m2.total_cmp(&b.luminance_cd_m2));
    let crossovers: Markup =
        report.crossover_words(true).into_iter().map(|words| paragraph("crossover", words)).collect();
    let others = report.crossover_words(false);
    let others = (!others.is_empty()).then(|| {
        let lines: Markup = others.into_iter().map(|words| paragraph("crossover", words)).collect();
        Markup::from(el("details").child(el("summary").child("Crossovers of the other cameras")).child(lines))
    });
    let reservations: Markup =
        report.conditions.reservations().into_iter().map(|words| paragraph("reservation", words)).collect();
    paragraph("headline", headline(&lights, report.contenders.len()))
        .and(reservations)
        .and(
            el("div")
                .class("verdicts")
                .children(lights.iter().map(|light| card(light, report.contenders.len()))),
        )
        .and(crossovers)
        .and(others.into_iter().collect::<Markup>())
        .and(paragraph("help", format!("{} {}", report.verdict_basis(), Comparison::verdict_limits())))
        .and(beside([difference_figure(report)].into_iter().chain(score_figure(report))))
        .and(values(report))
}

/// Who is the best at which light, in one sentence.
fn headline(lights: &[LightWords], contenders: usize) -> String {
    let mut groups: Vec<(&[String], Vec<String>)> = Vec::new();
    for light in lights {
        let cd_m2 = light.luminance_cd_m2.to_string();
        match groups.iter_mut().find(|(leaders, _)| *leaders == light.leaders) {
            Some((_, at)) => at.push(cd_m2),
            None => groups.push((&light.leaders, vec![cd_m2])),
        }
    }
    let one = |(leaders, at): &(&[String], Vec<String>)| {
        let at = format!("at {} cd/m²", listed(at));
        match leaders {
            [one] => format!("{at} {one} has the best CPSNR"),
            all if all.len() == contenders => {
                format!("{at} these scenes show no relevant difference in CPSNR")
            }
            some => format!("{at} {} share the best CPSNR", listed(some)),
        }
    };
    let sentence = groups.iter().map(one).collect::<Vec<_>>().join("; ") + ".";
    let mut letters = sentence.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The verdict in one light.
fn card(light: &LightWords, contenders: usize) -> Markup {
    let winner = match &light.leaders[..] {
        all if all.len() == contenders => "No difference in CPSNR that these scenes can show".to_owned(),
        some => format!("Best CPSNR: {}", some.join(" or ")),
    };
    let metric =
        |(name, words): &(&str, String)| Markup::from(el("dt").child(*name)).and(el("dd").child(words));
    let costs: Markup = light.costs.iter().map(|words| Markup::from(el("li").child(words))).collect();
    let costs = (!light.costs.is_empty())
        .then(|| paragraph("costs", format!("Cost ({ONCE}):")).and(el("ul").class("costs").child(costs)));
    el("article")
        .class("verdict")
        .child(el("h3").child(format!("{} cd/m²", light.luminance_cd_m2)))
        .child(paragraph("winner", winner))
        .child(el("dl").children(light.metrics.iter().map(metric)))
        .children(costs)
        .into()
}

/// Places in `luminances`, from dim to bright.
fn ascending(luminances: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..luminances.len()).collect();
    order.sort_by(|a, b| luminances[*a].total_cmp(&luminances[*b]));
    order
}

/// The difference of every contender from the first one in CPSNR, with its interval, against luminance.
fn difference_figure(report: &Comparison<'_>) -> Markup {
    let luminances = report.luminances();
    let order = ascending(&luminances);
    let (first, count) = (report.contender_name(0), report.contenders.len());
    let mut plot = Plot::new("Luminance (cd/m²)", "CPSNR difference (dB)")
        .title(format!("CPSNR: difference from {first}"))
        .note(if report.verdict.has_intervals() {
            "Bars are 95 % confidence intervals of the paired difference. Where a bar crosses the line of the first camera, these scenes show no difference."
        } else {
            "One scene with one noise realisation has no confidence intervals."
        })
        .x_scale(Scale::Log)
        .x_ticks(&luminances)
        .size(LIGHT_SIZE.0, height(count))
        .direct_labels();
    let mut zero: Vec<f64> = order.iter().map(|&light| luminances[light]).collect();
    if let [only] = zero[..] {
        zero = vec![only / 1.5, only * 1.5];
    }
    let range = zero.last().zip(zero.first()).map_or(1.0, |(high, low)| high / low);
    let dodge = |contender: usize| range.powf(APART * (contender as f64 - 0.5 * count as f64));
    plot = plot.line(Line::new(first, &zero, &vec![0.0; zero.len()]).color(look(0).0).width(2.0).dashed());
    for contender in 1..count {
        let of = |light: usize| {
            Some(*report.verdict.lights.get(light)?.metrics.first()?.from_first.get(contender)?)
        };
        let points: Vec<(f64, Estimate)> = order
            .iter()
            .filter_map(|&light| Some((luminances[light] * dodge(contender), of(light)?)))
            .filter(|(_, difference)| difference.value.is_finite())
            .collect();
        let (x, differences): (Vec<f64>, Vec<Estimate>) = points.into_iter().unzip();
        let y: Vec<f64> = differences.iter().map(|d| d.value).collect();
        let ends = |d: &Estimate| d.interval.map_or((d.value, d.value), |Interval { low, high }| (low, high));
        let intervals: Vec<(f64, f64)> = differences.iter().map(ends).collect();
        let (color, symbol) = look(contender);
        let marks =
            Points::new(report.contender_name(contender), &x, &y).color(color).symbol(symbol).radius(5.0);
        plot = plot.line(Line::new("", &x, &y).color(color).width(2.0)).points(marks.y_intervals(&intervals));
    }
    drawn(&plot)
}

/// The CPSNR of every contender against luminance; nothing for a single luminance.
fn score_figure(report: &Comparison<'_>) -> Option<Markup> {
    let luminances = report.luminances();
    let named = |(number, outcomes): (usize, &Vec<Outcome>)| {
        (report.contender_name(number), outcomes.iter().map(|o| o.means()[0]).collect())
    };
    let series: Named = report.outcomes.iter().enumerate().map(named).collect();
    (luminances.len() > 1).then(|| against_light(&luminances, "CPSNR (dB)", &series))
}

/// All differences as a table, folded.
fn values(report: &Comparison<'_>) -> Markup {
    let first = report.contender_name(0);
    let mut table = Table::new(format!("Differences from {first}, with intervals"))
        .number("Luminance, cd/m²")
        .text("Camera");
    for (name, unit, _) in WORDS {
        table = table.number(if unit.is_empty() { name.to_owned() } else { format!("{name},{unit}") });
    }
    let luminances = report.luminances();
    for light in ascending(&luminances) {
        let Some(verdict) = report.verdict.lights.get(light) else { continue };
        for contender in 1..report.contenders.len() {
            let differences = verdict.metrics.iter().zip(WORDS).map(|(metric, (_, _, digits))| {
                metric.from_first.get(contender).map_or_else(String::new, |d| amount(d, "", digits))
            });
            let before = [luminances[light].to_string(), report.contender_name(contender)];
            table = table.row(before.into_iter().chain(differences), false);
        }
    }
    el("details").child(el("summary").child("The differences as numbers")).child(table).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(luminance_cd_m2: f64, leaders: &[&str]) -> LightWords {
        let leaders = leaders.iter().map(|s| (*s).to_owned()).collect();
        LightWords { luminance_cd_m2, leaders, metrics: Vec::new(), costs: Vec::new() }
    }

    #[test]
    fn the_headline_groups_lights() {
        let lights = [light(1.0, &["rgbw"]), light(10.0, &["rgbw"]), light(80.0, &["bayer", "rgbw"])];
        assert_eq!(
            headline(&lights, 2),
            "At 1 and 10 cd/m² rgbw has the best CPSNR; at 80 cd/m² these scenes show no relevant difference in CPSNR."
        );
        assert_eq!(headline(&lights[2..], 3), "At 80 cd/m² bayer and rgbw share the best CPSNR.");
    }
}
