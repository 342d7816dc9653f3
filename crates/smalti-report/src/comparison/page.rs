//! The page of a comparison: pictures to look at side by side, scores, filters, kernels.

use rayon::prelude::*;
use serde_json::json;
use smalti::camera::LightGain;
use smalti::experiment::{Contender, Outcome, PairwiseLightGain};

use super::figures::{self, Scored};
use super::gallery::{self, Group, Shot};
use super::maps::DIFFERENCES;
use super::results::Comparison;
use super::text::GAIN_BASIS;
use super::{again, chart, crops, learned, summary, tables};
use crate::page::{COMPARE, Markup, Page, el, foot, paragraph};
use crate::pictures::Pixels;
use crate::words::listed;
use crate::{ReportError, names};

/// The size of a page, bytes, that its pictures may not exceed together with all else.
const MAX_BYTES: usize = 6_000_000;
/// Pages that are made until one fits. The first leaves room for the usual tables and kernels.
const ATTEMPTS: usize = 3;

/// The page of a comparison as HTML. It is smaller than 6 MB, unless its tables and pipelines alone are larger: pictures and crops
/// are compressed more or left out, which the page states.
///
/// # Errors
/// When a picture cannot be converted, or a camera cannot be written as text.
pub fn page(report: &Comparison<'_>) -> Result<String, ReportError> {
    // Scenes of equal names are numbered in the chooser as in the names of files.
    let scenes = names::numbered(report.scene_labels.to_vec());
    let groups = groups(report, &scenes)?;
    within(MAX_BYTES, |reserved| page_beside(report, (&groups, &scenes), reserved))
}

/// Makes a page with more and more bytes reserved for what is not a picture, until it is at most as large as `most`.
fn within<E>(most: usize, mut make: impl FnMut(usize) -> Result<String, E>) -> Result<String, E> {
    let mut reserved = 0;
    let mut page = make(reserved)?;
    for _ in 1..ATTEMPTS {
        let excess = page.len().saturating_sub(most);
        if excess == 0 {
            break;
        }
        reserved += excess;
        page = make(reserved)?;
    }
    Ok(page)
}

/// The page with `reserved` bytes of those of pictures kept free.
fn page_beside(
    report: &Comparison<'_>,
    (groups, scenes): (&[Group], &[String]),
    reserved: usize,
) -> Result<String, ReportError> {
    let title: Vec<String> = report.contenders.iter().map(Contender::name).collect();
    let learned = report.learned();
    let scored = scored(report);
    let (crops, used) = crops::crops(report, groups, scenes, gallery::MAX_BYTES.saturating_sub(reserved));
    let charts = chart::colors(&scored);
    let kinds = DIFFERENCES.each_ref().map(|d| &d.maps);
    let mut page = Page::new(format!("{} compared", listed(&title)))
        .with(COMPARE)
        .lead(lead(report))
        .section("verdict", "Verdict", summary::summary(report))
        .section("crops", "Regions with the largest differences", crops)
        .section(
            "pictures",
            "Pictures",
            gallery::gallery(groups, &kinds, reserved + used + charts.as_str().len()),
        )
        .section("scores", "Scores", tables::scores(report).and(tables::scenes(report)))
        .section("light", "Quality against light", light(report))
        .section("colours", "Colours", charts)
        .section("filters", "Filters", figures::all_filters(report.cameras, report.labels))
        .section("edges", "Sharpness", figures::edges(&scored))
        .section("noise", "Noise", figures::noise(&scored).and(tables::noise(&scored)));
    if !learned.is_empty() {
        page = page.section("kernels", "Learned pipelines", learned::section(&learned));
    }
    let data: Vec<_> = learned
        .par_iter()
        .map(|(contender, pipeline, _)| learned::data(contender, pipeline))
        .collect::<Result<_, _>>()?;
    let (scenes, cameras) = (Some(report.scene_names()), (report.cameras, report.labels));
    let again = again::section(report.command, (report.seed_words(), report.light_words()), scenes, cameras)?;
    Ok(page
        .section("again", "Reproduction", again)
        .data("compare", json!({"learned": data}))
        .foot(foot())
        .html())
}

impl Comparison<'_> {
    /// The region of each scene in which the cameras differ most, for another page; the pictures take at most `most` bytes.
    ///
    /// # Errors
    /// When a picture cannot be converted.
    pub fn telling_crops(&self, most: usize) -> Result<Markup, ReportError> {
        let scenes = names::numbered(self.scene_labels.to_vec());
        Ok(crops::crops(self, &groups(self, &scenes)?, &scenes, most).0)
    }
}

fn lead(report: &Comparison<'_>) -> Markup {
    let lights: Vec<String> = report.luminances().iter().map(f64::to_string).collect();
    let text = format!(
        "{} at {} cd/m², {}, all kinds of noise. Light: {}.",
        listed(report.scene_labels),
        listed(&lights),
        report.seed_words(),
        report.light_words()
    );
    let lead = Markup::from(el("p").child(text));
    if report.left_out.is_empty() {
        return lead;
    }
    let text =
        format!("Left out, since they are defined for Bayer mosaics only: {}.", listed(report.left_out));
    lead.and(el("p").class("warning").attr("role", "note").child(text))
}

