//! `smalti convert`: converts a scene to another format.

use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use clap::Args;
use smalti::color::{ColorSpace, Image};
use smalti::scene::Scene;
use smalti_io::envi::Interleave;
use smalti_io::picture::{self, Depth};
use smalti_io::scene_file::{self, Cropped, Format, Photons, Restated, Tiles, Whole, WriteOptions};
use smalti_io::{SpectralFile, exr, matlab, spectral_tiff};

use crate::args::{Choice, Common, choice};
use crate::progress::Progress;
use crate::resolve::{self, has_extension};
use crate::scene_args::SceneOptions;
use smalti::experiment::Progress as _;

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti convert macbeth -o macbeth.exr\n  \
    smalti convert photo.png --illuminant A -o upsampled.exr\n  \
    smalti convert dead-leaves?seed=7 --wavelengths 400:5:700 -o photons.npy\n  \
    smalti convert flight.hdr --crop 1000,0,512,512 -o part.npz\n  \
    smalti convert macbeth -o macbeth.mat                 for ISETCam\n  \
    smalti convert balloons_ms/ -o balloons.hdr --interleave bip\n  \
    smalti convert cube.npy --wavelengths 400:10:700 --quantity reflectance -o cube.tif --layout pages\n\n\
    The values and metadata of a spectral file are kept. With --luminance, --illuminant or other --wavelengths than its own, the file is \
    first converted to a scene. Notes list what the new format cannot represent. Most spectral formats are read in parts, and ENVI, NumPy \
    and TIFF are also written in parts, so cubes may exceed the memory (docs/formats-scenes.md).")]
pub(crate) struct Convert {
    /// A built-in scene, a file or a folder of bands
    pub(crate) scene: String,
    #[command(flatten)]
    pub(crate) scene_options: SceneOptions,
    /// .exr (spectral), .mat (a scene of ISETCam), .h5, .hdr (ENVI with its samples in a second file; or .img, .bsq, .bil, .bip), .npz,
    /// .npy (photons), .tif with --layout pages or samples (spectral), .png or .tif (a picture for the standard observer)
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Arrangement of bands: fichet2021 or pbrt for EXR, pages or samples for TIFF; version of a MAT-file: v5 or v7.3
    /// [default: fichet2021; a picture; v5]
    #[arg(long, value_parser = choice(&LAYOUTS))]
    pub(crate) layout: Option<Layout>,
    /// Order of the samples of ENVI [default: that of the extension, else bsq]
    #[arg(long, value_parser = choice(&INTERLEAVES))]
    pub(crate) interleave: Option<Interleave>,
    /// Compress a spectral TIFF without loss
    #[arg(long)]
    pub(crate) compress: bool,
}

/// The layout of a format.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Layout {
    Exr(exr::Layout),
    Tiff(spectral_tiff::Layout),
    Matlab(matlab::Version),
}

const LAYOUTS: [Choice<Layout>; 6] = [
    (
        "fichet2021",
        "`S0.400,0nm` channels with units (Fichet et al. 2021)",
        Layout::Exr(exr::Layout::Fichet2021),
    ),
    ("pbrt", "`Radiance.C01` channels", Layout::Exr(exr::Layout::Pbrt)),
    ("pages", "An image for each band", Layout::Tiff(spectral_tiff::Layout::Pages)),
    ("samples", "A sample of each pixel for each band", Layout::Tiff(spectral_tiff::Layout::Samples)),
    ("v5", "MATLAB level 5, up to 2 GiB", Layout::Matlab(matlab::Version::V5)),
    ("v7.3", "MATLAB 7.3, which is HDF5", Layout::Matlab(matlab::Version::V73)),
];

const INTERLEAVES: [Choice<Interleave>; 3] = [
    ("bsq", "Band, row, column", Interleave::Bsq),
    ("bil", "Row, band, column", Interleave::Bil),
    ("bip", "Row, column, band", Interleave::Bip),
];

pub(crate) fn run(args: &Convert, common: &Common) -> anyhow::Result<()> {
    let progress = Progress::new(1, common.quiet);
    progress.begin("converting");
    let path = &args.output;
    let spectral = write_options(args)?;
    let file = as_it_is(args)?;
    // Losses are reported for files only, since a built-in scene remains available.
    let report_losses = file.is_some();
    let notes = match (file, spectral) {
        (Some(file), Some(options)) => write_spectral(args, file, &options, common)?,
        (_, Some(options)) => {
            let file = SpectralFile::of_scene(&scene(args, common)?);
            scene_file::write(path, &Whole::new(&file), &options)?
        }
        (_, None) => write_picture(path, &scene(args, common)?)?,
    };
    notes.iter().filter(|_| report_losses).for_each(|note| progress.note(note));
    progress.finish();
    crate::print(&format!("{}\n", path.display()))
}

