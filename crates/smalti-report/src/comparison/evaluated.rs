//! The page of an evaluation: the pictures of the targets and their scores.

use smalti::camera::{Camera, Evaluation, EvaluationPictures};
use smalti::color::{ColorSpace, Image};
use smalti::numeric::Planes;

use super::columns::{EVALUATE, SENSOR, headings};
use super::conditions::Conditions;
use super::evaluated_text::{clipped, without_noise};
use super::figures::{self, Scored};
use super::gallery::{self, Group, Map, Maps, Shot};
use super::results::CommandLine;
use super::{again, chart, tables};
use crate::ReportError;
use crate::page::{COMPARE, Markup, Page, Table, el, foot, paragraph};
use crate::pictures::Pixels;
use crate::reliability::mark;
use crate::words::{listed, time_ms};

const ALIASING: Maps = Maps {
    name: "Aliasing",
    unit: "",
    about: "The part of the picture that the zone plate does not contain. Grey means no difference.",
};

/// The evaluations of cameras at one or several luminances.
#[derive(Debug, Clone, Copy)]
pub struct Evaluations<'a> {
    /// The command that made them.
    pub command: &'a CommandLine,
    /// The cameras.
    pub cameras: &'a [Camera],
    /// The label of each camera.
    pub labels: &'a [String],
    /// The mean luminances of the targets.
    pub luminances_cd_m2: &'a [f64],
    /// The light of the targets, as the command names it.
    pub illuminant: &'a str,
    /// X, Y, Z of that light, Y = 1.
    pub white: [f64; 3],
    /// The seed of the noise.
    pub seed: u64,
    /// The conditions of the scores.
    pub conditions: Conditions<'a>,
    /// For each camera one per luminance.
    pub results: &'a [(&'a Camera, Evaluation)],
    /// Whether learned pipelines rendered the pictures.
    pub learned: bool,
    /// In the same order.
    pub pictures: &'a [EvaluationPictures],
}

impl Evaluations<'_> {
    /// Label, scores and pictures of each camera in one light.
    fn in_light(
        &self,
        light: usize,
    ) -> impl Iterator<Item = (&String, &Camera, &Evaluation, &EvaluationPictures)> {
        let each = self.luminances_cd_m2.len().max(1);
        self.labels.iter().enumerate().filter_map(move |(i, label)| {
            let (camera, evaluation) = self.results.get(i * each + light)?;
            Some((label, *camera, evaluation, self.pictures.get(i * each + light)?))
        })
    }
}

/// The page of evaluations as HTML.
///
/// # Errors
/// When a picture cannot be converted, or a camera cannot be written as text.
pub fn page(shots: &Evaluations<'_>) -> Result<String, ReportError> {
    let edges = shots.pictures.iter().map(EvaluationPictures::edge_sfr).collect::<Result<Vec<_>, _>>()?;
    let each = shots.luminances_cd_m2.len();
    let scored: Vec<Vec<Scored<'_>>> = (0..each)
        .map(|light| {
            let one = |(i, (label, camera, evaluation, _)): (usize, (&String, &Camera, _, _))| Scored {
                name: label.clone(),
                luminance_cd_m2: shots.luminances_cd_m2.get(light).copied().unwrap_or(f64::NAN),
                evaluation,
                edge: edges.get(i * each + light).and_then(Option::as_ref),
                pitch_m: camera.sensor.pixel.pitch_m,
            };
            shots.in_light(light).enumerate().map(one).collect()
        })
        .collect();
    let lights: Vec<String> = shots.luminances_cd_m2.iter().map(f64::to_string).collect();
    let lead = format!(
        "ColorChecker, slanted edge of high contrast and zone plate at {} cd/m², light {}, seed {}. All pictures are scaled to the same brightness.",
        listed(&lights),
        shots.illuminant,
        shots.seed
    );
    let charts = chart::colors(&scored);
    let cameras = (shots.cameras, shots.labels);
    let again = again::section(
        shots.command,
        (format!("seed {}", shots.seed), shots.illuminant.to_owned()),
        None,
        cameras,
    )?;
    Ok(Page::new(format!("{} evaluated", listed(shots.labels)))
        .with(COMPARE)
        .lead(el("p").child(lead))
        .section(
            "pictures",
            "Pictures",
            gallery::gallery(&groups(shots)?, &[&ALIASING], charts.as_str().len()),
        )
        .section("scores", "Scores", shots.conditions.markup().and(scores(shots)))
        .section("colours", "Colours", charts.and(colors(&scored)))
        .section("noise", "Noise", figures::noise(&scored).and(tables::noise(&scored)))
        .section("edges", "Sharpness", figures::edges(&scored))
        .section("filters", "Filters", figures::all_filters(shots.cameras, shots.labels))
        .section("again", "Reproduction", again)
        .foot(foot())
        .html())
}

