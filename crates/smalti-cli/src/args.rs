//! The command line, as typed.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use smalti_io::Override;
use smalti_io::dataset::Shard;

use crate::convert::Convert;
use crate::learning_args::LearningOptions;
use crate::scene_args::SceneOptions;
use crate::show::Show;

/// A camera simulator that designs colour filter arrays and their image processing together.
#[derive(Debug, Parser)]
#[command(
    name = "smalti",
    version,
    arg_required_else_help = true,
    after_help = "Examples:\n  \
        smalti compare bayer rgbw --luminance 1,80            learn, render, score: a table and pictures\n  \
        smalti simulate bayer -o out                          a picture of the default scene\n  \
        smalti simulate my.toml --scene zone-plate -o out     your camera, another scene\n  \
        smalti evaluate bayer rgbw                            colour, resolution, noise, aliasing\n  \
        smalti sweep table2 -o study && smalti report study   5000 colour filter arrays, scored and shown\n  \
        smalti list cfas                                      what is built in\n  \
        smalti show rgbw                                      a camera, its mosaic and its spectra, drawn\n\n\
        Results go to standard output or -o, progress and messages to standard error.\n\
        Exit code: 0 done, 1 failed, 2 wrong usage."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) common: Common,
}

/// What every command takes.
#[derive(Debug, Clone, Args)]
pub(crate) struct Common {
    /// Threads to use; results do not depend on it [default: one per core]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// Print nothing but results and errors
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Learn the pipelines of cameras, render the same scenes, score and show them
    Compare(Box<Compare>),
    /// Learn the pipeline of a camera from scenes or from pairs of raw and picture
    Train(Box<Train>),
    /// Render a raw file through a learned pipeline
    Render(Render),
    /// Take one picture: raw.dng, rendered.png, metrics.json
    Simulate(Simulate),
    /// Score cameras on the built-in targets: colour, resolution, noise, aliasing
    Evaluate(Evaluate),
    /// Score the many designs of a study; goes on where it stopped
    Sweep(SweepArgs),
    /// What a study found: tables, best designs, figures
    Report(ReportArgs),
    /// List what is built in
    List(List),
    /// Draw a colour filter array, a camera or a scene in the terminal
    Show(Box<Show>),
    /// Convert a scene between formats, or write a built-in scene to a file
    Convert(Convert),
    /// Print a script for tab completion
    #[command(after_help = "Examples:\n  \
        echo 'source <(smalti completions bash)' >> ~/.bashrc\n  \
        echo 'source <(smalti completions zsh)' >> ~/.zshrc               after compinit\n  \
        smalti completions fish > ~/.config/fish/completions/smalti.fish\n\n\
        The script asks smalti itself, which offers cameras, scenes, lights and studies by name beside files.")]
    Completions {
        /// For which shell
        shell: clap_complete::Shell,
    },
    /// Write a manual page for each command
    #[command(hide = true, after_help = "Examples:\n  smalti man ~/.local/share/man/man1")]
    Man {
        /// Folder, made if need be
        dir: PathBuf,
    },
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti sweep table2 -o study && smalti report study   what more colours cost: 5000 designs\n  \
    smalti sweep my-study.toml -o mine                    your own study; again, after Ctrl-C, to go on\n  \
    smalti sweep my-study.toml --dry-run                  how many designs, how long, how large\n  \
    smalti sweep my-study.toml --shard 3/16 -o mine       one of sixteen machines that share the folder\n  \
    smalti sweep --merge part1 part2 -o mine              folders of shards into one\n\n\
    DIR/designs/*.parquet has a row for each design; pandas, Polars and DuckDB read it as it is.")]
pub(crate) struct SweepArgs {
    /// A built-in study (smalti list studies), a TOML file, or the manifest.json of its results
    #[arg(required_unless_present = "merge", conflicts_with = "merge")]
    pub(crate) study: Option<String>,
    /// Folder for the results, made if need be; one that holds some of them is continued
    #[arg(short, long, default_value = "study", value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Do only the I-th of N parts of the study
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    /// Designs in a file of the results; a killed run loses at most two files' worth [default: by the size of the study]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=smalti_io::dataset::MAX_CHUNK))]
    pub(crate) part_size: Option<u64>,
    /// Say how many designs there are, how long they take and how large the results become; write nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Measure how many designs a second this machine scores; write nothing
    #[arg(long, conflicts_with = "dry_run")]
    pub(crate) benchmark: bool,
    /// Put the results of shards that ran in folders of their own together in the folder of -o
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["shard", "dry_run", "benchmark"])]
    pub(crate) merge: Vec<PathBuf>,
    /// Neither read nor write cached optical images
    #[arg(long)]
    pub(crate) no_cache: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti sweep table2 -o study && smalti report study   what more colours cost: tables and figures\n  \
    smalti report study theory -o both                    filters by rule over the cloud of all filters\n  \
    smalti report study --json > study.json               the same as one document\n  \
    smalti report study -o study.html                     the page alone\n  \
    smalti report study --picture 4711,17                 with the simulator's pictures of these designs\n  \
    smalti report study --camera 4711 > found.toml        a design as a camera for all other commands\n\n\
    ΔE is the mean of the ColorChecker (CIELAB 1976), MTF50 that of a slanted edge in cycles/mm on the sensor, noise that of the \
    luminance of grey patches in percent. The best design of a number of colours is the one of least ΔE among those \
    whose MTF50 is not below the median; where only mosaics differ, that of the largest MTF50.\n\n\
    report.html is one page that needs no network: the designs to brush, filter and look at one by one. Figures are written as SVG \
    and PNG; report.json is removed first and written last: a folder that has it is whole.")]
pub(crate) struct ReportArgs {
    #[command(flatten)]
    pub(crate) of: ReportOptions,
    /// Print the camera file of a design of the first DIR instead, by its number
    #[arg(long, value_name = "DESIGN", conflicts_with_all = ["output", "json"])]
    pub(crate) camera: Option<u64>,
    /// Print report.json instead of the tables
    #[arg(long)]
    pub(crate) json: bool,
}

/// What is reported, and where.
#[derive(Debug, Clone, Args)]
pub struct ReportOptions {
    /// Folders of results (smalti sweep), complete or not
    #[arg(required = true, value_name = "DIR")]
    pub results: Vec<PathBuf>,
    /// Folder for report.html, figures and report.json, made if need be; or FILE.html for the page alone [default: report in the
    /// first DIR]
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// How many designs have pictures in the page by processing that it cannot draw itself (learned pipelines, demosaicking other than
    /// bilinear): the best, the worst, then of the Pareto front
    #[arg(long, default_value_t = 16, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1000))]
    pub pictures: u16,
    /// Designs of the first DIR, by their numbers, whose pictures by the simulator are in the page
    #[arg(long, value_delimiter = ',', value_name = "DESIGN")]
    pub picture: Vec<u64>,
    /// Conditions and processings that get figures of their own: those with TEXT in their name, as the tables give it; may be given
    /// more than once [default: the first 8]
    #[arg(long, value_name = "TEXT")]
    pub draw: Vec<String>,
}

/// Keys of the camera that the command line replaces.
#[derive(Debug, Clone, Args)]
pub(crate) struct CameraOptions {
    /// Replace a key of the camera (of every one); may be given more than once. The unit is in the key
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) overrides: Vec<Override>,
    /// Seed of all noise that changes from capture to capture
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti simulate bayer -o out\n  \
    smalti simulate rgbw --scene macbeth --luminance 5 --illuminant A -o dim\n  \
    smalti simulate my.toml --scene rendered.exr --set sensor.pixel.pitch_um=1.4 --set exposure.time_ms=20\n  \
    smalti simulate bayer --scene photo.png --noise none --stages\n\n\
    metrics.json is removed first and written last: a folder that has it is whole.")]
pub(crate) struct Simulate {
    /// A built-in camera (smalti list cameras) or a TOML file
    pub(crate) camera: String,
    /// A built-in scene with parameters, `zone-plate?frequency=0.4` (smalti list scenes), or a file: spectral or
    /// RGB EXR, ENVI, NumPy, TIFF, PNG, JPEG, or a folder of bands
    #[arg(long, default_value = "resolution-chart")]
    pub(crate) scene: String,
    #[command(flatten)]
    pub(crate) scene_options: SceneOptions,
    #[command(flatten)]
    pub(crate) camera_options: CameraOptions,
    /// Which noise to simulate
    #[arg(long, value_enum, default_value_t = Noise::All)]
    pub(crate) noise: Noise,
    /// Read the whole sensor, also where the scene does not reach
    #[arg(long)]
    pub(crate) full_frame: bool,
    /// Also write every stage as .npy, with its unit
    #[arg(long)]
    pub(crate) stages: bool,
    /// Bits per channel of the picture
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    pub(crate) bits: String,
    /// Format of the picture: rendered.png or rendered.tif
    #[arg(long, value_enum, default_value_t = PictureFormat::Png)]
    pub(crate) format: PictureFormat,
    /// Print metrics.json to standard output as well
    #[arg(long)]
    pub(crate) json: bool,
    /// Folder for the results, made if need be
    #[arg(short, long, default_value = "out", value_name = "DIR")]
    pub(crate) output: PathBuf,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PictureFormat {
    /// PNG
    Png,
    /// TIFF
    Tif,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Noise {
    /// None: expected values
    None,
    /// Photon noise only
    Shot,
    /// All
    All,
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti evaluate bayer rgbw\n  \
    smalti evaluate bayer my.toml --luminance 1,10,100 --illuminant A --json\n  \
    smalti evaluate bayer --set sensor.cfa.pattern=quad-bayer -o quad\n\n\
    Columns of the table, with their units and sources: smalti list metrics.\n\
    results.json is removed first and written last: a folder that has it is whole.")]
pub(crate) struct Evaluate {
    /// The command line, for the page
    #[arg(skip)]
    pub(crate) words: Vec<String>,
    /// Built-in cameras (smalti list cameras) or TOML files
    #[arg(required = true)]
    pub(crate) cameras: Vec<String>,
    /// Mean luminance of the targets, cd/m²; several, separated by commas, are evaluated in turn
    #[arg(long, value_delimiter = ',', default_value = "75", value_name = "CD_M2", value_parser = number)]
    pub(crate) luminance: Vec<f64>,
    /// Light of the targets: a name (smalti list illuminants) or a CSV of wavelength_nm and relative power
    #[arg(long, default_value = "D65", value_name = "NAME")]
    pub(crate) illuminant: String,
    #[command(flatten)]
    pub(crate) camera_options: CameraOptions,
    /// Neither read nor write the cache of optical images ($SMALTI_CACHE_DIR, else the user's cache folder)
    #[arg(long)]
    pub(crate) no_cache: bool,
    /// Print one JSON document instead of the table
    #[arg(long)]
    pub(crate) json: bool,
    /// Write report.html, results.json and the pictures of the targets to this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti list cfas\n  \
    smalti list scenes --json\n  \
    smalti list camera-keys                               what a camera file may say, with defaults\n  \
    smalti list camera-keys --schema > camera.json        for editors that check and complete TOML by a JSON Schema")]
pub(crate) struct List {
    /// What to list
    #[arg(value_enum)]
    pub(crate) what: Listing,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print a page in Markdown, as in docs/reference
    #[arg(long, conflicts_with = "json")]
    pub(crate) markdown: bool,
    /// Print a JSON Schema: of camera-keys and study-keys
    #[arg(long, conflicts_with_all = ["json", "markdown"])]
    pub(crate) schema: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Listing {
    /// Built-in scenes and their parameters
    Scenes,
    /// Colour filter arrays, with their tiles and sources
    Cfas,
    /// Built-in cameras
    Cameras,
    /// Light sources
    Illuminants,
    /// Filter curves
    Filters,
    /// Metrics, with their units
    Metrics,
    /// Studies of many designs, for `smalti sweep`
    Studies,
    /// Keys of a camera file, with their defaults
    CameraKeys,
    /// Keys of a study file, with their defaults
    StudyKeys,
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti compare bayer rgbw --luminance 1,80\n  \
    smalti compare bayer rgbw --luminance 1 --light-gain\n  \
    smalti compare bayer --processing l3,bilinear,malvar2004,adaptive --luminance 1,10,80\n  \
    smalti compare bayer rgbw clarity kodak wang --luminance 1 --scene photo.png -o slides\n\n\
    CPSNR (in XYZ), ΔE2000 and S-CIELAB are means over the pictures of all scenes, MTF50 is that of a slanted edge, visual \
    SNR and noise are those of the grey patches of a chart: smalti list metrics. What is learned is kept in the cache, so that \
    the next comparison takes seconds.\n\n\
    Written: report.html, a page of all that was found; side-by-side/ with a picture for each scene and luminance (the reference, then the cameras in the order of the \
    table) and one with maps of how far each is from the reference (ΔE2000, S-CIELAB), CAMERA.l3 (for smalti render), CAMERA-kernels.png and results.json, which is removed first and written last: a folder that has it is whole.")]
pub(crate) struct Compare {
    /// The command line, for the page
    #[arg(skip)]
    pub(crate) words: Vec<String>,
    /// Built-in cameras (smalti list cameras) or TOML files
    #[arg(required = true)]
    pub(crate) cameras: Vec<String>,
    /// Mean luminance of the scenes, cd/m²; several, separated by commas, are compared in turn
    #[arg(long, value_delimiter = ',', default_value = "1,80", value_name = "CD_M2", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) luminance: Vec<f64>,
    /// A scene to compare on, built in or a file; may be given more than once [default: scenes that nothing is learned from].
    /// The name of one of those alone is that scene, as large as there
    #[arg(long = "scene", value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Light of the scenes; pipelines are learned for it too: a name (smalti list illuminants) or a CSV
    #[arg(long, default_value = "D65", value_name = "NAME")]
    pub(crate) illuminant: String,
    /// Ways of processing, separated by commas
    #[arg(long, value_delimiter = ',', value_enum, default_value = "l3")]
    pub(crate) processing: Vec<Processing>,
    /// Also find how much more light the first camera needs to equal each of the others, in stops, by each metric, with the
    /// first way of processing; takes half a minute and more
    #[arg(long)]
    pub(crate) light_gain: bool,
    /// A learned table (smalti train) to use instead of learning one; as many as there are cameras, in their order
    #[arg(long = "pipeline", value_name = "FILE.l3")]
    pub(crate) pipelines: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) camera_options: CameraOptions,
    /// Neither read nor write the cache of optical images and pipelines ($SMALTI_CACHE_DIR, else the user's cache folder)
    #[arg(long)]
    pub(crate) no_cache: bool,
    /// Print results.json instead of the table
    #[arg(long)]
    pub(crate) json: bool,
    /// Folder for the results, made if need be
    #[arg(short, long, default_value = "out", value_name = "DIR")]
    pub(crate) output: PathBuf,
    // Last: its heading would be that of all that follows.
    #[command(flatten)]
    pub(crate) learning: LearningOptions,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Processing {
    /// The learned pipeline
    L3,
    /// Bilinear demosaicking and a colour matrix, for any mosaic
    Bilinear,
    /// Malvar, He and Cutler 2004 and a colour matrix, for Bayer
    Malvar2004,
    /// Along the smaller gradient (Hamilton and Adams 1997) and a colour matrix, for Bayer
    Adaptive,
}

impl Processing {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::L3 => "l3",
            Self::Bilinear => "bilinear",
            Self::Malvar2004 => "malvar2004",
            Self::Adaptive => "adaptive",
        }
    }
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti train rgbw -o rgbw.l3\n  \
    smalti train my.toml --illuminants A --target-illuminant D65 -o warm.l3       balances tungsten light\n  \
    smalti train bayer --scene forest.exr --scene street.exr -o mine.l3\n  \
    smalti train bayer --statistics half.l3s -o a.l3                             for --continue half.l3s\n  \
    smalti train nikon.toml --pair shot.dng shot.jpg --pair b.dng b.jpg -o nikon.l3\n  \
    smalti train rgbw -o rgbw.l3 --c-header rgbw_isp.h --npz rgbw.npz\n\n\
    Without --scene, --pair or --continue it learns from the default set: dead leaves, charts of patches, gradients, edges, \
    stars, gratings, steps and scenes of high dynamic range, in natural and saturated colours, under daylight, tungsten and LED. Scenes are exposed as \
    --exposures says, whatever their luminance. The table printed tells for each position of the mosaic how many classes \
    occur, and where the kernels of those with too few patches come from.")]
pub(crate) struct Train {
    /// A built-in camera (smalti list cameras) or a TOML file
    pub(crate) camera: String,
    /// A scene to learn from instead of the default set, built in or a file; may be given more than once
    #[arg(long = "scene", value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Lights of the default set, in turn
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "D65,A,LED",
        value_name = "NAME,...",
        conflicts_with = "scenes"
    )]
    pub(crate) illuminants: Vec<String>,
    /// The light that the picture is to be seen under, if not that of the capture: illuminant correction
    #[arg(long, value_name = "NAME")]
    pub(crate) target_illuminant: Option<String>,
    /// What to give: xyz, or a camera (name or TOML) whose channels are to be estimated at every pixel
    #[arg(long, value_name = "TARGET")]
    pub(crate) target: Option<String>,
    /// Exposures of each scene, as the response of its bright end (1: just saturated) [default: from 3 down to the noise]
    #[arg(long, value_delimiter = ',', value_name = "R,...", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) exposures: Vec<f64>,
    /// A raw file (DNG) and the picture that should come of it, of the same shot; may be given more than once. The picture
    /// is laid onto the raw image to a fraction of a pixel: it may be cropped, shifted, or scaled. Raw files hold
    /// their noise and scenes do not, so that one table learns from either
    #[arg(long = "pair", num_args = 2, value_names = ["RAW", "PICTURE"], conflicts_with_all = ["scenes", "target", "target_illuminant"])]
    pub(crate) pairs: Vec<PathBuf>,
    /// Take the pictures of --pair as they lie, pixel by pixel
    #[arg(long, requires = "pairs")]
    pub(crate) no_align: bool,
    /// Go on from statistics that --statistics saved; several are merged
    #[arg(long = "continue", value_name = "FILE")]
    pub(crate) continue_from: Vec<PathBuf>,
    /// Save what has been gathered from all patches, to go on from or to merge later
    #[arg(long, value_name = "FILE")]
    pub(crate) statistics: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) camera_options: CameraOptions,
    /// Also write the table as NumPy arrays
    #[arg(long, value_name = "FILE")]
    pub(crate) npz: Option<PathBuf>,
    /// Also write the table as a C header in fixed point
    #[arg(long, value_name = "FILE")]
    pub(crate) c_header: Option<PathBuf>,
    /// Print every class as JSON instead of the table
    #[arg(long)]
    pub(crate) json: bool,
    /// The learned table (safetensors)
    #[arg(short, long, value_name = "FILE.l3")]
    pub(crate) output: PathBuf,
    #[command(flatten, next_help_heading = "What a --scene is when it does not say")]
    pub(crate) scene_options: SceneOptions,
    // Last: its heading would be that of all that follows.
    #[command(flatten)]
    pub(crate) learning: LearningOptions,
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti render out/raw.dng --pipeline rgbw.l3 -o picture.png\n  \
    smalti render out/raw.dng --pipeline rgbw.l3 -o xyz.npy\n\n\
    A pixel darker or brighter than anything trained is rendered with the nearest class; how many did is said.")]
pub(crate) struct Render {
    /// A raw file (DNG)
    pub(crate) raw: PathBuf,
    /// A learned table (smalti train)
    #[arg(long, value_name = "FILE.l3")]
    pub(crate) pipeline: PathBuf,
    /// .png or .tif (as shown on a screen, sRGB) or .npy (the outputs as they are: X, Y, Z, white diffusers at most Y = 1)
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Compute in fixed point with 16-bit kernels, as an image processor does; raw files of digital numbers only
    #[arg(long)]
    pub(crate) fixed: bool,
    /// Brightness of the picture [default: all but the brightest half percent within the display's range]
    #[arg(long, value_name = "FACTOR", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) gain: Option<f64>,
    /// Bits per channel of the picture
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    pub(crate) bits: String,
    /// Print what was done as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// A number, which what takes it judges.
pub(crate) fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| "expected a number".into())
}

/// A number above zero.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let found = number(text).ok();
    found.filter(|v| v.is_finite() && *v > 0.0).ok_or_else(|| "expected a number above 0".into())
}
