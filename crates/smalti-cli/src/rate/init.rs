//! `smalti rate init`: renders the pictures of an experiment.

use std::path::PathBuf;

use anyhow::ensure;
use clap::Args;
use smalti::camera::ScoreSettings;
use smalti::experiment::{ComparisonSettings, Contender, Progress as _, RatedCondition, rated_scenes};
use smalti::rating::{Question, Schedule};
use smalti_io::ratings::{self, ANSWERS, Condition, LightExperiment, Manifest, Planned};
use smalti_io::test_scenes::scene_label;

use crate::args::Common;
use crate::contest::{Contest, ContestOptions};
use crate::learning_args::LearningOptions;
use crate::numbers::{ensure_distinct, number};
use crate::progress::Progress;
use crate::resolve;

#[derive(Debug, Clone, Args)]
// The usage that clap composes after a mistake would join the two.
#[command(
    override_usage = "smalti rate init [OPTIONS] <CAMERAS>...\n       smalti rate init [OPTIONS] --experiment <NAME>"
)]
#[command(after_help = "Examples:\n  \
    smalti rate init bayer rgbw clarity --luminance 1 --quality best -o trial\n  \
    smalti rate init bayer --processing l3,bilinear,malvar2004 --luminance 1,80 --scene natural-table --scene photo-fig -o methods\n  \
    smalti rate init bayer rgbw --luminance 1 --stops=-1,-0.5,0,0.5,1 -o light\n  \
    smalti rate init --experiment bayer-light -o light\n\n\
    Every camera with every processing at every luminance is a condition, and any two conditions of a scene are compared. With --stops, \
    the first camera is shown in several amounts of light, each against the second one at the stated luminance; the exposure time stays.\n\n\
    All pictures of a scene have the same crop, and each is scaled such that its white has the luminance of the reference's white. Pictures therefore \
    differ in noise, detail and colour but not in brightness. Metrics are those of the cropped pictures.\n\n\
    Output files: pictures/, PNG in sRGB; and experiment.json with the gain, the exposure time and the metrics of each, which is written \
    last, so a folder that contains it is complete.")]
pub(crate) struct Init {
    /// Built-in cameras (smalti list cameras) or TOML files; CAMERA@MOSAIC has another mosaic (smalti list cfas)
    #[arg(required_unless_present = "experiment")]
    pub(crate) cameras: Vec<String>,
    /// A built-in experiment (bayer-light) or a TOML file, which states cameras, light, scenes and ratings
    #[arg(long, value_name = "NAME", conflicts_with_all = ["cameras", "stops", "luminance", "set", "scenes", "ratings"])]
    pub(crate) experiment: Option<String>,
    /// Light of the first camera beyond the luminance, stops, separated by commas: the experiment then finds how much light it needs to
    /// look like the second camera
    #[arg(long, value_delimiter = ',', value_name = "STOPS", value_parser = number, allow_negative_numbers = true)]
    pub(crate) stops: Vec<f64>,
    /// Largest side of a picture, pixels; larger pictures are cropped to their middle
    #[arg(long, value_name = "PX", default_value_t = 320, value_parser = clap::value_parser!(u16).range(32..=4096))]
    pub(crate) side: u16,
    /// Ratings of each observer [default: 40, and with --stops two of each picture]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=10000))]
    pub(crate) ratings: Option<u16>,
    /// Hidden repeats of earlier pairs with the sides exchanged, for each observer
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(0..=1000))]
    pub(crate) repeats: u16,
    /// Traps for each observer: the reference against a coarse picture
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u16).range(0..=1000))]
    pub(crate) traps: u16,
    /// Training pairs before the ratings
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(0..=1000))]
    pub(crate) training: u16,
    /// Pairs between breaks
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub(crate) break_every: u16,
    #[command(flatten)]
    pub(crate) contest: ContestOptions,
    /// Folder for the experiment, created if needed
    #[arg(short, long, default_value = "experiment", value_name = "DIR")]
    pub(crate) output: PathBuf,
    // Last: the heading would apply to all arguments after it.
    #[command(flatten)]
    pub(crate) learning: LearningOptions,
}

impl Init {
    /// The arguments with those of the experiment file.
    fn with(&self, file: LightExperiment) -> Self {
        let LightExperiment { varied, standard, luminance_cd_m2, stops, scenes, ratings, .. } = file;
        let contest = ContestOptions { luminance: vec![luminance_cd_m2], scenes, ..self.contest.clone() };
        let ratings = Some(ratings.min(usize::from(u16::MAX)) as u16);
        Self { cameras: vec![varied, standard], stops, ratings, contest, ..self.clone() }
    }
}

