//! Adding the scenes of the default set to what several trainings learn, which share the scenes and their optical images.

use std::collections::VecDeque;

use rayon::prelude::*;

use super::error::StageContext;
use super::material::default_scenes;
use super::progress::ensure_running;
use super::{ExperimentError, Resources};
use crate::camera::{
    Camera, CameraError, ImageSampling, SceneNoise, Stand, SurfaceReflectances, TrainingScene,
    TrainingSettings,
};
use crate::l3::Learner;
use crate::optics::OpticalImage;
use crate::scene::Scene;
use crate::sensor::{ElectronRates, FixedPattern};
use crate::spectrum::Illuminant;

/// Trainings of later turns that keep the light of the scenes of a stage. Others image the scenes again.
const KEEP_AT_MOST: u64 = 32;
/// What such a training keeps of each scene of the second stage: four planes of 256 × 256 pixels in single precision.
const KEPT_BYTES: u64 = 256 * 256 * 4 * 4;
/// The share of the free memory that is kept at most.
const KEPT_SHARE: u64 = 8;

/// A camera and the illuminant that its pipeline is learned under.
#[derive(Debug, Clone)]
pub struct DefaultTraining {
    /// The camera.
    pub camera: Camera,
    /// Its name in progress and errors.
    pub label: String,
    /// The illuminant of the training scenes.
    pub light: Illuminant,
}

impl DefaultTraining {
    /// Whether a scene has the same optical image on both cameras, except for its light.
    pub(super) fn shares_images_with(&self, other: &Self) -> bool {
        let (a, b) = (&self.camera, &other.camera);
        a.optics == b.optics && a.sensor.pixel.pitch_m == b.sensor.pixel.pitch_m && a.grid() == b.grid()
    }

    /// Its illuminant, if it is not this one.
    fn light_instead_of(&self, other: &Illuminant) -> Option<&Illuminant> {
        (self.light != *other).then_some(&self.light)
    }
}

/// A camera before a scene of the set, and the light on its pixels.
pub(super) struct Lit {
    stand: Stand,
    rates: [ElectronRates; 2],
}

/// The next scenes of the set before the camera of a training, in order.
pub(super) type LitScenes = VecDeque<Lit>;

/// A training and what learns for it. It has the light of all scenes if they were imaged for it before, otherwise of none.
pub(super) struct Gathering<'a, L> {
    of: &'a DefaultTraining,
    /// The illuminant that the scenes are built under.
    built_under: &'a Illuminant,
    learner: &'a mut L,
    lit: LitScenes,
    /// The fixed pattern of its sensor, once a scene was learned from.
    drawn: FixedPattern,
}

impl<'a, L> Gathering<'a, L> {
    pub(super) fn new(
        of: &'a DefaultTraining,
        built_under: &'a Illuminant,
        learner: &'a mut L,
        lit: LitScenes,
    ) -> Self {
        Self { of, built_under, learner, lit, drawn: FixedPattern::default() }
    }
}

/// A scene and its optical images by their sampling, which cameras share unless each makes its own.
struct ImagedScene {
    scene: Scene,
    images: Vec<(ImageSampling, OpticalImage)>,
}

/// A training whose turn comes later, and where the light of the scenes is kept for it.
pub(super) struct Later<'a> {
    pub(super) of: &'a DefaultTraining,
    pub(super) lit: &'a mut LitScenes,
}

/// Trainings whose scenes have the same optical images, except for their light.
struct Group<'a, L> {
    /// The first of those that learn.
    first: &'a DefaultTraining,
    /// The illuminant that the scenes are built under.
    built_under: &'a Illuminant,
    now: Vec<Gathering<'a, L>>,
    later: Vec<Later<'a>>,
}

