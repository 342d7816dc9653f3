//! Patterns, mixtures and random tiles of colour filter arrays.
#![allow(clippy::unwrap_used, clippy::panic)]

use proptest::prelude::*;
use smalti::sensor::cfa::{BayerPhase, Modulation, WeightedMosaic, blue_noise};
use smalti::sensor::{Cfa, CfaError, Channel, Mosaic};
use smalti::spectrum::{Spectrum, WavelengthGrid};

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

fn tile(lines: &[&str]) -> Mosaic {
    Mosaic::from_letters(lines).unwrap().0
}

fn flat(value: f64) -> Spectrum {
    Spectrum::constant(GRID, value).unwrap()
}

#[test]
fn letters_number_the_channels_as_they_appear() {
    let (mosaic, letters) = Mosaic::from_letters(&["BG", "GR"]).unwrap();
    assert_eq!(mosaic.cells(), &[0, 1, 1, 2]);
    assert_eq!(letters, ['B', 'G', 'R']);
    assert_eq!(mosaic.to_letters(&letters).unwrap(), ["BG", "GR"]);
    let missing = CfaError::CellChannel { row: 0, col: 1, channel: 1, channels: 1 };
    assert_eq!(mosaic.to_letters(&['B']), Err(missing));
    // Any letter does.
    assert_eq!(Mosaic::from_letters(&["éμ"]).unwrap().1, ['é', 'μ']);
}

#[test]
fn what_is_no_tile_is_refused() {
    let refused = |lines: &[&str]| matches!(Mosaic::from_letters(lines), Err(CfaError::Tile { .. }));
    assert!(refused(&[]));
    assert!(refused(&[""]));
    assert!(refused(&["RG", "GBR"]));
    assert!(refused(&["RG", ""]));
    let long = "R".repeat(65537);
    assert!(refused(&[long.as_str()]));
    let many: String = (0..300u32).filter_map(|i| char::from_u32(0x4E00 + i)).collect();
    assert!(refused(&[many.as_str()]));
}

#[test]
fn a_letter_without_a_filter_is_named_with_its_place() {
    let error =
        Cfa::from_pattern("x", &["RG", "WB"], &[('R', flat(0.5)), ('G', flat(0.5)), ('B', flat(0.5))]);
    let error = error.unwrap_err();
    assert_eq!(error, CfaError::UnknownLetter { letter: 'W', row: 1, col: 0, known: "R, G, B".into() });
    assert!(error.to_string().contains("'W' at row 1, column 0"), "{error}");
}

#[test]
fn unused_filters_are_ignored_and_bad_ones_refused() {
    let cfa =
        Cfa::from_pattern("x", &["RG"], &[('W', flat(0.9)), ('G', flat(0.5)), ('R', flat(0.4))]).unwrap();
    assert_eq!(cfa.channels().iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["R", "G"]);
    assert_eq!(cfa.letters().unwrap(), ["RG"]);
    assert!(matches!(Cfa::from_pattern("x", &["R"], &[('R', flat(1.2))]), Err(CfaError::Spectrum(_))));
}

#[test]
fn bayer_is_found_in_all_phases_and_nothing_else() {
    let phase = |lines: &[&str]| tile(lines).bayer_phase();
    assert_eq!(
        phase(&["RG", "GB"]),
        Some(BayerPhase { diagonal: 1, even_rows: 0, odd_rows: 2, diagonal_col: 1 })
    );
    assert_eq!(
        phase(&["GB", "RG"]),
        Some(BayerPhase { diagonal: 0, even_rows: 1, odd_rows: 2, diagonal_col: 0 })
    );
    // RYYB too, and Bayer written out twice.
    assert!(phase(&["RY", "YB"]).is_some());
    assert_eq!(phase(&["RGRG", "GBGB"]), phase(&["RG", "GB"]));
    for other in [&["RG", "WB"][..], &["RC", "CC"], &["RW", "WR"], &["RGB"], &["RG", "BG"], &["RGGB"], &["W"]]
    {
        assert_eq!(phase(other), None, "{other:?}");
    }
}

#[test]
fn canonical_tiles_tell_arrangements_apart() {
    let quad = tile(&["RRGG", "RRGG", "GGBB", "GGBB"]);
    assert_eq!(quad.reduced(), quad);
    assert_ne!(quad.canonical(), tile(&["RG", "GB"]).canonical());
    assert_eq!(tile(&["RGRG", "GBGB", "RGRG", "GBGB"]).canonical(), tile(&["RG", "GB"]).canonical());
    assert_eq!(tile(&["WWW", "WWW"]).canonical(), tile(&["W"]));
}

