//! A simulated sensor is measured, and what was put in comes back.
#![allow(missing_docs, clippy::unwrap_used)]

use crate::common;

use common::normal;
use smalti::metrics::MetricError;
use smalti::metrics::photon_transfer::{FlatPair, FrameStacks, PhotonTransfer, photon_transfer};
use smalti::numeric::philox::Stream;

const PIXELS: usize = 128 * 128;

struct Sensor {
    gain_dn_per_e: f64,
    read_noise_e: f64,
    full_well_e: f64,
    prnu: f64,
    dsnu_e: f64,
    step_dn: f64,
    bend: f64,
}

/// Poisson: by multiplication for few electrons, else normal, whose first two moments are the same.
fn poisson(s: &mut Stream, mean: f64) -> f64 {
    if mean > 50.0 {
        return (mean + mean.sqrt() * normal(s)).round().max(0.0);
    }
    let (limit, mut product, mut k) = ((-mean).exp(), s.uniform(), 0.0);
    while product > limit {
        product *= s.uniform();
        k += 1.0;
    }
    k
}

impl Sensor {
    fn frame(&self, electrons: f64, item: u32) -> Vec<f32> {
        let (mut pattern, mut noise) = (Stream::new(1, 0, 0), Stream::new(1, 1, item));
        let pixel = |_| {
            let (gain, offset) = (1.0 + self.prnu * normal(&mut pattern), self.dsnu_e * normal(&mut pattern));
            let mean = electrons * (1.0 - self.bend * electrons / self.full_well_e);
            let caught = (poisson(&mut noise, mean) * gain).min(self.full_well_e);
            let dn = (caught + offset + self.read_noise_e * normal(&mut noise)) * self.gain_dn_per_e + 100.0;
            (if self.step_dn > 0.0 { (dn / self.step_dn).round() * self.step_dn } else { dn }) as f32
        };
        (0..PIXELS).map(pixel).collect()
    }

    fn measured(&self) -> PhotonTransfer {
        let frames: Vec<(f64, [Vec<f32>; 4])> = (0u32..30)
            .map(|i| {
                let electrons = f64::from(i + 1) / 25.0 * self.full_well_e;
                let item = 4 * i;
                let frame = |electrons, k| self.frame(electrons, item + k);
                (electrons, [frame(electrons, 0), frame(electrons, 1), frame(0.0, 2), frame(0.0, 3)])
            })
            .collect();
        let levels: Vec<FlatPair<'_>> = frames
            .iter()
            .map(|(exposure, [a, b, c, d])| FlatPair { exposure: *exposure, bright: [a, b], dark: [c, d] })
            .collect();
        let stack = |e: f64, first: u32| (0..16).map(|k| self.frame(e, first + k)).collect::<Vec<_>>();
        let (bright, dark) = (stack(0.5 * self.full_well_e, 1000), stack(0.0, 2000));
        let bright: Vec<&[f32]> = bright.iter().map(Vec::as_slice).collect();
        let dark: Vec<&[f32]> = dark.iter().map(Vec::as_slice).collect();
        let stacks = FrameStacks { bright: &bright, dark: &dark };
        photon_transfer(&levels, Some(&stacks), self.step_dn).unwrap()
    }
}

fn assert_within(what: &str, got: f64, put_in: f64, percent: f64) {
    let off = 100.0 * (got / put_in - 1.0);
    eprintln!("{what}: put in {put_in}, measured {got} ({off:+.2} %)");
    assert!(off.abs() < percent, "{what}: put in {put_in}, measured {got}: off by {off:.2} %");
}

/// Tolerances: four standard errors of a variance over 16 384 pixels, √(2 / 16384) = 1.1 %, pooled over the points for
/// the gain; half of that for a standard deviation; one exposure step (4 %) for the saturation.
#[test]
fn what_is_put_in_comes_back() {
    let sensor = Sensor {
        gain_dn_per_e: 0.4,
        read_noise_e: 6.0,
        full_well_e: 9000.0,
        prnu: 0.01,
        dsnu_e: 12.0,
        step_dn: 1.0,
        bend: 0.0,
    };
    let r = sensor.measured();
    assert_within("gain", r.gain_dn_per_e, 0.4, 2.0);
    assert_within("conversion gain", r.conversion_gain_v_per_e(5e-4), 2e-4, 2.0);
    assert_within("read noise", r.dark_noise_e, 6.0, 4.0);
    assert_within("saturation capacity", r.saturation_e, 9000.0, 5.0);
    assert_within("full well", r.full_well_e.unwrap(), 9000.0, 2.0);
    assert_within("PRNU", r.prnu_percent.unwrap(), 1.0, 4.0);
    assert_within("DSNU", r.dsnu_e.unwrap(), 12.0, 4.0);
    assert!(r.linearity_error_percent < 0.1, "{}", r.linearity_error_percent);
    assert!(!r.dark_noise_is_limit);
    let noise = (36.0 + (1.0 / 0.4f64).powi(2) / 12.0 + 0.25).sqrt() + 0.5;
    assert_within("dynamic range", r.dynamic_range.db, 20.0 * (9000.0 / noise).log10(), 1.0);
    assert!(r.curve.windows(2).all(|p| p[0].exposure < p[1].exposure) && r.curve.len() == 30);
}

