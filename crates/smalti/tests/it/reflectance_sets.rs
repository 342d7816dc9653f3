//! Reflectances that are learned from and those that scenes are tested with are different measurements.
#![allow(missing_docs, clippy::unwrap_used)]

use smalti::camera::{SurfaceReflectances, Surfaces, training_reflectances};
use smalti::spectrum::reflectance::{colorchecker, natural, surfaces};
use smalti::spectrum::{Spectrum, WavelengthGrid};

type Named = (&'static str, Spectrum);

/// Root mean square of the difference over the wavelengths.
fn distance(a: &Spectrum, b: &Spectrum) -> f64 {
    let squares: f64 = a.values().iter().zip(b.values()).map(|(a, b)| (a - b) * (a - b)).sum();
    (squares / a.values().len() as f64).sqrt()
}

fn nearest<'a>(a: &'a [Named], b: &'a [Named]) -> (f64, &'static str, &'static str) {
    let pairs = a.iter().flat_map(|(x, r)| b.iter().map(move |(y, s)| (distance(r, s), *x, *y)));
    pairs.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

/// All that either stage learns from.
fn learned(grid: WavelengthGrid) -> Vec<Named> {
    let reflectances = SurfaceReflectances::new(grid).unwrap();
    let all = Surfaces::ALL.iter().flat_map(|&kind| reflectances.of(kind));
    all.map(|r| ("a reflectance of training", r.clone())).collect()
}

/// Training paints its scenes with natural objects (Morimoto et al. 2022), paints (Munsell chips), greys and computed colours. The
/// rendered scenes and the photographs are made of other surfaces (USGS, NIST, CIE 224). Two spectra of one measurement would differ by
/// rounding, below 0.0001; the nearest pair, two blacks, differs by 0.0024. The surfaces are not those of the ColorChecker either.
#[test]
fn reflectances_of_training_and_of_tests_are_disjoint() {
    let grid = WavelengthGrid::VISIBLE;
    let tests = surfaces(grid).unwrap();
    for others in [natural(grid).unwrap(), colorchecker(grid).unwrap(), learned(grid)] {
        let (distance, test, trained) = nearest(&tests, &others);
        println!("nearest pair: {test} and {trained}, {distance:.4} rms");
        assert!(distance > 0.001, "{test} and {trained}: {distance}");
    }
    // The measure finds a spectrum that stands in both sets.
    let copied = [("a copy", natural(grid).unwrap()[3].1.clone())];
    assert!(nearest(&copied, &natural(grid).unwrap()).0 < 1e-9);
}

/// The ColorChecker is a test chart, and its patches are also the walls of the room of high dynamic range.
#[test]
fn training_does_not_contain_the_colorchecker() {
    let grid = WavelengthGrid::VISIBLE;
    let chart = colorchecker(grid).unwrap();
    let (distance, patch, trained) = nearest(&chart, &learned(grid));
    println!("nearest pair: {patch} and {trained}, {distance:.4} rms");
    assert!(distance > 0.001, "{patch} and {trained}: {distance}");
}

/// The dead leaves of the charts share the reflectances of natural objects with training, as the documentation states. If they no
/// longer do, it is to be corrected.
#[test]
fn dead_leaves_of_the_charts_share_reflectances_with_training() {
    let grid = WavelengthGrid::VISIBLE;
    let training = training_reflectances(grid).unwrap();
    let is_trained = |(_, r): &Named| training.iter().any(|t| distance(t, r) < 1e-9);
    assert!(natural(grid).unwrap().iter().all(is_trained));
}
