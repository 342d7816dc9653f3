//! The built-in filters: formulas for every kind of cell in the catalogue, and measured cameras.

use super::CfaError;
use super::generated::{NIKON_D5100, SIGMA_SD_MERRILL};
use super::shapes::{self, logistic};
use crate::names::nearest;
use crate::sensor::QuantumEfficiency;
use crate::spectrum::{Extrapolation, Spectrum, WavelengthGrid};

/// A built-in filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FilterInfo {
    /// Its name, as in `{ builtin = "red" }`.
    pub name: &'static str,
    /// A short description.
    pub summary: &'static str,
    /// The origin of the numbers.
    pub source: &'static str,
}

const FORMULA: &str = "Formula of this library, in the manner of pigment filters; not a measurement.";
const DARRODI: &str = "Measured at NPL: Darrodi, Finlayson, Goodman, Mackiewicz, J. Opt. Soc. Am. A 32(3), 381 (2015), \
    doi:10.1364/JOSAA.32.000381; numbers read from colour-science 0.4.7 (BSD-3-Clause).";
const D5100: &str = "Nikon D5100: spectral sensitivity of the whole camera (filter, quantum efficiency, infrared cut), each \
    channel relative to its own maximum; zero outside 380–780 nm. Use it with an ideal photodiode.";
const MERRILL: &str = "Sigma SD Merrill (layered sensor): spectral sensitivity of the whole camera (layer, quantum efficiency, \
    infrared cut), each channel relative to its own maximum; zero outside 400–680 nm. Use it with an ideal photodiode.";

const fn info(name: &'static str, summary: &'static str, source: &'static str) -> FilterInfo {
    FilterInfo { name, summary, source }
}

static INFOS: &[FilterInfo] = &[
    info("red", "Pass above 580 nm, infrared blocked from 680 nm; peak 0.9.", FORMULA),
    info("green", "Pass between 495 and 580 nm: 0.9 times the product of both edges.", FORMULA),
    info("blue", "Pass below 495 nm; peak 0.9.", FORMULA),
    info("cyan", "The sum of green and blue.", FORMULA),
    info("magenta", "The sum of red and blue.", FORMULA),
    info("yellow", "The sum of red and green.", FORMULA),
    info("emerald", "Gaussian at 500 nm, sigma 25 nm, peak 0.9.", FORMULA),
    info(
        "white",
        "No colour filter: transmittance 0.95 at all wavelengths, including the infrared.",
        FORMULA,
    ),
    info("clear", "The same as white.", FORMULA),
    info("infrared", "Pass above 790 nm, peak 0.9: dark on a grid that ends at 700 nm.", FORMULA),
    info("red+infrared", "Red filter that also transmits above 790 nm, as pigments do.", FORMULA),
    info("green+infrared", "Green filter that also transmits above 790 nm, as pigments do.", FORMULA),
    info("blue+infrared", "Blue filter that also transmits above 790 nm, as pigments do.", FORMULA),
    info("five-band/B", "Gaussian at 450 nm, sigma 20 nm, peak 0.9.", FORMULA),
    info("five-band/C", "Gaussian at 500 nm, sigma 20 nm, peak 0.9.", FORMULA),
    info("five-band/G", "Gaussian at 550 nm, sigma 20 nm, peak 0.9.", FORMULA),
    info("five-band/O", "Gaussian at 600 nm, sigma 20 nm, peak 0.9.", FORMULA),
    info("five-band/R", "Gaussian at 650 nm, sigma 20 nm, peak 0.9.", FORMULA),
    info("narrow", "Gaussian at 540 nm, sigma 10 nm, peak 0.9: the absorption of haemoglobin.", FORMULA),
    info(
        "band-1-of-9",
        "Band k of n (1 ≤ k ≤ n ≤ 64, any numbers): evenly spaced Gaussians over 400–700 nm, whose full width at \
         half maximum equals their spacing; peak 0.9.",
        FORMULA,
    ),
    info(
        "silicon",
        "Quantum efficiency of a back-illuminated photodiode, 3.5 µm deep: 0.78 at 500 nm, 0.15 at 850 nm.",
        "Absorption of silicon: Green, Sol. Energy Mater. Sol. Cells 92, 1305 (2008), doi:10.1016/j.solmat.2008.06.009.",
    ),
    info("ir-cut", "Infrared-cut filter with a smooth edge near 650 nm.", FORMULA),
    info("nikon-d5100/R", D5100, DARRODI),
    info("nikon-d5100/G", D5100, DARRODI),
    info("nikon-d5100/B", D5100, DARRODI),
    info("sigma-sd-merrill/R", MERRILL, DARRODI),
    info("sigma-sd-merrill/G", MERRILL, DARRODI),
    info("sigma-sd-merrill/B", MERRILL, DARRODI),
];

