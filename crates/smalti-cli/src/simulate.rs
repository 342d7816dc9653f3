//! `smalti simulate`: one capture, from the scene to a picture.

use std::path::Path;

use serde_json::json;
use smalti::camera::{Camera, CameraError, Photograph, PictureScores, ScoreSettings, score_picture};
use smalti::isp::{Isp, WhiteBalance};
use smalti::metrics::MetricError;
use smalti::scene::Scene;
use smalti::sensor::{NoiseMode, RawImage, RawSamples, Window};
use smalti::spectrum::{SpectralCube, Spectrum};
use smalti_io::dng::{self, DngInfo};
use smalti_io::picture::{self, Depth};
use smalti_io::stages::{self, write_stage};
use smalti_io::{memory, write};

use crate::args::{Common, Noise, PictureFormat, Simulate};
use crate::progress::Progress;
use crate::resolve;

/// How pictures are scored: on a good desktop screen, lightness relative to the brightest white in the picture.
const SCORE: ScoreSettings = ScoreSettings { samples_per_degree: 60.0, highlight_share: 0.0 };
/// Rows and columns, at most, of the part of a picture that is scored.
const SCORED_PX: usize = 2048;
/// What a capture takes at its peak, measured on mosaics: raw samples, and pictures in XYZ while they are compared.
const BYTES_PER_PIXEL: u64 = 120;

/// Files of `--stages`, along the light path.
const STAGES: [&str; 4] = ["1-scene-radiance", "2-optical-image-irradiance", "3-raw", "4-picture-xyz"];

pub(crate) fn run(args: &Simulate, common: &Common) -> anyhow::Result<()> {
    let progress = Progress::new(4, common.quiet);
    progress.begin("scene");
    write::ensure_can_fill(&args.output)?;
    let camera = resolve::camera(&args.camera, &args.camera_options, None)?;
    let scene = resolve::scene_for(&args.scene, &args.scene_options, &camera)?;
    let mut camera = resolve::camera(&args.camera, &args.camera_options, Some(scene.radiance().grid()))?;
    let scene = fitted(scene, args, &camera)?;
    progress.done();
    progress.begin("optics");
    if !args.full_frame {
        camera.sensor.window = Some(camera.window_on(&scene)?);
    }
    ensure_memory(&camera)?;
    let optical_image = camera.optics.image(&scene)?;
    let facts = scene_facts(args, &scene)?;
    let light = scene.illuminant().clone();
    // The largest thing in memory is kept only to be written.
    let scene = args.stages.then_some(scene);
    progress.done();
    progress.begin("sensor and processing");
    let noise = match args.noise {
        Noise::None => NoiseMode::None,
        Noise::Shot => NoiseMode::PhotonOnly,
        Noise::All => NoiseMode::All,
    };
    let photo = camera.photograph(optical_image, &light, noise, args.camera_options.seed)?;
    progress.done();
    progress.begin("writing");
    // Everything is computed before anything is written.
    let gain = photo.picture.brightness_gain();
    let picture = photo.picture.clone().scaled(gain).converted(camera.output_space())?;
    let info = DngInfo::of_camera(&camera, &light)?;
    let score = score(&camera, &light, &photo, noise, args.camera_options.seed)?;
    let metrics = metrics(args, &camera, facts, &photo, gain, score)?;
    let text = serde_json::to_string_pretty(&metrics)? + "\n";
    let dir = &args.output;
    let depth = if args.bits == "16" { Depth::Sixteen } else { Depth::Eight };
    let rendered = dir.join(match args.format {
        PictureFormat::Png => "rendered.png",
        PictureFormat::Tif => "rendered.tif",
    });
    // A folder that has metrics.json is whole: that of an earlier run goes first, the new one comes last.
    let earlier = STAGES.map(|stage| format!("{stage}.npy"));
    let earlier = earlier.iter().map(String::as_str).chain(["metrics.json", stages::INDEX]);
    write::begin_folder(dir, &earlier.collect::<Vec<_>>())?;
    picture::write(&rendered, &picture, depth)?;
    dng::write(&dir.join("raw.dng"), &photo.raw, &info)?;
    if let Some(scene) = &scene {
        write_scene(dir, scene)?;
        write_stages(dir, &photo)?;
    }
    write::bytes(&dir.join("metrics.json"), text.as_bytes())?;
    progress.finish();
    if args.json {
        return crate::print(&text);
    }
    let count = if args.stages { "raw.dng, metrics.json, stages.json" } else { "raw.dng, metrics.json" };
    crate::print(&format!("{}  ({count} beside it)\n", rendered.display()))
}

/// Refuses what would end in the system killing the program midway.
fn ensure_memory(camera: &Camera) -> anyhow::Result<()> {
    let sensor = &camera.sensor;
    let (rows, cols) = sensor.window.map_or((sensor.rows, sensor.cols), |w| (w.rows, w.cols));
    let need = (rows as u64).saturating_mul(cols as u64).saturating_mul(BYTES_PER_PIXEL);
    let Some(available) = memory::available_bytes() else { return Ok(()) };
    anyhow::ensure!(
        need <= available,
        "`sensor.rows` × `sensor.cols`: a picture of {rows} × {cols} pixels takes {} MiB of memory; {} are available",
        need >> 20,
        available >> 20,
    );
    Ok(())
}

