//! The light gain: how much more light one camera needs for the same image quality as another.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt;

use serde::Serialize;

use super::chart_in_light::ChartInLight;
use super::compare::IntegratedScene;
use super::grey_noise::COMPARED_NOISE_CAPTURES;
use super::{Camera, CameraError, IspFor, PICTURE_METRICS, ScoreSettings, TestScene};
use crate::isp::Isp;
use crate::metrics::{Better, MetricError, metric_info};
use crate::numeric::bootstrap::{Resamples, mean};
use crate::numeric::crossing::{Differences, Places, narrowed};
use crate::scene::Setting;
use crate::sensor::Exposure;
use crate::spectrum::Illuminant;

/// Range of the search in both directions, stops.
const REACH_STOPS: i32 = 4;
/// The light of the search changes in multiples of this part of a stop, within which the crossing is interpolated.
pub(crate) const STEP_STOPS: f64 = 0.125;

/// How much more light a camera needs to equal another, in stops (powers of two). Negative values mean less light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LightGain {
    /// The gain.
    Stops(f64),
    /// The gain is larger than the search range; the limit is given.
    MoreThan(f64),
    /// The gain is below the search range; the limit (a negative number) is given.
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

/// The light, in stops, at which `quality`, a function of light, equals `target`.
///
/// The search changes the light in steps of one stop, at most four, until quality crosses the target. It narrows that stop
/// by halving to an eighth, in which it interpolates linearly. `quality` is evaluated at most 8 times, always at
/// multiples of an eighth. It should improve with light; of several crossings, it finds the one nearest to equal light.
///
/// # Errors
/// When `quality` fails or is NaN, or the metric has no direction of improvement.
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
                let reason = "the metric has no direction of improvement";
                return Err(MetricError::Undefined { quantity, reason }.into());
            }
        };
        match lead {
            // The difference of equal infinities would be NaN.
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
        [near, far] = narrowed(near, far, STEP_STOPS, lead)?;
        let share = near.1 / (near.1 - far.1);
        let share = if share.is_finite() { share } else { 0.5 };
        return Ok(LightGain::Stops(near.0 + share * (far.0 - near.0)));
    }
    let reach = f64::from(REACH_STOPS);
    Ok(if behind { LightGain::MoreThan(reach) } else { LightGain::LessThan(-reach) })
}

/// A camera and its processing.
#[derive(Clone, Copy)]
pub struct CameraAndIsp<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Its processing for an illuminant.
    pub isp: IspFor<'a>,
}

/// Settings of a light gain.
#[derive(Debug, Clone, PartialEq)]
pub struct LightGainSettings {
    /// Mean luminance of the scenes for the reference camera, cd/m².
    pub luminance_cd_m2: f64,
    /// The illuminant.
    pub illuminant: Illuminant,
    /// Seed of the noise, the first of several. The seeds are the same at every luminance, so that scores change smoothly with light.
    pub seed: u64,
    /// The number of seeds of the pictures of scenes, at least 1.
    pub seed_count: u64,
    /// The scenes for the scores of whole pictures. Each is captured some twenty times for each seed.
    pub scenes: Vec<TestScene>,
    /// The exposure time of each scene, s; that of the camera's description where it is absent.
    pub times_s: Vec<Option<f64>>,
    /// The exposure time of the ColorChecker, s; `None` for that of the camera's description.
    pub chart_s: Option<f64>,
    /// Viewing conditions of the scores.
    pub score: ScoreSettings,
}

impl Default for LightGainSettings {
    /// 1 cd/m² of D65, the scenes of [`TestScene::charts`], and the cameras' own exposure times.
    fn default() -> Self {
        Self {
            luminance_cd_m2: 1.0,
            illuminant: Illuminant::D65,
            seed: 1,
            seed_count: 1,
            scenes: TestScene::charts(),
            times_s: Vec::new(),
            chart_s: None,
            score: ScoreSettings::default(),
        }
    }
}

/// The 95 % interval of a light gain, by inversion of the test: the gains at which the paired differences of the scores do not
/// contradict equal quality ([`crate::numeric::bootstrap`]).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GainInterval {
    /// The lower end.
    pub low: LightGain,
    /// The upper end.
    pub high: LightGain,
}

impl fmt::Display for GainInterval {
    /// The ends in stops, such as `[+0.38, +0.46]`, or `[+0.38, > +4]` for an end beyond the search range.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let end = |gain| match gain {
            LightGain::Stops(v) => format!("{v:+.2}"),
            LightGain::MoreThan(v) => format!("> {v:+}"),
            LightGain::LessThan(v) => format!("< {v:+}"),
        };
        write!(f, "[{}, {}]", end(self.low), end(self.high))
    }
}

