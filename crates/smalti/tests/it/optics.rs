//! Laws that an optical image obeys, and the essential reference values.
#![allow(missing_docs, clippy::unwrap_used)]

use std::f64::consts::PI;

use smalti::numeric::Planes;
use smalti::optics::{
    BirefringentLowPass, Boundary, ChromaticFocus, Defocus, Falloff, Geometry, OpticalImage, Optics,
    OpticsError, OpticsModel, Padding, PsfStack, Transmittance, Wavefront, WavefrontUnit, ZernikeIndex,
    ZernikeMode, builtin,
};
use smalti::scene::Scene;
use smalti::spectrum::{SpectralCube, Spectrum, WavelengthGrid};

/// Three wavelengths are enough for laws.
fn grid() -> WavelengthGrid {
    WavelengthGrid::new(450.0, 100.0, 3).unwrap()
}

/// A scene with `fov_deg` chosen so that samples are about `spacing_m` apart behind the 4 mm lens of these tests.
fn scene(rows: usize, cols: usize, spacing_m: f64, radiance: impl Fn(usize, usize) -> f32) -> Scene {
    let plane: Vec<f32> = (0..rows * cols).map(|i| radiance(i / cols, i % cols)).collect();
    let data = (0..3).flat_map(|b| plane.iter().map(move |v| v * (b + 1) as f32)).collect();
    let cube = SpectralCube::new(grid(), Planes::new(rows, cols, 3, data).unwrap()).unwrap();
    let fov_deg = 2.0 * (cols as f64 * spacing_m / 2.0 / 4e-3).atan().to_degrees();
    Scene::new("test", cube, Spectrum::constant(grid(), 1.0).unwrap(), 10.0, fov_deg).unwrap()
}

fn perfect() -> Optics {
    Optics { falloff: Falloff::None, ..Optics::new(4e-3, 4.0) }
}

fn wavefront(noll: &[f64]) -> Wavefront {
    let mode = |number| ZernikeMode::from_index(ZernikeIndex::Noll, number).unwrap();
    let terms: Vec<_> = (1..).zip(noll).map(|(number, &c)| (mode(number), c)).collect();
    Wavefront::new(&terms, WavefrontUnit::Waves { at_nm: 550.0 }).unwrap()
}

fn zernike(noll: &[f64]) -> OpticsModel {
    let wavefront = wavefront(noll);
    OpticsModel::Zernike { wavefront, defocus: Defocus::None, chromatic: ChromaticFocus::None }
}

fn defocused(defocus: Defocus) -> OpticsModel {
    OpticsModel::Diffraction { defocus, chromatic: ChromaticFocus::None }
}

/// A lopsided spot.
fn spot() -> OpticsModel {
    let mut values = vec![0.0; 9 * 9];
    (values[4 * 9 + 4], values[4 * 9 + 5], values[3 * 9 + 4]) = (3.0, 1.0, 2.0);
    OpticsModel::Psf(PsfStack::achromatic(9, 9, values, 2e-6).unwrap())
}

fn all_models() -> Vec<(&'static str, Optics)> {
    let with = |model| Optics { model, ..perfect() };
    let olpf = Some(BirefringentLowPass { horizontal_separation_m: 3e-6, vertical_separation_m: 2e-6 });
    vec![
        ("pinhole", with(OpticsModel::Pinhole)),
        ("diffraction", perfect()),
        ("defocus", with(defocused(Defocus::SensorShiftUm(20.0)))),
        ("zernike", with(zernike(&[0.0, 0.0, 0.0, 0.1, 0.05, 0.0, 0.2, 0.1]))),
        ("psf", with(spot())),
        ("low-pass", Optics { olpf, ..perfect() }),
        ("pinhole with low-pass", Optics { olpf, ..with(OpticsModel::Pinhole) }),
    ]
}

fn sum(image: &OpticalImage, band: usize) -> f64 {
    image.irradiance().planes().plane(band).unwrap().iter().map(|&v| f64::from(v)).sum()
}

/// A soft blob in the middle: no ringing, and nothing at the border.
fn blob(r: usize, c: usize) -> f32 {
    let (y, x) = (r as f32 - 31.0, c as f32 - 33.0);
    (-(x * x + y * y) / 40.0).exp()
}

