//! The catalogue of colour filter arrays.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::{BTreeMap, HashSet};

use proptest::prelude::*;
use smalti::sensor::cfa::{self, CfaError, Mosaic};
use smalti::spectrum::{Spectrum, WavelengthGrid};

fn near_infrared() -> WavelengthGrid {
    WavelengthGrid::new(400.0, 10.0, 61).unwrap()
}

fn tile(name: &str) -> Mosaic {
    Mosaic::from_letters(&cfa::pattern(name).unwrap()).unwrap().0
}

/// Share of each letter among the cells of a pattern.
fn shares(name: &str) -> BTreeMap<char, f64> {
    let text: String = cfa::pattern(name).unwrap().concat();
    let mut counts = BTreeMap::new();
    text.chars().for_each(|c| *counts.entry(c).or_insert(0.0) += 1.0 / text.chars().count() as f64);
    counts
}

fn assert_shares(name: &str, expected: &[(char, f64)]) {
    let got = shares(name);
    assert_eq!(got.len(), expected.len(), "{name}: {got:?}");
    for (letter, share) in expected {
        assert!((got[letter] - share).abs() < 1e-12, "{name}: {got:?}");
    }
}

#[test]
fn every_entry_builds_on_visible_and_infrared_grids() {
    for entry in cfa::names() {
        for grid in [WavelengthGrid::VISIBLE, near_infrared()] {
            let built = cfa::builtin(entry.name, grid).unwrap_or_else(|e| panic!("{}: {e}", entry.name));
            assert_eq!(built.name(), entry.name);
            assert_eq!(
                (built.mosaic().rows(), built.mosaic().cols()),
                (entry.rows(), entry.cols()),
                "{}",
                entry.name
            );
            let lines = entry.pattern().unwrap();
            assert!(lines.len() == entry.rows() && lines.iter().all(|l| l.chars().count() == entry.cols()));
            assert_eq!(built.channels().len(), built.mosaic().channels());
            assert!(built.channels().len() > 1 || entry.name == "mono", "{}", entry.name);
            for channel in built.channels() {
                let values = channel.transmittance.values();
                assert!(values.iter().all(|v| (0.0..=1.0).contains(v)), "{} {}", entry.name, channel.name);
                // Infrared alone is dark on a visible grid.
                assert!(
                    values.iter().any(|&v| v > 0.4) || channel.name == "I",
                    "{} {}",
                    entry.name,
                    channel.name
                );
            }
            let distinct: HashSet<String> =
                built.channels().iter().map(|c| format!("{:?}", c.transmittance.values())).collect();
            assert_eq!(distinct.len(), built.channels().len(), "{}: two channels alike", entry.name);
        }
    }
}

#[test]
fn names_are_unique_and_patterns_are_the_arrays() {
    let mut seen = HashSet::new();
    for entry in cfa::names() {
        for name in std::iter::once(&entry.name).chain(entry.aliases) {
            assert!(seen.insert(name.to_lowercase()), "{name} twice");
            assert_eq!(cfa::info(name).unwrap().name, entry.name);
        }
        assert!(!entry.summary.is_empty() && entry.source.len() > 20, "{}", entry.name);
        let built = cfa::builtin(entry.name, WavelengthGrid::VISIBLE).unwrap();
        assert_eq!(built.mosaic(), &tile(entry.name), "{}", entry.name);
        // The tile is the smallest there is, and its size is that of the pattern.
        assert_eq!(&built.mosaic().reduced(), built.mosaic(), "{}", entry.name);
        // Each default filter is used.
        if built.letters().is_some() {
            assert_eq!(built.channels().len(), entry.filters.len(), "{}", entry.name);
        }
    }
}

#[test]
fn no_two_entries_are_the_same_array_but_the_phases_of_bayer() {
    let mut seen: BTreeMap<String, &str> = BTreeMap::new();
    for entry in cfa::names().iter().filter(|e| !e.name.starts_with("bayer-")) {
        let built = cfa::builtin(entry.name, near_infrared()).unwrap();
        let canonical = built.mosaic().canonical();
        let key = format!("{canonical:?} {:?}", built.channels());
        assert_eq!(seen.insert(key, entry.name), None, "{}", entry.name);
    }
    // The phases of Bayer are one array seen from four corners.
    let [a, b, c, d] = ["bayer", "bayer-bggr", "bayer-grbg", "bayer-gbrg"].map(|n| cfa::pattern(n).unwrap());
    let numbered = |lines: &[String]| {
        let cells = lines.concat().chars().map(|l| "RGB".find(l).unwrap() as u8).collect();
        Mosaic::new(2, 2, cells).unwrap().canonical()
    };
    assert!([b, c, d].iter().all(|x| numbered(x) == numbered(&a)));
}

