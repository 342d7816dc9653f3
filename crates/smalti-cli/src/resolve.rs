//! Resolves names and options of the command line to objects of the library.

use std::path::Path;

use anyhow::{Context, bail};
use smalti::camera::Camera;
use smalti::scene::Scene;
use smalti::spectrum::{Illuminant, WavelengthGrid};
pub(crate) use smalti_io::scene_file::is_meant as is_file;
use smalti_io::{ReadOptions, SceneRequest, cameras, lights, scenes};
use smalti_report::comparison::{CameraArgument, CommandLine};

use crate::args::CameraOptions;
use crate::scene_args::SceneOptions;

/// A camera by name or file with the overrides of the command line, on a wavelength grid or, with `None`, on its own.
pub(crate) fn camera(
    name: &str,
    options: &CameraOptions,
    grid: Option<WavelengthGrid>,
) -> anyhow::Result<Camera> {
    cameras::load(name, &options.overrides, grid).map_err(|e| anyhow::anyhow!("{e}"))
}

/// The words of the command line for pages, with the cameras among them.
pub(crate) fn command_line(words: &[String], cameras: &[String]) -> CommandLine {
    let is_built_in = |word: &String| cameras::names().iter().any(|c| c.name == *word);
    let argument = |word: &String| CameraArgument { word: word.clone(), is_built_in: is_built_in(word) };
    CommandLine { words: words.to_vec(), cameras: cameras.iter().map(argument).collect() }
}

/// Cameras by name or file, on their own wavelengths.
pub(crate) fn cameras(names: &[String], options: &CameraOptions) -> anyhow::Result<Vec<Camera>> {
    names.iter().map(|name| camera(name, options, None)).collect()
}

/// An illuminant by name or from a CSV file; `file.csv#column` selects a column.
pub(crate) fn illuminant(name: &str) -> anyhow::Result<Illuminant> {
    Ok(lights::load(name, Path::new(""))?)
}

/// A scene by name or file on the wavelengths of the command line, else on those that the camera states.
pub(crate) fn scene_for(name: &str, options: &SceneOptions, camera: &Camera) -> anyhow::Result<Scene> {
    let given = options.wavelengths.as_deref().map(wavelengths).transpose()?;
    let stated = camera.description().wavelengths_nm.map(|_| camera.grid());
    scene_on(name, options, given.or(stated))
}

/// The options of reading a file.
pub(crate) fn read_options(options: &SceneOptions) -> anyhow::Result<ReadOptions> {
    Ok(ReadOptions {
        clamp_negative: options.clamp_negative,
        grid: options.wavelengths.as_deref().map(wavelengths).transpose()?,
        quantity: options.quantity,
        variable: options.variable.clone(),
        crop: options.crop,
        upsampling: options.upsampling,
        ..ReadOptions::default()
    })
}

/// A scene by name or file.
pub(crate) fn scene(name: &str, options: &SceneOptions) -> anyhow::Result<Scene> {
    scene_on(name, options, options.wavelengths.as_deref().map(wavelengths).transpose()?)
}

/// A scene by name or file, on a wavelength grid if one is given.
fn scene_on(name: &str, options: &SceneOptions, grid: Option<WavelengthGrid>) -> anyhow::Result<Scene> {
    if let Some(option) = options.of_files().filter(|_| !is_file(name)) {
        bail!("{name}: {option} applies to files, and this is a built-in scene");
    }
    let request = SceneRequest {
        luminance_cd_m2: options.luminance,
        distance_m: options.distance,
        horizontal_fov_deg: options.fov,
        illuminant: options.illuminant.as_deref().map(illuminant).transpose()?,
        grid,
        read: read_options(options)?,
    };
    Ok(scenes::load(name, &request)?)
}

pub(crate) fn has_extension(path: &Path, known: &[&str]) -> bool {
    path.extension().and_then(|e| e.to_str()).is_some_and(|e| known.iter().any(|k| k.eq_ignore_ascii_case(e)))
}

/// Parses `START:STEP:END` in nm.
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
