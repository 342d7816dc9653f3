//! Exposure times of comparisons.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use smalti::camera::description::AutoExposureName;
use smalti::camera::{Camera, CameraDescription, CameraError, ExposureFault, ScoreSettings, TestScene};
use smalti::experiment::{
    ComparedPictures, ComparisonSettings, Contender, EqualExposure, ExperimentError, ExposurePlan,
    ExposurePolicy, Resources, compare,
};
use smalti::spectrum::Illuminant;

use crate::common::coarse_grid;

const LEAVES: &str = "dead-leaves?rows=96&cols=128&least=2&largest=30&seed=1001";
const CHART: &str = "macbeth?patch=16";

fn camera(change: impl FnOnce(&mut CameraDescription)) -> Camera {
    let mut d = CameraDescription::default();
    (d.sensor.rows, d.sensor.cols) = (48, 64);
    change(&mut d);
    Camera::new(d, coarse_grid()).unwrap()
}

fn settings(exposure: ExposurePolicy) -> ComparisonSettings {
    ComparisonSettings {
        luminances_cd_m2: vec![5.0, 500.0],
        illuminant: Illuminant::D65,
        scenes: [LEAVES, CHART].map(TestScene::built_in).into(),
        seed_count: 1,
        seed: 1,
        score: ScoreSettings::default(),
        exposure,
    }
}

/// A camera that meters its highlights, and one of another lens and filters that meters the mean.
fn pair() -> [Camera; 2] {
    let mean = camera(|d| {
        d.exposure.auto = Some(AutoExposureName::Mean);
        d.optics.f_number = 1.8;
        d.sensor.cfa.pattern = smalti::camera::description::PatternDescription::Name("rgbw".into());
    });
    [camera(|d| d.exposure.auto = Some(AutoExposureName::Luminance)), mean]
}

fn plan(cameras: &[Camera], policy: ExposurePolicy) -> Result<ExposurePlan, ExperimentError> {
    let settings = settings(policy);
    let pictures = ComparedPictures {
        scenes: &settings.scenes,
        luminances_cd_m2: &settings.luminances_cd_m2,
        illuminant: &settings.illuminant,
        setups: &[],
    };
    let labelled: Vec<(&str, &Camera)> = ["a", "b", "c"].into_iter().zip(cameras).collect();
    ExposurePlan::new(policy, &labelled, pictures, Resources::default())
}

fn contenders(cameras: &[Camera]) -> Vec<Contender<'_>> {
    ["a", "b", "c"].iter().zip(cameras).map(|(label, c)| Contender::as_described(c, label)).collect()
}

/// Two automatic exposures differ, so both cameras get one time for each picture: no camera saturates more than the limit, and one
/// reaches it unless the longest time is reached.
#[test]
fn cameras_that_expose_differently_are_compared_at_equal_times() {
    let cameras = pair();
    let limits = EqualExposure { saturated_share: 0.02, longest_s: 0.02 };
    let settings = settings(ExposurePolicy::AutoEqual(limits));
    let compared = compare(&contenders(&cameras), &settings, Resources::default()).unwrap();
    assert_eq!(compared.exposure.applied(), ExposurePolicy::Equal(limits));
    let [a, b] = &compared.outcomes[..] else { panic!("two contenders") };
    for (light, (a, b)) in a.iter().zip(b).enumerate() {
        assert_eq!(a.targets.exposure, b.targets.exposure);
        for (i, ((name, a), (_, b))) in a.scenes.iter().zip(&b.scenes).enumerate() {
            let (a, b) = (&a.scores, &b.scores);
            assert_eq!(a.exposure_time_s, b.exposure_time_s, "{name}");
            assert_eq!(compared.exposure.scene_s(i, light), Some(a.exposure_time_s));
            let most = a.saturated_percent.max(b.saturated_percent);
            eprintln!("{name}, light {light}: {:.2} ms, {most:.2} %", a.exposure_time_s * 1e3);
            // Noise moves samples across the limit, some hundredths of those near it.
            assert!(most < 3.0, "{name}: {most}");
            assert!(a.exposure_time_s == limits.longest_s || most > 1.0, "{name}: {most}");
        }
    }
    let times: Vec<f64> = a.iter().map(|o| o.scenes[0].1.scores.exposure_time_s).collect();
    assert_eq!(times[0], limits.longest_s);
    assert!(times[1] < limits.longest_s);
}

