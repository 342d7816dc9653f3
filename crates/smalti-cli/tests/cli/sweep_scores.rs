//! What a study scores: its metrics and scenes, and that they are the scores of `evaluate`.

use smalti_io::dataset::{Column, Dataset};

use super::Place;
use super::gaussian_sets::{SETS, Set};

/// Columns of numbers, designs in their order.
fn columns(place: &Place, out: &str, names: &[&str]) -> Vec<Vec<f64>> {
    let dataset = Dataset::open(&place.path(out)).unwrap();
    let mut all = vec![Vec::new(); names.len()];
    for part in dataset.columns(names).unwrap() {
        for (all, column) in all.iter_mut().zip(part.unwrap().columns) {
            let Column::Float(values) = column else { panic!("not a column of numbers") };
            all.extend(values);
        }
    }
    all
}

fn names(place: &Place, out: &str) -> Vec<String> {
    let dataset = Dataset::open(&place.path(out)).unwrap();
    dataset.manifest().plan.schema.iter().map(|c| c.name.clone()).collect()
}

/// A set with its filters ascending, as studies have them, and the letters of its tile accordingly.
fn ascending((filters, tile): Set) -> (Vec<(f64, f64)>, Vec<String>) {
    let mut order: Vec<usize> = (0..filters.len()).collect();
    order.sort_by(|&a, &b| filters[a].0.total_cmp(&filters[b].0));
    let place = |letter: u8| order.iter().position(|&i| i == usize::from(letter - b'A')).unwrap();
    let row = |row: &&str| row.bytes().map(|c| char::from(b'a' + place(c) as u8)).collect();
    (order.iter().map(|&i| filters[i]).collect(), tile.iter().map(row).collect())
}

/// The same sets as a list in a study and each as a camera of its own.
#[test]
fn a_sweep_gives_the_figures_of_evaluate() {
    let place = Place::new();
    let gaussian = |&(center, sigma): &(f64, f64)| {
        format!("{{ gaussian = {{ center_nm = {center:?}, sigma_nm = {sigma:?}, peak = 1.0 }} }}")
    };
    let mut study = String::from(
        "camera = \"table1\"\ncolors = [3, 4, 5, 6, 7]\nprocessing = \"classic\"\n[mosaics]\ngiven = [",
    );
    for (_, tile) in SETS.map(ascending) {
        study += &format!("{tile:?}, ");
    }
    study += "]\n";
    for (filters, _) in SETS.map(ascending) {
        let filters: Vec<String> = filters.iter().map(gaussian).collect();
        study += &format!("[[filters.list]]\nfilters = [{}]\n", filters.join(", "));
    }
    place.write("sets.toml", study);
    place.ok("sweep sets.toml -o out");
    let metrics =
        ["delta_e_76", "delta_e_2000", "mtf50_cy_per_mm", "mtf50_cy_per_px", "luminance_noise_percent"];
    let swept = columns(&place, "out", &metrics);
    assert!(swept.iter().all(|c| c.len() == SETS.len()));

    for (i, (filters, tile)) in SETS.map(ascending).into_iter().enumerate() {
        let pattern: Vec<String> = tile.iter().map(|row| row.to_uppercase()).collect();
        let mut camera = place.ok("list cameras --json");
        let list: serde_json::Value = serde_json::from_str(&camera).unwrap();
        let table1 = list.as_array().unwrap().iter().find(|c| c["name"] == "table1").unwrap();
        camera = table1["toml"].as_str().unwrap().to_owned();
        let (before, after) = camera.split_once("[sensor.cfa]").unwrap();
        let after = after.split_once("\n[exposure]").map_or("", |(_, rest)| rest);
        let letters = ('A'..='G').zip(&filters).map(|(c, f)| format!("{c} = {}\n", gaussian(f)));
        let filters: String = letters.collect();
        let cfa = format!("[sensor.cfa]\npattern = {pattern:?}\n[sensor.cfa.filters]\n{filters}");
        place.write("camera.toml", format!("{before}{cfa}\n[exposure]{after}"));
        // The design as a camera is the same, found by the command that stands above it.
        let design = place.ok(&format!("report out --camera {i}"));
        let command = design.lines().nth(1).and_then(|line| line.strip_prefix("# smalti ")).unwrap();
        place.write(command.split(' ').nth(1).unwrap(), &design);
        for command in ["evaluate camera.toml --luminance 75", command] {
            let found = place.document(&format!("{command} --json"));
            for (metric, swept) in metrics.iter().zip(&swept) {
                let value = &found["cameras"][0][*metric];
                let expected = value["mean"].as_f64().or(value.as_f64()).unwrap();
                let tolerance = if *metric == "luminance_noise_percent" { 1e-3 } else { 1e-4 };
                assert!(
                    (swept[i] / expected - 1.0).abs() < tolerance,
                    "{metric} of set {i}: {}, {command} {expected}",
                    swept[i]
                );
            }
        }
    }
    let refused = place.run(&["report", "out", "--camera", "99"]);
    assert!(refused.code == 1 && refused.err.contains("trials 0 to"), "{}", refused.err);
}

