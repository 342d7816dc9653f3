//! `smalti render`: a raw file through a learned pipeline.

use std::path::Path;

use anyhow::{Context, bail};
use serde_json::json;
use smalti::color::{ColorSpace, Image};
use smalti::l3::{Pipeline, Rendered};
use smalti_io::picture::{self, Depth};
use smalti_io::{Limits, dng, l3, npy};

use crate::args::{Common, Render};
use crate::progress::Progress;
use crate::resolve::has_extension;

pub(crate) fn run(args: &Render, common: &Common) -> anyhow::Result<()> {
    if !has_extension(&args.output, &["npy", "png", "tif", "tiff"]) {
        bail!("{}: expected a name that ends in .png, .tif or .npy", args.output.display());
    }
    let progress = Progress::new(3, common.quiet);
    progress.begin("reading");
    let pipeline = l3::read_table(&args.pipeline)?;
    let dng = dng::read(&args.raw, Limits::default())?;
    dng.notes.iter().for_each(|note| progress.note(&format!("{}: {note}", args.raw.display())));
    // A raw file may list its channels in another order than the pipeline does; names tell.
    let raw = dng.raw.with_channels(pipeline.channel_names());
    progress.done();
    progress.begin("rendering");
    let about = || format!("{} with {}", args.raw.display(), args.pipeline.display());
    let rendered = if args.fixed { pipeline.render_fixed(&raw) } else { pipeline.render_raw(&raw) };
    let rendered = rendered.with_context(about)?;
    progress.done();
    progress.begin("writing");
    write(args, &pipeline, &rendered)?;
    progress.finish();
    let outside = &rendered.outside;
    if args.json {
        let report = json!({
            "smalti_version": env!("CARGO_PKG_VERSION"),
            "output": args.output.display().to_string(),
            "arithmetic": if args.fixed { "fixed point" } else { "single precision" },
            "rows": rendered.planes.rows(),
            "cols": rendered.planes.cols(),
            "outputs": pipeline.outputs(),
            "pixels_darker_than_trained": outside.darker,
            "pixels_brighter_than_trained": outside.brighter,
            "pixels_clipped_unlike_trained": outside.saturation,
        });
        return crate::print(&(serde_json::to_string_pretty(&report)? + "\n"));
    }
    for (count, what) in [
        (outside.darker, "darker than anything trained"),
        (outside.brighter, "brighter than anything trained"),
        (outside.saturation, "with channels clipped together that never were in training"),
    ] {
        if count > 0 {
            let total = rendered.planes.rows() * rendered.planes.cols();
            progress.note(&format!("{count} of {total} pixels are {what}; the nearest class was used"));
        }
    }
    crate::print(&format!("{}\n", args.output.display()))
}

fn write(args: &Render, pipeline: &Pipeline, rendered: &Rendered) -> anyhow::Result<()> {
    if has_extension(&args.output, &["npy"]) {
        let p = &rendered.planes;
        return Ok(npy::write(&args.output, &[p.count(), p.rows(), p.cols()], p.data())?);
    }
    let Some(white) = pipeline.white() else {
        bail!(
            "{}: {} gives {}, which is no picture: name an .npy to write them as they are",
            args.output.display(),
            args.pipeline.display(),
            pipeline.outputs().join(", "),
        );
    };
    let picture = Image::new(ColorSpace::Xyz, rendered.planes.clone())?;
    let gain = args.gain.unwrap_or_else(|| picture.brightness_gain());
    let depth = if args.bits == "16" { Depth::Sixteen } else { Depth::Eight };
    Ok(picture::write(Path::new(&args.output), &picture.shown(Some(white), gain)?, depth)?)
}