#[test]
fn colours_have_the_shares_of_the_publications() {
    let bayer = [('R', 0.25), ('G', 0.5), ('B', 0.25)];
    for name in ["bayer", "quad-bayer", "nona-bayer", "yamanaka", "lukac", "diagonal-bayer"] {
        assert_shares(name, &bayer);
    }
    assert_shares("xtrans", &[('R', 8.0 / 36.0), ('G', 20.0 / 36.0), ('B', 8.0 / 36.0)]);
    for name in ["kodak", "kodak-b", "kodak-c", "rgbw-hamilton", "rgbw-sony", "rgbw-yamagami"] {
        assert_shares(name, &[('R', 0.125), ('G', 0.25), ('B', 0.125), ('W', 0.5)]);
    }
    let sixth = 1.0 / 6.0;
    for name in ["rgbw-yamagami-b", "rgbw-susanu", "rgbw-kaizu"] {
        assert_shares(name, &[('R', sixth), ('G', sixth), ('B', sixth), ('W', 0.5)]);
    }
    assert_shares("wang2011", &[('R', 0.2), ('G', 0.2), ('B', 0.2), ('W', 0.4)]);
    assert_shares("five-band", &[('R', 0.125), ('O', 0.125), ('G', 0.5), ('C', 0.125), ('B', 0.125)]);
    assert_shares("rgbir-4x4", &[('R', 0.125), ('G', 0.5), ('B', 0.125), ('I', 0.25)]);
    assert_shares("rccc", &[('R', 0.25), ('C', 0.75)]);
    // Tiles of the two repositories.
    assert_shares("chakrabarti2016", &[('R', 0.125), ('G', 9.0 / 64.0), ('B', 0.125), ('W', 39.0 / 64.0)]);
    for (name, cells) in [("chakrabarti2014-4x4", 16.0), ("rgbw-honda", 16.0), ("rgbw-sparse-3", 64.0)] {
        let once = 1.0 / cells;
        assert_shares(name, &[('R', once), ('G', 2.0 * once), ('B', once), ('W', 1.0 - 4.0 * once)]);
    }
    assert_shares("rgbw-luo", &[('R', 0.125), ('G', 0.125), ('B', 0.0625), ('W', 0.6875)]);
    assert_shares("rgbw-quad", &[('R', 0.25), ('G', 0.25), ('B', 0.25), ('W', 0.25)]);
    assert_shares("rgbw-random", &[('R', 5.0 / 64.0), ('G', 5.0 / 64.0), ('B', 6.0 / 64.0), ('W', 0.75)]);
}

/// The software writes the tile as digits, 0 to 3 for red, green, blue and white.
#[test]
fn chakrabarti_2016_is_the_code_of_its_software() {
    let code = "3133033303333303132232330233131233333103303133100323133331333322";
    let text = cfa::pattern("chakrabarti2016").unwrap().concat();
    let digits: String = text.chars().map(|l| "RGBW".find(l).unwrap().to_string()).collect();
    assert_eq!(digits, code);
}

/// Claim 1 of US 9,699,429: one white pixel between the coloured ones of every row and column, which are red, green and blue in turn.
#[test]
fn kaizu_meets_the_claim_of_the_patent() {
    let lines: Vec<Vec<char>> =
        cfa::pattern("kaizu").unwrap().iter().map(|line| line.chars().collect()).collect();
    for i in 0..6 {
        let column: Vec<char> = lines.iter().map(|line| line[i]).collect();
        for line in [&lines[i], &column] {
            let start = line.iter().position(|&l| l == 'R').unwrap();
            let turned: String = (0..6).map(|k| line[(start + k) % 6]).collect();
            assert!(["RWGWBW", "RWBWGW"].contains(&turned.as_str()), "{turned}");
        }
    }
}

