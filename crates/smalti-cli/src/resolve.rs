//! From what was typed to what the library takes.

use std::path::Path;

use anyhow::{Context, bail};
use smalti::camera::Camera;
use smalti::color::ColorSpace;
use smalti::color::jakob_hanika2019::Uplift;
use smalti::scene::{self, Scene, Setting};
use smalti::spectrum::{Illuminant, Observer, WavelengthGrid, reflectance};
use smalti_io::exr::{Quantity, ReadOptions, SceneDefaults, SpectralFile};
use smalti_io::{cameras, exr, picture, spectrum_csv};

use crate::args::{CameraOptions, SceneOptions};

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
    let file = name.split('#').next().unwrap_or(name);
    if has_extension(Path::new(file), &["csv"]) {
        let power = spectrum_csv::read_spectrum(name)?;
        return Ok(Illuminant::Measured { name: name.to_owned(), power });
    }
    Ok(Illuminant::from_name(name)?)
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

/// A scene by name or file.
pub(crate) fn scene(name: &str, options: &SceneOptions) -> anyhow::Result<Scene> {
    scene_on(name, options, options.wavelengths.as_deref().map(wavelengths).transpose()?)
}

/// A scene by name or file, on a wavelength grid if one is given.
fn scene_on(name: &str, options: &SceneOptions, grid: Option<WavelengthGrid>) -> anyhow::Result<Scene> {
    let setting = setting(options, grid.unwrap_or_default())?;
    let path = Path::new(name);
    if !is_file(name) {
        let natural: Vec<_> = reflectance::natural(setting.grid)?.into_iter().map(|(_, s)| s).collect();
        return Ok(scene::catalog::build(name, &setting, &natural)?);
    }
    let scene = file_scene(path, &setting)?;
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

/// A file as a scene. What it leaves unsaid is that of the setting.
fn file_scene(path: &Path, setting: &Setting) -> anyhow::Result<Scene> {
    let read = ReadOptions::default();
    let defaults = SceneDefaults {
        luminance_cd_m2: setting.luminance_cd_m2,
        distance_m: setting.distance_m,
        horizontal_fov_deg: setting.horizontal_fov_deg,
        // Files that say nothing of their light are taken for daylight; another is put on by re-lighting.
        illuminant: Illuminant::D65,
    };
    if has_extension(path, &["exr"]) && exr::is_spectral(path, &read)? {
        // Messages about the file call it by the name that was typed.
        let file = SpectralFile { name: path.display().to_string(), ..exr::read(path, &read)? };
        return Ok(file.into_scene(&defaults)?);
    }
    let image = picture::read(path, &read)?.image.converted(ColorSpace::LinearSrgb)?;
    let lifted = SpectralFile {
        name: path.display().to_string(),
        cube: Uplift::new(setting.grid, Observer::Cie1931)?.uplift_image(&image)?,
        quantity: Quantity::Reflectance,
        illuminant: None,
        distance_m: None,
        horizontal_fov_deg: None,
    };
    Ok(lifted.into_scene(&defaults)?)
}

/// Whether a scene is meant as a file: it is one, or its name ends as one.
pub(crate) fn is_file(name: &str) -> bool {
    let path = Path::new(name);
    path.is_file() || has_extension(path, &["exr", "png", "tif", "tiff", "jpg", "jpeg"])
}

pub(crate) fn has_extension(path: &Path, known: &[&str]) -> bool {
    path.extension().and_then(|e| e.to_str()).is_some_and(|e| known.iter().any(|k| k.eq_ignore_ascii_case(e)))
}

/// `START:STEP:END` in nm.
fn wavelengths(text: &str) -> anyhow::Result<WavelengthGrid> {
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