#[test]
fn a_large_tile_finds_its_canonical_form_quickly() {
    // All alike but one cell: the worst case for comparing shifts one by one.
    let mut cells = vec![0; 65536];
    cells[40_000] = 1;
    let mosaic = Mosaic::new(256, 256, cells).unwrap();
    let canonical = mosaic.canonical();
    assert_eq!(canonical.cells()[65535], 1);
    assert_eq!(mosaic.shifted(17, 5).canonical(), canonical);
}

#[test]
fn mixtures_become_distinct_channels() {
    let red_green = [0.0, 1.0, 0.5, 0.5, 0.5, 0.5, 1.0, 0.0];
    let weighted = WeightedMosaic::new(2, 2, 2, red_green.to_vec()).unwrap();
    let primaries = [("R", 0.2), ("G", 0.6)]
        .map(|(name, value)| Channel { name: name.into(), transmittance: flat(value) });
    let cfa = weighted.cfa("x", &primaries).unwrap();
    assert_eq!(cfa.mosaic().cells(), &[0, 1, 1, 2]);
    let values: Vec<f64> = cfa.channels().iter().map(|c| c.transmittance.values()[0]).collect();
    for (got, expected) in values.iter().zip([0.6, 0.4, 0.2]) {
        assert!((got - expected).abs() < 1e-15, "{values:?}");
    }
    assert_eq!(cfa.channels()[1].name, "0.500R+0.500G");
}

#[test]
fn mixtures_that_would_pass_more_than_all_light_are_brought_down_together() {
    let weighted = WeightedMosaic::new(1, 2, 2, vec![1.0, 1.0, 1.0, 0.0]).unwrap();
    let primaries = ["A", "B"].map(|name| Channel { name: name.into(), transmittance: flat(0.8) });
    let cfa = weighted.cfa("x", &primaries).unwrap();
    let at = |i: usize| cfa.channels()[i].transmittance.values()[0];
    assert!((at(0) - 1.0).abs() < 1e-15 && (at(1) - 0.5).abs() < 1e-15);
}

#[test]
fn impossible_mixtures_are_refused() {
    assert!(matches!(WeightedMosaic::new(1, 1, 2, vec![0.5]), Err(CfaError::Tile { .. })));
    assert!(matches!(WeightedMosaic::new(0, 1, 2, vec![]), Err(CfaError::Tile { .. })));
    assert!(matches!(WeightedMosaic::new(1, 1, 0, vec![]), Err(CfaError::Tile { .. })));
    assert!(matches!(WeightedMosaic::new(usize::MAX, 9, 3, vec![]), Err(CfaError::Tile { .. })));
    for bad in [-0.1, 1.1, f64::NAN] {
        let error = WeightedMosaic::new(1, 2, 2, vec![0.0, 0.5, 0.5, bad]).unwrap_err();
        assert!(error.to_string().contains("primary 1 in cell (0, 1)"), "{error}");
    }
    let one = Modulation { mean: 0.5, amplitude: 0.5, phase_turns: 0.0 };
    assert!(WeightedMosaic::modulated(usize::MAX, 2, [1.0, 1.0], &[one]).is_err());
    assert!(WeightedMosaic::modulated(0, 2, [1.0, 1.0], &[one]).is_err());
    assert!(WeightedMosaic::modulated(2, 2, [f64::NAN, 1.0], &[one]).is_err());
    let weighted = WeightedMosaic::new(1, 1, 1, vec![1.0]).unwrap();
    assert!(matches!(weighted.cfa("x", &[]), Err(CfaError::Parameter { .. })));
}

/// Variance over all windows of `size` × `size` cells on the torus of how often each channel appears.
fn window_variance(mosaic: &Mosaic, size: usize) -> f64 {
    let (rows, cols) = (mosaic.rows(), mosaic.cols());
    let expected = (size * size) as f64 / mosaic.channels() as f64;
    let mut sum = 0.0;
    for at in 0..rows * cols {
        let mut counts = vec![0.0; mosaic.channels()];
        for i in 0..size * size {
            counts[mosaic.channel_at(at / cols + i / size, at % cols + i % size)] += 1.0;
        }
        sum += counts.iter().map(|c| (c - expected) * (c - expected)).sum::<f64>();
    }
    sum / (rows * cols * mosaic.channels()) as f64
}

