//! Families of mosaics: counts against brute force, uniform choice, how they are written.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::{BTreeMap, BTreeSet, HashSet};

use proptest::prelude::*;
use smalti::design::{DesignError, MosaicFamily, Symmetry, Tile, published};
use smalti::sensor::Mosaic;

const SYMMETRIES: [Symmetry; 3] = [Symmetry::Shift, Symmetry::ShiftMirror, Symmetry::ShiftMirrorRotation];

fn tile(rows: usize, cols: usize, symmetry: Symmetry) -> MosaicFamily {
    MosaicFamily::Tile(Tile { rows, cols, symmetry })
}

/// All images of a mosaic, written without the tables of the library.
fn images(mosaic: &Mosaic, rows: usize, cols: usize, symmetry: Symmetry) -> Vec<Vec<usize>> {
    let at = |r: usize, c: usize| mosaic.channel_at(r % rows, c % cols);
    let mut all = Vec::new();
    for dr in 0..rows {
        for dc in 0..cols {
            let mut add = |f: &dyn Fn(usize, usize) -> usize| {
                all.push((0..rows * cols).map(|i| f(i / cols, i % cols)).collect::<Vec<_>>());
            };
            add(&|r, c| at(r + dr, c + dc));
            if symmetry != Symmetry::Shift {
                add(&|r, c| at(2 * rows - 1 - r - dr, c + dc));
                add(&|r, c| at(r + dr, 2 * cols - 1 - c - dc));
                add(&|r, c| at(2 * rows - 1 - r - dr, 2 * cols - 1 - c - dc));
            }
            if symmetry == Symmetry::ShiftMirrorRotation {
                add(&|r, c| at(c + dr, r + dc));
                add(&|r, c| at(c + dr, 2 * cols - 1 - r - dc));
                add(&|r, c| at(2 * rows - 1 - c - dr, r + dc));
                add(&|r, c| at(2 * rows - 1 - c - dr, 2 * cols - 1 - r - dc));
            }
        }
    }
    all
}

/// The classes of all placements, each by its first image.
fn brute_force(rows: usize, cols: usize, colors: usize, symmetry: Symmetry) -> BTreeSet<Vec<usize>> {
    let places = rows * cols;
    let mut classes = BTreeSet::new();
    for code in 0..colors.pow(places as u32) {
        let cells: Vec<u8> = (0..places).map(|i| (code / colors.pow(i as u32) % colors) as u8).collect();
        if (0..colors).all(|c| cells.contains(&(c as u8))) {
            let mosaic = Mosaic::new(rows, cols, cells).unwrap();
            classes.insert(images(&mosaic, rows, cols, symmetry).into_iter().min().unwrap());
        }
    }
    classes
}

fn cells(mosaic: &Mosaic, rows: usize, cols: usize) -> Vec<usize> {
    (0..rows * cols).map(|i| mosaic.channel_at(i / cols, i % cols)).collect()
}

#[test]
fn counts_and_lists_are_those_of_brute_force() {
    let sizes = [
        (1, 1, 1),
        (1, 4, 2),
        (2, 2, 2),
        (2, 2, 3),
        (2, 2, 4),
        (2, 3, 3),
        (3, 2, 4),
        (2, 4, 3),
        (3, 3, 2),
        (3, 3, 4),
    ];
    for (rows, cols, colors) in sizes {
        for symmetry in SYMMETRIES {
            if symmetry == Symmetry::ShiftMirrorRotation && rows != cols {
                continue;
            }
            let expected = brute_force(rows, cols, colors, symmetry);
            let family = tile(rows, cols, symmetry);
            let context = format!("{rows} × {cols}, {colors} colours, {symmetry:?}");
            assert_eq!(family.count(colors).unwrap(), expected.len() as u128, "{context}");
            let all = family.pick(colors, None, 0).unwrap();
            let listed: BTreeSet<Vec<usize>> = all.iter().map(|m| cells(m, rows, cols)).collect();
            assert_eq!(all.len(), expected.len(), "{context}");
            // The very tile that comes first, too.
            assert_eq!(listed, expected, "{context}");
        }
    }
}