#[test]
fn a_sensor_without_converter_and_a_coarse_one() {
    let fine = Sensor {
        gain_dn_per_e: 2e-4,
        read_noise_e: 2.0,
        full_well_e: 5000.0,
        prnu: 0.0,
        dsnu_e: 0.0,
        step_dn: 0.0,
        bend: 0.0,
    };
    let r = fine.measured();
    assert_within("gain", r.gain_dn_per_e, 2e-4, 2.0);
    // Frames in single precision around 100 V resolve 8 µV, of which the noise of 0.4 mV takes no notice.
    assert_within("read noise", r.dark_noise_e, 2.0, 4.0);
    // What is left of the temporal noise after 16 frames, known to 1.1 %: 1.3 of 2500 e at one standard error.
    let (prnu, dsnu) = (r.prnu_percent.unwrap(), r.dsnu_e.unwrap());
    assert!(prnu < 0.11 && dsnu < 0.11, "PRNU {prnu} %, DSNU {dsnu} e");

    let coarse = Sensor { gain_dn_per_e: 0.05, step_dn: 1.0, ..fine };
    let r = coarse.measured();
    assert!(r.dark_noise_is_limit && (r.dark_noise_e - 0.4 / r.gain_dn_per_e).abs() < 1e-9);
}

#[test]
fn a_bent_response_shows() {
    let bent = Sensor {
        gain_dn_per_e: 0.4,
        read_noise_e: 3.0,
        full_well_e: 9000.0,
        prnu: 0.0,
        dsnu_e: 0.0,
        step_dn: 1.0,
        bend: 0.1,
    };
    let error = bent.measured().linearity_error_percent;
    assert!((0.3..5.0).contains(&error), "{error}");
}

#[test]
fn bad_frames_are_refused() {
    let (dark, bright) = (vec![0.0f32; 16], vec![1.0f32; 16]);
    let level = |exposure, bright| FlatPair { exposure, bright: [bright, bright], dark: [&dark, &dark] };
    let run = |levels: &[FlatPair<'_>], step| photon_transfer(levels, None, step).unwrap_err();
    let flat: Vec<_> = (0..5).map(|i| level(f64::from(i), &bright[..])).collect();
    assert!(matches!(run(&[], 1.0), MetricError::TooFew { .. }));
    assert!(matches!(run(&flat, -1.0), MetricError::Parameter { .. }));
    assert!(matches!(run(&flat, f64::NAN), MetricError::Parameter { .. }));
    // No noise at all, or no signal.
    assert!(matches!(run(&flat, 1.0), MetricError::TooFew { .. } | MetricError::Undefined { .. }));
    let none: Vec<_> = (0..5).map(|i| level(f64::from(i), &dark[..])).collect();
    assert!(matches!(run(&none, 1.0), MetricError::Undefined { .. }));
    let mut short = flat.clone();
    short[2].bright[1] = &bright[..7];
    assert!(matches!(run(&short, 1.0), MetricError::Count { .. }));
    let mut wrong = flat.clone();
    wrong[1].exposure = f64::NAN;
    assert!(matches!(run(&wrong, 1.0), MetricError::Parameter { .. }));
    let hole = vec![f32::NAN; 16];
    wrong = flat.clone();
    wrong[4].dark[0] = &hole;
    assert!(matches!(run(&wrong, 1.0), MetricError::NotFinite { .. }));
    let empty: Vec<_> =
        (0..5).map(|i| FlatPair { exposure: f64::from(i), bright: [&[], &[]], dark: [&[], &[]] }).collect();
    assert!(matches!(run(&empty, 1.0), MetricError::TooFew { .. }));
}
