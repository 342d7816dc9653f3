use super::*;
use crate::design::Symmetry;

fn tile(rows: usize, cols: usize) -> Tile {
    Tile { rows, cols, symmetry: Symmetry::ShiftMirror }
}

fn rules(least_distance_px: f64, kept: &[&str]) -> LayoutRules {
    let kept = kept.iter().map(|s| (*s).to_owned()).collect();
    LayoutRules { least_distance_px, kept, ..LayoutRules::default() }
}

fn letters(mosaics: &[Mosaic]) -> Vec<String> {
    mosaics.iter().map(|m| m.cells().iter().map(|c| char::from(b'a' + c)).collect()).collect()
}

#[test]
fn rules_leave_the_layouts_that_fulfil_them() {
    let none = rules(0.0, &[]).of_tile(tile(2, 2)).unwrap();
    assert_eq!(none.all(3).unwrap().unwrap().len(), 3);
    // Bayer is the only tile of three filters without equal neighbours.
    let apart = rules(1.4, &[]).of_tile(tile(2, 2)).unwrap();
    assert_eq!(letters(&apart.all(3).unwrap().unwrap()), ["abbc"]);
    let kept = rules(0.0, &["a.", "b."]).of_tile(tile(2, 2)).unwrap();
    assert_eq!(letters(&kept.all(3).unwrap().unwrap()), ["aabc", "abbc", "acba", "acbb", "acbc"]);
}

#[test]
fn rules_that_conflict_are_named() {
    let key = |found: Result<(), DesignError>| match found {
        Err(DesignError::Key { key, message }) => (key, message),
        other => panic!("{other:?}"),
    };
    let (name, message) = key(rules(2.5, &[]).of_tile(tile(2, 2)).map(drop));
    assert!(name == "rules.least_distance_px" && message.contains("repeats after 2"), "{message}");
    let two = rules(1.9, &[]).of_tile(tile(2, 2)).unwrap();
    let (name, message) = key(two.all(3).map(drop));
    assert!(name == "rules.least_distance_px" && message.contains("no layout of 3 filters"), "{message}");
    assert_eq!(key(rules(0.0, &["ab"]).of_tile(tile(2, 2)).map(drop)).0, "rules.kept");
    // As many other filters as other cells.
    assert!(rules(0.0, &["ab", ".."]).of_tile(tile(2, 2)).unwrap().all(4).is_ok());
    let full = rules(0.0, &["ab", "ab"]).of_tile(tile(2, 2)).unwrap();
    assert_eq!(key(full.all(3).map(drop)).0, "colors");
    let mut unused = rules(0.0, &["a.", ".."]);
    unused.filters.insert('w', Filter::Flat(0.9));
    assert_eq!(key(unused.validate()).0, "rules.filters.w");
}

#[test]
fn many_layouts_are_not_listed() {
    assert_eq!(rules(0.0, &[]).of_tile(tile(4, 4)).unwrap().all(4).unwrap(), None);
}

#[test]
fn moves_keep_what_is_kept_and_every_filter() {
    let rules = rules(0.0, &["a...", "...."]).of_tile(tile(2, 4)).unwrap();
    let mut random = Stream::new(1, 2, 3);
    let mut cells = rules.random(4, &mut random);
    for _ in 0..500 {
        cells = rules.moved(&cells, 4, &mut random);
        assert!(cells[0] == 0 && (0..4).all(|f| cells.contains(&f)), "{cells:?}");
    }
}

/// Every move is a swap of two cells, another filter in a cell, or a shift of a row or column round the tile; all kinds occur.
#[test]
fn a_move_is_one_change() {
    const ROWS: usize = 3;
    const COLS: usize = 4;
    let rules = rules(0.0, &[]).of_tile(tile(ROWS, COLS)).unwrap();
    let cells: Vec<u8> = vec![0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0, 1];
    // The tile with its lines shifted round along a stride: a row or a column.
    let shifted = |places: Vec<usize>| {
        let mut next = cells.clone();
        (0..places.len()).for_each(|i| next[places[i]] = cells[places[(i + 1) % places.len()]]);
        next
    };
    let rows: Vec<Vec<u8>> = (0..ROWS).map(|r| shifted((0..COLS).map(|c| r * COLS + c).collect())).collect();
    let cols: Vec<Vec<u8>> = (0..COLS).map(|c| shifted((0..ROWS).map(|r| r * COLS + c).collect())).collect();
    let mut random = Stream::new(3, 2, 1);
    let mut seen = vec![0; ROWS + COLS];
    for _ in 0..2000 {
        let next = rules.moved(&cells, 5, &mut random);
        if let Some(line) = rows.iter().chain(&cols).position(|shifted| *shifted == next) {
            seen[line] += 1;
            continue;
        }
        let changed: Vec<usize> = (0..ROWS * COLS).filter(|i| next[*i] != cells[*i]).collect();
        let is_one = match changed[..] {
            [] | [_] => true,
            [a, b] => (next[a], next[b]) == (cells[b], cells[a]),
            _ => false,
        };
        assert!(is_one, "{next:?}");
    }
    assert!(seen.iter().all(|n| *n > 0), "{seen:?}");
}
