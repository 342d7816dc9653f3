//! Exposure times of a comparison. A camera that exposes longer collects more light, so scores at different times compare
//! exposure rules rather than cameras.

use super::error::StageContext;
use super::progress::ensure_running;
use super::{ExperimentError, Resources};
use crate::camera::evaluate::ensure_targets_show_something;
use crate::camera::target::Target;
use crate::camera::{Camera, CameraError, EvaluationSettings, ExposureTimes, Setup, TestScene};
use crate::numeric::{Number, require};
use crate::optics::OpticalImage;
use crate::scene::Setting;
use crate::sensor::{AutoExposure, SensorError};
use crate::spectrum::Illuminant;

/// Relative difference up to which exposure times count as equal.
const SAME_TIME: f64 = 1e-6;
/// The factor by which one camera must shorten the times of the others to be named: two stops.
const NOTABLE_FACTOR: f64 = 4.0;

/// The longest exposure time that suits every camera of a comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EqualExposure {
    /// The share of the samples of any camera that may saturate, 0 to below 1. Noise does not count.
    pub saturated_share: f64,
    /// The longest time, s.
    pub longest_s: f64,
}

impl Default for EqualExposure {
    /// Half a percent of the samples, which [`ScoreSettings`](crate::camera::ScoreSettings) lets exceed white; at most 33 ms, a
    /// frame of video.
    fn default() -> Self {
        Self { saturated_share: 0.005, longest_s: 0.033 }
    }
}

/// The choice of the exposure times of a comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ExposurePolicy {
    /// The time or the rule of each camera's description.
    Own,
    /// One time for every picture, s.
    Time(f64),
    /// For each picture, the longest time at which no camera saturates more than a share of its samples.
    Equal(EqualExposure),
    /// [`ExposurePolicy::Own`] if these times are the same for all cameras, otherwise [`ExposurePolicy::Equal`].
    AutoEqual(EqualExposure),
}

impl ExposurePolicy {
    /// The policies that have a name on the command line and in Python, with the limits of equal times.
    #[must_use]
    pub fn named(limits: EqualExposure) -> [(&'static str, Self); 3] {
        [("own", Self::Own), ("equal", Self::Equal(limits)), ("auto-equal", Self::AutoEqual(limits))]
    }

    /// The policy with other limits of equal times.
    #[must_use]
    pub fn with_limits(self, limits: EqualExposure) -> Self {
        match self {
            Self::Equal(_) => Self::Equal(limits),
            Self::AutoEqual(_) => Self::AutoEqual(limits),
            Self::Own | Self::Time(_) => self,
        }
    }

    /// Whether the times for these labelled cameras depend on the pictures.
    pub(super) fn meters(self, cameras: &[(&str, &Camera)]) -> bool {
        let time_s = |(_, camera): &(&str, &Camera)| camera.stated_time_s();
        match self {
            Self::Own | Self::Time(_) => false,
            Self::Equal(_) => true,
            Self::AutoEqual(_) => {
                let cameras = distinct(cameras);
                let first = cameras.first().and_then(time_s);
                cameras.len() > 1 && !cameras.iter().all(|c| first.is_some() && time_s(c) == first)
            }
        }
    }

    /// Checks that a time that is given leaves something of the chart and of the edge of low contrast unsaturated, for every camera at every
    /// luminance, before any work for the comparison. Times that are chosen by a rule do. `labels` are the unique names of the cameras in errors.
    ///
    /// # Errors
    /// With the label of the camera, the luminance and the longest time, when all samples of a target saturate; when a stage fails.
    pub fn ensure_targets_show_something(
        self,
        cameras: &[Camera],
        labels: &[String],
        luminances_cd_m2: &[f64],
        illuminant: &Illuminant,
        resources: Resources<'_>,
    ) -> Result<(), ExperimentError> {
        let Self::Time(time_s) = self else { return Ok(()) };
        let times = ExposureTimes { macbeth_s: time_s, edge_s: time_s, zone_plate_s: time_s };
        for (camera, label) in cameras.iter().zip(labels) {
            for &luminance_cd_m2 in luminances_cd_m2 {
                ensure_running(resources.progress)?;
                let settings = EvaluationSettings {
                    luminance_cd_m2,
                    illuminant: illuminant.clone(),
                    exposure: Some(times),
                    ..EvaluationSettings::default()
                };
                let context = || format!("{label} at {} cd/m²", Number(luminance_cd_m2));
                ensure_targets_show_something(camera, &settings, &resources.images()).in_context(context)?;
            }
        }
        Ok(())
    }
}

impl Default for ExposurePolicy {
    fn default() -> Self {
        Self::AutoEqual(EqualExposure::default())
    }
}

/// The exposure times of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct ExposurePlan {
    /// The policy that was applied, never [`ExposurePolicy::AutoEqual`].
    applied: ExposurePolicy,
    /// For equal times: for each scene, then for the chart, the edge and the zone plate, the time in each light, s.
    times_s: Vec<Vec<f64>>,
    limiting: Option<LimitingCamera>,
}