#[test]
fn exhaustive_lists_of_the_papers_tiles_have_the_counts_of_burnside() {
    for symmetry in SYMMETRIES {
        for (side, colors) in [(2, 3), (2, 4), (3, 3), (3, 4), (3, 5), (3, 6), (3, 7), (3, 8), (3, 9)] {
            let family = tile(side, side, symmetry);
            let all = family.pick(colors, None, 7).unwrap();
            let different: HashSet<_> = all.iter().collect();
            assert_eq!(family.count(colors).unwrap(), different.len() as u128);
            assert!(all.iter().all(|m| m.channels() == colors));
        }
    }
    // 9 different filters in 3 × 3: 9!/9 up to shifts, and no symmetry leaves one as it is.
    let count = |s| tile(3, 3, s).count(9).unwrap();
    assert_eq!(SYMMETRIES.map(count), [40320, 10080, 5040]);
    // Bayer's colours in 2 × 2: which is doubled, and whether it stands on the diagonal, in a row or in a column.
    assert_eq!(tile(2, 2, Symmetry::Shift).count(3).unwrap(), 9);
    assert_eq!(tile(2, 2, Symmetry::ShiftMirrorRotation).count(3).unwrap(), 6);
}

#[test]
fn the_tile_of_a_mosaic_is_its_canonical_one() {
    for mosaic in tile(4, 4, Symmetry::Shift).pick(3, Some(500), 3).unwrap() {
        assert_eq!(mosaic, mosaic.canonical());
    }
    // Mosaics of a smaller period come out as their smaller tile.
    let all = tile(2, 4, Symmetry::Shift).pick(3, None, 0).unwrap();
    for bayer in tile(2, 2, Symmetry::Shift).pick(3, None, 0).unwrap() {
        assert!(all.contains(&bayer));
    }
}

/// Mosaics are shown by different numbers of tiles, from 1 to as many as the symmetry has elements: a sample favours none.
#[test]
fn every_mosaic_is_equally_likely() {
    for (rows, cols, colors, symmetry) in [
        (2, 4, 2, Symmetry::ShiftMirror),
        (2, 2, 3, Symmetry::Shift),
        (3, 3, 2, Symmetry::ShiftMirrorRotation),
    ] {
        let family = tile(rows, cols, symmetry);
        let count = family.count(colors).unwrap() as usize;
        let trials = 1000 * count;
        let mut drawn = BTreeMap::new();
        for seed in 0..trials as u64 {
            let one = family.pick(colors, Some(1), seed).unwrap().remove(0);
            *drawn.entry((one.rows(), one.cells().to_vec())).or_insert(0.0) += 1.0;
        }
        assert_eq!(drawn.len(), count);
        let chi: f64 = drawn.values().map(|n| (n - 1000.0f64).powi(2) / 1000.0).sum();
        let freedom = count as f64 - 1.0;
        assert!((chi - freedom).abs() < 4.0 * (2.0 * freedom).sqrt(), "{rows} × {cols}: {chi} for {freedom}");
    }
}

#[test]
fn samples_are_different_mosaics_and_repeatable() {
    for symmetry in SYMMETRIES {
        let family = tile(4, 4, symmetry);
        let sample = family.pick(4, Some(3000), 11).unwrap();
        let classes: HashSet<_> =
            sample.iter().map(|m| images(m, 4, 4, symmetry).into_iter().min().unwrap()).collect();
        assert_eq!(classes.len(), 3000);
        assert_eq!(family.pick(4, Some(3000), 11).unwrap(), sample);
        assert_ne!(family.pick(4, Some(3000), 12).unwrap(), sample);
        assert_eq!(family.pick(4, Some(100), 11).unwrap(), sample[..100]);
    }
    // All but one, and a tile with more mosaics than 128 bits can count.
    let nearly: HashSet<_> =
        tile(3, 3, Symmetry::Shift).pick(5, Some(92_000), 1).unwrap().into_iter().collect();
    assert_eq!(nearly.len(), 92_000);
    let large = tile(8, 12, Symmetry::ShiftMirror);
    assert!(matches!(large.count(7), Err(DesignError::Uncountable { colors: 7, .. })));
    assert!(matches!(large.pick(7, None, 1), Err(DesignError::Uncountable { .. })));
    assert_eq!(large.pick(7, Some(50), 1).unwrap().iter().collect::<HashSet<_>>().len(), 50);
}

