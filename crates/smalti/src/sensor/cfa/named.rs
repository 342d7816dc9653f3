//! The built-in filters: formulas for every kind of cell in the catalogue, and published curves.

use super::CfaError;
use super::curves;
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

const HUFKENS: &str = "Traced by Koen Hufkens from the maker's figure; numbers from scivision/raspicam-spectra, commit 94d386d \
    (MIT, © 2015 Michael Hirsch).";
const IMX219: &str = "Sony IMX219 (Raspberry Pi camera 2): filter and photodiode without infrared cut, relative to the largest value \
    of the three; zero outside 400–700 nm.";
const OV5647: &str = "OmniVision OV5647 (Raspberry Pi camera 1): filter and photodiode without infrared cut, relative to the largest \
    value of the three; zero outside 400–700 nm.";
const ACADEMY: &str = "Academy of Motion Picture Arts and Sciences (2017): AcademySoftwareFoundation/rawtoaces-data, commit f5f6cf2 \
    (Apache-2.0).";
const SONY_7RM2: &str = "Sony ILCE-7RM2 (A7R II): whole camera, infrared cut included, relative to the largest value of the three; zero \
    outside 380–700 nm.";
const CANON_5D2: &str = "Canon EOS 5D Mark II: whole camera, infrared cut included, relative to the largest value of the three; zero \
    outside 380–700 nm.";
const DCS620X: &str = "Kodak DCS620x: absolute quantum efficiency of the whole camera, infrared cut included; zero outside 400–700 nm. To be \
    used with an ideal photodiode.";
const LANSEL: &str = "Traced by Steven Lansel (2010) from the maker's figure: ISET/isetL3, data/sensors/KodakDCS620x Raw, commit 497c251; \
    read every 10 nm.";
const CMV12000: &str = "ams CMV12000: absolute quantum efficiency of filter and photodiode, without infrared cut. To be used with an \
    ideal photodiode.";
const DATASHEET: &str = "Digitised from figure 8 of the datasheet: ams, CMV12000, DS000603, v5-00 (2022).";
const PIGMENT: &str = "Pigment of the CMV12000: the quantum efficiency of the colour device divided by that of the monochrome device, \
    smoothed; 400–1000 nm, constant outside. It transmits infrared.";
const SUBTRACTIVE: &str = "Pigment of the Kodak DCS620x: the quantum efficiency of the whole camera behind the filter, divided by the largest of the \
    three filters at each wavelength, 400–700 nm, constant outside. Two of the three pigments are nearly clear at every wavelength, so \
    that this is the transmittance relative to theirs. Curves: see kodak-dcs620x/C.";
const APERTUS: &str =
    "Spectrophotometer of the apertus° AXIOM team, 2019: plot of absorbance, curve \"UQG\", digitised.";

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
        "Quantum efficiency of a back-illuminated photodiode, 3.5 µm deep: 0.81 at 500 nm, 0.15 at 850 nm.",
        "Absorption of silicon: Green, Sol. Energy Mater. Sol. Cells 92, 1305 (2008), doi:10.1016/j.solmat.2008.06.009.",
    ),
    info("ir-cut", "Infrared-cut filter with a smooth edge near 650 nm.", FORMULA),
    info("nikon-d5100/R", D5100, DARRODI),
    info("nikon-d5100/G", D5100, DARRODI),
    info("nikon-d5100/B", D5100, DARRODI),
    info("sigma-sd-merrill/R", MERRILL, DARRODI),
    info("sigma-sd-merrill/G", MERRILL, DARRODI),
    info("sigma-sd-merrill/B", MERRILL, DARRODI),
    info("imx219/R", IMX219, HUFKENS),
    info("imx219/G", IMX219, HUFKENS),
    info("imx219/B", IMX219, HUFKENS),
    info("ov5647/R", OV5647, HUFKENS),
    info("ov5647/G", OV5647, HUFKENS),
    info("ov5647/B", OV5647, HUFKENS),
    info("sony-ilce-7rm2/R", SONY_7RM2, ACADEMY),
    info("sony-ilce-7rm2/G", SONY_7RM2, ACADEMY),
    info("sony-ilce-7rm2/B", SONY_7RM2, ACADEMY),
    info("canon-eos-5d-mark-ii/R", CANON_5D2, ACADEMY),
    info("canon-eos-5d-mark-ii/G", CANON_5D2, ACADEMY),
    info("canon-eos-5d-mark-ii/B", CANON_5D2, ACADEMY),
    info("kodak-dcs620x/C", DCS620X, LANSEL),
    info("kodak-dcs620x/M", DCS620X, LANSEL),
    info("kodak-dcs620x/Y", DCS620X, LANSEL),
    info("cmv12000/R", CMV12000, DATASHEET),
    info("cmv12000/G", CMV12000, DATASHEET),
    info("cmv12000/B", CMV12000, DATASHEET),
    info(
        "cmv12000/mono",
        "ams CMV12000, monochrome device: absolute quantum efficiency, without infrared cut.",
        DATASHEET,
    ),
    info("pigment/R", PIGMENT, DATASHEET),
    info("pigment/G", PIGMENT, DATASHEET),
    info("pigment/B", PIGMENT, DATASHEET),
    info("pigment/C", SUBTRACTIVE, LANSEL),
    info("pigment/M", SUBTRACTIVE, LANSEL),
    info("pigment/Y", SUBTRACTIVE, LANSEL),
    info(
        "hot-mirror",
        "Infrared-cut filter of a camera, ultraviolet cut included (UQG Optics): half transmission at 392 and 643 nm; 380–1000 nm, \
         constant outside.",
        APERTUS,
    ),
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
        "pigment/C" => subtractive(0, grid),
        "pigment/M" => subtractive(1, grid),
        "pigment/Y" => subtractive(2, grid),
        "silicon" => Ok(QuantumEfficiency::SILICON.spectrum(grid)?),
        "ir-cut" => Ok(crate::optics::builtin::ir_cut(grid)?),
        _ => {
            if let Some((k, n)) = band(name) {
                let spacing = 300.0 / n;
                // The full width at half maximum of a Gaussian is 2.3548 standard deviations.
                return gaussian(400.0 + spacing * (k - 0.5), spacing / 2.354_820_045);
            }
            curves::spectrum(name, grid)?.ok_or_else(|| CfaError::UnknownName {
                what: "filter",
                name: name.into(),
                suggestion: nearest(name, INFOS.iter().map(|i| i.name)).map(str::to_owned),
            })
        }
    }
}

/// The transmittance of a pigment of the Kodak DCS620x relative to the clearest of the three.
fn subtractive(pigment: usize, grid: WavelengthGrid) -> Result<Spectrum, CfaError> {
    let own = WavelengthGrid::new(400.0, 10.0, 31)?;
    let curves = ["C", "M", "Y"].map(|letter| spectrum(&format!("kodak-dcs620x/{letter}"), own));
    let [cyan, magenta, yellow] = curves;
    let all = [cyan?, magenta?, yellow?];
    let of = |i: usize| {
        let clearest = all.iter().map(|s| s.values()[i]).fold(f64::MIN_POSITIVE, f64::max);
        all[pigment].values()[i] / clearest
    };
    let relative = Spectrum::new(own, (0..own.len()).map(of).collect())?;
    Ok(relative.resampled(grid, Extrapolation::Hold)?)
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