/// A camera that makes the equal times of a comparison much shorter than the others need.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitingCamera {
    /// Its label.
    pub label: String,
    /// How many times as long the exposures could be without it: the median over the pictures that it limits.
    pub factor: f64,
}

/// Makes a target for a camera.
type TargetOf = fn(&Camera, &Setting) -> Result<Target, CameraError>;

/// The targets in the order of [`ExposureTimes`], with their names.
const TARGETS: [(&str, TargetOf); 3] =
    [("ColorChecker", Target::chart), ("slanted edge", Target::edge), ("zone plate", Target::zone_plate)];

/// A picture before one camera.
struct Metered {
    /// The camera's own times in each light, s; `None` where they do not matter, or its rule finds no light.
    own: Option<Vec<f64>>,
    /// The longest times that the saturated share allows, s.
    longest: Vec<f64>,
}

/// The pictures of a comparison.
#[derive(Debug, Clone, Copy)]
pub struct ComparedPictures<'a> {
    /// The scenes.
    pub scenes: &'a [TestScene],
    /// Their mean luminances, cd/m².
    pub luminances_cd_m2: &'a [f64],
    /// Their illuminant.
    pub illuminant: &'a Illuminant,
    /// The scenes imaged on one of the cameras, in the same order; may be empty.
    pub setups: &'a [Setup],
}

impl ExposurePlan {
    /// The times for labelled cameras on scenes and on the targets of an evaluation. Scenes are imaged only if the times depend on
    /// them.
    ///
    /// # Errors
    /// When a setting is out of range, a stage fails, a camera saturates without light, or the work is stopped.
    pub fn new(
        policy: ExposurePolicy,
        cameras: &[(&str, &Camera)],
        pictures: ComparedPictures<'_>,
        resources: Resources<'_>,
    ) -> Result<Self, ExperimentError> {
        let own = Self { applied: ExposurePolicy::Own, times_s: Vec::new(), limiting: None };
        let cameras = distinct(cameras);
        let limits = match policy {
            ExposurePolicy::Own => return Ok(own),
            ExposurePolicy::Time(time_s) => {
                require(time_s > 0.0 && time_s <= 1e6, "the exposure time, s", time_s, "more than 0 to 1e6")?;
                return Ok(Self { applied: policy, ..own });
            }
            ExposurePolicy::Equal(limits) => limits,
            ExposurePolicy::AutoEqual(limits) if policy.meters(&cameras) => limits,
            ExposurePolicy::AutoEqual(_) => return Ok(own),
        };
        let EqualExposure { saturated_share: share, longest_s } = limits;
        require((0.0..1.0).contains(&share), "the saturated share", share, "0 to less than 1")?;
        require(longest_s > 0.0 && longest_s <= 1e6, "the longest time, s", longest_s, "more than 0 to 1e6")?;
        let depends_on_own = matches!(policy, ExposurePolicy::AutoEqual(_));
        let metered = metered(&cameras, pictures, (share, depends_on_own), resources)?;
        if depends_on_own && metered.iter().all(|p| have_same_times(p)) {
            return Ok(own);
        }
        let common = |cameras: &Vec<Metered>| -> Vec<f64> {
            let of_light = |light| cameras.iter().filter_map(move |m| m.longest.get(light).copied());
            (0..pictures.luminances_cd_m2.len())
                .map(|light| of_light(light).fold(longest_s, f64::min))
                .collect()
        };
        let times_s = metered.iter().map(common).collect();
        let limiting = limiting(&cameras, &metered, longest_s);
        Ok(Self { applied: ExposurePolicy::Equal(limits), times_s, limiting })
    }

    /// The policy that was applied: own times, one time, or equal times.
    #[must_use]
    pub fn applied(&self) -> ExposurePolicy {
        self.applied
    }

    /// The camera that makes equal times less than a quarter of what they could be without it, in most pictures.
    #[must_use]
    pub fn limiting(&self) -> Option<&LimitingCamera> {
        self.limiting.as_ref()
    }

    /// The error of scoring a camera at these times, with the camera that limits them where that is another one.
    #[must_use]
    pub fn explained(&self, label: &str, error: ExperimentError) -> ExperimentError {
        match (&self.limiting, error) {
            (Some(limiting), reason @ ExperimentError::Stage { .. }) if limiting.label != label => {
                let LimitingCamera { label, factor } = limiting.clone();
                ExperimentError::UnequalExposure { reason: Box::new(reason), limiting: label, factor }
            }
            (_, error) => error,
        }
    }

    /// The common time of a scene in a light of the settings, s; `None` for the own times of the cameras.
    #[must_use]
    pub fn scene_s(&self, scene: usize, light: usize) -> Option<f64> {
        match self.applied {
            ExposurePolicy::Time(time_s) => Some(time_s),
            _ => self.times_s.get(scene)?.get(light).copied(),
        }
    }

    /// The common times of the targets in a light of the settings; `None` for the own times of the cameras.
    #[must_use]
    pub fn targets(&self, light: usize) -> Option<ExposureTimes> {
        let first = self.times_s.len().saturating_sub(TARGETS.len());
        let [macbeth_s, edge_s, zone_plate_s] = [0, 1, 2].map(|target| self.scene_s(first + target, light));
        Some(ExposureTimes { macbeth_s: macbeth_s?, edge_s: edge_s?, zone_plate_s: zone_plate_s? })
    }
}