/// The pictures of each scene at each luminance, the reference first.
fn groups(report: &Comparison<'_>, scenes: &[String]) -> Result<Vec<Group>, ReportError> {
    let mut groups = Vec::new();
    for scene in 0..report.scene_count() {
        for (light, luminance_cd_m2) in report.luminances().into_iter().enumerate() {
            let all: Vec<_> = report.of_scene(light, scene).collect();
            let Some((_, first)) = all.first() else { continue };
            let tops = DIFFERENCES.each_ref().map(|d| d.top(all.iter().map(|(_, s)| &s.scores)));
            let mut shots = vec![Shot {
                name: "reference".into(),
                is_reference: true,
                caption: "as the standard observer sees the scene".into(),
                picture: Pixels::of(&report.as_seen(&first.scores, &first.scores.reference)?),
                maps: Vec::new(),
            }];
            for (contender, scored) in &all {
                let seen = &scored.scores;
                let scores = &seen.scores;
                shots.push(Shot {
                    name: contender.name(),
                    is_reference: false,
                    caption: format!(
                        "CPSNR {:.1} dB, ΔE2000 {:.2}, S-CIELAB {:.2}",
                        scores.cpsnr_db, scores.pixel_delta_e_2000_mean, scores.scielab_mean
                    ),
                    picture: Pixels::of(&report.as_seen(seen, &seen.picture)?),
                    maps: DIFFERENCES.iter().zip(tops).map(|(d, top)| d.map(scores, top)).collect(),
                });
            }
            let scene = scenes.get(scene).cloned().unwrap_or_default();
            groups.push(Group { scene, luminance_cd_m2, shots, tops: tops.to_vec() });
        }
    }
    Ok(groups)
}

fn light(report: &Comparison<'_>) -> Markup {
    let luminances = report.luminances();
    let of = |label: &str, f: fn(&Outcome) -> f64| {
        let values = |(number, outcomes): (usize, &Vec<Outcome>)| {
            (report.contender_name(number), outcomes.iter().map(f).collect())
        };
        figures::against_light(&luminances, label, &report.outcomes.iter().enumerate().map(values).collect())
    };
    let mut out = if luminances.len() > 1 {
        figures::beside([
            of("ΔE2000", |o| o.means()[1]),
            of("S-CIELAB difference (ΔE*ab)", |o| o.means()[2]),
            if report.has_one_pitch() {
                of("MTF50 (cy/mm)", |o| o.targets.mtf50_cy_per_mm)
            } else {
                of("MTF50 (cycles/pixel)", |o| o.targets.mtf50_cy_per_px)
            },
            of("Luminance noise (%)", |o| o.targets.luminance_noise_percent.mean),
        ])
    } else {
        paragraph(
            "none",
            "One luminance was compared. With several, such as --luminance 1,10,80, curves are drawn here.",
        )
    };
    if report.gains.is_empty() {
        return out.and(paragraph(
            "help",
            "The same command with --light-gain finds how much more light the first camera needs to equal the others.",
        ));
    }
    if luminances.len() > 1 {
        out = out.and(gain_figures(report, &luminances));
    }
    out = out.and(tables::gains(report.gains));
    out.and(paragraph("help", GAIN_BASIS))
}

/// The light gain against luminance, a figure for each camera to be equalled. Gains that are only bounded are in the tables alone.
fn gain_figures(report: &Comparison<'_>, luminances: &[f64]) -> Markup {
    let mut others: Vec<&str> = report.gains.iter().map(|g| g.other.as_str()).collect();
    others.dedup();
    let figures = others.into_iter().map(|other| {
        let gains: Vec<_> = report.gains.iter().filter(|g| g.other == other).collect();
        let metrics = gains.first().map_or(&[][..], |g| g.gains.metrics.as_slice());
        let series = metrics.iter().enumerate().map(|(i, m)| {
            let value = |g: &&PairwiseLightGain| match g.gains.metrics.get(i).map(|m| m.gain) {
                Some(LightGain::Stops(stops)) => stops,
                _ => f64::NAN,
            };
            (tables::metric_name(m.metric).to_owned(), gains.iter().map(value).collect())
        });
        let label = format!("Light gain of {other} (stops)");
        figures::against_light(luminances, &label, &series.collect())
    });
    figures::beside(figures)
}

/// For each luminance the scores of the targets.
fn scored<'a>(report: &'a Comparison<'_>) -> Vec<Vec<Scored<'a>>> {
    let of_light = |light: usize| {
        let one = |(contender, outcome): (&Contender<'_>, &'a Outcome)| Scored {
            name: contender.name(),
            luminance_cd_m2: outcome.luminance_cd_m2,
            evaluation: &outcome.targets,
            edge: outcome.edge.as_ref(),
            pitch_m: contender.camera.sensor.pixel.pitch_m,
        };
        report.in_light(light).map(one).collect()
    };
    (0..report.light_count()).map(of_light).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_is_too_large_is_made_again_with_smaller_pictures() {
        let of = |tables: usize, pictures: usize, calls: &mut Vec<usize>| -> String {
            let make = |reserved: usize| -> Result<String, ReportError> {
                calls.push(reserved);
                Ok("x".repeat(tables + pictures.saturating_sub(reserved)))
            };
            within(100, make).unwrap()
        };
        let mut calls = Vec::new();
        assert_eq!((of(40, 50, &mut calls).len(), calls.as_slice()), (90, &[0][..]));
        calls.clear();
        assert_eq!((of(70, 50, &mut calls).len(), calls.as_slice()), (100, &[0, 20][..]));
        // Tables alone are larger.
        calls.clear();
        assert_eq!((of(120, 50, &mut calls).len(), calls.len()), (120, ATTEMPTS));
    }
}
