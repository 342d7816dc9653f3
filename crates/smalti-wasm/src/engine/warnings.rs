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
/// The key of the filters.
const FILTERS: &str = "sensor.cfa.filters";
/// The key of the infrared cut.
const IR_CUT: &str = "optics.ir_cut";
/// Independent channels that colour needs.
const COLORS: usize = 3;
/// Share of the samples that may saturate, percent: beyond it, a design clips noticeably.
pub(super) const SATURATED_PERCENT: f64 = 1.0;

/// A warning about a key of a design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Warning {
    key: String,
    message: String,
}

impl Warning {
    fn new(key: &str, message: String) -> Self {
        Self { key: key.into(), message }
    }
}

/// A filter with a fault: its letter, how severe the fault is, and its figures in words.
struct FaultyFilter {
    letter: String,
    severity: f64,
    figures: String,
}

/// One warning about all filters with a fault, the worst first: `one` says it of one filter by letter and figures, `several` of a number of them with a list of these.
fn of_filters(
    key: &str,
    mut all: Vec<FaultyFilter>,
    one: impl Fn(&str, &str) -> String,
    several: impl Fn(usize, &str) -> String,
) -> Option<Warning> {
    all.sort_by(|a, b| b.severity.total_cmp(&a.severity));
    let message = match all.as_slice() {
        [] => return None,
        [only] => one(&only.letter, &only.figures),
        _ => {
            let list: Vec<String> = all
                .iter()
                .map(|FaultyFilter { letter, figures, .. }| format!("{letter} ({figures})"))
                .collect();
            several(all.len(), &list.join(", "))
        }
    };
    Some(Warning::new(key, message))
}

/// Warnings about a camera.
pub(super) fn of_camera(camera: &Camera) -> Result<Vec<Warning>, CameraError> {
    let grid = camera.grid();
    let lens = camera.optics.transmittance_on(grid)?;
    let light = Illuminant::D65.photons(grid)?;
    let (mut found, mut seen, mut unknown) = (Vec::new(), Vec::new(), Vec::new());
    let mut whites = Vec::new();
    let beyond = Beyond::new(camera)?;
    let end_nm = grid.end_nm();
    let channels = camera.sensor.cfa.channels();
    for (channel, response) in channels.iter().zip(camera.sensor.spectral_responsivity_on(grid)?) {
        let behind = response.times(&lens)?;
        match beyond.response(&channel.name, &behind) {
            Infrared::Blocked => {}
            Infrared::Seen { nm, percent } => seen.push(FaultyFilter {
                letter: channel.name.clone(),
                severity: percent,
                figures: format!("{percent:.0} % of its maximum at {nm} nm"),
            }),
            Infrared::Unknown => unknown.push(channel.name.as_str()),
        }
        whites.push(behind.times(&light)?.integral());
    }
    found.extend(of_filters(
        IR_CUT,
        seen,
        |letter, figures| {
            format!(
                "the channel {letter} responds with {figures}; light beyond {end_nm} nm, which is not simulated, would reach it"
            )
        },
        |count, list| {
            format!("light beyond {end_nm} nm, which is not simulated, would reach {count} channels: {list}")
        },
    ));
    if !unknown.is_empty() {
        let message = format!(
            "whether light beyond {end_nm} nm reaches the filters {} cannot be judged: some of their curves are not stated there, and nothing else blocks \
             it. Use an infrared-cut filter",
            unknown.join(", ")
        );
        found.push(Warning::new(IR_CUT, message));
    }
    let brightest = whites.iter().copied().fold(0.0, f64::max);
    let dark = channels.iter().zip(&whites).filter(|(_, white)| **white < DARK * brightest);
    found.extend(of_filters(
        FILTERS,
        dark.map(|(channel, white)| FaultyFilter {
            letter: channel.name.clone(),
            severity: -white,
            figures: format!("{:.1} %", 100.0 * white / brightest),
        })
        .collect(),
        |letter, figures| {
            format!("the channel {letter} has {figures} of the response of the brightest channel to white")
        },
        |count, list| {
            format!("{count} channels respond weakly to white, relative to the brightest channel: {list}")
        },
    ));
    let independent = camera.independent_channels(&light)?;
    if independent < COLORS {
        let message = match independent {
            2 => {
                "the array confuses colours: only two of its channels respond to light independently, and colour needs three. Give a filter another curve, or add a filter"
            }
            _ => {
                "the array sees no colour: its channels all respond to light in the same way, and colour needs three that differ"
            }
        };
        found.push(Warning::new(FILTERS, message.into()));
    }
    let noise_gain = camera.isp(&light, WhiteBalance::None)?.color_matrix.luminance_noise_gain();
    if noise_gain > NOISY {
        let message = format!(
            "the filters are ill-conditioned: the colour matrix multiplies the noise of Y by {noise_gain:.1}"
        );
        found.push(Warning::new(FILTERS, message));
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
        let (mut apart, mut high, mut reached) = (Vec::new(), Vec::new(), 0.0);
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
            let faulty = |severity: f64, unit: &str| FaultyFilter {
                letter: channel.name.clone(),
                severity,
                figures: format!("{:.0} {unit}", 100.0 * severity),
            };
            if distance > APART {
                apart.push(faulty(distance, "percentage points"));
            }
            if curve.max() > most + HIGHER {
                high.push(faulty(curve.max(), "%"));
                reached = 100.0 * most;
            }
        }
        let [made, filters] = words(family);
        let apart = of_filters(
            FILTERS,
            apart,
            |letter, figures| {
                format!(
                    "the filter {letter} cannot be made {made}: its transmittance differs from that of the nearest such filter by up to {figures}"
                )
            },
            |count, list| {
                format!(
                    "{count} filters cannot be made {made}. Their transmittances differ from those of the nearest such filters by up to: {list}"
                )
            },
        );
        let high = of_filters(
            FILTERS,
            high,
            |letter, figures| {
                format!(
                    "the peak of the filter {letter} is {figures} transmittance; {filters} reach {reached:.0} %"
                )
            },
            |count, list| {
                format!(
                    "the peaks of {count} filters are higher than the {reached:.0} % transmittance that {filters} reach: {list}"
                )
            },
        );
        Ok(apart.into_iter().chain(high).collect())
    }
}

/// Warnings about figures that cannot be measured.
pub(super) fn of_targets(targets: &LiveTargetScores) -> Vec<Warning> {
    let warning = |reason: &String| Warning::new("optics", format!("MTF50 cannot be measured: {reason}"));
    targets.no_mtf50.iter().map(warning).collect()
}

/// Warnings about a capture.
pub(super) fn of_capture(saturated_percent: f64) -> Option<Warning> {
    let message = format!(
        "{saturated_percent:.1} % of the samples saturate: the picture and its scores show clipping, in highlights or in darker, saturated colours"
    );
    (saturated_percent > SATURATED_PERCENT).then(|| Warning::new("exposure.time_ms", message))
}
