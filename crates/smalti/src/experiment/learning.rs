//! Training a pipeline for a camera from the default training set, from scenes, or from saved statistics.

use serde::Serialize;

use super::error::{StageContext, ensure_memory};
use super::progress::ensure_running;
use super::{ExperimentError, Progress, Resources};
use crate::camera::stable_text::stable_text;
use crate::camera::{
    Camera, CameraDescription, CameraError, TRAINING_SET_REVISION, TrainingScene, TrainingSettings,
    training_scenes,
};
use crate::color::SRGB_WHITE;
use crate::l3::{self, Axes, Pipeline, Statistics, Training};
use crate::scene::Scene;
use crate::sensor::{Channel, ColorArchitecture};
use crate::spectrum::{Illuminant, Spectrum};

/// A scene with its name for messages and provenance.
#[derive(Debug, Clone)]
pub struct NamedScene {
    /// Its name: a catalogue name with parameters, or a file.
    pub name: String,
    /// The scene on the wavelength grid of the camera, with its field of view.
    pub scene: Scene,
}

impl NamedScene {
    /// A scene on the wavelength grid of the camera. Unless `keeps_fov`, its field of view is fitted to the sensor by
    /// [`Camera::fitted`], which `is_file` is passed to.
    ///
    /// # Errors
    /// When the scene does not cover the camera's wavelengths, or is not beyond the focal length.
    pub fn for_camera(
        camera: &Camera,
        name: String,
        scene: Scene,
        is_file: bool,
        keeps_fov: bool,
    ) -> Result<Self, ExperimentError> {
        let fitted = || -> Result<Scene, CameraError> {
            let same = scene.radiance().grid() == camera.grid();
            let scene = if same { scene } else { scene.resampled(camera.grid())? };
            if keeps_fov { Ok(scene) } else { camera.fitted(scene, is_file) }
        };
        Ok(Self { scene: fitted().in_context(|| name.clone())?, name })
    }
}

/// The training scenes of a pipeline.
#[derive(Debug, Clone)]
pub enum TrainingMaterial {
    /// The default set, with its scenes under these illuminants in turn.
    DefaultSet(Vec<Illuminant>),
    /// Given scenes.
    Scenes(Vec<NamedScene>),
}

impl TrainingMaterial {
    /// Number of scenes.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::DefaultSet(lights) => training_scenes(lights).len(),
            Self::Scenes(scenes) => scenes.len(),
        }
    }

    /// Whether there is no scene.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Names of the scenes, with their illuminants for the default set.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        match self {
            Self::DefaultSet(lights) => {
                let name = |s: &TrainingScene| format!("{} under {}", s.spec, s.light.name());
                training_scenes(lights).iter().map(name).collect()
            }
            Self::Scenes(scenes) => scenes.iter().map(|s| s.name.clone()).collect(),
        }
    }

    /// The illuminant of the first scene (photons), which determines the levels and white.
    ///
    /// # Errors
    /// [`ExperimentError::NoScene`] without scenes; when the illuminant is not defined on the camera's wavelengths.
    pub fn light(&self, camera: &Camera) -> Result<Spectrum, ExperimentError> {
        match self {
            Self::DefaultSet(lights) => {
                let light = lights.first().unwrap_or(&Illuminant::D65);
                light.photons(camera.grid()).in_context(|| light.name())
            }
            Self::Scenes(scenes) => {
                scenes.first().map(|s| s.scene.illuminant().clone()).ok_or(ExperimentError::NoScene)
            }
        }
    }
}

/// Adds every scene to the statistics. Each scene is one step of progress, which names the camera by its label.
///
/// The noise of a scene is keyed by its number in the default set, or by its name otherwise, and does not depend on the other
/// scenes. Several scenes of one name have different noise.
///
/// # Errors
/// When a scene cannot be built or imaged, or the work is stopped.
pub fn gather(
    camera: &Camera,
    label: &str,
    settings: &TrainingSettings,
    material: &TrainingMaterial,
    statistics: &mut Statistics,
    progress: &dyn Progress,
) -> Result<(), ExperimentError> {
    let mut learn = |item: u64, name: &str, scene: &dyn Fn() -> Result<Scene, CameraError>| {
        ensure_running(progress)?;
        let short = name.split('?').next().unwrap_or(name);
        progress.begin(&format!("training {label}: {short}"));
        let added = scene().and_then(|scene| camera.train_on(statistics, &scene, settings, item));
        added.in_context(|| format!("scene {name}"))?;
        progress.done();
        Ok(())
    };
    match material {
        TrainingMaterial::DefaultSet(lights) => {
            let scenes = training_scenes(lights);
            scenes.iter().zip(0..).try_for_each(|(s, item)| learn(item, &s.spec, &|| s.build(camera)))
        }
        TrainingMaterial::Scenes(scenes) => scenes.iter().enumerate().try_for_each(|(place, s)| {
            let before = scenes.iter().take(place).filter(|other| other.name == s.name).count();
            learn(item_of(&s.name, before), &s.name, &|| Ok(s.scene.clone()))
        }),
    }
}

