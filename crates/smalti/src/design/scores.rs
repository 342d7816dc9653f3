//! The metrics of a study and the scores of its trials.

use serde::{Deserialize, Serialize};

use crate::camera::{CameraError, SensorColorimetry};
use crate::metrics::esfr::Mtf50Reliability;

/// A metric of a study, by its name in the [list of metrics](crate::metrics::CATALOG).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Metric {
    /// ΔE*ab (CIE 1976) from the reference ColorChecker, mean over the patches.
    #[serde(rename = "delta_e_76")]
    DeltaE76,
    /// CIEDE2000 from the reference ColorChecker, mean over the patches.
    #[serde(rename = "delta_e_2000")]
    DeltaE2000,
    /// Spatial frequency at which the edge response falls to one half (MTF50), cycles per mm on the sensor.
    #[serde(rename = "mtf50_cy_per_mm")]
    Mtf50CyPerMm,
    /// MTF50 in cycles per pixel.
    #[serde(rename = "mtf50_cy_per_px")]
    Mtf50CyPerPx,
    /// `100 · std(Y) / mean(Y)`, mean over the grey series of the ColorChecker, percent.
    #[serde(rename = "luminance_noise_percent")]
    LuminanceNoise,
    /// Vora value: share of the space of the CIE 1931 colour matching functions that the spectral sensitivities span, 0 to 1.
    #[serde(rename = "vora_value")]
    VoraValue,
    /// Sensitivity metamerism index of ISO 17321-1 under the illuminant, at most 100.
    #[serde(rename = "sensitivity_metamerism_index")]
    SensitivityMetamerismIndex,
    /// Range of X, Y, Z of the reflectances that the sensor cannot tell from a mid grey, percent of the range of all objects.
    #[serde(rename = "metamer_mismatch_percent")]
    MetamerMismatch,
    /// Aliased energy in the picture of a zone plate, percent of the energy of the picture.
    #[serde(rename = "aliasing_percent")]
    Aliasing,
    /// The chromatic part of the aliased energy, percent.
    #[serde(rename = "color_aliasing_percent")]
    ColorAliasing,
    /// Peak signal-to-noise ratio over X, Y, Z of a scene against the standard observer, peak at white, dB.
    #[serde(rename = "cpsnr_db")]
    Cpsnr,
    /// CIEDE2000, mean over the pixels of a scene.
    #[serde(rename = "pixel_delta_e_2000_mean")]
    PixelDeltaE2000,
    /// S-CIELAB difference, mean over the pixels of a scene.
    #[serde(rename = "scielab_mean")]
    Scielab,
}

/// The target that a metric is measured on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum MetricTarget {
    /// The spectral sensitivities of the sensor: nothing is rendered.
    Sensitivities,
    /// The ColorChecker without noise.
    ColorPatches,
    /// The grey series of the ColorChecker with all noise.
    GreyPatches,
    /// A slanted edge without noise.
    Edge,
    /// A zone plate without noise.
    ZonePlate,
    /// Every scene of the study, with all noise.
    Scenes,
}

impl Metric {
    /// The default metrics of a study: those of `[cfaresolution]` and two variants of them.
    pub const USUAL: [Self; 5] =
        [Self::DeltaE76, Self::DeltaE2000, Self::Mtf50CyPerMm, Self::Mtf50CyPerPx, Self::LuminanceNoise];

    /// The metrics of the spectral sensitivities.
    pub const OF_SENSITIVITIES: [Self; 3] =
        [Self::VoraValue, Self::SensitivityMetamerismIndex, Self::MetamerMismatch];

    /// The metrics that are measured on scenes.
    pub const OF_SCENES: [Self; 3] = [Self::Cpsnr, Self::PixelDeltaE2000, Self::Scielab];

    /// The target that it is measured on.
    #[must_use]
    pub fn target(self) -> MetricTarget {
        match self {
            Self::VoraValue | Self::SensitivityMetamerismIndex | Self::MetamerMismatch => {
                MetricTarget::Sensitivities
            }
            Self::DeltaE76 | Self::DeltaE2000 => MetricTarget::ColorPatches,
            Self::LuminanceNoise => MetricTarget::GreyPatches,
            Self::Mtf50CyPerMm | Self::Mtf50CyPerPx => MetricTarget::Edge,
            Self::Aliasing | Self::ColorAliasing => MetricTarget::ZonePlate,
            Self::Cpsnr | Self::PixelDeltaE2000 | Self::Scielab => MetricTarget::Scenes,
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::DeltaE76 => "delta_e_76",
            Self::DeltaE2000 => "delta_e_2000",
            Self::Mtf50CyPerMm => "mtf50_cy_per_mm",
            Self::Mtf50CyPerPx => "mtf50_cy_per_px",
            Self::LuminanceNoise => "luminance_noise_percent",
            Self::VoraValue => "vora_value",
            Self::SensitivityMetamerismIndex => "sensitivity_metamerism_index",
            Self::MetamerMismatch => "metamer_mismatch_percent",
            Self::Aliasing => "aliasing_percent",
            Self::ColorAliasing => "color_aliasing_percent",
            Self::Cpsnr => "cpsnr_db",
            Self::PixelDeltaE2000 => "pixel_delta_e_2000_mean",
            Self::Scielab => "scielab_mean",
        }
    }
}

