//! The light gain: how much more light one camera needs to make as good a picture as another.

use std::collections::HashMap;
use std::fmt;

use serde::Serialize;

use super::chart::{self, PATCH_SAMPLES};
use super::{Camera, CameraError, IspFor, ScoreSettings, Setup, compare_on};
use crate::isp::Isp;
use crate::metrics::{Better, CATALOG, MetricError};
use crate::scene::{Setting, macbeth};
use crate::sensor::NoiseMode;
use crate::spectrum::Illuminant;

/// How far light is looked for on either side, stops.
const REACH_STOPS: i32 = 4;
/// Halvings of the stop in which the two are equal; what is left is interpolated.
const HALVINGS: u32 = 3;

/// Scenes that whole pictures are scored on by default: those of [`test_scenes`](super::test_scenes) that look like photographs
/// and like surfaces, smaller, since each is taken some twenty times. Another seed moves the gain by a
/// hundredth of a stop, by S-CIELAB by a few.
const SCENES: [&str; 2] = ["dead-leaves?rows=384&cols=512&least=2&largest=100&seed=1001", "macbeth?patch=64"];

/// Captures of the ColorChecker that noise is averaged over: its patches are small, and one capture leaves the gain uncertain
/// by a tenth of a stop, four by half of that.
const CHART_CAPTURES: u64 = 4;

/// How much more light a camera needs to equal another, in stops: powers of two. Below 0 it needs less.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LightGain {
    /// So much.
    Stops(f64),
    /// Even so much more is not enough.
    MoreThan(f64),
    /// Even in so much less light (a negative number) it is better.
    LessThan(f64),
}

impl fmt::Display for LightGain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stops(v) => write!(f, "{v:+.2} stops"),
            Self::MoreThan(v) => write!(f, "more than {v:+} stops"),
            Self::LessThan(v) => write!(f, "less than {v:+} stops"),
        }
    }
}

/// How much more light it takes until `quality`, a function of light in stops, is as good as `target`.
///
/// Light is added (or taken) stop by stop, at most four, until the two change places; that stop is halved three times, and
/// within the eighth of a stop the quality is taken to be linear. So `quality` is asked at most 8 times, always at whole
/// eighths. It should get better with light on the way; the crossing that is nearest to equal light is found.
///
/// # Errors
/// When `quality` fails, is NaN, or `better` says that there is no better.
pub fn light_gain(
    better: Better,
    target: f64,
    mut quality: impl FnMut(f64) -> Result<f64, CameraError>,
) -> Result<LightGain, CameraError> {
    let quantity = "the light gain";
    let mut lead = |stops: f64| -> Result<f64, CameraError> {
        let own = quality(stops)?;
        let lead = match better {
            Better::Higher => own - target,
            Better::Lower => target - own,
            Better::Neither => {
                let reason = "the metric is neither good nor bad";
                return Err(MetricError::Undefined { quantity, reason }.into());
            }
        };
        match lead {
            // Infinity less infinity.
            _ if own == target => Ok(0.0),
            v if v.is_nan() => {
                Err(MetricError::Undefined { quantity, reason: "the metric has no value" }.into())
            }
            v => Ok(v),
        }
    };
    let mut near = (0.0, lead(0.0)?);
    if near.1 == 0.0 {
        return Ok(LightGain::Stops(0.0));
    }
    let behind = near.1 < 0.0;
    for whole in 1..=REACH_STOPS {
        let stops = f64::from(if behind { whole } else { -whole });
        let mut far = (stops, lead(stops)?);
        if (far.1 < 0.0) == behind {
            near = far;
            continue;
        }
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(near.0, far.0);
            let there = (middle, lead(middle)?);
            *(if (there.1 < 0.0) == behind { &mut near } else { &mut far }) = there;
        }
        let share = near.1 / (near.1 - far.1);
        let share = if share.is_finite() { share } else { 0.5 };
        return Ok(LightGain::Stops(near.0 + share * (far.0 - near.0)));
    }
    let reach = f64::from(REACH_STOPS);
    Ok(if behind { LightGain::MoreThan(reach) } else { LightGain::LessThan(-reach) })
}

/// A camera with its processing.
#[derive(Clone, Copy)]
pub struct Contender<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Its processing for a light.
    pub isp: IspFor<'a>,
}

/// Where the light gain is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct LightGainSettings {
    /// Mean luminance of the scenes for the camera that is to be equalled, cd/m².
    pub luminance_cd_m2: f64,
    /// The light.
    pub illuminant: Illuminant,
    /// Seed of the noise, the same in every light, so that scores change smoothly with light.
    pub seed: u64,
    /// Built-in scenes for the scores of whole pictures, as [`Setup::of_test_scene`] takes them.
    pub scenes: Vec<String>,
    /// How pictures are looked at.
    pub score: ScoreSettings,
}

