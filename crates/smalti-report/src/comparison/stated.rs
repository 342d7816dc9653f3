//! What the report of a comparison states besides its outcomes.

use smalti::camera::{Camera, TestScene};
use smalti::experiment::{
    CameraDifference, Compared, ComparisonSettings, Contender, ExperimentError, IspKeys, Processing,
    camera_differences,
};

use super::conditions::Conditions;
use super::results::{CommandLine, Comparison};

/// What the report of a comparison states besides its outcomes, made from the same input by `smalti compare`, a proof and the studio.
pub struct Stated<'a> {
    all: (&'a [Camera], &'a [String]),
    contenders: &'a [Contender<'a>],
    settings: &'a ComparisonSettings,
    /// The cameras that are compared; others were left out.
    cameras: Vec<Camera>,
    labels: Vec<String>,
    differences: Vec<CameraDifference>,
    scene_labels: Vec<String>,
    own_light: Vec<bool>,
    illuminant: String,
}

impl<'a> Stated<'a> {
    /// Collects it from cameras with their labels, the contenders that are made of them, and the settings of the comparison. `scene_label` names a scene.
    ///
    /// # Errors
    /// When the descriptions of the cameras cannot be compared.
    pub fn new(
        all: (&'a [Camera], &'a [String]),
        contenders: &'a [Contender<'a>],
        settings: &'a ComparisonSettings,
        scene_label: impl Fn(&str) -> String,
    ) -> Result<Self, ExperimentError> {
        let is_compared = |label: &String| contenders.iter().any(|c| c.label == label);
        let (cameras, labels): (Vec<Camera>, Vec<String>) =
            all.0.iter().cloned().zip(all.1.iter().cloned()).filter(|(_, label)| is_compared(label)).unzip();
        let learned_only = contenders.iter().all(|c| c.processing == Processing::L3);
        let isp = if learned_only { IspKeys::Unused } else { IspKeys::ColorMatrix };
        Ok(Self {
            differences: camera_differences(&cameras, isp)?,
            scene_labels: settings.scenes.iter().map(|s| scene_label(s.name())).collect(),
            own_light: settings.scenes.iter().map(TestScene::keeps_light).collect(),
            illuminant: settings.illuminant.name(),
            all,
            contenders,
            settings,
            cameras,
            labels,
        })
    }

    /// The name of the illuminant in the report, where it is not that of the settings: the words of a command may name a file.
    #[must_use]
    pub fn with_illuminant(self, name: &str) -> Self {
        Self { illuminant: name.to_owned(), ..self }
    }

    /// The report of a comparison, without light gains. `left_out` has the names of contenders whose processing is not
    /// defined for their camera.
    #[must_use]
    pub fn report(
        &'a self,
        command: &'a CommandLine,
        left_out: &'a [String],
        compared: &'a Compared,
    ) -> Comparison<'a> {
        Comparison {
            command,
            cameras: self.all.0,
            labels: self.all.1,
            contenders: self.contenders,
            left_out,
            outcomes: &compared.outcomes,
            conditions: Conditions {
                exposure: compared.exposure.applied(),
                cameras: &self.cameras,
                differences: &self.differences,
                limiting: compared.exposure.limiting(),
                labels: &self.labels,
            },
            gains: &[],
            scene_labels: &self.scene_labels,
            own_light: &self.own_light,
            illuminant: &self.illuminant,
            seed: self.settings.seed,
            verdict: &compared.verdict,
        }
    }
}
