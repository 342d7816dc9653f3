//! Experiments in which people judge: their pictures, and the analysis of simulated observers.

use smalti::numeric::philox::Stream;
use smalti::rating::{Counts, Model, Psychometric, Role, Shown, Side};
use smalti_io::ratings::{AnswerFolder, Display, Manifest, read, secret_hash};

use crate::Place;

const SCENES: &str = "--scene macbeth?patch=16 --scene dead-leaves?rows=96&cols=128&largest=40";

/// Simulated observers answer all their pairs. `prefers` is the probability that the first condition is preferred to the second;
/// nobody falls into a trap.
fn observe(place: &Place, folder: &str, observers: u32, prefers: impl Fn(usize, usize) -> f64) -> Manifest {
    let dir = place.path(folder);
    let manifest = read(&dir, true).unwrap();
    let answers = AnswerFolder::open(&dir).unwrap();
    let display =
        Display { device_pixel_ratio: 1.0, screen_px: [1920, 1080], px_per_mm: None, gamma: Some(2.2) };
    let mut counts = vec![Counts::new(manifest.conditions.len()); manifest.scenes.len()];
    for number in 1..=observers {
        let mut random = Stream::new(9, 1, number);
        let (mut observer, mut file) =
            answers.begin(&manifest, number, &secret_hash(&number.to_string()), &display).unwrap();
        loop {
            let own: Vec<_> = observer.trials.iter().map(|t| t.trial).collect();
            let who = (manifest.seed, number);
            let Some(trial) = manifest.schedule.next(manifest.question, who, &own, &counts, &[]) else {
                break;
            };
            let left = match (trial.left, trial.right) {
                (Shown::Condition(a), Shown::Condition(b)) => random.uniform() < prefers(a, b),
                (left, _) => left == Shown::Reference,
            };
            file.show(&mut observer, trial).unwrap();
            file.answer(&mut observer, if left { Side::Left } else { Side::Right }, 1500).unwrap();
            if let (Role::Rating, Some((a, b))) = (trial.role, trial.pair()) {
                let a_wins = (trial.left == Shown::Condition(a)) == left;
                let (preferred, other) = if a_wins { (a, b) } else { (b, a) };
                counts[trial.scene].add(preferred, other, 1.0);
            }
        }
    }
    manifest
}

