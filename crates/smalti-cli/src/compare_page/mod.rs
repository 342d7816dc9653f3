//! `report.html` of `compare` and of `evaluate`: pictures to look at side by side, scores, filters, kernels.

mod again;
mod evaluated;
mod figures;
mod gallery;
mod learned;
mod maps;
mod tables;

pub(crate) use evaluated::{Shots, page as evaluate_page};

use rayon::prelude::*;
use serde_json::json;
use smalti::camera::LightGain;
use smalti_report::Sheet;
use smalti_report::page::{COMPARE, Markup, Page, el};

use crate::compare::{Outcome, Way};
use crate::compare_report::{Report, mean, stem};
use crate::pictures::Pixels;
use figures::{Named, Scored};
use gallery::{Group, Shot};
use maps::DIFFERENCES;

/// The page of both commands.
pub(crate) const FILE: &str = "report.html";

fn foot() -> Markup {
    let text = format!(
        "Made by Smalti {}. This page needs no network and sends nothing.",
        env!("CARGO_PKG_VERSION")
    );
    el("p").child(text).into()
}

/// Names in a row: `a, b and c`.
fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// The page of a comparison.
pub(crate) fn page(report: &Report<'_>) -> anyhow::Result<String> {
    let names: Vec<String> = report.ways.iter().map(Way::name).collect();
    let learned = report.learned_ways();
    let scored = scored(report);
    let kinds = DIFFERENCES.each_ref().map(|d| &d.maps);
    let mut page = Page::new(format!("{} compared", listed(&names)))
        .with(COMPARE)
        .lead(lead(report))
        .section("pictures", "Pictures", gallery::gallery(&groups(report)?, &kinds))
        .section("scores", "Scores", tables::scores(report).and(tables::scenes(report)))
        .section("light", "Quality against light", light(report));
    let filters =
        report.cameras.iter().zip(report.labels).map(|(camera, label)| figures::filters(camera, label));
    page = page
        .section("filters", "Filters", el("div").class("cameras").children(filters))
        .section("edges", "Sharpness", figures::edges(&scored))
        .section("noise", "Noise", figures::noise(&scored).and(noise_tables(&scored)));
    if !learned.is_empty() {
        page = page.section("kernels", "Learned pipelines", learned::section(&learned));
    }
    let data: Vec<_> = learned.par_iter().map(|(way, pipeline)| learned::data(way, pipeline)).collect();
    let facts = [
        ("Smalti", env!("CARGO_PKG_VERSION").to_owned()),
        ("seed", report.args.camera_options.seed.to_string()),
        ("light", report.args.illuminant.clone()),
        ("scenes", report.scene_names().join(", ")),
    ];
    let cameras: Vec<_> = report.labels.iter().cloned().zip(report.cameras).collect();
    Ok(page
        .section(
            "again",
            "The same again",
            again::section(&report.args.words, &report.args.cameras, &facts, &cameras)?,
        )
        .data("compare", json!({"learned": data}))
        .foot(foot())
        .html())
}

fn lead(report: &Report<'_>) -> Markup {
    let lights: Vec<String> = (0..report.light_count()).map(|l| report.luminance(l).to_string()).collect();
    let scenes: Vec<String> = report.scene_names().iter().map(|s| stem(s)).collect();
    let text = format!(
        "{} at {} cd/m², light {}, seed {}, all noise.",
        listed(&scenes),
        listed(&lights),
        report.args.illuminant,
        report.args.camera_options.seed
    );
    let mut out: Markup = el("p").child(text).into();
    if !report.left_out.is_empty() {
        let text = format!("Left out, as defined for Bayer mosaics only: {}.", listed(report.left_out));
        out = out.and(el("p").class("warning").attr("role", "note").child(text));
    }
    out
}

/// The maps of all ways in a scene and light, with the colours they share.
pub(crate) fn maps_sheet<'a>(report: &'a Report<'a>, title: String, light: usize, scene: usize) -> Sheet {
    let of = |(way, outcomes): (&Way<'_>, &'a Vec<Outcome>)| {
        Some((way.name(), &outcomes.get(light)?.scenes.get(scene)?.1))
    };
    maps::sheet(title, &report.ways.iter().zip(report.outcomes).filter_map(of).collect::<Vec<_>>())
}

