//! What the page draws pictures of its designs from: the light of two scenes on the pixels, the read-out, a colour matrix for each
//! design.

use anyhow::Context;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rayon::prelude::*;
use serde_json::{Value, json};
use smalti::camera::description::DemosaicName;
use smalti::camera::{Camera, ExposureTime, Setup};
use smalti::color::{BRIGHT_SHARE, shown_from_xyz};
use smalti::design::{PixelLight, Processing, ReadoutModel};
use smalti::isp::{ColorFit, WhiteBalance};
use smalti::scene::Setting;
use smalti::spectrum::{Illuminant, Observer};
use smalti_report::page::{packed, whole_pictures};

use super::Sources;
use super::choice::Choice;
use crate::study_report::answers::Section;
use crate::study_report::pictures::{LEAVES, ZONE_PLATE};
use crate::study_report::results;

/// The scenes on a quarter of the pixels, for a page of many stages.
const SMALL: [&str; 2] =
    ["zone-plate?size=256&frequency=0.25", "dead-leaves?rows=288&cols=384&least=2&largest=75&seed=1001"];
/// Stages from which scenes are small.
const MANY: usize = 4;
/// Most bytes of all stages.
pub(super) const MOST_BYTES: usize = 2_800_000;
/// Components of each scene. Grey rings differ by the blur of the lens alone; natural surfaces under daylight are known to a few
/// thousandths from eight.
const COMPONENTS: [usize; 2] = [3, 8];
/// Steps of a component, of the brightest light: twice as fine as what a screen of 8 bits shows of white.
const STEPS: f64 = 1000.0;

/// One lens and one geometry of pixels under one light: what the light on the pixels depends on, but for its strength.
struct Stage {
    camera: Camera,
    illuminant: Illuminant,
    luminance_cd_m2: f64,
}

impl Stage {
    fn serves(&self, camera: &Camera, illuminant: &Illuminant) -> bool {
        let (own, other) = (&self.camera.sensor, &camera.sensor);
        let rule = |c: &Camera| match c.exposure_time() {
            ExposureTime::Fixed(_) => None,
            ExposureTime::Auto(rule) => Some(rule),
        };
        self.illuminant == *illuminant
            && self.camera.optics == camera.optics
            && self.camera.grid() == camera.grid()
            && own.pixel.pitch_m == other.pixel.pitch_m
            && own.pixel.fill_factor == other.pixel.fill_factor
            && own.aperture == other.aperture
            && own.quantum_efficiency == other.quantum_efficiency
            && own.ir_cut == other.ir_cut
            && rule(&self.camera) == rule(camera)
    }

    /// The light of both scenes.
    fn data(&self, specs: [&str; 2]) -> anyhow::Result<Value> {
        let grid = self.camera.grid();
        let setting = Setting {
            luminance_cd_m2: self.luminance_cd_m2,
            illuminant: self.illuminant.clone(),
            grid,
            ..Setting::default()
        };
        let mut scenes = Vec::new();
        for (spec, components) in specs.into_iter().zip(COMPONENTS) {
            let setup = Setup::of_test_scene(&self.camera, spec, &setting)?;
            scenes.push(scene(&PixelLight::new(&setup, components)?));
        }
        let white = Observer::Cie1931.white(&self.illuminant.photons(grid)?)?;
        Ok(json!({
            "nm": [grid.start_nm(), grid.step_nm(), grid.len()],
            "rgb_from_xyz": shown_from_xyz(Some(white)),
            "bright_share": BRIGHT_SHARE,
            "scenes": scenes,
        }))
    }
}

fn scene(light: &PixelLight) -> Value {
    let (planes, step) = (light.planes(), light.brightest() / STEPS);
    let steps = |plane: &[f32]| -> Vec<i32> {
        plane.iter().map(|&v| if step > 0.0 { (f64::from(v) / step).round() as i32 } else { 0 }).collect()
    };
    let whole: Vec<Vec<i32>> = planes.planes().map(steps).collect();
    let spectra: Vec<f64> = light.spectra().iter().flat_map(|s| s.values().to_vec()).collect();
    json!({
        "rows": planes.rows(),
        "cols": planes.cols(),
        "step": step,
        "spectra": packed(&spectra),
        "planes": whole_pictures(whole.iter().map(Vec::as_slice), planes.cols()),
        "metered": light.metered().map(|s| packed(s.values())),
    })
}

/// How a section draws its designs.
struct Drawn {
    stage: usize,
    camera: Camera,
    fit: ColorFit,
    data: Value,
    /// Whether by the very processing of the section.
    exact: bool,
}

/// What pictures of designs are drawn from.
pub(super) struct Stages {
    stages: Vec<Value>,
    sections: Vec<Option<Drawn>>,
    /// Of all stages.
    pub(super) bytes: usize,
    pub(super) notes: Vec<String>,
}

