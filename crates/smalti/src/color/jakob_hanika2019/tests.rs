use super::*;
use crate::color::cie1976::lab_from_xyz;
use crate::color::difference::delta_e_2000;

fn lab_of(uplift: &Uplift, reflectance: &[f64]) -> [f64; 3] {
    lab_from_xyz(uplift.fit.xyz_of(reflectance), [1.0; 3])
}

/// All combinations of encoded values 0 to 255 in even steps, as linear light, plus very dark colours.
fn colours(step: usize) -> Vec<[f64; 3]> {
    let levels: Vec<f64> = (0..=255)
        .step_by(step)
        .map(|v| crate::color::display::decode_srgb(v as f64 / 255.0))
        .chain([crate::color::display::decode_srgb(1.0 / 255.0), 0.999, 0.9999])
        .collect();
    let n = levels.len();
    (0..n * n * n).map(|i| [levels[i / n / n], levels[i / n % n], levels[i % n]]).collect()
}

#[test]
fn every_colour_of_srgb_comes_back() {
    let uplift = Uplift::new(WavelengthGrid::VISIBLE, Observer::Cie1931).unwrap();
    // With steps of 3 (704 969 colours), the largest ΔE2000 was 0.235 for images and 0.052 for single
    // colours.
    let rgb = colours(17);
    let n = rgb.len();
    let data = [0, 1, 2].iter().flat_map(|&c| rgb.iter().map(move |v| v[c] as f32)).collect();
    let image = Image::new(ColorSpace::LinearSrgb, Planes::new(1, n, 3, data).unwrap()).unwrap();
    let cube = uplift.uplift_image(&image).unwrap();
    let (mut worst_image, mut worst) = ((0.0, [0.0; 3]), (0.0, [0.0; 3]));
    for (i, &v) in rgb.iter().enumerate() {
        let target = uplift.fit.target(&v);
        let from_image = delta_e_2000(target, lab_of(&uplift, cube.pixel(0, i).unwrap().values()));
        let exact = uplift.reflectance(v).unwrap();
        let single = delta_e_2000(target, lab_of(&uplift, exact.values()));
        if from_image > worst_image.0 {
            worst_image = (from_image, v);
        }
        if single > worst.0 {
            worst = (single, v);
        }
    }
    // The limits of the sigmoid at black and white cost 0.05; the tolerance for images adds to that.
    assert!(worst.0 < 0.06, "single {worst:?}");
    assert!(worst_image.0 < 0.4, "picture {worst_image:?}");
}

#[test]
fn other_grids_and_observers_come_back_too() {
    for (start, step, count, observer) in [
        (380.0, 5.0, 81, Observer::Cie1964),
        (360.0, 10.0, 65, Observer::Cie2015),
        (400.0, 20.0, 16, Observer::Cie1931),
    ] {
        let uplift = Uplift::new(WavelengthGrid::new(start, step, count).unwrap(), observer).unwrap();
        for rgb in colours(85) {
            let spectrum = uplift.reflectance(rgb).unwrap();
            assert!(spectrum.values().iter().all(|r| (0.0..=1.0).contains(r)));
            let de = delta_e_2000(uplift.fit.target(&rgb), lab_of(&uplift, spectrum.values()));
            assert!(de < 0.06, "{observer:?} {start}:{step}: {rgb:?} gives {de}");
        }
    }
}

#[test]
fn spectra_are_smooth_and_grey_is_flat() {
    let uplift = Uplift::new(WavelengthGrid::VISIBLE, Observer::Cie1931).unwrap();
    let grey = uplift.reflectance([0.2; 3]).unwrap();
    assert!(grey.values().iter().all(|r| (r - 0.2).abs() < 1e-4));
    for rgb in colours(51) {
        // A sigmoid of a parabola has at most one extremum.
        let spectrum = uplift.reflectance(rgb).unwrap();
        let rises: Vec<bool> = spectrum
            .values()
            .windows(2)
            .filter(|w| (w[1] - w[0]).abs() > 1e-12)
            .map(|w| w[1] > w[0])
            .collect();
        assert!(rises.windows(2).filter(|w| w[0] != w[1]).count() <= 1, "{rgb:?}");
    }
}

#[test]
fn pictures_keep_highlights_and_bad_ones_are_refused() {
    let uplift = Uplift::new(WavelengthGrid::VISIBLE, Observer::Cie1931).unwrap();
    let picture =
        |space, data: Vec<f32>| Image::new(space, Planes::new(1, data.len() / 3, 3, data).unwrap()).unwrap();
    let cube =
        uplift.uplift_image(&picture(ColorSpace::LinearSrgb, vec![4.0, -1.0, 2.0, 0.5, 1.0, 0.5])).unwrap();
    let unit = uplift.reflectance([1.0, 0.5, 0.25]).unwrap();
    for (got, want) in cube.pixel(0, 0).unwrap().values().iter().zip(unit.values()) {
        assert!((got - 4.0 * want).abs() < 0.02, "{got} is not four times {want}");
    }
    assert!(uplift.uplift_image(&picture(ColorSpace::Srgb, vec![0.0; 3])).is_err());
    let e = uplift.uplift_image(&picture(ColorSpace::LinearSrgb, vec![0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0]));
    assert!(matches!(e, Err(UpliftError::Image(ImageError::Value { plane: 1, row: 0, col: 1, .. }))));
    let color = uplift.reflectance([0.5, f64::NAN, 0.5]);
    assert!(matches!(color, Err(UpliftError::Color(_))), "{color:?}");
    let infrared = WavelengthGrid::new(900.0, 10.0, 11).unwrap();
    assert!(matches!(Uplift::new(infrared, Observer::Cie1931), Err(UpliftError::Spectrum(_))));
    // A picture without pixels has no spectra.
    let empty = uplift.uplift_image(&picture(ColorSpace::LinearSrgb, Vec::new()));
    assert!(matches!(empty, Err(UpliftError::Spectrum(_))), "{empty:?}");
}

/// The nodes ascend from the darkest to the lightest value, and are as dense near white as near black.
#[test]
fn nodes_are_symmetric_between_the_limits() {
    let nodes: Vec<f64> = (0..VALUES).map(value_of_node).collect();
    assert!(nodes.windows(2).all(|w| w[0] < w[1]), "{nodes:?}");
    for (dark, light) in nodes.iter().zip(nodes.iter().rev()) {
        assert!((dark + light - DARKEST - LIGHTEST).abs() < 1e-14, "{dark} {light}");
    }
    assert!((nodes[0] - DARKEST).abs() < 1e-14, "{}", nodes[0]);
}
