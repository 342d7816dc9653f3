//! The built-in scenes by name.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use smalti::scene::catalog::{build, common_parameters, names};
use smalti::scene::{
    Checkerboard, ColorPatches, DeadLeaves, FrequencyOrientation, FrequencySweep, GlossyBalls, Gradients,
    GreySteps, MAX_VALUES, PatternSampling, PointGrid, ResolutionChart, SceneError, Setting, SiemensStar,
    SlantedBar, ZonePlate, checkerboard, color_patches, dead_leaves, frequency_orientation, frequency_sweep,
    glossy_balls, gradients, grey_steps, hdr, macbeth, point_grid, resolution_chart, siemens_star,
    slanted_bar, uniform, zone_plate, zone_plate_isetcam,
};
use smalti::spectrum::{Illuminant, Spectrum, WavelengthGrid};

/// Two wavelengths, so that full sizes stay cheap.
fn setting() -> Setting {
    Setting { grid: WavelengthGrid::new(500.0, 100.0, 2).unwrap(), ..Setting::default() }
}

#[test]
fn defaults_are_those_of_the_functions() {
    let s = &setting();
    let list = macbeth::reflectances(s.grid).unwrap();
    let scenes = [
        ("macbeth", macbeth::chart(32, s)),
        ("slanted-bar", slanted_bar(&SlantedBar::default(), s)),
        ("zone-plate", zone_plate(&ZonePlate::default(), s)),
        ("zone-plate?sampling=isetcam", zone_plate_isetcam(s)),
        ("uniform", uniform(64, 64, s)),
        ("grey-steps", grey_steps(&GreySteps { steps: 20, step_px: 32, rows: 160, density: 3.0 }, s)),
        (
            "frequency-sweep",
            frequency_sweep(
                &FrequencySweep {
                    rows: 384,
                    cols: 768,
                    lowest: 1.0 / 256.0,
                    highest: 0.5,
                    least_contrast: 0.01,
                },
                s,
            ),
        ),
        (
            "frequency-orientation",
            frequency_orientation(
                &FrequencyOrientation {
                    block_px: 32,
                    frequencies: 8,
                    angles: 8,
                    contrast: 1.0,
                    sampling: PatternSampling::Area,
                },
                s,
            ),
        ),
        ("siemens-star", siemens_star(&SiemensStar { size: 512, cycles: 72, contrast_ratio: 1e3 }, s)),
        ("point-grid", point_grid(&PointGrid { points: 15, spacing_px: 32, diameter_px: 2.0 }, s)),
        ("checkerboard", checkerboard(&Checkerboard { squares: 16, square_px: 32, contrast_ratio: 1e3 }, s)),
        ("resolution-chart", resolution_chart(&ResolutionChart { rows: 1080, contrast_ratio: 40.0 }, s)),
        ("hdr?rows=40", hdr(40, s)),
        (
            "dead-leaves",
            dead_leaves(
                &DeadLeaves { rows: 512, cols: 512, least_radius_px: 1.5, largest_radius_px: 200.0, seed: 1 },
                &list,
                s,
            ),
        ),
        (
            "color-patches",
            color_patches(
                &ColorPatches { rows: 512, cols: 512, least_px: 8, doublings: 4, seed: 1 },
                &list,
                s,
            ),
        ),
        (
            "gradients",
            gradients(
                &Gradients {
                    rows: 512,
                    cols: 512,
                    cell_px: 64,
                    contrast_ratio: 100.0,
                    neutral: false,
                    seed: 1,
                },
                &list,
                s,
            ),
        ),
        (
            "glossy-balls",
            glossy_balls(&GlossyBalls { rows: 512, cols: 512, shade: 1000.0, seed: 1 }, &list, s),
        ),
    ];
    for (spec, expected) in scenes {
        assert_eq!(build(spec, s, &[]).unwrap(), expected.unwrap(), "{spec}");
    }
}

#[test]
fn every_scene_builds_and_says_what_it_is() {
    let s = setting();
    let mut seen = std::collections::BTreeSet::new();
    for info in names() {
        assert!(seen.insert(info.name) && !info.summary.is_empty());
        // Defaults may be written out.
        let own = info.parameters.iter().filter(|p| !p.default.is_empty());
        let written: Vec<String> = own.map(|p| format!("{}={}", p.name, p.default)).collect();
        let scene = build(&format!("{}?{}", info.name, written.join("&")), &s, &[]).unwrap();
        assert_eq!(scene.name(), info.name);
        assert!((scene.mean_luminance_cd_m2().unwrap() - 100.0).abs() < 1e-3, "{}", info.name);
        for p in info.parameters.iter().chain(common_parameters()) {
            assert!(!p.doc.is_empty() && !p.expected.is_empty());
            let error = build(&format!("{}?{}=~", info.name, p.name), &s, &[]).unwrap_err();
            assert!(matches!(error, SceneError::BadValue { .. }), "{error}");
            assert!(error.to_string().contains(p.expected));
        }
    }
}

