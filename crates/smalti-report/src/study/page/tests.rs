use smalti::design::{ColumnValues, ResultColumn, StudyResults};
use smalti::experiment::Silent;
use smalti_io::{TomlSource, studies};

use super::choice::Choice;
use super::marks::marks;
use super::sources::Sources;
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
