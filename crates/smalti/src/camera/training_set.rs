//! The default training scenes and their reflectances.

use std::fmt;

use super::{Camera, CameraError, TrainingItem};
use crate::color::jakob_hanika2019::Uplift;
use crate::scene::{Glints, Scene, Setting, catalog};
use crate::spectrum::{Illuminant, Observer, Spectrum, WavelengthGrid, reflectance};

/// Revision of the default training set of the first stage. It increases when the scenes, their optical images or their parts that are
/// learned from change, so that cached statistics are not reused. What only the second stage learns from is part of
/// [`REFINEMENT_REVISION`](crate::l3::REFINEMENT_REVISION) instead.
pub const TRAINING_SET_REVISION: u32 = 6;

/// The illuminant of training where none is given.
pub const DEFAULT_TRAINING_LIGHT: Illuminant = Illuminant::D65;

/// Side of a default training scene, pixels of the sensor.
const SCENE_PX: usize = 256;
/// Samples per pixel: two, so that detail beyond the sensor's Nyquist frequency can alias.
pub(crate) const SAMPLES_PER_PX: usize = 2;
/// Number of scenes of dead leaves, without and with stored scenes, of which some show leaves.
const LEAVES: [usize; 2] = [12, 8];
/// The sizes that the patches of each chart of uniform patches begin at.
const LEAST_PATCHES: [u32; 3] = [3, 8, 5];
/// The light that reaches a warm part of a scene, and the light without the warmth: a shift by 159 mired, that of a filter that makes
/// daylight the light of a film lamp.
const WARM_INSTEAD_OF_COOL: [Illuminant; 2] =
    [Illuminant::Blackbody { temperature_k: 3200.0 }, Illuminant::Blackbody { temperature_k: 6500.0 }];
/// Number of grey reflectances among those of natural objects, and of painted ones among paints.
const GREYS: usize = 16;
const GREYS_AMONG_PAINTS: usize = 8;
/// White paint reflects violet light as its pigment, titanium dioxide (rutile), does: a logistic edge, nm, and its width, nm.
const WHITE_PAINT_NM: [f64; 2] = [402.0, 9.0];
/// Whites of the first stage that white paint replaces: parts of the specifications of scenes, of which the first one that has each is
/// painted. The others stay even, because a mosaic cannot tell the two whites apart.
const PAINTED_WHITES: [&str; 4] = ["paint=white", "glossy-balls", "siemens-star", "grey-steps"];
/// Glints on a fiftieth of the samples and thus near every tenth pixel, most of them about as bright as white.
const GLINTS: Glints = Glints { share: 0.02, least: 0.7, exponent: 1.5, seed: 0 };
/// Scenes with glints, less their size: leaves of four scales.
const GLINTING_SCENES: [&str; 4] = [
    "dead-leaves?seed=40&least=1.5&largest=200",
    "dead-leaves?seed=41&least=3&largest=60",
    "dead-leaves?seed=42&least=1&largest=30",
    "dead-leaves?seed=43&least=8&largest=400",
];
/// Scenes of paints, less their size, and whether they have warm local light.
const PAINTED_SCENES: [(&str, bool); 3] = [
    ("dead-leaves?seed=32&least=3&largest=60", true),
    ("color-patches?seed=31&least=3", false),
    ("color-patches?seed=32&least=5", true),
];

/// A scene of the default training set.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainingScene {
    /// Its content.
    pub content: TrainingContent,
    /// What its surfaces reflect.
    pub surfaces: Surfaces,
    /// Its illuminant.
    pub light: Illuminant,
    /// Whether it has warm local light: see [`TrainingScene::build`].
    pub has_warm_light: bool,
    /// Whether its radiance is multiplied by the reflectance of white paint: see [`TrainingScene::build`].
    pub has_painted_white: bool,
    /// The seed of its glints, if it has any: see [`TrainingScene::build`].
    pub glints: Option<u64>,
}