/// Adds the default set to what all trainings learn. The optical images serve those of later turns as well. Each scene is one step of
/// progress, once for those that learn now and once for those that learn later.
///
/// # Errors
/// When a stage fails, or the work is stopped; with the label of the camera.
pub(super) fn add_default_set<'a, L: Learner>(
    trainings: Vec<Gathering<'a, L>>,
    later: Vec<Later<'a>>,
    settings: &TrainingSettings,
    resources: Resources<'_>,
) -> Result<(), ExperimentError> {
    let mut groups: Vec<Group<'a, L>> = Vec::new();
    for training in trainings {
        match groups.iter_mut().find(|g| g.first.shares_images_with(training.of)) {
            Some(group) => group.now.push(training),
            None => {
                let (first, built_under) = (training.of, training.built_under);
                groups.push(Group { first, built_under, now: vec![training], later: Vec::new() });
            }
        }
    }
    let bytes_each = KEPT_BYTES * default_scenes(&[], resources.training_scenes, true).len() as u64;
    let fit = resources.memory_bytes.map_or(KEEP_AT_MOST, |bytes| bytes / KEPT_SHARE / bytes_each);
    let kept = if settings.has_own_images() { 0 } else { fit.min(KEEP_AT_MOST) };
    for training in later.into_iter().take(kept as usize) {
        if let Some(group) = groups.iter_mut().find(|g| g.first.shares_images_with(training.of)) {
            group.later.push(training);
        }
    }
    let learning: Vec<_> = groups
        .into_iter()
        .map(|group| {
            let light = std::slice::from_ref(group.built_under);
            let is_second_stage = group.now.iter().any(|g| g.learner.is_second_stage());
            let scenes = default_scenes(light, resources.training_scenes, is_second_stage);
            // The turn that imaged scenes for some of a group has announced the steps of the group as well.
            if group.now.iter().all(|g| g.lit.is_empty()) {
                let turns = if group.later.is_empty() { 1 } else { 2 };
                resources.progress.expect(turns * scenes.len() as u64);
            }
            (group, scenes)
        })
        .collect();
    learning.into_iter().try_for_each(|(mut group, scenes)| group.learn(&scenes, settings, resources))
}

