//! Options of `smalti design`.

use std::path::PathBuf;

use clap::Args;

use super::proof_options::ProofOptions;
use crate::learning_args::LearningOptions;
use crate::scene_args::SceneOptions;

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti design pigments-4 -o best                       the best four filters of pigments in 2 × 2\n  \
    smalti compare best/camera.toml bayer --luminance 1,10,80   what they are worth on scenes that were not used\n  \
    smalti design pigments-4 -o best --prove               the same with all published mosaics, as a table and a page\n  \
    smalti design best --prove --proof-patch 5,9           the proof of a finished search, or the rest of one that was stopped\n  \
    smalti design my-design.toml -o mine                   your own camera, pigments, light (smalti list design-keys)\n  \
    smalti design pigments-6 --light best/light/D65.light  the statistics of an earlier design again\n  \
    smalti design --benchmark                              colour filter arrays that this machine screens per second\n\n\
    The search minimises the expected error of the best linear pipeline in closed form. It needs the statistics of the light on the \
    pixels, from the scenes that pipelines learn from, and simulates no picture. The printed figures are such expectations: they rank \
    colour filter arrays as learned pipelines do and are not their scores. DIR holds the camera with the array that was found \
    (camera.toml, filters.csv, mosaic.svg, mosaic.png, camera.l3), the published mosaics with the best filters of the same kind (rivals/), the compromises of a front \
    (front/), the statistics of light (light/), design.html and results.json. After Ctrl-C or a crash, the same command goes on where the search ended.\n\n\
    --prove learns pipelines for the array that was found, for the camera's own and for the published mosaics with the best filters of the \
    same kind, and scores them on scenes that were not used. Its intervals hold together for all rivals, luminances and metrics. \
    Another table has illuminants, f-numbers, deviations of the filters and other scenes. DIR/proof holds the scores (results.json) \
    and the comparison with pictures (comparison/report.html). The cache keeps the scores, so that the same command resumes.")]
pub(crate) struct DesignArgs {
    /// A built-in design (smalti list designs), a TOML file, or with --prove the folder of a finished search
    #[arg(required_unless_present = "benchmark", conflicts_with = "benchmark")]
    pub(crate) design: Option<String>,
    /// Folder for the results, created if needed
    #[arg(short, long, default_value = "design", value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// A scene to gather the statistics of light from instead of the default set, built in or a file; may be given more than once
    #[arg(long = "scene", value_name = "SCENE", conflicts_with = "light")]
    pub(crate) light_scenes: Vec<String>,
    /// Statistics of light that an earlier design wrote (DIR/light/NAME.light) instead of gathering them; several files of one illuminant are merged
    #[arg(long, value_name = "FILE")]
    pub(crate) light: Vec<PathBuf>,
    /// Measure how many colour filter arrays per second this machine screens; write nothing
    #[arg(long)]
    pub(crate) benchmark: bool,
    /// Do not learn a pipeline for the array that was found
    #[arg(long)]
    pub(crate) no_pipeline: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) proof: ProofOptions,
    // Last: the heading would apply to all arguments after it.
    #[command(flatten)]
    pub(crate) learning: LearningOptions,
    #[command(flatten, next_help_heading = "Properties that a --scene does not state")]
    pub(crate) scene_options: SceneOptions,
}
