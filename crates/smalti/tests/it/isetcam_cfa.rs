//! Filters and patterns of the reference cases.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::common;

use smalti::sensor::Cfa;
use smalti::sensor::cfa::{Channel, Filter, Mosaic};
use smalti::spectrum::{Spectrum, WavelengthGrid};

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

fn column(rows: &[Vec<f64>], i: usize) -> Vec<f64> {
    rows.iter().map(|r| r[i]).collect()
}

#[test]
fn gaussian_sets_are_those_of_the_reference() {
    let sets = common::reference_json("gaussian_filter_sets.json");
    for set in sets.as_array().unwrap() {
        let id = set["id"].as_str().unwrap();
        let (centers, sigmas) = (common::numbers(&set["center_nm"]), common::numbers(&set["sigma_nm"]));
        let filters: Vec<Spectrum> = centers
            .iter()
            .zip(&sigmas)
            .map(|(&center_nm, &sigma_nm)| {
                Filter::Gaussian { center_nm, sigma_nm, peak: 1.0 }.spectrum(GRID).unwrap()
            })
            .collect();
        let case = common::reference_json(&format!("ip_case_{id}.json"));
        let rows: Vec<Vec<f64>> =
            case["filters_31xN"].as_array().unwrap().iter().map(common::numbers).collect();
        for (i, filter) in filters.iter().enumerate() {
            // The reference keeps filters in double precision and prints ten digits.
            common::assert_close(&format!("{id} filter {i}"), filter.values(), &column(&rows, i), 1e-9);
        }
        let pattern = set["pattern"].as_array().unwrap();
        let cells = common::numbers(&set["pattern"]).iter().map(|&c| c as u8 - 1).collect();
        let mosaic = Mosaic::new(pattern.len(), common::numbers(&pattern[0]).len(), cells).unwrap();
        assert_eq!(mosaic.bayer_phase().is_some(), id == "g3a");
        let channels = filters
            .into_iter()
            .enumerate()
            .map(|(i, transmittance)| Channel { name: i.to_string(), transmittance });
        let cfa = Cfa::new(id, mosaic, channels.collect()).unwrap();
        assert_eq!(cfa.channels().len(), set["N"].as_u64().unwrap() as usize);
    }
}

#[test]
fn measured_filters_of_the_reference_make_a_bayer_array() {
    for name in ["nikonD100", "isetRGB"] {
        let rows = common::reference_csv(&format!("filters_{name}_400_10_700.csv"));
        let filters: Vec<(char, Spectrum)> = ['R', 'G', 'B']
            .into_iter()
            .enumerate()
            .map(|(i, letter)| (letter, Spectrum::new(GRID, column(&rows, i)).unwrap()))
            .collect();
        let cfa = Cfa::from_pattern(name, &["GR", "BG"], &filters).unwrap();
        let phase = cfa.mosaic().bayer_phase().unwrap();
        assert_eq!(cfa.channels()[phase.diagonal].name, "G");
        assert_eq!(phase.diagonal_col, 0);
    }
}