/// The filters of [`Filter::Builtin`](super::Filter::Builtin). The formulas supply a filter for each letter of the catalogue's
/// arrays. Designs that are to be compared should specify their own.
#[must_use]
pub fn builtin_filters() -> &'static [FilterInfo] {
    INFOS
}

/// Transmittance of a built-in filter.
pub(super) fn spectrum(name: &str, grid: WavelengthGrid) -> Result<Spectrum, CfaError> {
    let blue = |nm: f64| logistic((BLUE_GREEN_NM - nm) / EDGE_NM);
    let red_side = |nm: f64| logistic((nm - GREEN_RED_NM) / EDGE_NM);
    let cut = |nm: f64| logistic((CUT_NM - nm) / CUT_EDGE_NM);
    let green = |nm: f64| (1.0 - blue(nm)) * (1.0 - red_side(nm));
    let red = |nm: f64| (1.0 - blue(nm)) * red_side(nm) * cut(nm);
    let infrared = |nm: f64| logistic((nm - INFRARED_NM) / EDGE_NM);
    // The infrared leak transmits a share of the light that the dye absorbs, so the sum stays below the peak.
    let opening = |dye: f64, nm: f64| dye + (1.0 - dye) * infrared(nm);
    let formula = |f: &dyn Fn(f64) -> f64| Ok(Spectrum::from_fn(grid, |nm| PEAK * f(nm))?);
    let gaussian = |center_nm, sigma_nm| formula(&|nm| shapes::gaussian(nm, center_nm, sigma_nm));
    match name {
        "red" => formula(&red),
        "green" => formula(&green),
        "blue" => formula(&blue),
        "cyan" => formula(&|nm| green(nm) + blue(nm)),
        "magenta" => formula(&|nm| red(nm) + blue(nm)),
        "yellow" => formula(&|nm| red(nm) + green(nm)),
        "infrared" => formula(&infrared),
        "red+infrared" => formula(&|nm| opening(red(nm), nm)),
        "green+infrared" => formula(&|nm| opening(green(nm), nm)),
        "blue+infrared" => formula(&|nm| opening(blue(nm), nm)),
        "white" | "clear" => Ok(Spectrum::constant(grid, 0.95)?),
        "emerald" => gaussian(500.0, 25.0),
        "five-band/B" => gaussian(450.0, 20.0),
        "five-band/C" => gaussian(500.0, 20.0),
        "five-band/G" => gaussian(550.0, 20.0),
        "five-band/O" => gaussian(600.0, 20.0),
        "five-band/R" => gaussian(650.0, 20.0),
        "narrow" => gaussian(540.0, 10.0),
        "silicon" => Ok(QuantumEfficiency::SILICON.spectrum(grid)?),
        "ir-cut" => Ok(crate::optics::builtin::ir_cut(grid)?),
        "nikon-d5100/R" => Ok(NIKON_D5100.spectrum(0, grid, Extrapolation::Zero)?),
        "nikon-d5100/G" => Ok(NIKON_D5100.spectrum(1, grid, Extrapolation::Zero)?),
        "nikon-d5100/B" => Ok(NIKON_D5100.spectrum(2, grid, Extrapolation::Zero)?),
        "sigma-sd-merrill/R" => Ok(SIGMA_SD_MERRILL.spectrum(0, grid, Extrapolation::Zero)?),
        "sigma-sd-merrill/G" => Ok(SIGMA_SD_MERRILL.spectrum(1, grid, Extrapolation::Zero)?),
        "sigma-sd-merrill/B" => Ok(SIGMA_SD_MERRILL.spectrum(2, grid, Extrapolation::Zero)?),
        _ => match band(name) {
            Some((k, n)) => {
                let spacing = 300.0 / n;
                // The full width at half maximum of a Gaussian is 2.3548 standard deviations.
                gaussian(400.0 + spacing * (k - 0.5), spacing / 2.354_820_045)
            }
            None => Err(CfaError::UnknownName {
                what: "filter",
                name: name.into(),
                suggestion: nearest(name, INFOS.iter().map(|i| i.name)).map(str::to_owned),
            }),
        },
    }
}

/// Parses `band-k-of-n` into (k, n).
fn band(name: &str) -> Option<(f64, f64)> {
    let (k, n) = name.strip_prefix("band-")?.split_once("-of-")?;
    let (k, n): (u8, u8) = (k.parse().ok()?, n.parse().ok()?);
    (1 <= k && k <= n && n <= 64).then(|| (k.into(), n.into()))
}

// The edges of the generic set are typical: they lie near the crossings of the Nikon D5100's curves (499 and
// 579 nm). 10 % to 90 % takes 53 nm, as in pigment filters. Red, green and blue add up to at most PEAK.
const BLUE_GREEN_NM: f64 = 495.0;
const GREEN_RED_NM: f64 = 580.0;
const EDGE_NM: f64 = 12.0;
const CUT_NM: f64 = 680.0;
const CUT_EDGE_NM: f64 = 6.0;
const INFRARED_NM: f64 = 790.0;
const PEAK: f64 = 0.9;
