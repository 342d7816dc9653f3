//! The closed form of expected errors: against textbook Wiener estimation, against patches that are sampled, its derivatives, and an
//! optimum that is known.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, clippy::needless_range_loop)]

use smalti::camera::description::OpticsModelName;
use smalti::camera::{Camera, CameraDescription};
use smalti::design::DesignError;
use smalti::design::light::{LightClasses, LightGatherer, LightSettings, LightStatistics};
use smalti::design::screen::{
    ExpectedError, FigureWeights, Figures, FilterResponses, Screen, ScreenCondition, ScreenTime,
};
use smalti::design::search::{
    Annealing, FilterSearch, FilterSpace, FreeCurves, Goal, LayoutRules, LayoutSearch, Measured, Objective,
    Over, Pigments, SampledSpace, SearchSettings, Tolerance,
};
use smalti::design::{Symmetry, Tile};
use smalti::experiment::{Resources, light_statistics};
use smalti::scene::{Scene, Setting, catalog};
use smalti::sensor::{Cfa, Channel, Filter, Mosaic, NoiseMode};
use smalti::spectrum::{Illuminant, Observer, Spectrum, WavelengthGrid};

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;
const LUMINANCE: f64 = 5.0;
const TIME_S: f64 = 0.05;

/// A camera with read noise and without other noise than that of photons.
fn camera() -> Camera {
    let mut d = CameraDescription::default();
    (d.sensor.adc_bits, d.sensor.pixel.pitch_um, d.sensor.pixel.fill_factor) = (0, 2.2, 0.6);
    d.exposure.time_ms = Some(TIME_S * 1e3);
    Camera::new(d, GRID).unwrap()
}

/// Dead leaves on as many pixels as a third of their samples.
fn leaves(camera: &Camera, seed: u32) -> Scene {
    let spec = format!("dead-leaves?rows=360&cols=360&seed={seed}&least=2&largest=90");
    let setting = Setting { grid: GRID, ..Setting::default() };
    let reflectances: Vec<Spectrum> =
        smalti::spectrum::reflectance::natural(GRID).unwrap().into_iter().map(|(_, s)| s).collect();
    let scene = catalog::build(&spec, &setting, &reflectances).unwrap();
    let deg = camera.field_of_view_deg(180, setting.distance_m).unwrap();
    scene.with_fov(deg).unwrap()
}

fn settings(classes: LightClasses) -> LightSettings {
    LightSettings { max_components: 10, max_left_out: 0.0, step_px: 1, classes, ..LightSettings::default() }
}

fn statistics(camera: &Camera, scenes: &[Scene], settings: &LightSettings) -> LightStatistics {
    light_statistics(camera, &Illuminant::D65, Some(scenes), settings, Resources::default()).unwrap()
}

fn condition() -> ScreenCondition {
    ScreenCondition { luminance_cd_m2: LUMINANCE, time: ScreenTime::Fixed(TIME_S) }
}

fn bayer() -> Cfa {
    let channel = |name: &str, center_nm, sigma_nm| Channel {
        name: name.into(),
        transmittance: Filter::Gaussian { center_nm, sigma_nm, peak: 0.9 }.spectrum(GRID).unwrap(),
    };
    let channels = vec![channel("A", 450.0, 30.0), channel("B", 540.0, 40.0), channel("C", 610.0, 35.0)];
    Cfa::new("test", Mosaic::new(2, 2, vec![1, 2, 0, 1]).unwrap(), channels).unwrap()
}

/// Solves a x = b by elimination with pivoting, for several right-hand sides.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let n = a.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap();
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            for j in k..n {
                a[i][j] -= factor * a[k][j];
            }
            for j in 0..b[i].len() {
                b[i][j] -= factor * b[k][j];
            }
        }
    }
    for k in (0..n).rev() {
        for j in 0..b[k].len() {
            let sum: f64 = (k + 1..n).map(|i| a[k][i] * b[i][j]).sum();
            b[k][j] = (b[k][j] - sum) / a[k][k];
        }
    }
    b
}