impl Default for LightGainSettings {
    /// At 1 cd/m² of D65, on dead leaves and the ColorChecker.
    fn default() -> Self {
        Self {
            luminance_cd_m2: 1.0,
            illuminant: Illuminant::D65,
            seed: 1,
            scenes: SCENES.map(str::to_owned).to_vec(),
            score: ScoreSettings::default(),
        }
    }
}

/// The light gain by one metric.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MetricGain {
    /// Its name in the list of metrics.
    pub metric: &'static str,
    /// The light gain.
    pub gain: LightGain,
    /// What the camera scores in equal light.
    pub own: f64,
    /// What the other scores, and is to be equalled.
    pub target: f64,
}

/// The light gain by every metric.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightGains {
    /// Mean luminance for the camera that is to be equalled, cd/m².
    pub luminance_cd_m2: f64,
    /// By metric.
    pub metrics: Vec<MetricGain>,
    /// Amounts of light in which the camera was tried.
    pub tried: usize,
}

/// The metrics by which cameras are compared: of whole pictures, the mean over the scenes; of noise, over the grey patches of
/// a ColorChecker, the mean of the one and the median of the other.
const METRICS: [&str; 5] =
    ["cpsnr_db", "pixel_delta_e_2000_mean", "scielab_mean", "visual_snr", "luminance_noise_percent"];

/// How much more light camera `a` needs to equal camera `b`.
///
/// Every picture is scored relative to its own exposure and light: white is the reference's. Exposure times are those that the
/// cameras choose at the luminance of the settings, and stay when the light changes: otherwise an automatic exposure
/// would undo the change. Metrics share their captures: most take 8 amounts of light each, all together some 10 to 20,
/// each a capture, a rendering and a score of every scene.
///
/// # Errors
/// When a stage refuses, or a scene is dark.
pub fn light_gains(
    a: Contender<'_>,
    b: Contender<'_>,
    settings: &LightGainSettings,
) -> Result<LightGains, CameraError> {
    let rig_b = Rig::new(b, settings, None)?;
    let targets = rig_b.qualities(0.0, settings)?;
    let rig_a = Rig::new(a, settings, Some(&rig_b))?;
    drop(rig_b);
    let mut known: HashMap<i64, [f64; METRICS.len()]> = HashMap::new();
    let mut qualities = |stops: f64| -> Result<[f64; METRICS.len()], CameraError> {
        // Places are whole eighths of a stop.
        let place = (stops * f64::from(1u32 << HALVINGS)).round() as i64;
        match known.get(&place) {
            Some(&q) => Ok(q),
            None => Ok(*known.entry(place).or_insert(rig_a.qualities(stops, settings)?)),
        }
    };
    let mut metrics = Vec::with_capacity(METRICS.len());
    for (i, (&metric, &target)) in METRICS.iter().zip(&targets).enumerate() {
        let better = CATALOG.iter().find(|m| m.name == metric).map_or(Better::Neither, |m| m.better);
        let gain = light_gain(better, target, |stops| Ok(qualities(stops)?[i]))?;
        metrics.push(MetricGain { metric, gain, own: qualities(0.0)?[i], target });
    }
    Ok(LightGains { luminance_cd_m2: settings.luminance_cd_m2, metrics, tried: known.len() })
}

