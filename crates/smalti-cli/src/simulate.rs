//! `smalti simulate`: one capture, from the scene to the picture.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use serde_json::json;
use smalti::camera::{Camera, Photograph, ScoreSettings};
use smalti::experiment::{
    FieldOfView, PreparedCapture, Progress as _, ScoredWindow, Simulation, SimulationSettings, displayed,
    simulate,
};
use smalti::scene::Scene;
use smalti::sensor::{NoiseMode, RawImage, RawSamples};
use smalti::spectrum::SpectralCube;
use smalti_io::cameras::LoadedCamera;
use smalti_io::dng::{self, DngInfo};
use smalti_io::l3;
use smalti_io::picture::{self, Depth};
use smalti_io::stages::{self, write_stage};
use smalti_io::{memory, write};

use crate::args::{CameraOptions, Choice, Common, choice};
use crate::progress::Progress;
use crate::resolve;
use crate::scene_args::SceneOptions;

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti simulate bayer -o out\n  \
    smalti simulate rgbw --scene macbeth --luminance 5 --illuminant A -o dim\n  \
    smalti simulate my.toml --scene rendered.exr --set sensor.pixel.pitch_um=1.4 --set exposure.time_ms=20\n  \
    smalti simulate bayer --scene photo.png --noise none --stages\n  \
    smalti simulate bayer@quad-bayer -o quad\n  \
    smalti simulate rgbw --pipeline rgbw.l3 --luminance 1 -o learned\n\n\
    metrics.json is removed first and written last, so a folder that contains it is complete.")]
pub(crate) struct Simulate {
    /// A built-in camera (smalti list cameras) or a TOML file; CAMERA@MOSAIC has another mosaic (smalti list cfas)
    pub(crate) camera: String,
    /// A built-in scene, with parameters as in `zone-plate?frequency=0.4` (smalti list scenes), or a file: spectral or
    /// RGB EXR, ENVI, NumPy, TIFF, PNG, JPEG, or a folder of bands
    #[arg(long, default_value = "resolution-chart")]
    pub(crate) scene: String,
    #[command(flatten)]
    pub(crate) scene_options: SceneOptions,
    #[command(flatten)]
    pub(crate) camera_options: CameraOptions,
    /// A learned table (smalti train) that renders the picture, instead of the camera's own processing. The scene is resampled to the
    /// wavelengths of the camera, unless --wavelengths states others
    #[arg(long, value_name = "FILE.l3")]
    pub(crate) pipeline: Option<PathBuf>,
    /// Noise to simulate
    #[arg(long, default_value = "all", value_parser = choice(&NOISES))]
    pub(crate) noise: NoiseMode,
    /// Read out the whole sensor, also where the scene does not cover it
    #[arg(long)]
    pub(crate) full_frame: bool,
    /// Also write every stage of the light path as .npy, with its unit in stages.json
    #[arg(long)]
    pub(crate) stages: bool,
    /// Bits per channel of the picture
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    pub(crate) bits: String,
    /// Format of the picture: rendered.png or rendered.tif
    #[arg(long, default_value = "png", value_parser = choice(&PICTURES))]
    pub(crate) format: &'static str,
    /// Print metrics.json to standard output as well
    #[arg(long)]
    pub(crate) json: bool,
    /// Folder for the results, created if needed
    #[arg(short, long, default_value = "out", value_name = "DIR")]
    pub(crate) output: PathBuf,
}

/// Names of the picture.
const PICTURES: [Choice<&str>; 2] = [("png", "PNG", "rendered.png"), ("tif", "TIFF", "rendered.tif")];

/// Noise, by its names here and in metrics.json.
const NOISES: [Choice<NoiseMode>; 3] = [
    ("none", "No noise: expected values", NoiseMode::None),
    ("shot", "Photon noise only", NoiseMode::PhotonOnly),
    ("all", "All noise", NoiseMode::All),
];

/// Names of the files of `--stages`, in the order of the light path.
const STAGES: [&str; 4] = ["1-scene-radiance", "2-optical-image-irradiance", "3-raw", "4-picture-xyz"];