/// What the surfaces of a training scene reflect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Surfaces {
    /// The [`training_reflectances`].
    Natural,
    /// The same, with greys of white paint, which absorb violet light.
    NaturalAndPaintedGreys,
    /// The same and [paints](reflectance::paints).
    NaturalAndPaints,
    /// [Paints](reflectance::paints) and such greys.
    Paints,
}

impl Surfaces {
    /// All kinds.
    pub const ALL: [Self; 4] =
        [Self::Natural, Self::NaturalAndPaintedGreys, Self::NaturalAndPaints, Self::Paints];
}

/// The reflectances of all [`Surfaces`] on a wavelength grid.
#[derive(Debug, Clone)]
pub struct SurfaceReflectances {
    natural: Vec<Spectrum>,
    natural_and_painted_greys: Vec<Spectrum>,
    natural_and_paints: Vec<Spectrum>,
    paints: Vec<Spectrum>,
    white_paint: Spectrum,
}

impl SurfaceReflectances {
    /// All of them.
    ///
    /// # Errors
    /// As [`training_reflectances`].
    pub fn new(grid: WavelengthGrid) -> Result<Self, CameraError> {
        let [edge, width] = WHITE_PAINT_NM;
        let passed = grid.wavelengths_nm().map(|nm| 1.0 / (1.0 + (-(nm - edge) / width).exp()));
        let white_paint = Spectrum::new(grid, passed.collect())?;
        let chips: Vec<Spectrum> = reflectance::paints(grid)?.into_iter().map(|(_, s)| s).collect();
        let chromatic = Chromatic::new(grid)?;
        let natural_and_painted_greys = chromatic.with_greys(&white_paint)?;
        Ok(Self {
            natural: chromatic.with_greys(&even_white(grid)?)?,
            natural_and_paints: [natural_and_painted_greys.as_slice(), &chips].concat(),
            natural_and_painted_greys,
            paints: [chips, greys(&white_paint, GREYS_AMONG_PAINTS)?].concat(),
            white_paint,
        })
    }

    /// Those of a kind.
    #[must_use]
    pub fn of(&self, surfaces: Surfaces) -> &[Spectrum] {
        match surfaces {
            Surfaces::Natural => &self.natural,
            Surfaces::NaturalAndPaintedGreys => &self.natural_and_painted_greys,
            Surfaces::NaturalAndPaints => &self.natural_and_paints,
            Surfaces::Paints => &self.paints,
        }
    }
}

/// The content of a training scene.
#[derive(Debug, Clone, PartialEq)]
pub enum TrainingContent {
    /// A scene of the catalogue, by its name with parameters.
    Catalog(String),
    /// A scene of [`StoredTrainingScenes`], by its name.
    Stored(&'static str),
}

/// Training scenes that come from files. The library opens no file, so the caller provides them.
pub trait StoredTrainingScenes: Sync {
    /// Their names.
    fn names(&self) -> Vec<&'static str>;

    /// The scene of a name on a wavelength grid, under any one illuminant that is nowhere 0, with two samples per pixel. Its surfaces
    /// have the `reflectances`, which are on the grid.
    ///
    /// # Errors
    /// Why the scene cannot be loaded.
    fn load(&self, name: &str, grid: WavelengthGrid, reflectances: &[Spectrum]) -> Result<Scene, String>;
}

/// No stored training scenes.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoStoredScenes;

impl StoredTrainingScenes for NoStoredScenes {
    fn names(&self) -> Vec<&'static str> {
        Vec::new()
    }

    fn load(&self, name: &str, _: WavelengthGrid, _: &[Spectrum]) -> Result<Scene, String> {
        Err(format!("there is no stored training scene {name}"))
    }
}

