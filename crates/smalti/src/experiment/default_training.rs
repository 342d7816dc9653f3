//! Learning from the default set for several cameras and lights together, which share the scenes and their optical images.

use rayon::prelude::*;
use serde::Serialize;

use super::error::StageContext;
use super::learning::{TrainingRecord, solve};
use super::material::{TrainingMaterial, built, first_light};
use super::order::Order;
use super::progress::ensure_running;
use super::training_statistics::{WhiteIn, ensure_mosaic, fresh_statistics, second_stage};
use super::{ExperimentError, Resources};
use crate::camera::stable_text::stable_text;
use crate::camera::{
    Camera, CameraDescription, CameraError, Stand, StoredTrainingScenes, TRAINING_SET_REVISION,
    TrainingScene, TrainingSettings, training_reflectances, training_scenes,
};
use crate::l3::{self, Learner, Pipeline, Quality, Statistics, Training};
use crate::optics::OpticalImage;
use crate::scene::Scene;
use crate::sensor::{Channel, ElectronRates};
use crate::spectrum::{Illuminant, Spectrum};

/// All inputs of training statistics, for the cache key.
#[derive(Serialize)]
struct StatisticsKey<'a> {
    smalti_version: &'a str,
    l3_revision: u32,
    training_set_revision: u32,
    stored_scenes: Vec<&'a str>,
    camera: &'a CameraDescription,
    /// Tile and filters of a colour filter array that differs from the description.
    other_cfa: Option<(usize, &'a [u8], &'a [Channel])>,
    light: &'a Spectrum,
    settings: &'a TrainingSettings,
}

/// A camera and the illuminant that its pipeline is learned under.
#[derive(Debug, Clone, Copy)]
pub struct DefaultTraining<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Its name in progress and errors.
    pub label: &'a str,
    /// The illuminant of the training scenes.
    pub light: &'a Illuminant,
}

impl DefaultTraining<'_> {
    /// Whether a scene has the same optical image on both cameras, except for its light.
    fn shares_images_with(&self, other: &Self) -> bool {
        let (a, b) = (self.camera, other.camera);
        a.optics == b.optics && a.sensor.pixel.pitch_m == b.sensor.pixel.pitch_m && a.grid() == b.grid()
    }

    /// Its illuminant, if it is not this one.
    fn light_instead_of(&self, other: &Illuminant) -> Option<&Illuminant> {
        (self.light != other).then_some(self.light)
    }

    fn key(
        &self,
        settings: &TrainingSettings,
        light: &Spectrum,
        stored: &dyn StoredTrainingScenes,
    ) -> Result<String, ExperimentError> {
        let cfa = &self.camera.sensor.cfa;
        let other_cfa =
            self.camera.has_other_cfa().then(|| (cfa.mosaic().cols(), cfa.mosaic().cells(), cfa.channels()));
        stable_text(&StatisticsKey {
            smalti_version: env!("CARGO_PKG_VERSION"),
            l3_revision: l3::REVISION,
            training_set_revision: TRAINING_SET_REVISION,
            stored_scenes: stored.names(),
            camera: self.camera.description(),
            other_cfa,
            light,
            settings,
        })
        .in_context(|| "learning".into())
    }
}

/// Trains pipelines on the default set, each for a camera and an illuminant. Statistics come from the store if it has them. Each
/// scene is one step of progress.
///
/// # Errors
/// When a camera has no mosaic, a setting is invalid, memory does not suffice, or the work is stopped; with the label of the camera.
pub fn learn_default(
    trainings: &[DefaultTraining<'_>],
    (settings, training): (&TrainingSettings, &Training),
    resources: Resources<'_>,
) -> Result<Vec<Pipeline>, ExperimentError> {
    let mut gathered = Vec::with_capacity(trainings.len());
    for of in trainings {
        let start = || -> Result<Gathered<'_>, ExperimentError> {
            ensure_mosaic(of.camera, of.label)?;
            let light = first_light(std::slice::from_ref(of.light), of.camera)?;
            let key = of.key(settings, &light, resources.training_scenes)?;
            let (learner, is_new) = match resources.store.statistics(&key) {
                Some(stored) => (stored, false),
                None => (fresh_statistics(of.camera, settings, &light, resources.memory_bytes)?, true),
            };
            Ok(Gathered { gathering: Gathering { of: *of, learner }, key, light, is_new })
        };
        gathered.push(start().map_err(|e| e.of_camera(of.label))?);
    }
    let new = gathered.iter_mut().filter(|g| g.is_new).map(|g| &mut g.gathering);
    add_default_set(new.collect(), settings, resources)?;
    for g in gathered.iter().filter(|g| g.is_new) {
        resources.store.keep_statistics(&g.key, &g.gathering.learner);
    }
    let solved = Order::Parallel.map(
        gathered,
        |Gathered { gathering: Gathering { of, learner }, light, key, .. }| {
            let names =
                TrainingMaterial::DefaultSet(std::slice::from_ref(of.light), resources.training_scenes)
                    .names();
            let record = TrainingRecord::new(of.camera, settings, names);
            let pipeline = solve(&learner, training, Some(&record)).map_err(|e| e.of_camera(of.label))?;
            let key =
                stable_text(&(l3::REFINEMENT_REVISION, key, training)).in_context(|| "learning".into())?;
            Ok::<_, ExperimentError>(FirstStage { of, light, pipeline, key })
        },
    )?;
    match training.quality {
        Quality::Fast => Ok(solved.into_iter().map(|first| first.pipeline).collect()),
        Quality::Best => refined(solved, settings, resources),
    }
}