const STUDY: &str = r#"
camera = "table1"
colors = [3]
metrics = ["mtf50_cy_per_mm", "cpsnr_db", "aliasing_percent"]
scenes = ["dead-leaves?rows=64&cols=64", "leaves.exr", "dead-leaves?rows=64&cols=64&seed=2"]
[sample]
filters = 3
[filters.gaussian_grid]
[mosaics]
given = [["bc", "ab"]]
"#;

#[test]
fn a_study_scores_what_it_names() {
    let place = Place::new();
    place.ok("convert dead-leaves?rows=48&cols=40 -o leaves.exr");
    place.write("study.toml", STUDY);
    place.ok("sweep study.toml -o out");
    let metrics = [
        "mtf50_cy_per_mm",
        "cpsnr_db_dead_leaves_1",
        "cpsnr_db_leaves",
        "cpsnr_db_dead_leaves_3",
        "aliasing_percent",
    ];
    let all = names(&place, "out");
    let from = all.iter().position(|n| n == metrics[0]).unwrap();
    let saturated =
        ["dead_leaves_1", "leaves", "dead_leaves_3"].map(|scene| format!("saturated_percent_{scene}"));
    let saturated = saturated.each_ref().map(String::as_str);
    let others = [
        "macbeth_time_s",
        "macbeth_saturated_percent",
        "edge_time_s",
        "edge_saturated_percent",
        "mtf50_reliability",
        "problem",
    ];
    assert_eq!(all[from..], [&metrics[..], &saturated, &others].concat());
    let found = columns(&place, "out", &metrics);
    assert!(found.iter().flatten().all(|v| v.is_finite()), "{found:?}");
    // Automatic exposure leaves few samples at the white level.
    let shares = columns(&place, "out", &saturated);
    assert!(shares.iter().flatten().all(|v| (0.0..5.0).contains(v)), "{shares:?}");
    // Other leaves, other pictures.
    assert_ne!(found[1], found[3]);

    // The report shows what there is, and draws no plane of colour and resolution.
    let text = place.ok("report out");
    for words in [
        "MTF50 cy/mm",
        "CPSNR dB leaves",
        "CPSNR dB dead leaves 1",
        "aliasing %",
        "saturated % leaves",
        "exposure ms",
        "larger share of their raw samples that saturate",
        "no other design beats in MTF50, CPSNR dead leaves 1, CPSNR leaves, CPSNR dead leaves 3 and aliasing at once",
    ] {
        assert!(text.contains(words), "{words} is missing in\n{text}");
    }
    assert!(!text.contains("ΔE") && !text.contains("NaN"), "{text}");
    let files = place.names("out/report");
    assert!(files.contains(&"report.html".into()) && files.contains(&"mosaics.svg".into()), "{files:?}");
    assert!(!files.iter().any(|f| f.starts_with("cloud")), "{files:?}");
    let document = place.json("out/report/report.json");
    let best = &document["studies"][0]["sections"][0]["colors"][0]["best"];
    let first = |i: usize| best[i]["mtf50_cy_per_mm"].as_f64().unwrap();
    assert!(
        first(0) >= first(1) && best[0]["cpsnr_db_leaves"].is_number() && best[0]["delta_e_76"].is_null()
    );

    // A scene that changed is another study, whatever its file is called.
    place.ok("convert dead-leaves?rows=48&cols=40&seed=5 -o leaves.exr");
    let run = place.run(&["sweep", "study.toml", "-o", "out"]);
    assert!(run.code == 1 && run.err.contains("hash"), "{}", run.err);
}

