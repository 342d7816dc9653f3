use super::*;
use crate::color::difference::delta_e_2000;
use crate::color::jakob_hanika2019::Uplift;
use crate::spectrum::Illuminant;

fn repaint() -> Repaint {
    Repaint::new(WavelengthGrid::VISIBLE, Observer::Cie1931).unwrap()
}

/// The colours in CIELAB that a picture and its reflectances have under D65.
fn colours(repaint: &Repaint, image: &Image, cube: &SpectralCube) -> Vec<[[f64; 3]; 2]> {
    let cols = image.cols();
    (0..image.planes().plane_len())
        .map(|i| {
            let rgb = image.channels().map(|p| f64::from(p[i]));
            let reflectance = cube.pixel(i / cols, i % cols).unwrap();
            [repaint.fit.target(&rgb), lab_from_xyz(repaint.fit.xyz_of(reflectance.values()), [1.0; 3])]
        })
        .collect()
}

fn picture(rows: usize, cols: usize, mut rgb: impl FnMut(usize, usize) -> [f64; 3]) -> Image {
    let pixels: Vec<[f64; 3]> = (0..rows * cols).map(|i| rgb(i / cols, i % cols)).collect();
    let data = (0..3).flat_map(|c| pixels.iter().map(move |p| p[c] as f32)).collect();
    Image::new(ColorSpace::LinearSrgb, Planes::new(rows, cols, 3, data).unwrap()).unwrap()
}

/// Patches of many colours with a gradient of light and texture.
fn patches() -> Image {
    picture(70, 130, |row, col| {
        let (i, j) = (row / 14, col / 13);
        let hue = (i * 10 + j) as f64;
        let light = (0.1 + 0.85 * col as f64 / 130.0) * (1.0 - 0.2 * ((row * 7 + col * 3) % 5) as f64 / 5.0);
        [0.0, 2.1, 4.2].map(|phase| light * (0.55 + 0.42 * (hue + phase).sin()))
    })
}

#[test]
fn colours_under_d65_are_those_of_the_picture() {
    let (repaint, image) = (repaint(), patches());
    let cube = repaint.repaint_image(&image).unwrap();
    let values = cube.planes().data();
    assert!(values.iter().all(|r| (0.0..=1.0).contains(r)));
    let mut errors: Vec<f64> =
        colours(&repaint, &image, &cube).iter().map(|[a, b]| delta_e_2000(*a, *b)).collect();
    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors[(share * (errors.len() - 1) as f64) as usize];
    println!("ΔE2000: median {}, 99.9 % {}, largest {}", at(0.5), at(0.999), at(1.0));
    assert!(at(0.5) < 0.02 && at(0.999) < 0.2 && at(1.0) < 0.5);
}

/// Pixels of colours that no reflectance has, such as those of the primaries of sRGB, are counted.
#[test]
fn pixels_of_another_colour_are_counted() {
    let repaint = repaint();
    let primaries = picture(4, 6, |row, _| if row < 2 { [0.0, 0.9, 0.0] } else { [0.5; 3] });
    for image in [patches(), primaries] {
        let Repainted { cube, missed } = repaint.repainted(&image).unwrap();
        let colours = colours(&repaint, &image, &cube);
        let distance =
            |[a, b]: &[[f64; 3]; 2]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        let beyond = |limit: f64| colours.iter().filter(|c| distance(c) > limit).count();
        println!("{missed} of {} pixels missed", colours.len());
        assert!(
            (beyond(0.15)..=beyond(0.1)).contains(&missed),
            "{missed}: {} to {}",
            beyond(0.15),
            beyond(0.1)
        );
    }
}