/// The key of a scene's noise: the 32-bit FNV-1a hash of its name plus the number of earlier scenes of that name.
fn item_of(name: &str, before: usize) -> u64 {
    let hash = name.bytes().fold(0x811c_9dc5, |h: u64, b| ((h ^ u64::from(b)) * 0x0100_0193) & 0xffff_ffff);
    hash.wrapping_add(before as u64) & 0xffff_ffff
}

/// Checks that a camera has a mosaic. `label` is its name in the error.
///
/// # Errors
/// [`ExperimentError::NotMosaic`].
pub fn ensure_mosaic(camera: &Camera, label: &str) -> Result<(), ExperimentError> {
    let architecture = match camera.sensor.architecture {
        ColorArchitecture::Mosaic => return Ok(()),
        ColorArchitecture::Prism => "prism",
        ColorArchitecture::FieldSequential => "field-sequential",
    };
    Err(ExperimentError::NotMosaic { camera: label.to_owned(), architecture })
}

/// Empty statistics for pairs of raw files and pictures: the raw images are noisy, and the pictures have the white of sRGB.
/// Classes and targets are those of `fresh`.
///
/// # Errors
/// When the targets are invalid.
pub fn pair_statistics(fresh: &Statistics) -> Result<Statistics, ExperimentError> {
    let statistics = Statistics::new(fresh.axes().clone(), fresh.outputs().to_vec(), true)?;
    Ok(statistics.with_white(Some(SRGB_WHITE)))
}

/// Camera, settings and sources of training statistics, for the provenance of a pipeline.
#[derive(Debug, Clone)]
pub struct TrainingRecord {
    /// The camera.
    pub camera: CameraDescription,
    /// The settings.
    pub settings: TrainingSettings,
    /// Names of the scenes, pairs and saved statistics.
    pub sources: Vec<String>,
}

/// The provenance of a pipeline, as stored in its file.
#[derive(Serialize)]
struct Provenance<'a> {
    smalti_version: &'a str,
    camera: Option<&'a CameraDescription>,
    settings: Option<&'a TrainingSettings>,
    training: &'a Training,
    scenes: &'a [String],
    patches: u64,
}

/// Solves the kernels of every class. The provenance of the pipeline holds the record of its training, if there is one, and the
/// settings of the solver.
///
/// # Errors
/// When a setting is invalid or the statistics are empty.
pub fn solve(
    statistics: &Statistics,
    training: &Training,
    record: Option<&TrainingRecord>,
) -> Result<Pipeline, ExperimentError> {
    let provenance = stable_text(&Provenance {
        smalti_version: env!("CARGO_PKG_VERSION"),
        camera: record.map(|r| &r.camera),
        settings: record.map(|r| &r.settings),
        training,
        scenes: record.map_or(&[], |r| &r.sources),
        patches: statistics.count(),
    })
    .in_context(|| "provenance".into())?;
    Ok(training.solve(statistics, provenance)?)
}

/// All inputs of training statistics, for the cache key.
#[derive(Serialize)]
struct StatisticsKey<'a> {
    smalti_version: &'a str,
    l3_revision: u32,
    training_set_revision: u32,
    camera: &'a CameraDescription,
    /// Tile and filters of a colour filter array that differs from the description.
    other_cfa: Option<(usize, &'a [u8], &'a [Channel])>,
    light: &'a Spectrum,
    settings: &'a TrainingSettings,
}

