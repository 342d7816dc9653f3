//! `smalti report`: its figures against those computed here from the Parquet files, its files, its refusals.

use std::path::Path;

use serde_json::Value;
use smalti::design::Study;
use smalti::design::statistics::summarize;
use smalti_io::dataset::{Column, Dataset};

use crate::{Place, numbers};

/// A study of 8 trials.
const TINY: &str = r#"
camera = "table1"
colors = [3, 4]
mosaics = { given = [["bc", "ab"], ["ab", "cd"]] }
[sample]
filters = 4
[filters.gaussian_grid]
centers_nm = [430, 10, 660]
sigmas_nm = [20, 5, 55]
min_spacing_nm = 20
"#;
/// As the study `theory`, without its slowest rule.
const RULES: &str = r#"
camera = "table1"
colors = [3, 4]
mosaics = { given = [["bc", "ab"], ["ab", "cd"]] }
[filters.rule]
rules = ["uniform", "height-scaled"]
targets = ["cones"]
"#;
const FIGURES: [&str; 12] = [
    "cloud-by-colours",
    "cloud-by-noise",
    "filters-best",
    "filters-worst",
    "histogram-delta-e",
    "histogram-mtf50",
    "means",
    "mosaics",
    "panels-by-colours",
    "pareto-front",
    "scene",
    "zone-plates",
];

/// A place with the results of the tiny study in `out`.
fn swept() -> Place {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    place.ok("sweep tiny.toml -o out");
    place
}

/// What a report prints, without drawing figures.
fn printed(place: &Place, dir: &str) -> String {
    place.ok(&format!("report {dir} -o page.html"))
}

/// Its results, without drawing figures.
fn results(place: &Place, dir: &str) -> Value {
    place.document(&format!("report {dir} -o page.html --json"))
}

fn rows(dir: &Path) -> Vec<Column> {
    let names = ["colors", "delta_e_76", "mtf50_cy_per_mm", "tile", "center_nm", "luminance_noise_percent"];
    let dataset = Dataset::open(dir).unwrap();
    let mut parts: Vec<_> = dataset.columns(&names).unwrap().map(Result::unwrap).collect();
    assert_eq!(parts.len(), 1, "a tiny study is one part");
    parts.remove(0).columns
}

/// The files of a report: every figure twice, well-formed.
fn assert_whole(place: &Place, folder: &str, figures: &[&str]) {
    for figure in figures {
        let png = place.read(&format!("{folder}/{figure}.png"));
        assert!(png.starts_with(b"\x89PNG") && png.ends_with(b"IEND\xaeB`\x82"), "{figure}");
        let svg = String::from_utf8(place.read(&format!("{folder}/{figure}.svg"))).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{figure}");
        assert!(png.len() < 1_000_000 && svg.len() < 1_000_000, "{figure} is large");
    }
}

