//! Resolves names and options of the command line to objects of the library.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use smalti::camera::Camera;
use smalti::experiment::light_notes;
use smalti::l3::Pipeline;
use smalti::scene::{Scene, SceneError};
use smalti::spectrum::{Illuminant, SpectrumError, WavelengthGrid};
use smalti_io::cache::Cache;
use smalti_io::cameras::LoadedCamera;
pub(crate) use smalti_io::scene_file::is_meant as is_file;
use smalti_io::{ContentError, IoError, ReadOptions, SceneRequest, cameras, lights, scenes};
use smalti_report::comparison::{CameraArgument, CommandLine};

use crate::args::{CameraOptions, Common};
use crate::output::note;
use crate::scene_args::SceneOptions;

/// A camera by name or file with the mosaic and the overrides of the command line, on its own wavelengths.
pub(crate) fn camera(name: &str, options: &CameraOptions) -> anyhow::Result<LoadedCamera> {
    let name = with_cfa(name, options.cfa.as_deref())?;
    cameras::load_with_notes(&name, &options.overrides, None).map_err(anyhow::Error::from)
}

/// The name of a camera with the mosaic of `--cfa`.
pub(crate) fn with_cfa(name: &str, cfa: Option<&str>) -> anyhow::Result<String> {
    match cfa {
        Some(cfa) if cameras::has_mosaic(name) => {
            bail!("{name}: the mosaic is given twice, here and as --cfa {cfa}; expected one of them")
        }
        Some(cfa) => Ok(format!("{name}@{cfa}")),
        None => Ok(name.to_owned()),
    }
}

/// The words of the command line for pages, with the cameras among them.
pub(crate) fn command_line(words: &[String], cameras: &[String]) -> CommandLine {
    let argument =
        |word: &String| CameraArgument { word: word.clone(), is_built_in: cameras::is_built_in(word) };
    CommandLine { words: words.to_vec(), cameras: cameras.iter().map(argument).collect() }
}

/// Cameras by name or file, on their own wavelengths, for pictures under an illuminant. Prints what is to be told about them.
pub(crate) fn cameras(
    names: &[String],
    options: &CameraOptions,
    illuminant: &Illuminant,
    common: &Common,
) -> anyhow::Result<Vec<Camera>> {
    let (mut notes, mut warnings) = (Vec::<String>::new(), Vec::<(String, Vec<String>)>::new());
    let one = |name: &String| {
        let (options, left_out) = fitting(name, names, options)?;
        let LoadedCamera { camera, notes: mut told, .. } = camera(name, &options)?;
        told.extend(left_out);
        notes.extend(told.into_iter().filter(|note| !notes.contains(note)).collect::<Vec<_>>());
        // One note for all cameras that it applies to.
        let light = illuminant.photons(camera.grid())?;
        // What makes colours impossible to measure is an error that follows.
        let notes = if camera.ensure_measures_color(&light).is_ok() {
            light_notes(&camera, &light)?
        } else {
            Vec::new()
        };
        for text in notes {
            let name = camera.description().name.clone();
            match warnings.iter_mut().find(|(known, _)| *known == text) {
                Some((_, names)) => names.push(name),
                None => warnings.push((text, vec![name])),
            }
        }
        Ok(camera)
    };
    let cameras = names.iter().map(one).collect::<anyhow::Result<_>>()?;
    let warnings = warnings.iter().map(|(text, names)| format!("{}: {text}", names.join(", ")));
    notes.into_iter().chain(warnings).for_each(|text| note(&text, common));
    Ok(cameras)
}

/// The options for one of several cameras: filters that the command line states for the mosaic of another one, such as `W` for
/// `phone@rgbw`, do not concern a camera without such a letter. A note names them.
fn fitting(
    name: &str,
    names: &[String],
    options: &CameraOptions,
) -> anyhow::Result<(CameraOptions, Option<String>)> {
    let mut options = options.clone();
    let others_have_mosaics = options.cfa.is_none() && names.iter().any(|other| cameras::has_mosaic(other));
    if cameras::has_mosaic(name) || !others_have_mosaics {
        return Ok((options, None));
    }
    let (filters, rest): (Vec<_>, Vec<_>) =
        options.overrides.iter().cloned().partition(|o| cameras::filter_letter(o).is_some());
    if filters.is_empty() {
        return Ok((options, None));
    }
    let letters = cameras::letters(name, &rest).map_err(anyhow::Error::from)?;
    let has = |letter: char| letters.contains(&letter);
    let mut left_out: Vec<String> =
        filters.iter().filter_map(cameras::filter_letter).filter(|l| !has(*l)).map(String::from).collect();
    left_out.dedup();
    options.overrides.retain(|o| cameras::filter_letter(o).is_none_or(has));
    let note = (!left_out.is_empty()).then(|| {
        let letters = left_out.join(", ");
        format!("{name}: the stated filter for {letters} is not used, since the mosaic has no such letter")
    });
    Ok((options, note))
}