#[test]
fn what_cannot_be_listed_says_how_many_there_are() {
    let family = tile(2, 2, Symmetry::Shift);
    let error = family.pick(4, Some(5000), 1).unwrap_err();
    assert_eq!(error, DesignError::TooFew { what: "this tile", colors: 4, wanted: 5000, available: 6 });
    assert!(error.to_string().contains("has only 6"), "{error}");
    let error = tile(4, 4, Symmetry::Shift).pick(4, None, 1).unwrap_err();
    assert!(error.to_string().starts_with("257706024 mosaics of 4 colours"), "{error}");
    assert!(tile(4, 4, Symmetry::Shift).pick(4, Some(20_000_000), 1).is_err());
    // Fewer cells than colours: none, and none are listed.
    assert_eq!((family.count(5), family.pick(5, None, 1)), (Ok(0), Ok(vec![])));
    assert!(matches!(family.pick(5, Some(1), 1), Err(DesignError::TooFew { available: 0, .. })));
    for colors in [0, 27, usize::MAX] {
        assert_eq!(family.count(colors), Err(DesignError::Colors { colors }));
    }
    for (rows, cols) in [(0, 3), (3, 0), (33, 32), (usize::MAX, usize::MAX)] {
        assert!(matches!(tile(rows, cols, Symmetry::Shift).count(3), Err(DesignError::Key { .. })));
    }
    let error = tile(2, 3, Symmetry::ShiftMirrorRotation).count(3).unwrap_err().to_string();
    assert!(error.contains("`tile.symmetry`") && error.contains("2 × 3"), "{error}");
}

#[test]
fn given_tiles_are_read_by_their_letters() {
    let lines = |lines: &[&str]| lines.iter().map(|&l| l.to_owned()).collect::<Vec<_>>();
    let family = MosaicFamily::Given(vec![lines(&["cb", "ba"]), lines(&["ab", "cd"]), lines(&["abc"])]);
    assert_eq!([2, 3, 4].map(|n| family.count(n).unwrap()), [0, 2, 1]);
    let tiles = family.pick(3, None, 0).unwrap();
    assert_eq!(tiles[0].cells(), [2, 1, 1, 0]);
    assert_eq!(tiles[1].cells(), [0, 1, 2]);
    let wrong = |l: &[&str]| MosaicFamily::Given(vec![lines(l)]).count(3).unwrap_err().to_string();
    assert!(wrong(&["RG", "GB"]).contains("'R' is no channel"));
    assert!(wrong(&["ac", "cd"]).contains("'b' is in no cell"));
    assert!(wrong(&["ab", "c"]).contains("`given[0]`"));
    assert!(wrong(&[]).contains("`given[0]`"));
}

#[test]
fn the_catalogue_has_each_arrangement_once() {
    let named = |n: usize| published(n).unwrap().iter().map(|(e, _)| e.name).collect::<Vec<_>>();
    assert!(named(1).contains(&"mono") && named(2) == ["rccc"]);
    assert!(named(3).starts_with(&["bayer", "quad-bayer"]));
    // The study `aliasing` has as many designs as docs/studies.md states.
    assert_eq!([3, 4, 5, 6].map(|n| named(n).len()), [12, 23, 1, 1]);
    for left_out in ["bayer-bggr", "rccb", "ryyb", "hirakawa2008", "condat2011", "random"] {
        assert!((1..=26).all(|n| !named(n).contains(&left_out)), "{left_out}");
    }
    // Blue, green, red ascend.
    assert_eq!(published(3).unwrap()[0].1.cells(), [2, 1, 1, 0]);
    let rgbw = published(4).unwrap().into_iter().find(|(e, _)| e.name == "rgbw").unwrap();
    assert_eq!(rgbw.1.cells(), [3, 1, 2, 0]);
    let rgbir = published(4).unwrap().into_iter().find(|(e, _)| e.name == "rgbir").unwrap();
    assert_eq!(rgbir.1.cells(), [0, 1, 3, 2]);
    let some = MosaicFamily::Catalogue.pick(4, Some(5), 3).unwrap();
    assert_eq!(some.iter().collect::<HashSet<_>>().len(), 5);
    assert_eq!(MosaicFamily::Catalogue.count(7), Ok(0));
}

proptest! {
    #[test]
    fn any_shift_mirror_or_turn_is_counted_once(seed: u64, pick in 0usize..128) {
        // The first mosaic of a sample is the class of all its images: any image, canonicalised by the exhaustive list
        // of the smaller space, is the same one.
        let family = tile(3, 3, Symmetry::ShiftMirrorRotation);
        let one = family.pick(3, Some(1), seed).unwrap().remove(0);
        let all = family.pick(3, None, 0).unwrap();
        prop_assert!(all.contains(&one));
        let images = images(&one, 3, 3, Symmetry::ShiftMirrorRotation);
        let image = &images[pick % images.len()];
        let same = |m: &&Mosaic| cells(m, 3, 3) == *image;
        prop_assert!(all.iter().find(same).is_none_or(|m| *m == one));
    }
}