#[test]
fn means_best_and_front_are_those_of_the_rows() {
    let place = swept();
    let text = place.ok("report out");
    let report = place.json("out/report/report.json");
    assert_eq!(place.document("report out --json"), report);
    let [
        Column::Int(colors),
        Column::Float(delta_e),
        Column::Float(mtf50),
        Column::Text(tile),
        Column::Floats(centers),
        Column::Float(noise),
    ] = &rows(&place.path("out"))[..]
    else {
        panic!("other columns")
    };
    let section = &report["studies"][0]["sections"][0];
    let groups = section["colors"].as_array().unwrap();
    assert_eq!(groups.len(), 2);
    for (group, n) in groups.iter().zip([3, 4]) {
        let of: Vec<usize> = (0..colors.len()).filter(|&r| colors[r] == n).collect();
        let column = |c: &[f64]| of.iter().map(|&r| c[r]).collect::<Vec<f64>>();
        for (key, values) in
            [("delta_e_76", delta_e), ("mtf50_cy_per_mm", mtf50), ("luminance_noise_percent", noise)]
        {
            let expected = summarize(&column(values), 0.95).unwrap();
            for (name, e) in [("mean", expected.mean), ("p05", expected.p05), ("p95", expected.p95)] {
                assert_eq!(group[key][name]["value"].as_f64(), Some(e.value), "{n} {key} {name}");
                assert_eq!(group[key][name]["low"].as_f64(), Some(e.low).filter(|v| v.is_finite()));
                assert_eq!(group[key][name]["high"].as_f64(), Some(e.high).filter(|v| v.is_finite()));
            }
        }
        let e = summarize(&column(delta_e), 0.95).unwrap().mean;
        let cell = format!("{:.2} ({:.2} to {:.2})", e.value, e.low, e.high).replace('-', "−");
        assert!(text.contains(&cell), "{cell} is not in\n{text}");
        // Of four designs two are not below the median of MTF50.
        let mut sharp = of.clone();
        sharp.sort_by(|&a, &b| mtf50[b].total_cmp(&mtf50[a]));
        let best = *sharp[..2].iter().min_by(|&&a, &&b| delta_e[a].total_cmp(&delta_e[b])).unwrap();
        let told = &group["best"][0];
        assert_eq!(told["trial"].as_u64(), Some(best as u64));
        // The filters are drawn anew by their number: they are those that were scored.
        assert_eq!(numbers(&told["center_nm"]), centers[best]);
        assert_eq!(told["tile"].as_str().unwrap(), tile[best]);
        let worst = *of.iter().max_by(|&&a, &&b| delta_e[a].total_cmp(&delta_e[b])).unwrap();
        assert_eq!(group["worst"]["trial"].as_u64(), Some(worst as u64));
    }
    let beats = |a: usize, b: usize| {
        let (no_worse, better) = (
            delta_e[a] <= delta_e[b] && mtf50[a] >= mtf50[b] && noise[a] <= noise[b],
            delta_e[a] < delta_e[b] || mtf50[a] > mtf50[b] || noise[a] < noise[b],
        );
        no_worse && better
    };
    let mut front: Vec<u64> = section["pareto_front"]["trials"]
        .as_array()
        .unwrap()
        .iter()
        .map(|d| d["trial"].as_u64().unwrap())
        .collect();
    front.sort_unstable();
    let all = 0..colors.len();
    let expected: Vec<u64> =
        all.clone().filter(|&b| !all.clone().any(|a| beats(a, b))).map(|r| r as u64).collect();
    assert_eq!(front, expected);
}

#[test]
fn detail_finer_than_the_pixels_is_marked() {
    let place = Place::new();
    let set = |centers: [(u32, u32); 3]| {
        let filters =
            centers.map(|(nm, sigma)| format!("{{ gaussian = {{ center_nm = {nm}, sigma_nm = {sigma} }} }}"));
        format!("[[filters.list]]\nfilters = [{}]\n", filters.join(", "))
    };
    let study = |keys: &str, set: String| {
        place.write(
            "one.toml",
            format!(
                "camera = \"table1\"\ncolors = [3]\nmosaics = {{ given = [[\"bc\", \"ab\"]] }}\n{keys}\n{set}"
            ),
        );
        std::fs::remove_dir_all(place.path("out")).ok();
        place.ok("sweep one.toml -o out");
        printed(&place, "out")
    };
    // Filters that overlap this much need a colour matrix that amplifies all detail, and what is aliased.
    let absurd = study("", set([(442, 45), (462, 33), (635, 42)]));
    assert!(absurd.contains(" * ") && absurd.contains("\n* MTF50 lies beyond the 0.5 cycles"), "{absurd}");
    assert!(absurd.contains("Means contain the MTF50 of 1 design beyond the Nyquist frequency"), "{absurd}");
    let section = || results(&place, "out")["studies"][0]["sections"][0].clone();
    assert_eq!(section()["colors"][0]["best"][0]["mtf50_reliability"], "beyond-nyquist");
    let sound = study("", set([(455, 25), (540, 35), (600, 30)]));
    assert!(!sound.contains('*') && !sound.contains("Means contain"), "{sound}");
    let section = section();
    let best = &section["colors"][0]["best"][0];
    assert_eq!(best["mtf50_reliability"], "reliable");
    // Its array is stated in full, for the camera of the section: the studio opens it.
    assert_eq!(section["description"]["name"], section["camera"]);
    let cfa = &best["cfa"];
    assert_eq!(cfa["pattern"], serde_json::json!(["BC", "AB"]));
    let gaussian = serde_json::json!({"gaussian": {"center_nm": 455.0, "sigma_nm": 25.0, "peak": 1.0}});
    assert_eq!(cfa["filters"]["A"], gaussian);
    // In cycles per pixel, too.
    let per_pixel = study("metrics = [\"mtf50_cy_per_px\"]", set([(442, 45), (462, 33), (635, 42)]));
    assert!(per_pixel.contains(" * ") && per_pixel.contains("\n* MTF50 lies beyond"), "{per_pixel}");
}