impl Stages {
    pub(super) fn new(sources: &Sources<'_>) -> anyhow::Result<Self> {
        let sections: Vec<&Section<'_>> = sources.all.iter().flat_map(|(_, s)| s).collect();
        let mut stages: Vec<Stage> = Vec::new();
        let mut drawn: Vec<anyhow::Result<Drawn>> = sections.iter().map(|s| drawn(s, &mut stages)).collect();
        let mut out = Self { stages: Vec::new(), sections: Vec::new(), bytes: 0, notes: Vec::new() };
        let specs = if stages.len() < MANY { [ZONE_PLATE, LEAVES] } else { SMALL };
        for (index, stage) in stages.iter().enumerate() {
            sources.watch.ask()?;
            let large = || anyhow::anyhow!("it would have become too large; report one study at a time");
            let made = if out.bytes > MOST_BYTES { Err(large()) } else { stage.data(specs) };
            let data = made.unwrap_or_else(|error| {
                let why = results::plain(&crate::in_one_line(error.as_ref()));
                for drawn in drawn.iter_mut().filter(|d| d.as_ref().is_ok_and(|d| d.stage == index)) {
                    *drawn = Err(anyhow::anyhow!(why.clone()));
                }
                Value::Null
            });
            out.bytes += data.to_string().len();
            out.stages.push(data);
            (sources.watch.done)();
        }
        for (section, drawn) in sections.iter().zip(drawn) {
            // The description of a camera may name a file that is not part of the study.
            let note = |error: anyhow::Error| {
                let why = results::plain(&crate::in_one_line(error.as_ref()));
                out.notes.push(format!("{}: the page draws no pictures: {why}", section.title()));
            };
            out.sections.push(drawn.map_err(note).ok());
        }
        Ok(out)
    }

    /// Whether the page draws the designs of a section as its own processing does.
    pub(super) fn is_exact(&self, section: usize) -> bool {
        self.sections.get(section).is_some_and(|d| d.as_ref().is_some_and(|d| d.exact))
    }

    /// The stages, what each section has of them, and the colour matrices of designs.
    pub(super) fn data(
        &self,
        sources: &Sources<'_>,
        choice: &Choice,
    ) -> anyhow::Result<(Value, Vec<Value>, Value)> {
        let sections =
            self.sections.iter().map(|d| d.as_ref().map_or(Value::Null, |d| d.data.clone())).collect();
        let matrices: Vec<(f64, Vec<i16>)> = choice
            .rows
            .par_iter()
            .map(|row| {
                let Some((results, _)) = sources.all.get(row.study) else { return Ok((0.0, Vec::new())) };
                let design = results.design(row.row)?;
                let none = || Ok((0.0, vec![0; 3 * design.filters.filters.len()]));
                let Some(Some(drawn)) = self.sections.get(row.section) else { return none() };
                // What fails here has failed when it was scored, too: its scores say why.
                let matrix = || -> anyhow::Result<Vec<[f64; 3]>> {
                    let camera = drawn.camera.with_cfa(design.cfa(drawn.camera.grid())?);
                    let isp = camera.isp_fitted_to(&drawn.fit, WhiteBalance::None)?;
                    Ok(isp.color_matrix.xyz_from_camera().to_vec())
                };
                matrix().map(|m| rounded(m.as_flattened())).or_else(|_| none())
            })
            .collect::<anyhow::Result<_>>()?;
        let scales: Vec<f64> = matrices.iter().map(|(scale, _)| *scale).collect();
        let codes: Vec<u8> =
            matrices.iter().flat_map(|(_, codes)| codes.iter().flat_map(|c| c.to_le_bytes())).collect();
        Ok((json!(self.stages), sections, json!({"scale": packed(&scales), "i16": STANDARD.encode(codes)})))
    }
}

/// How a section draws its designs, on one of the stages or a new one.
fn drawn(section: &Section<'_>, stages: &mut Vec<Stage>) -> anyhow::Result<Drawn> {
    let (condition, processing) = section.results.setup(section.setup).context("no such condition")?;
    let camera = Camera::new(condition.camera.clone(), condition.camera.grid()?)?;
    let (illuminant, luminance_cd_m2) = (&condition.illuminant, condition.luminance_cd_m2);
    let fit = camera.color_fit(&illuminant.photons(camera.grid())?)?;
    let readout = ReadoutModel::new(&camera)?;
    let own = match (processing, camera.description().isp.demosaic) {
        (Processing::L3, _) => Some("a learned pipeline"),
        (_, _) if readout.all_channels => None,
        (_, DemosaicName::Bilinear) => None,
        (_, DemosaicName::Malvar2004) => Some("the demosaicking of Malvar et al. 2004"),
        (_, DemosaicName::Adaptive) => Some("adaptive demosaicking"),
    };
    let stage = stages.iter().position(|s| s.serves(&camera, illuminant)).unwrap_or_else(|| {
        stages.push(Stage { camera: camera.clone(), illuminant: illuminant.clone(), luminance_cd_m2 });
        stages.len() - 1
    });
    let light = stages.get(stage).map_or(1.0, |s| luminance_cd_m2 / s.luminance_cd_m2);
    let data = json!({"stage": stage, "light": light, "readout": readout, "own_processing": own});
    Ok(Drawn { stage, camera, fit, data, exact: own.is_none() })
}

/// Coefficients as 16-bit whole numbers times a factor.
fn rounded(values: &[f64]) -> (f64, Vec<i16>) {
    let most = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let scale = if most > 0.0 { most / f64::from(i16::MAX) } else { 1.0 };
    (scale, values.iter().map(|v| (v / scale).round() as i16).collect())
}