/// A pipeline of one stage, with its training, the illuminant of that, photons, and the key of both stages.
struct FirstStage<'a> {
    of: DefaultTraining<'a>,
    light: Spectrum,
    pipeline: Pipeline,
    key: String,
}

/// Learns the second stages of pipelines. Each scene is one step of progress.
fn refined(
    pipelines: Vec<FirstStage<'_>>,
    settings: &TrainingSettings,
    resources: Resources<'_>,
) -> Result<Vec<Pipeline>, ExperimentError> {
    let mut refined: Vec<Option<Pipeline>> =
        pipelines.iter().map(|first| resources.store.pipeline(&first.key)).collect();
    let missing: Vec<(&FirstStage<'_>, &mut Option<Pipeline>)> =
        pipelines.iter().zip(&mut refined).filter(|(_, stored)| stored.is_none()).collect();
    let mut gathered = Vec::with_capacity(missing.len());
    for (FirstStage { of, light, pipeline, .. }, _) in &missing {
        let learner =
            second_stage(of.camera, WhiteIn::Light(light), pipeline).map_err(|e| e.of_camera(of.label))?;
        gathered.push(Gathering { of: *of, learner });
    }
    add_default_set(gathered.iter_mut().collect(), settings, resources)?;
    Order::Parallel.map(
        missing.into_iter().zip(gathered),
        |((first, both), Gathering { of, learner })| {
            let solved = learner.solve().in_context(|| "learning".into());
            let solved = solved.map_err(|e: ExperimentError| e.of_camera(of.label))?;
            resources.store.keep_pipeline(&first.key, &solved);
            *both = Some(solved);
            Ok::<_, ExperimentError>(())
        },
    )?;
    Ok(refined.into_iter().flatten().collect())
}

/// A training, and what it has learned so far.
struct Gathering<'a, L> {
    of: DefaultTraining<'a>,
    learner: L,
}

/// The statistics of the first stage of a training.
struct Gathered<'a> {
    gathering: Gathering<'a, Statistics>,
    key: String,
    /// The illuminant, photons.
    light: Spectrum,
    /// Whether they are still to be gathered.
    is_new: bool,
}

/// Adds the default set to what all trainings learn.
fn add_default_set<L: Learner>(
    trainings: Vec<&mut Gathering<'_, L>>,
    settings: &TrainingSettings,
    resources: Resources<'_>,
) -> Result<(), ExperimentError> {
    let mut groups: Vec<Vec<&mut Gathering<'_, L>>> = Vec::new();
    for training in trainings {
        let shared =
            groups.iter_mut().find(|g| g.first().is_some_and(|f| f.of.shares_images_with(&training.of)));
        match shared {
            Some(group) => group.push(training),
            None => groups.push(vec![training]),
        }
    }
    let (progress, stored) = (resources.progress, resources.training_scenes);
    for group in &mut groups {
        let Some((first, is_local)) = group.first().map(|g| (g.of, g.learner.learns_local_light())) else {
            continue;
        };
        let (scenes, count) = (training_scenes(std::slice::from_ref(first.light), stored), group.len());
        progress.expect(scenes.len() as u64);
        let reflectances =
            training_reflectances(first.camera.grid()).in_context(|| first.label.to_owned())?;
        let prepared = |scene: &TrainingScene| {
            ensure_running(progress)?;
            let failed = |e: ExperimentError| e.of_camera(first.label);
            let context = || format!("scene {}", scene.content);
            let built = built(scene, first.camera, &reflectances, stored, is_local).in_context(context);
            let built = built.map_err(failed)?;
            let shared = || first.camera.optics.image(&built).in_context(context).map_err(failed);
            let image = (!settings.has_own_images()).then(shared).transpose()?;
            Ok::<_, ExperimentError>((built, image))
        };
        let mut upcoming = scenes.iter().map(|scene| (scene, prepared(scene)));
        let mut next = upcoming.next();
        let mut number = 0;
        while let Some((scene, ready)) = next {
            ensure_running(progress)?;
            let of = if count == 1 { first.label.to_owned() } else { format!("{count} pipelines") };
            progress.begin(&format!("training {of}: {}", scene.content.name()));
            let ready = ready?;
            // The next scene is prepared while the current one is learned from, because both have single-threaded parts.
            let (added, following) =
                rayon::join(|| add_scene(group, (scene, &ready), settings, number), || upcoming.next());
            added?;
            (next, number) = (following, number + 1);
            progress.done();
        }
    }
    Ok(())
}