/// The same cells in an order without structure.
fn shuffled(mosaic: &Mosaic, seed: u64) -> Mosaic {
    let mut random = smalti::numeric::philox::Stream::new(seed, 0, 0);
    let mut cells = mosaic.cells().to_vec();
    (1..cells.len()).rev().for_each(|i| cells.swap(i, random.below(i as u32 + 1) as usize));
    Mosaic::new(mosaic.rows(), mosaic.cols(), cells).unwrap()
}

#[test]
fn blue_noise_is_spread_evenly() {
    for (channels, rows, cols) in [(2, 16, 16), (3, 16, 16), (4, 16, 12), (7, 14, 14)] {
        for seed in 1..=3 {
            let blue = blue_noise(channels, rows, cols, seed).unwrap();
            let (b, w) = (window_variance(&blue, 4), window_variance(&shuffled(&blue, seed), 4));
            // White noise without replacement has nearly the binomial variance; blue noise well below a third of it.
            assert!(b < w / 3.0, "{channels} channels, seed {seed}: {b:.3} against {w:.3}");
            let counts = (0..channels).map(|c| blue.cells().iter().filter(|&&x| usize::from(x) == c).count());
            let (low, high) = (counts.clone().min().unwrap(), counts.max().unwrap());
            assert!(high - low <= 1);
        }
    }
}

#[test]
fn blue_noise_depends_on_the_seed_alone() {
    assert_eq!(blue_noise(3, 8, 8, 5).unwrap(), blue_noise(3, 8, 8, 5).unwrap());
    assert_ne!(blue_noise(3, 8, 8, 5).unwrap(), blue_noise(3, 8, 8, 6).unwrap());
    assert!(blue_noise(1, 8, 8, 1).is_err());
    assert!(blue_noise(27, 8, 8, 1).is_err());
    assert!(blue_noise(5, 2, 2, 1).is_err());
    assert!(blue_noise(3, 65, 64, 1).is_err());
    assert!(blue_noise(3, usize::MAX, usize::MAX, 1).is_err());
}

fn any_mosaic() -> impl Strategy<Value = Mosaic> {
    (1usize..7, 1usize..7, 1u8..5).prop_flat_map(|(rows, cols, letters)| {
        prop::collection::vec(0..letters, rows * cols).prop_map(move |cells| {
            let lines: Vec<String> =
                cells.chunks(cols).map(|row| row.iter().map(|&c| char::from(b'A' + c)).collect()).collect();
            Mosaic::from_letters(&lines).unwrap().0
        })
    })
}

proptest! {
    #[test]
    fn letters_round_trip(mosaic in any_mosaic()) {
        let letters: Vec<char> = ('a'..='z').collect();
        let lines = mosaic.to_letters(&letters).unwrap();
        prop_assert_eq!(Mosaic::from_letters(&lines).unwrap().0, mosaic);
    }

    #[test]
    fn reading_any_text_ends(lines in prop::collection::vec(".{0,12}", 0..6)) {
        let _ = Mosaic::from_letters(&lines);
    }

    #[test]
    fn shifts_and_repetitions_have_one_canonical_tile(
        mosaic in any_mosaic(), dr in 0usize..9, dc in 0usize..9, down in 1usize..4, across in 1usize..4,
    ) {
        let (rows, cols) = (mosaic.rows() * down, mosaic.cols() * across);
        let cells = (0..rows * cols).map(|i| mosaic.channel_at(i / cols, i % cols) as u8).collect();
        let repeated = Mosaic::new(rows, cols, cells).unwrap();
        prop_assert_eq!(repeated.reduced(), mosaic.reduced());
        prop_assert_eq!(repeated.shifted(dr, dc).canonical(), mosaic.canonical());
    }

    #[test]
    fn the_canonical_tile_is_the_first_of_all_shifts(mosaic in any_mosaic()) {
        let tile = mosaic.reduced();
        let all = (0..tile.rows()).flat_map(|r| (0..tile.cols()).map(move |c| (r, c)));
        let first = all.map(|(r, c)| tile.shifted(r, c).cells().to_vec()).min().unwrap();
        let canonical = mosaic.canonical();
        prop_assert_eq!(canonical.cells(), &first[..]);
    }
}
