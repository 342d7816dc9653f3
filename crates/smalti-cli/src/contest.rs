//! What commands that render scenes with cameras share: their arguments, and what these mean.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use smalti::camera::{Camera, TestScene};
use smalti::experiment::{
    Contender, PipelineTask, Pipelines, Processing, Progress as _, Resources, contenders, ensure_any_defined,
    other_wavelengths_note, scene_lights, without_infrared,
};
use smalti::isp::Demosaic;
use smalti::spectrum::Illuminant;
use smalti_io::test_scenes::{TestSet, test_scene};
use smalti_io::write;
use smalti_report::names;

use crate::args::{CameraOptions, Common, choice, word_of};
use crate::exposure_args::ExposureOptions;
use crate::learning_args::LearningOptions;
use crate::numbers::{ensure_distinct, positive};
use crate::output::note;
use crate::progress::Progress;
use crate::resolve;

/// The options of cameras on scenes.
#[derive(Debug, Clone, Args)]
pub(crate) struct ContestOptions {
    /// Mean luminance of the scenes, cd/m²; one or several, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "1,80", value_name = "CD_M2", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) luminance: Vec<f64>,
    /// The set of test scenes. None is used for training
    #[arg(long = "scenes", value_name = "SET", value_parser = choice(&TestSet::NAMED), default_value = word_of(&TestSet::NAMED, &TestSet::default()), conflicts_with = "scenes")]
    pub(crate) set: TestSet,
    /// A scene to compare on instead of a set, built in or a file; may be given more than once. A chart named
    /// without parameters has the size that it has in the set `charts`
    #[arg(long = "scene", value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Illuminant of charts, files and targets, and of the training for them: a name (smalti list illuminants) or a CSV. Natural
    /// scenes keep their own light, and each light has a pipeline of its own
    #[arg(long, default_value = DEFAULT_LIGHT, value_name = "NAME")]
    pub(crate) illuminant: String,
    /// Processing methods, separated by commas
    #[arg(long, value_delimiter = ',', value_parser = processing(), default_value = "l3")]
    pub(crate) processing: Vec<Processing>,
    /// A learned table (smalti train) to use instead of training; one for each camera, in their order
    #[arg(long = "pipeline", value_name = "FILE.l3")]
    pub(crate) pipelines: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) exposure: ExposureOptions,
    #[command(flatten)]
    pub(crate) camera_options: CameraOptions,
    /// Do not use the cache of optical images and pipelines ($SMALTI_CACHE_DIR, else the user's cache folder)
    #[arg(long)]
    pub(crate) no_cache: bool,
}

/// Parses the names of processing methods, including a former name.
fn processing() -> impl TypedValueParser<Value = Processing> {
    let value = |p: Processing| {
        let value = PossibleValue::new(p.name());
        match p {
            Processing::L3 => value.help("The learned pipeline"),
            Processing::Classic(Demosaic::Malvar2004) => {
                value.help("Malvar, He and Cutler 2004 with a colour matrix, for Bayer mosaics")
            }
            Processing::Classic(Demosaic::HamiltonAdams1997) => value
                .alias("adaptive")
                .help("Hamilton and Adams 1997 with a colour matrix, for Bayer mosaics"),
            Processing::Classic(_) => {
                value.help("Bilinear demosaicking with a colour matrix, for any mosaic")
            }
        }
    };
    PossibleValuesParser::new(Processing::all().into_iter().map(value)).try_map(|typed| {
        let typed = if typed == "adaptive" { "hamilton-adams1997" } else { &typed };
        Processing::all().into_iter().find(|p| p.name() == typed).ok_or("unknown processing")
    })
}

/// The illuminant of a comparison where none is stated.
const DEFAULT_LIGHT: &str = "D65";

