use std::collections::BTreeSet;

use smalti::design::{ColumnValues, FilterFigures, ResultColumn, StudyResults};
use smalti::experiment::Silent;
use smalti::sensor::NoiseMode;
use smalti::spectrum::WavelengthGrid;
use smalti_io::{TomlSource, studies};

use super::choice::Choice;
use super::filters::filters;
use super::marks::marks;
use super::optical_setups::OpticalSetups;
use super::sources::Sources;
use crate::Rgb;
use crate::page::tests::{unpacked, whole};
use crate::pictures::Pixels;
use crate::study::pictures::{LEAVES, ZONE_PLATE, photographer_of};
use crate::study::results::Results;
use crate::study::sections::Section;

/// Results of all designs of a study, with made-up scores.
fn results(name: &str, filters: &str) -> Results {
    let text = format!(
        "name = \"{name}\"\ncamera = \"table1\"\ncolors = [3]\nmosaics = {{ given = [[\"bc\", \"ab\"]] }}\n{filters}"
    );
    let source = TomlSource { name: name.into(), folder: "".into(), text };
    let (trials, about) = studies::from_source(&source).unwrap();
    let count = trials.len();
    let column = |name: &str, values| ResultColumn {
        name: name.into(),
        unit: String::new(),
        doc: String::new(),
        values,
    };
    let scores =
        |factor: u64| ColumnValues::Numbers((0..count).map(|n| 1.0 + ((n * factor) % 31) as f64).collect());
    let columns = vec![
        column("colors", ColumnValues::Integers(vec![3; count as usize])),
        column("delta_e_76", scores(7)),
        column("mtf50_cy_per_mm", scores(11)),
        column("luminance_noise_percent", scores(13)),
        column("problem", ColumnValues::Texts(vec!["".into(); count as usize])),
    ];
    Results::new(StudyResults {
        study_json: serde_json::to_string(trials.study()).unwrap(),
        trials,
        about,
        is_built_in: false,
        smalti_version: env!("CARGO_PKG_VERSION").into(),
        plan_blake3: String::new(),
        origin: name.into(),
        parts: 1,
        parts_missing: 0,
        numbers: (0..count).collect(),
        columns,
    })
    .unwrap()
}

#[test]
fn of_more_designs_than_a_page_holds_all_marked_ones_are_there() {
    let cloud = results(
        "cloud",
        "[sample]\nfilters = 90\n[filters.gaussian_grid]\ncenters_nm = [430, 10, 660]\nsigmas_nm = [20, 5, 55]\n",
    );
    let few =
        results("few", "[filters.rule]\nrules = [\"uniform\", \"height-scaled\"]\ntargets = [\"cones\"]\n");
    let all = [(&cloud, Section::all(&cloud).unwrap()), (&few, Section::all(&few).unwrap())];
    let sources = Sources { all: &all, pictures: 0, requested: &[], progress: &Silent };
    assert_eq!(Choice::of(&sources).unwrap().of, None);
    let choice = Choice::among(&sources, 20).unwrap();
    let designs = few.data.numbers.len();
    assert_eq!(choice.of, Some(90 + designs));
    let of = |study| choice.rows.iter().filter(|r| r.study == study).count();
    assert!((18..45).contains(&of(0)), "{}", of(0));
    assert_eq!(of(1), designs);
    let marked = marks(&sources, &choice);
    let rows: u64 = marked.iter().filter_map(|m| m.pointer("/rows/n")?.as_u64()).sum();
    assert_eq!((designs > 1, rows), (true, designs as u64));
}

#[test]
fn columns_that_a_sweep_does_not_write_are_refused() {
    let mut data = results("few", "[filters.rule]\nrules = [\"uniform\"]\n").data;
    data.columns.retain(|c| c.name != "problem");
    let refused = Results::new(data.clone()).unwrap_err().to_string();
    assert!(refused.starts_with("few: its column problem"), "{refused}");
    data.columns[0].values = ColumnValues::Integers(vec![27; data.numbers.len()]);
    data.columns.push(ResultColumn { name: "problem".into(), ..data.columns[0].clone() });
    let refused = Results::new(data).unwrap_err().to_string();
    assert!(refused.contains("problem"), "{refused}");
}

