//! What the page draws pictures of its designs from: the light of two scenes on the pixels, the read-out, a colour matrix for each
//! design.

use anyhow::Context;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rayon::prelude::*;
use serde_json::{Value, json};
use smalti::camera::description::{DemosaicName, ExposureDescription};
use smalti::camera::{Camera, CameraDescription, Setup};
use smalti::color::{BRIGHT_SHARE, shown_from_xyz};
use smalti::design::{PixelLight, Processing, ReadoutModel, metered_electrons};
use smalti::isp::{ColorFit, WhiteBalance};
use smalti::scene::Setting;
use smalti::spectrum::{Illuminant, Observer};
use smalti_report::page::{packed, whole_pictures};

use super::Sources;
use super::choice::Choice;
use crate::Watch;
use crate::study_report::answers::Section;
use crate::study_report::pictures::{LEAVES, ZONE_PLATE};
use crate::study_report::results;

/// The scenes on a quarter of the pixels, for a page of many stages.
const SMALL: [&str; 2] =
    ["zone-plate?size=256&frequency=0.25", "dead-leaves?rows=288&cols=384&least=2&largest=75&seed=1001"];
/// About the bytes of a stage of scenes that are not small.
const STAGE_BYTES: usize = 850_000;
/// Most bytes of stages and pictures: what a page of 5000 designs can spare of its 4 MB.
pub(super) const MOST_BYTES: usize = 2_800_000;
/// Of them for pictures, where some processing cannot be drawn.
const PICTURE_BYTES: usize = 1_000_000;
/// Components of each scene. Grey rings differ by the blur of the lens alone; natural surfaces under daylight are known to a few
/// thousandths from eight.
const COMPONENTS: [usize; 2] = [3, 8];
/// Steps of a component, of the brightest light: twice as fine as what a screen of 8 bits shows of white.
const STEPS: f64 = 1000.0;
/// Why some sections draw nothing.
const NO_ROOM: &str = "it would have become too large; take fewer studies or conditions at a time";

/// One lens and one geometry of pixels under one light: what the light on the pixels depends on, but for its strength.
struct Stage {
    camera: Camera,
    illuminant: Illuminant,
    luminance_cd_m2: f64,
}

impl Stage {
    fn serves(&self, camera: &Camera, illuminant: &Illuminant) -> bool {
        let (own, other) = (&self.camera.sensor, &camera.sensor);
        self.illuminant == *illuminant
            && self.camera.optics == camera.optics
            && self.camera.grid() == camera.grid()
            && own.pixel.pitch_m == other.pixel.pitch_m
            && own.pixel.fill_factor == other.pixel.fill_factor
            && own.aperture == other.aperture
            && own.quantum_efficiency == other.quantum_efficiency
            && own.ir_cut == other.ir_cut
    }

    /// The light of both scenes, and what the exposure rule of each camera looks at in them.
    fn data(
        &self,
        specs: [&str; 2],
        cameras: &[&Camera],
        watch: &Watch<'_>,
    ) -> anyhow::Result<(Value, Vec<anyhow::Result<Vec<Value>>>)> {
        let grid = self.camera.grid();
        let setting = Setting {
            luminance_cd_m2: self.luminance_cd_m2,
            illuminant: self.illuminant.clone(),
            grid,
            ..Setting::default()
        };
        let mut scenes = Vec::new();
        let mut metered: Vec<anyhow::Result<Vec<Value>>> = cameras.iter().map(|_| Ok(Vec::new())).collect();
        for (spec, components) in specs.into_iter().zip(COMPONENTS) {
            watch.ask()?;
            let setup = Setup::of_test_scene(&self.camera, spec, &setting)?;
            scenes.push(scene(&PixelLight::new(&setup, components)?));
            for (metered, camera) in metered.iter_mut().zip(cameras) {
                let looked_at = || -> anyhow::Result<Value> {
                    let setup = setup.before(camera)?.context("another lens")?;
                    Ok(metered_electrons(&setup)?.map_or(Value::Null, |s| packed(s.values())))
                };
                match (looked_at(), metered.as_mut()) {
                    (Ok(value), Ok(values)) => values.push(value),
                    (Err(error), Ok(_)) => *metered = Err(error),
                    (_, Err(_)) => {}
                }
            }
        }
        let white = Observer::Cie1931.white(&self.illuminant.photons(grid)?)?;
        let data = json!({
            "nm": [grid.start_nm(), grid.step_nm(), grid.len()],
            "rgb_from_xyz": shown_from_xyz(Some(white)),
            "bright_share": BRIGHT_SHARE,
            "scenes": scenes,
        });
        Ok((data, metered))
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
    })
}

/// How a section draws its designs.
struct Drawn {
    stage: usize,
    camera: Camera,
    fit: ColorFit,
    data: Value,
    /// Processing of the section that the page has not.
    own_processing: Option<&'static str>,
}

/// What pictures of designs are drawn from.
pub(super) struct Stages {
    stages: Vec<Value>,
    /// Or why a section draws none.
    sections: Vec<Result<Drawn, String>>,
    /// Of all stages.
    pub(super) bytes: usize,
    pub(super) notes: Vec<String>,
}

