//! Comparisons of cameras, each with its processing, on the same scenes.

use std::ops::Range;

use rayon::prelude::*;

use super::contender::{Contender, ScoredScene, score_integrated};
use super::error::StageContext;
use super::order::Order;
use super::outcome::{Outcome, means};
use super::progress::ensure_running;
use super::store::{ImagesInMemory, Store};
use super::verdict::{LIGHT_METRIC, QualityAtMoreLight, Scores, Verdict};
use super::{
    ComparedPictures, ExperimentError, ExposurePlan, ExposurePolicy, Pipelines, Processing, Progress,
    Resources,
};
use crate::camera::compare::IntegratedScene;
use crate::camera::{
    COMPARED_NOISE_CAPTURES, Camera, Evaluation, EvaluationSettings, ScoreSettings, Setup, TestScene,
};
use crate::metrics::esfr::EdgeSfr;
use crate::spectrum::Illuminant;

/// Contenders whose pictures of a small scene are scored at a time, which bounds the memory of their optical images.
const CONTENDERS_AT_ONCE: usize = 4;

/// Settings of a comparison.
#[derive(Debug, Clone)]
pub struct ComparisonSettings {
    /// Mean luminances of the scenes, cd/m².
    pub luminances_cd_m2: Vec<f64>,
    /// Their illuminant.
    pub illuminant: Illuminant,
    /// The scenes.
    pub scenes: Vec<TestScene>,
    /// Seed of the noise: that of the targets and the first of the scenes.
    pub seed: u64,
    /// The number of seeds for each scene, at least 1.
    pub seed_count: u64,
    /// Viewing conditions of the scores.
    pub score: ScoreSettings,
    /// The choice of the exposure times.
    pub exposure: ExposurePolicy,
}

/// The results of a comparison.
pub struct Compared {
    /// For each contender an outcome per luminance.
    pub outcomes: Vec<Vec<Outcome>>,
    /// The exposure times.
    pub exposure: ExposurePlan,
    /// Who is better at which light, by how much, and how certainly.
    pub verdict: Verdict,
}

impl ComparisonSettings {
    /// The seeds of each scene.
    #[must_use]
    pub fn seeds(&self) -> Range<u64> {
        self.seed..self.seed.saturating_add(self.seed_count.max(1))
    }

    /// The pictures; `setups` are the scenes imaged on one of the cameras, in the same order, or none.
    #[must_use]
    pub fn pictures<'a>(&'a self, setups: &'a [Setup]) -> ComparedPictures<'a> {
        ComparedPictures {
            scenes: &self.scenes,
            luminances_cd_m2: &self.luminances_cd_m2,
            illuminant: &self.illuminant,
            setups,
        }
    }
}