/// The error of the Wiener estimate, written out from the moments: the mean square over X, Y, Z relative to white.
fn textbook(screen: &Screen, statistics: &LightStatistics, camera: &Camera, cfa: &Cfa) -> f64 {
    let transmittances: Vec<Spectrum> = cfa.channels().iter().map(|c| c.transmittance.clone()).collect();
    let spectra = screen.response_spectra();
    let response = |t: &Spectrum| -> Vec<f64> {
        spectra.iter().map(|s| s.values().iter().zip(t.values()).map(|(a, b)| a * b).sum()).collect()
    };
    let responses: Vec<Vec<f64>> = transmittances.iter().map(response).collect();
    let (side, k, xyz) = (statistics.settings().side, statistics.basis().len(), statistics.xyz());
    let (taps, n) = (side * side, statistics.coefficients());
    let exposure = camera
        .sensor
        .noise_variance(0.0, &smalti::sensor::Exposure { time_s: TIME_S, ..camera.gain_and_offset() });
    let dark_v2 = exposure.unwrap().total();
    let exposure = smalti::sensor::Exposure { time_s: TIME_S, ..camera.gain_and_offset() };
    let per_e = camera.sensor.volts_per_electron(&exposure) * exposure.analog_gain;
    let dark_e2 = dark_v2 / (per_e * per_e);
    let scale = LUMINANCE * TIME_S;
    let mosaic = cfa.mosaic();
    let (mut sum, mut patches) = (0.0, 0.0);
    for class in statistics.classes().values().filter(|c| c.moments.count() >= 64) {
        let m = &class.moments;
        let count = m.count() as f64;
        let mean = |i: usize| m.get(0, 1 + i) / count;
        let covariance = |i: usize, j: usize| m.get(1 + i, 1 + j) / count - mean(i) * mean(j);
        for position in 0..4 {
            // A, a row for each sample: in electrons.
            let channel = |tap: usize| {
                let (r, c) = (tap / side, tap % side);
                mosaic.channel_at(
                    position / 2 + r + 2 * side - side / 2,
                    position % 2 + c + 2 * side - side / 2,
                )
            };
            let row = |tap: usize| -> Vec<f64> {
                let mut row = vec![0.0; n];
                for (a, f) in responses[channel(tap)].iter().enumerate() {
                    row[tap * k + a] = f * scale;
                }
                row
            };
            let a: Vec<Vec<f64>> = (0..taps).map(row).collect();
            let seen =
                |vector: &[f64], i: usize| -> f64 { (0..n).map(|j| vector[j] * covariance(j, i)).sum() };
            let ac: Vec<Vec<f64>> = a.iter().map(|row| (0..n).map(|i| seen(row, i)).collect()).collect();
            let mut g: Vec<Vec<f64>> = ac
                .iter()
                .map(|ac| a.iter().map(|row| ac.iter().zip(row).map(|(x, y)| x * y).sum()).collect())
                .collect();
            for (tap, line) in g.iter_mut().enumerate() {
                let signal: f64 = (0..n).map(|i| a[tap][i] * mean(i)).sum();
                // The last term stands for the precision of the statistics.
                line[tap] += dark_e2 + signal + 1e-12 * signal * signal;
            }
            let middle = taps / 2 * k;
            let target =
                |of: &dyn Fn(usize) -> f64, c: usize| -> f64 { (0..k).map(|b| of(b) * xyz[b][c]).sum() };
            let crossed: Vec<Vec<f64>> =
                ac.iter().map(|ac| (0..3).map(|c| target(&|b| ac[middle + b], c)).collect()).collect();
            let solved = solve(g, crossed.clone());
            for c in 0..3 {
                let own = target(&|b| target(&|d| covariance(middle + b, middle + d), c), c);
                let known: f64 = crossed.iter().zip(&solved).map(|(r, w)| r[c] * w[c]).sum();
                sum += (own - known) * class.per_white_squared / 12.0;
            }
        }
        patches += count;
    }
    sum / patches
}

