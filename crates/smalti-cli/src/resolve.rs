//! From what was typed to what the library takes.

use std::path::Path;

use anyhow::{Context, bail};
use smalti::camera::Camera;
use smalti::color::jakob_hanika2019::Uplift;
use smalti::color::ColorSpace;
use smalti::scene::{self, Scene, Setting};
use smalti::spectrum::{Illuminant, WavelengthGrid};
use smalti_io::exr::{ReadOptions, SceneDefaults};
use smalti_io::{cameras, exr, picture};

use crate::args::{CameraOptions, SceneOptions};

/// A camera by name or file, with the overrides of the command line.
pub(crate) fn camera(name: &str, options: &CameraOptions) -> anyhow::Result<Camera> {
    cameras::load(name, &options.overrides, WavelengthGrid::VISIBLE).map_err(|e| anyhow::anyhow!("{e}"))
}

/// A light by name.
pub(crate) fn illuminant(name: &str) -> anyhow::Result<Illuminant> {
    Ok(Illuminant::from_name(name)?)
}

/// The setting of a scene: what was typed, then the defaults. `fov_deg` is the field of view where none was typed.
fn setting(options: &SceneOptions, grid: WavelengthGrid, fov_deg: Option<f64>) -> anyhow::Result<Setting> {
    let default = Setting::default();
    Ok(Setting {
        luminance_cd_m2: options.luminance.unwrap_or(default.luminance_cd_m2),
        distance_m: options.distance.unwrap_or(default.distance_m),
        horizontal_fov_deg: options.fov.or(fov_deg).unwrap_or(default.horizontal_fov_deg),
        illuminant: options.illuminant.as_deref().map_or(Ok(default.illuminant), illuminant)?,
        grid,
    })
}

/// A scene by name or file.
pub(crate) fn scene(
    name: &str,
    options: &SceneOptions,
    grid: WavelengthGrid,
    fov_deg: Option<f64>,
) -> anyhow::Result<Scene> {
    let setting = setting(options, grid, fov_deg)?;
    let path = Path::new(name);
    if !(path.is_file() || has_extension(path, &["exr", "png", "tif", "tiff", "jpg", "jpeg"])) {
        return Ok(scene::build(name, &setting)?);
    }
    let scene = file_scene(path, options, &setting)?;
    // What was typed holds, whatever the file states.
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
    match options.fov.or(fov_deg) {
        Some(deg) => Ok(scene.with_fov(deg)?),
        None => Ok(scene),
    }
}

fn file_scene(path: &Path, options: &SceneOptions, setting: &Setting) -> anyhow::Result<Scene> {
    let read = ReadOptions::default();
    if has_extension(path, &["exr"]) && exr::is_spectral(path)? {
        let defaults = SceneDefaults {
            luminance_cd_m2: setting.luminance_cd_m2,
            distance_m: setting.distance_m,
            horizontal_fov_deg: setting.horizontal_fov_deg,
            illuminant: setting.illuminant.clone(),
        };
        return Ok(exr::read(path, &read)?.into_scene(&defaults)?);
    }
    let image = picture::read(path, &read)?.image.converted(ColorSpace::LinearSrgb)?;
    // A photograph says nothing of the light it was taken in: its white is taken for that of D65, then re-lit.
    let light = match &options.illuminant {
        Some(_) => Illuminant::D65,
        None => setting.illuminant.clone(),
    };
    let photons = light.photons(setting.grid)?;
    let uplift = Uplift::new(setting.grid)?;
    let reflectance = uplift.uplift_image(&image)?;
    let name = path.file_stem().map_or_else(|| "picture".into(), |s| s.to_string_lossy().into_owned());
    Ok(Scene::from_reflectance(name, reflectance, &photons, setting.distance_m, setting.horizontal_fov_deg)?
        .with_mean_luminance(setting.luminance_cd_m2)?)
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
    let [start, step, end] = numbers[..] else { bail!("--wavelengths {text}: expected START:STEP:END, such as 400:10:700") };
    let count = ((end - start) / step).round();
    if !(count.is_finite() && (0.0..=100_000.0).contains(&count)) {
        bail!("--wavelengths {text}: expected an end above the start and a positive step");
    }
    Ok(WavelengthGrid::new(start, step, count as usize + 1)?)
}