#[test]
fn equal_own_times_are_kept() {
    let plan = |cameras: &[Camera], policy| plan(cameras, policy).unwrap();
    let automatic = ExposurePolicy::default();
    let fixed = |ms| camera(|d| d.exposure.time_ms = Some(ms));
    assert_eq!(plan(&[fixed(10.0), fixed(10.0)], automatic).applied(), ExposurePolicy::Own);
    let rule = |f_number| {
        camera(|d| {
            d.exposure.auto = Some(AutoExposureName::Luminance);
            d.optics.f_number = f_number;
        })
    };
    assert_eq!(plan(&[rule(4.0), rule(4.0)], automatic).applied(), ExposurePolicy::Own);
    assert_eq!(plan(&[rule(4.0)], automatic).applied(), ExposurePolicy::Own);
    assert_eq!(plan(&pair(), ExposurePolicy::Own).scene_s(0, 0), None);
    for cameras in [[fixed(10.0), fixed(20.0)], [rule(4.0), rule(2.0)]] {
        assert!(matches!(plan(&cameras, automatic).applied(), ExposurePolicy::Equal(_)));
    }
    let stated = plan(&pair(), ExposurePolicy::Time(0.004));
    assert_eq!((stated.scene_s(1, 1), stated.targets(0).unwrap().edge_s), (Some(0.004), 0.004));
}

/// A camera that saturates early limits the times of most pictures; cameras within two stops of each other do not.
#[test]
fn the_camera_that_limits_the_times_is_known() {
    let of_well = |full_well_e: f64| {
        camera(|d| {
            d.sensor.pixel.full_well_e = full_well_e;
            d.exposure.time_ms = Some(10.0);
        })
    };
    let limits = EqualExposure { saturated_share: 0.005, longest_s: 100.0 };
    let plan = |wells: [f64; 3]| plan(&wells.map(of_well), ExposurePolicy::Equal(limits)).unwrap();
    let limited = plan([9000.0, 90.0, 900.0]);
    let limiting = limited.limiting().unwrap();
    assert_eq!(limiting.label, "b");
    // Ten times the well of the next camera; the dark signal counts too.
    assert!((limiting.factor / 10.0 - 1.0).abs() < 0.05, "{limiting:?}");
    assert_eq!(plan([9000.0, 3000.0, 9000.0]).limiting(), None);
    // Two cameras of the same well: either could be left out without longer times.
    assert_eq!(plan([9000.0, 90.0, 90.0]).limiting(), None);
}

#[test]
fn impossible_exposures_name_the_setting() {
    let refused = |policy| match plan(&pair(), policy) {
        Err(ExperimentError::Setting(setting)) => setting.name,
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(ExposurePolicy::Time(0.0)), "the exposure time, s");
    let limits =
        |saturated_share, longest_s| ExposurePolicy::Equal(EqualExposure { saturated_share, longest_s });
    assert_eq!(refused(limits(1.0, 0.1)), "the saturated share");
    assert_eq!(refused(limits(0.1, f64::NAN)), "the longest time, s");
    // A camera whose offset alone saturates it cannot be exposed.
    let saturated = camera(|d| d.exposure.analog_offset_mv = 2000.0);
    let cameras = [camera(|_| {}), saturated];
    let limits = limits(0.1, 0.1);
    let error = plan(&cameras, limits);
    let error = error.unwrap_err().to_string();
    assert!(error.starts_with("b, dead-leaves"), "{error}");
}

/// A time that saturates all of a target at one of two lights is refused with that light, the first that suits is stated, and that one is accepted.
#[test]
fn a_time_that_saturates_a_whole_target_is_refused_before_work() {
    let cameras = pair();
    let checked = |policy: ExposurePolicy| {
        let labels = ["a", "b"].map(str::to_owned);
        policy.ensure_targets_show_something(
            &cameras,
            &labels,
            &[5.0, 500.0],
            &Illuminant::D65,
            Resources::default(),
        )
    };
    for policy in [ExposurePolicy::Own, ExposurePolicy::Equal(EqualExposure::default())] {
        checked(policy).unwrap();
    }
    for (time_s, light) in [(10.0, "a at 500 cd/m²"), (3000.0, "a at 5 cd/m²")] {
        let ExperimentError::Stage { context, source } = checked(ExposurePolicy::Time(time_s)).unwrap_err()
        else {
            panic!("{time_s} s")
        };
        assert_eq!(context, light);
        let CameraError::Exposure { fault: ExposureFault::Saturated { percent, longest_s }, .. } = *source
        else {
            panic!("{source}")
        };
        assert!(percent > 99.4 && longest_s < time_s, "{percent} % in {time_s} s, {longest_s} s at most");
        // The other light, which is brighter or the same, allows no more than this.
        let suits = checked(ExposurePolicy::Time(longest_s));
        assert_eq!(suits.is_ok(), light == "a at 500 cd/m²", "{longest_s} s");
    }
}
