//! The engine of the studio: designs as JSON go in, pictures, figures and curves come out.

mod error;
mod figures;
mod file;
mod improving;
mod infrared;
mod lens;
mod mosaic;
mod photograph;
mod request;
mod text;
mod warnings;

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use serde_json::{Value, json};
use smalti::camera::{Camera, ColorimetricObserver};
use smalti::design::live::{LiveDesign, LivePicture};
use smalti::spectrum::Illuminant;
use smalti_io::dng::{self, DngInfo};
use smalti_io::{cameras, l3};

pub use error::EngineError;
pub use file::StudioFile;
use improving::Improving;
use lens::{Lens, Sources};
use request::{ClippingRequest, DifferenceRequest, DrawRequest, Request};

/// Bytes of the longest request.
const MAX_REQUEST: usize = 4 << 20;

/// An answer: JSON, and the bytes of pictures behind it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Answer {
    /// The JSON.
    pub said: Value,
    /// Pictures, four bytes a pixel each, and maps, a number of 32 bits a pixel, little-endian; or a file.
    pub bytes: Vec<u8>,
}

impl Answer {
    fn of(said: &impl Serialize) -> Result<Self, EngineError> {
        Ok(Self { said: serde_json::to_value(said)?, bytes: Vec::new() })
    }

    /// The length of the JSON as 32 bits, little-endian; the JSON; the bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let text = self.said.to_string().into_bytes();
        [&(text.len() as u32).to_le_bytes(), text.as_slice(), &self.bytes].concat()
    }
}

/// What was learned last, for requests about the same design.
struct Learned {
    key: String,
    design: LiveDesign,
}

/// What was drawn last.
struct Drawn {
    key: String,
    picture: LivePicture,
}

/// Draws, scores and improves designs.
#[derive(Default)]
pub struct Engine {
    /// By the names that the page gives them.
    lenses: BTreeMap<String, Lens>,
    sources: Sources,
    observer: Option<ColorimetricObserver>,
    learned: Option<Learned>,
    drawn: Option<Drawn>,
    /// The picture from which differences were last asked for.
    other: Option<Drawn>,
    improving: Option<Improving>,
    makeable: warnings::Makeable,
}

impl Engine {
    /// Takes a file of the studio, inflated, for designs with a lens: with one lens and pixel geometry, to which the page gives a name.
    ///
    /// # Errors
    /// When it is damaged or of another kind.
    pub fn load(&mut self, lens: &str, kind: StudioFile, bytes: &[u8]) -> Result<(), EngineError> {
        (self.learned, self.drawn, self.other) = (None, None, None);
        self.lenses.entry(lens.to_owned()).or_default().load(kind, bytes)
    }

    /// Takes a file from which light is gathered.
    pub fn source(&mut self, name: &str, bytes: Vec<u8>) {
        self.sources.files.insert(name.to_owned(), bytes);
    }

    /// Takes a photograph, RGBA in sRGB, from which the light of a scene is gathered.
    ///
    /// # Errors
    /// When its size is not that of its bytes or out of range, or it is black.
    pub fn photograph(&mut self, id: &str, size: [usize; 2], rgba: &[u8]) -> Result<(), EngineError> {
        let photograph = photograph::Photograph::new(size, rgba)?;
        self.sources.photographs.insert(id.to_owned(), photograph);
        Ok(())
    }