/// Colour differences on the ColorChecker without noise, means over the patches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorScores {
    /// [`Metric::DeltaE76`].
    pub delta_e_76: f64,
    /// [`Metric::DeltaE2000`].
    pub delta_e_2000: f64,
}

/// Resolution measured on a slanted edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeScores {
    /// [`Metric::Mtf50CyPerMm`].
    pub mtf50_cy_per_mm: f64,
    /// [`Metric::Mtf50CyPerPx`].
    pub mtf50_cy_per_px: f64,
    /// Whether MTF50 can be trusted as a resolution.
    pub mtf50_reliability: Mtf50Reliability,
    /// Exposure time, s.
    pub time_s: f64,
    /// The share of the raw samples around the edge that saturate without noise, percent.
    pub saturated_percent: f64,
}

/// Aliasing measured on a zone plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AliasingScores {
    /// [`Metric::Aliasing`].
    pub aliasing_percent: f64,
    /// [`Metric::ColorAliasing`].
    pub color_aliasing_percent: f64,
}

/// Differences of the picture of a scene from the reference of the standard observer, as in
/// [`PictureScores`](crate::camera::PictureScores).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneFigures {
    /// [`Metric::Cpsnr`].
    pub cpsnr_db: f64,
    /// [`Metric::PixelDeltaE2000`].
    pub pixel_delta_e_2000_mean: f64,
    /// [`Metric::Scielab`].
    pub scielab_mean: f64,
    /// The share of the raw samples that saturate, percent.
    pub saturated_percent: f64,
}

/// The scores on one target, or the error of the measurement; `None` when no metric of the study needs the target.
pub type MetricResult<T> = Option<Result<T, CameraError>>;

/// The scores of a trial. A failure on one target, such as an edge without contrast, does not affect the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Scores {
    /// The spectral sensitivities.
    pub sensor: MetricResult<SensorColorimetry>,
    /// The colour patches of the ColorChecker.
    pub colors: MetricResult<ColorScores>,
    /// [`Metric::LuminanceNoise`].
    pub luminance_noise_percent: MetricResult<f64>,
    /// The slanted edge.
    pub edge: MetricResult<EdgeScores>,
    /// The zone plate.
    pub zone_plate: MetricResult<AliasingScores>,
    /// The scenes of the study, in their order.
    pub scenes: Vec<Result<SceneFigures, CameraError>>,
    /// Exposure time of the ColorChecker, s.
    pub macbeth_time_s: f64,
    /// The share of the raw samples of the ColorChecker that saturate without noise, percent.
    pub macbeth_saturated_percent: f64,
}

impl Scores {
    /// The score of a metric; `scene` is the index of the scene in the study and counts for metrics of scenes only. `None`
    /// when the metric was not measured or cannot be computed.
    #[must_use]
    pub fn value(&self, metric: Metric, scene: usize) -> Option<f64> {
        fn of<T: Copy>(found: &MetricResult<T>) -> Option<T> {
            found.as_ref()?.as_ref().ok().copied()
        }
        let scene = || self.scenes.get(scene)?.as_ref().ok();
        Some(match metric {
            Metric::VoraValue => of(&self.sensor)?.vora_value,
            Metric::SensitivityMetamerismIndex => of(&self.sensor)?.sensitivity_metamerism_index,
            Metric::MetamerMismatch => of(&self.sensor)?.metamer_mismatch_percent,
            Metric::DeltaE76 => of(&self.colors)?.delta_e_76,
            Metric::DeltaE2000 => of(&self.colors)?.delta_e_2000,
            Metric::Mtf50CyPerMm => of(&self.edge)?.mtf50_cy_per_mm,
            Metric::Mtf50CyPerPx => of(&self.edge)?.mtf50_cy_per_px,
            Metric::LuminanceNoise => of(&self.luminance_noise_percent)?,
            Metric::Aliasing => of(&self.zone_plate)?.aliasing_percent,
            Metric::ColorAliasing => of(&self.zone_plate)?.color_aliasing_percent,
            Metric::Cpsnr => scene()?.cpsnr_db,
            Metric::PixelDeltaE2000 => scene()?.pixel_delta_e_2000_mean,
            Metric::Scielab => scene()?.scielab_mean,
        })
    }

    /// The measurements that failed: the target and the error.
    pub fn problems(&self) -> impl Iterator<Item = (&'static str, &CameraError)> {
        fn of<T>(found: &MetricResult<T>) -> Option<&CameraError> {
            found.as_ref()?.as_ref().err()
        }
        let targets = [
            ("sensitivities", of(&self.sensor)),
            ("colour error", of(&self.colors)),
            ("noise", of(&self.luminance_noise_percent)),
            ("edge", of(&self.edge)),
            ("zone plate", of(&self.zone_plate)),
        ];
        let scenes = self.scenes.iter().map(|s| ("scene", s.as_ref().err()));
        targets.into_iter().chain(scenes).filter_map(|(target, e)| Some((target, e?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::CATALOG;

    #[test]
    fn metrics_have_the_names_of_the_list() {
        let others = Metric::OF_SCENES.into_iter().chain(Metric::OF_SENSITIVITIES);
        for metric in Metric::USUAL.into_iter().chain([Metric::Aliasing, Metric::ColorAliasing]).chain(others)
        {
            assert!(CATALOG.iter().any(|m| m.name == metric.name()), "{}", metric.name());
            assert_eq!(serde_json::to_value(metric).unwrap(), metric.name());
        }
    }
}