pub(crate) fn run(args: &Simulate, common: &Common) -> anyhow::Result<()> {
    // The steps of this function: reading the scene, and writing.
    let progress = Progress::new(2, common.quiet);
    progress.begin("scene");
    write::ensure_can_fill(&args.output)?;
    let LoadedCamera { camera, notes, .. } = resolve::camera(&args.camera, &args.camera_options)?;
    notes.iter().for_each(|note| progress.note(note));
    let pipeline = args.pipeline.as_ref().map(|file| l3::read_table(file)).transpose()?;
    let scene = resolve::scene_for(&args.scene, &args.scene_options, &camera, common)?;
    // A table is for the wavelengths of the camera. At others, the brightest channel responds more or less to white, so that picture and reference differ in scale.
    let scene = match (&pipeline, &args.scene_options.wavelengths) {
        (Some(_), None) => {
            scene.resampled(camera.grid()).with_context(|| format!("{} (--pipeline)", args.scene))?
        }
        _ => scene,
    };
    let field_of_view = match (args.scene_options.states_fov(&args.scene), resolve::is_file(&args.scene)) {
        (true, _) => FieldOfView::Stated,
        (false, true) => FieldOfView::FittedFile,
        (false, false) => FieldOfView::Fitted,
    };
    let PreparedCapture { camera, scene, notes } =
        PreparedCapture::new(&camera, scene, field_of_view, args.full_frame)?;
    for text in notes {
        progress.note(&format!("{}: {text}", camera.description().name));
    }
    progress.done();
    let facts = json!({
        "name": args.scene,
        "mean_luminance_cd_m2": scene.mean_luminance_cd_m2()?,
        "distance_m": scene.distance_m(),
        "horizontal_fov_deg": scene.horizontal_fov_deg(),
    });
    let light = scene.illuminant().clone();
    let kept = args.stages.then(|| scene.clone());
    let settings = SimulationSettings {
        noise: args.noise,
        seed: args.camera_options.seed,
        score: ScoreSettings::default(),
    };
    let about_table = || match &args.pipeline {
        Some(file) => format!("{} with {}", args.camera, file.display()),
        None => args.camera.clone(),
    };
    let Simulation { photograph: photo, score } =
        simulate((&camera, pipeline.as_ref()), scene, &settings, &progress, memory::available_bytes())
            .with_context(about_table)?;
    progress.begin("writing");
    // All results are computed before the first file is written.
    let (picture, gain) = displayed(&camera, &photo)?;
    let info = DngInfo::of_camera(&camera, &light)?;
    let metrics = metrics(args, &camera, facts, &photo, gain, score, &settings.score)?;
    let text = serde_json::to_string_pretty(&metrics)? + "\n";
    let dir = &args.output;
    let depth = if args.bits == "16" { Depth::Sixteen } else { Depth::Eight };
    let rendered = dir.join(args.format);
    // metrics.json marks a complete folder: it is removed first and written last.
    let earlier = STAGES.map(|stage| format!("{stage}.npy"));
    let earlier = earlier.iter().map(String::as_str).chain(["metrics.json", stages::INDEX]);
    write::begin_folder(dir, &earlier.collect::<Vec<_>>())?;
    picture::write(&rendered, &picture, depth)?;
    dng::write(&dir.join("raw.dng"), &photo.raw, &info)?;
    if let Some(scene) = &kept {
        write_scene(dir, scene)?;
        write_stages(dir, &photo)?;
    }
    write::bytes(&dir.join("metrics.json"), text.as_bytes())?;
    progress.finish();
    if args.json {
        return crate::output::print_document(&text);
    }
    let others = if args.stages { "raw.dng, metrics.json, stages.json" } else { "raw.dng, metrics.json" };
    crate::print(&format!("{}  ({others} in the same folder)\n", rendered.display()))
}

