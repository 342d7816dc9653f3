//! The page of an experiment.

use smalti::experiment::RatingResult;
use smalti::numeric::bootstrap::Estimate;
use smalti::rating::{Agreement, MAX_LAPSE, OUTLIER_DISTANCE, Scales};

use super::RatingReport;
use super::figures;
use super::text::{agreement_words, basis, estimated, interval, light_words, number, reasons, shown_best};
use crate::comparison::columns::heading_of;
use crate::page::{DESIGN, Markup, Page, Table, copyable, el, foot, paragraph};
use crate::words::{command, quoted};

/// The page as HTML.
#[must_use]
pub fn page(report: &RatingReport<'_>) -> String {
    let mut page = Page::new(&report.answers.title)
        .with(DESIGN)
        .lead(el("p").child(format!("{}.", report.observers_words())));
    page = match &report.analysis.result {
        RatingResult::Scale { scales, agreement } => page
            .section("scale", "Scale", scale(report, scales))
            .section("scenes", "Scenes", scenes(report, scales))
            .section("agreement", "Agreement with metrics", agreements(agreement)),
        RatingResult::Light { varied, standard, levels, fit } => {
            let fit = fit.as_ref();
            let mut out =
                paragraph("headline", light_words(varied, standard, fit)).and(figures::light(levels, fit));
            if let Some(fit) = fit {
                out = out.and(facts(fit));
            }
            page.section("light", "Light for equal appearance", out).section(
                "answers",
                "Answers",
                light_table(levels),
            )
        }
    };
    page.section("observers", "Observers", observers(report))
        .section("again", "Reproduction", again(report))
        .foot(foot())
        .html()
}

/// A number with its interval in small print.
fn cell(estimate: &Estimate) -> Markup {
    let value = Markup::from(number(estimate.value, 2));
    match interval(estimate, 2) {
        Some(interval) => value.and(el("span").class("interval").child(format!(" {interval}"))),
        None => value,
    }
}

/// The conditions from the best on.
fn order(scores: &[Estimate]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..scores.len()).collect();
    order.sort_by(|&a, &b| scores[b].value.total_cmp(&scores[a].value));
    order
}

fn scale(report: &RatingReport<'_>, scales: &Scales) -> Markup {
    let all = match &scales.all {
        Ok(all) => all,
        Err(error) => return paragraph("none", format!("There is no scale: {error}.")),
    };
    let (conditions, order) = (report.conditions(), order(&all.jod));
    let ties: Vec<String> = order
        .iter()
        .skip(1)
        .filter(|&&i| all.below_best_jod[i].interval.is_none_or(|interval| interval.low <= 0.0))
        .map(|&i| conditions[i].clone())
        .collect();
    let best = order.first().map_or("", |&i| conditions[i].as_str());
    let headline = match ties.len() {
        0 => format!("{best} is preferred to all others."),
        _ => format!(
            "{best} has the highest score; these answers show no difference from {}.",
            crate::words::listed(&ties)
        ),
    };
    let mut table = Table::new("Scores of all scenes")
        .text("condition")
        .number("JOD")
        .number("below the best (JOD)")
        .number("Bradley–Terry (log odds)");
    for (rank, &i) in order.iter().enumerate() {
        let name = Markup::from(conditions[i].as_str());
        let cells = [name, cell(&all.jod[i]), cell(&all.below_best_jod[i]), cell(&all.log_odds[i])];
        table = table.row(cells, rank == 0);
    }
    paragraph("headline", headline)
        .and(figures::scale(&conditions, all, &order))
        .and(table)
        .and(paragraph("help", format!(
            "Thurstone’s Case V, in just-objectionable differences (JOD): of two conditions that differ by 1 JOD, 75 % of the choices prefer the better one. The \
             mean of all scores is 0. The model of Bradley and Terry states the logarithm of the odds. {}",
            basis(scales.basis)
        )))
}

fn scenes(report: &RatingReport<'_>, scales: &Scales) -> Markup {
    let mut table = Table::new("Scores of each scene (JOD)").text("scene");
    for condition in &report.answers.conditions {
        table = table.number(condition.name.as_str());
    }
    let mut without = Markup::new();
    for (name, scale) in report.answers.scenes.iter().zip(&scales.scenes) {
        match scale {
            Ok(scale) => {
                let cells = std::iter::once(Markup::from(name.as_str())).chain(scale.jod.iter().map(cell));
                table = table.row(cells, false);
            }
            Err(error) => {
                without = without.and(paragraph("none", format!("{name}: there is no scale: {error}.")))
            }
        }
    }
    let help = "Each scene has a scale of its own with a mean of 0. Scores of different scenes are not comparable, since no pair has pictures of both.";
    Markup::from(table).and(without).and(paragraph("help", help))
}