impl Stages {
    pub(super) fn new(sources: &Sources<'_>) -> anyhow::Result<Self> {
        let sections: Vec<&Section<'_>> = sources.all.iter().flat_map(|(_, s)| s).collect();
        let mut stages: Vec<Stage> = Vec::new();
        // The description of a camera may name a file that is not part of the study.
        let said = |error: anyhow::Error| results::plain(&crate::in_one_line(error.as_ref()));
        let mut drawn: Vec<Result<Drawn, String>> =
            sections.iter().map(|s| drawn(s, &mut stages).map_err(said)).collect();
        let mut out = Self { stages: Vec::new(), sections: Vec::new(), bytes: 0, notes: Vec::new() };
        let pictured = drawn.iter().flatten().any(|d| d.own_processing.is_some()) && sources.pictures > 0;
        let most = if pictured { MOST_BYTES - PICTURE_BYTES } else { MOST_BYTES };
        let specs = if stages.len() * STAGE_BYTES < most { [ZONE_PLATE, LEAVES] } else { SMALL };
        for (index, stage) in stages.iter().enumerate() {
            let mut here: Vec<&mut Result<Drawn, String>> =
                drawn.iter_mut().filter(|d| d.as_ref().is_ok_and(|d| d.stage == index)).collect();
            let cameras: Vec<&Camera> =
                here.iter().flat_map(|d| d.as_ref().ok()).map(|d| &d.camera).collect();
            let made = match out.bytes < most {
                true => stage.data(specs, &cameras, sources.watch).map_err(said),
                false => Err(NO_ROOM.to_owned()),
            };
            // Unless it was asked to stop.
            sources.watch.ask()?;
            match made {
                Ok((data, metered)) => {
                    out.bytes += data.to_string().len();
                    out.stages.push(data);
                    for (slot, metered) in here.into_iter().zip(metered) {
                        match (metered, slot.as_mut()) {
                            (Ok(metered), Ok(drawn)) => drawn.data["metered"] = metered.into(),
                            (Err(error), _) => *slot = Err(said(error)),
                            (Ok(_), Err(_)) => {}
                        }
                    }
                }
                Err(why) => {
                    here.iter_mut().for_each(|drawn| **drawn = Err(why.clone()));
                    out.stages.push(Value::Null);
                }
            }
            (sources.watch.done)();
        }
        for (section, drawn) in sections.iter().zip(&drawn) {
            if let Err(why) = drawn {
                out.notes.push(format!("{}: the page draws no pictures: {why}", section.title()));
            }
        }
        out.sections = drawn;
        Ok(out)
    }

    /// Whether pictures of a section have to be made for the page, since it has not its processing.
    pub(super) fn wants_pictures(&self, section: usize) -> bool {
        matches!(self.sections.get(section), Some(Ok(drawn)) if drawn.own_processing.is_some())
    }

    /// Whether it has been told that a section cannot have pictures.
    pub(super) fn has_failed(&self, section: usize) -> bool {
        matches!(self.sections.get(section), Some(Err(why)) if why != NO_ROOM)
    }

    /// The stages, what each section has of them, and the colour matrices of designs.
    pub(super) fn data(
        &self,
        sources: &Sources<'_>,
        choice: &Choice,
    ) -> anyhow::Result<(Value, Vec<Value>, Value)> {
        let said = |drawn: &Result<Drawn, String>| match drawn {
            Ok(drawn) => drawn.data.clone(),
            Err(why) => json!({"none": why, "is_elsewhere": why == NO_ROOM}),
        };
        let sections = self.sections.iter().map(said).collect();
        let matrices: Vec<(f64, Vec<i16>)> = choice
            .rows
            .par_iter()
            .map(|row| {
                let Some((results, _)) = sources.all.get(row.study) else { return Ok((0.0, Vec::new())) };
                let design = results.design(row.row)?;
                let none = || Ok((0.0, vec![0; 3 * design.filters.filters.len()]));
                let Some(Ok(drawn)) = self.sections.get(row.section) else { return none() };
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
    let stage = match stages.iter().position(|s| s.serves(&camera, illuminant)) {
        Some(found) => found,
        None => {
            // Exposed somehow: cameras that share the stage have their own rules, of which some may fail.
            let exposure = ExposureDescription { time_ms: Some(1.0), ..ExposureDescription::default() };
            let description = CameraDescription { exposure, ..condition.camera.clone() };
            let camera = Camera::new(description, camera.grid())?;
            stages.push(Stage { camera, illuminant: illuminant.clone(), luminance_cd_m2 });
            stages.len() - 1
        }
    };
    let light = stages.get(stage).map_or(1.0, |s| luminance_cd_m2 / s.luminance_cd_m2);
    let data = json!({"stage": stage, "light": light, "readout": readout, "own_processing": own});
    Ok(Drawn { stage, camera, fit, data, own_processing: own })
}

/// Coefficients as 16-bit whole numbers times a factor.
fn rounded(values: &[f64]) -> (f64, Vec<i16>) {
    let most = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let scale = if most > 0.0 { most / f64::from(i16::MAX) } else { 1.0 };
    (scale, values.iter().map(|v| (v / scale).round() as i16).collect())
}