/// Compares contenders on scenes. The result holds an outcome for each contender and luminance, and a verdict. Cameras with the
/// same lens and pixel pitch share the optical images. All contenders are scored on one scene before the next one, so that
/// [`Progress::preliminary`] compares them from the first scene on. The targets and each scene are steps of progress, for each
/// contender and luminance.
///
/// # Errors
/// When a contender lacks its pipeline, a stage fails, or the work is stopped.
pub fn compare(
    contenders: &[Contender<'_>],
    settings: &ComparisonSettings,
    resources: Resources<'_>,
) -> Result<Compared, ExperimentError> {
    compare_with(contenders, None, settings, resources)
}

/// [`compare`] for contenders with these pipelines, some of which may be still to be learned. Scenes that need none of those are scored
/// before.
///
/// # Errors
/// As [`compare`] and [`Pipelines::learn_rest`].
pub fn compare_while_learning(
    contenders: &[Contender<'_>],
    pipelines: &Pipelines,
    settings: &ComparisonSettings,
    resources: Resources<'_>,
) -> Result<Compared, ExperimentError> {
    compare_with(contenders, Some(pipelines), settings, resources)
}

/// [`compare`], which learns the rest of the pipelines before the scenes that need it.
fn compare_with(
    contenders: &[Contender<'_>],
    pipelines: Option<&Pipelines>,
    settings: &ComparisonSettings,
    resources: Resources<'_>,
) -> Result<Compared, ExperimentError> {
    let (lights, scenes) = (settings.luminances_cd_m2.len(), settings.scenes.len());
    resources.progress.expect((contenders.len() * lights * (scenes + 1)) as u64);
    let has_pipeline = |c: &Contender<'_>, scene: &TestScene| {
        let light = scene.light(&settings.illuminant, c.camera.grid());
        light.is_ok_and(|light| c.is_ready_for(&light))
    };
    let mut learned = contenders.iter().filter(|c| c.processing == Processing::L3);
    let lacks = |c: &&Contender<'_>| {
        c.pipelines.is_none()
            || pipelines.is_none() && !settings.scenes.iter().all(|scene| has_pipeline(c, scene))
    };
    if let Some(contender) = learned.find(lacks) {
        return Err(ExperimentError::NoPipeline { camera: contender.label.to_owned() });
    }
    let cameras: Vec<(&str, &Camera)> = contenders.iter().map(|c| (c.label, c.camera)).collect();
    // The first camera's images serve the exposure times and the verdict as well.
    let metered = match contenders.first() {
        Some(first) if settings.exposure.meters(&cameras) => imaged(first, settings, &[], resources)?,
        _ => Vec::new(),
    };
    let exposure = ExposurePlan::new(settings.exposure, &cameras, settings.pictures(&metered), resources)?;
    let mut setups: Vec<Option<Setup>> = metered.into_iter().map(Some).collect();
    setups.resize(scenes, None);
    let scoring = Scoring { contenders, settings, exposure: &exposure, resources };
    let mut scored: Vec<Option<SceneRow>> = (0..scenes).map(|_| None).collect();
    let mut score = |scene: usize| -> Result<(), ExperimentError> {
        let setup = setups[scene].take().map_or_else(|| scoring.imaged_first(scene), Ok)?;
        scored[scene] = Some(scoring.scene(scene, &setup)?);
        setups[scene] = Some(setup);
        resources.progress.preliminary(&preliminary_table(contenders, settings, &scored));
        Ok(())
    };
    let is_ready = |scene: &usize| contenders.iter().all(|c| has_pipeline(c, &settings.scenes[*scene]));
    let (early, late): (Vec<usize>, Vec<usize>) = (0..scenes).partition(is_ready);
    // The targets show nothing before they are all done, and so come after the first scene.
    let mut early = early.into_iter();
    early.next().map_or(Ok(()), &mut score)?;
    load(&settings.scenes)?;
    let targets = scoring.targets()?;
    early.try_for_each(&mut score)?;
    if let Some(pipelines) = pipelines.filter(|_| !late.is_empty()) {
        pipelines.learn_rest(resources)?;
    }
    late.into_iter().try_for_each(score)?;
    let outcomes = outcomes(settings, targets, scored);
    let setups: Vec<Setup> = setups.into_iter().flatten().collect();
    let verdict = verdict(contenders, settings, &exposure, (&outcomes, setups), resources)?;
    Ok(Compared { outcomes, exposure, verdict })
}

/// The scores on a scene, for each contender and luminance.
type SceneRow = Vec<Vec<ScoredScene>>;

/// The scores on the targets, with the response to the edge.
type TargetScores = (Evaluation, Option<EdgeSfr>);

/// What all scores of a comparison have in common.
#[derive(Clone, Copy)]
struct Scoring<'a> {
    contenders: &'a [Contender<'a>],
    settings: &'a ComparisonSettings,
    exposure: &'a ExposurePlan,
    resources: Resources<'a>,
}

impl Scoring<'_> {
    /// A scene on the camera of the first contender.
    fn imaged_first(&self, scene: usize) -> Result<Setup, ExperimentError> {
        let first = self.contenders.first().ok_or(ExperimentError::NothingToCompare)?;
        image(first, scene, self.settings, None, self.resources)
    }

    /// The scores of all contenders on a scene. `first` is the scene on the camera of the first one.
    fn scene(&self, scene: usize, first: &Setup) -> Result<SceneRow, ExperimentError> {
        let Self { contenders, settings, exposure, resources } = *self;
        let mut last = first.clone();
        let order = Order::of(std::slice::from_ref(first));
        let at_once = if order == Order::Parallel { CONTENDERS_AT_ONCE } else { 1 };
        let mut row = Vec::with_capacity(contenders.len());
        for contenders in contenders.chunks(at_once) {
            let mut imaged = Vec::with_capacity(at_once);
            for contender in contenders {
                last = image(contender, scene, settings, Some(&last), resources)?;
                imaged.push((contender, last.clone()));
            }
            row.extend(order.map(imaged, |(contender, setup)| {
                let scored = scene_scores(contender, (scene, &setup), settings, exposure, resources.progress);
                scored.map_err(|e| exposure.explained(contender.label, e))
            })?);
        }
        Ok(row)
    }

    /// The scores on the targets, for each contender and luminance. Contenders share the optical images of the targets at a
    /// luminance, and so come one after another.
    fn targets(&self) -> Result<Vec<Vec<TargetScores>>, ExperimentError> {
        let Self { contenders, settings, exposure, resources } = *self;
        let mut found: Vec<Vec<TargetScores>> = contenders.iter().map(|_| Vec::new()).collect();
        for light in 0..settings.luminances_cd_m2.len() {
            let images = ImagesInMemory::new(resources.store);
            let store: &dyn Store = if contenders.len() > 1 { &images } else { resources.store };
            let shared = Resources { store, ..resources };
            for (contender, found) in contenders.iter().zip(&mut found) {
                let scored = targets(contender, light, settings, exposure, shared);
                found.push(scored.map_err(|e| exposure.explained(contender.label, e))?);
            }
        }
        Ok(found)
    }
}

