//! The command line, as typed.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use smalti_io::Override;

/// A camera simulator that designs colour filter arrays and their image processing together.
#[derive(Debug, Parser)]
#[command(
    name = "smalti",
    version,
    arg_required_else_help = true,
    after_help = "Examples:\n  \
        smalti simulate bayer -o out                        a picture of the default scene\n  \
        smalti simulate my.toml --scene zone-plate -o out   your camera, another scene\n  \
        smalti evaluate bayer rgbw                          colour, resolution, noise, aliasing\n  \
        smalti list cfas                                    what is built in\n\n\
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
    /// Take one picture: raw.dng, rendered.png, metrics.json
    Simulate(Simulate),
    /// Score cameras on the built-in targets: colour, resolution, noise, aliasing
    Evaluate(Evaluate),
    /// List what is built in
    List(List),
    /// Convert a scene between formats, or write a built-in scene to a file
    Convert(Convert),
    /// Print a script for tab completion
    #[command(after_help = "Examples:\n  \
        smalti completions bash > ~/.local/share/bash-completion/completions/smalti\n  \
        smalti completions zsh > ~/.zfunc/_smalti\n  \
        smalti completions fish > ~/.config/fish/completions/smalti.fish")]
    Completions {
        /// For which shell
        shell: clap_complete::Shell,
    },
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

/// What a scene is when its file or name does not say.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct SceneOptions {
    /// Mean luminance, cd/m² [default: what the scene states, else 100]
    #[arg(long, value_name = "CD_M2", allow_negative_numbers = true)]
    pub(crate) luminance: Option<f64>,
    /// Distance from the lens, m
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub(crate) distance: Option<f64>,
    /// Horizontal field of view, degrees [default: the scene fills the sensor]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    pub(crate) fov: Option<f64>,
    /// Light of the scene: a name (smalti list illuminants) or a CSV of wavelength_nm and relative power; files are re-lit
    #[arg(long, value_name = "NAME")]
    pub(crate) illuminant: Option<String>,
    /// Wavelengths, nm [default: those of the file, else 400:10:700]
    #[arg(long, value_name = "START:STEP:END")]
    pub(crate) wavelengths: Option<String>,
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
    /// A built-in scene with parameters, `zone-plate?frequency=0.4` (smalti list scenes), or a file: spectral or RGB
    /// EXR, PNG, TIFF, JPEG
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
    /// Built-in cameras (smalti list cameras) or TOML files
    #[arg(required = true)]
    pub(crate) cameras: Vec<String>,
    /// Mean luminance of the targets, cd/m²; several, separated by commas, are evaluated in turn
    #[arg(long, value_delimiter = ',', default_value = "75", value_name = "CD_M2")]
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
    /// Write results.json and the pictures of the targets to this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  smalti list cfas\n  smalti list scenes --json")]
pub(crate) struct List {
    /// What to list
    #[arg(value_enum)]
    pub(crate) what: Listing,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
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
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti convert macbeth -o macbeth.exr\n  \
    smalti convert photo.png --illuminant A -o lifted.exr\n  \
    smalti convert dead-leaves?seed=7 --wavelengths 400:5:700 -o photons.npy")]
pub(crate) struct Convert {
    /// A built-in scene or a file
    pub(crate) scene: String,
    #[command(flatten)]
    pub(crate) scene_options: SceneOptions,
    /// .exr (spectral), .png or .tif (a picture as the standard observer sees it) or .npy (photons)
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Layout of a spectral EXR
    #[arg(long, value_enum, default_value_t = ExrLayout::Fichet2021)]
    pub(crate) layout: ExrLayout,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExrLayout {
    /// `S0.400,0nm` channels with units (Fichet et al. 2021)
    #[value(name = "fichet2021")]
    Fichet2021,
    /// `Radiance.C01` channels
    #[value(name = "pbrt")]
    Pbrt,
}