/// Results state the exposure and the saturated share of every trial, whatever is scored.
#[test]
fn every_trial_has_its_exposure() {
    let place = Place::new();
    let reported = |keys: &str| {
        place.write(
            "one.toml",
            format!(
                "camera = \"bayer\"\ncolors = [3]\nmosaics = {{ given = [[\"bc\", \"ab\"]] }}\n{keys}\n[filters.gaussian_grid]\n[sample]\nfilters = 2\n"
            ),
        );
        std::fs::remove_dir_all(place.path("out")).ok();
        place.ok("sweep one.toml -o out");
        printed(&place, "out")
    };
    // Nothing is rendered for the Vora value.
    let dim = reported("metrics = [\"vora_value\"]\nluminance_cd_m2 = 10");
    assert!(dim.contains("Exposure: ColorChecker 100.0 ms (0.00 % of the samples saturated)."), "{dim}");
    assert!(dim.lines().any(|l| l.contains("exposure ms  saturated %")), "{dim}");
    let bright = reported("metrics = [\"vora_value\"]\nluminance_cd_m2 = 5000");
    let trial = &results(&place, "out")["studies"][0]["sections"][0]["colors"][0]["best"][0];
    let share = trial["macbeth_saturated_percent"].as_f64().unwrap();
    assert!(share > 50.0 && trial["macbeth_time_s"] == 0.1, "{trial}");
    assert!(bright.contains(&format!("{share:.2}")), "{bright}");
    // Classic and learned processing look at the same chart.
    let both = reported(
        "metrics = [\"mtf50_cy_per_mm\", \"delta_e_76\"]\nluminance_cd_m2 = 500\nprocessing = [\"classic\", \"l3\"]",
    );
    assert!(both.contains(", edge 100.0 ms ("), "{both}");
    let document = results(&place, "out");
    let sections = document["studies"][0]["sections"].as_array().unwrap();
    let shares = |i: usize| -> Vec<f64> {
        let best = sections[i]["colors"][0]["best"].as_array().unwrap();
        let mut trials: Vec<_> =
            best.iter().map(|t| t["macbeth_saturated_percent"].as_f64().unwrap()).collect();
        trials.sort_by(f64::total_cmp);
        trials
    };
    assert_eq!(shares(0), shares(1));
}

#[test]
fn figures_are_whole_and_written_anew() {
    let place = swept();
    place.ok("report out");
    let expected: Vec<String> =
        FIGURES.iter().flat_map(|f| [format!("{f}.png"), format!("{f}.svg")]).collect();
    let mut names = place.names("out/report");
    names.retain(|n| n != "report.json" && n != "report.html");
    assert_eq!(names, expected);
    assert_whole(&place, "out/report", &FIGURES);
    let [first, page] = ["json", "html"].map(|e| place.read(&format!("out/report/report.{e}")));
    // What an earlier report left is replaced or removed; what is not of a report stays.
    place.write("out/report/means.svg", "torn");
    place.write("out/report/filters-by-rule.png", "of other results");
    place.write("out/report/mine.txt", "mine");
    place.ok("report out --threads 1");
    assert_whole(&place, "out/report", &FIGURES);
    assert_eq!(place.read("out/report/report.json"), first);
    assert!(place.read("out/report/report.html") == page, "the page depends on the threads");
    let names = place.names("out/report");
    assert!(names.contains(&"mine.txt".to_owned()) && !names.contains(&"filters-by-rule.png".to_owned()));
    // The results are as they were: a sweep finds nothing to do.
    assert!(
        place.ok("sweep tiny.toml -o out --quiet").starts_with("nothing was left to do; out is complete")
    );
}

