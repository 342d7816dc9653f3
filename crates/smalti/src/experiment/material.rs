//! Training scenes, and adding them to statistics.

use super::error::StageContext;
use super::progress::ensure_running;
use super::{ExperimentError, Progress};
use crate::camera::{
    Camera, CameraError, DEFAULT_TRAINING_LIGHT, StoredTrainingScenes, SurfaceReflectances, TrainingItem,
    TrainingScene, TrainingSettings, refinement_scenes, training_scenes,
};
use crate::l3::Learner;
use crate::scene::Scene;
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
            let scene = scene.resampled(camera.grid())?;
            if keeps_fov { Ok(scene) } else { camera.fitted(scene, is_file) }
        };
        Ok(Self { scene: fitted().in_context(|| name.clone())?, name })
    }
}

/// The training scenes of a pipeline.
pub(super) enum TrainingMaterial<'a> {
    /// The default set, with its scenes under these illuminants in turn, and those of its scenes that come from files.
    DefaultSet(&'a [Illuminant], &'a dyn StoredTrainingScenes),
    /// Given scenes.
    Scenes(&'a [NamedScene]),
}

impl TrainingMaterial<'_> {
    /// Number of scenes for the first or the second stage.
    pub(super) fn len(&self, is_second_stage: bool) -> usize {
        match self {
            Self::DefaultSet(lights, stored) => default_scenes(lights, *stored, is_second_stage).len(),
            Self::Scenes(scenes) => scenes.len(),
        }
    }

    /// Names of the scenes of the first stage, with their illuminants for the default set.
    pub(super) fn names(&self) -> Vec<String> {
        match self {
            Self::DefaultSet(lights, stored) => {
                let name = |s: &TrainingScene| format!("{} under {}", s.content, s.light.name());
                training_scenes(lights, *stored).iter().map(name).collect()
            }
            Self::Scenes(scenes) => scenes.iter().map(|s| s.name.clone()).collect(),
        }
    }
}

/// The first illuminant (photons), or [`DEFAULT_TRAINING_LIGHT`] without any.
pub(super) fn first_light(lights: &[Illuminant], camera: &Camera) -> Result<Spectrum, ExperimentError> {
    let light = lights.first().unwrap_or(&DEFAULT_TRAINING_LIGHT);
    light.photons(camera.grid()).in_context(|| light.name())
}

/// Adds every scene to what is learned. Each scene is one step of progress, which names the camera by its label.
///
/// The noise of a scene is keyed by its number in the default set, or by its name otherwise, and does not depend on the other
/// scenes. Several scenes of one name have different noise.
///
/// # Errors
/// When a scene cannot be built or imaged, or the work is stopped.
pub(super) fn add_scenes(
    camera: &Camera,
    label: &str,
    settings: &TrainingSettings,
    material: &TrainingMaterial<'_>,
    learner: &mut dyn Learner,
    progress: &dyn Progress,
) -> Result<(), ExperimentError> {
    let is_second_stage = learner.is_second_stage();
    let mut learn = |item: TrainingItem, name: &str, scene: &dyn Fn() -> Result<Scene, CameraError>| {
        ensure_running(progress)?;
        let short = name.split('?').next().unwrap_or(name);
        progress.begin(&format!("training {label}: {short}"));
        let added = scene().and_then(|scene| camera.train_on(learner, &scene, settings, item));
        added.in_context(|| format!("scene {name}"))?;
        progress.done();
        Ok(())
    };
    match material {
        TrainingMaterial::DefaultSet(lights, stored) => {
            let scenes = default_scenes(lights, *stored, is_second_stage);
            let reflectances = SurfaceReflectances::new(camera.grid()).in_context(|| label.to_owned())?;
            let built = |s: &TrainingScene| s.build(camera, &reflectances, *stored);
            let mut scenes = scenes.iter().zip(0..);
            scenes.try_for_each(|(s, number)| learn(s.item(number), &s.content.to_string(), &|| built(s)))
        }
        TrainingMaterial::Scenes(scenes) => scenes.iter().enumerate().try_for_each(|(place, s)| {
            let before = scenes.iter().take(place).filter(|other| other.name == s.name).count();
            learn(item_of(&s.name, before).into(), &s.name, &|| Ok(s.scene.clone()))
        }),
    }
}