#[test]
fn blur_conserves_energy() {
    let scene = scene(64, 64, 2e-6, blob);
    for (name, optics) in all_models() {
        // Wide enough to hold the whole torus: nothing is cut away.
        let padding = Padding { boundary: Boundary::Dark, margin: 1.0 };
        let optics = Optics { padding, ..optics };
        let image = optics.image(&scene).unwrap();
        let geometry = optics.geometry(scene.distance_m()).unwrap();
        for b in 0..3 {
            let radiance: f64 =
                scene.radiance().planes().plane(b).unwrap().iter().map(|&v| f64::from(v)).sum();
            let expected = radiance * geometry.irradiance_per_radiance_sr();
            // What f32 leaves of zero is clipped on one side: 1e-6 of the peak per sample.
            assert!((sum(&image, b) / expected - 1.0).abs() < 1e-4, "{name}: {}", sum(&image, b) / expected);
        }
    }
}

#[test]
fn a_flat_field_stays_flat() {
    let scene = scene(48, 64, 2e-6, |_, _| 1.0);
    for boundary in [Boundary::Edge, Boundary::Mirror] {
        for (name, optics) in all_models() {
            let optics = Optics { padding: Padding { boundary, margin: 0.125 }, ..optics };
            let image = optics.image(&scene).unwrap();
            assert_eq!((image.irradiance().rows(), image.irradiance().cols()), (48, 64));
            let e = optics.geometry(10.0).unwrap().irradiance_per_radiance_sr();
            for b in 0..3 {
                for &v in image.irradiance().planes().plane(b).unwrap() {
                    assert!((f64::from(v) / (e * (b + 1) as f64) - 1.0).abs() < 1e-5, "{name} {v}");
                }
            }
        }
    }
    // With dark surroundings the middle is flat but for the light that diffraction takes across the border.
    let image = perfect().image(&scene).unwrap();
    let e = perfect().geometry(10.0).unwrap().irradiance_per_radiance_sr();
    let middle = image.irradiance().pixel(30, 40).unwrap();
    assert!((middle.values()[0] / e - 1.0).abs() < 0.02);
}

#[test]
fn images_add_and_scale() {
    let (a, b) = (|r: usize, c: usize| blob(r, c), |r: usize, c: usize| blob(r + 7, c + 3) * 2.0);
    for (name, optics) in all_models() {
        let form = |f: &dyn Fn(usize, usize) -> f32| optics.image(&scene(64, 64, 2e-6, f)).unwrap();
        let (ia, ib, both) = (form(&a), form(&b), form(&|r, c| a(r, c) + 3.0 * b(r, c)));
        let data = |i: &OpticalImage| i.irradiance().planes().data().to_vec();
        let peak = data(&both).iter().copied().fold(0.0, f32::max);
        for ((x, y), z) in data(&ia).iter().zip(data(&ib)).zip(data(&both)) {
            assert!(
                (x + 3.0 * y - z).abs() < 1e-6 * peak,
                "{name} {x} {y} {z} {}",
                (x + 3.0 * y - z).abs() / peak
            );
        }
    }
}

#[test]
fn a_shifted_scene_gives_a_shifted_image() {
    for (name, optics) in all_models() {
        let optics = Optics { padding: Padding { boundary: Boundary::Edge, margin: 0.125 }, ..optics };
        let form = |dr: usize, dc: usize| {
            let image = optics.image(&scene(64, 64, 2e-6, |r, c| blob(r + dr, c + dc))).unwrap();
            image.irradiance().planes().plane(1).unwrap().to_vec()
        };
        let (still, moved) = (form(0, 0), form(4, 6));
        for r in 4..64 {
            for c in 6..64 {
                let (a, b) = (still[r * 64 + c], moved[(r - 4) * 64 + c - 6]);
                assert!((a - b).abs() < 1e-5 * 0.05, "{name} {r} {c} {a} {b}");
            }
        }
    }
}

/// Without its margin an image has the samples that it has in the middle of the margin, whatever surrounds the scene.
#[test]
fn the_image_of_the_scene_is_the_middle_of_the_image() {
    for (name, optics) in all_models() {
        for boundary in [Boundary::Dark, Boundary::Edge, Boundary::Mirror] {
            let optics = Optics { padding: Padding { boundary, ..optics.padding }, ..optics.clone() };
            let scene = scene(40, 56, 1e-6, blob);
            let (whole, part) = (optics.image(&scene).unwrap(), optics.image_of_scene(&scene).unwrap());
            let (whole, part) = (whole.irradiance().planes(), part.irradiance().planes());
            assert_eq!((part.rows(), part.cols()), (40, 56), "{name}");
            let (above, left) = ((whole.rows() - 40) / 2, (whole.cols() - 56) / 2);
            let largest = part.data().iter().fold(0.0f32, |largest, v| largest.max(*v));
            for (whole_plane, part_plane) in whole.planes().zip(part.planes()) {
                for (i, v) in part_plane.iter().enumerate() {
                    let at = (above + i / 56) * whole.cols() + left + i % 56;
                    assert!((v - whole_plane[at]).abs() <= 5e-6 * largest, "{name}, {boundary:?}, {i}");
                }
            }
        }
    }
}

