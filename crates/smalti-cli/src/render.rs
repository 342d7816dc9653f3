//! `smalti render`: renders a raw file with a learned pipeline.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use serde_json::json;
use smalti::color::{ColorSpace, Image};
use smalti::l3::{Pipeline, Quality, Rendered};
use smalti_io::dng::{self, Crop, Dng, DngPicture};
use smalti_io::picture::{self, Depth};
use smalti_io::{Orientation, l3, npy};

use crate::args::{Common, choice};
use crate::learning_args::QUALITIES;
use crate::numbers::positive;
use crate::progress::Progress;
use crate::raw_args::RawOptions;
use crate::resolve::has_extension;
use smalti::experiment::Progress as _;

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti render out/raw.dng --pipeline rgbw.l3 -o picture.png\n  \
    smalti render out/raw.dng --pipeline rgbw.l3 -o linear.dng   a raw developer that refuses the mosaic goes on from here\n  \
    smalti render out/raw.dng --pipeline rgbw.l3 -o xyz.npy\n\n\
    A pixel that is darker or brighter than the training data is rendered with the nearest class. A note reports the number of such pixels.")]
pub(crate) struct Render {
    /// A raw file (DNG)
    pub(crate) raw: PathBuf,
    /// A learned table (smalti train)
    #[arg(long, value_name = "FILE.l3")]
    pub(crate) pipeline: PathBuf,
    /// .png or .tif (sRGB for a display, upright), .dng (linear, 16 bits, before white balance and tone curve, for a raw developer) or .npy
    /// (the unscaled outputs X, Y, Z, where a white diffuser has at most Y = 1, in rows and columns of the sensor)
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Stages to render with: a table of quality best also renders with its first stage alone [default: that of the table]
    #[arg(long, value_parser = choice(&QUALITIES))]
    pub(crate) quality: Option<Quality>,
    /// Compute in fixed point with 16-bit kernels, as an image signal processor does; needs digital numbers in the raw file
    #[arg(long)]
    pub(crate) fixed: bool,
    /// Gain of the picture [default: all but the brightest half percent are within the range of the display]
    #[arg(long, value_name = "FACTOR", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) gain: Option<f64>,
    /// Bits per channel of a .png or .tif
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    pub(crate) bits: String,
    #[command(flatten)]
    pub(crate) raw_options: RawOptions,
    /// Print a summary as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &Render, common: &Common) -> anyhow::Result<()> {
    if !has_extension(&args.output, &["npy", "png", "tif", "tiff", "dng"]) {
        bail!("{}: expected a name that ends in .png, .tif, .dng or .npy", args.output.display());
    }
    let progress = Progress::new(3, common.quiet);
    progress.begin("reading");
    let mut pipeline = l3::read_table(&args.pipeline)?;
    if let Some(quality) = args.quality {
        let about = || format!("--quality {} with {}", quality.name(), args.pipeline.display());
        pipeline = pipeline.at_quality(quality).with_context(about)?;
    }
    let Dng { raw, orientation, default_crop, .. } =
        args.raw_options.read(&args.raw, |text| progress.note(text))?;
    // A raw file may list its channels in another order than the pipeline; names identify them.
    let raw = raw.with_channels(pipeline.channel_names());
    progress.done();
    progress.begin("rendering");
    let about = || format!("{} with {}", args.raw.display(), args.pipeline.display());
    let rendered = if args.fixed { pipeline.render_fixed(&raw) } else { pipeline.render_raw(&raw) };
    let rendered = rendered.with_context(about)?;
    progress.done();
    progress.begin("writing");
    write(args, &pipeline, &rendered, (orientation, default_crop))?;
    progress.finish();
    let outside = &rendered.outside;
    if args.json {
        let report = json!({
            "smalti_version": env!("CARGO_PKG_VERSION"),
            "output": args.output.display().to_string(),
            "quality": pipeline.quality().name(),
            "arithmetic": if args.fixed { "fixed point" } else { "single precision" },
            "rows": rendered.planes.rows(),
            "cols": rendered.planes.cols(),
            "outputs": pipeline.outputs(),
            "pixels_darker_than_trained": outside.darker,
            "pixels_brighter_than_trained": outside.brighter,
            "pixels_clipped_unlike_trained": outside.saturation,
        });
        return crate::output::print_json(&report);
    }
    for (count, what) in [
        (outside.darker, "darker than the training data"),
        (outside.brighter, "brighter than the training data"),
        (outside.saturation, "clipped in a combination of channels that does not occur in the training data"),
    ] {
        if count > 0 {
            let total = rendered.planes.rows() * rendered.planes.cols();
            progress.note(&format!("{count} of {total} pixels are {what} and use the nearest class"));
        }
    }
    crate::print(&format!("{}\n", args.output.display()))
}

/// Writes the picture with the orientation and the part to be shown that the raw file states.
fn write(
    args: &Render,
    pipeline: &Pipeline,
    rendered: &Rendered,
    (orientation, default_crop): (Orientation, Option<Crop>),
) -> anyhow::Result<()> {
    if has_extension(&args.output, &["npy"]) {
        let p = &rendered.planes;
        return Ok(npy::write(&args.output, &[p.count(), p.rows(), p.cols()], p.data())?);
    }
    let Some(white) = pipeline.white() else {
        bail!(
            "{}: the outputs of {} are {}, not a picture; use the extension .npy to write them",
            args.output.display(),
            args.pipeline.display(),
            pipeline.outputs().join(", "),
        );
    };
    let picture = Image::new(ColorSpace::Xyz, rendered.planes.clone())?;
    if has_extension(&args.output, &["dng"]) {
        let model = args.pipeline.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let gain = args.gain.unwrap_or_else(|| picture.brightness_gain());
        let stated = DngPicture { white, gain, model, orientation, default_crop };
        return Ok(dng::write_picture(&args.output, &picture, &stated)?);
    }
    let depth = if args.bits == "16" { Depth::Sixteen } else { Depth::Eight };
    // As `smalti simulate` takes the brightness: from the picture with its white balanced.
    let balanced = picture.balanced(Some(white))?;
    let gain = args.gain.unwrap_or_else(|| balanced.brightness_gain());
    let shown = orientation.apply(balanced.shown(None, gain)?);
    Ok(picture::write(Path::new(&args.output), &shown, depth)?)
}
