//! What a designer should know of a design.

use std::collections::VecDeque;

use serde::Serialize;
use smalti::camera::{Camera, CameraError};
use smalti::design::live::{LiveFamily, LiveTargetScores};
use smalti::design::search::SampledSpace;
use smalti::isp::WhiteBalance;
use smalti::spectrum::{Illuminant, Spectrum};

use super::EngineError;
use super::infrared::{Beyond, Infrared};
use super::request::judged;

/// Share of the response to white of the brightest channel below which a channel is dark.
const DARK: f64 = 0.02;
/// Noise of Y after the colour matrix, relative to that of the channels, from which on colours cost much noise.
const NOISY: f64 = 4.0;
/// The largest difference of transmittance from the nearest filter of a family with which a filter counts as one of it.
const APART: f64 = 0.05;
/// The transmittance by which the peak of a filter may lie above that of the family.
const HIGHER: f64 = 0.01;
/// Independent channels that colour needs.
const COLORS: usize = 3;
/// Share of the samples that may saturate, percent: beyond it, a design clips noticeably.
pub(super) const SATURATED_PERCENT: f64 = 1.0;

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
    let independent = camera.independent_channels(&light)?;
    if independent < COLORS {
        found.push(Warning {
            key: "sensor.cfa.filters".into(),
            message: match independent {
                2 => "the array confuses colours: only two of its channels respond to light independently, and colour needs three. Give a filter another curve, or add a filter",
                _ => "the array sees no colour: its channels all respond to light in the same way, and colour needs three that differ",
            }
            .into(),
            filter: None,
        });
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

/// How a filter is made in a family, and the filters of the family.
fn words(family: LiveFamily) -> [&'static str; 2] {
    match family {
        LiveFamily::Free => ["as a smooth curve", "smooth curves"],
        LiveFamily::Pigments => ["of pigments", "filters of pigments"],
        LiveFamily::Dichroic => ["as a dichroic band", "dichroic bands"],
    }
}

/// Filters whose distance from a family is kept.
const KEPT: usize = 32;

/// The distances of filters from families.
#[derive(Default)]
pub(super) struct Makeable {
    /// Family, curve, distance, and the greatest transmittance of the family; those used last at the end.
    kept: VecDeque<(LiveFamily, Spectrum, [f64; 2])>,
}

impl Makeable {
    /// Warnings about filters that the family does not have.
    pub(super) fn warnings(
        &mut self,
        camera: &Camera,
        family: LiveFamily,
    ) -> Result<Vec<Warning>, EngineError> {
        let mut sampled: Option<Vec<SampledSpace>> = None;
        let mut found = Vec::new();
        for channel in camera.sensor.cfa.channels() {
            let curve = &channel.transmittance;
            let known = self.kept.iter().find(|(f, c, _)| *f == family && c == curve).map(|(_, _, d)| *d);
            let [distance, most] = match known {
                Some(known) => known,
                None => {
                    let sampled = match &sampled {
                        Some(sampled) => sampled,
                        None => {
                            let spaces = judged(family);
                            let on_grid = spaces.iter().map(|space| space.sampled(camera.grid()));
                            sampled.insert(on_grid.collect::<Result<_, _>>()?)
                        }
                    };
                    let nearest = |least: f64, space: &SampledSpace| least.min(space.distance(curve));
                    let new = [
                        sampled.iter().fold(1.0, nearest),
                        sampled.iter().map(SampledSpace::clear).fold(0.0, f64::max),
                    ];
                    if self.kept.len() >= KEPT {
                        self.kept.pop_front();
                    }
                    self.kept.push_back((family, curve.clone(), new));
                    new
                }
            };
            let [made, filters] = words(family);
            let mut warn = |message: String| {
                let (key, filter) = (format!("sensor.cfa.filters.{}", channel.name), channel.name.clone());
                found.push(Warning { key, message, filter: Some(filter) });
            };
            if distance > APART {
                warn(format!(
                    "the filter {} cannot be made {made}: the nearest such filter differs by up to {:.0} % transmittance",
                    channel.name,
                    100.0 * distance
                ));
            }
            if curve.max() > most + HIGHER {
                warn(format!(
                    "the peak of the filter {} is {:.0} % transmittance; {filters} reach {:.0} %",
                    channel.name,
                    100.0 * curve.max(),
                    100.0 * most
                ));
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
        message: format!(
            "{saturated_percent:.1} % of the samples saturate: the picture and its scores show clipping, in highlights or in darker, saturated colours"
        ),
        filter: None,
    })
}