fn metrics(
    args: &Simulate,
    camera: &Camera,
    scene: serde_json::Value,
    photo: &Photograph,
    gain: f64,
    score: Option<ScoredWindow>,
    settings: &ScoreSettings,
) -> anyhow::Result<serde_json::Value> {
    let mean = |values: &[f32]| values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
    let lux = photo.optical_image.illuminance_lux()?;
    let levels = photo.raw.normalized();
    let scored = |s: &ScoredWindow| json!({"row": s.window.row, "col": s.window.col, "rows": s.window.rows, "cols": s.window.cols});
    Ok(json!({
        "smalti_version": env!("CARGO_PKG_VERSION"),
        "camera": camera.description().name,
        "scene": scene,
        "seed": args.camera_options.seed,
        "pipeline": args.pipeline.as_ref().map(|file| file.display().to_string()),
        "noise": NOISES.iter().find(|(_, _, mode)| *mode == args.noise).map(|(name, ..)| name),
        "exposure_time_s": photo.exposure.time_s,
        "mean_illuminance_lux": mean(&lux),
        "raw": {
            "rows": photo.raw.rows(),
            "cols": photo.raw.cols(),
            "mean_percent_of_saturation": 100.0 * mean(&levels),
            "saturated_percent": photo.raw.saturated_percent(),
        },
        "picture": {
            "brightness_gain": gain,
            "scielab_mean": score.as_ref().map(|s| s.scores.scielab_mean),
            "cpsnr_db": score.as_ref().map(|s| s.scores.cpsnr_db),
            "pixel_delta_e_2000_mean": score.as_ref().map(|s| s.scores.pixel_delta_e_2000_mean),
            "pixel_delta_e_2000_p95": score.as_ref().map(|s| s.scores.pixel_delta_e_2000_p95),
            "scored_window": score.as_ref().map(scored),
            "viewing_px_per_degree": settings.samples_per_degree,
            "highlight_share": settings.highlight_share,
        },
        "description": camera.description(),
    }))
}

/// Writes a spectral image as `.npy`, with its unit and properties in `stages.json`.
fn write_cube(
    dir: &Path,
    name: &str,
    cube: &SpectralCube,
    unit: &str,
    facts: &[(&str, f64)],
) -> anyhow::Result<()> {
    let axes = [("wavelength", cube.grid().len()), ("row", cube.rows()), ("column", cube.cols())];
    let nm: Vec<f64> = cube.grid().wavelengths_nm().collect();
    let facts = facts.iter().map(|(name, value)| (*name, std::slice::from_ref(value)));
    let numbers: Vec<(&str, &[f64])> = facts.chain([("wavelengths_nm", &nm[..])]).collect();
    Ok(write_stage(dir, name, &axes, cube.planes().data(), unit, &numbers)?)
}

fn write_scene(dir: &Path, scene: &Scene) -> anyhow::Result<()> {
    let facts = [("distance_m", scene.distance_m()), ("horizontal_fov_deg", scene.horizontal_fov_deg())];
    write_cube(dir, STAGES[0], scene.radiance(), "photons s^-1 m^-2 sr^-1 nm^-1", &facts)
}

/// Writes the stages after the scene as `.npy`, with axes and units in `stages.json`.
fn write_stages(dir: &Path, photo: &Photograph) -> anyhow::Result<()> {
    let image = &photo.optical_image;
    let spacing = [("sample_spacing_m", image.sample_spacing_m())];
    write_cube(dir, STAGES[1], image.irradiance(), "photons s^-1 m^-2 nm^-1", &spacing)?;
    write_raw(dir, &photo.raw)?;
    let planes = photo.picture.planes();
    let axes = [("XYZ", 3), ("row", planes.rows()), ("column", planes.cols())];
    write_stage(
        dir,
        STAGES[3],
        &axes,
        planes.data(),
        "relative, Y = 1 is the brightest white the sensor holds",
        &[],
    )?;
    Ok(())
}

fn write_raw(dir: &Path, raw: &RawImage) -> anyhow::Result<()> {
    let axes = [("plane", raw.sampling().planes()), ("row", raw.rows()), ("column", raw.cols())];
    let levels: [(&str, &[f64]); 2] =
        [("black_level", &[raw.black_level()]), ("white_level", &[raw.white_level()])];
    match raw.samples() {
        RawSamples::Digital(v) => write_stage(dir, STAGES[2], &axes, v, "digital numbers", &levels)?,
        RawSamples::Analog(v) => write_stage(dir, STAGES[2], &axes, v, "V", &levels)?,
    }
    Ok(())
}