/// The light gain by one metric.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MetricGain {
    /// Its name in the catalogue of metrics.
    pub metric: &'static str,
    /// The light gain.
    pub gain: LightGain,
    /// Its interval. For scores of pictures it covers scenes and seeds, for visual SNR and luminance noise captures of the chart
    /// alone. `None` for a single picture, and where a score is not finite.
    pub interval: Option<GainInterval>,
    /// Further stops, among the light that was tried, at which the scores are equal; empty for a score that rises or falls steadily
    /// with light.
    pub also_at_stops: Vec<f64>,
    /// The score of the camera at equal light.
    pub own: f64,
    /// The score of the reference camera.
    pub target: f64,
}

/// The light gain by every metric.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightGains {
    /// Mean luminance for the reference camera, cd/m².
    pub luminance_cd_m2: f64,
    /// The gain by each metric.
    pub metrics: Vec<MetricGain>,
    /// Number of luminances at which the camera was evaluated.
    pub tried: usize,
}

/// The metrics of a light gain. Those of whole pictures are means over the scenes and seeds. Of the grey patches of the ColorChecker,
/// luminance noise is the mean and visual SNR the median.
const METRICS: [&str; 5] =
    ["cpsnr_db", "pixel_delta_e_2000_mean", "scielab_mean", "visual_snr", "luminance_noise_percent"];

/// How much more light camera `a` needs to equal camera `b`.
///
/// Every picture is scored relative to its own exposure and light, with the white of its reference. The exposure times are
/// those for the luminance of the settings and stay fixed when the light changes, because automatic exposure would undo the
/// change. Metrics share their captures: each needs up to 8 luminances, all together some 10 to 20, and each luminance a
/// capture, a rendering and a score of every scene.
///
/// # Errors
/// When a stage fails or a scene is dark.
pub fn light_gains(
    a: CameraAndIsp<'_>,
    b: CameraAndIsp<'_>,
    settings: &LightGainSettings,
) -> Result<LightGains, CameraError> {
    let reference = CameraUnderTest::new(b, settings, None)?;
    let targets = reference.qualities(0.0, settings)?;
    let camera = CameraUnderTest::new(a, settings, Some(&reference))?;
    drop(reference);
    // The search evaluates multiples of an eighth of a stop only.
    let eighths = |stops: f64| (stops / STEP_STOPS).round() as i64;
    let mut known: BTreeMap<i64, Figures> = BTreeMap::new();
    let mut figures = |stops: f64, metric: usize| -> Result<Vec<f64>, CameraError> {
        let found = match known.entry(eighths(stops)) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => entry.insert(camera.qualities(stops, settings)?),
        };
        Ok(found[metric].clone())
    };
    let (scenes, seeds) = (settings.scenes.len(), settings.seed_count.max(1) as usize);
    let pictures = (scenes * seeds > 1).then(|| Resamples::new(scenes, seeds, settings.seed));
    let captures = Resamples::new(1, COMPARED_NOISE_CAPTURES as usize, settings.seed);
    let mut metrics = Vec::with_capacity(METRICS.len());
    for (i, (&metric, target)) in METRICS.iter().zip(&targets).enumerate() {
        let better = metric_info(metric)?.better;
        let mut tried = Vec::new();
        let gain = light_gain(better, mean(target), |stops| {
            tried.push(stops);
            Ok(mean(&figures(stops, i)?))
        })?;
        let sign = if better == Better::Higher { 1.0 } else { -1.0 };
        let leads = |stops| -> Result<Vec<f64>, CameraError> {
            Ok(figures(stops, i)?.iter().zip(target).map(|(own, target)| sign * (own - target)).collect())
        };
        let resamples = if i < PICTURE_METRICS.len() { pictures.as_ref() } else { Some(&captures) };
        let interval = resamples.map_or(Ok(None), |r| gain_interval(gain, &tried, r, leads))?;
        let own = mean(&figures(0.0, i)?);
        metrics.push(MetricGain {
            metric,
            gain,
            interval,
            also_at_stops: Vec::new(),
            own,
            target: mean(target),
        });
    }
    // The light that other metrics needed shows further crossings.
    for (i, (found, target)) in metrics.iter_mut().zip(&targets).enumerate() {
        let lead = |(eighths, figures): (&i64, &Figures)| {
            (*eighths as f64 * STEP_STOPS, mean(&figures[i]) - mean(target))
        };
        found.also_at_stops = further_crossings(found.gain, &known.iter().map(lead).collect::<Vec<_>>());
    }
    Ok(LightGains { luminance_cd_m2: settings.luminance_cd_m2, metrics, tried: known.len() })
}

