//! How a design and its best rival score under other conditions than those of the search.

use serde::Serialize;

use super::entrants::{Entrant, score_entrants};
use super::error::StageContext;
use super::verdict::sign;
use super::{ComparisonSettings, Estimate, ExperimentError, Resources};
use crate::camera::{Camera, PICTURE_METRICS, TestScene, TrainingSettings};
use crate::design::Deviation;
use crate::l3::Training;
use crate::numeric::bootstrap::{Resamples, mean};
use crate::spectrum::Illuminant;

/// Deviations of all filters, whose pipelines stay those of the design: 5 nm and 5 % of the thickness.
pub(super) const DEVIATIONS: [Deviation; 4] = [
    Deviation { shift_nm: -5.0, thickness: 1.0 },
    Deviation { shift_nm: 5.0, thickness: 1.0 },
    Deviation { shift_nm: 0.0, thickness: 0.95 },
    Deviation { shift_nm: 0.0, thickness: 1.05 },
];
/// Illuminants of scenes and training.
const ILLUMINANTS: [Illuminant; 3] = [Illuminant::A, Illuminant::F11, Illuminant::Led];
/// Factors of the f-number: one stop.
const F_NUMBERS: [f64; 2] = [std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::SQRT_2];

/// A condition, with both cameras and the settings of the scores under it.
#[derive(Debug, Clone)]
pub struct RobustnessCase {
    /// The condition in words.
    pub name: String,
    /// The array that was found.
    pub found: Entrant,
    /// Its best rival.
    pub rival: Entrant,
    /// Scenes, illuminant, luminances and seeds.
    pub settings: ComparisonSettings,
}

/// The scores under a condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RobustnessRow {
    /// The condition in words.
    pub name: String,
    /// Number of scenes.
    pub scenes: usize,
    /// For each luminance, the means of [`PICTURE_METRICS`] of the array that was found.
    pub found: Vec<[f64; PICTURE_METRICS.len()]>,
    /// Those of the rival.
    pub rival: Vec<[f64; PICTURE_METRICS.len()]>,
    /// For each luminance and metric, how much better the array that was found is, with the interval for it alone.
    pub leads: Vec<[Estimate; PICTURE_METRICS.len()]>,
}

/// The scenes of a robustness table.
pub struct RobustnessScenes<'a, E> {
    /// Scenes under an illuminant.
    pub under: &'a dyn Fn(&Illuminant) -> Result<Vec<TestScene>, E>,
    /// Another set of scenes, with its name.
    pub other: Option<(String, Vec<TestScene>)>,
}

/// The conditions of a robustness table: as designed, other illuminants, the f-number a stop up and down, filters that deviate, and another
/// set of scenes. `clear` is the transmittance of a filter without absorbance, as for [`Deviation::of`].
///
/// # Errors
/// Those of the scenes, and when a camera cannot be built.
pub fn robustness_cases<E: From<ExperimentError>>(
    found: &Entrant,
    rival: &Entrant,
    settings: &ComparisonSettings,
    clear: f64,
    scenes: RobustnessScenes<'_, E>,
) -> Result<Vec<RobustnessCase>, E> {
    let base = ComparisonSettings { scenes: (scenes.under)(&settings.illuminant)?, ..settings.clone() };
    let case = |name: String, found: Entrant, rival: Entrant, settings: &ComparisonSettings| RobustnessCase {
        name,
        found,
        rival,
        settings: settings.clone(),
    };
    let plain =
        |name: String, settings: &ComparisonSettings| case(name, found.clone(), rival.clone(), settings);
    let mut cases = vec![plain("as designed".into(), &base)];
    for illuminant in ILLUMINANTS.into_iter().filter(|i| *i != settings.illuminant) {
        let name = format!("illuminant {}", illuminant.name());
        let scenes = (scenes.under)(&illuminant)?;
        cases.push(plain(name, &ComparisonSettings { scenes, illuminant, ..base.clone() }));
    }
    for factor in F_NUMBERS {
        let with = |entrant: &Entrant| -> Result<Entrant, ExperimentError> {
            let mut description = entrant.camera.description().clone();
            description.optics.f_number = (description.optics.f_number * factor * 100.0).round() / 100.0;
            let camera =
                Camera::new(description, entrant.camera.grid()).in_context(|| entrant.label.clone())?;
            Ok(Entrant::new(&entrant.label, camera))
        };
        let found = with(found)?;
        let name = format!("f/{}", found.camera.description().optics.f_number);
        cases.push(case(name, found, with(rival)?, &base));
    }
    for deviation in DEVIATIONS {
        let with = |entrant: &Entrant| -> Result<Entrant, ExperimentError> {
            let camera = deviation.of_camera(&entrant.camera, clear).in_context(|| entrant.label.clone())?;
            let learned_for = Some(entrant.camera.clone());
            Ok(Entrant { label: entrant.label.clone(), camera, learned_for })
        };
        cases.push(case(format!("filters {deviation}"), with(found)?, with(rival)?, &base));
    }
    if let Some((name, scenes)) = scenes.other {
        cases.push(plain(format!("scenes {name}"), &ComparisonSettings { scenes, ..base.clone() }));
    }
    Ok(cases)
}

/// Scores both cameras of each case; see [`score_entrants`].
///
/// # Errors
/// As [`score_entrants`].
pub fn robustness(
    cases: &[RobustnessCase],
    learning: (&TrainingSettings, &Training),
    resources: Resources<'_>,
) -> Result<Vec<RobustnessRow>, ExperimentError> {
    let mut rows = Vec::with_capacity(cases.len());
    for RobustnessCase { name, found, rival, settings } in cases {
        let figures = score_entrants(&[found.clone(), rival.clone()], settings, learning, resources)?;
        let [own, other] = &figures[..] else { return Err(ExperimentError::NothingToCompare) };
        let (scenes, seeds) = (settings.scenes.len(), settings.seeds().count());
        let resamples = (scenes * seeds > 1).then(|| Resamples::new(scenes, seeds, settings.seed));
        let lead = |light: usize| {
            std::array::from_fn(|metric| {
                let [a, b] = [own, other].map(|f| {
                    let values = &f.lights[light].metrics[metric];
                    values.iter().map(|v| sign(metric) * v).collect::<Vec<f64>>()
                });
                Estimate::of_difference(&a, &b, resamples.as_ref())
            })
        };
        let means = |of: &super::PictureFigures| {
            of.lights.iter().map(|l| l.metrics.each_ref().map(|v| mean(v))).collect()
        };
        rows.push(RobustnessRow {
            name: name.clone(),
            scenes,
            found: means(own),
            rival: means(other),
            leads: (0..settings.luminances_cd_m2.len()).map(lead).collect(),
        });
    }
    Ok(rows)
}