fn agreements(agreement: &[(String, Option<Agreement>)]) -> Markup {
    let best = shown_best(agreement);
    let mut table = Table::new("Rank correlation of each metric with the scores")
        .text("metric")
        .number("Spearman")
        .number("Kendall")
        .number("scenes");
    for (name, agreement) in agreement {
        let is_best = best == Some(name);
        let heading = Markup::from(heading_of(name));
        let cells = match agreement {
            Some(a) => [heading, cell(&a.spearman), cell(&a.kendall), Markup::from(a.scenes.to_string())],
            None => [heading, Markup::from("–"), Markup::from("–"), Markup::from("0")],
        };
        table = table.row(cells, is_best);
    }
    paragraph("headline", agreement_words(agreement)).and(table).and(paragraph(
        "help",
        "Each correlation is computed within a scene and averaged over the scenes; 1 means the same order, −1 the reverse. The sign of a metric of which smaller values are better is reversed. \
         The first three metrics are those of the pictures that were shown, the others those of the test targets (smalti list metrics). Intervals of 95 % resample the observers and, with five \
         scenes or more, also the scenes. These answers cannot rank metrics whose intervals overlap.",
    ))
}

fn facts(fit: &smalti::rating::PsychometricFit) -> Markup {
    let fact = |name: &str, value: String| Markup::from(el("dt").child(name)).and(el("dd").child(value));
    let list = fact("point of subjective equality", format!("{} stops", estimated(&fit.equality, 2)))
        .and(fact("spread", format!("{} stops", estimated(&fit.spread, 2))))
        .and(fact("lapse rate", format!("{} %", number(100.0 * fit.function.lapse, 0))))
        .and(fact("deviance", number(fit.deviance, 1)));
    Markup::from(el("dl").class("facts").child(list)).and(paragraph(
        "help",
        format!(
            "Bars are intervals of 95 % of each share. The curve is the psychometric function λ + (1 − 2 λ) Φ((x − e) / s), fitted by maximum likelihood: e is the point of subjective equality, which the dashed \
             line shows, s the spread and λ the lapse rate. The lapse rate is the share of answers given without regard to the pictures, such as slips of the hand, that prefer either side. It is limited to \
             {} %, since a larger one cannot be told from a flat curve; a fit at this limit may have more lapses. {}",
            number(100.0 * MAX_LAPSE, 0),
            basis(fit.basis)
        ),
    ))
}

fn light_table(levels: &[smalti::rating::Level]) -> Markup {
    let mut table = Table::new("Choices in each amount of light")
        .number("stops")
        .number("preferred")
        .number("answers")
        .number("%");
    for l in levels {
        let share = if l.asked > 0.0 { number(100.0 * l.chosen / l.asked, 0) } else { "–".into() };
        table = table.row([number(l.level, 2), l.chosen.to_string(), l.asked.to_string(), share], false);
    }
    table.into()
}

fn observers(report: &RatingReport<'_>) -> Markup {
    let mut table = Table::new("Observers")
        .text("observer")
        .number("answered")
        .number("consistent repeats")
        .number("traps passed")
        .number("log₁₀ likelihood")
        .number("distance")
        .number("pixel ratio")
        .number("display gamma")
        .text("excluded for");
    for (o, judged) in report.observers() {
        let of = |[part, all]: [u32; 2]| if all > 0 { format!("{part} of {all}") } else { "–".into() };
        let (mean, distance) = judged
            .screening
            .likelihood
            .map_or(("–".into(), "–".into()), |l| (number(l.mean_log10, 3), number(l.distance, 2)));
        let why = reasons(judged);
        table = table.row(
            [
                o.number.to_string(),
                format!("{} of {}", o.answered, o.pairs),
                of(o.choices.repeats),
                of(o.choices.traps),
                mean,
                distance,
                number(o.device_pixel_ratio, 2),
                o.gamma.map_or("–".into(), |g| number(g, 2)),
                why,
            ],
            false,
        );
    }
    let excluded = format!(
        "An observer is excluded who answered fewer than two thirds of the traps correctly, who chose differently in more than half of at least four hidden repeats, or whose choices are \
         improbable under the scale of all others: with five observers or more, their distance is more than {OUTLIER_DISTANCE}. Observers without ratings have answered no pair that \
         counts: they opened the page alone, or did its training alone. With "
    );
    let excluded = el("p")
        .class("help")
        .child(excluded)
        .child(el("code").class("option").child("--keep-all"))
        .child(", only these are excluded.");
    Markup::from(table)
        .and(paragraph(
            "help",
            "The log₁₀ likelihood is the mean decimal logarithm of the probability that the scale of all other observers gives to the choices: the nearer to 0, the more the observer chose as the others. The \
             distance is the number of interquartile ranges by which it lies below the first quartile of all observers, and 0 above this quartile.",
        ))
        .and(excluded)
}

fn again(report: &RatingReport<'_>) -> Markup {
    let commands = format!("{}\nsmalti rate analyse {}", command(report.command), quoted(report.folder));
    copyable(&commands, "commands")
}