/// From the pictures to the scale: the scores of simulated observers are those that they answer by, and the metrics are ranked.
#[test]
fn a_scale_is_recovered_from_the_answers() {
    let place = Place::new();
    let trials = "--ratings 24 --repeats 4 --traps 2 --training 2 --side 96";
    let out = place.ok(&format!(
        "rate init bayer rgbw --processing bilinear --luminance 1,80 {SCENES} {trials} -o trial -q"
    ));
    assert!(out.starts_with("4 conditions on 2 scenes; 32 pairs for each observer"), "{out}");
    assert_eq!(place.names("trial/pictures").len(), 12);
    let run = place.run(&["rate", "analyse", "trial"]);
    assert_eq!(run.code, 1);
    assert!(run.err.contains("no answers yet"), "{}", run.err);
    let truth = [-1.2, 0.4, -0.6, 1.4];
    observe(&place, "trial", 8, |a, b| Model::ThurstoneCaseV.probability(truth[a] - truth[b]));
    let results = place.document("rate analyse trial --json --keep-all");
    assert_eq!(results["observers"].as_array().unwrap().len(), 8);
    assert_eq!(results["result"]["intervals_describe"], "observers");
    let conditions = results["result"]["all"]["conditions"].as_array().unwrap();
    for (condition, truth) in conditions.iter().zip(truth) {
        let jod = &condition["jod"];
        let (low, high) =
            (jod["interval"]["low"].as_f64().unwrap(), jod["interval"]["high"].as_f64().unwrap());
        // Four scores of one experiment: wider than the interval of each by a half.
        let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
        assert!((truth - middle).abs() < 1.5 * half, "{condition} and {truth}");
    }
    let agreement = results["result"]["agreement"].as_array().unwrap();
    let names: Vec<&str> = agreement.iter().map(|a| a["metric"].as_str().unwrap()).collect();
    assert_eq!(names[..3], ["cpsnr_db", "pixel_delta_e_2000_mean", "scielab_mean"]);
    assert_eq!(names.len(), 7);
    // The observers prefer more light, as all metrics do.
    assert!(agreement[0]["agreement"]["spearman"]["value"].as_f64().unwrap() > 0.5, "{agreement:?}");
    let csv = String::from_utf8(place.read("trial/analysis/scale.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 3 * 4);
    let csv = String::from_utf8(place.read("trial/analysis/agreement.csv")).unwrap();
    let mut lines = csv.lines();
    assert_eq!(
        lines.next(),
        Some("metric,spearman,spearman_low,spearman_high,kendall,kendall_low,kendall_high,scenes,conditions")
    );
    for (line, metric) in lines.zip(agreement) {
        let of = &metric["agreement"];
        let mut expected = vec![metric["metric"].to_string()];
        for which in ["spearman", "kendall"] {
            let (value, interval) = (&of[which]["value"], &of[which]["interval"]);
            expected.extend(
                [value, &interval["low"], &interval["high"]].map(|v| v.as_f64().unwrap().to_string()),
            );
        }
        expected.extend([of["scenes"].to_string(), "4".into()]);
        assert_eq!(line, expected.join(","));
    }
    assert_eq!(csv.lines().count(), 1 + 7);
    let answers = String::from_utf8(place.read("trial/analysis/answers.csv")).unwrap();
    assert_eq!(answers.lines().count(), 1 + 8 * 32);
    let text = place.ok("rate analyse trial --keep-all");
    assert!(text.contains("rgbw bilinear at 80 cd/m²") && text.contains("cpsnr_db"), "{text}");
    assert_eq!(place.json("trial/analysis/results.json"), results);
    let page = String::from_utf8(place.read("trial/analysis/report.html")).unwrap();
    assert!(page.contains("Agreement with metrics") && !page.contains("No figure"));
    // Answers belong to their pictures.
    let run = place.run(&["rate", "init", "bayer", "rgbw", "-o", "trial", "-q"]);
    assert_eq!(run.code, 1);
    assert!(run.err.contains("answers of observers"), "{}", run.err);
    // A second run of the same experiment has the same pictures.
    place.ok(&format!(
        "rate init bayer rgbw --processing bilinear --luminance 1,80 {SCENES} {trials} -o again -q"
    ));
    for name in place.names("trial/pictures") {
        assert!(
            place.read(&format!("trial/pictures/{name}")) == place.read(&format!("again/pictures/{name}"))
        );
    }
}

/// The light for equal appearance is that of the psychometric function that the simulated observers answer by.
#[test]
fn the_light_of_equal_appearance_is_recovered() {
    let place = Place::new();
    place.write(
        "light.toml",
        "about = \"light\"\nvaried = \"bayer\"\nstandard = \"rgbw\"\nluminance_cd_m2 = 20\nstops = [-1, -0.5, 0, 0.5, 1, 1.5]\n\
         scenes = [\"macbeth?patch=16\", \"dead-leaves?rows=96&cols=128&largest=40\"]\nratings = 36\n",
    );
    place.ok("rate init --experiment light.toml --processing bilinear --side 96 -o light -q");
    let manifest = read(&place.path("light"), true).unwrap();
    assert_eq!(manifest.conditions.len(), 7);
    assert_eq!(manifest.conditions[1].name, "bayer bilinear at 20 cd/m² −1 stops");
    // 2.5 stops more light at the same exposure time: the gain of the display makes up for it, and photon noise falls by 2^1.25 or more.
    let picture = |c: usize| &manifest.scenes[1].pictures[c];
    let gain = |c: usize| picture(c).gain.unwrap();
    assert!((gain(1) / gain(6) - 2.0f64.powf(2.5)).abs() < 1e-3);
    let noise = |c: usize| picture(c).metrics["luminance_noise_percent"];
    assert!(noise(6) < noise(1) / 2.0f64.powf(1.25), "{} and {}", noise(6), noise(1));
    assert!(picture(6).metrics["cpsnr_db"] > picture(1).metrics["cpsnr_db"]);
    assert_eq!(picture(6).exposure_time_s, picture(1).exposure_time_s);
    let truth = Psychometric { equality: 0.4, spread: 0.7, lapse: 0.01 };
    let stops: Vec<f64> = manifest.conditions.iter().map(|c| c.stops).collect();
    observe(&place, "light", 10, |a, b| {
        if a == 0 { 1.0 - truth.probability(stops[b]) } else { truth.probability(stops[a]) }
    });
    let results = place.document("rate analyse light --json --keep-all");
    let fit = &results["result"]["fit"];
    let interval = &fit["equality"]["interval"];
    let (low, high) = (interval["low"].as_f64().unwrap(), interval["high"].as_f64().unwrap());
    assert!(low < 0.4 && 0.4 < high && high - low < 0.6, "{fit}");
    let csv = String::from_utf8(place.read("light/analysis/light.csv")).unwrap();
    let cells: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    let cell = |name: &str| cells[1][cells[0].iter().position(|n| *n == name).unwrap()];
    assert_eq!(cells.len(), 2);
    assert_eq!(
        [
            cell("varied"),
            cell("standard"),
            cell("is_within"),
            cell("scenes"),
            cell("observers"),
            cell("answers")
        ],
        ["\"bayer bilinear\"", "\"rgbw bilinear at 20 cd/m²\"", "true", "2", "10", "410"]
    );
    assert_eq!(cell("equality_stops").parse::<f64>().unwrap(), fit["equality"]["value"].as_f64().unwrap());
    assert_eq!(
        ["equality_stops_low", "equality_stops_high"].map(|name| cell(name).parse::<f64>().unwrap()),
        [low, high]
    );
    let csv = String::from_utf8(place.read("light/analysis/levels.csv")).unwrap();
    assert_eq!((csv.lines().next(), csv.lines().count()), (Some("stops,preferred,asked"), 1 + 6));
    assert!(!place.names("light/analysis").iter().any(|name| name == "scale.csv"));
    let text = place.ok("rate analyse light --keep-all");
    assert!(text.contains("bayer bilinear needs 0.") && text.contains("stops more light ["), "{text}");
    let page = String::from_utf8(place.read("light/analysis/report.html")).unwrap();
    assert!(page.contains("point of equality"));
    let again = "smalti rate init --experiment light.toml --processing bilinear --side 96 -o light -q\nsmalti rate analyse light";
    assert!(page.contains(again), "{}", page.split("rate init").nth(1).unwrap_or("no command"));
}

#[test]
fn what_is_no_experiment_is_refused() {
    let place = Place::new();
    for (words, expected) in [
        ("rate init bayer -q", "only one condition"),
        ("rate init bayer rgbw --stops=0,1 --luminance 1,80 -q", "one --luminance"),
        ("rate init bayer rgbw --stops=1 --luminance 1 -q", "expected several"),
        ("rate init bayer rgbw --stops=1,1 --luminance 1 -q", "given twice"),
        ("rate init --experiment bayer-lihgt -q", "did you mean 'bayer-light'?"),
        ("rate serve no-such -q", "experiment.json"),
        ("rate analyse no-such", "experiment.json"),
    ] {
        let words = words.replace(
            "rate init bayer -q",
            "rate init bayer --processing bilinear --luminance 80 --scene uniform?size=32 -q",
        );
        let run = place.run(&words.split(' ').collect::<Vec<_>>());
        assert_eq!((run.code, run.out.as_str()), (1, ""), "{words}");
        assert!(run.err.contains(expected), "{words}: {}", run.err);
    }
    for words in
        ["rate", "rate init", "rate init bayer --experiment bayer-light", "rate serve", "rate analyse"]
    {
        assert_eq!(place.run(&words.split(' ').collect::<Vec<_>>()).code, 2, "{words}");
    }
    assert!(place.names("experiment").is_empty());
    // The usage names the two forms apart: the arguments of one are refused in the other.
    let both = place.run(&["rate", "init", "bayer", "--experiment", "bayer-light"]).err;
    assert!(both.contains("smalti rate init [OPTIONS] <CAMERAS>...\n"), "{both}");
    assert!(both.contains("smalti rate init [OPTIONS] --experiment <NAME>\n"), "{both}");
}

#[test]
fn one_scene_is_not_called_scenes() {
    let out = Place::new().ok(
        "rate init bayer rgbw --processing bilinear --luminance 80 --scene macbeth?patch=16 --side 96 -o one -q",
    );
    assert!(out.starts_with("2 conditions on 1 scene; 52 pairs for each observer\n"), "{out}");
}