/// An image of half the size has the means of two by two samples of the image of the scene, whatever surrounds it. There is light
/// everywhere, so that no sample is limited at 0.
#[test]
fn the_halved_image_has_the_means_of_the_image_of_the_scene() {
    let mut models = all_models();
    for (name, model) in [("pinhole, cos⁴", OpticsModel::Pinhole), ("diffraction, cos⁴", perfect().model)]
    {
        models.push((name, Optics { falloff: Falloff::Cos4, model, ..perfect() }));
    }
    for (name, optics) in models {
        for boundary in [Boundary::Dark, Boundary::Edge, Boundary::Mirror] {
            let optics = Optics { padding: Padding { boundary, ..optics.padding }, ..optics.clone() };
            let scene = scene(42, 56, 1e-6, |r, c| 0.3 + blob(r, c));
            let fine = optics.image_of_scene(&scene).unwrap();
            let halved = optics.halved_image_of_scene(&scene).unwrap();
            assert_eq!(halved.sample_spacing_m(), 2.0 * fine.sample_spacing_m());
            let (fine, halved) = (fine.irradiance().planes(), halved.irradiance().planes());
            assert_eq!((halved.rows(), halved.cols()), (21, 28), "{name}");
            let largest = fine.data().iter().fold(0.0f32, |largest, v| largest.max(*v));
            for (fine, halved) in fine.planes().zip(halved.planes()) {
                for (i, v) in halved.iter().enumerate() {
                    let first = 2 * (i / 28) * 56 + 2 * (i % 28);
                    let four = [first, first + 1, first + 56, first + 57].map(|at| fine[at]);
                    let difference = v - four.iter().sum::<f32>() / 4.0;
                    assert!(
                        difference.abs() <= 5e-6 * largest && *v > 0.0,
                        "{name}, {boundary:?}, {i}: {v} {four:?}"
                    );
                }
            }
        }
    }
    for (rows, cols) in [(41, 56), (42, 55)] {
        let error = perfect().halved_image_of_scene(&scene(rows, cols, 1e-6, blob)).unwrap_err();
        assert!(error.to_string().contains("expected even numbers of rows and columns"), "{error}");
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let scene = scene(40, 56, 2e-6, |r, c| ((r * 31 + c * 17) % 23) as f32);
    for (name, optics) in all_models() {
        let with = |n| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            pool.install(|| optics.image(&scene).unwrap())
        };
        assert_eq!(with(1), with(3), "{name}");
    }
}

#[test]
fn transfer_is_one_at_zero_and_not_negative_for_a_perfect_lens() {
    for (name, optics) in all_models() {
        let at_zero = optics.otf(550.0, 10.0).unwrap().at(0.0, 0.0);
        assert!((at_zero.re - 1.0).abs() < 1e-6 && at_zero.im.abs() < 1e-6, "{name} {at_zero}");
    }
    let otf = perfect().otf(550.0, 10.0).unwrap();
    assert!((0..2000).all(|i| otf.at(f64::from(i) * 300.0, f64::from(i) * 100.0).re >= 0.0));
    assert_eq!(otf.at(otf.cutoff_cy_per_m(), 0.0).re, 0.0);
}

#[test]
fn without_aberration_zernike_is_the_diffraction_limit() {
    let optics = Optics { model: zernike(&[]), ..perfect() };
    let (a, b) = (optics.otf(550.0, 10.0).unwrap(), perfect().otf(550.0, 10.0).unwrap());
    for i in 0..100 {
        let (fx, fy) = (f64::from(i) * 4e3, f64::from(i % 13) * 2e4);
        assert!((a.at(fx, fy) - b.at(fx, fy)).norm() < 1e-5);
    }
    let scene = scene(64, 64, 2e-6, blob);
    let (a, b) = (optics.image(&scene).unwrap(), perfect().image(&scene).unwrap());
    for (x, y) in a.irradiance().planes().data().iter().zip(b.irradiance().planes().data()) {
        assert!((x - y).abs() < 1e-5 * 0.15);
    }
}