#[test]
fn metrics_and_scenes_that_cannot_be_are_refused_where_they_say_so() {
    let place = Place::new();
    let fails = |what: &str, by: &str, expected: &[&str]| {
        assert!(STUDY.contains(what), "{what}");
        place.write("study.toml", STUDY.replace("\"leaves.exr\", ", "").replace(what, by));
        let run = place.run(&["sweep", "study.toml", "-o", "none"]);
        assert_eq!(run.code, 1, "{by}: {}", run.err);
        assert!(expected.iter().all(|word| run.err.contains(word)), "{}\nexpected {expected:?}", run.err);
        assert!(!place.path("none").exists());
    };
    let metrics = "\"mtf50_cy_per_mm\", \"cpsnr_db\", \"aliasing_percent\"";
    fails("aliasing_percent", "aliasing_procent", &["study.toml:4", "did you mean `aliasing_percent`?"]);
    fails(metrics, "", &["study.toml:4", "at least one metric"]);
    fails(metrics, "\"cpsnr_db\", \"cpsnr_db\"", &["study.toml:4", "cpsnr_db is listed twice"]);
    fails(metrics, "\"delta_e_76\"", &["study.toml:5", "no metric uses them", "cpsnr_db"]);
    fails("scenes = [", "scenes = [] # [", &["study.toml:4", "cpsnr_db needs scenes"]);
    fails("&seed=2", "", &["study.toml:5", "twice"]);
    fails("&seed=2", "&sed=2", &["study.toml:5:42", "did you mean 'seed'"]);
    fails("dead-leaves?rows=64&cols=64&seed=2", "none.exr", &["study.toml:5:42", "none.exr"]);

    // What stands in lists and conditions is shown there, not somewhere.
    fails("[\"bc\", \"ab\"]", "[\"bc\", \"ab\"], [\"ab\", \"c\"]", &["study.toml:10:24", "given[1]"]);
    let at = |by| ("[filters.gaussian_grid]", by);
    let (what, by) = at(
        "[filters.library]\nseries = [\"measured\", { butterworth = { centers_nm = [450, 50, 650], fwhms_nm = [50, 50, 100], order = 0 } }]",
    );
    fails(what, by, &["study.toml:9:23", "series[1]", "order"]);
    let (what, by) = at("[filters.list]");
    fails(what, by, &["study.toml:8"]);
    let condition = |by: &str| format!("given = [[\"bc\", \"ab\"]]\n[conditions.grid]\n{by}");
    let given = "given = [[\"bc\", \"ab\"]]";
    fails(
        given,
        &condition("luminance_cd_m2 = [10, -1]"),
        &["study.toml:12", "-1; expected a number above 0"],
    );
    fails(given, &condition("illuminant = [\"D65\", \"D66\"]"), &["study.toml:12", "D66"]);
    let unknown = condition("\"optics.fnumber\" = [2, 4]");
    fails(given, &unknown, &["study.toml:12", "fnumber", "did you mean `f_number`?"]);
    let negative = "colors = [3]\nset = { \"sensor.pixel.pitch_um\" = -1 }";
    fails("colors = [3]", negative, &["study.toml:4:35", "pitch_um"]);
    fails(
        "colors = [3]",
        "colors = [5]",
        &["study.toml:3", "5 colours have 3 sets of filters and 0 mosaics"],
    );
    let listed = "given = [[\"bc\", \"ab\"]]\n[[conditions.list]]\nluminance_cd_m2 = 5\n[[conditions.list]]\nluminance_cd_m2 = 0";
    fails(given, listed, &["study.toml:14", "0; expected a number above 0"]);
    let other = "given = [[\"bc\", \"ab\"]]\n[[conditions.list]]\n\"optics.f_number\" = 2\n[[conditions.list]]\n\"optics.f_numbr\" = 4";
    fails(given, other, &["no key `optics.f_numbr`", "did you mean `optics.f_number`?"]);
    let fewer = "given = [[\"bc\", \"ab\"]]\n[[conditions.list]]\nluminance_cd_m2 = 5\nilluminant = \"A\"\n[[conditions.list]]\nluminance_cd_m2 = 9";
    fails(given, fewer, &["lacks the key `illuminant` of the first entry"]);
}

