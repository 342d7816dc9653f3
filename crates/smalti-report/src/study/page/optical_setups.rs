//! The data from which the page draws pictures of its designs: the light of two scenes and of the training scenes on the pixels.

use serde_json::{Value, json};
use smalti::camera::description::ExposureDescription;
use smalti::camera::{Camera, CameraDescription, EvaluationSettings, Setup};
use smalti::design::{
    LearningSettings, PipelineTrainer, Preview, PreviewLight, PreviewScene, PreviewTraining, QuantizedPlanes,
    Targets, TrialProcessing, metered,
};
use smalti::experiment::Progress;
use smalti::scene::Setting;
use smalti::spectrum::Illuminant;

use super::sources::Sources;
use crate::page::{SIMULATOR_BYTES, whole_pictures};
use crate::study::book::ensure_running;
use crate::study::pictures::{LEAVES, ZONE_PLATE, camera_of};
use crate::study::sections::Section;
use crate::words::plain;
use crate::{ReportError, in_one_line};

/// The approximate bytes of an optical setup at full size, and of training data.
const OPTICAL_SETUP_BYTES: usize = 850_000;
/// The least scale of the scenes on a page of many optical setups: a zone plate of 64 × 64 pixels.
const LEAST_SCALE: f64 = 0.25;
/// The largest number of bytes of the simulator, optical setups and pictures: a page of 5000 designs then stays below 4 MB.
pub(super) const MAX_BYTES: usize = 2_800_000;
/// Spectral components of each scene. Grey rings differ in the blur of the lens alone. Eight components describe natural surfaces in
/// daylight to a few thousandths.
const COMPONENTS: [usize; 2] = [3, 8];
/// Spectral components of training scenes.
const TRAINING_COMPONENTS: usize = 8;

/// One lens and pixel geometry under one light. They determine the light on the pixels up to a factor.
struct OpticalSetup {
    camera: Camera,
    illuminant: Illuminant,
    luminance_cd_m2: f64,
    /// Side of the training scenes, where pipelines are learned.
    training_px: Option<usize>,
}

impl OpticalSetup {
    /// The optical setup of a section alone.
    fn new(section: &Section<'_>) -> Result<Self, ReportError> {
        let (condition, processing, camera) = camera_of(section)?;
        // Any exposure: the cameras that share the optical setup have their own rules, some of which may fail.
        let exposure = ExposureDescription { time_ms: Some(1.0), ..ExposureDescription::default() };
        let description = CameraDescription { exposure, ..condition.camera.clone() };
        let training_px = (processing == TrialProcessing::L3).then_some(section.results.study().l3.size_px);
        Ok(Self {
            camera: Camera::new(description, camera.grid())?,
            illuminant: condition.illuminant.clone(),
            luminance_cd_m2: condition.luminance_cd_m2,
            training_px,
        })
    }

    /// Whether the light on the pixels is that of another optical setup up to a factor.
    fn serves(&self, optical_setup: &Self) -> bool {
        let (own, other) = (&self.camera.sensor, &optical_setup.camera.sensor);
        self.illuminant == optical_setup.illuminant
            && self.camera.optics == optical_setup.camera.optics
            && self.camera.grid() == optical_setup.camera.grid()
            && own.pixel.pitch_m == other.pixel.pitch_m
            && own.pixel.fill_factor == other.pixel.fill_factor
            && own.aperture == other.aperture
            && own.binning_side() == other.binning_side()
            && own.quantum_efficiency == other.quantum_efficiency
            && own.ir_cut == other.ir_cut
            && self.training_px.zip(optical_setup.training_px).is_none_or(|(own, other)| own == other)
    }

    /// Both scenes before its camera.
    fn setups(&self, specs: &[String], progress: &dyn Progress) -> Result<Vec<Setup>, ReportError> {
        let setting = Setting {
            luminance_cd_m2: self.luminance_cd_m2,
            illuminant: self.illuminant.clone(),
            grid: self.camera.grid(),
            ..Setting::default()
        };
        let setup = |spec: &String| {
            ensure_running(progress)?;
            Ok(Setup::of_test_scene(&self.camera, spec, &setting)?)
        };
        specs.iter().map(setup).collect()
    }

    /// The chart before a camera.
    fn targets(&self, camera: &Camera) -> Result<Targets, ReportError> {
        let settings = EvaluationSettings {
            luminance_cd_m2: self.luminance_cd_m2,
            illuminant: self.illuminant.clone(),
            seed: 0,
            ..EvaluationSettings::default()
        };
        Ok(Targets::new(camera, &settings, &[], &[], &|_, make| make())?)
    }

