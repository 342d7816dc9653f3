//! The requests of a page.

use serde::Deserialize;
use serde_json::Value;
use smalti::design::live::{LiveCrop, LiveEffort, LiveFamily, LiveLocks};
use smalti::design::search::{FilterSpace, FreeCurves};
use smalti::sensor::NoiseMode;

/// Knots of free curves: one in 20 nm.
const KNOTS: usize = 16;

/// A request: an object with one key.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Request {
    /// What is built in.
    Catalogue {},
    /// The pipeline of a design.
    Learn(DrawRequest),
    /// A picture.
    Draw(DrawRequest),
    /// The learned table of a design, a file in the format `.l3`.
    Table(TableRequest),
    /// The raw image of a picture of the whole scene, a file in the format DNG.
    Raw(RawRequest),
    /// Scores of a picture.
    Measure(DrawRequest),
    /// CIEDE2000 at every pixel between two pictures of a scene.
    Difference(DifferenceRequest),
    /// The luminance beyond which a design clips a scene.
    Clipping(ClippingRequest),
    /// Figures without a picture.
    Scores(ScoresRequest),
    /// Curves over wavelength.
    Curves {
        /// The camera.
        design: Value,
    },
    /// Begins to improve a design.
    Improve(ImproveRequest),
    /// The next step of the improvement.
    Step {},
    /// A design with another mosaic of the catalogue.
    Mosaic(MosaicRequest),
    /// An array with its tile in letters and with all of its filters.
    InFull {
        /// `sensor.cfa` of a camera description.
        array: Value,
    },
    /// The light behind the lens of a design, as the file that is loaded for it.
    Light(LightRequest),
    /// Forgets the light of a lens.
    Forget {
        /// The name of the lens.
        lens: String,
    },
    /// The camera file of a design.
    CameraToml {
        /// The camera.
        design: Value,
    },
    /// The design of a camera file.
    Parse {
        /// The file.
        text: String,
    },
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DrawRequest {
    pub(super) design: Value,
    #[serde(default)]
    pub(super) lens: String,
    pub(super) scene: String,
    pub(super) luminance_cd_m2: f64,
    #[serde(default)]
    pub(super) crop: Option<LiveCrop>,
    #[serde(default = "yes")]
    pub(super) noise: bool,
    #[serde(default)]
    pub(super) seed: u64,
    #[serde(default)]
    pub(super) reference: bool,
    /// Whether the pipeline is learned at several exposures, which takes longer.
    #[serde(default)]
    pub(super) thorough: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DifferenceRequest {
    pub(super) picture: DrawRequest,
    pub(super) other: DrawRequest,
}

fn yes() -> bool {
    true
}

impl DrawRequest {
    pub(super) fn noise_mode(&self) -> NoiseMode {
        if self.noise { NoiseMode::All } else { NoiseMode::None }
    }

    pub(super) fn effort(&self) -> LiveEffort {
        if self.thorough { LiveEffort::Thorough } else { LiveEffort::Quick }
    }

    /// What a pipeline depends on.
    pub(super) fn design_key(&self) -> String {
        let Self { lens, luminance_cd_m2, seed, thorough, design, .. } = self;
        format!("{lens} {} {seed} {thorough} {design}", luminance_cd_m2.to_bits())
    }

    /// What a picture depends on.
    pub(super) fn picture_key(&self) -> String {
        format!("{} {:?} {} {}", self.scene, self.crop, self.noise, self.design_key())
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TableRequest {
    design: Value,
    #[serde(default)]
    lens: String,
    luminance_cd_m2: f64,
    #[serde(default)]
    seed: u64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRequest {
    design: Value,
    #[serde(default)]
    lens: String,
    scene: String,
    luminance_cd_m2: f64,
    #[serde(default = "yes")]
    noise: bool,
    #[serde(default)]
    seed: u64,
}

impl From<TableRequest> for DrawRequest {
    fn from(TableRequest { design, lens, luminance_cd_m2, seed }: TableRequest) -> Self {
        Self::from(RawRequest { design, lens, scene: String::new(), luminance_cd_m2, noise: true, seed })
    }
}

impl From<RawRequest> for DrawRequest {
    fn from(RawRequest { design, lens, scene, luminance_cd_m2, noise, seed }: RawRequest) -> Self {
        Self {
            design,
            lens,
            scene,
            luminance_cd_m2,
            crop: None,
            noise,
            seed,
            reference: false,
            thorough: true,
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ClippingRequest {
    pub(super) design: Value,
    #[serde(default)]
    pub(super) lens: String,
    pub(super) scene: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScoresRequest {
    pub(super) design: Value,
    #[serde(default)]
    pub(super) lens: String,
    pub(super) luminances_cd_m2: Vec<f64>,
    #[serde(default)]
    pub(super) derivatives: bool,
    /// The family of which the filters should be.
    #[serde(default)]
    pub(super) family: Option<LiveFamily>,
}

/// The filters of a family as the page searches them.
pub(super) fn space(family: LiveFamily) -> FilterSpace {
    family.space(FreeCurves { knots: KNOTS, ..FreeCurves::default() })
}

/// The filters by which it is judged whether one is of a family. Smooth curves are those that the page searches, and those with fewer knots of searches by the
/// native library and of `smalti design`.
pub(super) fn judged(family: LiveFamily) -> Vec<FilterSpace> {
    let coarse = (family == LiveFamily::Free).then(|| family.space(FreeCurves::default()));
    std::iter::once(space(family)).chain(coarse).collect()
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ImproveRequest {
    pub(super) design: Value,
    #[serde(default)]
    pub(super) lens: String,
    #[serde(default)]
    pub(super) locks: LiveLocks,
    pub(super) luminances_cd_m2: Vec<f64>,
    #[serde(default)]
    pub(super) family: LiveFamily,
}

/// What a design comes from, and the mosaic that it is to have. Arrays are `sensor.cfa` of camera descriptions.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MosaicRequest {
    /// The array of the camera that was opened.
    pub(super) base: Value,
    /// That array with the mosaic that was chosen last.
    pub(super) given: Value,
    /// The filters that were changed before that mosaic was chosen.
    pub(super) changed: Value,
    /// The array of the design.
    pub(super) array: Value,
    /// The mosaic, by its name in the catalogue.
    pub(super) mosaic: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LightRequest {
    pub(super) design: Value,
    pub(super) of: LightOf,
}

/// What the light is of.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum LightOf {
    /// The training scene and the targets.
    Training,
    /// A scene, by its name.
    Scene(String),
    /// Statistics over the training scenes.
    Statistics,
}