    /// Answers a request, a JSON object with the request's name as its only key.
    ///
    /// # Errors
    /// When the request cannot be read, the design is impossible, or a file is missing.
    pub fn ask(&mut self, request: &[u8]) -> Result<Answer, EngineError> {
        if request.len() > MAX_REQUEST {
            return Err(EngineError::TooLong { bytes: request.len(), limit: MAX_REQUEST });
        }
        match serde_json::from_slice(request)? {
            Request::Catalogue {} => Answer::of(&text::catalogue()?),
            Request::Learn(request) => self.learn(&request),
            Request::Draw(request) => self.draw(&request),
            Request::Table(request) => self.table(&request.into()),
            Request::Raw(request) => self.raw(&request.into()),
            Request::Measure(request) => self.measure(&request),
            Request::Difference(request) => self.difference(&request),
            Request::Clipping(request) => self.clipping(request),
            Request::Scores(request) => {
                let camera = camera(request.design)?;
                let observer = self.observer(&camera)?;
                let wanted = figures::Wanted {
                    luminances_cd_m2: &request.luminances_cd_m2,
                    derivatives: request.derivatives,
                };
                // The figures of the array alone need no statistics.
                let statistics = match request.luminances_cd_m2.is_empty() {
                    true => None,
                    false => Some(self.lens(&request.lens)?.statistics()?),
                };
                let mut scores = figures::scores(&camera, statistics, &observer, wanted)?;
                if let Some(family) = request.family {
                    scores.warnings.extend(self.makeable.warnings(&camera, family)?);
                }
                Answer::of(&scores)
            }
            Request::Curves { design } => Answer::of(&figures::curves(&camera(design)?, &Illuminant::D65)?),
            Request::Improve(request) => {
                let statistics = self.lens(&request.lens)?.statistics()?;
                let design = cameras::from_json(request.design.clone())?;
                let improving = Improving::new(design, statistics, &request)?;
                let step = improving.said()?;
                self.improving = Some(improving);
                Answer::of(&step)
            }
            Request::Step {} => {
                let improving = self.improving.as_mut().ok_or(EngineError::Missing("an improvement"))?;
                improving.step();
                Answer::of(&improving.said()?)
            }
            Request::Mosaic(request) => Answer::of(&mosaic::exchanged(&request)?),
            Request::InFull { array } => Answer::of(&mosaic::in_full(&array)?),
            Request::Light(request) => {
                let bytes = self.sources.light(cameras::from_json(request.design)?, &request.of)?;
                Ok(Answer { said: json!({}), bytes })
            }
            Request::Forget { lens } => {
                self.lenses.remove(&lens);
                Answer::of(&json!({}))
            }
            Request::CameraToml { design } => Answer::of(&json!({"toml": text::toml(design)?})),
            Request::Parse { text } => Answer::of(&json!({"design": text::parse(&text)?})),
        }
    }

    fn lens(&self, name: &str) -> Result<&Lens, EngineError> {
        self.lenses.get(name).ok_or(EngineError::Missing("the light of this lens"))
    }

    fn lens_mut(&mut self, name: &str) -> Result<&mut Lens, EngineError> {
        self.lenses.get_mut(name).ok_or(EngineError::Missing("the light of this lens"))
    }

    fn observer(&mut self, camera: &Camera) -> Result<ColorimetricObserver, EngineError> {
        if let Some(known) = self.observer.as_ref().filter(|o| o.light().grid() == camera.grid()) {
            return Ok(known.clone());
        }
        let light = Illuminant::D65.photons(camera.grid()).map_err(smalti::camera::CameraError::from)?;
        let made = ColorimetricObserver::new(&light)?;
        self.observer = Some(made.clone());
        Ok(made)
    }

    /// Learns the pipeline of a design, unless it was learned last.
    fn learn(&mut self, request: &DrawRequest) -> Result<Answer, EngineError> {
        let key = request.design_key();
        if self.learned.as_ref().is_none_or(|known| known.key != key) {
            let description = cameras::from_json(request.design.clone())?;
            let learner = self.lens_mut(&request.lens)?.learner()?;
            let (luminance, seed) = (request.luminance_cd_m2, request.seed);
            let design = learner.learn(&description, luminance, seed, request.effort())?;
            self.learned = Some(Learned { key, design });
        }
        Answer::of(&json!({}))
    }

    /// The picture; with it the reference if it is asked for.
    fn draw(&mut self, request: &DrawRequest) -> Result<Answer, EngineError> {
        self.learn(request)?;
        let learned = self.learned.as_ref().ok_or(EngineError::Missing("a pipeline"))?;
        let lens =
            self.lenses.get_mut(&request.lens).ok_or(EngineError::Missing("the light of this lens"))?;
        let scene = lens.pictures(&request.scene)?;
        let noise = request.noise_mode();
        let key = request.picture_key();
        let picture = match self.drawn.take().filter(|known| known.key == key) {
            Some(known) => known.picture,
            None => scene.picture(&learned.design, request.crop, noise, request.seed)?,
        };
        let mut bytes = scene.rgba8(&picture)?;
        if request.reference {
            bytes.append(&mut scene.reference_rgba8(request.crop)?);
        }
        let mut found = warnings::of_camera(learned.design.camera())?;
        found.extend(warnings::of_capture(picture.saturated_percent));
        let said = json!({
            "width": picture.crop.cols,
            "height": picture.crop.rows,
            "crop": picture.crop,
            "exposure_ms": picture.time_s * 1e3,
            "saturated_percent": picture.saturated_percent,
            "gain": scene.display_gain(&picture),
            "warnings": found,
        });
        self.drawn = Some(Drawn { key, picture });
        Ok(Answer { said, bytes })
    }