impl<L: Learner> Group<'_, L> {
    /// Adds all scenes.
    fn learn(
        &mut self,
        scenes: &[TrainingScene],
        settings: &TrainingSettings,
        resources: Resources<'_>,
    ) -> Result<(), ExperimentError> {
        let (first, progress, stored) = (self.first, resources.progress, resources.training_scenes);
        let dark = self.now.iter().filter(|g| g.lit.is_empty()).map(|g| g.of);
        let waiting: Vec<&DefaultTraining> = dark.chain(self.later.iter().map(|l| l.of)).collect();
        let reflectances =
            SurfaceReflectances::new(first.camera.grid()).in_context(|| first.label.clone())?;
        let imaged = |scene: &TrainingScene| -> Result<_, ExperimentError> {
            if waiting.is_empty() {
                return Ok(None);
            }
            ensure_running(progress)?;
            let failed = |e: ExperimentError| e.of_camera(&first.label);
            let context = || format!("scene {}", scene.content);
            let built = scene.build(&first.camera, &reflectances, stored).in_context(context);
            let built = built.map_err(failed)?;
            let mut samplings = Vec::new();
            for of in waiting.iter().filter(|_| !settings.has_own_images()) {
                let sampling = of.camera.training_sampling(&built).in_context(context);
                samplings.push(sampling.map_err(|e: ExperimentError| e.of_camera(&of.label))?);
            }
            let image = |sampling| {
                let image = first.camera.training_image(&built, sampling).in_context(context);
                Ok((sampling, image.map_err(failed)?))
            };
            let needed = ImageSampling::ALL.into_iter().filter(|sampling| samplings.contains(sampling));
            let images = needed.map(image).collect::<Result<_, ExperimentError>>()?;
            Ok(Some(ImagedScene { scene: built, images }))
        };
        let of = match self.now.len() {
            1 => first.label.clone(),
            count => format!("{count} pipelines"),
        };
        let mut upcoming = scenes.iter().map(|scene| (scene, imaged(scene)));
        let mut next = upcoming.next();
        let mut number = 0;
        while let Some((scene, ready)) = next {
            ensure_running(progress)?;
            progress.begin(&format!("training {of}: {}", scene.content.name()));
            let ready = ready?;
            // The next scene is imaged while the current one is learned from, because both have single-threaded parts.
            let (added, following) =
                rayon::join(|| self.add_scene((scene, number), ready.as_ref(), settings), || upcoming.next());
            added?;
            (next, number) = (following, number + 1);
            progress.done();
        }
        Ok(())
    }

    /// Adds a scene to what all trainings learn. `ready` is the scene, built under the light of the set's scene, or `None` if all have
    /// the light of the scene.
    fn add_scene(
        &mut self,
        (scene, number): (&TrainingScene, u64),
        ready: Option<&ImagedScene>,
        settings: &TrainingSettings,
    ) -> Result<(), ExperimentError> {
        let failed = |e: CameraError, of: &DefaultTraining| {
            ExperimentError::stage(format!("scene {}", scene.content), e).of_camera(&of.label)
        };
        let item = scene.item(number);
        if let Some(ImagedScene { scene: built, images }) = ready {
            if settings.has_own_images() {
                return self.now.par_iter_mut().try_for_each(|g| {
                    let light = g.of.light_instead_of(&scene.light);
                    let relit = light.map(|light| built.clone().relit(light)).transpose();
                    let relit = relit.map_err(|e| failed(e.into(), g.of))?;
                    let scene = relit.as_ref().unwrap_or(built);
                    let added = g.of.camera.train_on(g.learner, scene, settings, item);
                    added.map_err(|e| failed(e, g.of))
                });
            }
            let dark = self.now.iter_mut().filter(|g| g.lit.is_empty()).map(|g| (g.of, &mut g.lit));
            let later = self.later.iter_mut().map(|l| (l.of, &mut *l.lit));
            let mut waiting: Vec<(&DefaultTraining, &mut LitScenes)> = dark.chain(later).collect();
            for (sampling, image) in images {
                let (mut stands, mut lit) = (Vec::new(), Vec::new());
                for (of, its) in &mut waiting {
                    if of.camera.training_sampling(built).map_err(|e| failed(e, of))? == *sampling {
                        let stand = of.camera.stand(built, of.light_instead_of(&scene.light), settings);
                        stands.push(stand.map_err(|e| failed(e, of))?);
                        lit.push(its);
                    }
                }
                let sensors: Vec<_> = stands.iter().map(Stand::sensors).collect();
                let rates =
                    ElectronRates::of_all(&sensors, image).map_err(|e| failed(e.into(), self.first))?;
                for ((lit, stand), rates) in lit.into_iter().zip(stands).zip(rates) {
                    lit.push_back(Lit { stand, rates });
                }
            }
        }
        // One camera draws its noise in parallel, and need not keep it.
        let noise = (self.now.len() > 1).then(SceneNoise::new);
        self.now.par_iter_mut().try_for_each(|g| {
            let Lit { stand, rates } = g.lit.pop_front().ok_or(ExperimentError::NoScene)?;
            let drawn = (&mut g.drawn, noise.as_ref());
            stand.learn(g.learner, rates, drawn, settings, item).map_err(|e| failed(e, g.of))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{CameraDescription, NoStoredScenes, Surfaces, TrainingContent};
    use crate::l3::Statistics;
    use crate::spectrum::WavelengthGrid;

    /// Statistics of a scene that is relit from another light are those of the scene built under the light, up to rounding: noise
    /// changes the class of some patches. Those of a scene built under the light have the bits of a camera that learns alone.
    #[test]
    fn a_relit_scene_gives_the_statistics_of_its_light() {
        let camera = Camera::new(CameraDescription::default(), WavelengthGrid::VISIBLE).unwrap();
        let settings = TrainingSettings { exposures: vec![1.0, 0.1], ..TrainingSettings::default() };
        let reflectances = SurfaceReflectances::new(camera.grid()).unwrap();
        let spec = "dead-leaves?rows=96&cols=96&seed=3&least=2&largest=40";
        let spec = TrainingContent::Catalog(spec.into());
        let under = |light: &Illuminant| TrainingScene::plain(spec.clone(), Surfaces::Natural, light.clone());
        let (d65, a) = (under(&Illuminant::D65), under(&Illuminant::A));
        let statistics = |scene: &TrainingScene| {
            let built = scene.build(&camera, &reflectances, &NoStoredScenes).unwrap();
            let of = DefaultTraining { camera: camera.clone(), label: "a".into(), light: Illuminant::A };
            let spectrum = of.light.photons(camera.grid()).unwrap();
            let mut statistics = camera.training_statistics(&settings, &spectrum).unwrap();
            let (built_under, lit) = (&scene.light, LitScenes::new());
            let now = vec![Gathering::new(&of, built_under, &mut statistics, lit)];
            let image = camera.training_image(&built, ImageSampling::Halved).unwrap();
            let mut group = Group { first: &of, built_under, now, later: Vec::new() };
            let imaged = ImagedScene { scene: built, images: vec![(ImageSampling::Halved, image)] };
            group.add_scene((scene, 7), Some(&imaged), &settings).unwrap();
            statistics
        };
        let (direct, relit) = (statistics(&a), statistics(&d65));
        assert_eq!(direct.count(), relit.count());
        let built = under(&Illuminant::A).build(&camera, &reflectances, &NoStoredScenes).unwrap();
        let spectrum = Illuminant::A.photons(camera.grid()).unwrap();
        let mut alone = camera.training_statistics(&settings, &spectrum).unwrap();
        camera.train_on(&mut alone, &built, &settings, under(&Illuminant::A).item(7)).unwrap();
        assert_eq!(alone, direct);
        let mean = |s: &Statistics, of: usize| {
            let all = s.classes().values();
            all.map(|m| m.get(0, of)).sum::<f64>() / s.count() as f64
        };
        // 1, the patch of 25 samples, then X, Y, Z.
        for of in [1, 13, 25, 26, 27, 28] {
            let (direct, relit) = (mean(&direct, of), mean(&relit, of));
            assert!((direct / relit - 1.0).abs() < 1e-5, "{of}: {direct} and {relit}");
        }
        let white = |s: &Statistics| s.white();
        assert_eq!(white(&direct), white(&relit));
    }
}