/// The default training set of the first stage. The scenes take the illuminants in turn, or D65 if there is none:
///
/// - dead leaves and charts of uniform patches at several scales, in natural and in saturated colours;
/// - gradients between colours and between light and shade, and shading on white paper, because clipped areas in pictures are
///   mostly white;
/// - glossy balls with highlights, lamps and deep shade, of high dynamic range;
/// - edges, Siemens stars, gratings and a grey ramp;
/// - the `stored` scenes: photographs and path-traced scenes. With them, there are fewer dead leaves.
///
/// It contains none of the [`test_scenes`](super::test_scenes), none of the targets of [`evaluate`](super::evaluate()), no
/// reflectance of the ColorChecker, and none of the [`surfaces`](reflectance::surfaces) of which rendered test scenes and photographs
/// are made. The dead leaves of the test scenes have other shapes but the same reflectances of natural objects, so that their scores
/// stay comparable with those of earlier versions.
#[must_use]
pub fn training_scenes(lights: &[Illuminant], stored: &dyn StoredTrainingScenes) -> Vec<TrainingScene> {
    let n = SCENE_PX * SAMPLES_PER_PX;
    let stored: Vec<TrainingContent> = stored.names().into_iter().map(TrainingContent::Stored).collect();
    let leaves = LEAVES[usize::from(!stored.is_empty())];
    let mut specs: Vec<String> = (0..leaves).map(|i| dead_leaves(i, n)).collect();
    let patches =
        |(i, least): (usize, u32)| format!("color-patches?rows={n}&cols={n}&seed={}&least={least}", i + 1);
    specs.extend(LEAST_PATCHES.into_iter().enumerate().map(patches));
    let gradients =
        |(i, cell): (usize, u32)| format!("gradients?rows={n}&cols={n}&seed={}&cell={cell}", i + 1);
    specs.extend([64, 128].into_iter().enumerate().map(gradients));
    let paper = |(i, cell): (usize, u32)| {
        format!("gradients?rows={n}&cols={n}&seed={}&cell={cell}&contrast=3&paint=white", i + 11)
    };
    specs.extend([64, 32].into_iter().enumerate().map(paper));
    specs.extend((1..=3).map(|seed| format!("glossy-balls?rows={n}&cols={n}&seed={seed}")));
    specs.extend([
        format!("slanted-bar?size={}&angle=11&contrast=100&sampling=area", n + 1),
        format!("checkerboard?squares=11&square={}&contrast=50", n / 11),
        format!("siemens-star?size={n}&cycles=36&contrast=20"),
        format!("frequency-sweep?rows={n}&cols={n}&contrast=0.05"),
        format!("grey-steps?steps=16&step={}&rows={n}&density=2", n / 16),
    ]);
    let contents = specs.into_iter().map(TrainingContent::Catalog).chain(stored);
    let lights = if lights.is_empty() { &[DEFAULT_TRAINING_LIGHT][..] } else { lights };
    // Every illuminant occurs with every scale of leaves.
    let light = |i: usize| lights[(i + i / 4) % lights.len()].clone();
    let scene = |(i, content)| TrainingScene::plain(content, Surfaces::Natural, light(i));
    contents.enumerate().map(scene).collect()
}

