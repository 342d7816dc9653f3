use super::*;
use crate::color::ColorSpace;
use crate::color::difference::delta_e_map;
use crate::numeric::Planes;

const WHITE: [f64; 3] = [95.047, 100.0, 108.883];

fn grey(rows: usize, cols: usize, y: impl Fn(usize, usize) -> f64) -> Image {
    let plane = |w: f64| (0..rows * cols).map(|i| (y(i / cols, i % cols) * w) as f32).collect::<Vec<_>>();
    let data = WHITE.iter().flat_map(|w| plane(w / 100.0)).collect();
    Image::new(ColorSpace::Xyz, Planes::new(rows, cols, 3, data).unwrap()).unwrap()
}

#[test]
fn uniform_pictures_differ_as_their_colours() {
    let (a, b) = (grey(40, 50, |_, _| 50.0), grey(40, 50, |_, _| 55.0));
    for formula in [DeltaE::Cie1976, DeltaE::Cie1994, DeltaE::Ciede2000] {
        let plain = delta_e_map(&a, &b, WHITE, formula).unwrap();
        for kernels in [KernelWidth::ZhangWandell1997, KernelWidth::Isetcam] {
            let map = Scielab { kernels, ..Scielab::new(30.0, formula) }.compare(&a, &b, WHITE).unwrap();
            for (got, want) in map.values.iter().zip(&plain.values) {
                assert!((got - want).abs() < 1e-3, "{formula:?}: {got} is not {want}");
            }
        }
    }
}

/// An error of brightness is seen alike under every light, and a uniform picture differs as its colour does.
#[test]
fn achromatic_errors_are_the_same_under_every_light() {
    let under = |white: [f64; 3], y: &dyn Fn(usize, usize) -> f64| {
        let plane = |w: f64| (0..60 * 60).map(|i| (y(i / 60, i % 60) * w) as f32).collect::<Vec<_>>();
        let data = white.iter().flat_map(|w| plane(w / white[1])).collect();
        Image::new(ColorSpace::Xyz, Planes::new(60, 60, 3, data).unwrap()).unwrap()
    };
    let edge = |_: usize, c: usize| if c < 30 { 8.0 } else { 80.0 };
    let blurred = |r: usize, c: usize| edge(r, c) + if c == 30 { -25.0 } else { (r % 3) as f64 };
    let maps = |adaptation| {
        // D65, illuminant A, and a blue sky.
        [WHITE, [109.85, 100.0, 35.585], [98.0, 100.0, 130.0]].map(|white| {
            let scielab = Scielab { adaptation, ..Scielab::new(60.0, DeltaE::Cie1976) };
            scielab.compare(&under(white, &edge), &under(white, &blurred), white).unwrap().values
        })
    };
    let [d65, others @ ..] = maps(Adaptation::White);
    for other in others {
        for (a, b) in d65.iter().zip(&other) {
            assert!((a - b).abs() < 2e-3, "{a} {b}");
        }
    }
    // Without adaptation, D65 is the same and the lamp is not.
    let [plain, lamp, _] = maps(Adaptation::None);
    let mean = |map: &[f32]| map.iter().map(|v| f64::from(*v)).sum::<f64>() / map.len() as f64;
    assert!((mean(&plain) - mean(&d65)).abs() < 1e-4, "{} {}", mean(&plain), mean(&d65));
    assert!(mean(&lamp) > 1.1 * mean(&d65), "{} {}", mean(&lamp), mean(&d65));
    let lamp = [109.85, 100.0, 35.585];
    let (dark, bright) = (under(lamp, &|_, _| 40.0), under(lamp, &|_, _| 43.0));
    let colors = delta_e_map(&dark, &bright, lamp, DeltaE::Cie1976).unwrap();
    let seen = scielab(&dark, &bright, lamp, 60.0, DeltaE::Cie1976).unwrap();
    assert!((seen.mean() - colors.mean()).abs() < 1e-3, "{} {}", seen.mean(), colors.mean());
}

