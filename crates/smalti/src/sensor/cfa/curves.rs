//! Published curves among the built-in filters.

use super::generated::curves::{
    CANON_5D2, CMV12000, HOT_MIRROR, IMX219, KODAK_DCS620X, OV5647, PIGMENTS, SONY_7RM2,
};
use super::generated::{NIKON_D5100, SIGMA_SD_MERRILL};
use crate::spectrum::{Extrapolation, Spectrum, SpectrumError, WavelengthGrid};

/// The curve of a name; `None` when there is none.
pub(super) fn spectrum(name: &str, grid: WavelengthGrid) -> Result<Option<Spectrum>, SpectrumError> {
    if name == "hot-mirror" {
        return HOT_MIRROR.spectrum(0, grid, Extrapolation::Hold).map(Some);
    }
    let Some((set, channel)) = name.split_once('/') else { return Ok(None) };
    let columns: &[&str] = match set {
        "cmv12000" => &["R", "G", "B", "mono"],
        "kodak-dcs620x" => &["C", "M", "Y"],
        _ => &["R", "G", "B"],
    };
    let Some(column) = columns.iter().position(|c| *c == channel) else { return Ok(None) };
    // A sensitivity is taken as zero where it was not measured, a transmittance as at the end of the table.
    let table = match set {
        "nikon-d5100" => &NIKON_D5100,
        "sigma-sd-merrill" => &SIGMA_SD_MERRILL,
        "imx219" => &IMX219,
        "ov5647" => &OV5647,
        "sony-ilce-7rm2" => &SONY_7RM2,
        "canon-eos-5d-mark-ii" => &CANON_5D2,
        "kodak-dcs620x" => &KODAK_DCS620X,
        "cmv12000" => return CMV12000.spectrum(column, grid, Extrapolation::Zero).map(Some),
        "pigment" => return PIGMENTS.spectrum(column, grid, Extrapolation::Hold).map(Some),
        _ => return Ok(None),
    };
    table.spectrum(column, grid, Extrapolation::Zero).map(Some)
}