/// The default set of the first or the second stage.
pub(super) fn default_scenes(
    lights: &[Illuminant],
    stored: &dyn StoredTrainingScenes,
    is_second_stage: bool,
) -> Vec<TrainingScene> {
    if is_second_stage { refinement_scenes(lights, stored) } else { training_scenes(lights, stored) }
}

/// The key of a scene's noise: the 32-bit FNV-1a hash of its name plus the number of earlier scenes of that name.
fn item_of(name: &str, before: usize) -> u64 {
    let hash = name.bytes().fold(0x811c_9dc5, |h: u64, b| ((h ^ u64::from(b)) * 0x0100_0193) & 0xffff_ffff);
    hash.wrapping_add(before as u64) & 0xffff_ffff
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::CameraDescription;
    use crate::experiment::Silent;
    use crate::l3::{Axes, L3Error, Pair, Share, Tiles};
    use crate::scene::{self, Setting};
    use crate::spectrum::WavelengthGrid;

    /// Records the shares that it is given.
    struct Record {
        axes: Axes,
        given: Vec<Share>,
    }

    impl Learner for Record {
        fn axes(&self) -> &Axes {
            &self.axes
        }

        fn add_share(&mut self, _: &Pair<'_>, share: Share) -> Result<(), L3Error> {
            self.given.push(share);
            Ok(())
        }
    }

    /// A uniform scene besides those of the catalogue.
    struct Grey;

    impl StoredTrainingScenes for Grey {
        fn names(&self) -> Vec<&'static str> {
            vec!["grey"]
        }

        fn load(&self, _: &str, grid: WavelengthGrid, _: &[Spectrum]) -> Result<Scene, String> {
            scene::uniform(32, 32, &Setting { grid, ..Setting::default() }).map_err(|e| e.to_string())
        }
    }

    /// Coarse, for speed.
    fn grid() -> WavelengthGrid {
        WavelengthGrid::new(400.0, 30.0, 11).unwrap()
    }

    fn given(material: &TrainingMaterial<'_>) -> Vec<Share> {
        let camera = Camera::new(CameraDescription::default(), grid()).unwrap();
        let settings = TrainingSettings { exposures: vec![0.5, 0.2, 0.1], ..TrainingSettings::default() };
        let light = DEFAULT_TRAINING_LIGHT.photons(grid()).unwrap();
        let axes = camera.training_axes(&settings, &light).unwrap();
        let mut record = Record { axes, given: Vec::new() };
        add_scenes(&camera, "a", &settings, material, &mut record, &Silent).unwrap();
        record.given
    }

    /// Scenes of the default set are learned from by halves, and the stored ones count more than once.
    #[test]
    fn the_default_set_is_halved_and_weighed() {
        let halves = [Tiles::Even, Tiles::Odd, Tiles::Even, Tiles::Odd];
        let last = training_scenes(&[], &Grey).len() - 1;
        let of = |scene: usize| {
            let times = if scene == last { 4 } else { 1 };
            halves[scene % 2..][..3].iter().map(move |&tiles| Share { tiles, times })
        };
        let expected: Vec<_> = (0..=last).flat_map(of).collect();
        assert_eq!(given(&TrainingMaterial::DefaultSet(&[], &Grey)), expected);
    }

    /// Given scenes may be few: all of their patches are learned from.
    #[test]
    fn given_scenes_are_learned_from_as_a_whole() {
        let scene = Grey.load("", grid(), &[]).unwrap();
        let named = |name: &str| NamedScene { name: name.into(), scene: scene.clone() };
        let scenes = [named("a"), named("b")];
        assert_eq!(given(&TrainingMaterial::Scenes(&scenes)), [Share::WHOLE; 6]);
    }

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