/// The scores of every contender and luminance, those of the scenes in the order of the settings.
fn outcomes(
    settings: &ComparisonSettings,
    targets: Vec<Vec<TargetScores>>,
    scored: Vec<Option<SceneRow>>,
) -> Vec<Vec<Outcome>> {
    let outcome = |((targets, edge), &luminance_cd_m2): (TargetScores, &f64)| Outcome {
        luminance_cd_m2,
        targets,
        edge,
        scenes: Vec::with_capacity(settings.scenes.len()),
    };
    let of_contender = |of: Vec<_>| of.into_iter().zip(&settings.luminances_cd_m2).map(outcome).collect();
    let mut outcomes: Vec<Vec<Outcome>> = targets.into_iter().map(of_contender).collect();
    for (scene, row) in settings.scenes.iter().zip(scored) {
        for (outcome, scored) in outcomes.iter_mut().flatten().zip(row.into_iter().flatten().flatten()) {
            outcome.scenes.push((scene.name().to_owned(), scored));
        }
    }
    outcomes
}

/// The means over the scenes that are scored so far.
fn preliminary_table(
    contenders: &[Contender<'_>],
    settings: &ComparisonSettings,
    scored: &[Option<SceneRow>],
) -> String {
    let width = contenders.iter().map(|c| c.name().chars().count()).max().unwrap_or(0);
    let count = scored.iter().flatten().count();
    let mut table = format!("Means over {count} of {} scenes", scored.len());
    for (light, luminance_cd_m2) in settings.luminances_cd_m2.iter().enumerate() {
        for (number, contender) in contenders.iter().enumerate() {
            let of_scenes = scored.iter().flatten().filter_map(|row| row.get(number)?.get(light));
            let of_scenes: Vec<&ScoredScene> = of_scenes.collect();
            let [cpsnr_db, delta_e, scielab] = means(of_scenes.iter().copied());
            table += &format!(
                "\n{:width$} {luminance_cd_m2:>6} cd/m²  CPSNR {cpsnr_db:5.2} dB  ΔE2000 {delta_e:5.2}  S-CIELAB {scielab:5.2}",
                contender.name(),
            );
        }
    }
    table
}

/// The verdict of a comparison. `first` are the scenes on the first contender's camera.
fn verdict(
    contenders: &[Contender<'_>],
    settings: &ComparisonSettings,
    exposure: &ExposurePlan,
    (outcomes, first): (&[Vec<Outcome>], Vec<Setup>),
    resources: Resources<'_>,
) -> Result<Verdict, ExperimentError> {
    let progress = resources.progress;
    let scores = Scores::new(outcomes, settings.seed);
    let cpsnr_db = |contender: usize, light: usize| -> Vec<f64> {
        let outcome = outcomes.get(contender).and_then(|o| o.get(light));
        outcome.map_or_else(Vec::new, |o| o.figures(LIGHT_METRIC))
    };
    let order = Order::of(&first);
    // The scenes on the camera of one contender at a time.
    let mut integrated: Option<(usize, Vec<IntegratedScene>)> = None;
    let more_light = |number: usize, best: usize, light: usize| -> Result<_, ExperimentError> {
        let contender = &contenders[number];
        let luminance_cd_m2 = settings.luminances_cd_m2[light];
        progress.begin(&format!("{} at more than {luminance_cd_m2} cd/m²", contender.name()));
        if integrated.as_ref().is_none_or(|(of, _)| *of != number) {
            let imaged = imaged(contender, settings, &first, resources)?;
            let scenes = order.map(imaged, IntegratedScene::new);
            integrated = Some((number, scenes.in_context(|| contender.name())?));
        }
        let scenes = integrated.as_ref().map_or(&[][..], |(_, scenes)| scenes);
        let quality = |factor: f64| -> Result<Vec<f64>, ExperimentError> {
            let on_scene = |(i, scene): (usize, &IntegratedScene)| {
                ensure_running(progress)?;
                let scored = || {
                    let exposure = scene.exposure(luminance_cd_m2, exposure.scene_s(i, light))?;
                    let at = luminance_cd_m2 * factor;
                    let isp = contender.isp(&scene.light(at)?, progress)?;
                    scene.cpsnr_of_seeds((at, &exposure), &*isp, settings.seeds(), &settings.score)
                };
                scored().in_context(|| contender.name())
            };
            Ok(order.map(scenes.iter().enumerate(), on_scene)?.concat())
        };
        let (own, target) = (cpsnr_db(number, light), cpsnr_db(best, light));
        QualityAtMoreLight::measure(&own, &target, scores.resamples(), quality)
    };
    scores.verdict(&settings.luminances_cd_m2, more_light)
}

/// Loads all scenes in parallel.
fn load(scenes: &[TestScene]) -> Result<(), ExperimentError> {
    let loaded = |scene: &TestScene| scene.loaded().map(drop).in_context(|| scene.name().to_owned());
    scenes.par_iter().try_for_each(loaded)
}

/// The scenes on the camera of a contender, with the optical images of another camera where possible.
pub(super) fn imaged(
    contender: &Contender<'_>,
    settings: &ComparisonSettings,
    others: &[Setup],
    resources: Resources<'_>,
) -> Result<Vec<Setup>, ExperimentError> {
    load(&settings.scenes)?;
    let on_camera = |scene: usize| image(contender, scene, settings, others.get(scene), resources);
    Order::of(others).map(0..settings.scenes.len(), on_camera)
}

/// A scene on the camera of a contender, with the optical image of another camera if possible.
fn image(
    contender: &Contender<'_>,
    scene: usize,
    settings: &ComparisonSettings,
    other: Option<&Setup>,
    resources: Resources<'_>,
) -> Result<Setup, ExperimentError> {
    ensure_running(resources.progress)?;
    let scene = &settings.scenes[scene];
    let setup = scene.before_sharing(contender.camera, &settings.illuminant, other);
    setup.in_context(|| scene.name().to_owned())
}

/// The scores of a contender on the targets at a luminance, with the response to the edge.
fn targets(
    contender: &Contender<'_>,
    light: usize,
    settings: &ComparisonSettings,
    exposure: &ExposurePlan,
    resources: Resources<'_>,
) -> Result<(Evaluation, Option<EdgeSfr>), ExperimentError> {
    let (progress, luminance_cd_m2) = (resources.progress, settings.luminances_cd_m2[light]);
    progress.begin(&format!("{} at {luminance_cd_m2} cd/m², targets", contender.name()));
    let targets = EvaluationSettings {
        luminance_cd_m2,
        illuminant: settings.illuminant.clone(),
        seed: settings.seed,
        noise_captures: COMPARED_NOISE_CAPTURES,
        exposure: exposure.targets(light),
    };
    let (targets, pictures) = contender.evaluate(&targets, resources)?;
    let edge = pictures.edge_sfr().in_context(|| contender.name())?;
    progress.done();
    Ok((targets, edge))
}

/// The scores of a contender on a scene at every luminance.
pub(super) fn scene_scores(
    contender: &Contender<'_>,
    (number, setup): (usize, &Setup),
    settings: &ComparisonSettings,
    exposure: &ExposurePlan,
    progress: &dyn Progress,
) -> Result<Vec<ScoredScene>, ExperimentError> {
    ensure_running(progress)?;
    let scene = settings.scenes[number].name();
    let integrated = IntegratedScene::new(setup.clone());
    let integrated = integrated.in_context(|| format!("{}, {scene}", contender.name()))?;
    let at = |(light, luminance_cd_m2): (usize, &f64)| {
        progress.begin(&format!("{} at {luminance_cd_m2} cd/m², {scene}", contender.name()));
        let light = (*luminance_cd_m2, exposure.scene_s(number, light));
        let seeds = settings.seeds();
        let scored = score_integrated(contender, &integrated, light, seeds, &settings.score, progress);
        let scored = scored.map_err(|e| match e {
            ExperimentError::Stage { context, source } => {
                ExperimentError::Stage { context: format!("{context}, {scene}"), source }
            }
            other => other,
        })?;
        progress.done();
        Ok(scored)
    };
    Order::of(std::slice::from_ref(setup)).map(settings.luminances_cd_m2.iter().enumerate(), at)
}
