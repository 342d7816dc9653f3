//! From what was typed to what the library takes.

use std::path::Path;

use anyhow::{Context, bail};
use smalti::camera::Camera;
use smalti::scene::{self, Scene, Setting};
use smalti::spectrum::{Illuminant, WavelengthGrid};
pub(crate) use smalti_io::scene_file::is_meant as is_file;
use smalti_io::{ReadOptions, cameras, lights, scene_file};

use crate::args::CameraOptions;
use crate::scene_args::SceneOptions;

/// A camera by name or file, with the overrides of the command line, for scenes on a wavelength grid; `None`: its own.
pub(crate) fn camera(
    name: &str,
    options: &CameraOptions,
    grid: Option<WavelengthGrid>,
) -> anyhow::Result<Camera> {
    cameras::load(name, &options.overrides, grid).map_err(|e| anyhow::anyhow!("{e}"))
}

/// A light by name, or from a CSV file (`file.csv#column` picks a column).
pub(crate) fn illuminant(name: &str) -> anyhow::Result<Illuminant> {
    Ok(lights::load(name, Path::new(""))?)
}

/// The wavelengths that a scene is asked for: those that were typed, else those that the camera states.
pub(crate) fn scene_for(name: &str, options: &SceneOptions, camera: &Camera) -> anyhow::Result<Scene> {
    let typed = options.wavelengths.as_deref().map(wavelengths).transpose()?;
    let stated = camera.description().wavelengths_nm.map(|_| camera.grid());
    scene_on(name, options, typed.or(stated))
}

/// The setting of a scene: what was typed, then the defaults.
fn setting(options: &SceneOptions, grid: WavelengthGrid) -> anyhow::Result<Setting> {
    let default = Setting::default();
    Ok(Setting {
        luminance_cd_m2: options.luminance.unwrap_or(default.luminance_cd_m2),
        distance_m: options.distance.unwrap_or(default.distance_m),
        horizontal_fov_deg: options.fov.unwrap_or(default.horizontal_fov_deg),
        illuminant: options.illuminant.as_deref().map_or(Ok(default.illuminant), illuminant)?,
        grid,
    })
}

/// How a file is read: what was typed of what it may leave unsaid.
pub(crate) fn read_options(options: &SceneOptions) -> anyhow::Result<ReadOptions> {
    Ok(ReadOptions {
        clamp_negative: options.clamp_negative,
        grid: options.wavelengths.as_deref().map(wavelengths).transpose()?,
        quantity: options.quantity.map(Into::into),
        variable: options.variable.clone(),
        crop: options.crop,
        ..ReadOptions::default()
    })
}

/// A scene by name or file.
pub(crate) fn scene(name: &str, options: &SceneOptions) -> anyhow::Result<Scene> {
    scene_on(name, options, options.wavelengths.as_deref().map(wavelengths).transpose()?)
}

/// A scene by name or file, on a wavelength grid if one is given.
fn scene_on(name: &str, options: &SceneOptions, grid: Option<WavelengthGrid>) -> anyhow::Result<Scene> {
    let setting = setting(options, grid.unwrap_or_default())?;
    if !is_file(name) {
        if let Some(option) = options.of_files() {
            bail!("{name}: {option} is of files; it is a built-in scene");
        }
        return Ok(scene::catalog::build_natural(name, &setting)?);
    }
    let scene = scene_file::read(Path::new(name), &setting, &read_options(options)?)?;
    // What was typed holds, whatever the file states.
    let scene = match grid {
        Some(grid) if grid != scene.radiance().grid() => scene.resampled(grid)?,
        _ => scene,
    };
    let scene = match &options.illuminant {
        Some(_) => scene.relit(&setting.illuminant)?,
        None => scene,
    };
    let scene = match options.luminance {
        Some(cd_m2) => scene.with_mean_luminance(cd_m2)?,
        None => scene,
    };
    let scene = match options.distance {
        Some(m) => scene.with_distance(m)?,
        None => scene,
    };
    match options.fov {
        Some(deg) => Ok(scene.with_fov(deg)?),
        None => Ok(scene),
    }
}

pub(crate) fn has_extension(path: &Path, known: &[&str]) -> bool {
    path.extension().and_then(|e| e.to_str()).is_some_and(|e| known.iter().any(|k| k.eq_ignore_ascii_case(e)))
}

/// `START:STEP:END` in nm.
pub(crate) fn wavelengths(text: &str) -> anyhow::Result<WavelengthGrid> {
    let numbers: Vec<f64> = text
        .split(':')
        .map(|p| p.trim().parse().with_context(|| format!("--wavelengths {text}: '{p}' is not a number")))
        .collect::<Result<_, _>>()?;
    let [start, step, end] = numbers[..] else {
        bail!("--wavelengths {text}: expected START:STEP:END, such as 400:10:700")
    };
    let count = ((end - start) / step).round();
    if !(count.is_finite() && (0.0..=100_000.0).contains(&count)) {
        bail!(
            "--wavelengths {text}: expected an end above the start, a positive step and at most 100000 wavelengths"
        );
    }
    WavelengthGrid::new(start, step, count as usize + 1).with_context(|| format!("--wavelengths {text}"))
}

/// The scene, as wide as needed to lie on the sensor whole. A file is not spread over more pixels than it has.
pub(crate) fn on_sensor(scene: Scene, is_file: bool, camera: &Camera) -> anyhow::Result<Scene> {
    let (rows, cols) = (scene.radiance().rows(), scene.radiance().cols());
    let whole = camera.sensor.cols.min(camera.sensor.rows * cols / rows.max(1));
    let span = if is_file { whole.min(cols) } else { whole };
    let deg = camera.field_of_view_deg(span.max(1), scene.distance_m())?;
    Ok(scene.with_fov(deg)?)
}