/// The default training set of the second stage: the [`training_scenes`] with painted greys instead of even ones, and seven further
/// scenes. Four of these are leaves with glints; one of leaves and two of patches have the colours of paints. Among the
/// [`training_scenes`], every second scene of leaves and patches has warm local light, as have two of the scenes of paints. Leaves in warm
/// light and all patches also have paints among their surfaces. One scene of white paper, one of glossy balls, the star and the grey ramp
/// have the white of paint, because the whites of paint and print, of which photographs are full, absorb violet light.
///
/// What [`training_scenes`] leaves out for the tests, it leaves out as well.
#[must_use]
pub fn refinement_scenes(lights: &[Illuminant], stored: &dyn StoredTrainingScenes) -> Vec<TrainingScene> {
    let n = SCENE_PX * SAMPLES_PER_PX;
    let mut all = training_scenes(lights, stored);
    let mut whites = PAINTED_WHITES.to_vec();
    for (i, scene) in all.iter_mut().enumerate() {
        let name = scene.content.name();
        scene.has_warm_light = i % 2 == 1 && ["dead-leaves", "color-patches"].contains(&name);
        let has_paints = scene.has_warm_light || name == "color-patches";
        scene.surfaces =
            if has_paints { Surfaces::NaturalAndPaints } else { Surfaces::NaturalAndPaintedGreys };
        let spec = scene.content.to_string();
        let white = whites.iter().position(|part| spec.contains(part));
        scene.has_painted_white = white.map(|i| whites.remove(i)).is_some();
    }
    let further = |spec: &str, surfaces| {
        let content = TrainingContent::Catalog(format!("{spec}&rows={n}&cols={n}"));
        TrainingScene::plain(content, surfaces, DEFAULT_TRAINING_LIGHT)
    };
    let glinting = (0..).zip(GLINTING_SCENES).map(|(seed, spec)| TrainingScene {
        glints: Some(seed),
        ..further(spec, Surfaces::NaturalAndPaintedGreys)
    });
    let painted = PAINTED_SCENES
        .into_iter()
        .map(|(spec, has_warm_light)| TrainingScene { has_warm_light, ..further(spec, Surfaces::Paints) });
    // They take the illuminants of the first scenes.
    let lights: Vec<Illuminant> = all.iter().map(|s| s.light.clone()).collect();
    all.extend(glinting.chain(painted).zip(lights).map(|(scene, light)| TrainingScene { light, ..scene }));
    all
}

impl fmt::Display for TrainingContent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Catalog(spec) => f.write_str(spec),
            Self::Stored(name) => f.write_str(name),
        }
    }
}

/// How many times the pairs of a stored scene count for the second stage of pipelines. The seven natural scenes then have 45 % of the
/// weight. With less, the uniform areas of the others would teach it to take faint natural texture for noise.
const STORED_TIMES: u32 = 4;
/// How many times the pairs of a scene with glints count for the second stage. Such scenes are few, and few of their pixels show a glint.
const GLINTING_TIMES: u32 = 2;

impl TrainingContent {
    /// The name without parameters.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Catalog(spec) => spec.split('?').next().unwrap_or(spec),
            Self::Stored(name) => name,
        }
    }
}

/// Dead leaves number `i` of `n` × `n` samples, at four scales in turn, with seeds below those of the test scenes.
pub(crate) fn dead_leaves(i: usize, n: usize) -> String {
    let scales = [(1.5, 200), (3.0, 60), (1.0, 30), (8.0, 400)];
    let (least, largest) = scales[i % scales.len()];
    format!("dead-leaves?rows={n}&cols={n}&seed={}&least={least}&largest={largest}", i + 1)
}

impl TrainingScene {
    /// A scene with the light of its illuminant alone, even whites and no glints.
    #[must_use]
    pub fn plain(content: TrainingContent, surfaces: Surfaces, light: Illuminant) -> Self {
        Self { content, surfaces, light, has_warm_light: false, has_painted_white: false, glints: None }
    }

    /// The scene in training, by its number in the set.
    #[must_use]
    pub fn item(&self, number: u64) -> TrainingItem {
        let times = match self.content {
            TrainingContent::Catalog(_) if self.glints.is_some() => GLINTING_TIMES,
            TrainingContent::Catalog(_) => 1,
            TrainingContent::Stored(_) => STORED_TIMES,
        };
        TrainingItem::halved(number, times)
    }