/// Each camera once.
fn distinct<'a>(cameras: &[(&'a str, &'a Camera)]) -> Vec<(&'a str, &'a Camera)> {
    let mut distinct: Vec<(&str, &Camera)> = Vec::new();
    for &(label, camera) in cameras {
        if !distinct.iter().any(|(_, known)| std::ptr::eq(*known, camera)) {
            distinct.push((label, camera));
        }
    }
    distinct
}

/// The camera that limits the times of most pictures by a notable factor. `metered` has the times of each camera for each picture.
fn limiting(cameras: &[(&str, &Camera)], metered: &[Vec<Metered>], longest_s: f64) -> Option<LimitingCamera> {
    let mut pictures = 0;
    let mut factors: Vec<Vec<f64>> = vec![Vec::new(); cameras.len()];
    for picture in metered {
        let lights = picture.first().map_or(0, |m| m.longest.len());
        for light in 0..lights {
            pictures += 1;
            let time = |m: &Metered| m.longest.get(light).map_or(longest_s, |t| t.min(longest_s));
            let mut times: Vec<(f64, usize)> = picture.iter().map(time).zip(0..).collect();
            times.sort_by(|a, b| a.0.total_cmp(&b.0));
            if let [(least, camera), (next, _), ..] = times[..]
                && let Some(of_camera) = factors.get_mut(camera).filter(|_| next > NOTABLE_FACTOR * least)
            {
                of_camera.push(next / least);
            }
        }
    }
    let (of_camera, (label, _)) = factors.iter_mut().zip(cameras).max_by_key(|(f, _)| f.len())?;
    of_camera.sort_by(f64::total_cmp);
    let factor = *of_camera.get(of_camera.len() / 2)?;
    (2 * of_camera.len() > pictures).then(|| LimitingCamera { label: (*label).to_owned(), factor })
}

/// For each scene, then for each target, the times of each camera.
fn metered(
    cameras: &[(&str, &Camera)],
    pictures: ComparedPictures<'_>,
    of: (f64, bool),
    resources: Resources<'_>,
) -> Result<Vec<Vec<Metered>>, ExperimentError> {
    let (lights, mut all) = (pictures.luminances_cd_m2, Vec::new());
    for (i, scene) in pictures.scenes.iter().enumerate() {
        let (mut metered, mut last) = (Vec::new(), pictures.setups.get(i).cloned());
        for &(label, camera) in cameras {
            ensure_running(resources.progress)?;
            let context = || format!("{label}, {}", scene.name());
            let setup =
                scene.before_sharing(camera, pictures.illuminant, last.as_ref()).in_context(context)?;
            metered.push(Metered::new(&setup.camera, &setup.image, of, lights).in_context(context)?);
            last = Some(setup);
        }
        all.push(metered);
    }
    let Some(&luminance_cd_m2) = lights.first() else { return Ok(all) };
    let illuminant = pictures.illuminant.clone();
    let targets = EvaluationSettings { luminance_cd_m2, illuminant, ..EvaluationSettings::default() };
    let factors: Vec<f64> = lights.iter().map(|cd_m2| cd_m2 / luminance_cd_m2).collect();
    for (name, target_of) in TARGETS {
        let mut metered = Vec::new();
        for &(label, camera) in cameras {
            ensure_running(resources.progress)?;
            let on_target = || -> Result<Metered, CameraError> {
                let setting = targets.setting(camera.grid());
                let target = target_of(camera, &setting)?;
                let image = resources.store.optical_image(&target.key, &|| target.image())?;
                Metered::new(&target.camera, &image, of, &factors)
            };
            metered.push(on_target().in_context(|| format!("{label}, {name}"))?);
        }
        all.push(metered);
    }
    Ok(all)
}

impl Metered {
    /// The times of a camera for an optical image at multiples of its light, with a saturated share, and with its own times if they
    /// matter.
    fn new(
        camera: &Camera,
        image: &OpticalImage,
        (share, depends_on_own): (f64, bool),
        factors: &[f64],
    ) -> Result<Self, CameraError> {
        let or_dark = |times: Result<Vec<f64>, CameraError>| match times {
            Err(CameraError::Sensor(SensorError::NoLight)) => Ok(None),
            times => times.map(Some),
        };
        let longest = or_dark(camera.times_by(AutoExposure::SaturatedShare { share }, image, factors))?;
        Ok(Self {
            own: if depends_on_own { or_dark(camera.times_in_light(image, factors))? } else { None },
            // A picture without light never saturates.
            longest: longest.unwrap_or_else(|| vec![f64::INFINITY; factors.len()]),
        })
    }
}

/// Whether the cameras have the same own times.
fn have_same_times(metered: &[Metered]) -> bool {
    let Some((first, rest)) = metered.split_first() else { return true };
    let same = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME_TIME * a.abs();
    let all_same = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).all(same);
    rest.iter().all(|m| first.own.as_ref().zip(m.own.as_ref()).is_some_and(all_same))
}
