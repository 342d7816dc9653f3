//! `smalti convert`: a scene to another format.

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use smalti::color::{ColorSpace, Image};
use smalti_io::SpectralFile;
use smalti_io::exr::{self, Layout};
use smalti_io::npy;
use smalti_io::picture::{self, Depth};

use crate::args::{Common, SceneOptions};
use crate::brightness::{brightness_gain, scaled};
use crate::progress::Progress;
use crate::resolve::{self, has_extension};

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

pub(crate) fn run(args: &Convert, common: &Common) -> anyhow::Result<()> {
    let progress = Progress::new(2, common.quiet);
    progress.begin("reading");
    let scene = resolve::scene(&args.scene, &args.scene_options).with_context(|| {
        match &args.scene_options.wavelengths {
            Some(w) => format!("{} at --wavelengths {w}", args.scene),
            None => args.scene.clone(),
        }
    })?;
    progress.done();
    progress.begin("writing");
    let path = &args.output;
    if has_extension(path, &["exr"]) {
        let layout = match args.layout {
            ExrLayout::Fichet2021 => Layout::Fichet2021,
            ExrLayout::Pbrt => Layout::Pbrt,
        };
        exr::write(path, &SpectralFile::of_scene(&scene).into_energy()?, layout)?;
    } else if has_extension(path, &["png", "tif", "tiff"]) {
        let image = Image::new(ColorSpace::Xyz, scene.xyz()?)?;
        let image = scaled(&image, brightness_gain(&image))?;
        picture::write(path, &image.converted(ColorSpace::Srgb)?, Depth::Eight)?;
    } else if has_extension(path, &["npy"]) {
        let cube = scene.radiance();
        npy::write(path, &[cube.grid().len(), cube.rows(), cube.cols()], cube.planes().data())?;
    } else {
        bail!("{}: expected a name that ends in .exr, .png, .tif or .npy", path.display());
    }
    progress.finish();
    crate::print(&format!("{}\n", path.display()))
}