/// Prints which cameras of a comparison are the same but for their names.
pub(crate) fn note_identical(cameras: &[Camera], labels: &[String], common: &Common) {
    let mut told: Vec<usize> = Vec::new();
    for (i, camera) in cameras.iter().enumerate().filter(|_| !common.quiet) {
        let same: Vec<usize> =
            (i + 1..cameras.len()).filter(|&other| cameras[other].is_same_as(camera)).collect();
        if same.is_empty() || told.contains(&i) {
            continue;
        }
        let names: Vec<&str> = std::iter::once(i)
            .chain(same.iter().copied())
            .filter_map(|c| labels.get(c).map(String::as_str))
            .collect();
        note(&format!("{} are identical cameras: their scores do not differ", names.join(" and ")), common);
        told.extend(same);
    }
}

/// The learned tables of `--pipeline`, one for each camera; empty when none is given.
pub(crate) fn pipelines(files: &[PathBuf], cameras: usize) -> anyhow::Result<Vec<Option<Pipeline>>> {
    if !files.is_empty() && files.len() != cameras {
        bail!(
            "--pipeline: {} given for {cameras} cameras; expected one for each, in their order, with the option repeated: {}",
            files.len(),
            vec!["--pipeline FILE.l3"; cameras].join(" ")
        );
    }
    files.iter().map(|file| Ok(Some(smalti_io::l3::read_table(file)?))).collect()
}

/// Checks that learned tables render pictures of their cameras.
pub(crate) fn ensure_tables_fit<'a>(
    files: &[PathBuf],
    pairs: impl Iterator<Item = (&'a Camera, &'a Option<Pipeline>)>,
) -> anyhow::Result<()> {
    for (file, (camera, pipeline)) in files.iter().zip(pairs) {
        let about = || format!("{} for {}", file.display(), camera.description().name);
        let Some(pipeline) = pipeline else { continue };
        pipeline.ensure_renders(&camera.sensor.cfa).with_context(about)?;
        // Volts are equivalent after normalisation.
        if camera.sensor.adc.bits > 0 {
            let levels = camera.sensor.raw_levels(&camera.gain_and_offset())?;
            pipeline.ensure_levels([levels.black, levels.white]).with_context(about)?;
        }
    }
    Ok(())
}

/// An illuminant by name or from a CSV file; `file.csv#column` selects a column. Prints what is to be told about the file.
pub(crate) fn illuminant(name: &str, common: &Common) -> anyhow::Result<Illuminant> {
    let (illuminant, told) = lights::load_with_note(name, Path::new(""))?;
    told.iter().for_each(|text| note(text, common));
    Ok(illuminant)
}

/// A scene by name or file on the wavelengths of the command line, else on those that the camera states.
pub(crate) fn scene_for(
    name: &str,
    options: &SceneOptions,
    camera: &Camera,
    common: &Common,
) -> anyhow::Result<Scene> {
    let given = options.wavelengths.as_deref().map(wavelengths).transpose()?;
    let stated = camera.description().wavelengths_nm.map(|_| camera.grid());
    let scene = scene_on(name, options, given.or(stated), common);
    scene.map_err(|error| match (given, stated) {
        (None, Some(grid)) => with_common_wavelengths(error, grid),
        _ => error,
    })
}

/// The error about a scene that lacks wavelengths of a camera, with the option that leaves them out.
fn with_common_wavelengths(error: anyhow::Error, of_camera: WavelengthGrid) -> anyhow::Error {
    let Some(IoError::Content { source, .. }) = error.downcast_ref() else { return error };
    let (ContentError::Spectrum(spectra) | ContentError::Scene(SceneError::Spectrum(spectra))) = source
    else {
        return error;
    };
    let &SpectrumError::Coverage { have_start_nm, have_end_nm, .. } = spectra else { return error };
    let [start, end] = [of_camera.start_nm().max(have_start_nm), of_camera.end_nm().min(have_end_nm)];
    let step = of_camera.step_nm();
    if start >= end {
        return error;
    }
    error.context(format!(
        "the camera sees light that the scene lacks; --wavelengths {start}:{step}:{end} leaves it out"
    ))
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
pub(crate) fn scene(name: &str, options: &SceneOptions, common: &Common) -> anyhow::Result<Scene> {
    scene_on(name, options, options.wavelengths.as_deref().map(wavelengths).transpose()?, common)
}

/// A scene by name or file, on a wavelength grid if one is given.
fn scene_on(
    name: &str,
    options: &SceneOptions,
    grid: Option<WavelengthGrid>,
    common: &Common,
) -> anyhow::Result<Scene> {
    if let Some(option) = options.of_files().filter(|_| !is_file(name)) {
        bail!("{name}: {option} applies to files, and this is a built-in scene");
    }
    let request = SceneRequest {
        luminance_cd_m2: options.luminance,
        distance_m: options.distance,
        horizontal_fov_deg: options.fov,
        illuminant: options.illuminant.as_deref().map(|name| illuminant(name, common)).transpose()?,
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
    if !(count.is_finite() && (1.0..100_000.0).contains(&count)) {
        bail!(
            "--wavelengths {text}: expected an end above the start, a positive step and at most 100000 wavelengths"
        );
    }
    WavelengthGrid::new(start, step, count as usize + 1).with_context(|| format!("--wavelengths {text}"))
}

/// The cache, unless an option turns it off.
pub(crate) fn cache(no_cache: bool) -> anyhow::Result<Cache> {
    Ok(if no_cache { Cache::disabled() } else { Cache::open(None)? })
}
