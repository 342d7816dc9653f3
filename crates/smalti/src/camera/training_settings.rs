//! Settings for training a pipeline.

use serde::Serialize;

use super::{Camera, CameraError};
use crate::l3::Textures;
use crate::sensor::Channel;
use crate::spectrum::Illuminant;

/// The output that a pipeline is trained for.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TrainingTarget {
    /// CIE 1931 X, Y, Z, with Y = 1 for a white diffuser that just saturates its brightest channel, as with
    /// [`crate::isp::Classic`].
    #[default]
    Xyz,
    /// The responses of other sensitivities behind the same lens, such as another camera, near infrared or spectral bands. The
    /// transmittances are relative sensitivities per photon. A white of Y = 1 in XYZ is 1 in the largest response.
    Channels(Vec<Channel>),
}

impl TrainingTarget {
    /// The responses of another camera: its filters and sensor, behind the transmittance and the infrared-cut filter of its own lens.
    /// Sharpness and fall-off are those of the camera that is trained.
    ///
    /// # Errors
    /// When its curves do not match its wavelength grid.
    pub fn channels_of(camera: &Camera) -> Result<Self, CameraError> {
        let curves = camera.responsivities()?;
        let channels = camera.sensor.cfa.channels().iter().zip(curves);
        let channel = |(c, curve): (&Channel, _)| Channel { name: c.name.clone(), transmittance: curve };
        Ok(Self::Channels(channels.map(channel).collect()))
    }
}

/// The rule for the cuts between response levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LevelRule {
    /// Equal ratios from half of the dark noise to nearly saturation.
    #[default]
    Logarithmic,
    /// Equal steps in units of the standard deviation of the noise.
    NoiseSteps,
}

/// Settings for training a pipeline.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrainingSettings {
    /// Side of the patch, pixels: 3, 5, 7, 9 or 11.
    pub side: usize,
    /// Number of response levels.
    pub levels: usize,
    /// The rule for their cuts.
    pub level_rule: LevelRule,
    /// Texture classes.
    pub textures: Textures,
    /// The output.
    pub target: TrainingTarget,
    /// The illuminant of the target, if it differs from that of the capture (illuminant correction).
    pub target_light: Option<Illuminant>,
    /// Whether targets lack the blur of the lens, so that the pipeline learns to sharpen. The pixel area still blurs them.
    pub sharp: bool,
    /// Exposures of each scene: the responses of its 99th percentile, 1 at saturation. When empty, they range from the response at
    /// which white saturates every channel (limited to 1.2 to 3) down to the dark noise, and include 1.
    pub exposures: Vec<f64>,
    /// Seed of the noise for the classification of patches.
    pub seed: u64,
}

impl Default for TrainingSettings {
    fn default() -> Self {
        Self {
            side: 5,
            levels: 10,
            level_rule: LevelRule::default(),
            textures: Textures::Oriented,
            target: TrainingTarget::default(),
            target_light: None,
            sharp: false,
            exposures: Vec::new(),
            seed: 1,
        }
    }
}

impl TrainingSettings {
    /// Whether the targets have optical images of their own.
    pub(crate) fn has_own_images(&self) -> bool {
        self.sharp || self.target_light.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::CameraDescription;
    use crate::sensor::Filter;
    use crate::spectrum::WavelengthGrid;

    #[test]
    fn channels_of_a_camera_lie_behind_its_infrared_cut() {
        let channels = |cut: Option<Filter>| {
            let mut description = CameraDescription::default();
            description.optics.ir_cut = cut;
            let camera = Camera::new(description, WavelengthGrid::default()).unwrap();
            match TrainingTarget::channels_of(&camera).unwrap() {
                TrainingTarget::Channels(channels) => channels,
                TrainingTarget::Xyz => panic!("channels"),
            }
        };
        for (bare, cut) in channels(None).iter().zip(channels(Some(Filter::Flat(0.5)))) {
            assert!(bare.transmittance.max() > 0.1, "{}", bare.name);
            assert_eq!(bare.transmittance.scaled(0.5).unwrap().values(), cut.transmittance.values());
        }
    }
}