#[test]
fn quads_are_binned_to_their_single_cells() {
    let lettered = |name: &str| Mosaic::from_letters(&cfa::pattern(name).unwrap()).unwrap();
    for (quad, single, shift) in [("quad-bayer", "bayer", 0), ("rgbw-quad", "rgbw", 1)] {
        let (mosaic, letters) = lettered(quad);
        assert_eq!(mosaic.block_side(4), Some(2), "{quad}");
        let binned = mosaic.binned(2).unwrap().to_letters(&letters).unwrap();
        let (mosaic, letters) = lettered(single);
        assert_eq!(binned, mosaic.shifted(0, shift).to_letters(&letters).unwrap(), "{quad}");
    }
}

#[test]
fn x_trans_has_every_colour_in_every_row_and_column() {
    let x = tile("xtrans");
    let colours = |cells: Vec<usize>| cells.into_iter().collect::<HashSet<_>>().len();
    for i in 0..6 {
        assert_eq!(colours((0..6).map(|c| x.channel_at(i, c)).collect()), 3);
        assert_eq!(colours((0..6).map(|r| x.channel_at(r, i)).collect()), 3);
    }
}

#[test]
fn snapshot_arrays_see_every_part_of_the_spectrum_in_every_row_and_column() {
    for (name, n) in [("multispectral-3x3", 3), ("multispectral-5x5", 5)] {
        let text: Vec<char> = cfa::pattern(name).unwrap().concat().chars().collect();
        let part = |row: usize, col: usize| (text[row * n + col] as usize - 'A' as usize) / n;
        for i in 0..n {
            assert_eq!((0..n).map(|k| part(i, k)).collect::<HashSet<_>>().len(), n);
            assert_eq!((0..n).map(|k| part(k, i)).collect::<HashSet<_>>().len(), n);
        }
    }
}

/// Cycles (over rows, over columns) at which the weight of some channel has energy.
fn carriers(rows: usize, cols: usize, weight: impl Fn(usize, usize) -> f64) -> HashSet<(usize, usize)> {
    let mut found = HashSet::new();
    for (u, v) in (0..rows).flat_map(|u| (0..cols).map(move |v| (u, v))) {
        let (mut re, mut im) = (0.0, 0.0);
        for (r, c) in (0..rows).flat_map(|r| (0..cols).map(move |c| (r, c))) {
            let turns = (u * r) as f64 / rows as f64 + (v * c) as f64 / cols as f64;
            re += weight(r, c) * (std::f64::consts::TAU * turns).cos();
            im += weight(r, c) * (std::f64::consts::TAU * turns).sin();
        }
        if re.hypot(im) > 1e-6 {
            found.insert((u, v));
        }
    }
    found
}

#[test]
fn wang_has_the_carriers_the_paper_states() {
    let wang = tile("wang2011");
    for channel in 0..4 {
        let found = carriers(5, 5, |r, c| f64::from(u8::from(wang.channel_at(r, c) == channel)));
        // Luma at zero; chroma at (4π/5, 2π/5) and (2π/5, −4π/5) in the paper's (x, y), and their conjugates.
        assert_eq!(found, HashSet::from([(0, 0), (1, 2), (4, 3), (2, 4), (3, 1)]));
    }
}

#[test]
fn weighted_arrays_put_chrominance_on_one_carrier() {
    for (name, rows, cols, channels) in [("hirakawa2008", 2, 4, 4), ("condat2011", 2, 3, 6)] {
        let unit = |nm: f64| {
            let at = |x: f64| f64::from(u8::from((x - nm).abs() < 1.0));
            Spectrum::from_fn(WavelengthGrid::VISIBLE, at).unwrap()
        };
        // With primaries of one wavelength each, the transmittance there is the weight.
        let primaries = [('R', unit(600.0)), ('G', unit(550.0)), ('B', unit(450.0))];
        let built = cfa::builtin_with(name, WavelengthGrid::VISIBLE, &primaries).unwrap();
        assert_eq!(
            (built.mosaic().rows(), built.mosaic().cols(), built.channels().len()),
            (rows, cols, channels)
        );
        let weight = |r: usize, c: usize, nm: f64| {
            built.channels()[built.mosaic().channel_at(r, c)].transmittance.at(nm).unwrap()
        };
        let expected = HashSet::from([(0, 0), (1, 1), (1, cols - 1)]);
        for nm in [600.0, 550.0, 450.0] {
            assert_eq!(carriers(rows, cols, |r, c| weight(r, c, nm)), expected, "{name} {nm}");
        }
        // Luminance is not modulated.
        assert_eq!(
            carriers(rows, cols, |r, c| weight(r, c, 600.0) + weight(r, c, 550.0) + weight(r, c, 450.0)),
            HashSet::from([(0, 0)]),
            "{name}"
        );
    }
    let condat = cfa::builtin("condat2011", WavelengthGrid::VISIBLE).unwrap();
    let names: Vec<&str> = condat.channels().iter().map(|c| c.name.as_str()).collect();
    assert!(names.contains(&"1.000R+0.500B") || names.contains(&"0.500R+1.000G"), "{names:?}");
}