#[test]
fn the_closed_form_is_wiener_estimation() {
    let camera = camera();
    let classes = LightClasses { luminance_cuts: vec![0.8], ..LightClasses::default() };
    let statistics = statistics(
        &camera,
        &[leaves(&camera, 1)],
        &LightSettings { side: 3, max_components: 6, ..settings(classes) },
    );
    let screen = Screen::new(&camera, &statistics, &[condition()]).unwrap();
    let expected = screen.expected(&bayer()).unwrap()[0];
    let mean_square = textbook(&screen, &statistics, &camera, &bayer());
    let found = libm::pow(10.0, -0.1 * expected.cpsnr_db);
    assert!((found / mean_square - 1.0).abs() < 1e-9, "{found} and {mean_square}");
}

/// Kernels fitted to the drawn samples of the same patches have the expected error to 1 %.
#[test]
fn the_closed_form_is_what_kernels_of_drawn_samples_reach() {
    let camera = camera();
    let classes = LightClasses { contrast_cuts: Vec::new(), ..LightClasses::default() };
    let scene = leaves(&camera, 2);
    let statistics =
        statistics(&camera, std::slice::from_ref(&scene), &LightSettings { side: 3, ..settings(classes) });
    let screen = Screen::new(&camera, &statistics, &[condition()]).unwrap();
    let cfa = bayer();
    let expected = screen.expected(&cfa).unwrap()[0];
    // The same scene, captured in the light of the condition.
    let lit = scene.with_mean_luminance(LUMINANCE).unwrap();
    let camera = camera.with_size(180, 180).with_cfa(cfa.clone());
    let image = camera.optics.image(&lit).unwrap();
    let exposure = camera.exposure(&image).unwrap();
    let reference = camera.reference(&image).unwrap();
    let raw = camera.sensor.capture(&image, &exposure, NoiseMode::All, 3).unwrap();
    let samples = raw.normalized();
    let xyz = reference.channels();
    let mut sorted: Vec<f32> = xyz[1].to_vec();
    sorted.sort_by(f32::total_cmp);
    let white = f64::from(sorted[(sorted.len() as f64 * 0.995) as usize]);
    let (mut sum, mut count) = (0.0, 0usize);
    for position in 0..4 {
        // Normal equations of z = (1, nine samples) against X, Y, Z.
        let (mut gram, mut against) = (vec![vec![0.0; 10]; 10], vec![vec![0.0; 3]; 10]);
        let mut squares = 0.0;
        let mut patches = 0usize;
        for row in (1..179).filter(|r| r % 2 == position / 2) {
            for col in (1..179).filter(|c| c % 2 == position % 2) {
                let mut z = vec![1.0];
                z.extend((0..9).map(|t| f64::from(samples[(row + t / 3 - 1) * 180 + col + t % 3 - 1])));
                let y: Vec<f64> = (0..3).map(|c| f64::from(xyz[c][row * 180 + col]) / white).collect();
                for i in 0..10 {
                    for j in 0..10 {
                        gram[i][j] += z[i] * z[j];
                    }
                    for c in 0..3 {
                        against[i][c] += z[i] * y[c];
                    }
                }
                squares += y.iter().map(|v| v * v).sum::<f64>();
                patches += 1;
            }
        }
        let kernels = solve(gram, against.clone());
        let explained: f64 =
            kernels.iter().zip(&against).map(|(w, r)| w.iter().zip(r).map(|(w, r)| w * r).sum::<f64>()).sum();
        // Ten fitted numbers explain a share of the noise.
        sum += (squares - explained) * patches as f64 / (patches as f64 - 10.0);
        count += patches;
    }
    let sampled = sum / count as f64 / 3.0;
    let found = libm::pow(10.0, -0.1 * expected.cpsnr_db);
    assert!((found / sampled - 1.0).abs() < 0.01, "{found} and {sampled}");
}

fn random_responses(filters: usize, components: usize) -> FilterResponses {
    let value =
        |f: usize, k: usize| 20.0 * f64::sin((3 * f + 7 * k + 1) as f64) + if k == 0 { 400.0 } else { 0.0 };
    FilterResponses::new((0..filters).map(|f| (0..components).map(|k| value(f, k)).collect()).collect())
}

/// A search with default settings.
fn search<'a>(screens: &'a [Screen], space: &'a SampledSpace, goal: &'a Goal) -> FilterSearch<'a> {
    FilterSearch {
        screens,
        space,
        given: &[],
        goal,
        tolerance: Tolerance::default(),
        settings: SearchSettings::default(),
    }
}

