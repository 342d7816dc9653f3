//! What designs are scored by, and what they scored.

use serde::{Deserialize, Serialize};

use crate::camera::CameraError;

/// A metric of a study, by its name in the [list of metrics](crate::metrics::CATALOG).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Metric {
    /// Colour difference of 1976 from the ColorChecker itself, mean over the patches.
    #[serde(rename = "delta_e_76")]
    DeltaE76,
    /// CIEDE2000 from the ColorChecker itself, mean over the patches.
    #[serde(rename = "delta_e_2000")]
    DeltaE2000,
    /// Frequency at which the response to an edge falls to one half, cycles per mm on the sensor.
    #[serde(rename = "mtf50_cy_per_mm")]
    Mtf50CyPerMm,
    /// The same in cycles per pixel.
    #[serde(rename = "mtf50_cy_per_px")]
    Mtf50CyPerPx,
    /// `100 · std(Y) / mean(Y)`, mean over the grey series of the ColorChecker, percent.
    #[serde(rename = "luminance_noise_percent")]
    LuminanceNoise,
    /// Energy in the picture of a zone plate that is not in the zone plate, percent.
    #[serde(rename = "aliasing_percent")]
    Aliasing,
    /// The part of it that is colour.
    #[serde(rename = "color_aliasing_percent")]
    ColorAliasing,
    /// White over RMS difference of X, Y, Z from what the standard observer sees of a scene, dB.
    #[serde(rename = "cpsnr_db")]
    Cpsnr,
    /// Mean CIEDE2000 of the pixels of a scene.
    #[serde(rename = "pixel_delta_e_2000_mean")]
    PixelDeltaE2000,
    /// Mean S-CIELAB difference of a scene.
    #[serde(rename = "scielab_mean")]
    Scielab,
}

/// What a metric looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Sight {
    /// The ColorChecker without noise.
    Colors,
    /// The grey series of the ColorChecker with all noise.
    Greys,
    /// A slanted edge without noise.
    Edge,
    /// A zone plate without noise.
    ZonePlate,
    /// Every scene of the study, with all noise.
    Scenes,
}

impl Metric {
    /// The metrics of a study that names none: those of `[cfaresolution]`, and two of their variants.
    pub const USUAL: [Self; 5] =
        [Self::DeltaE76, Self::DeltaE2000, Self::Mtf50CyPerMm, Self::Mtf50CyPerPx, Self::LuminanceNoise];

    /// The metrics of scenes.
    pub const OF_SCENES: [Self; 3] = [Self::Cpsnr, Self::PixelDeltaE2000, Self::Scielab];

    /// What it looks at.
    #[must_use]
    pub fn sight(self) -> Sight {
        match self {
            Self::DeltaE76 | Self::DeltaE2000 => Sight::Colors,
            Self::LuminanceNoise => Sight::Greys,
            Self::Mtf50CyPerMm | Self::Mtf50CyPerPx => Sight::Edge,
            Self::Aliasing | Self::ColorAliasing => Sight::ZonePlate,
            Self::Cpsnr | Self::PixelDeltaE2000 | Self::Scielab => Sight::Scenes,
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
            Self::Aliasing => "aliasing_percent",
            Self::ColorAliasing => "color_aliasing_percent",
            Self::Cpsnr => "cpsnr_db",
            Self::PixelDeltaE2000 => "pixel_delta_e_2000_mean",
            Self::Scielab => "scielab_mean",
        }
    }
}

/// Of the ColorChecker without noise, means over its patches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorScores {
    /// [`Metric::DeltaE76`].
    pub delta_e_76: f64,
    /// [`Metric::DeltaE2000`].
    pub delta_e_2000: f64,
}

/// Of a slanted edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeScores {
    /// [`Metric::Mtf50CyPerMm`].
    pub mtf50_cy_per_mm: f64,
    /// [`Metric::Mtf50CyPerPx`].
    pub mtf50_cy_per_px: f64,
    /// Exposure time, s.
    pub time_s: f64,
}

/// What of a zone plate's picture is not in the zone plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AliasingScores {
    /// [`Metric::Aliasing`].
    pub aliasing_percent: f64,
    /// [`Metric::ColorAliasing`].
    pub color_aliasing_percent: f64,
}

/// How far the picture of a scene is from what the standard observer sees, as in
/// [`PictureScores`](crate::camera::PictureScores).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneFigures {
    /// [`Metric::Cpsnr`].
    pub cpsnr_db: f64,
    /// [`Metric::PixelDeltaE2000`].
    pub pixel_delta_e_2000_mean: f64,
    /// [`Metric::Scielab`].
    pub scielab_mean: f64,
}

/// What was found where a metric asked for it: `None` where none did; else the scores, or why there are none.
pub type Asked<T> = Option<Result<T, CameraError>>;

/// The scores of a design. What fails on one target, such as an edge without contrast, says nothing of the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Scores {
    /// Colours of the ColorChecker.
    pub colors: Asked<ColorScores>,
    /// [`Metric::LuminanceNoise`].
    pub luminance_noise_percent: Asked<f64>,
    /// The edge.
    pub edge: Asked<EdgeScores>,
    /// The zone plate.
    pub zone_plate: Asked<AliasingScores>,
    /// The scenes of the study, in their order.
    pub scenes: Vec<Result<SceneFigures, CameraError>>,
    /// Exposure time of the ColorChecker, s.
    pub macbeth_time_s: f64,
}

impl Scores {
    /// The score by a metric, of a scene by its place among those of the study; `None` where it was not asked for, or cannot be
    /// computed.
    #[must_use]
    pub fn value(&self, metric: Metric, scene: usize) -> Option<f64> {
        fn of<T: Copy>(found: &Asked<T>) -> Option<T> {
            found.as_ref()?.as_ref().ok().copied()
        }
        let scene = || self.scenes.get(scene)?.as_ref().ok();
        Some(match metric {
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

    /// What failed, each with the target that it failed on.
    pub fn problems(&self) -> impl Iterator<Item = (&'static str, &CameraError)> {
        fn of<T>(found: &Asked<T>) -> Option<&CameraError> {
            found.as_ref()?.as_ref().err()
        }
        let targets = [
            ("colours", of(&self.colors)),
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
        let scenes = Metric::OF_SCENES.into_iter();
        for metric in Metric::USUAL.into_iter().chain([Metric::Aliasing, Metric::ColorAliasing]).chain(scenes)
        {
            assert!(CATALOG.iter().any(|m| m.name == metric.name()), "{}", metric.name());
            assert_eq!(serde_json::to_value(metric).unwrap(), metric.name());
        }
    }
}
