//! Measured reflectances: a colour chart, natural objects, paints, and surfaces of all kinds.

use super::generated::{
    COLORCHECKER, COLORCHECKER_NAMES, NATURAL, NATURAL_NAMES, PAINT, PAINT_NAMES, SURFACE_NAMES, SURFACES,
    Table,
};
use super::{Extrapolation, Spectrum, SpectrumError, WavelengthGrid};

/// Reflectances (0 to 1) of the 24 patches of the ColorChecker with their names, row by row from dark skin,
/// so that the grey series is last. Measured at 380–730 nm in steps of 10 nm and held constant beyond.
/// Average of 30 charts (Pascale, BabelColor, 2012).
///
/// # Errors
/// Never for a valid grid.
pub fn colorchecker(grid: WavelengthGrid) -> Result<Vec<(&'static str, Spectrum)>, SpectrumError> {
    named(&COLORCHECKER, &COLORCHECKER_NAMES, grid)
}

/// Reflectances (0 to 1) of natural objects with their names: flowers, leaves, fruits, vegetables, barks and
/// stones. Measured at 380–780 nm and held constant beyond. A selection, in steps of 10 nm, from the 359
/// spectra of Morimoto et al. (2022), "Spectral measurement of daylights and surface properties of natural
/// objects in Japan", *Optics Express* 30(3), <https://doi.org/10.5281/zenodo.5189606>, CC BY 4.0. Below 400
/// nm the spectra of small objects are noisy.
///
/// # Errors
/// Never for a valid grid.
pub fn natural(grid: WavelengthGrid) -> Result<Vec<(&'static str, Spectrum)>, SpectrumError> {
    named(&NATURAL, &NATURAL_NAMES, grid)
}

/// Reflectances (0 to 1) of matte painted chips with their names (Munsell hue value/chroma). Measured at 380–780 nm and held constant
/// beyond. 64 of the 1269 chips of the Munsell Book of Color, Matte Finish Collection, that J. Hiltunen measured at the University of
/// Joensuu, chosen for variety. White pigment absorbs light below 430 nm.
///
/// # Errors
/// Never for a valid grid.
pub fn paints(grid: WavelengthGrid) -> Result<Vec<(&'static str, Spectrum)>, SpectrumError> {
    named(&PAINT, &PAINT_NAMES, grid)
}

/// Reflectances (0 to 1) of surfaces with their names: minerals, building materials, pigments, fabrics and plants of the
/// USGS Spectral Library (Kokaly et al. 2017), human skin (Cooksey, Allen and Tsai 2017, NIST), and the test colour
/// samples of CIE 224:2017 (`TCS`). Means over bands of 10 nm from 400 to 700 nm, held constant beyond. The path-traced
/// test scenes are made of them, and photographs are repainted with them. `tools/scenes/README.md` states the licences.
///
/// # Errors
/// Never for a valid grid.
pub fn surfaces(grid: WavelengthGrid) -> Result<Vec<(&'static str, Spectrum)>, SpectrumError> {
    named(&SURFACES, &SURFACE_NAMES, grid)
}

fn named<const N: usize>(
    table: &Table<N>,
    names: &[&'static str; N],
    grid: WavelengthGrid,
) -> Result<Vec<(&'static str, Spectrum)>, SpectrumError> {
    names
        .iter()
        .enumerate()
        .map(|(i, &name)| Ok((name, table.spectrum(i, grid, Extrapolation::Hold)?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflectances_are_between_0_and_1() {
        let grid = WavelengthGrid::new(360.0, 10.0, 48).unwrap();
        let (chart, nature) = (colorchecker(grid).unwrap(), natural(grid).unwrap());
        assert_eq!(chart.len(), 24);
        assert!(nature.len() >= 100);
        for (name, reflectance) in chart.iter().chain(&nature) {
            assert!(reflectance.values().iter().all(|r| (0.0..=1.0).contains(r)), "{name}");
        }
    }

    #[test]
    fn the_chart_runs_from_dark_skin_to_black() {
        let chart = colorchecker(WavelengthGrid::VISIBLE).unwrap();
        assert_eq!((chart[0].0, chart[5].0, chart[18].0), ("dark skin", "bluish green", "white 9.5 (.05 D)"));
        let greys: Vec<f64> = chart[18..].iter().map(|(_, r)| r.at(550.0).unwrap()).collect();
        assert!(greys.windows(2).all(|w| w[1] < w[0]), "{greys:?}");
    }

    #[test]
    fn natural_objects_look_as_they_should() {
        let nature = natural(WavelengthGrid::new(380.0, 10.0, 41).unwrap()).unwrap();
        let mut names: Vec<&str> = nature.iter().map(|n| n.0).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), nature.len(), "names are unique");
        for (name, r) in nature.iter().filter(|n| n.0.starts_with("leaf")) {
            // Chlorophyll: absorption at 680 nm, the red edge towards 760 nm, green above blue.
            let at = |nm| r.at(nm).unwrap();
            assert!(at(760.0) > 1.3 * at(680.0) && at(550.0) > at(450.0), "{name}");
        }
        let tomato = &nature.iter().find(|n| n.0.contains("Solanum lycopersicum")).unwrap().1;
        assert!(tomato.at(640.0).unwrap() > 10.0 * tomato.at(540.0).unwrap());
    }
}