/// Adds a scene that was built under the light of the set's scene to all trainings, with their shared optical image; `None` if each makes its own.
fn add_scene<L: Learner>(
    group: &mut [&mut Gathering<'_, L>],
    (scene, (built, image)): (&TrainingScene, &(Scene, Option<OpticalImage>)),
    settings: &TrainingSettings,
    number: u64,
) -> Result<(), ExperimentError> {
    let failed = |e: CameraError, of: &DefaultTraining<'_>| {
        ExperimentError::stage(format!("scene {}", scene.content), e).of_camera(of.label)
    };
    let Some(first) = group.first().map(|g| g.of) else { return Ok(()) };
    let item = scene.item(number);
    let Some(image) = image else {
        return group.par_iter_mut().try_for_each(|g| {
            let relit =
                g.of.light_instead_of(&scene.light).map(|light| built.clone().relit(light)).transpose();
            let relit = relit.map_err(|e| failed(e.into(), &g.of))?;
            let added = g.of.camera.train_on(&mut g.learner, relit.as_ref().unwrap_or(built), settings, item);
            added.map_err(|e| failed(e, &g.of))
        });
    };
    let stand = |g: &&mut Gathering<'_, L>| {
        let stand = g.of.camera.stand(built, g.of.light_instead_of(&scene.light), settings);
        stand.map_err(|e| failed(e, &g.of))
    };
    let stands = group.iter().map(stand).collect::<Result<Vec<_>, _>>()?;
    let sensors: Vec<_> = stands.iter().map(Stand::sensors).collect();
    let rates = ElectronRates::of_all(&sensors, image).map_err(|e| failed(e.into(), &first))?;
    let learning = group.par_iter_mut().zip(&stands).zip(rates);
    learning.try_for_each(|((g, stand), rates)| {
        stand.learn(&mut g.learner, rates, settings, item).map_err(|e| failed(e, &g.of))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{NoStoredScenes, TrainingContent};
    use crate::spectrum::WavelengthGrid;

    fn gathering<'a>(
        camera: &'a Camera,
        light: &'a Illuminant,
        settings: &TrainingSettings,
    ) -> Gathering<'a, Statistics> {
        let spectrum = light.photons(camera.grid()).unwrap();
        let statistics = camera.training_statistics(settings, &spectrum).unwrap();
        let of = DefaultTraining { camera, label: "a", light };
        Gathering { of, learner: statistics }
    }

    /// Statistics of a scene that is relit from another light are those of the scene built under the light, up to rounding: noise
    /// changes the class of some patches.
    #[test]
    fn a_relit_scene_gives_the_statistics_of_its_light() {
        let camera = Camera::new(CameraDescription::default(), WavelengthGrid::VISIBLE).unwrap();
        let settings = TrainingSettings { exposures: vec![1.0, 0.1], ..TrainingSettings::default() };
        let reflectances = training_reflectances(camera.grid()).unwrap();
        let spec = "dead-leaves?rows=96&cols=96&seed=3&least=2&largest=40";
        let spec = TrainingContent::Catalog(spec.into());
        let under = |light: &Illuminant| TrainingScene {
            content: spec.clone(),
            light: light.clone(),
            has_warm_light: false,
        };
        let (d65, a) = (under(&Illuminant::D65), under(&Illuminant::A));
        let statistics = |scene: &TrainingScene| {
            let built = scene.build(&camera, &reflectances, &NoStoredScenes).unwrap();
            let mut gathering = gathering(&camera, &Illuminant::A, &settings);
            let image = camera.optics.image(&built).unwrap();
            add_scene(&mut [&mut gathering], (scene, &(built, Some(image))), &settings, 7).unwrap();
            gathering.learner
        };
        let (direct, relit) = (statistics(&a), statistics(&d65));
        assert_eq!(direct.count(), relit.count());
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