/// Of the reflectances of natural objects, which are not among the measured ones, the repainted ones are nearer to the
/// truth than smooth ones, and so are their colours under an LED lamp.
#[test]
fn repainted_reflectances_are_nearer_to_real_ones() {
    let grid = WavelengthGrid::VISIBLE;
    let (repaint, smooth) = (repaint(), Uplift::new(grid, Observer::Cie1931).unwrap());
    let inverse = crate::color::matrix::inverse(&repaint.fit.relative_xyz_from_rgb).unwrap();
    let response = |light: Illuminant| -> [Vec<f64>; 3] {
        let light = light.energy(grid).unwrap();
        Observer::Cie1931
            .matching_functions(grid)
            .unwrap()
            .map(|m| m.times(&light).unwrap().values().to_vec())
    };
    let lab = |response: &[Vec<f64>; 3], values: &[f64]| {
        let sum = |m: &Vec<f64>| m.iter().zip(values).map(|(m, v)| m * v).sum::<f64>();
        let (xyz, white) =
            ([0, 1, 2].map(|c| sum(&response[c])), [0, 1, 2].map(|c| response[c].iter().sum()));
        lab_from_xyz(xyz, white)
    };
    let (tungsten, led) = (response(Illuminant::A), response(Illuminant::Led));
    let mut found: [Vec<[f64; 3]>; 2] = [Vec::new(), Vec::new()];
    for (_, truth) in reflectance::natural(grid).unwrap() {
        let rgb = crate::color::matrix::apply(&inverse, repaint.fit.xyz_of(truth.values()));
        if rgb.iter().any(|v| !(0.0..=1.0).contains(v)) {
            continue;
        }
        let painted = repaint.repaint_image(&picture(3, 3, |_, _| rgb)).unwrap().pixel(1, 1).unwrap();
        for (found, guess) in found.iter_mut().zip([painted, smooth.reflectance(rgb).unwrap()]) {
            let square: f64 = truth.values().iter().zip(guess.values()).map(|(a, b)| (a - b) * (a - b)).sum();
            found.push([
                (square / grid.len() as f64).sqrt(),
                delta_e_2000(lab(&tungsten, truth.values()), lab(&tungsten, guess.values())),
                delta_e_2000(lab(&led, truth.values()), lab(&led, guess.values())),
            ]);
        }
    }
    let means = found.map(|f| [0, 1, 2].map(|k| f.iter().map(|v| v[k]).sum::<f64>() / f.len() as f64));
    println!("measured, smooth: rms, ΔE2000 under A and LED-B3: {means:?}");
    let [rms, tungsten, led] = [0, 1, 2].map(|k| means[0][k] / means[1][k]);
    // Tungsten light rises evenly with wavelength, and smooth reflectances suffice for it.
    assert!(rms < 0.5 && tungsten < 1.0 && led < 0.7, "{means:?}");
}

/// Surfaces that cannot be, and none at all, are refused.
#[test]
fn reflectances_that_cannot_be_measured_are_refused() {
    let grid = WavelengthGrid::VISIBLE;
    let with = |all: &[f64]| {
        let all = all.iter().map(|v| Spectrum::constant(grid, *v).unwrap());
        Repaint::with(grid, Observer::Cie1931, all.collect::<Vec<_>>())
    };
    for wrong in [&[0.5, 0.0][..], &[0.5, 1.01], &[-0.1, 0.5], &[]] {
        let found = with(wrong);
        assert!(matches!(found, Err(UpliftError::Spectrum(_))), "{wrong:?}");
    }
    let white = with(&[0.5, 1.0]).unwrap();
    let empty = white.repaint_image(&picture(0, 0, |_, _| [0.5; 3]));
    assert!(matches!(empty, Err(UpliftError::Spectrum(_))), "{empty:?}");
}

/// Of grey surfaces, grey pictures have flat reflectances, and lamps those above 1. Single precision costs far less than the tolerance.
#[test]
fn grey_surfaces_stay_flat() {
    let grid = WavelengthGrid::VISIBLE;
    let all = [0.2, 0.5].map(|v| Spectrum::constant(grid, v).unwrap());
    let repaint = Repaint::with(grid, Observer::Cie1931, all).unwrap();
    let level = |row: usize, col: usize| 0.1 + 0.05 * ((row + col) % 7) as f64;
    let image = picture(20, 40, |row, col| if row == 19 { [3.0; 3] } else { [level(row, col); 3] });
    let Repainted { cube, missed } = repaint.repainted(&image).unwrap();
    assert_eq!(missed, 0);
    for (row, col) in [(0, 0), (3, 17), (10, 22), (18, 39)] {
        for r in cube.pixel(row, col).unwrap().values() {
            assert!((r - level(row, col)).abs() < 1e-4, "{row} {col}: {r}");
        }
    }
    // White has the bound of linear RGB.
    assert!(cube.pixel(19, 5).unwrap().values().iter().all(|r| (r - 3.0).abs() < 0.005));
}