#[test]
fn defocus_is_the_same_by_all_ways() {
    let otf = |model| Optics { model, ..perfect() }.otf(550.0, f64::INFINITY).unwrap();
    // A quarter wave at the rim: c = W₂₀ / 2√3 µm; a = 0.5 mm, so D = 2 W₂₀ / a².
    let w20_um = 0.55 / 4.0;
    let c = w20_um / (2.0 * 3f64.sqrt());
    let ways = [
        otf(defocused(Defocus::ZernikeUm(c))),
        otf(defocused(Defocus::Dioptres(2.0 * w20_um * 1e-6 / 0.25e-6))),
        otf(defocused(Defocus::SensorShiftUm(w20_um * 8.0 * 16.0))),
        otf(zernike(&[0.0, 0.0, 0.0, c / 0.55])),
    ];
    for i in 0..50 {
        let f = f64::from(i) * 9e3;
        let first = ways[0].at(f, 0.0).re;
        // The last is sampled, the others are one integral.
        assert!(ways.iter().all(|w| (w.at(f, 0.0).re - first).abs() < 1e-3), "{f}");
    }
}

#[test]
fn a_spread_function_from_outside_blurs_like_the_lens_it_came_from() {
    let lens = Optics { model: zernike(&[0.0, 0.0, 0.0, 0.1, 0.05, 0.0, 0.1, 0.05]), ..perfect() };
    let wavelengths: Vec<f64> = grid().wavelengths_nm().collect();
    let psf = |nm: &f64| lens.psf(*nm, 10.0, 0.5e-6, 256).unwrap().into_data();
    // Spread functions of a band-limited transfer are not negative but for rounding.
    let data = wavelengths.iter().flat_map(psf).map(|v: f32| v.max(0.0)).collect();
    let stack = PsfStack::new(wavelengths, Planes::new(256, 256, 3, data).unwrap(), 0.5e-6).unwrap();
    let outside = Optics { model: OpticsModel::Psf(stack), ..perfect() };
    let scene = scene(64, 64, 2e-6, |r, c| if (20..40).contains(&r) && c > 30 { 1.0 } else { 0.1 });
    // The same torus for both: all of it is in the image.
    let padding = Padding { boundary: Boundary::Dark, margin: 1.0 };
    let image = |o: Optics| Optics { padding, ..o }.image(&scene).unwrap();
    let (a, b) = (image(lens), image(outside));
    let (a, b) = (a.irradiance().planes(), b.irradiance().planes());
    for band in 0..3 {
        let peak = a.plane(band).unwrap().iter().copied().fold(0.0, f32::max);
        // The tails that a spread function of 128 µm cuts off.
        let worst = a
            .plane(band)
            .unwrap()
            .iter()
            .zip(b.plane(band).unwrap())
            .map(|(x, y)| (x - y).abs() / peak)
            .fold(0.0, f32::max);
        assert!(worst < 2e-3, "{band} {worst}");
    }
}

#[test]
fn the_airy_disc_is_first_dark_at_1_22_lambda_n() {
    let psf = perfect().psf(550.0, f64::INFINITY, 0.02e-6, 1024).unwrap();
    let line = &psf.data()[512 * 1024..513 * 1024];
    let first = (512..1000).find(|&i| line[i] < line[i + 1]).unwrap();
    let radius_m = (first - 512) as f64 * 0.02e-6;
    // Half a sample either way.
    assert!((radius_m - 1.2197 * 550e-9 * 4.0).abs() < 0.02e-6, "{radius_m}");
    let total: f64 = psf.data().iter().map(|&v| f64::from(v)).sum();
    assert!((total - 1.0).abs() < 1e-4);
}

#[test]
fn strehl_ratio_of_small_aberrations() {
    let peak = |model| {
        let psf = Optics { model, ..perfect() }.psf(550.0, f64::INFINITY, 0.5e-6, 128).unwrap();
        f64::from(psf.data()[64 * 128 + 64])
    };
    let perfect_peak = peak(zernike(&[]));
    // Astigmatism, coma (on axis only its tilt-free part counts) and spherical aberration, each and together.
    for sigma in [0.02, 0.05] {
        for noll in [4, 6, 8, 11] {
            let mut list = vec![0.0; noll];
            list[noll - 1] = sigma;
            let strehl = peak(zernike(&list)) / perfect_peak;
            let marechal = (-(2.0 * PI * sigma).powi(2)).exp();
            // Maréchal's approximation is itself good to about σ⁴ terms.
            assert!((strehl - marechal).abs() < 3e-3, "{noll} {sigma} {strehl} {marechal}");
        }
    }
}