fn scene(args: &Convert, common: &Common) -> anyhow::Result<Scene> {
    let scene = resolve::scene(&args.scene, &args.scene_options, common);
    match &args.scene_options.wavelengths {
        Some(w) => scene.with_context(|| format!("--wavelengths {w}")),
        None => scene,
    }
}

/// The options of writing a spectral file; `None` for a picture.
fn write_options(args: &Convert) -> anyhow::Result<Option<WriteOptions>> {
    let path = &args.output;
    let tiff = if let Some(Layout::Tiff(layout)) = args.layout { Some(layout) } else { None };
    let exr = if let Some(Layout::Exr(layout)) = args.layout { Some(layout) } else { None };
    let matlab = if let Some(Layout::Matlab(version)) = args.layout { Some(version) } else { None };
    let format = Format::of(path);
    let picture = has_extension(path, &["png"]) || (format == Some(Format::Tiff) && tiff.is_none());
    ensure!(
        format.is_some() || picture,
        "{}: expected a name that ends in .exr, .mat, .h5, .hdr, .npz, .npy, .png or .tif",
        path.display()
    );
    ensure!(exr.is_none() || format == Some(Format::Exr), "--layout fichet2021 and pbrt apply to .exr");
    ensure!(matlab.is_none() || format == Some(Format::Mat), "--layout v5 and v7.3 apply to .mat");
    ensure!(tiff.is_none() || format == Some(Format::Tiff), "--layout pages and samples apply to .tif");
    ensure!(args.interleave.is_none() || format == Some(Format::Envi), "--interleave applies to ENVI (.hdr)");
    ensure!(!args.compress || tiff.is_some(), "--compress applies to .tif with --layout pages or samples");
    let tiff = spectral_tiff::WriteOptions { layout: tiff.unwrap_or_default(), deflate: args.compress };
    Ok((!picture).then_some(WriteOptions { interleave: args.interleave, exr, matlab, tiff }))
}

/// The unchanged spectral file, unless it must become a scene. It is read while the new file is written.
fn as_it_is(args: &Convert) -> anyhow::Result<Option<Box<dyn Tiles>>> {
    let options = &args.scene_options;
    if !resolve::is_file(&args.scene) || options.luminance.is_some() || options.illuminant.is_some() {
        return Ok(None);
    }
    let path = Path::new(&args.scene);
    let read = resolve::read_options(options)?;
    let Some(tiles) = scene_file::open(path, &read)? else { return Ok(None) };
    let tiles: Box<dyn Tiles> = match read.crop {
        Some(part) => Box::new(Cropped::new(tiles, part, path)?),
        None => tiles,
    };
    if read.grid.is_some_and(|grid| !grid.wavelengths_nm().eq(tiles.header().wavelengths_nm.iter().copied()))
    {
        return Ok(None);
    }
    Ok(Some(Box::new(Restated::new(tiles, options.distance, options.fov))))
}

fn write_spectral(
    args: &Convert,
    file: Box<dyn Tiles>,
    options: &WriteOptions,
    common: &Common,
) -> anyhow::Result<Vec<String>> {
    let path = &args.output;
    if !has_extension(path, &["npy"]) {
        return Ok(scene_file::write(path, &file, options)?);
    }
    // An .npy does not state its quantity: the values are always photons.
    match Photons::new(file) {
        Ok(photons) => Ok(scene_file::write(path, &photons, options)?),
        Err(_) => {
            let scene = SpectralFile::of_scene(&scene(args, common)?);
            Ok(scene_file::write(path, &Whole::new(&scene), options)?)
        }
    }
}

fn write_picture(path: &Path, scene: &Scene) -> anyhow::Result<Vec<String>> {
    let image = Image::new(ColorSpace::Xyz, scene.xyz()?)?;
    let gain = image.brightness_gain();
    let image = image.scaled(gain);
    picture::write(path, &image.converted(ColorSpace::Srgb)?, Depth::Eight)?;
    let instead =
        if has_extension(path, &["png"]) { "" } else { " (use --layout pages or samples to keep them)" };
    Ok(vec![format!("{} is a picture without spectra{instead}", path.display())])
}
