//! The results of a comparison, and what its page states of their origin.

use smalti::camera::{Camera, SceneScores};
use smalti::color::Image;
use smalti::experiment::{
    Contender, Outcome, PairwiseLightGain, PipelineSet, Processing, ScoredScene, Verdict,
};
use smalti::l3::Pipeline;

use super::columns::{COMPARE, COMPARE_PER_PIXEL, Column};
use super::conditions::Conditions;
use crate::words::listed;
use crate::{ReportError, names};

/// The command that made results, for their page.
#[derive(Debug, Clone, Default)]
pub struct CommandLine {
    /// Its words, without the name of the program.
    pub words: Vec<String>,
    /// The cameras as its words name them.
    pub cameras: Vec<CameraArgument>,
}

/// A camera as the words of a command name it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CameraArgument {
    /// The word.
    pub word: String,
    /// Whether it is the name of a built-in camera. Otherwise it is a file.
    pub is_built_in: bool,
}

/// All results of a comparison.
#[derive(Clone, Copy)]
pub struct Comparison<'a> {
    /// The command that made them.
    pub command: &'a CommandLine,
    /// The cameras.
    pub cameras: &'a [Camera],
    /// The label of each camera.
    pub labels: &'a [String],
    /// Each camera with each of its ways of processing.
    pub contenders: &'a [Contender<'a>],
    /// Names of contenders that were left out: their processing is not defined for their camera.
    pub left_out: &'a [String],
    /// For each contender one outcome per luminance.
    pub outcomes: &'a [Vec<Outcome>],
    /// The conditions of the scores.
    pub conditions: Conditions<'a>,
    /// How much more light the first camera needs to equal each other camera. Empty if it was not requested.
    pub gains: &'a [PairwiseLightGain],
    /// The label of each scene.
    pub scene_labels: &'a [String],
    /// Whether each scene keeps its own light.
    pub own_light: &'a [bool],
    /// The light of the other scenes, of the chart and the edge, as the command names it.
    pub illuminant: &'a str,
    /// The first seed of the noise.
    pub seed: u64,
    /// Who is better at which light.
    pub verdict: &'a Verdict,
}

/// The cells that name a contender and a luminance.
pub(super) fn of_contender(contender: &Contender<'_>, luminance_cd_m2: f64) -> [String; 3] {
    [contender.label.to_owned(), contender.method(), luminance_cd_m2.to_string()]
}