/// The pictures of each scene in each light, the reference first.
fn groups(report: &Report<'_>) -> anyhow::Result<Vec<Group>> {
    let mut groups = Vec::new();
    for scene in 0..report.scene_count() {
        for light in 0..report.light_count() {
            let here = |o: &Outcome| o.scenes.get(scene).cloned();
            let all: Vec<_> = report.outcomes.iter().filter_map(|o| here(o.get(light)?)).collect();
            let Some((name, first)) = all.first() else { continue };
            let tops = DIFFERENCES.each_ref().map(|d| d.top(all.iter().map(|(_, s)| s)));
            let mut shots = vec![Shot {
                name: "reference".into(),
                caption: "what the standard observer would see".into(),
                picture: Pixels::of(&report.as_seen(first, &first.reference)?),
                maps: Vec::new(),
            }];
            for (way, (_, s)) in report.ways.iter().zip(&all) {
                let scores = &s.scores;
                shots.push(Shot {
                    name: way.name(),
                    caption: format!(
                        "CPSNR {:.1} dB, ΔE2000 {:.2}, S-CIELAB {:.2}",
                        scores.cpsnr_db, scores.pixel_delta_e_2000_mean, scores.scielab_mean
                    ),
                    picture: Pixels::of(&report.as_seen(s, &s.picture)?),
                    maps: DIFFERENCES.iter().zip(tops).map(|(d, top)| d.map(scores, top)).collect(),
                });
            }
            let (scene, luminance_cd_m2) = (stem(name), report.luminance(light));
            groups.push(Group { scene, luminance_cd_m2, shots, tops: tops.to_vec() });
        }
    }
    // Scenes of one name are told apart in the chooser as they are in the names of files.
    let stems: Vec<String> = report.scene_names().iter().map(|s| stem(s)).collect();
    let numbered = crate::names::numbered(stems);
    let lights = report.light_count().max(1);
    groups
        .iter_mut()
        .enumerate()
        .for_each(|(i, g)| g.scene = numbered.get(i / lights).unwrap_or(&g.scene).clone());
    Ok(groups)
}

fn light(report: &Report<'_>) -> Markup {
    let luminances: Vec<f64> = (0..report.light_count()).map(|l| report.luminance(l)).collect();
    let of = |f: fn(&Outcome) -> f64| -> Named {
        let way = |(way, outcomes): (&Way<'_>, &Vec<Outcome>)| (way.name(), outcomes.iter().map(f).collect());
        report.ways.iter().zip(report.outcomes).map(way).collect()
    };
    let mut out = if luminances.len() > 1 {
        figures::against_light(
            &luminances,
            &[
                ("CPSNR (dB)", of(|o| mean(o, |s| s.scores.cpsnr_db))),
                ("S-CIELAB difference (ΔE*ab)", of(|o| mean(o, |s| s.scores.scielab_mean))),
            ],
        )
    } else {
        el("p")
            .class("none")
            .child("One luminance was compared; --luminance 1,10,80 draws curves here.")
            .into()
    };
    if report.gains.is_empty() {
        return out.and(el("p").class("help").child(
            "How much more light the first camera needs to equal the others: the same command with --light-gain.",
        ));
    }
    if luminances.len() > 1 {
        out = out.and(gain_figures(report, &luminances));
    }
    out = out.and(tables::gains(report.gains));
    out.and(el("p").class("help").child(
        "Below 0 the first camera needs less light. Gains are found on pictures of their own: up to two scenes, and four captures of the \
         ColorChecker.",
    ))
}

/// The light gain against luminance, a figure for each camera that is to be equalled. Bounds are no points: they are in the tables.
fn gain_figures(report: &Report<'_>, luminances: &[f64]) -> Markup {
    let mut others: Vec<&str> = report.gains.iter().map(|g| g.other.as_str()).collect();
    others.dedup();
    let figures = others.into_iter().map(|other| {
        let gains: Vec<_> = report.gains.iter().filter(|g| g.other == other).collect();
        let metrics = gains.first().map_or(&[][..], |g| g.gains.metrics.as_slice());
        let series = metrics.iter().enumerate().map(|(i, m)| {
            let value = |g: &&crate::compare::Gain| match g.gains.metrics.get(i).map(|m| m.gain) {
                Some(LightGain::Stops(stops)) => stops,
                _ => f64::NAN,
            };
            (tables::metric_name(m.metric).to_owned(), gains.iter().map(value).collect())
        });
        let label = format!("Light gain of {other} (stops)");
        figures::against_light(luminances, &[(label.as_str(), series.collect())])
    });
    figures.collect()
}

/// For each light the scores of the targets.
fn scored<'a>(report: &'a Report<'_>) -> Vec<Vec<Scored<'a>>> {
    let of_light = |light: usize| {
        let one = |(way, outcomes): (&Way<'_>, &'a Vec<Outcome>)| {
            let outcome = outcomes.get(light)?;
            Some(Scored {
                name: way.name(),
                luminance_cd_m2: outcome.luminance_cd_m2,
                evaluation: &outcome.targets,
                edge: outcome.edge.as_ref(),
                pitch_m: way.camera.sensor.pixel.pitch_m,
            })
        };
        report.ways.iter().zip(report.outcomes).filter_map(one).collect()
    };
    (0..report.light_count()).map(of_light).collect()
}

/// The figures of the noise as tables, folded away.
fn noise_tables(scored: &[Vec<Scored<'_>>]) -> Markup {
    let table = |of_light: &Vec<Scored<'_>>| {
        let first = of_light.first()?;
        let columns: Vec<(String, Vec<f64>)> = of_light
            .iter()
            .map(|s| (s.name.clone(), s.evaluation.luminance_noise_percent.per_patch.clone()))
            .collect();
        let patches = columns.first().map_or(0, |(_, v)| v.len());
        let names: Vec<String> = (1..=patches).map(|p| p.to_string()).collect();
        let caption =
            format!("Luminance noise at {} cd/m², %, by grey patch from white", first.luminance_cd_m2);
        Some(tables::patches(caption, "Patch", &names, &columns, 2))
    };
    el("details").child(el("summary").child("The figures")).children(scored.iter().filter_map(table)).into()
}