/// Cameras on scenes, with their pipelines.
pub(crate) struct Contest {
    pub(crate) cameras: Vec<Camera>,
    /// The unique name of each camera.
    pub(crate) labels: Vec<String>,
    pub(crate) scenes: Vec<TestScene>,
    pub(crate) illuminant: Illuminant,
    /// Those for lights other than that of the targets may be still to be learned.
    pub(crate) pipelines: Pipelines,
}

impl ContestOptions {
    /// Resolves cameras and scenes and begins to learn pipelines. `output` is the folder that will be written.
    pub(crate) fn resolve(
        &self,
        cameras: &[String],
        learning: &LearningOptions,
        output: &Path,
        resources: Resources<'_>,
        common: &Common,
    ) -> anyhow::Result<Contest> {
        let illuminant = resolve::illuminant(&self.illuminant, common)?;
        let cameras = resolve::cameras(cameras, &self.camera_options, &illuminant, common)?;
        ensure_distinct("--luminance", &self.luminance)?;
        ensure_distinct("--scene", &self.scenes)?;
        ensure_any_defined(&cameras, &self.processing)?;
        let labels = names::numbered(cameras.iter().map(|c| c.description().name.clone()).collect());
        if self.pipelines.is_empty() {
            resolve::note_identical(&cameras, &labels, common);
        }
        self.exposure.note().iter().for_each(|text| note(text, common));
        write::ensure_can_fill(output)?;
        let (settings, training) = (learning.settings(self.camera_options.seed), learning.training());
        let given = resolve::pipelines(&self.pipelines, cameras.len())?;
        resolve::ensure_tables_fit(&self.pipelines, cameras.iter().zip(&given))?;
        let scenes = self.test_scenes(&illuminant)?;
        let lights = scene_lights(&illuminant, &scenes)?;
        let with_table = cameras.iter().zip(&labels).zip(&given).filter(|(_, table)| table.is_some());
        for ((camera, label), _) in with_table {
            if let Some(text) = other_wavelengths_note(camera, &lights) {
                note(&format!("{label}: {text}"), common);
            }
        }
        if self.illuminant != DEFAULT_LIGHT && scenes.iter().all(TestScene::keeps_light) {
            note(
                &format!(
                    "every scene keeps its own light; {} illuminates the chart and the edge alone",
                    self.illuminant
                ),
                common,
            );
        }
        without_infrared(&cameras, &scenes, &illuminant)?.iter().for_each(|text| note(text, common));
        let policy = self.exposure.policy();
        policy.ensure_targets_show_something(&cameras, &labels, &self.luminance, &illuminant, resources)?;
        let task = PipelineTask {
            given,
            processing: &self.processing,
            ..PipelineTask::learned((&cameras, &labels), (&settings, &training), &lights)
        };
        let pipelines = Pipelines::begin(task, resources)?;
        Ok(Contest { cameras, labels, scenes, illuminant, pipelines })
    }

    /// The scenes of the command line, else those of the set.
    fn test_scenes(&self, illuminant: &Illuminant) -> anyhow::Result<Vec<TestScene>> {
        if self.scenes.is_empty() {
            return Ok(self.set.scenes(illuminant)?);
        }
        Ok(self.scenes.iter().map(|name| test_scene(name, illuminant)).collect::<Result<_, _>>()?)
    }
}

impl Contest {
    /// Every camera with every kind of processing, and the names of those that are left out. Notes tell of them.
    pub(crate) fn contenders(
        &self,
        processing: &[Processing],
        progress: &Progress,
    ) -> anyhow::Result<(Vec<Contender<'_>>, Vec<String>)> {
        let (contenders, left_out) =
            contenders(&self.cameras, &self.labels, self.pipelines.sets(), processing)?;
        for name in &left_out {
            progress.note(&format!(
                "{name} is left out, since the method is defined for Bayer mosaics only; l3 and bilinear are defined for any mosaic"
            ));
        }
        contenders.iter().filter_map(Contender::other_than_green).for_each(|text| progress.note(&text));
        Ok((contenders, left_out))
    }
}