impl<'a> Comparison<'a> {
    /// The outcomes of the first contender, one per luminance. Every contender has the same luminances and scenes.
    pub(super) fn lights(&self) -> &'a [Outcome] {
        self.outcomes.first().map_or(&[], Vec::as_slice)
    }

    /// Whether the cameras have the same pixel pitch.
    pub(super) fn has_one_pitch(&self) -> bool {
        let mut pitches = self.cameras.iter().map(|c| c.sensor.pixel.pitch_m);
        pitches.next().is_none_or(|first| pitches.all(|pitch| (pitch / first - 1.0).abs() < 1e-6))
    }

    /// The columns of the scores.
    pub(super) fn columns(&self) -> &'static [Column<Outcome>] {
        if self.has_one_pitch() { &COMPARE } else { &COMPARE_PER_PIXEL }
    }

    /// Each contender with its outcome in one light.
    pub(super) fn in_light(&self, light: usize) -> impl Iterator<Item = (&'a Contender<'a>, &'a Outcome)> {
        let of = move |(contender, outcomes): (_, &'a Vec<Outcome>)| Some((contender, outcomes.get(light)?));
        self.contenders.iter().zip(self.outcomes).filter_map(of)
    }

    /// Each contender with its scores of a scene in one light.
    pub(super) fn of_scene(
        &self,
        light: usize,
        scene: usize,
    ) -> impl Iterator<Item = (&'a Contender<'a>, &'a ScoredScene)> {
        self.in_light(light).filter_map(move |(contender, o)| Some((contender, &o.scenes.get(scene)?.1)))
    }

    /// Luminances that were compared.
    pub(super) fn light_count(&self) -> usize {
        self.lights().len()
    }

    /// These luminances, cd/m².
    pub(super) fn luminances(&self) -> Vec<f64> {
        self.lights().iter().map(|o| o.luminance_cd_m2).collect()
    }

    /// The scenes, as [`scene::catalog`](smalti::scene::catalog) takes them, or files.
    pub(super) fn scene_names(&self) -> String {
        let scenes = self.lights().first().into_iter().flat_map(|o| &o.scenes);
        scenes.map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ")
    }

    /// Scenes that were compared on.
    pub(super) fn scene_count(&self) -> usize {
        self.lights().first().map_or(0, |o| o.scenes.len())
    }

    /// All learned tables with the names of their files. A table for a light other than that of the comparison is named after it.
    #[must_use]
    pub fn tables(&self) -> Vec<(String, &'a Pipeline)> {
        let of_camera = |(contender, _, _): (&'a Contender<'a>, _, _)| {
            let all = contender.pipelines.into_iter().flat_map(PipelineSet::iter);
            all.enumerate().map(move |(i, lit)| match i {
                0 => (contender.label.to_owned(), &lit.pipeline),
                _ => (format!("{}-{}", contender.label, lit.illuminant.name()), &lit.pipeline),
            })
        };
        let (wanted, tables): (Vec<String>, Vec<_>) = self.learned().into_iter().flat_map(of_camera).unzip();
        let files = names::file_names(wanted.iter().map(String::as_str));
        files.into_iter().map(|file| format!("{file}.l3")).zip(tables).collect()
    }

    /// The learned ways with their pipelines for the light of the comparison and the names of their files, without extension.
    #[must_use]
    pub fn learned(&self) -> Vec<(&'a Contender<'a>, &'a Pipeline, String)> {
        let learned: Vec<&'a Contender<'a>> =
            self.contenders.iter().filter(|c| c.processing == Processing::L3).collect();
        let files = names::file_names(learned.iter().map(|c| c.label));
        learned.into_iter().zip(files).filter_map(|(c, file)| Some((c, c.pipelines?.main(), file))).collect()
    }

    /// What the scores are means over, in words.
    #[must_use]
    pub fn over(&self) -> String {
        let count = |n: usize, one: &str| if n == 1 { format!("one {one}") } else { format!("{n} {one}s") };
        match (self.verdict.scenes, self.verdict.seeds) {
            (1, 1) => "scores of one scene".into(),
            (scenes, seeds) => format!("means over {} and {}", count(scenes, "scene"), count(seeds, "seed")),
        }
    }

    /// The light of the scenes in words.
    pub(super) fn light_words(&self) -> String {
        let own: Vec<String> = self
            .scene_labels
            .iter()
            .zip(self.own_light)
            .filter(|(_, own)| **own)
            .map(|(s, _)| s.clone())
            .collect();
        match own.len() {
            0 => self.illuminant.to_owned(),
            n if n == self.scene_labels.len() => {
                format!("that of each scene; {} on chart and edge", self.illuminant)
            }
            _ => format!("{}; {} keep their own", self.illuminant, listed(&own)),
        }
    }

    /// The seeds of the noise in words.
    pub(super) fn seed_words(&self) -> String {
        match self.verdict.seeds {
            0 | 1 => format!("seed {}", self.seed),
            n => format!("seeds {} to {}", self.seed, self.seed.saturating_add(n as u64 - 1)),
        }
    }

    /// The label of a scene.
    pub(super) fn scene_label(&self, scene: usize) -> &'a str {
        self.scene_labels.get(scene).map_or("", String::as_str)
    }

    /// A picture of a scored scene as shown on a screen: white is that of the reference.
    pub(super) fn as_seen(&self, scores: &SceneScores, picture: &Image) -> Result<Image, ReportError> {
        Ok(picture.shown(Some(scores.white), 1.0 / scores.scores.white_y)?)
    }
}