/// What `tools/page` does not see: the data of the page, and what it says without a script.
#[test]
fn a_page_holds_the_designs() {
    let place = swept();
    place.ok("report out -o page.html --pictures 1 --picture 6");
    assert!(!place.path("out/report").exists(), "the page alone");
    let html = String::from_utf8(place.read("page.html")).unwrap();
    assert!(
        html.contains("Means, tiny") && html.contains("8 trials, seed 1") && html.contains("Best designs")
    );
    let data = html.split("id=\"sweep\">").nth(1).and_then(|d| d.split("</script>").next()).unwrap();
    let data: Value = serde_json::from_str(data).unwrap();
    assert_eq!((data["rows"].as_u64(), &data["number"]), (Some(8), &serde_json::json!([0, 8])));
    let names: Vec<&str> =
        data["columns"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(names[..3], ["delta_e_76", "delta_e_2000", "mtf50_cy_per_mm"]);
    let pictures = data["pictures"].as_array().unwrap();
    assert_eq!(pictures.len(), 1, "the page draws the others; one was asked for");
    assert_eq!(pictures[0]["row"], 6);
    assert!(pictures[0]["scene"]["src"].as_str().unwrap().starts_with("data:image/png;base64,iVBOR"));
    // What it draws them from.
    assert_eq!(
        (data["optical_setups"].as_array().unwrap().len(), &data["sections"][0]["drawn"]["optical_setup"]),
        (1, &0.into())
    );
    assert_eq!(data["studies"][0]["study"]["seed"], 1);
    assert!(
        html.contains("id=\"simulator\"") && html.contains("&#39;wasm-unsafe-eval&#39;; worker-src blob:")
    );
    // Colours from 3 to 4: the designs use 4 × 3 + 4 × 4 filters, of which two are the same.
    assert_eq!((&data["filters"]["used"]["n"], &data["filters"]["center"]["n"]), (&28.into(), &27.into()));

    let run = place.run(&["report", "out", "-o", "page.html", "--picture", "8"]);
    assert_eq!(run.code, 1);
    assert!(
        run.err.contains("the pictures of trial 8 cannot be embedded: tiny holds no such trial"),
        "{}",
        run.err
    );
    std::fs::create_dir(place.path("folder.html")).unwrap();
    assert_eq!(place.run(&["report", "out", "-o", "folder.html"]).code, 1);
}

#[test]
fn a_manifest_is_a_study() {
    let place = swept();
    place.ok("sweep out/manifest.json -o again");
    let part = "trials/part-000000.parquet";
    assert!(place.read(&format!("again/{part}")) == place.read(&format!("out/{part}")));
    for (name, text) in [("none.json", None), ("torn.json", Some("{")), ("other.json", Some("{\"a\": 1}"))] {
        text.into_iter().for_each(|t| place.write(name, t));
        let run = place.run(&["sweep", name, "-o", "x"]);
        assert!(run.code == 1 && run.err.contains(name), "{}", run.err);
    }
}

/// Five thousand designs and their pictures in less than 4 MB.
#[test]
fn a_page_of_many_designs_is_small() {
    let place = Place::new();
    let study = TINY.replace("filters = 4", "filters = 1000").replace("[3, 4]", "[3, 4, 5, 6, 7]").replace(
        "[\"ab\", \"cd\"]]",
        "[\"ab\", \"cd\"], [\"abc\", \"deb\", \"cad\"], [\"abc\", \"def\", \"bcd\"], [\"abc\", \"def\", \"gce\"]]",
    );
    place.write("many.toml", study);
    place.ok("sweep many.toml -o out");
    place.ok("report out -o page.html");
    let bytes = place.read("page.html").len();
    assert!((1_000_000..4_000_000).contains(&bytes), "{bytes} bytes");
}

#[test]
fn pictures_are_made_by_learned_pipelines() {
    let place = Place::new();
    place.write(
        "learned.toml",
        TINY.replace("[3, 4]", "[3]")
            .replace("filters = 4", "filters = 2")
            .replace("[sample]", "processing = \"l3\"\n[l3]\nside = 3\nlevels = 1\nsize_px = 64\n[sample]"),
    );
    place.ok("sweep learned.toml -o out");
    place.ok("report out");
    assert_whole(&place, "out/report", &["scene", "zone-plates"]);
}

#[test]
fn rules_stand_beside_the_means_of_a_cloud() {
    let place = swept();
    place.write("rules.toml", RULES);
    place.ok("sweep rules.toml -o rules");
    let text = place.ok("report out rules -o both");
    let line = |start: &str| {
        text.lines().any(|l| l.split_whitespace().collect::<Vec<_>>().join(" ").starts_with(start))
    };
    for words in ["3 uniform", "4 height-scaled, cones", "3 mean of tiny"] {
        assert!(line(words), "no line with {words} in\n{text}");
    }
    assert_whole(&place, "both", &["means", "filters-by-rule"]);
    assert_whole(&place, "both/tiny", &["scene"]);
    assert_whole(&place, "both/rules", &["scene"]);
    let report = place.json("both/report.json");
    let files: Vec<&str> =
        report["figures"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
    assert!(
        files.contains(&"tiny/mosaics.svg") && files.iter().all(|f| place.path("both").join(f).is_file())
    );
    let uniform = &report["studies"][1]["sections"][0]["filters"];
    assert!(uniform.as_array().unwrap().iter().any(|f| f["filters"] == "uniform" && f["colors"] == 4));
}

#[test]
fn conditions_are_told_apart() {
    let place = Place::new();
    place.write(
        "noisy.toml",
        format!("{TINY}[conditions.grid]\n\"sensor.pixel.read_noise_mv\" = [1, 30]\n")
            .replace("filters = 4", "filters = 1"),
    );
    place.ok("sweep noisy.toml -o out");
    let text = place.ok("report out");
    assert!(text.contains("── read noise 1 mV ──") && text.contains("── read noise 30 mV ──"), "{text}");
    let report = place.json("out/report/report.json");
    let sections = report["studies"][0]["sections"].as_array().unwrap();
    assert_eq!(sections.len(), 2);
    let noise =
        |i: usize| sections[i]["colors"][0]["luminance_noise_percent"]["mean"]["value"].as_f64().unwrap();
    assert!(noise(0) < noise(1), "{} {}", noise(0), noise(1));
    // One set of filters: the sharpest mosaic is the best.
    assert!(sections[0]["best_by"].as_str().unwrap().starts_with("largest MTF50"));
    assert_whole(&place, "out/report/noisy--read-noise-30-mV", &["scene"]);
}

/// Of many conditions the means of all are printed, and tables of the first, or of those that are asked for.
#[test]
fn many_conditions_are_printed_in_short() {
    let place = Place::new();
    let conditions =
        "[conditions.grid]\n\"optics.f_number\" = [2, 2.8, 4]\n\"sensor.prnu_percent\" = [0, 2]\n";
    place.write("many.toml", format!("{TINY}{conditions}").replace("filters = 4", "filters = 2"));
    place.ok("sweep many.toml -o out");
    let text = printed(&place, "out");
    let tables = |text: &str| text.lines().filter(|l| l.starts_with("── ")).count();
    assert_eq!(tables(&text), 3, "{text}");
    let (_, of_all) = text.split_once("Means of all designs under each condition").unwrap();
    let (of_all, _) = of_all.split_once("\n── ").unwrap();
    for (f, prnu) in [("2", "0"), ("2.8", "2"), ("4", "2")] {
        let name = format!("f-number {f}, PRNU {prnu} %");
        assert!(of_all.lines().any(|l| l.starts_with(&name)), "no {name} in\n{of_all}");
    }
    assert!(of_all.contains("Tables of 3 of the 6 conditions follow. `--draw TEXT`"), "{of_all}");
    assert_eq!(results(&place, "out")["studies"][0]["sections"].as_array().unwrap().len(), 6);
    let run = place.run(&["report", "out", "--draw", "f-number 4", "-o", "some.html"]);
    assert!(run.out.contains("── f-number 4, PRNU 2 % ──"), "{}", run.out);
    assert_eq!(tables(&run.out), 2, "{}", run.out);
    // On the page, the tables of the first conditions are open.
    let page = String::from_utf8(place.read("some.html")).unwrap();
    assert_eq!(page.matches("<details class=\"condition\">").count(), 6);
    assert!(page.contains("Means of all designs under each condition"));
    let refused = place.run(&["report", "out", "--draw", "f-number 9", "-o", "none.html"]);
    assert!(refused.code == 1 && refused.err.contains("f-number 9"), "{}", refused.err);
}

/// A study that names another metric first ranks by it, and its best and worst designs are those of that metric.
#[test]
fn the_first_metric_of_a_study_ranks() {
    let place = Place::new();
    let metrics = ["mtf50_cy_per_mm", "luminance_noise_percent", "delta_e_76"];
    let rest = ["luminance_noise_percent", "vora_value"];
    for (name, metrics, sign) in
        [("sharp", &metrics[..], -1.0), ("clean", &rest[1..], -1.0), ("noise", &rest[..], 1.0)]
    {
        place.write("study.toml", format!("metrics = {metrics:?}\n{TINY}"));
        place.ok(&format!("sweep study.toml -o {name}"));
        let report = results(&place, name);
        let section = &report["studies"][0]["sections"][0];
        assert!(section["best_by"].as_str().unwrap().contains("first metric of the study"), "{section}");
        let dataset = Dataset::open(&place.path(name)).unwrap();
        let mut parts: Vec<_> =
            dataset.columns(&["colors", metrics[0]]).unwrap().map(Result::unwrap).collect();
        let [Column::Int(colors), Column::Float(scores)] = &parts.remove(0).columns[..] else { panic!() };
        let of_three = colors.iter().zip(scores).filter(|(c, _)| **c == 3).map(|(_, s)| sign * s);
        let best = sign * of_three.fold(f64::INFINITY, f64::min);
        let stated = &section["colors"][0]["best"][0];
        let value = stated[metrics[0]].as_f64().unwrap_or_else(|| panic!("no {} in {stated}", metrics[0]));
        assert_eq!(value, best, "{name}");
    }
}

#[test]
fn hostile_names_are_escaped() {
    let place = Place::new();
    place.write("evil.toml", format!("name = \"<script>\\u001b[2J&../../x\"\n{TINY}"));
    place.ok("sweep evil.toml -o out");
    let text = place.ok("report out");
    assert!(text.starts_with("<script>\u{fffd}[2J&../../x: 8 trials"), "{text}");
    for figure in FIGURES {
        let svg = String::from_utf8(place.read(&format!("out/report/{figure}.svg"))).unwrap();
        assert!(!svg.contains("<script>") && !svg.contains('\u{1b}'), "{figure}");
    }
    // Folders of sections are named after studies.
    place.ok("report out out -o twice");
    assert!(place.names("twice").iter().all(|n| !n.contains("..") || !n.contains('/')));
    assert_eq!(place.names("twice").iter().filter(|n| place.path("twice").join(n).is_dir()).count(), 2);
}

#[test]
fn what_cannot_be_reported_is_refused() {
    let place = swept();
    let refused = |args: &[&str]| {
        let run = place.run(&[&["report"], args].concat());
        assert_eq!((run.code, run.out.as_str()), (1, ""), "{args:?}: {}", run.err);
        assert!(run.err.starts_with("error: ") && run.err.lines().count() == 1, "{}", run.err);
        run.err
    };
    assert!(refused(&["nowhere"]).contains("nowhere"));
    std::fs::create_dir(place.path("empty")).unwrap();
    assert!(refused(&["empty"]).contains("holds no results"));
    // The folder of a comparison has a page of its own.
    std::fs::create_dir(place.path("compared")).unwrap();
    place.write("compared/results.json", "{}");
    let compared = refused(&["compared"]);
    assert!(compared.contains("holds a comparison") && compared.contains("report.html"), "{compared}");
    place.write("file", "x");
    assert!(refused(&["out", "-o", "file"]).contains("expected a folder"));
    assert!(!place.path("out/report").exists(), "nothing is written before all is read");

    let part = "out/trials/part-000000.parquet";
    let whole = place.read(part);
    place.write(part, &whole[..whole.len() / 2]);
    assert!(refused(&["out"]).contains("part-000000.parquet is truncated"));
    std::fs::remove_file(place.path(part)).unwrap();
    assert!(refused(&["out"]).contains("holds no trial yet"));
    place.write(part, &whole);

    let manifest = String::from_utf8(place.read("out/manifest.json")).unwrap();
    place.write("out/manifest.json", manifest.replace("\"revision\": 2", "\"revision\": 9"));
    assert!(refused(&["out"]).contains("version 9"));
    place.write("out/manifest.json", manifest.replace("\"seed\": 1", "\"seed\": 2"));
    assert!(refused(&["out"]).contains("manifest.json"));
    place.write("out/manifest.json", &manifest[..manifest.len() / 2]);
    assert!(refused(&["out"]).contains("manifest.json"));
}

/// JSON without spaces, the keys of every object in order of their bytes, as the hash of a plan has it.
fn canonical(value: &Value) -> String {
    match value {
        Value::Object(map) => {
            let sorted: std::collections::BTreeMap<_, _> = map.iter().collect();
            let pairs: Vec<String> = sorted
                .into_iter()
                .map(|(k, v)| format!("{}:{}", Value::from(k.as_str()), canonical(v)))
                .collect();
            format!("{{{}}}", pairs.join(","))
        }
        Value::Array(items) => {
            format!("[{}]", items.iter().map(canonical).collect::<Vec<_>>().join(","))
        }
        other => other.to_string(),
    }
}

/// Results as another version would have left them, by the description of the format alone.
fn made_by_another_version(place: &Place, version: &str) {
    made_with(place, |manifest| manifest["smalti"] = version.into());
}

/// Results with another manifest, sealed again.
fn made_with(place: &Place, change: impl FnOnce(&mut Value)) {
    let mut manifest: Value = serde_json::from_slice(&place.read("out/manifest.json")).unwrap();
    let old = manifest["plan_blake3"].as_str().unwrap().to_owned();
    change(&mut manifest);
    let hashed = ["smalti", "revision", "trials", "chunk", "schema", "study"];
    let plan: serde_json::Map<_, _> = hashed.iter().map(|k| ((*k).to_owned(), manifest[k].clone())).collect();
    let new = blake3::hash(canonical(&Value::Object(plan)).as_bytes()).to_hex().to_string();
    manifest["plan_blake3"] = new.as_str().into();
    place.write("out/manifest.json", manifest.to_string());
    let part = "out/trials/part-000000.parquet";
    let mut bytes = place.read(part);
    let find = |bytes: &[u8], what: &[u8]| bytes.windows(what.len()).rposition(|w| w == what).unwrap();
    let at = find(&bytes, old.as_bytes());
    bytes[at..at + 64].copy_from_slice(new.as_bytes());
    // Behind the key: the length of the value as Thrift has it, then the value.
    let key = b"smalti.blake3";
    let at = find(&bytes, key) + key.len();
    let at = at + bytes[at..].windows(64).position(|w| w.iter().all(u8::is_ascii_hexdigit)).unwrap();
    bytes[at..at + 64].fill(b'0');
    let seal = blake3::hash(&bytes).to_hex().to_string();
    bytes[at..at + 64].copy_from_slice(seal.as_bytes());
    place.write(part, bytes);
}

#[test]
fn results_of_another_version_are_shown_and_not_continued() {
    let place = swept();
    let ours = results(&place, "out");
    made_by_another_version(&place, "0.0.9");
    let theirs = place.document("report out --json -o theirs");
    let page = String::from_utf8(place.read("theirs/report.html")).unwrap();
    assert!(page.contains("the figures are those of Smalti 0.0.9"), "{theirs}");
    // The figures are those that stand in the files.
    let sections = &ours["studies"][0]["sections"];
    assert!(sections[0]["colors"].is_array() && *sections == theirs["studies"][0]["sections"]);
    assert_eq!(theirs["studies"][0]["scored_by"], "0.0.9");
    let refused = place.run(&["sweep", "tiny.toml", "-o", "out"]);
    assert!(refused.code == 1 && refused.err.contains("0.0.9"), "{}", refused.err);
}

/// A machine whose last bits differ neither continues results nor adds shards to them; it can report them.
#[test]
fn results_of_a_machine_with_other_arithmetic_are_shown_and_not_continued() {
    let place = swept();
    let own = place.json("out/manifest.json")["study"]["arithmetic"].as_str().unwrap().to_owned();
    assert_eq!(own, smalti::numeric::arithmetic());
    made_with(&place, |manifest| manifest["study"]["arithmetic"] = "0123456789abcdef".into());
    place.ok("report out -o theirs");
    place.ok("sweep tiny.toml -o mine");
    for words in ["sweep tiny.toml -o out", "sweep --merge out mine -o both"] {
        let refused = place.run(&words.split(' ').collect::<Vec<_>>());
        let [theirs, ours] = ["\"0123456789abcdef\"".to_owned(), format!("{own:?}")];
        assert!(refused.code == 1 && refused.err.contains("arithmetic: "), "{words}: {}", refused.err);
        assert!(refused.err.contains(&theirs) && refused.err.contains(&ours), "{words}: {}", refused.err);
    }
}

#[test]
fn incomplete_results_are_reported_as_such() {
    let place = Place::new();
    place.write("two-parts.toml", TINY.replace("filters = 4", "filters = 300"));
    place.ok("sweep two-parts.toml -o out --shard 1/2");
    let text = printed(&place, "out");
    assert!(
        text.contains(
            "Incomplete: 1 of 2 parts are missing, 88 trials. This report covers the 512 scored trials."
        ),
        "{text}"
    );
    let study = &results(&place, "out")["studies"][0];
    assert_eq!((study["trials"].as_u64(), study["trials_missing"].as_u64()), (Some(600), Some(88)));
}

/// The study in a manifest is the one that was swept, whatever it holds.
#[test]
fn a_study_is_read_as_it_was_written() {
    let place = Place::new();
    place.write("light.csv", "wavelength_nm,power\n380,1\n580,2.5\n780,0.1\n");
    let sources = [
        ("tiny.toml", TINY.to_owned()),
        ("rules.toml", RULES.to_owned()),
        ("csv.toml", format!("illuminant = \"light.csv\"\n{TINY}")),
        ("dark.toml", format!("{TINY}[conditions.grid]\nilluminant = [\"A\", \"D:5123\"]\n")),
        ("table2", String::new()),
        ("theory", String::new()),
        ("mosaics", String::new()),
        ("aliasing", String::new()),
    ];
    for (name, toml) in sources {
        let path = place.path(name);
        if !toml.is_empty() {
            place.write(name, toml);
        }
        let named = if path.is_file() { path.to_string_lossy().into_owned() } else { name.to_owned() };
        let (trials, _) = smalti_io::studies::load(&named).unwrap();
        let text = serde_json::to_string(trials.study()).unwrap();
        let read: Study = serde_json::from_str(&text).unwrap();
        assert_eq!(&read, trials.study(), "{name}");
        let figures = |d: &smalti::design::Trials| {
            let design = d.trial(d.len() - 1).unwrap().design;
            design.filters.figures().unwrap().iter().map(|f| f.center_nm).collect::<Vec<f64>>()
        };
        assert_eq!(figures(&smalti::design::Trials::new(read).unwrap()), figures(&trials), "{name}");
    }
    let (trials, _) = smalti_io::studies::load("table2").unwrap();
    let mut study = serde_json::to_value(trials.study()).unwrap();
    for (wrong, words) in [
        (Value::from("D56"), "D55"),
        (serde_json::json!(["x", 400.0, 0.0, [1.0, 2.0]]), "step"),
        (7.into(), "expected the name of a light"),
    ] {
        study["conditions"][0]["illuminant"] = wrong;
        let error = serde_json::from_value::<Study>(study.clone()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}