#[test]
fn parameters_make_random_arrays() {
    let name = "random?channels=4&rows=6&cols=10&seed=7";
    let built = cfa::builtin(name, WavelengthGrid::VISIBLE).unwrap();
    assert_eq!(built.name(), name);
    assert_eq!((built.mosaic().rows(), built.mosaic().cols(), built.channels().len()), (6, 10, 4));
    assert_eq!(built.letters().unwrap(), cfa::pattern(name).unwrap());
    assert_eq!(cfa::pattern("random?seed=1").unwrap(), cfa::info("random").unwrap().pattern().unwrap());
    assert_eq!(
        cfa::builtin("random?channels=26&rows=16&cols=16", near_infrared()).unwrap().channels().len(),
        26
    );
    // The same tile on every machine.
    assert_eq!(cfa::pattern("random?rows=4&cols=4&channels=2").unwrap(), ["ABBA", "BAAB", "ABBA", "BAAB"]);
}

#[test]
fn wrong_names_and_parameters_are_explained() {
    let message = |name: &str| cfa::builtin(name, WavelengthGrid::VISIBLE).unwrap_err().to_string();
    assert_eq!(message("bayr"), "no built-in CFA is called 'bayr'; did you mean 'bayer'?");
    assert_eq!(message("polaroid"), "no built-in CFA is called 'polaroid'");
    assert!(message("bayer?seed=1").contains("parameter of a CFA with a fixed pattern is called 'seed'"));
    assert!(message("random?sed=1").contains("did you mean 'seed'?"));
    assert_eq!(message("random?rows=x"), "rows is 'x'; expected a whole number");
    assert_eq!(message("random?rows"), "rows is ''; expected a whole number");
    assert!(message("random?rows=99999999999999999999").contains("whole number"));
    assert!(message("random?rows=18446744073709551615").contains("4096"));
    assert!(message("random?channels=1").contains("2 to 26"));
    let flat = Spectrum::constant(WavelengthGrid::VISIBLE, 0.5).unwrap();
    let error = cfa::builtin_with("bayer", WavelengthGrid::VISIBLE, &[('W', flat)]).unwrap_err();
    assert!(matches!(error, CfaError::UnknownName { .. }), "{error}");
    let infrared = Spectrum::constant(near_infrared(), 0.5).unwrap();
    assert!(cfa::builtin_with("bayer", WavelengthGrid::VISIBLE, &[('R', infrared)]).is_err());
}

#[test]
fn filters_can_be_replaced() {
    let flat = Spectrum::constant(WavelengthGrid::VISIBLE, 0.5).unwrap();
    let built = cfa::builtin_with("rgbw", WavelengthGrid::VISIBLE, &[('W', flat.clone())]).unwrap();
    let default = cfa::builtin("RGBW", WavelengthGrid::VISIBLE).unwrap();
    for (new, old) in built.channels().iter().zip(default.channels()) {
        assert_eq!(new.transmittance == flat, new.name == "W");
        assert_eq!(new.transmittance == old.transmittance, new.name != "W");
    }
}

proptest! {
    #[test]
    fn any_name_is_answered(name in ".{0,40}", query in "(random)?[?a-z0-9=&]{0,30}") {
        let _ = cfa::builtin(&name, WavelengthGrid::VISIBLE);
        let _ = cfa::pattern(&query);
    }
}