    /// The light of both scenes and of the training scenes.
    fn light(&self, setups: &[Setup]) -> Result<PreviewLight, ReportError> {
        let scenes = setups.iter().zip(COMPONENTS).map(|(setup, n)| PreviewScene::new(setup, n));
        let training = |size_px| -> Result<PreviewTraining, ReportError> {
            let settings = LearningSettings { size_px, ..LearningSettings::default() };
            let trainer = PipelineTrainer::new(&self.targets(&self.camera)?, &settings, &|_, make| make())?;
            Ok(PreviewTraining::new(&trainer, TRAINING_COMPONENTS)?)
        };
        Ok(PreviewLight {
            factor: 1.0,
            scenes: scenes.collect::<Result<_, _>>()?,
            training: self.training_px.map(training).transpose()?,
        })
    }

    /// The light before the camera of a section, with its strength, and the light that its exposure rule meters.
    fn light_of(
        &self,
        section: &Section<'_>,
        setups: &[Setup],
        light: &PreviewLight,
    ) -> Result<PreviewLight, ReportError> {
        let (condition, processing, camera) = camera_of(section)?;
        let mut light = light.clone();
        light.factor = condition.luminance_cd_m2 / self.luminance_cd_m2;
        for (scene, setup) in light.scenes.iter_mut().zip(setups) {
            scene.metered = metered(
                &setup.before(&camera)?.ok_or(ReportError::Missing { what: "image before another lens" })?,
            )?;
        }
        if processing != TrialProcessing::L3 {
            light.training = None;
        }
        if let Some(training) = &mut light.training {
            training.chart.metered = self.targets(&camera)?.metered().map(|s| s.values().to_vec());
        }
        Ok(light)
    }
}

/// The scale of the scenes at which a number of optical setups, some of them with training data, fit into the page.
fn scale(optical_setups: usize, learned: usize) -> f64 {
    let all = (optical_setups + learned) * OPTICAL_SETUP_BYTES;
    if SIMULATOR_BYTES + all < MAX_BYTES + OPTICAL_SETUP_BYTES {
        return 1.0;
    }
    let room = MAX_BYTES.saturating_sub(SIMULATOR_BYTES + learned * OPTICAL_SETUP_BYTES);
    let share = room as f64 / (optical_setups * OPTICAL_SETUP_BYTES) as f64;
    // Small pictures take some more bytes per pixel.
    (0.95 * share.sqrt()).clamp(LEAST_SCALE, 1.0)
}

/// The zone plate and the leaves at a scale.
fn scenes(scale: f64) -> [String; 2] {
    if scale >= 1.0 {
        return [ZONE_PLATE.into(), LEAVES.into()];
    }
    let even = |full: f64| 2 * (full * scale / 2.0).round() as usize;
    let (size, rows, cols, largest) = (even(512.0), even(576.0), even(768.0), (150.0 * scale).round());
    [
        format!("zone-plate?size={size}&frequency=0.25"),
        format!("dead-leaves?rows={rows}&cols={cols}&least=2&largest={largest}&seed=1001"),
    ]
}

/// The planes of an optical setup for the page.
fn packed(light: &mut PreviewLight) -> Value {
    let plane = |planes: &mut QuantizedPlanes| {
        let QuantizedPlanes { rows, cols, codes, .. } = planes;
        let mut data = whole_pictures(codes.chunks_exact((*rows * *cols).max(1)), *cols);
        (data["rows"], data["cols"]) = (json!(rows), json!(cols));
        data
    };
    json!({"planes": light.planes_mut().map(plane).collect::<Vec<_>>()})
}

/// How a section draws its designs.
struct Drawn {
    optical_setup: usize,
    light: PreviewLight,
}

/// Why a section draws no pictures.
#[derive(Clone)]
enum NoPicture {
    /// The page would be too large. A page of fewer sections has the pictures.
    NoRoom,
    Failed(String),
}

impl NoPicture {
    fn words(&self) -> &str {
        match self {
            Self::NoRoom => {
                "the page would be too large with the light of this condition; report fewer studies or conditions at a time"
            }
            Self::Failed(why) => why,
        }
    }
}

impl From<ReportError> for NoPicture {
    fn from(error: ReportError) -> Self {
        Self::Failed(plain(&in_one_line(&error)))
    }
}

/// The data from which pictures of designs are drawn.
pub(super) struct OpticalSetups {
    optical_setups: Vec<Value>,
    sections: Vec<Result<Drawn, NoPicture>>,
    /// Bytes of all optical setups and of the simulator.
    pub(super) bytes: usize,
    pub(super) notes: Vec<String>,
}

