//! The closed form of expected errors: against textbook Wiener estimation, against patches that are sampled, its derivatives, and an
//! optimum that is known.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, clippy::needless_range_loop)]

mod searches;
mod wiener;

use smalti::camera::description::OpticsModelName;
use smalti::camera::{Camera, CameraDescription};
use smalti::design::DesignError;
use smalti::design::light::{LightClasses, LightGatherer, LightParts, LightSettings, LightStatistics};
use smalti::design::screen::{
    ExpectedError, FigureWeights, Figures, FilterResponses, Screen, ScreenCondition, ScreenTime,
};
use smalti::design::search::{
    FilterSearch, FilterSpace, FreeCurves, Goal, Objective, Over, SampledSpace, SearchSettings, Tolerance,
};
use smalti::experiment::{Resources, light_statistics};
use smalti::scene::{Scene, Setting, catalog};
use smalti::sensor::{Binning, BinningMode, Cfa, Channel, Filter, Mosaic};
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

/// The closed form on patches of 3 × 3 pixels of one picture of leaves, every `step_px` pixels.
fn screen(seed: u32, max_components: usize, step_px: usize) -> Screen {
    let camera = camera();
    let settings = LightSettings { side: 3, max_components, step_px, ..settings(LightClasses::default()) };
    let statistics = statistics(&camera, &[leaves(&camera, seed)], &settings);
    Screen::new(&camera, &statistics, &[condition()]).unwrap()
}

fn bayer() -> Cfa {
    let channel = |name: &str, center_nm, sigma_nm| Channel {
        name: name.into(),
        transmittance: Filter::Gaussian { center_nm, sigma_nm, peak: 0.9 }.spectrum(GRID).unwrap(),
    };
    let channels = vec![channel("A", 450.0, 30.0), channel("B", 540.0, 40.0), channel("C", 610.0, 35.0)];
    Cfa::new("test", Mosaic::new(2, 2, vec![1, 2, 0, 1]).unwrap(), channels).unwrap()
}

/// A kernel without symmetry.
const CROSSTALK: [[f64; 3]; 3] = [[0.01, 0.05, 0.0], [0.03, 0.75, 0.04], [0.02, 0.08, 0.02]];

fn with_crosstalk() -> Camera {
    let mut camera = camera();
    camera.sensor.crosstalk = Some(CROSSTALK);
    camera
}

/// A camera that bins 2 × 2 photodiodes of half the pitch.
fn binned(mode: BinningMode) -> Camera {
    let mut camera = camera();
    camera.sensor.binning = Some(Binning { side: 2, mode });
    camera
}

/// The same with a crosstalk of 9 % between its photodiodes, also without symmetry.
fn binned_with_crosstalk(mode: BinningMode) -> Camera {
    let mut camera = binned(mode);
    camera.sensor.crosstalk = Some([[0.005, 0.02, 0.0], [0.01, 0.91, 0.015], [0.01, 0.025, 0.005]]);
    camera
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
    derivatives_are_right(&camera(), 5);
}

#[test]
fn derivatives_with_crosstalk_are_those_of_finite_differences() {
    derivatives_are_right(&with_crosstalk(), 3);
}

fn derivatives_are_right(camera: &Camera, side: usize) {
    let statistics = statistics(
        camera,
        &[leaves(camera, 3)],
        &LightSettings { side, max_components: 5, step_px: 3, ..settings(LightClasses::default()) },
    );
    // The second condition is limited by saturation.
    let limited = ScreenCondition { luminance_cd_m2: 500.0, time: ScreenTime::UpTo(0.5) };
    let screen = Screen::new(camera, &statistics, &[condition(), limited]).unwrap();
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
    let screen = screen(4, 4, 3);
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
        assert_eq!(class.colors, merged.colors);
        assert_eq!(class.per_white_squared, merged.per_white_squared);
    }
    assert_eq!(first.parts().energy, both.parts().energy);
    assert!(
        first.luminance_error() == both.luminance_error() && (1e-6..0.1).contains(&first.luminance_error())
    );
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
    // Patches of light that leave too few samples within their outermost ring, and patches that are too large for one more.
    let small = LightSettings { side: 3, step_px: 4, ..settings(LightClasses::default()) };
    let narrow = statistics(&plain, &[leaves(&plain, 4)], &small);
    let refused = Screen::new(&with_crosstalk(), &narrow, &[condition()]);
    assert!(matches!(refused, Err(DesignError::Key { key, .. }) if key == "light.side"));
    assert!(LightSettings { side: 9, ..LightSettings::default() }.around(&with_crosstalk()).is_err());
    let empty = LightGatherer::new(
        &plain,
        &Illuminant::D65,
        &[Illuminant::D65.photons(GRID).unwrap()],
        &LightSettings::default(),
    );
    let empty = empty.unwrap().statistics();
    assert!(matches!(Screen::new(&plain, &empty, &[condition()]), Err(DesignError::TooFewPatches { .. })));
}