#[test]
fn parameters_reach_the_scene() {
    let s = setting();
    let scene = build("uniform?size=8&luminance=3.5,distance=2&fov=30&illuminant=A", &s, &[]).unwrap();
    assert_eq!((scene.radiance().rows(), scene.distance_m(), scene.horizontal_fov_deg()), (8, 2.0, 30.0));
    assert!((scene.mean_luminance_cd_m2().unwrap() - 3.5).abs() < 1e-5);
    let a = uniform(8, 8, &Setting { illuminant: Illuminant::A, luminance_cd_m2: 3.5, ..setting() }).unwrap();
    assert_eq!(scene.illuminant(), a.illuminant());
    let bar = build("slanted-bar?size=64&angle=5&contrast=4&sampling=area", &s, &[]).unwrap();
    assert_eq!(bar.radiance().cols(), 65);
    let black_and_white =
        [Spectrum::constant(s.grid, 0.0).unwrap(), Spectrum::constant(s.grid, 1.0).unwrap()];
    let leaves = build("dead-leaves?rows=32&cols=48&largest=20", &s, &black_and_white).unwrap();
    assert_eq!((leaves.radiance().rows(), leaves.radiance().cols()), (32, 48));
    assert!(leaves.radiance().planes().data().contains(&0.0));
}

#[test]
fn errors_say_what_was_expected() {
    let s = setting();
    let message = |spec: &str| build(spec, &s, &[]).unwrap_err().to_string();
    assert!(message("zoneplate").contains("did you mean 'zone-plate'?"));
    assert!(message("zone-plate?frequncy=1").contains("did you mean 'frequency'?"));
    assert!(message("zone-plate?size=1e9").contains("size=1e9"));
    assert!(message("zone-plate?size=1e9").contains("a whole number from 2 to 16384"));
    assert!(message("uniform?size").contains("expected name=value"));
    assert!(message("uniform?size=4&size=4").contains("each parameter once"));
    assert!(message("uniform?luminance=-1").contains("a number from"));
    assert!(message("uniform?illuminant=D66").contains("D65"));
    assert!(message("point-grid?spacing=4&diameter=5").contains("less than the spacing"));
    // Each number is allowed, their product is not.
    let full = Setting::default();
    let error = build("checkerboard?squares=4096&square=4096", &full, &[]).unwrap_err();
    assert!(matches!(error, SceneError::TooLarge { .. }), "{error}");
    let error = build("uniform?size=16384", &full, &[]).unwrap_err();
    assert!(matches!(error, SceneError::TooLarge { .. }), "{error}");
    // A pixel has too many wavelengths for memory; its reflectances would have as well.
    let grid = WavelengthGrid::new(400.0, 1e-9, MAX_VALUES + 1).unwrap();
    let (many, natural) =
        (Setting { grid, ..Setting::default() }, [Spectrum::constant(full.grid, 0.5).unwrap()]);
    for spec in ["macbeth", "gradients?paint=white", "uniform"] {
        let error = build(spec, &many, &natural).unwrap_err();
        assert!(matches!(error, SceneError::TooLarge { .. }), "{spec}: {error}");
    }
}

/// A value that may be anything, but asks for few pixels or for far too many.
fn value() -> impl Strategy<Value = String> {
    prop_oneof![
        (0u32..40).prop_map(|v| v.to_string()),
        (0.0f64..4.0).prop_map(|v| v.to_string()),
        (1e7f64..1e300).prop_map(|v| v.to_string()),
        (-1e9f64..0.0).prop_map(|v| v.to_string()),
        proptest::sample::select(vec![
            "isetcam",
            "area",
            "nan",
            "inf",
            "1/0",
            "7/3",
            "",
            "D65",
            "A",
            "0K",
            "18446744073709551615",
            "1e-300",
        ])
        .prop_map(str::to_owned),
        "\\PC{0,6}",
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn no_text_panics(spec in "\\PC{0,40}") {
        let _ = build(&spec, &setting(), &[]);
    }

    #[test]
    fn no_value_panics(
        scene in 0..names().len(),
        values in proptest::collection::vec((0usize..16, value()), 0..4),
    ) {
        let info = &names()[scene];
        let all: Vec<&str> = info.parameters.iter().chain(common_parameters()).map(|p| p.name).collect();
        let mut parameters: Vec<String> = values
            .into_iter()
            .filter_map(|(i, v)| all.get(i).map(|name| format!("{name}={v}")))
            .collect();
        // Where no size is given, a small one, so that the test stays fast.
        for (name, small) in [("size", "24"), ("patch", "3"), ("rows", "20"), ("cols", "20"), ("points", "2"), ("squares", "2"), ("block", "4")] {
            if all.contains(&name) && !parameters.iter().any(|p| p.starts_with(name)) {
                parameters.push(format!("{name}={small}"));
            }
        }
        if let Ok(scene) = build(&format!("{}?{}", info.name, parameters.join("&")), &setting(), &[]) {
            prop_assert!(scene.mean_luminance_cd_m2().unwrap() > 0.0);
        }
    }
}
