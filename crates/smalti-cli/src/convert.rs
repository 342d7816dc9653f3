//! `smalti convert`: a scene to another format.

use anyhow::{Context, bail};
use smalti::color::{ColorSpace, Image};
use smalti_io::exr::{self, Layout, SpectralFile};
use smalti_io::npy;
use smalti_io::picture::{self, Depth};

use crate::args::{Common, Convert, ExrLayout};
use crate::brightness::{brightness_gain, scaled};
use crate::progress::Progress;
use crate::resolve::{self, has_extension};

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