impl OpticalSetups {
    pub(super) fn new(sources: &Sources<'_>) -> Result<Self, ReportError> {
        let sections: Vec<&Section<'_>> = sources.sections().collect();
        let mut optical_setups: Vec<OpticalSetup> = Vec::new();
        // The camera may need a file that is not part of the study.
        let places: Vec<Result<usize, NoPicture>> =
            sections.iter().map(|s| Ok(place(OpticalSetup::new(s)?, &mut optical_setups))).collect();
        let learned = optical_setups.iter().filter(|s| s.training_px.is_some()).count();
        let mut bytes = if optical_setups.is_empty() { 0 } else { SIMULATOR_BYTES };
        let specs = scenes(scale(optical_setups.len(), learned));
        let mut drawn: Vec<Result<Drawn, NoPicture>> = Vec::new();
        drawn.resize_with(sections.len(), || Err(NoPicture::NoRoom));
        let mut data = Vec::new();
        for (index, optical_setup) in optical_setups.iter().enumerate() {
            let make = || -> Result<(PreviewLight, Vec<Setup>), NoPicture> {
                if bytes >= MAX_BYTES {
                    return Err(NoPicture::NoRoom);
                }
                let setups = optical_setup.setups(&specs, sources.progress)?;
                Ok((optical_setup.light(&setups).map_err(NoPicture::from)?, setups))
            };
            let mut made = make();
            // A stop is no reason that a section could state.
            ensure_running(sources.progress)?;
            for ((section, place), drawn) in sections.iter().zip(&places).zip(&mut drawn) {
                if place.as_ref().is_ok_and(|optical_setup| *optical_setup == index) {
                    *drawn = match &made {
                        Ok((light, setups)) => optical_setup
                            .light_of(section, setups, light)
                            .map(|light| Drawn { optical_setup: index, light })
                            .map_err(NoPicture::from),
                        Err(why) => Err(why.clone()),
                    };
                }
            }
            let optical_setup = made.as_mut().map_or(Value::Null, |(light, _)| packed(light));
            bytes += optical_setup.to_string().len();
            data.push(optical_setup);
            sources.progress.picture();
        }
        for (drawn, place) in drawn.iter_mut().zip(places) {
            if let Err(why) = place {
                *drawn = Err(why);
            }
        }
        let note = |(section, drawn): (&&Section<'_>, &Result<Drawn, NoPicture>)| {
            let why = drawn.as_ref().err()?;
            Some(format!("{}: the page draws no pictures: {}", section.title(), why.words()))
        };
        let notes = sections.iter().zip(&drawn).filter_map(note).collect();
        Ok(Self { optical_setups: data, sections: drawn, bytes, notes })
    }

    /// Whether pictures of a section are embedded although the page can draw them: learning a pipeline takes long.
    pub(super) fn wants_pictures(&self, section: usize) -> bool {
        matches!(self.sections.get(section), Some(Ok(drawn)) if drawn.light.training.is_some())
    }

    /// Whether a section cannot have pictures, which a note states.
    pub(super) fn has_failed(&self, section: usize) -> bool {
        matches!(self.sections.get(section), Some(Err(NoPicture::Failed(_))))
    }

    /// Whether the page draws anything.
    pub(super) fn draws(&self) -> bool {
        self.sections.iter().any(Result::is_ok)
    }

    /// Draws the designs of a section as the page does, or as another page would where this one has no room.
    pub(super) fn preview(
        &self,
        index: usize,
        section: &Section<'_>,
        progress: &dyn Progress,
    ) -> Result<Preview, ReportError> {
        let alone;
        let light = match self.sections.get(index) {
            Some(Ok(drawn)) => &drawn.light,
            _ => {
                let optical_setup = OpticalSetup::new(section)?;
                let setups = optical_setup.setups(&scenes(1.0), progress)?;
                alone = optical_setup.light_of(section, &setups, &optical_setup.light(&setups)?)?;
                &alone
            }
        };
        let (condition, processing) =
            section.results.condition(section.setup).ok_or(ReportError::Missing { what: "condition" })?;
        Ok(Preview::new(section.results.study(), condition, processing, light)?)
    }

    /// The optical setups, and the part of each section.
    pub(super) fn data(&self, sections: &[&Section<'_>]) -> Result<(Value, Vec<Value>), ReportError> {
        let said =
            |(drawn, section): (&Result<Drawn, NoPicture>, &&Section<'_>)| -> Result<Value, ReportError> {
                match drawn {
                    Ok(Drawn { optical_setup, light }) => {
                        let (condition, processing) = section
                            .results
                            .condition(section.setup)
                            .ok_or(ReportError::Missing { what: "condition" })?;
                        let is_learned = processing == TrialProcessing::L3;
                        Ok(
                            json!({"optical_setup": optical_setup, "light": light, "condition": condition, "is_learned": is_learned}),
                        )
                    }
                    Err(why) => {
                        Ok(json!({"none": why.words(), "is_elsewhere": matches!(why, NoPicture::NoRoom)}))
                    }
                }
            };
        let drawn = self.sections.iter().zip(sections).map(said).collect::<Result<_, ReportError>>()?;
        Ok((json!(self.optical_setups), drawn))
    }
}

/// The index of an optical setup among known optical setups. It is added if none of them fits.
fn place(optical_setup: OpticalSetup, optical_setups: &mut Vec<OpticalSetup>) -> usize {
    let found = optical_setups.iter().position(|s| s.serves(&optical_setup));
    let place = found.unwrap_or(optical_setups.len());
    match optical_setups.get_mut(place) {
        Some(there) => there.training_px = there.training_px.or(optical_setup.training_px),
        None => optical_setups.push(optical_setup),
    }
    place
}