/// The statistics of a small picture of a chart, of one class.
fn of_chart(camera: &Camera, luminance_cd_m2: f64) -> LightStatistics {
    let setting = Setting { grid: GRID, luminance_cd_m2, ..Setting::default() };
    let deg = camera.field_of_view_deg(24, setting.distance_m).unwrap();
    let chart = catalog::build_natural("macbeth?patch=8", &setting).unwrap().with_fov(deg).unwrap();
    let classes = LightClasses { contrast_cuts: Vec::new(), ..LightClasses::default() };
    statistics(camera, &[chart], &LightSettings { side: 3, ..settings(classes) })
}

/// Statistics are relative to the luminance of a scene, but for the rounding of light to single precision.
#[test]
fn statistics_do_not_depend_on_the_luminance() {
    let camera = camera();
    let [dim, bright] = [2.0, 300.0].map(|luminance| of_chart(&camera, luminance).parts());
    assert_eq!(dim.classes.len(), 1);
    let (a, b) = (&dim.classes[0], &bright.classes[0]);
    // The error of Y is a difference of nearly equal numbers, of which rounding is a larger part.
    let energy = dim.energy.iter().zip(&bright.energy).map(|pair| (pair, 1e-3));
    // The number of patches, and the first and largest component of each of the nine pixels.
    let firsts = 1 + 8 * dim.components.len() + 1;
    let places = std::iter::once(0).chain((1..firsts).step_by(dim.components.len()));
    let sums = places.map(|at| ((&a.sums[at], &b.sums[at]), 1e-4));
    let white = std::iter::once(((&a.per_white_squared, &b.per_white_squared), 1e-4));
    for ((x, y), tolerance) in energy.chain(sums).chain(white) {
        assert!((x - y).abs() <= tolerance * x.abs().max(y.abs()).max(1e-3), "{x} {y}");
    }
    assert!(dim.energy[0] > 100.0 && dim.energy[1] < 0.01 * dim.energy[0], "{:?}", dim.energy);
}

/// The components describe white, which is among the colours that they are made for, to a small part of the energy that they leave out.
#[test]
fn white_is_the_sum_of_its_components() {
    let statistics = of_chart(&camera(), 100.0);
    assert_eq!(statistics.white_coefficients().len(), statistics.basis().len());
    let white = Observer::Cie1931.white(&Illuminant::D65.photons(GRID).unwrap()).unwrap();
    for c in 0..3 {
        let parts = statistics.white_coefficients().iter().zip(statistics.xyz());
        let found: f64 = parts.map(|(coefficient, xyz)| coefficient * xyz[c]).sum();
        assert!((found - white[c]).abs() < 0.01, "{found} {}", white[c]);
        assert_eq!(statistics.white()[c], white[c]);
    }
}

/// Statistics that are made of the parts of others equal them, and a part that does not fit the others is named.
#[test]
fn statistics_are_those_of_their_parts() {
    let statistics = of_chart(&camera(), 100.0);
    assert_eq!(LightStatistics::from_parts(statistics.parts()).as_ref(), Ok(&statistics));
    let key = |change: &dyn Fn(&mut LightParts)| {
        let mut parts = statistics.parts();
        change(&mut parts);
        match LightStatistics::from_parts(parts) {
            Err(DesignError::Key { key, .. }) => key,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(key(&|p| p.settings.side = 5), "class 0");
    assert_eq!(key(&|p| p.settings.step_px = 0), "step_px");
    assert_eq!(key(&|p| p.components.clear()), "components");
    assert_eq!(key(&|p| p.components[1][3] = f64::NAN), "components");
    assert_eq!(key(&|p| drop(p.analysis.pop())), "analysis");
    assert_eq!(key(&|p| p.xyz[0][2] = f64::INFINITY), "xyz");
    assert_eq!(key(&|p| p.white_coefficients.push(1.0)), "white_coefficients");
    assert_eq!(key(&|p| p.white[1] = 0.0), "white");
    assert_eq!(key(&|p| p.energy[1] = -1.0), "energy");
    assert_eq!(key(&|p| p.left_out = 1.1), "left_out");
    assert_eq!(key(&|p| p.classes[0].number = 1), "class 1");
    assert_eq!(key(&|p| p.classes[0].sums.truncate(5)), "class 0");
    assert_eq!(key(&|p| p.classes[0].per_white_squared = 0.0), "class 0");
    assert_eq!(key(&|p| p.classes[0].colors = Default::default()), "class 0");
}
