//! Raw files of cameras.

use std::error::Error;
use std::path::Path;

use anyhow::anyhow;
use clap::Args;
use smalti::camera::CameraError;
use smalti::experiment::ExperimentError;
use smalti::l3::L3Error;
use smalti_io::Limits;
use smalti_io::dng::{self, Dng, StatedMosaic};
use smalti_report::in_one_line;

/// Options for raw files.
#[derive(Debug, Clone, Args)]
pub(crate) struct RawOptions {
    /// The mosaic of the raw files, if they state none or a wrong one, as telephones do for Quad Bayer: a name (smalti list cfas), or
    /// rows of letters that begin at the first pixel of the active area, such as GR/BG
    #[arg(long, value_name = "MOSAIC")]
    pub(crate) raw_cfa: Option<StatedMosaic>,
}

impl RawOptions {
    /// Reads a raw file. `note` is told what was simplified or ignored, and of which file.
    pub(crate) fn read(&self, path: &Path, note: impl Fn(&str)) -> anyhow::Result<Dng> {
        let dng = dng::read_as(path, Limits::default(), self.raw_cfa.as_ref())?;
        dng.notes.iter().for_each(|text| note(&format!("{}: {text}", path.display())));
        Ok(dng)
    }
}

/// The error about a raw file of another mosaic than is expected names the option that states the mosaic.
pub(crate) fn naming_the_option(error: anyhow::Error) -> anyhow::Error {
    let of_mosaic = |error: &L3Error| matches!(error, L3Error::Mosaic { .. } | L3Error::NoMosaic);
    let is_of_mosaic = |error: &(dyn Error + 'static)| match error.downcast_ref::<ExperimentError>() {
        Some(ExperimentError::Stage { source, .. }) => {
            matches!(&**source, CameraError::L3(e) if of_mosaic(e))
        }
        _ => error.downcast_ref::<L3Error>().is_some_and(of_mosaic),
    };
    if !error.chain().any(is_of_mosaic) {
        return error;
    }
    let words = in_one_line(error.as_ref());
    anyhow!("{words} (--raw-cfa states the mosaic of raw files that state none or a wrong one)")
}