    /// The pipeline of a design as a file.
    fn table(&mut self, request: &DrawRequest) -> Result<Answer, EngineError> {
        self.learn(request)?;
        let learned = self.learned.as_ref().ok_or(EngineError::Missing("a pipeline"))?;
        let lens =
            self.lenses.get_mut(&request.lens).ok_or(EngineError::Missing("the light of this lens"))?;
        let pipeline = lens.learner()?.table(&learned.design)?;
        let bytes = l3::table_to_bytes(&pipeline, Path::new("table"))?;
        Ok(Answer { said: json!({"classes": pipeline.classes().len()}), bytes })
    }

    /// The raw image of the picture of the whole scene as a file.
    fn raw(&mut self, request: &DrawRequest) -> Result<Answer, EngineError> {
        self.learn(request)?;
        let learned = self.learned.as_ref().ok_or(EngineError::Missing("a pipeline"))?;
        let lens =
            self.lenses.get_mut(&request.lens).ok_or(EngineError::Missing("the light of this lens"))?;
        let raw = lens.pictures(&request.scene)?.raw(&learned.design, request.noise_mode(), request.seed)?;
        let camera = learned.design.camera();
        let light = lens.learner()?.setup().illuminant.photons(camera.grid());
        let info = DngInfo::of_camera(camera, &light.map_err(smalti::camera::CameraError::from)?)?;
        let bytes = dng::to_bytes(&raw, &info, Path::new("raw"))?;
        Ok(Answer { said: json!({"rows": raw.rows(), "cols": raw.cols()}), bytes })
    }

    /// The scores of a picture and of the targets, and CIEDE2000 at every pixel.
    fn measure(&mut self, request: &DrawRequest) -> Result<Answer, EngineError> {
        if self.drawn.as_ref().is_none_or(|known| known.key != request.picture_key()) {
            self.draw(request)?;
        }
        self.learn(request)?;
        let drawn = self.drawn.as_ref().ok_or(EngineError::Missing("a picture"))?;
        let learned = self.learned.as_ref().ok_or(EngineError::Missing("a pipeline"))?;
        let lens =
            self.lenses.get_mut(&request.lens).ok_or(EngineError::Missing("the light of this lens"))?;
        let scores = lens.pictures(&request.scene)?.scores(&drawn.picture)?;
        let targets = lens.learner()?.targets(&learned.design, request.seed)?;
        let bytes = scores.delta_e_2000_map.data().iter().flat_map(|v| v.to_le_bytes()).collect();
        let mut said = serde_json::to_value(&scores)?;
        said["warnings"] = serde_json::to_value(warnings::of_targets(&targets))?;
        said["targets"] = serde_json::to_value(targets)?;
        Ok(Answer { said, bytes })
    }

    /// The mean luminance of a scene beyond which a design saturates more than [`warnings::SATURATED_PERCENT`] of the samples; null if it never does.
    fn clipping(&mut self, request: ClippingRequest) -> Result<Answer, EngineError> {
        let description = cameras::from_json(request.design)?;
        let lens = self.lens_mut(&request.lens)?;
        let camera = lens.learner()?.camera(&description)?;
        let share = warnings::SATURATED_PERCENT / 100.0;
        let luminance = lens.pictures(&request.scene)?.saturating_luminance(&camera, share)?;
        Answer::of(&json!({"luminance_cd_m2": luminance}))
    }

    /// CIEDE2000 at every pixel between two pictures of a scene, of which the other one is kept.
    fn difference(&mut self, request: &DifferenceRequest) -> Result<Answer, EngineError> {
        let DifferenceRequest { picture, other } = request;
        if self.other.as_ref().is_none_or(|known| known.key != other.picture_key()) {
            self.draw(other)?;
            self.other = self.drawn.take();
        }
        if self.drawn.as_ref().is_none_or(|known| known.key != picture.picture_key()) {
            self.draw(picture)?;
        }
        let drawn = self.drawn.as_ref().ok_or(EngineError::Missing("a picture"))?;
        let other = self.other.as_ref().ok_or(EngineError::Missing("another picture"))?;
        let lens =
            self.lenses.get_mut(&picture.lens).ok_or(EngineError::Missing("the light of this lens"))?;
        let map = lens.pictures(&picture.scene)?.difference(&drawn.picture, &other.picture)?;
        let bytes = map.data().iter().flat_map(|v| v.to_le_bytes()).collect();
        Ok(Answer { said: json!({"rows": map.rows(), "cols": map.cols()}), bytes })
    }
}

/// The camera of a design.
fn camera(design: Value) -> Result<Camera, EngineError> {
    let description = cameras::from_json(design)?;
    let grid = description.grid()?;
    Ok(Camera::new(description, grid)?)
}