#[test]
fn chromatic_focus_blurs_what_is_not_in_focus() {
    let chromatic = ChromaticFocus::Linear { reference_nm: 550.0, dioptres_per_nm: 0.02 };
    let model = OpticsModel::Diffraction { defocus: Defocus::None, chromatic: chromatic.clone() };
    let optics = Optics { model, ..perfect() };
    let share = |nm: f64| {
        let f = 1e5;
        optics.otf(nm, 10.0).unwrap().at(f, 0.0).re / perfect().otf(nm, 10.0).unwrap().at(f, 0.0).re
    };
    assert!((share(550.0) - 1.0).abs() < 1e-4);
    assert!(share(450.0) < 0.95 && share(650.0) < 0.97);
    // The same through the sampled pupil.
    let model = OpticsModel::Zernike { wavefront: Wavefront::default(), defocus: Defocus::None, chromatic };
    let sampled = Optics { model, ..perfect() };
    let scene = scene(64, 64, 2e-6, blob);
    let (a, b) = (optics.image(&scene).unwrap(), sampled.image(&scene).unwrap());
    for (x, y) in a.irradiance().planes().data().iter().zip(b.irradiance().planes().data()) {
        assert!((x - y).abs() < 1e-3 * 0.15);
    }
}

#[test]
fn the_low_pass_filter_removes_what_alternates() {
    let pitch = 4e-6;
    let olpf = Some(BirefringentLowPass { horizontal_separation_m: pitch, vertical_separation_m: pitch });
    let padding = Padding { boundary: Boundary::Mirror, margin: 0.125 };
    // Stripes of one pixel, two samples each; a pinhole, so that nothing else blurs.
    let optics = Optics { model: OpticsModel::Pinhole, olpf, padding, ..perfect() };
    let stripes = scene(32, 64, pitch / 2.0, |_, c| if c / 2 % 2 == 0 { 1.0 } else { 0.0 });
    let image = optics.image(&stripes).unwrap();
    let line: Vec<f64> =
        image.irradiance().planes().plane(0).unwrap()[16 * 64..17 * 64].iter().map(|&v| v.into()).collect();
    let mean = line.iter().sum::<f64>() / 64.0;
    assert!(line[8..56].iter().all(|v| (v / mean - 1.0).abs() < 1e-2), "{:?}", &line[20..28]);
}

#[test]
fn falloff_is_cos4_of_the_field_angle() {
    let flat = scene(50, 80, 50e-6, |_, _| 1.0);
    let pinhole = Optics { model: OpticsModel::Pinhole, ..perfect() };
    let image = Optics { falloff: Falloff::Cos4, ..pinhole.clone() }.image(&flat).unwrap();
    let geometry: Geometry = pinhole.geometry(10.0).unwrap();
    let spacing = image.sample_spacing_m();
    assert!((spacing - 50e-6).abs() < 1e-12);
    for (r, c) in [(0, 0), (25, 40), (49, 10)] {
        let (x, y) = ((c as f64 - 39.5) * spacing, (r as f64 - 24.5) * spacing);
        let angle = (x.hypot(y) / geometry.image_distance_m()).atan();
        let want = PI / 65.0 * angle.cos().powi(4);
        assert!((image.irradiance().pixel(r, c).unwrap().values()[0] / want - 1.0).abs() < 1e-5);
    }
}

#[test]
fn filters_multiply() {
    let flat = scene(8, 8, 2e-6, |_, _| 1.0);
    let half = Optics {
        model: OpticsModel::Pinhole,
        transmittance: Transmittance::Constant(0.5),
        ir_cut: Some(builtin::ir_cut(grid()).unwrap()),
        ..perfect()
    };
    let pixel = half.image(&flat).unwrap().irradiance().pixel(4, 4).unwrap();
    // 450, 550, 650 nm with radiance 1, 2, 3: the filter passes half at 650 nm.
    for (got, want) in pixel.values().iter().zip([0.5, 1.0, 0.75]) {
        assert!((got / (want * PI / 65.0) - 1.0).abs() < 1e-3);
    }
}

