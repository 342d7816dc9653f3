//! Scenes against ISETCam. Its Planck constant is 1.6e-5 from the exact one, which shifts all photon counts; its D65
//! differs by up to 6e-4 from the CIE formula, so its own light is fed where the light is not what is tested.
#![allow(clippy::unwrap_used)]

use crate::common;

use common::{assert_close, numbers, reference_csv, reference_json};
use smalti::scene::{
    FrequencyOrientation, PatternSampling, Setting, SlantedBar, frequency_orientation, macbeth, slanted_bar,
    zone_plate_isetcam,
};
use smalti::spectrum::{Illuminant, Observer, Spectrum, WavelengthGrid};

const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;
/// ISETCam's Planck constant (1.6e-5) and single precision.
const TOLERANCE: f64 = 3e-5;

fn measured(values: Vec<f64>) -> Illuminant {
    Illuminant::Measured { name: "reference".into(), power: Spectrum::new(GRID, values).unwrap() }
}

/// Equal photons at every wavelength.
fn equal_photons() -> Illuminant {
    measured(GRID.wavelengths_nm().map(|nm| 560.0 / nm).collect())
}

/// Row-by-row index of a patch that ISETCam counts column by column.
fn by_row(column_major: usize) -> usize {
    column_major % macbeth::ROWS * macbeth::COLS + column_major / macbeth::ROWS
}

#[test]
fn macbeth_under_d65() {
    let json = reference_json("scene_macbeth_d65.json");
    let reflectance = reference_csv("macbeth_reflectance_400_10_700.csv");
    let photons = reference_csv("scene_macbeth_d65_photons.csv");
    let mut list = vec![Spectrum::constant(GRID, 0.0).unwrap(); 24];
    for (i, r) in reflectance.into_iter().enumerate() {
        list[by_row(i)] = Spectrum::new(GRID, r).unwrap();
    }
    // (light, tolerance): with its own light, and with ours, where 6e-4 of the light comes on top.
    let own = measured(numbers(&json["illuminant_energy_W_sr_m2_nm"]));
    for (illuminant, tolerance) in [(own, TOLERANCE), (Illuminant::D65, 7e-4)] {
        let setting = Setting { luminance_cd_m2: 75.0, illuminant, ..Setting::default() };
        let scene = macbeth::chart_of(&list, 32, &setting).unwrap();
        assert_eq!(
            [scene.radiance().rows() as f64, scene.radiance().cols() as f64].to_vec(),
            numbers(&json["size_rc"])
        );
        let white = numbers(&json["illuminant_photons_s_sr_m2_nm"]);
        assert_close("light", scene.illuminant().values(), &white, tolerance);
        let luminance = scene.luminance_cd_m2().unwrap();
        for i in 0..24 {
            let (row, col) = (by_row(i) / macbeth::COLS * 32 + 16, by_row(i) % macbeth::COLS * 32 + 16);
            let pixel = scene.radiance().pixel(row, col).unwrap();
            assert_close(&format!("photons of patch {i}"), pixel.values(), &photons[i], tolerance);
            let xyz = Observer::Cie1931.xyz_from_photons(&pixel).unwrap();
            assert_close(&format!("XYZ of patch {i}"), &xyz, &numbers(&json["patch_XYZ"][i]), tolerance);
            let y = json["patch_luminance"][i].as_f64().unwrap();
            assert_close("luminance", &[f64::from(luminance[row * 192 + col])], &[y], tolerance);
        }
    }
}

#[test]
fn slanted_bar_of_512() {
    let json = reference_json("scene_slantedbar.json");
    let setting = Setting {
        luminance_cd_m2: json["mean_luminance"].as_f64().unwrap(),
        horizontal_fov_deg: 5.0,
        illuminant: Illuminant::E,
        ..Setting::default()
    };
    let scene = slanted_bar(&SlantedBar::default(), &setting).unwrap();
    assert_eq!((scene.radiance().rows(), scene.radiance().cols()), (513, 513));
    let (left, right) = (scene.radiance().pixel(256, 0).unwrap(), scene.radiance().pixel(256, 512).unwrap());
    assert_close("bright", left.values(), &numbers(&json["bright_photons"]), TOLERANCE);
    assert_close("dark", right.values(), &numbers(&json["dark_photons"]), TOLERANCE);
    let luminance = scene.luminance_cd_m2().unwrap();
    let bright = json["bright_lum"].as_f64().unwrap();
    assert_close("luminance", &[f64::from(luminance[256 * 513])], &[bright], TOLERANCE);
    let row = luminance[256 * 513..257 * 513].iter().map(|&y| f64::from(u8::from(y > 75.0)));
    assert_eq!(row.collect::<Vec<_>>(), numbers(&json["row_257_is_bright"]));
}

#[test]
fn zone_plate_and_frequency_orientation() {
    let json = reference_json("scene_targets_misc.json");
    let setting = Setting { illuminant: equal_photons(), ..Setting::default() };
    let band = 15; // 550 nm
    let scene = zone_plate_isetcam(&setting).unwrap();
    let row = |scene: &smalti::scene::Scene, r: usize| -> Vec<f64> {
        let cols = scene.radiance().cols();
        let plane = scene.radiance().planes().plane(band).unwrap();
        plane[r * cols..(r + 1) * cols].iter().map(|&v| f64::from(v)).collect()
    };
    let plate = &json["zone_plate"];
    assert_close("row 1", &row(&scene, 0), &numbers(&plate["row_1_550"]), TOLERANCE);
    // What the file calls the centre is row 128, counted from 1: a third of the height.
    assert_close("row 128", &row(&scene, 127), &numbers(&plate["row_center_550"]), TOLERANCE);
    let target = FrequencyOrientation {
        sampling: PatternSampling::Isetcam,
        block_px: 32,
        frequencies: 8,
        angles: 8,
        contrast: 1.0,
    };
    let scene = frequency_orientation(&target, &setting).unwrap();
    let gratings = &json["freq_orient"];
    assert_close("row 16", &row(&scene, 15), &numbers(&gratings["row_16_550"]), TOLERANCE);
    assert_close("row 100", &row(&scene, 99), &numbers(&gratings["row_100_550"]), TOLERANCE);
}