#[test]
fn derivatives_are_those_of_finite_differences() {
    let camera = camera();
    let statistics = statistics(
        &camera,
        &[leaves(&camera, 3)],
        &LightSettings { max_components: 5, step_px: 3, ..settings(LightClasses::default()) },
    );
    // The second condition is limited by saturation.
    let limited = ScreenCondition { luminance_cd_m2: 500.0, time: ScreenTime::UpTo(0.5) };
    let screen = Screen::new(&camera, &statistics, &[condition(), limited]).unwrap();
    let space = FilterSpace::Free(FreeCurves::default()).sampled(GRID).unwrap();
    let mosaic = Mosaic::new(2, 3, vec![0, 1, 2, 3, 0, 2]).unwrap();
    let start: Vec<Vec<f64>> =
        (0..4).map(|f| (0..9).map(|j| f64::sin((f * 5 + j * 3) as f64)).collect()).collect();
    let own = screen.expected(&bayer()).unwrap().repeat(2);
    let cpsnr = Objective { delta_e_2000: 0.0, ..Objective::default() };
    let detail = Objective { detail_db: 2.0, ..cpsnr };
    let worst = Objective { over: Over::Worst, ..Objective::default() };
    let seen = Objective { cpsnr_db: 0.0, delta_e_2000: 0.3, scielab: 1.0, ..cpsnr };
    let spread = Tolerance { thickness: 0.1, shift_nm: 5.0, draws: 2 };
    // Two screens, as of two illuminants.
    let screens = [screen.clone(), screen];
    for (objective, tolerance, least) in [
        (cpsnr, Tolerance::default(), 1e-6),
        (detail, Tolerance::default(), 1e-6),
        (cpsnr, spread, 1e-6),
        (Objective::default(), Tolerance::default(), 1e-5),
        (seen, Tolerance::default(), 1e-5),
        (worst, Tolerance::default(), 1e-5),
    ] {
        let goal = objective.goal(&own);
        let search = FilterSearch { tolerance, ..search(&screens, &space, &goal) };
        let cost = |p: &[Vec<f64>]| search.cost(&mosaic, p).0;
        let (_, gradient) = search.cost(&mosaic, &start);
        let largest = gradient.iter().flatten().fold(0.0f64, |m, g| m.max(g.abs()));
        for (filter, knot) in [(0, 1), (1, 4), (2, 0), (3, 8), (2, 6)] {
            let moved = |by: f64| {
                let mut p = start.clone();
                p[filter][knot] += by;
                cost(&p)
            };
            // A difference of fourth order.
            let h = 1e-3;
            let found = (8.0 * (moved(h) - moved(-h)) - (moved(2.0 * h) - moved(-2.0 * h))) / (12.0 * h);
            let error = (found - gradient[filter][knot]).abs() / largest;
            assert!(error < least, "{filter} {knot}: {found}, {}", gradient[filter][knot]);
        }
    }
}

#[test]
fn one_set_has_the_figures_that_it_has_among_others() {
    let camera = camera();
    let statistics = statistics(
        &camera,
        &[leaves(&camera, 4)],
        &LightSettings { side: 3, max_components: 4, step_px: 3, ..settings(LightClasses::default()) },
    );
    let screen = Screen::new(&camera, &statistics, &[condition()]).unwrap();
    let mosaic = Mosaic::new(2, 2, vec![0, 1, 2, 3]).unwrap();
    let sets: Vec<FilterResponses> = (0..20).map(|i| random_responses(4 + i % 2, 4)).collect();
    let all = screen.expected_of(&mosaic, &sets, Figures::All);
    for (set, expected) in sets.iter().zip(&all) {
        assert_eq!(&screen.expected_of(&mosaic, std::slice::from_ref(set), Figures::All)[0], expected);
        let differentiable = screen.differentiable(&mosaic, set, Figures::All);
        let ExpectedError { cpsnr_db, delta_e_2000, scielab, .. } = expected[0];
        assert!((differentiable.expected()[0].cpsnr_db - cpsnr_db).abs() < 1e-9);
        assert!((differentiable.expected()[0].delta_e_2000 - delta_e_2000).abs() < 1e-9);
        assert!((differentiable.expected()[0].scielab - scielab).abs() < 1e-9);
        let by_response = differentiable.by_response(&[FigureWeights::default()]);
        assert!(by_response.iter().flatten().all(|g| *g == 0.0));
    }
    // The colours of the tile only have to be shifted: the mean over its positions is the same.
    let shifted = screen.expected_of(&mosaic.shifted(1, 1), &sets[..1], Figures::Cpsnr);
    assert!((shifted[0][0].cpsnr_db - all[0][0].cpsnr_db).abs() < 1e-9);
}

