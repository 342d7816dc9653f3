//! Options of the proof of a design.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use smalti_io::test_scenes::TestSet;

use crate::args::{choice, word_of};

/// Options of the proof of a design.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Proof")]
pub(crate) struct ProofOptions {
    /// Score the array with learned pipelines against its rivals, on scenes that were not used for the search
    #[arg(long)]
    pub(crate) prove: bool,
    /// Number of published mosaics to score, the best by expected cost first [default: all]
    #[arg(long, value_name = "N", requires = "prove")]
    pub(crate) rivals: Option<usize>,
    /// Sides of the patches of the pipelines of the proof, separated by commas
    #[arg(long, value_name = "PX", value_delimiter = ',', default_value = "5", requires = "prove", value_parser = sides())]
    pub(crate) proof_patch: Vec<usize>,
    /// The set of test scenes of the proof. None is used for training or for the statistics
    #[arg(long = "scenes", value_name = "SET", value_parser = choice(&TestSet::NAMED), default_value = word_of(&TestSet::NAMED, &TestSet::default()), conflicts_with = "scenes")]
    pub(crate) set: TestSet,
    /// A scene for the proof instead of a set, built in or a file; may be given more than once
    #[arg(long = "proof-scene", value_name = "SCENE", requires = "prove")]
    pub(crate) scenes: Vec<String>,
    /// Number of noise realisations of each scene
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub(crate) seeds: u64,
    /// Omit the table of other illuminants, f-numbers, deviations of the filters and scenes
    #[arg(long, requires = "prove")]
    pub(crate) no_robustness: bool,
    /// Do not use the cache of scores, pipelines and optical images ($SMALTI_CACHE_DIR, else the user's cache folder)
    #[arg(long, requires = "prove")]
    pub(crate) no_cache: bool,
}

/// Parses the side of a patch.
fn sides() -> impl TypedValueParser<Value = usize> {
    PossibleValuesParser::new(["3", "5", "7", "9", "11"]).try_map(|side| side.parse::<usize>())
}
