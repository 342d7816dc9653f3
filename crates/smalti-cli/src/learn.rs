//! Learning a pipeline for a camera: scenes in turn, with progress, and a cache of what has been learned.

use anyhow::{Context, bail, ensure};
use serde_json::json;
use smalti::camera::{Camera, TrainingScene, TrainingSettings, training_scenes};
use smalti::l3::{Axes, Pipeline, Statistics, Training};
use smalti::scene::Scene;
use smalti::sensor::ColorArchitecture;
use smalti::spectrum::Illuminant;
use smalti_io::cache::{Cache, CacheKey, KeyBuilder};
use smalti_io::memory;

use crate::progress::Progress;

/// Number of what learning gives for the same settings: raised when the default scenes or the mathematics change.
const REVISION: u32 = 3;

/// What is learned from.
pub(crate) enum Material {
    /// The default set under these lights.
    Default(Vec<Illuminant>),
    /// Scenes of the user's, each with its name.
    Scenes(Vec<(String, Scene)>),
}

impl Material {
    /// Scenes to go through.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Default(lights) => training_scenes(lights).len(),
            Self::Scenes(scenes) => scenes.len(),
        }
    }

    /// Names of the scenes, with their lights.
    pub(crate) fn names(&self) -> Vec<String> {
        match self {
            Self::Default(lights) => {
                let name = |s: &TrainingScene| format!("{} under {}", s.spec, s.light.name());
                training_scenes(lights).iter().map(name).collect()
            }
            Self::Scenes(scenes) => scenes.iter().map(|(name, _)| name.clone()).collect(),
        }
    }

    /// The light that white is seen under: that of the first scene.
    pub(crate) fn light(&self, camera: &Camera) -> anyhow::Result<smalti::spectrum::Spectrum> {
        Ok(match self {
            Self::Default(lights) => lights.first().unwrap_or(&Illuminant::D65).photons(camera.grid())?,
            Self::Scenes(scenes) => {
                let first = scenes.first().context("there is no scene to learn from")?;
                first.1.illuminant().clone()
            }
        })
    }
}

/// Goes through the scenes; one step of progress each.
pub(crate) fn gather(
    camera: &Camera,
    settings: &TrainingSettings,
    material: &Material,
    statistics: &mut Statistics,
    progress: &Progress,
) -> anyhow::Result<()> {
    let name = &camera.description().name;
    let learn = |statistics: &mut Statistics, item: u64, what: &str, scene: &Scene| {
        progress.begin(format!("{name} learns from {}", what.split('?').next().unwrap_or(what)));
        camera.train_on(statistics, scene, settings, item).with_context(|| format!("scene {what}"))?;
        progress.done();
        anyhow::Ok(())
    };
    match material {
        Material::Default(lights) => {
            for (item, of_set) in training_scenes(lights).iter().enumerate() {
                learn(statistics, item as u64, &of_set.spec, &of_set.build(camera)?)?;
            }
        }
        Material::Scenes(scenes) => {
            for (what, scene) in scenes {
                learn(statistics, item_of(what), what, scene)?;
            }
        }
    }
    Ok(())
}

/// The number that a scene's noise is keyed by, from its name: the same whether it is learned from alone, in parts or with
/// others. (FNV-1a, 32 bits.)
fn item_of(name: &str) -> u64 {
    name.bytes().fold(0x811c_9dc5, |h: u64, b| ((h ^ u64::from(b)) * 0x0100_0193) & 0xffff_ffff)
}

/// That a camera is one that pipelines are learned for.
pub(crate) fn ensure_mosaic(camera: &Camera) -> anyhow::Result<()> {
    let architecture = match camera.sensor.architecture {
        ColorArchitecture::Mosaic => return Ok(()),
        ColorArchitecture::Prism => "prism",
        ColorArchitecture::FieldSequential => "field-sequential",
    };
    let name = &camera.description().name;
    bail!(
        "{name}: `sensor.architecture` is {architecture}: every pixel sees every channel; learned pipelines are for mosaics"
    )
}

/// Refuses classes whose moments and kernels would fill the memory. Combinations of clipped channels, which come with
/// the scenes, may need more.
pub(crate) fn ensure_memory(axes: &Axes, outputs: usize) -> anyhow::Result<()> {
    let (levels, textures) = (axes.level_count(), axes.textures().count());
    let size = 1 + axes.taps() + outputs;
    let each = size * (size + 1) / 2 * size_of::<f64>() + outputs * axes.taps() * size_of::<f32>();
    let classes = axes.positions().saturating_mul(levels * textures);
    let need = (classes as u64).saturating_mul(each as u64);
    let Some(available) = memory::available_bytes() else { return Ok(()) };
    ensure!(
        need <= available,
        "a table of {} positions × {levels} levels × {textures} textures with patches of {side} × {side} takes {} MiB of \
         memory to learn; {} are available: a smaller --patch, fewer --levels or --textures none take less",
        axes.positions(),
        need >> 20,
        available >> 20,
        side = axes.side(),
    );
    Ok(())
}

/// How a pipeline was learned, for its file.
pub(crate) fn provenance(
    camera: &Camera,
    settings: &TrainingSettings,
    training: &Training,
    scenes: &[String],
    patches: u64,
) -> anyhow::Result<String> {
    Ok(serde_json::to_string(&json!({
        "smalti_version": env!("CARGO_PKG_VERSION"),
        "camera": camera.description(),
        "settings": format!("{settings:?}"),
        "training": format!("{training:?}"),
        "scenes": scenes,
        "patches": patches,
    }))?)
}

/// The pipeline for a camera, learned from the default set under a light. Its statistics come from the cache where they are there.
pub(crate) fn learned(
    camera: &Camera,
    settings: &TrainingSettings,
    training: &Training,
    light: &Illuminant,
    cache: &Cache,
    progress: &Progress,
) -> anyhow::Result<Pipeline> {
    let (key, material) = (key(camera, settings, light)?, Material::Default(vec![light.clone()]));
    let statistics = match cache.get_statistics(&key) {
        Some(statistics) => statistics,
        None => {
            let mut statistics = camera.training_statistics(settings, &material.light(camera)?)?;
            ensure_memory(statistics.axes(), statistics.outputs().len())?;
            progress.more(material.len() as u64);
            gather(camera, settings, &material, &mut statistics, progress)?;
            // A cache that cannot be written costs time, not the result.
            let _ = cache.put_statistics(&key, &statistics);
            statistics
        }
    };
    let story = provenance(camera, settings, training, &material.names(), statistics.count())?;
    Ok(training.solve(&statistics, story)?)
}

/// What statistics depend on.
fn key(camera: &Camera, settings: &TrainingSettings, light: &Illuminant) -> anyhow::Result<CacheKey> {
    let lit = light.photons(camera.grid())?;
    let description = serde_json::to_string(camera.description())?;
    let mut hash = KeyBuilder::new();
    hash.bytes("l3 revision", &REVISION.to_le_bytes())
        .bytes("version", env!("CARGO_PKG_VERSION").as_bytes())
        .bytes("camera", description.as_bytes())
        .bytes("light", format!("{:?} {:?}", camera.grid(), lit.values()).as_bytes())
        .bytes("settings", format!("{settings:?}").as_bytes());
    Ok(hash.finish())
}