/// Without noise and on flat fields, filters that are mixtures of the observer's functions (Luther's condition) have no colour error, and
/// others have one.
#[test]
fn filters_that_span_the_cones_see_every_flat_colour() {
    let mut d = CameraDescription::default();
    (d.sensor.adc_bits, d.sensor.pixel.read_noise_mv, d.sensor.pixel.dark_voltage_v_per_s) = (0, 0.0, 0.0);
    d.exposure.time_ms = Some(1e9);
    // Without blur, the borders of flat scenes are flat as well.
    d.optics.model = OpticsModelName::Pinhole;
    let camera = Camera::new(d, GRID).unwrap();
    let scenes: Vec<Scene> = smalti::spectrum::reflectance::natural(GRID)
        .unwrap()
        .into_iter()
        .step_by(3)
        .map(|(name, s)| {
            let light = Illuminant::D65.photons(GRID).unwrap();
            let radiance = s.times(&light).unwrap();
            let planes: Vec<f32> =
                radiance.values().iter().flat_map(|v| std::iter::repeat_n(*v as f32, 256)).collect();
            let planes = smalti::numeric::Planes::new(16, 16, GRID.len(), planes).unwrap();
            let cube = smalti::spectrum::SpectralCube::new(GRID, planes).unwrap();
            let deg = camera.field_of_view_deg(16, 1.2).unwrap();
            Scene::new(name, cube, light, 1.2, deg).unwrap()
        })
        .collect();
    let classes = LightClasses { contrast_cuts: Vec::new(), ..LightClasses::default() };
    let settings = LightSettings { side: 3, max_components: 8, ..settings(classes) };
    let statistics = statistics(&camera, &scenes, &settings);
    let condition = ScreenCondition { luminance_cd_m2: 1e6, time: ScreenTime::Fixed(1e9) };
    let screen = Screen::new(&camera, &statistics, &[condition]).unwrap();
    // What a transmittance must be for a pixel to have the sensitivity of the observer.
    let lens = camera.optics.transmittance_on(GRID).unwrap();
    let bare = camera.sensor.bare_responsivity_on(GRID).unwrap();
    let observer = Observer::Cie1931.photon_weights(GRID).unwrap();
    let luther = |function: &Spectrum| {
        let of = |i: usize| {
            let (f, b) = (function.values()[i], bare.values()[i] * lens.values()[i]);
            if b > 1e-4 { f / b } else { 0.0 }
        };
        let values: Vec<f64> = (0..GRID.len()).map(of).collect();
        let most = values.iter().copied().fold(0.0, f64::max);
        Spectrum::new(GRID, values.iter().map(|v| v / most).collect()).unwrap()
    };
    let mosaic = Mosaic::new(2, 2, vec![0, 1, 2, 1]).unwrap();
    let of = |filters: [Spectrum; 3]| {
        screen.expected_of(&mosaic, &[screen.responses(&filters)], Figures::All)[0][0].delta_e_2000
    };
    let cones = of(observer.each_ref().map(luther));
    let narrow = of([450.0, 550.0, 650.0]
        .map(|center_nm| Filter::Gaussian { center_nm, sigma_nm: 15.0, peak: 1.0 }.spectrum(GRID).unwrap()));
    assert!(cones < 1e-3 && narrow > 0.3, "{cones} and {narrow}");
}