/// Every filter of every design has the figures, the colour and the curve that the library computes.
#[test]
fn filters_are_stored_once_as_the_library_computes_them() {
    let gaussians = "[sample]\nfilters = 90\n[filters.gaussian_grid]\ncenters_nm = [430, 10, 660]\nsigmas_nm = [20, 5, 55]\n";
    let cosines = "[sample]\nfilters = 40\n[filters.library]\n[[filters.library.series]]\n\
                   raised_cosine = { centers_nm = [440, 30, 620], fwhms_nm = [60, 40, 140], peak = 0.9 }\n";
    let (first, second) = (results("gaussians", gaussians), results("cosines", cosines));
    let all = [(&first, Section::all(&first).unwrap()), (&second, Section::all(&second).unwrap())];
    let sources = Sources { all: &all, pictures: 0, requested: &[], progress: &Silent };
    let data = filters(&sources, &Choice::of(&sources).unwrap()).unwrap();
    let column = |name: &str| unpacked(&data[name]);
    let [used, center, fwhm, peak, color] = ["used", "center", "fwhm", "peak", "color"].map(column);
    let block = &data["curves"]["blocks"][0];
    let curves = whole(block, block["rows"].as_u64().unwrap() as usize, 171).remove(0);
    let grid = WavelengthGrid::new(380.0, 2.0, 171).unwrap();
    let nm: Vec<f64> = grid.wavelengths_nm().collect();
    let mut places = used.iter();
    let mut different = BTreeSet::new();
    for results in [&first, &second] {
        for row in 0..results.data.numbers.len() {
            for filter in results.trial(row).unwrap().design.filters.filters {
                let place = *places.next().unwrap() as usize;
                let figures = FilterFigures::new(&filter).unwrap();
                let own = [figures.center_nm, figures.fwhm_nm, figures.peak].map(|v| v as f32);
                assert_eq!([center[place], fwhm[place], peak[place]], own);
                let curve = filter.spectrum(grid).unwrap();
                let Rgb(r, g, b) = Rgb::of_transmittance(&nm, curve.values());
                assert_eq!(color[place] as u32, u32::from_be_bytes([0, r, g, b]));
                for (code, t) in curves[place * 171..][..171].iter().zip(curve.values()) {
                    assert!((f64::from(*code) / 2000.0 - t).abs() <= 0.5001 / 2000.0, "{code}, {t}");
                }
                different.insert(serde_json::to_string(&filter).unwrap());
            }
        }
    }
    assert_eq!((places.next(), center.len()), (None, different.len()));
    assert!(different.len() < used.len() / 2 && curves.len() == 171 * different.len());
}

/// The root mean square of the difference of two pictures, of 255.
fn difference(a: &Pixels, b: &Pixels) -> f64 {
    assert_eq!((a.width, a.height, a.rgb.len()), (b.width, b.height, b.rgb.len()));
    let squares: f64 = a.rgb.iter().zip(&b.rgb).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum();
    (squares / a.rgb.len() as f64).sqrt()
}

/// The figures capture the whole spectra of scenes, the page captures a few components of them: 3 of the rings, 8 of the leaves.
#[test]
fn figures_and_the_page_show_the_same_pictures() {
    let designs = "[sample]\nfilters = 4\n[filters.gaussian_grid]\ncenters_nm = [430, 10, 660]\n\
                   sigmas_nm = [20, 5, 55]\nmin_spacing_nm = 20\n";
    let learned = format!("processing = \"l3\"\n[l3]\nside = 5\nlevels = 2\nsize_px = 96\n{designs}");
    for text in [designs, &learned] {
        let study = results("few", text);
        let all = [(&study, Section::all(&study).unwrap())];
        let sources = Sources { all: &all, pictures: 0, requested: &[], progress: &Silent };
        let section = &all[0].1[0];
        let figures = photographer_of(section).unwrap();
        let page = OpticalSetups::new(&sources).unwrap().preview(0, section, &Silent).unwrap();
        for (scene, (spec, limit)) in [(ZONE_PLATE, 1.0), (LEAVES, 1.5)].into_iter().enumerate() {
            for noise in [NoiseMode::None, NoiseMode::All] {
                let figure = figures.scene(spec, noise).unwrap();
                let on_page = |row| {
                    let design = page.design(&study.trial(row).unwrap().design).unwrap();
                    Pixels::of(&page.picture(&design, scene, noise).unwrap())
                };
                for row in 0..4 {
                    let in_figure = Pixels::of(&figure.picture(&study.trial(row).unwrap().design).unwrap());
                    let found = difference(&in_figure, &on_page(row));
                    assert!(found < limit, "{spec}, {noise:?}, trial {row}: {found}");
                    // Pictures of different trials differ far more.
                    let other = difference(&in_figure, &on_page((row + 1) % 4));
                    assert!(other > 8.0, "{spec}, {noise:?}, trial {row}: {other}");
                }
            }
        }
    }
}