/// Figures of ISETCam for the f/4 lens of 3.8628 mm before a scene at 1.2 m (see `isetcam_optics.rs` for all of them).
#[test]
fn figures_of_isetcam() {
    let optics = Optics::new(0.003862755099228297, 4.0);
    let geometry = optics.geometry(1.2).unwrap();
    let close = |got: f64, want: f64, tolerance: f64| {
        assert!((got / want - 1.0).abs() < tolerance, "{got} {want}");
    };
    close(geometry.magnification(), -0.0032293577645002939, 1e-9);
    close(geometry.irradiance_per_radiance_sr(), 0.048026285530568198, 1e-9);
    close(geometry.sample_spacing_m(10.0, 192), 3.531652435789954e-6, 1e-9);
    close(geometry.sample_spacing_m(5.0, 513), 6.596341753778128e-7, 1e-9);
    let otf = |nm| optics.otf(nm, f64::INFINITY).unwrap();
    close(otf(550.0).cutoff_cy_per_m(), 454545.4545454545, 1e-12);
    for (nm, at_10) in [(450.0, 0.9770829258), (550.0, 0.9719909898), (650.0, 0.966899502)] {
        close(f64::from(otf(nm).at(1e4, 0.0).re), at_10, 1e-5);
    }
    for (nm, peak) in [(450.0, 0.015150548941430614), (650.0, 0.007261704038564219)] {
        let psf = optics.psf(nm, f64::INFINITY, 0.25e-6, 256).unwrap();
        close(f64::from(psf.data()[128 * 256 + 128]), peak, 1e-5);
    }
}

#[test]
fn bad_input_is_an_error() {
    let flat = scene(8, 8, 2e-6, |_, _| 1.0);
    let parameter = |optics: Optics| matches!(optics.image(&flat), Err(OpticsError::Parameter { .. }));
    assert!(parameter(Optics { f_number: 0.0, ..perfect() }));
    assert!(parameter(Optics { f_number: f64::NAN, ..perfect() }));
    assert!(parameter(Optics { focal_length_m: -1.0, ..perfect() }));
    assert!(parameter(Optics { transmittance: Transmittance::Constant(1.1), ..perfect() }));
    assert!(parameter(Optics { model: defocused(Defocus::Dioptres(f64::NAN)), ..perfect() }));
    let low_pass = |s| Some(BirefringentLowPass { horizontal_separation_m: s, vertical_separation_m: 0.0 });
    assert!(parameter(Optics { olpf: low_pass(-1e-6), ..perfect() }));
    for margin in [-0.1, 5.0, f64::NAN] {
        assert!(parameter(Optics { padding: Padding { margin, ..Padding::default() }, ..perfect() }));
    }
    let visible_only = Some(Spectrum::constant(WavelengthGrid::new(500.0, 10.0, 5).unwrap(), 1.0).unwrap());
    let short = Optics { ir_cut: visible_only, ..perfect() };
    assert!(matches!(short.image(&flat), Err(OpticsError::Spectrum(_))));
    let near = Optics { focal_length_m: 20.0, ..perfect() };
    assert!(matches!(near.image(&flat), Err(OpticsError::SceneTooNear { .. })));
    assert!(Optics { model: OpticsModel::Pinhole, ..near }.image(&flat).is_ok());
    let one = Planes::new(1, 1, 1, vec![1.0]).unwrap();
    let stack = PsfStack::new(vec![550.0], one, 1e-6).unwrap();
    let narrow = Optics { model: OpticsModel::Psf(stack), ..perfect() };
    assert!(matches!(narrow.image(&flat), Err(OpticsError::PsfCoverage { .. })));
    let wide = Optics { olpf: low_pass(1.0), ..perfect() };
    assert!(matches!(wide.image(&flat), Err(OpticsError::BlurTooWide { .. })));
    let steep = Optics { model: defocused(Defocus::SensorShiftUm(1e6)), ..perfect() };
    assert!(matches!(steep.image(&flat), Err(OpticsError::WavefrontTooSteep { .. })));
    for (spacing, size) in [(0.0, 16), (1e-6, 0), (f64::NAN, 16), (1e-6, usize::MAX)] {
        assert!(perfect().psf(550.0, 1.0, spacing, size).is_err());
    }
    assert!(perfect().otf(0.0, 1.0).is_err() && perfect().otf(f64::NAN, 1.0).is_err());
}
