//! Searches of filters and layouts: reproducible, of filters that can be made, and as good as trying all.

use smalti::design::screen::ExpectedError;
use smalti::design::search::{
    Annealing, FilterSearch, FilterSpace, FreeCurves, LayoutRules, LayoutSearch, Measured, Objective,
    Pigments, SearchSettings,
};
use smalti::design::{Symmetry, Tile};
use smalti::sensor::{Filter, Mosaic};

use super::{GRID, screen, search};

/// The same search finds the same filters, whose cost is not above that of any start that was drawn.
#[test]
fn a_search_is_reproducible_and_its_filters_can_be_made() {
    let space = FilterSpace::Pigments(Pigments::default()).sampled(GRID).unwrap();
    let settings = SearchSettings { starts: 4, steps: 30, seed: 9 };
    let (screens, goal) = ([screen(5, 5, 3)], Objective::default().goal(&[ExpectedError::default()]));
    let search = FilterSearch { settings, ..search(&screens, &space, &goal) };
    let mosaic = Mosaic::new(2, 2, vec![0, 1, 2, 1]).unwrap();
    let run = || search.filters(&mosaic, &[], 3, &|_| true).unwrap();
    let found = run();
    assert_eq!(found, run());
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(found, one.install(run));
    assert!(found.windows(2).all(|w| w[0].cost <= w[1].cost));
    for filters in &found {
        for parameters in &filters.parameters {
            let thick = space.thicknesses(parameters).unwrap();
            assert!(thick.iter().filter(|d| **d > 1e-9).count() <= 2);
        }
        assert!(filters.transmittances.iter().all(|t| t.values().iter().all(|v| (0.0..=0.95).contains(v))));
    }
    // A stopped search keeps what it has found.
    assert!(!search.filters(&mosaic, &[], 3, &|_| false).unwrap().is_empty());
    // A search that begins with what was found ends no worse.
    let again = search.filters(&mosaic, &[found[0].parameters.clone()], 4, &|_| true).unwrap();
    assert!(again[0].cost <= found[0].cost);
}

/// Filters that are given stay as they are, and the others are found beside them.
#[test]
fn given_filters_are_kept() {
    let screens = [screen(5, 5, 3)];
    let space = FilterSpace::Free(FreeCurves::default()).sampled(GRID).unwrap();
    let goal = Objective::default().goal(&[ExpectedError::default()]);
    let clear = Filter::Flat(0.9).spectrum(GRID).unwrap();
    let given = [None, Some(clear.clone())];
    let settings = SearchSettings { starts: 3, steps: 20, seed: 1 };
    let search = FilterSearch { given: &given, settings, ..search(&screens, &space, &goal) };
    let mosaic = Mosaic::new(2, 2, vec![0, 1, 2, 1]).unwrap();
    let found = search.filters(&mosaic, &[], 0, &|_| true).unwrap();
    for filters in &found {
        assert_eq!(filters.transmittances[1], clear);
        assert!(filters.parameters[1].is_empty() && filters.transmittances[0] != filters.transmittances[2]);
    }
}

/// A choice among filters is that of the cheapest of all sets, and the exchange of one at a time finds it as well.
#[test]
fn the_choice_among_filters_is_the_cheapest() {
    let screens = [screen(5, 5, 4)];
    let goal = Objective::default().goal(&[ExpectedError::default()]);
    let mosaic = Mosaic::new(2, 2, vec![0, 1, 2, 1]).unwrap();
    let curve =
        |at: usize| Filter::Gaussian { center_nm: 420.0 + 13.0 * at as f64, sigma_nm: 40.0, peak: 0.9 };
    let choose = |count: usize| {
        let library = (0..count).map(curve).collect();
        let space = FilterSpace::Measured(Measured { library }).sampled(GRID).unwrap();
        let search = search(&screens, &space, &goal);
        let found = search.filters(&mosaic, &[], 0, &|_| true).unwrap();
        let cost = |set: [usize; 3]| search.cost(&mosaic, &set.map(|at| vec![at as f64])).0;
        let all = (0..count * count * count).map(|n| [n % count, n / count % count, n / count / count]);
        let best = all.map(cost).fold(f64::INFINITY, f64::min);
        (found[0].cost, best)
    };
    // 6³ sets are all tried; 17³ are more than that.
    for count in [6, 17] {
        let (found, best) = choose(count);
        assert!((found - best).abs() < 1e-9 * best.abs(), "{count}: {found} {best}");
    }
}

/// Annealing finds the layout that is the best of all, in tiles that are small enough to try each.
#[test]
fn annealing_finds_what_enumeration_finds() {
    let screens = [screen(5, 5, 3)];
    let space = FilterSpace::Free(FreeCurves::default()).sampled(GRID).unwrap();
    let goal = Objective::default().goal(&[ExpectedError::default()]);
    let settings = SearchSettings { starts: 6, steps: 60, seed: 2 };
    let search = FilterSearch { settings, ..search(&screens, &space, &goal) };
    for (rows, cols, colors) in [(2, 2, 3), (2, 3, 3)] {
        let tile = Tile { rows, cols, symmetry: Symmetry::ShiftMirror };
        let rules = LayoutRules::default().of_tile(tile).unwrap();
        let finish = |mosaic: &Mosaic, first: &[Vec<Vec<f64>>]| {
            search.filters(mosaic, first, 0, &|_| true).unwrap()[0].cost
        };
        let listed = rules.all(colors).unwrap().unwrap();
        let best = listed.iter().map(|m| finish(m, &[])).fold(f64::INFINITY, f64::min);
        let annealing = Annealing { chains: 4, rounds: 3, moves: 60 };
        let layouts = LayoutSearch { filters: search, rules: &rules, annealing };
        let found = layouts.layouts(colors, &|_| true).unwrap();
        let annealed = finish(&found[0].mosaic, std::slice::from_ref(&found[0].parameters));
        assert!((annealed - best).abs() < 0.01, "{rows} × {cols}: {annealed} {best}");
        assert_eq!(found, layouts.layouts(colors, &|_| true).unwrap());
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(found, one.install(|| layouts.layouts(colors, &|_| true).unwrap()));
    }
}

/// A search that goes on searches each start to the end; one that is stopped after the first leaves the others as they are.
#[test]
fn only_a_search_that_is_stopped_ends_early() {
    let screens = [screen(5, 5, 3)];
    let space = FilterSpace::Free(FreeCurves::default()).sampled(GRID).unwrap();
    let goal = Objective::default().goal(&[ExpectedError::default()]);
    let settings = SearchSettings { starts: 6, steps: 100, seed: 4 };
    let search = FilterSearch { settings, ..search(&screens, &space, &goal) };
    let mosaic = Mosaic::new(2, 2, vec![0, 1, 2, 1]).unwrap();
    // With one thread, starts follow each other.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let costs = |goes_on: bool| -> f64 {
        let found = one.install(|| search.filters(&mosaic, &[], 0, &|_| goes_on).unwrap());
        assert_eq!(found.len(), 3);
        found.iter().map(|f| f.cost).sum()
    };
    let (all, stopped) = (costs(true), costs(false));
    assert!(all < stopped, "{all} {stopped}");
}
