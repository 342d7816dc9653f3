//! Comparisons of cameras, each with its processing, on the same scenes.

use std::ops::Range;

use super::contender::{Contender, ScoredScene, score_scene};
use super::error::StageContext;
use super::outcome::Outcome;
use super::progress::ensure_running;
use super::verdict::{LIGHT_METRIC, QualityAtMoreLight, Scores, Verdict};
use super::{
    ComparedPictures, ExperimentError, ExposurePlan, ExposurePolicy, Processing, Progress, Resources,
};
use crate::camera::compare::cpsnr_of_seeds;
use crate::camera::{Camera, EvaluationSettings, ScoreSettings, Setup, TestScene};
use crate::spectrum::Illuminant;

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
}

/// Compares contenders on scenes. The result holds an outcome for each contender and luminance, each one step of progress, and a
/// verdict. Cameras with the same lens and pixel pitch share the optical images.
///
/// # Errors
/// When a contender lacks its pipeline, a stage fails, or the work is stopped.
pub fn compare(
    contenders: &[Contender<'_>],
    settings: &ComparisonSettings,
    resources: Resources<'_>,
) -> Result<Compared, ExperimentError> {
    resources.progress.expect((contenders.len() * settings.luminances_cd_m2.len()) as u64);
    let cameras: Vec<(&str, &Camera)> = contenders.iter().map(|c| (c.label, c.camera)).collect();
    // The first camera's images serve the exposure times as well.
    let mut setups = contenders.first().map_or(Ok(Vec::new()), |c| imaged(c, settings, &[], resources))?;
    let pictures = ComparedPictures {
        scenes: &settings.scenes,
        luminances_cd_m2: &settings.luminances_cd_m2,
        illuminant: &settings.illuminant,
        setups: &setups,
    };
    let exposure = ExposurePlan::new(settings.exposure, &cameras, pictures, resources)?;
    let mut outcomes = Vec::with_capacity(contenders.len());
    for (i, contender) in contenders.iter().enumerate() {
        if contender.processing == Processing::L3 && contender.pipelines.is_none() {
            return Err(ExperimentError::NoPipeline { camera: contender.label.to_owned() });
        }
        if i > 0 {
            setups = imaged(contender, settings, &setups, resources)?;
        }
        let at = |light: usize| {
            let scored = outcome(contender, light, &setups, settings, &exposure, resources);
            scored.map_err(|e| exposure.explained(contender.label, e))
        };
        outcomes.push((0..settings.luminances_cd_m2.len()).map(at).collect::<Result<_, _>>()?);
    }
    let verdict = verdict(contenders, settings, &exposure, (&outcomes, setups), resources)?;
    Ok(Compared { outcomes, exposure, verdict })
}

/// The verdict of a comparison. `last` are the scenes on the last contender's camera.
fn verdict(
    contenders: &[Contender<'_>],
    settings: &ComparisonSettings,
    exposure: &ExposurePlan,
    (outcomes, last): (&[Vec<Outcome>], Vec<Setup>),
    resources: Resources<'_>,
) -> Result<Verdict, ExperimentError> {
    let mut imaged_on = (contenders.len().wrapping_sub(1), last);
    let scores = Scores::new(outcomes, settings.seed);
    let cpsnr_db = |contender: usize, light: usize| -> Vec<f64> {
        let outcome = outcomes.get(contender).and_then(|o| o.get(light));
        outcome.map_or_else(Vec::new, |o| o.figures(LIGHT_METRIC))
    };
    let more_light = |number: usize, best: usize, light: usize| -> Result<_, ExperimentError> {
        let contender = &contenders[number];
        let luminance_cd_m2 = settings.luminances_cd_m2[light];
        resources.progress.begin(&format!("{} at more than {luminance_cd_m2} cd/m²", contender.name()));
        if imaged_on.0 != number {
            imaged_on = (number, imaged(contender, settings, &imaged_on.1, resources)?);
        }
        let quality = |factor: f64| -> Result<Vec<f64>, ExperimentError> {
            let on_scene = |(i, setup): (usize, &Setup)| {
                ensure_running(resources.progress)?;
                let scored = || {
                    let exposed = setup.in_light(luminance_cd_m2)?.exposed(exposure.scene_s(i, light))?;
                    let lit = exposed.in_light(factor)?;
                    let isp = contender.isp(&lit.light, resources.progress)?;
                    cpsnr_of_seeds(&lit, &*isp, settings.seeds(), &settings.score)
                };
                scored().in_context(|| contender.name())
            };
            Ok(imaged_on.1.iter().enumerate().map(on_scene).collect::<Result<Vec<_>, _>>()?.concat())
        };
        let (own, target) = (cpsnr_db(number, light), cpsnr_db(best, light));
        QualityAtMoreLight::measure(&own, &target, scores.resamples(), quality)
    };
    scores.verdict(&settings.luminances_cd_m2, more_light)
}

/// The scenes on the camera of a contender, with the optical images of another camera where possible.
pub(super) fn imaged(
    contender: &Contender<'_>,
    settings: &ComparisonSettings,
    others: &[Setup],
    resources: Resources<'_>,
) -> Result<Vec<Setup>, ExperimentError> {
    let on_camera = |(i, scene): (usize, &TestScene)| {
        ensure_running(resources.progress)?;
        let setup = scene.before_sharing(contender.camera, &settings.illuminant, others.get(i));
        setup.in_context(|| scene.name().to_owned())
    };
    settings.scenes.iter().enumerate().map(on_camera).collect()
}

fn outcome(
    contender: &Contender<'_>,
    light: usize,
    setups: &[Setup],
    settings: &ComparisonSettings,
    exposure: &ExposurePlan,
    resources: Resources<'_>,
) -> Result<Outcome, ExperimentError> {
    let (progress, luminance_cd_m2) = (resources.progress, settings.luminances_cd_m2[light]);
    progress.begin(&format!("{} at {luminance_cd_m2} cd/m²", contender.name()));
    let illuminant = settings.illuminant.clone();
    let targets = EvaluationSettings {
        luminance_cd_m2,
        illuminant,
        seed: settings.seed,
        exposure: exposure.targets(light),
    };
    let (targets, pictures) = contender.evaluate(&targets, resources)?;
    let scenes = scene_scores(contender, light, setups, settings, exposure, progress)?;
    let edge = pictures.edge_sfr().in_context(|| contender.name())?;
    let outcome = Outcome { luminance_cd_m2, targets, edge, scenes };
    let [cpsnr_db, delta_e, scielab] = outcome.means();
    progress.preliminary(&format!(
        "{} at {luminance_cd_m2} cd/m²: CPSNR {cpsnr_db:.2} dB, ΔE2000 {delta_e:.2}, S-CIELAB {scielab:.2}",
        contender.name()
    ));
    progress.done();
    Ok(outcome)
}

/// The scores of a contender on every scene at a luminance, with the names of the scenes.
pub(super) fn scene_scores(
    contender: &Contender<'_>,
    light: usize,
    setups: &[Setup],
    settings: &ComparisonSettings,
    exposure: &ExposurePlan,
    progress: &dyn Progress,
) -> Result<Vec<(String, ScoredScene)>, ExperimentError> {
    let luminance_cd_m2 = settings.luminances_cd_m2[light];
    let on_scene = |(i, (scene, setup)): (usize, (&TestScene, &Setup))| {
        let light = (luminance_cd_m2, exposure.scene_s(i, light));
        let scored = score_scene(contender, setup, light, settings.seeds(), &settings.score, progress);
        let scored = scored.map_err(|e| match e {
            ExperimentError::Stage { context, source } => {
                ExperimentError::Stage { context: format!("{context}, {}", scene.name()), source }
            }
            other => other,
        })?;
        Ok((scene.name().to_owned(), scored))
    };
    settings.scenes.iter().zip(setups).enumerate().map(on_scene).collect()
}