/// Trains the pipeline for a camera on the default set under an illuminant. Statistics come from the store if it has them.
/// `label` is the name of the camera in progress.
///
/// # Errors
/// When the camera has no mosaic, a setting is invalid, memory does not suffice, or the work is stopped.
pub fn learn_default(
    camera: &Camera,
    label: &str,
    (settings, training): (&TrainingSettings, &Training),
    light: &Illuminant,
    resources: Resources<'_>,
) -> Result<Pipeline, ExperimentError> {
    ensure_mosaic(camera, label)?;
    let material = TrainingMaterial::DefaultSet(vec![light.clone()]);
    let spectrum = material.light(camera)?;
    let cfa = &camera.sensor.cfa;
    let other_cfa =
        camera.has_other_cfa().then(|| (cfa.mosaic().cols(), cfa.mosaic().cells(), cfa.channels()));
    let key = stable_text(&StatisticsKey {
        smalti_version: env!("CARGO_PKG_VERSION"),
        l3_revision: l3::REVISION,
        training_set_revision: TRAINING_SET_REVISION,
        camera: camera.description(),
        other_cfa,
        light: &spectrum,
        settings,
    })
    .in_context(|| "learning".into())?;
    let statistics = match resources.store.statistics(&key) {
        Some(statistics) => statistics,
        None => {
            let mut statistics = fresh_statistics(camera, settings, &spectrum, resources.memory_bytes)?;
            resources.progress.expect(material.len() as u64);
            gather(camera, label, settings, &material, &mut statistics, resources.progress)?;
            resources.store.keep_statistics(&key, &statistics);
            statistics
        }
    };
    let record = TrainingRecord {
        camera: camera.description().clone(),
        settings: settings.clone(),
        sources: material.names(),
    };
    solve(&statistics, training, Some(&record))
}

/// Empty statistics of a camera, with levels cut for white under an illuminant (photons).
///
/// # Errors
/// When the camera has no mosaic, a setting is invalid, or memory does not suffice.
pub fn fresh_statistics(
    camera: &Camera,
    settings: &TrainingSettings,
    light: &Spectrum,
    memory_bytes: Option<u64>,
) -> Result<Statistics, ExperimentError> {
    ensure_mosaic(camera, &camera.description().name)?;
    let statistics = camera.training_statistics(settings, light).in_context(|| "learning".into())?;
    ensure_memory(statistics.axes(), statistics.outputs().len(), memory_bytes)?;
    Ok(statistics)
}

/// Merges saved statistics, each given with its name. They must match the camera and the settings of `fresh`, under any
/// illuminant. With `add_more`, `fresh` is merged as well and must match completely.
///
/// # Errors
/// [`ExperimentError::Statistics`] when statistics do not match; [`ExperimentError::NoScene`] without statistics.
pub fn continue_statistics(
    saved: Vec<(String, Statistics)>,
    fresh: &Statistics,
    add_more: bool,
) -> Result<Statistics, ExperimentError> {
    let mut saved = saved.into_iter();
    let (name, mut statistics) = saved.next().ok_or(ExperimentError::NoScene)?;
    let refused = |reason: String| ExperimentError::Statistics { name: name.clone(), reason };
    let (its, own) = (statistics.axes(), fresh.axes());
    if its.mosaic() != own.mosaic() {
        return Err(refused("statistics of another mosaic than that of the camera".into()));
    }
    if its.side() != own.side() {
        let (its, own) = (its.side(), own.side());
        return Err(refused(format!("statistics of patches of {its} × {its}; {own} × {own} was asked for")));
    }
    if its.level_count() != own.level_count() {
        let (its, own) = (its.level_count(), own.level_count());
        return Err(refused(format!("statistics of {its} levels; {own} were asked for")));
    }
    if its.textures() != own.textures() {
        let names = |a: &Axes| a.textures().names().join(", ");
        let (its, own) = (names(its), names(own));
        return Err(refused(format!("statistics of the textures {its}; {own} were asked for")));
    }
    if its.noise() != own.noise() {
        return Err(refused("statistics of a camera with other noise (or of another exposure)".into()));
    }
    if statistics.outputs() != fresh.outputs() {
        let (its, own) = (statistics.outputs().join(", "), fresh.outputs().join(", "));
        return Err(refused(format!("statistics with targets {its}; {own} were asked for")));
    }
    let refused_merge =
        |what: String, e: l3::L3Error| ExperimentError::Statistics { name: what, reason: e.to_string() };
    if add_more {
        if statistics.noisy() != fresh.noisy() {
            return Err(refused(
                "statistics from raw files include noise and statistics from scenes do not; they cannot be combined".into(),
            ));
        }
        let what = || format!("{name}, gathered in another light or with other settings");
        statistics.merge(fresh).map_err(|e| refused_merge(what(), e))?;
    }
    for (file, other) in saved {
        statistics.merge(&other).map_err(|e| refused_merge(format!("{name} and {file}"), e))?;
    }
    Ok(statistics)
}

#[cfg(test)]
mod tests {
    use super::item_of;

    #[test]
    fn the_number_of_a_scene_depends_on_its_name_alone() {
        // FNV-1a test vectors (Fowler, Noll, Vo), 32 bits.
        assert_eq!(
            [item_of("", 0), item_of("a", 0), item_of("foobar", 0)],
            [0x811c_9dc5, 0xe40c_292c, 0xbf9c_f968]
        );
        assert_eq!(item_of("a", 1), item_of("a", 0) + 1);
    }
}