/// The places, stops, at which leads change their sign, but for that of the gain. `leads` are those at places in ascending order,
/// between which they are interpolated linearly.
fn further_crossings(gain: LightGain, leads: &[(f64, f64)]) -> Vec<f64> {
    let LightGain::Stops(gain) = gain else { return Vec::new() };
    let pairs = leads.windows(2).filter_map(|pair| match pair {
        [low, high] if (low.1 < 0.0) != (high.1 < 0.0) => Some((low, high)),
        _ => None,
    });
    let crossings = pairs.map(|(low, high)| low.0 + low.1 / (low.1 - high.1) * (high.0 - low.0));
    crossings.filter(|stops| (stops - gain).abs() > STEP_STOPS).collect()
}

/// The interval of a light gain. `leads` are the paired differences from the reference at a number of stops, positive where the camera
/// is better. From the gain outwards, they are evaluated in whole stops until they differ from 0 with certainty, at most to the ends of
/// the search range. Between these places and those that the search has `tried`, they are interpolated linearly. `None` where the
/// differences have no interval.
fn gain_interval(
    gain: LightGain,
    tried: &[f64],
    resamples: &Resamples,
    mut leads: impl FnMut(f64) -> Result<Vec<f64>, CameraError>,
) -> Result<Option<GainInterval>, CameraError> {
    let (LightGain::Stops(stops) | LightGain::MoreThan(stops) | LightGain::LessThan(stops)) = gain;
    let reach = f64::from(REACH_STOPS);
    let mut end = |mut stops: f64, step: f64| -> Result<Option<f64>, CameraError> {
        loop {
            let Some(interval) = resamples.interval(&leads(stops)?) else { return Ok(None) };
            let is_certain = if step < 0.0 { interval.high < 0.0 } else { interval.low > 0.0 };
            if is_certain || stops == step * reach {
                return Ok(Some(stops));
            }
            stops += step;
        }
    };
    let (Some(first), Some(last)) = (end(stops.floor(), -1.0)?, end(stops.ceil(), 1.0)?) else {
        return Ok(None);
    };
    let whole = (0..=2 * REACH_STOPS).map(|i| f64::from(i - REACH_STOPS));
    let mut places: Vec<f64> = whole.chain(tried.iter().copied()).collect();
    places.retain(|stops| (first..=last).contains(stops));
    places.sort_unstable_by(f64::total_cmp);
    places.dedup();
    let at = places.into_iter().map(|stops| Ok((stops, leads(stops)?)));
    let differences = Differences::new(at.collect::<Result<Vec<_>, CameraError>>()?);
    let found = differences.interval(resamples).map(|Places { low, high }| GainInterval {
        low: low.map_or(LightGain::LessThan(-reach), LightGain::Stops),
        high: high.map_or(LightGain::MoreThan(reach), LightGain::Stops),
    });
    // Without a place at which the quality may be equal, the gain is out of reach with certainty.
    Ok(Some(found.unwrap_or(GainInterval { low: gain, high: gain })))
}

/// The figures of each of [`METRICS`]: of all scenes and seeds, scene by scene, or of the captures of the chart.
type Figures = [Vec<f64>; METRICS.len()];

/// A camera with its processing, and the scenes and the chart imaged on it.
struct CameraUnderTest<'a> {
    scenes: Vec<(IntegratedScene, Exposure, Box<dyn Isp + 'a>)>,
    chart: ChartInLight<'a>,
}

impl<'a> CameraUnderTest<'a> {
    /// Optical images of `other` are reused where possible.
    fn new(
        CameraAndIsp { camera, isp }: CameraAndIsp<'a>,
        settings: &LightGainSettings,
        other: Option<&CameraUnderTest<'_>>,
    ) -> Result<Self, CameraError> {
        let setting = Setting {
            luminance_cd_m2: settings.luminance_cd_m2,
            illuminant: settings.illuminant.clone(),
            grid: camera.grid(),
            ..Setting::default()
        };
        let other_chart = other.map(|o| &o.chart);
        let scene = |(i, scene): (usize, &TestScene)| -> Result<_, CameraError> {
            let lender = other.and_then(|o| o.scenes.get(i)).map(|s| s.0.setup());
            let setup = scene.before_sharing(camera, &settings.illuminant, lender)?;
            let scene = IntegratedScene::new(setup)?;
            let exposure =
                scene.exposure(settings.luminance_cd_m2, settings.times_s.get(i).copied().flatten())?;
            let isp = isp(&scene.light(settings.luminance_cd_m2)?)?;
            Ok((scene, exposure, isp))
        };
        Ok(Self {
            scenes: settings.scenes.iter().enumerate().map(scene).collect::<Result<_, _>>()?,
            chart: ChartInLight::new((camera, isp), &setting, settings.chart_s, other_chart)?,
        })
    }