/// The scene, as wide as needed to lie on the sensor whole, unless its field of view was stated.
fn fitted(scene: Scene, args: &Simulate, camera: &Camera) -> anyhow::Result<Scene> {
    if args.scene_options.fov.is_some() || args.scene.contains("fov=") {
        return Ok(scene);
    }
    Ok(camera.fitted(scene, resolve::is_file(&args.scene))?)
}

/// How far the picture is from what the standard observer sees through the same lens and pixels, and where.
struct Score {
    scores: PictureScores,
    window: Window,
}

/// Scores the middle of the picture, at most [`SCORED_PX`] high and wide. `None` where there is no light.
fn score(
    camera: &Camera,
    light: &Spectrum,
    photo: &Photograph,
    noise: NoiseMode,
    seed: u64,
) -> anyhow::Result<Option<Score>> {
    let mosaic = camera.sensor.cfa.mosaic();
    let whole = camera.sensor.read_window();
    let middle = |first: usize, count: usize, tile: usize| {
        let taken = count.min(SCORED_PX);
        let skipped = (count - taken) / 2;
        (first + skipped - skipped % tile, taken)
    };
    let (row, rows) = middle(whole.row, whole.rows, mosaic.rows());
    let (col, cols) = middle(whole.col, whole.cols, mosaic.cols());
    let window = Window { row, col, rows, cols };
    let mut camera = camera.clone();
    camera.sensor.window = Some(window);
    // A windowed capture has the bits of that part of the whole.
    let raw = camera.sensor.capture(&photo.optical_image, &photo.exposure, noise, seed)?;
    let colors = camera.isp(light, WhiteBalance::None)?;
    let measured = colors.render(&raw)?;
    let reference = camera.reference_as_exposed(&photo.optical_image, &photo.exposure, light)?;
    let white = colors.color_matrix.xyz_white();
    match score_picture(&measured, &reference, white, &SCORE) {
        Ok(scores) => Ok(Some(Score { scores, window })),
        Err(CameraError::Metric(MetricError::Undefined { .. })) => Ok(None),
        Err(e) => Err(e.into()),
    }
}

fn scene_facts(args: &Simulate, scene: &Scene) -> anyhow::Result<serde_json::Value> {
    Ok(json!({
        "name": args.scene,
        "mean_luminance_cd_m2": scene.mean_luminance_cd_m2()?,
        "distance_m": scene.distance_m(),
        "horizontal_fov_deg": scene.horizontal_fov_deg(),
    }))
}

fn metrics(
    args: &Simulate,
    camera: &Camera,
    scene: serde_json::Value,
    photo: &Photograph,
    gain: f64,
    score: Option<Score>,
) -> anyhow::Result<serde_json::Value> {
    let mean = |v: &mut dyn Iterator<Item = f64>, n: usize| v.sum::<f64>() / n as f64;
    let lux = photo.optical_image.illuminance_lux()?;
    let levels = photo.raw.normalized();
    let scored = |s: &Score| json!({"row": s.window.row, "col": s.window.col, "rows": s.window.rows, "cols": s.window.cols});
    Ok(json!({
        "smalti_version": env!("CARGO_PKG_VERSION"),
        "camera": camera.description().name,
        "scene": scene,
        "seed": args.camera_options.seed,
        "noise": format!("{:?}", args.noise).to_lowercase(),
        "exposure_time_s": photo.exposure.time_s,
        "mean_illuminance_lux": mean(&mut lux.iter().map(|&v| f64::from(v)), lux.len()),
        "raw": {
            "rows": photo.raw.rows(),
            "cols": photo.raw.cols(),
            "mean_percent_of_saturation": 100.0 * mean(&mut levels.iter().map(|&v| f64::from(v)), levels.len()),
            "saturated_percent": photo.raw.saturated_percent(),
        },
        "picture": {
            "brightness_gain": gain,
            "scielab_mean": score.as_ref().map(|s| s.scores.scielab_mean),
            "cpsnr_db": score.as_ref().map(|s| s.scores.cpsnr_db),
            "pixel_delta_e_2000_mean": score.as_ref().map(|s| s.scores.pixel_delta_e_2000_mean),
            "pixel_delta_e_2000_p95": score.as_ref().map(|s| s.scores.pixel_delta_e_2000_p95),
            "scored_window": score.as_ref().map(scored),
            "viewing_px_per_degree": SCORE.samples_per_degree,
        },
        "description": camera.description(),
    }))
}

/// A spectral image as `.npy`, with its unit and facts in `stages.json`.
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

/// The stages after the scene as `.npy`, with axes and units in `stages.json`.
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