/// A contender before all scenes.
struct Rig<'a> {
    scenes: Vec<(Setup, Box<dyn Isp + 'a>)>,
    chart: (Setup, Box<dyn Isp + 'a>),
}

impl<'a> Rig<'a> {
    /// `other` may lend its optical images.
    fn new(
        Contender { camera, isp }: Contender<'a>,
        settings: &LightGainSettings,
        other: Option<&Rig<'_>>,
    ) -> Result<Self, CameraError> {
        let setting = Setting {
            luminance_cd_m2: settings.luminance_cd_m2,
            illuminant: settings.illuminant.clone(),
            grid: camera.grid(),
            ..Setting::default()
        };
        let lent = |setup: Option<&Setup>| setup.map_or(Ok(None), |s| s.before(camera));
        let with_isp = |setup: Setup| {
            let isp = isp(&setup.light)?;
            Ok::<_, CameraError>((setup, isp))
        };
        let scene = |(i, spec): (usize, &String)| {
            let setup = match lent(other.and_then(|o| o.scenes.get(i)).map(|s| &s.0))? {
                Some(setup) => setup,
                None => Setup::of_test_scene(camera, spec, &setting)?,
            };
            with_isp(setup)
        };
        let chart = match lent(other.map(|o| &o.chart.0))? {
            Some(setup) => setup,
            None => {
                let scene = macbeth::chart(PATCH_SAMPLES, &setting)?;
                Setup::with_size(camera, scene, chart::SIZE_PX)?
            }
        };
        Ok(Self {
            scenes: settings.scenes.iter().enumerate().map(scene).collect::<Result<_, _>>()?,
            chart: with_isp(chart)?,
        })
    }

    /// The scores of [`METRICS`] in more light, by so many stops.
    fn qualities(
        &self,
        stops: f64,
        settings: &LightGainSettings,
    ) -> Result<[f64; METRICS.len()], CameraError> {
        let mut means = [0.0; 3];
        for (setup, isp) in &self.scenes {
            let s =
                compare_on(&setup.in_light(stops.exp2())?, &**isp, settings.seed, &settings.score)?.scores;
            for (mean, v) in means.iter_mut().zip([s.cpsnr_db, s.pixel_delta_e_2000_mean, s.scielab_mean]) {
                *mean += v / self.scenes.len() as f64;
            }
        }
        let [cpsnr, delta_e, scielab] = means;
        let [visual, luminance] = self.grey_noise(stops, settings.seed)?;
        Ok([cpsnr, delta_e, scielab, visual, luminance])
    }

    /// Visual SNR and luminance noise of the grey series, the mean over captures. In the deep dark, where a patch has no
    /// signal, the worst there is.
    fn grey_noise(&self, stops: f64, seed: u64) -> Result<[f64; 2], CameraError> {
        let (setup, isp) = &self.chart;
        let Setup { camera, image, light, exposure } = &setup.in_light(stops.exp2())?;
        let (mut visual, mut luminance) = (0.0, 0.0);
        for capture in 0..CHART_CAPTURES {
            let seed = seed.wrapping_add(capture);
            let picture = isp.render(&camera.sensor.capture(image, exposure, NoiseMode::All, seed)?)?;
            let noise = match chart::noise(&picture, light) {
                Ok(noise) => noise,
                Err(CameraError::Metric(MetricError::Undefined { .. })) => return Ok([0.0, f64::INFINITY]),
                Err(e) => return Err(e),
            };
            let percent = &noise.luminance_noise_percent;
            luminance += percent.iter().sum::<f64>() / percent.len().max(1) as f64;
            visual += super::GreyScores::from(noise.visual_snr).median;
        }
        Ok([visual, luminance].map(|sum| sum / CHART_CAPTURES as f64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The light gain of a quality against a target, and how often it was asked.
    fn gain(better: Better, target: f64, quality: impl Fn(f64) -> f64) -> (LightGain, usize) {
        let mut asked = 0;
        let gain = light_gain(better, target, |stops| {
            assert_eq!((stops * 8.0).fract(), 0.0, "{stops} is no whole eighth");
            asked += 1;
            Ok(quality(stops))
        });
        (gain.unwrap(), asked)
    }

    /// Quantities that grow or fall with light as those of photon noise do.
    #[test]
    fn the_crossing_of_monotone_functions_is_found() {
        for expected in [-3.9, -1.8, -0.3, 0.01, 1.0, 1.77, 3.95] {
            let cases = [
                gain(Better::Higher, 30.0, |s| 30.0 + 3.01 * (s - expected)),
                gain(Better::Higher, 5.0, |s| 5.0 * (0.5 * (s - expected)).exp2()),
                gain(Better::Lower, 12.0, |s| 12.0 * (-0.5 * (s - expected)).exp2()),
            ];
            for (got, asked) in cases {
                let LightGain::Stops(stops) = got else { panic!("{got:?} is not {expected}") };
                // A square root over an eighth of a stop is straight to 1e-3 of it.
                assert!((stops - expected).abs() < 1e-3, "{stops} is not {expected}");
                assert!(asked <= 8, "asked {asked} times");
            }
        }
    }

    #[test]
    fn out_of_reach_is_said() {
        assert_eq!(gain(Better::Higher, 1.0, |s| -10.0 + s), (LightGain::MoreThan(4.0), 5));
        assert_eq!(gain(Better::Higher, 1.0, |s| 10.0 + s), (LightGain::LessThan(-4.0), 5));
        assert_eq!(gain(Better::Lower, 1.0, |s| 10.0 - s), (LightGain::MoreThan(4.0), 5));
    }

    #[test]
    fn equals_gain_nothing_and_what_has_no_value_is_refused() {
        assert_eq!(gain(Better::Higher, 1.0, |_| 1.0), (LightGain::Stops(0.0), 1));
        assert_eq!(gain(Better::Lower, f64::INFINITY, |_| f64::INFINITY).0, LightGain::Stops(0.0));
        // A jump from nothing to all is somewhere in the eighth.
        let (jump, _) = gain(Better::Higher, 1.0, |s| if s < 0.3 { 0.0 } else { f64::INFINITY });
        assert!(matches!(jump, LightGain::Stops(s) if (0.25..=0.375).contains(&s)), "{jump}");
        assert!(light_gain(Better::Higher, 1.0, |_| Ok(f64::NAN)).is_err());
        assert!(light_gain(Better::Neither, 1.0, |_| Ok(1.0)).is_err());
    }

    #[test]
    fn every_metric_has_a_direction() {
        for name in METRICS {
            let found = CATALOG.iter().find(|m| m.name == name).map(|m| m.better);
            assert!(matches!(found, Some(Better::Higher | Better::Lower)), "{name}");
        }
    }
}