    /// The figures with the light changed by `stops`.
    fn qualities(&self, stops: f64, settings: &LightGainSettings) -> Result<Figures, CameraError> {
        let seeds = settings.seed..settings.seed.saturating_add(settings.seed_count.max(1));
        let mut all = Figures::default();
        for (scene, exposure, isp) in &self.scenes {
            let at = (settings.luminance_cd_m2 * stops.exp2(), exposure);
            for of_seed in scene.compare_seeds(at, &**isp, seeds.clone(), &settings.score)?.figures {
                for (values, figure) in all.iter_mut().zip(of_seed) {
                    values.push(figure);
                }
            }
        }
        [all[PICTURE_METRICS.len()], all[PICTURE_METRICS.len() + 1]] =
            self.chart.grey_noise(stops, settings.seed)?;
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The light gain of a quality against a target, and the number of evaluations.
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

    /// Six scenes whose leads are 3 dB per stop, less the gain, with ±0.1 dB between them: the interval is that of the mean difference.
    fn interval(gain_stops: f64) -> GainInterval {
        let resamples = Resamples::new(6, 1, 1);
        let of = |stops: f64| -> Vec<f64> {
            (0..6u32).map(|i| 3.0 * (stops - gain_stops) + 0.1 * (f64::from(i) - 2.5)).collect()
        };
        let mut tried = Vec::new();
        let gain = light_gain(Better::Higher, 0.0, |stops| {
            tried.push(stops);
            Ok(mean(&of(stops)))
        });
        gain_interval(gain.unwrap(), &tried, &resamples, |stops| Ok(of(stops))).unwrap().unwrap()
    }

    #[test]
    fn the_interval_of_a_linear_quality_is_that_of_its_mean_difference() {
        let mean_interval =
            Resamples::new(6, 1, 1).interval(&[-0.25, -0.15, -0.05, 0.05, 0.15, 0.25]).unwrap();
        for stops in [-2.3, -0.01, 0.4, 3.1] {
            let GainInterval { low: LightGain::Stops(low), high: LightGain::Stops(high) } = interval(stops)
            else {
                panic!("{stops}")
            };
            let expected = [stops - mean_interval.high / 3.0, stops - mean_interval.low / 3.0];
            assert!((low - expected[0]).abs() < 1e-6 && (high - expected[1]).abs() < 1e-6, "{low} to {high}");
        }
    }

    /// A score that rises, falls and rises again equals the target three times.
    #[test]
    fn further_crossings_are_found() {
        let leads: Vec<(f64, f64)> = (-32..=32)
            .map(|i| f64::from(i) * STEP_STOPS)
            .map(|s| (s, (s + 1.0) * (s - 0.4) * (s - 2.0)))
            .collect();
        let found = further_crossings(LightGain::Stops(0.4), &leads);
        assert!(
            found.len() == 2 && (found[0] + 1.0).abs() < 0.02 && (found[1] - 2.0).abs() < 0.02,
            "{found:?}"
        );
        let steady: Vec<(f64, f64)> = leads.iter().map(|(s, _)| (*s, s - 0.4)).collect();
        assert!(further_crossings(LightGain::Stops(0.4), &steady).is_empty());
    }

    /// An end beyond the search range is bounded, and so is a gain that lies beyond it with certainty.
    #[test]
    fn ends_out_of_reach_are_bounds() {
        let near = interval(3.99);
        assert!(
            matches!(near, GainInterval { low: LightGain::Stops(_), high: LightGain::MoreThan(4.0) }),
            "{near}"
        );
        assert!(near.to_string().ends_with(", > +4]"), "{near}");
        assert_eq!(interval(6.0).to_string(), "[> +4, > +4]");
        assert_eq!(interval(-6.0).to_string(), "[< -4, < -4]");
    }

    #[test]
    fn every_metric_has_a_direction() {
        for name in METRICS {
            let better = metric_info(name).unwrap().better;
            assert!(matches!(better, Better::Higher | Better::Lower), "{name}");
        }
    }
}