/// A list of mosaics is held in memory: what would not fit is refused with what would.
#[test]
fn too_many_large_mosaics_are_refused() {
    let place = Place::new();
    let tile = "sample = { mosaics = 9000000 }\n[filters.rule]\nrules = [\"uniform\"]\n[mosaics.tile]\nrows = 8\ncols = 8\n";
    place.write("study.toml", format!("camera = \"table1\"\ncolors = [5]\n{tile}"));
    let run = place.run(&["sweep", "study.toml", "-o", "none"]);
    assert!(
        run.code == 1 && run.err.contains("study.toml:3") && run.err.contains("at most 1562500"),
        "{}",
        run.err
    );
}

/// Of mosaics it is asked which aliases least; those that are published have names.
#[test]
fn the_report_of_mosaics_names_the_one_that_aliases_least() {
    let place = Place::new();
    let metrics =
        "metrics = [\"delta_e_76\", \"mtf50_cy_per_mm\", \"aliasing_percent\", \"color_aliasing_percent\"]";
    let families = "mosaics = \"catalogue\"\n[filters.rule]\nrules = [\"uniform\"]\n";
    place.write("study.toml", format!("camera = \"table1\"\ncolors = [3]\n{metrics}\n{families}"));
    place.ok("sweep study.toml -o out --part-size 4");
    // Results go on in the parts that they have.
    place.ok("sweep study.toml -o out --quiet");
    let text = place.ok("report out");
    assert!(text.contains("least aliasing") && text.contains("colour aliasing %"), "{text}");
    let document = place.json("out/report/report.json");
    let best = &document["studies"][0]["sections"][0]["colors"][0]["best"];
    let aliasing = columns(&place, "out", &["aliasing_percent"]).remove(0);
    let least = aliasing.iter().copied().fold(f64::INFINITY, f64::min);
    assert_eq!(best[0]["aliasing_percent"].as_f64(), Some(least));
    assert!(best[0]["mosaic"].as_str().unwrap().starts_with("bayer"), "{best}");
}

/// Files of a study are told as those of cameras are.
#[test]
fn what_was_recognised_in_the_files_of_a_study_is_told() {
    let place = Place::new();
    place.write("light.csv", "nm;power\n380;0,5\n800;1\n");
    let study = STUDY.replacen("colors", "illuminant = \"light.csv\"\ncolors", 1);
    let study = study.replace("\"leaves.exr\", ", "");
    place.write("study.toml", &study);
    let told = place.run(&["sweep", "study.toml", "-o", "out", "--dry-run"]);
    let note = "note: light.csv: columns separated by semicolons, decimal commas\n";
    assert!(told.code == 0 && told.err.contains(note), "{}", told.err);
    place.write("light.csv", "nm,power (%)\n380,50\n800,120\n");
    let refused = place.run(&["sweep", "study.toml", "-o", "out", "--dry-run"]);
    assert!(
        refused.code == 1 && refused.err.contains("found 120 in column 'power'; expected at most 100 %"),
        "{}",
        refused.err
    );
}