pub(super) fn run(args: &Init, words: &[String], common: &Common) -> anyhow::Result<()> {
    let (mut about, mut own) = (None, None);
    if let Some(name) = &args.experiment {
        let file = ratings::load(name).map_err(|e| anyhow::anyhow!("{e}"))?;
        about = Some(file.about.clone());
        own = Some(args.with(file));
    }
    let args = own.as_ref().unwrap_or(args);
    ensure_distinct("--stops", &args.stops)?;
    ensure!(
        args.stops.is_empty()
            || (args.cameras.len() == 2
                && args.contest.luminance.len() == 1
                && args.contest.processing.len() == 1),
        "--stops compares two cameras with one processing at one --luminance; expected such arguments"
    );
    ensure!(args.stops.len() != 1, "--stops: one amount of light is given; expected several");
    ensure!(
        !args.output.join(ANSWERS).exists(),
        "{}: it has answers of observers, which belong to its pictures; expected another folder",
        args.output.display()
    );
    let options = &args.contest;
    let seed = options.camera_options.seed;
    let (cache, progress) = (resolve::cache(options.no_cache)?, Progress::new(0, common.quiet));
    let resources = args.learning.resources(&cache, &progress);
    let contest = options.resolve(&args.cameras, &args.learning, &args.output, resources, common)?;
    let Contest { scenes, illuminant, .. } = &contest;
    let (contenders, _) = contest.contenders(&options.processing, &progress)?;
    let (question, rated) = conditions(args, &contenders);
    ensure!(
        rated.len() > 1,
        "there is only one condition; expected two or more cameras, processing methods or luminances"
    );
    let settings = ComparisonSettings {
        luminances_cd_m2: options.luminance.clone(),
        illuminant: illuminant.clone(),
        scenes: scenes.clone(),
        seed,
        seed_count: 1,
        score: ScoreSettings::default(),
        exposure: options.exposure.policy(),
    };
    contest.pipelines.learn_rest(resources)?;
    let mut pictures = rated_scenes(&contenders, &rated, usize::from(args.side), &settings, resources)?;
    for scene in &mut pictures {
        scene.name = scene_label(&scene.name);
    }
    progress.begin("writing");
    let levels = rated.len() - usize::from(question != Question::Scale);
    let ratings = match (args.ratings, question) {
        (Some(ratings), _) => usize::from(ratings),
        (None, Question::Scale) => 40,
        (None, Question::Light { .. }) => 2 * levels * pictures.len(),
    };
    let names: Vec<String> = contenders.iter().map(Contender::name).collect();
    let planned = Planned {
        title: about.unwrap_or_else(|| format!("{} rated", names.join(", "))),
        command: words.to_vec(),
        question,
        schedule: Schedule {
            ratings,
            repeats: usize::from(args.repeats),
            traps: usize::from(args.traps),
            training: usize::from(args.training),
            break_every: usize::from(args.break_every),
        },
        seed,
        conditions: rated.iter().map(|c| described(c, &contenders, options)).collect(),
    };
    let manifest = ratings::write(&args.output, &planned, &pictures)?;
    progress.finish();
    crate::print(&summary(&manifest, args))
}

/// What is asked, and the conditions.
fn conditions(args: &Init, contenders: &[Contender<'_>]) -> (Question, Vec<RatedCondition>) {
    if args.stops.is_empty() {
        let lights = args.contest.luminance.len();
        let of =
            |contender: usize| (0..lights).map(move |light| RatedCondition { contender, light, stops: 0.0 });
        return (Question::Scale, (0..contenders.len()).flat_map(of).collect());
    }
    let standard = RatedCondition { contender: 1, light: 0, stops: 0.0 };
    let varied = args.stops.iter().map(|&stops| RatedCondition { contender: 0, light: 0, stops });
    (Question::Light { standard: 0 }, std::iter::once(standard).chain(varied).collect())
}

fn described(
    condition: &RatedCondition,
    contenders: &[Contender<'_>],
    options: &ContestOptions,
) -> Condition {
    let contender = &contenders[condition.contender];
    let luminance_cd_m2 = options.luminance[condition.light];
    let more = if condition.stops == 0.0 {
        String::new()
    } else {
        format!(" {:+} stops", condition.stops).replace('-', "−")
    };
    Condition {
        name: format!("{} at {luminance_cd_m2} cd/m²{more}", contender.name()),
        camera: contender.label.to_owned(),
        processing: contender.method(),
        luminance_cd_m2,
        stops: condition.stops,
    }
}

fn summary(manifest: &Manifest, args: &Init) -> String {
    let dir = args.output.display();
    let counted = |count: usize, one: &str| format!("{count} {one}{}", if count == 1 { "" } else { "s" });
    format!(
        "{} on {}; {} for each observer\nsmalti rate serve {dir} shows them; {dir}/{} describes them\n",
        counted(manifest.conditions.len(), "condition"),
        counted(manifest.scenes.len(), "scene"),
        counted(manifest.schedule.trials(), "pair"),
        ratings::MANIFEST,
    )
}
