//! The filters and the mosaic of an array as files.

use std::path::Path;

use smalti::design::Design;
use smalti::experiment::DesignTask;
use smalti::spectrum::Spectrum;
use smalti_io::spectrum_csv;
use smalti_report::Figure;

/// The transmittances as a table with a column for each letter.
pub(super) fn write_filters(path: &Path, design: &Design, task: &DesignTask) -> anyhow::Result<()> {
    let cfa = design.cfa(task.camera.grid())?;
    let columns: Vec<(&str, &Spectrum)> =
        cfa.channels().iter().map(|c| (c.name.as_str(), &c.transmittance)).collect();
    Ok(spectrum_csv::write(path, &columns)?)
}

pub(super) fn mosaic_figure(design: &Design, task: &DesignTask) -> anyhow::Result<Figure> {
    let cfa = design.cfa(task.camera.grid())?;
    crate::show::mosaic_figure(&cfa)
}