/// Zhang and Wandell 1997, table 1: weights with three decimals, of planes that sum to 0.918, 0.861 and 0.859, and spreads in
/// degrees, where a kernel has fallen to 1/e.
#[test]
fn the_kernels_are_those_of_the_paper() {
    let paper: [(f64, &[(f64, f64)]); 3] = [
        (0.918, &[(0.921, 0.0283), (0.105, 0.133), (-0.108, 4.336)]),
        (0.861, &[(0.531, 0.0392), (0.330, 0.494)]),
        (0.859, &[(0.488, 0.0536), (0.371, 0.386)]),
    ];
    // Many samples within the narrowest Gaussian.
    let kernels = Scielab::new(400.0, DeltaE::Cie1976).kernels().unwrap();
    for (kernel, (sum, stated)) in kernels.iter().zip(paper) {
        assert_eq!(kernel.len(), stated.len());
        let total: f32 = kernel.iter().map(|g| g.weight).sum();
        assert!((total - 1.0).abs() < 1e-6, "{total}");
        for (gaussian, &(weight, degrees)) in kernel.iter().zip(stated) {
            let printed = f64::from(gaussian.weight) * sum;
            assert!((printed - weight).abs() < 0.0006, "{printed} for {weight}");
            // ln(h₀/hᵢ) = (i / σ)², of a sample near σ, or the last of half a degree.
            let i = ((degrees * 400.0) as usize).min(gaussian.half.len() - 1);
            let ratio = f64::from(gaussian.half[0]) / f64::from(gaussian.half[i]);
            let sigma = i as f64 / ratio.ln().sqrt() / 400.0;
            assert!((sigma / degrees - 1.0).abs() < 0.01, "{sigma} for {degrees}");
        }
    }
}

#[test]
fn a_fine_pattern_vanishes_and_a_coarse_one_stays() {
    let mean = grey(96, 96, |_, _| 50.0);
    let with_period =
        |p: f64| grey(96, 96, move |_, c| 50.0 + 10.0 * (c as f64 * std::f64::consts::TAU / p).sin());
    let score = |p: f64| scielab(&mean, &with_period(p), WHITE, 60.0, DeltaE::Ciede2000).unwrap().mean();
    // 30, 10 and 1.25 cycles per degree.
    let (fine, middle, coarse) = (score(3.0), score(6.0), score(48.0));
    assert!(fine < 0.15 * coarse && fine < middle && middle < coarse, "{fine} {middle} {coarse}");
}

#[test]
fn bad_input_is_refused() {
    let (a, b) = (grey(4, 4, |_, _| 1.0), grey(4, 5, |_, _| 1.0));
    assert!(matches!(
        scielab(&a, &b, WHITE, 60.0, DeltaE::Cie1976),
        Err(ScielabError::Image(ImageError::Size { .. }))
    ));
    for s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(scielab(&a, &a, WHITE, s, DeltaE::Cie1976), Err(ScielabError::SamplesPerDegree(_))));
    }
    for white in [[0.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, f64::NAN], [f64::INFINITY, 1.0, 1.0]] {
        assert!(matches!(scielab(&a, &a, white, 60.0, DeltaE::Cie1976), Err(ScielabError::White(_))));
    }
    let srgb = Image::new(ColorSpace::Srgb, Planes::zeros(4, 4, 3)).unwrap();
    assert!(scielab(&srgb, &srgb, WHITE, 60.0, DeltaE::Cie1976).is_err());
    // Images smaller than the kernel, and an empty image.
    assert_eq!(
        scielab(&grey(1, 2, |_, _| 3.0), &grey(1, 2, |_, _| 3.0), WHITE, 100.0, DeltaE::Cie1976)
            .unwrap()
            .max(),
        0.0
    );
    let empty = Image::new(ColorSpace::Xyz, Planes::zeros(0, 0, 3)).unwrap();
    assert!(scielab(&empty, &empty, WHITE, 60.0, DeltaE::Cie1976).unwrap().values.is_empty());
}
