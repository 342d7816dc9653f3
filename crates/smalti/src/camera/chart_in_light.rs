//! The ColorChecker under a camera whose light changes, for the noise part of a light gain.

use super::chart::{self, PATCH_SAMPLES};
use super::grey_noise::{COMPARED_NOISE_CAPTURES, GreyNoise};
use super::{Camera, CameraError, IspFor, Setup};
use crate::color::Image;
use crate::isp::Isp;
use crate::metrics::MetricError;
use crate::scene::{Setting, macbeth};
use crate::sensor::NoiseMode;

/// The chart imaged on a camera, and the camera's processing.
pub(super) struct ChartInLight<'a> {
    setup: Setup,
    isp: Box<dyn Isp + 'a>,
}

impl<'a> ChartInLight<'a> {
    /// The chart in the light of a setting, exposed for `time_s` or as the camera's description states. The optical image of `other`
    /// is reused where possible.
    pub(super) fn new(
        (camera, isp): (&Camera, IspFor<'a>),
        setting: &Setting,
        time_s: Option<f64>,
        other: Option<&ChartInLight<'_>>,
    ) -> Result<Self, CameraError> {
        let setup = match other.map(|o| o.setup.before(camera)).transpose()?.flatten() {
            Some(setup) => setup,
            None => Setup::with_size(camera, macbeth::chart(PATCH_SAMPLES, setting)?, chart::SIZE_PX)?,
        };
        let isp = isp(&setup.light)?;
        Ok(Self { setup: setup.exposed(time_s)?, isp })
    }

    /// Visual SNR and luminance noise of the grey series for each capture, with the light changed by `stops`. When a patch has no
    /// signal, they are 0 and infinite, the worst values.
    pub(super) fn grey_noise(&self, stops: f64, seed: u64) -> Result<[Vec<f64>; 2], CameraError> {
        let Setup { camera, image, light, exposure } = &self.setup.in_light(stops.exp2())?;
        let capture = |number: u64| -> Result<Image, CameraError> {
            let seed = seed.wrapping_add(number);
            Ok(self.isp.render(&camera.sensor.capture(image, exposure, NoiseMode::All, seed)?)?)
        };
        let captures = (0..COMPARED_NOISE_CAPTURES).map(capture).collect::<Result<Vec<_>, _>>()?;
        match GreyNoise::of_captures(&captures, light) {
            Ok(noise) => Ok([
                noise.iter().map(|n| n.visual_snr.median).collect(),
                noise.iter().map(|n| n.luminance_noise_percent.mean).collect(),
            ]),
            Err(CameraError::Metric(MetricError::Undefined { .. })) => {
                Ok([0.0, f64::INFINITY].map(|worst| vec![worst; captures.len()]))
            }
            Err(e) => Err(e),
        }
    }
}