fn groups(shots: &Evaluations<'_>) -> Result<Vec<Group>, ReportError> {
    let mut groups = Vec::new();
    type Of = fn(&EvaluationPictures) -> &Image;
    let targets: [(&str, Of); 3] =
        [("ColorChecker", |p| &p.macbeth), ("edge", |p| &p.edge), ("zone plate", |p| &p.zone_plate)];
    for (scene, of) in targets {
        for (light, &luminance_cd_m2) in shots.luminances_cd_m2.iter().enumerate() {
            let mut group =
                Group { scene: scene.into(), luminance_cd_m2, shots: Vec::new(), tops: Vec::new() };
            for (label, _, e, pictures) in shots.in_light(light) {
                let (caption, aliasing) = match scene {
                    "ColorChecker" => (format!("ΔE2000 {:.2}", e.delta_e_2000.mean), None),
                    "edge" => {
                        let mark = mark(e.mtf50_reliability);
                        (format!("MTF50 {:.1} cy/mm{mark}", e.mtf50_cy_per_mm), None)
                    }
                    _ => (format!("aliasing {:.1} %", e.aliasing_percent), Some(aliasing_picture(pictures)?)),
                };
                let maps = aliasing.iter().map(|image| Map::Picture(Pixels::of(image))).collect();
                let picture = Pixels::of(&seen(of(pictures), shots.white)?);
                group.shots.push(Shot { name: label.clone(), is_reference: false, caption, picture, maps });
            }
            groups.push(group);
        }
    }
    Ok(groups)
}

/// The aliasing in the picture of the zone plate, in sRGB. Aliasing has two signs: grey is none.
///
/// # Errors
/// When the planes have another shape than the picture.
pub fn aliasing_picture(pictures: &EvaluationPictures) -> Result<Image, ReportError> {
    let planes = &pictures.aliasing;
    let largest = planes.data().iter().fold(0.0f32, |m, v| m.max(v.abs())).max(f32::MIN_POSITIVE);
    let data = planes.data().iter().map(|v| 0.5 + 0.5 * v / largest).collect();
    Ok(Image::new(ColorSpace::Srgb, Planes::new(planes.rows(), planes.cols(), 3, data)?)?)
}

/// A picture for display: the light is white, and the 99th percentile of the luminance is just below white, since targets in little
/// light are dark as exposed.
fn seen(picture: &Image, white: [f64; 3]) -> Result<Image, ReportError> {
    let mut luminance: Vec<f32> = picture.channels()[1].iter().copied().filter(|v| v.is_finite()).collect();
    let place = luminance.len().saturating_sub(1) * 99 / 100;
    luminance.sort_unstable_by(f32::total_cmp);
    let bright = luminance.get(place).copied().filter(|v| *v > 0.0).unwrap_or(1.0);
    Ok(picture.shown(Some(white), 0.92 / f64::from(bright))?)
}

fn scores(shots: &Evaluations<'_>) -> Markup {
    let table = Table::new("Scores").text("Camera").number("Luminance, cd/m²");
    let mut table = headings(&EVALUATE).fold(table, Table::number).number("Exposure, ms");
    for (light, luminance) in shots.luminances_cd_m2.iter().enumerate() {
        let rows = shots.in_light(light).map(|(label, _, e, _)| {
            let exposure_ms = time_ms(e.exposure.macbeth_s * 1e3);
            (vec![label.clone(), luminance.to_string()], e, vec![exposure_ms])
        });
        table = tables::scored(table, &EVALUATE, &rows.collect::<Vec<_>>(), None);
    }
    let all: Vec<&Evaluation> = shots.results.iter().map(|(_, e)| e).collect();
    let lights = (0..shots.luminances_cd_m2.len()).flat_map(|light| shots.in_light(light));
    let clipping = clipped(lights.map(|(label, _, e, _)| (label.as_str(), e)));
    Markup::from(table)
        .and(tables::meanings_of(&EVALUATE, &all))
        .and(paragraph("help", without_noise(shots.learned)))
        .and(clipping.map(|text| paragraph("help", text)).into_iter().collect::<Markup>())
        .and(paragraph(
            "help",
            "MTF50 4:1 is that of an edge of low contrast. It differs from the other MTF50 where processing depends on contrast. ★ marks the \
             best value in this light and those that do not differ from it by a relevant amount (see the list of metrics). Higher is better for MTF50 and dynamic range, lower for the other columns.",
        ))
        .and(sensors(shots))
}

/// The colorimetry of the sensor of each camera.
fn sensors(shots: &Evaluations<'_>) -> Markup {
    let caption = format!("Colorimetry of the sensor under {}", shots.illuminant);
    let table = headings(&SENSOR).fold(Table::new(caption).text("Camera"), Table::number);
    let rows = shots.in_light(0).map(|(label, _, e, _)| (vec![label.clone()], &e.sensor, Vec::new()));
    Markup::from(tables::scored(table, &SENSOR, &rows.collect::<Vec<_>>(), None)).and(paragraph(
        "help",
        "How well the spectral sensitivities tell colours apart as the CIE 1931 observer does, without noise. Vora value 1, sensitivity \
         metamerism index (SMI) 100 and metamer mismatch 0 mean that a colour matrix makes every colour exact.",
    ))
}

/// Colour differences of each patch, a table for each light, folded.
fn colors(scored: &[Vec<Scored<'_>>]) -> Markup {
    let caption = |cd_m2| format!("ΔE2000 of each patch at {cd_m2} cd/m²");
    let tables = tables::patches(scored, caption, &chart::names(), |e| &e.delta_e_2000.per_patch);
    el("details")
        .child(el("summary").child("The values"))
        .child(el("div").class("beside").child(tables))
        .into()
}
