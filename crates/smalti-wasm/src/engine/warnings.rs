//! What a designer should know of a design.

use std::collections::VecDeque;

use serde::Serialize;
use smalti::camera::{Camera, CameraError};
use smalti::design::live::{LiveFamily, LiveTargetScores};
use smalti::isp::WhiteBalance;
use smalti::spectrum::{Illuminant, Spectrum};

use super::EngineError;
use super::infrared::{Beyond, Infrared};
use super::request::space;

/// Share of the response to white of the brightest channel below which a channel is dark.
const DARK: f64 = 0.02;
/// Noise of Y after the colour matrix, relative to that of the channels, from which on colours cost much noise.
const NOISY: f64 = 4.0;
/// The largest difference of transmittance from the nearest filter of a family with which a filter counts as one of it.
const APART: f64 = 0.05;
/// Share of the samples that may saturate, percent.
const SATURATED_PERCENT: f64 = 1.0;

/// A warning about a key of a design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Warning {
    key: String,
    message: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    filter: Option<String>,
}

/// Warnings about a camera.
pub(super) fn of_camera(camera: &Camera) -> Result<Vec<Warning>, CameraError> {
    let grid = camera.grid();
    let lens = camera.optics.transmittance_on(grid)?;
    let light = Illuminant::D65.photons(grid)?;
    let (mut found, mut unknown) = (Vec::new(), Vec::new());
    let mut whites = Vec::new();
    let beyond = Beyond::new(camera)?;
    let channels = camera.sensor.cfa.channels();
    for (channel, response) in channels.iter().zip(camera.sensor.spectral_responsivity_on(grid)?) {
        let behind = response.times(&lens)?;
        match beyond.response(&channel.name, &behind) {
            Infrared::Blocked => {}
            Infrared::Seen { nm, percent } => found.push(Warning {
                key: "optics.ir_cut".into(),
                message: format!(
                    "the channel {} responds at {nm} nm with {percent:.0} % of its maximum; light beyond {} nm, which is not simulated, would reach it",
                    channel.name,
                    grid.end_nm()
                ),
                filter: Some(channel.name.clone()),
            }),
            Infrared::Unknown => unknown.push(channel.name.as_str()),
        }
        whites.push(behind.times(&light)?.integral());
    }
    if !unknown.is_empty() {
        found.push(Warning {
            key: "optics.ir_cut".into(),
            message: format!(
                "whether light beyond {} nm reaches the filters {} cannot be judged: some of their curves are not stated there, and nothing else blocks \
                 it. Use an infrared-cut filter",
                grid.end_nm(),
                unknown.join(", ")
            ),
            filter: None,
        });
    }
    let brightest = whites.iter().copied().fold(0.0, f64::max);
    for (channel, white) in channels.iter().zip(&whites) {
        if *white < DARK * brightest {
            found.push(Warning {
                key: format!("sensor.cfa.filters.{}", channel.name),
                message: format!(
                    "the channel {} has {:.1} % of the response of the brightest channel to white",
                    channel.name,
                    100.0 * white / brightest
                ),
                filter: Some(channel.name.clone()),
            });
        }
    }
    let noise_gain = camera.isp(&light, WhiteBalance::None)?.color_matrix.luminance_noise_gain();
    if noise_gain > NOISY {
        found.push(Warning {
            key: "sensor.cfa.filters".into(),
            message: format!("the filters are ill-conditioned: the colour matrix multiplies the noise of Y by {noise_gain:.1}"),
            filter: None,
        });
    }
    Ok(found)
}

/// Filters of a family in words.
fn words(family: LiveFamily) -> &'static str {
    match family {
        LiveFamily::Free => "as a smooth curve",
        LiveFamily::Pigments => "of pigments",
        LiveFamily::Dichroic => "as a dichroic band",
    }
}

/// Filters whose distance from a family is kept.
const KEPT: usize = 32;

/// The distances of filters from families.
#[derive(Default)]
pub(super) struct Makeable {
    /// Family, curve and distance, those used last at the end.
    kept: VecDeque<(LiveFamily, Spectrum, f64)>,
}

impl Makeable {
    /// Warnings about filters that the family does not have.
    pub(super) fn warnings(
        &mut self,
        camera: &Camera,
        family: LiveFamily,
    ) -> Result<Vec<Warning>, EngineError> {
        let mut sampled = None;
        let mut found = Vec::new();
        for channel in camera.sensor.cfa.channels() {
            let curve = &channel.transmittance;
            let known = self.kept.iter().find(|(f, c, _)| *f == family && c == curve).map(|(_, _, d)| *d);
            let distance = match known {
                Some(distance) => distance,
                None => {
                    let sampled = match &sampled {
                        Some(sampled) => sampled,
                        None => sampled.insert(space(family).sampled(camera.grid())?),
                    };
                    let distance = sampled.distance(curve);
                    if self.kept.len() >= KEPT {
                        self.kept.pop_front();
                    }
                    self.kept.push_back((family, curve.clone(), distance));
                    distance
                }
            };
            if distance > APART {
                found.push(Warning {
                    key: format!("sensor.cfa.filters.{}", channel.name),
                    message: format!(
                        "the filter {} cannot be made {}: the nearest such filter differs by up to {:.0} % transmittance",
                        channel.name,
                        words(family),
                        100.0 * distance
                    ),
                    filter: Some(channel.name.clone()),
                });
            }
        }
        Ok(found)
    }
}

/// Warnings about figures that cannot be measured.
pub(super) fn of_targets(targets: &LiveTargetScores) -> Vec<Warning> {
    let warning = |reason: &String| Warning {
        key: "optics".into(),
        message: format!("MTF50 cannot be measured: {reason}"),
        filter: None,
    };
    targets.no_mtf50.iter().map(warning).collect()
}

/// Warnings about a capture.
pub(super) fn of_capture(saturated_percent: f64) -> Option<Warning> {
    (saturated_percent > SATURATED_PERCENT).then(|| Warning {
        key: "exposure.time_ms".into(),
        message: format!("{saturated_percent:.1} % of the samples saturate"),
        filter: None,
    })
}