    /// Builds the scene with the field of view that it needs on a camera. `reflectances` are on the wavelengths of the camera; `stored`
    /// are the scenes that were given to [`training_scenes`].
    ///
    /// In warm local light, the spectra of its pixels are those under other light than its illuminant, which remains the white: the light
    /// of a scene varies from place to place, mostly towards red, where walls, wood or the evening sun lend it their colour. Without such
    /// scenes, the second stage of a pipeline would take everything bright and warm for one of the few surfaces of that colour that it
    /// has seen.
    ///
    /// With a painted white, its radiance is multiplied by the reflectance of white paint, which absorbs violet light as its pigment,
    /// titanium dioxide, does. White paper then is painted paper.
    ///
    /// [Glints] have the colour of the light, but a mosaic samples each in one or two of its channels. Without such scenes, the second
    /// stage would take the false colours that follow for those of surfaces.
    ///
    /// # Errors
    /// When there is no such scene, it cannot be loaded, or the wavelengths differ.
    pub fn build(
        &self,
        camera: &Camera,
        reflectances: &SurfaceReflectances,
        stored: &dyn StoredTrainingScenes,
    ) -> Result<Scene, CameraError> {
        let surfaces = reflectances.of(self.surfaces);
        let grid = camera.grid();
        let setting = Setting { illuminant: self.light.clone(), grid, ..Setting::default() };
        let scene = match &self.content {
            TrainingContent::Catalog(spec) => catalog::build(spec, &setting, surfaces)?,
            TrainingContent::Stored(name) => {
                let loaded = stored.load(name, grid, surfaces);
                let named = |reason| CameraError::StoredScene { name: (*name).into(), reason };
                let lit = loaded.map_err(named)?.relit(&self.light)?;
                lit.with_distance(setting.distance_m)?.with_mean_luminance(setting.luminance_cd_m2)?
            }
        };
        let px = scene.radiance().cols() / SAMPLES_PER_PX;
        let deg = camera.field_of_view_deg(px.max(1), setting.distance_m)?;
        let scene = scene.with_fov(deg)?;
        let scene =
            if self.has_painted_white { scene.multiplied_by(&reflectances.white_paint)? } else { scene };
        let scene = match self.glints {
            Some(seed) => scene.with_glints(&Glints { seed, ..GLINTS })?,
            None => scene,
        };
        let [warm, cool] = &WARM_INSTEAD_OF_COOL;
        Ok(if self.has_warm_light { scene.in_local_light(warm, cool)? } else { scene })
    }
}

/// Reflectances of natural objects, greys, and a few saturated colours computed from RGB. Greys are rare in nature, but pipelines
/// must render neutrals accurately. Saturated colours are few, because each reduces the accuracy of the others.
///
/// # Errors
/// When reflectances cannot be computed from RGB on the grid.
pub fn training_reflectances(grid: WavelengthGrid) -> Result<Vec<Spectrum>, CameraError> {
    Chromatic::new(grid)?.with_greys(&even_white(grid)?)
}

/// The [`training_reflectances`] without greys.
struct Chromatic {
    objects: Vec<Spectrum>,
    saturated: Vec<Spectrum>,
}

impl Chromatic {
    fn new(grid: WavelengthGrid) -> Result<Self, CameraError> {
        let uplift = Uplift::new(grid, Observer::Cie1931)?;
        const ENDS: [f64; 2] = [0.1, 0.6];
        let mut saturated = Vec::with_capacity(8);
        for r in ENDS {
            for g in ENDS {
                for b in ENDS {
                    saturated.push(uplift.reflectance([r, g, b])?);
                }
            }
        }
        let objects = reflectance::natural(grid)?.into_iter().map(|(_, s)| s).collect();
        Ok(Self { objects, saturated })
    }

    /// All of them, with shades of a white at the places of the greys.
    fn with_greys(&self, white: &Spectrum) -> Result<Vec<Spectrum>, CameraError> {
        Ok([self.objects.as_slice(), &greys(white, GREYS)?, &self.saturated].concat())
    }
}

/// A white that reflects all light.
fn even_white(grid: WavelengthGrid) -> Result<Spectrum, CameraError> {
    Ok(Spectrum::constant(grid, 1.0)?)
}

/// Shades of a white, in equal steps of the square root up to 0.95 of it.
fn greys(white: &Spectrum, count: usize) -> Result<Vec<Spectrum>, CameraError> {
    (1..=count).map(|i| Ok(white.scaled((i as f64 / count as f64).powi(2) * 0.95)?)).collect()
}