/// The same search finds the same filters, whose cost is not above that of any start that was drawn.
#[test]
fn a_search_is_reproducible_and_its_filters_can_be_made() {
    let camera = camera();
    let statistics = statistics(
        &camera,
        &[leaves(&camera, 5)],
        &LightSettings { side: 3, max_components: 5, step_px: 3, ..settings(LightClasses::default()) },
    );
    let screen = Screen::new(&camera, &statistics, &[condition()]).unwrap();
    let space = FilterSpace::Pigments(Pigments::default()).sampled(GRID).unwrap();
    let settings = SearchSettings { starts: 4, steps: 30, seed: 9 };
    let (screens, goal) = ([screen], Objective::default().goal(&[ExpectedError::default()]));
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
    let camera = camera();
    let settings =
        LightSettings { side: 3, max_components: 5, step_px: 3, ..settings(LightClasses::default()) };
    let statistics = statistics(&camera, &[leaves(&camera, 5)], &settings);
    let screens = [Screen::new(&camera, &statistics, &[condition()]).unwrap()];
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
    let camera = camera();
    let settings =
        LightSettings { side: 3, max_components: 5, step_px: 4, ..settings(LightClasses::default()) };
    let statistics = statistics(&camera, &[leaves(&camera, 5)], &settings);
    let screens = [Screen::new(&camera, &statistics, &[condition()]).unwrap()];
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
    let camera = camera();
    let settings =
        LightSettings { side: 3, max_components: 5, step_px: 3, ..settings(LightClasses::default()) };
    let statistics = statistics(&camera, &[leaves(&camera, 5)], &settings);
    let screens = [Screen::new(&camera, &statistics, &[condition()]).unwrap()];
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

#[test]
fn statistics_of_two_sets_are_those_of_both() {
    let camera = camera();
    let (a, b) = (leaves(&camera, 6), leaves(&camera, 7));
    let settings =
        LightSettings { side: 3, max_components: 4, step_px: 4, ..settings(LightClasses::default()) };
    let mut first = statistics(&camera, std::slice::from_ref(&a), &settings);
    first.merge(&statistics(&camera, std::slice::from_ref(&b), &settings)).unwrap();
    let both = statistics(&camera, &[a.clone(), b], &settings);
    assert_eq!((first.patches(), first.scenes()), (both.patches(), 2));
    for (number, class) in both.classes() {
        let merged = &first.classes()[number];
        for (x, y) in class.moments.sums().iter().zip(merged.moments.sums()) {
            assert!((x - y).abs() <= 1e-12 * x.abs().max(1.0));
        }
    }
    // Any thread count gives the same bits.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let again = one.install(|| statistics(&camera, std::slice::from_ref(&a), &settings));
    assert_eq!(again, statistics(&camera, std::slice::from_ref(&a), &settings));
    // Other light cannot be merged.
    let other =
        light_statistics(&camera, &Illuminant::A, Some(&[a]), &settings, Resources::default()).unwrap();
    assert_eq!(first.merge(&other), Err(DesignError::OtherLight { what: "lens, pixel or light" }));
}

#[test]
fn what_cannot_be_described_is_refused() {
    let key = |camera: &Camera, settings: &LightSettings| match LightGatherer::new(
        camera,
        &Illuminant::D65,
        &[Illuminant::D65.photons(GRID).unwrap()],
        settings,
    ) {
        Err(DesignError::Key { key, .. }) => key,
        other => panic!("{other:?}"),
    };
    let plain = camera();
    assert_eq!(key(&plain, &LightSettings { side: 4, ..LightSettings::default() }), "side");
    let mut crossed = plain.clone();
    crossed.sensor.crosstalk = Some([[0.0, 0.01, 0.0], [0.01, 0.96, 0.01], [0.0, 0.01, 0.0]]);
    assert_eq!(key(&crossed, &LightSettings::default()), "sensor.crosstalk");
    let empty = LightGatherer::new(
        &plain,
        &Illuminant::D65,
        &[Illuminant::D65.photons(GRID).unwrap()],
        &LightSettings::default(),
    );
    let empty = empty.unwrap().statistics();
    assert!(matches!(Screen::new(&plain, &empty, &[condition()]), Err(DesignError::TooFewPatches { .. })));
}
