//! The folder of a rating experiment, and scales against another program.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use smalti::color::{ColorSpace, Image};
use smalti::experiment::{RatedPicture, RatedScene};
use smalti::numeric::Planes;
use smalti::numeric::philox::Stream;
use smalti::rating::{Counts, Model, Penalty, Question, Role, Schedule, Shown, Side, Trial, fit};
use smalti_io::ratings::{
    ANSWERS, AnswerFolder, Condition, Display, MANIFEST, Manifest, Planned, choices, read, read_observers,
    secret_hash, write, write_table,
};

use crate::python::python;

/// The scores of 800 choices between six conditions agree with those of choix to 1e-5, the tolerance of its optimiser.
#[test]
fn choix_finds_the_same_scale() {
    let truth = [-1.5, -0.6, 0.0, 0.2, 0.7, 1.2];
    let mut random = Stream::new(4, 1, 1);
    let (mut counts, mut all) = (Counts::new(6), Vec::new());
    for _ in 0..800 {
        let (a, b) = (random.below(6) as usize, random.below(6) as usize);
        if a != b {
            let prefers_a = random.uniform() < Model::BradleyTerry.probability(truth[a] - truth[b]);
            let (preferred, other) = if prefers_a { (a, b) } else { (b, a) };
            counts.add(preferred, other, 1.0);
            all.push([preferred, other]);
        }
    }
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("choices.json");
    fs::write(&path, json!({"conditions": 6, "choices": all}).to_string()).unwrap();
    let Some(lines) = python("check_ratings.py", "choix", &[&path]) else { return };
    let own = fit(&counts, Model::BradleyTerry, Penalty::None).unwrap();
    for (score, other) in own.scores.iter().zip(lines[0].as_array().unwrap()) {
        assert!((score - other.as_f64().unwrap()).abs() < 1e-5, "{:?} and {lines:?}", own.scores);
    }
}

fn grey(level: f32) -> Image {
    Image::new(ColorSpace::Srgb, Planes::new(4, 6, 3, vec![level; 72]).unwrap()).unwrap()
}

fn experiment(dir: &Path, question: Question) -> Manifest {
    let condition = |stops: f64| Condition {
        name: format!("camera at {stops}"),
        camera: "camera".into(),
        processing: "l3".into(),
        luminance_cd_m2: 1.0,
        stops,
    };
    let picture = |level| RatedPicture {
        image: grey(level),
        gain: 2.0,
        exposure_time_s: 0.1,
        metrics: vec![("cpsnr_db", 30.0)],
    };
    let scene = |name: &str| RatedScene {
        name: name.into(),
        reference: grey(0.5),
        trap: grey(0.1),
        pictures: vec![picture(0.2), picture(0.3), picture(0.4)],
    };
    let planned = Planned {
        title: "test".into(),
        command: vec!["rate".into()],
        question,
        schedule: Schedule { ratings: 6, repeats: 1, traps: 1, training: 1, break_every: 5 },
        seed: 1,
        conditions: vec![condition(0.0), condition(-1.0), condition(1.0)],
    };
    write(dir, &planned, &[scene("one"), scene("two")]).unwrap()
}

fn display() -> Display {
    Display { device_pixel_ratio: 1.0, screen_px: [1920, 1080], px_per_mm: Some(3.8), gamma: None }
}

fn trial(role: Role, scene: usize, left: Shown, right: Shown) -> Trial {
    Trial { role, scene, left, right }
}

#[test]
fn an_experiment_is_read_as_it_was_written() {
    let dir = tempfile::tempdir().unwrap();
    let written = experiment(dir.path(), Question::Scale);
    assert_eq!(read(dir.path(), true).unwrap(), written);
    assert_eq!(written.scenes[1].pictures[2].metrics["cpsnr_db"], 30.0);
    assert_eq!((written.scenes[0].rows, written.scenes[0].cols), (4, 6));
}

#[test]
fn a_manifest_that_is_not_as_written_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    experiment(dir.path(), Question::Scale);
    let path = dir.path().join(MANIFEST);
    let good: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut other = good.clone();
        change(&mut other);
        fs::write(&path, other.to_string()).unwrap();
        let error = read(dir.path(), true).unwrap_err().to_string();
        assert!(error.contains(MANIFEST), "{error}");
        error
    };
    for (expected, change) in [
        ("version 1 is read here", &(|v: &mut Value| v["version"] = json!(2)) as &dyn Fn(&mut Value)),
        ("smalti rate init", &|v| v["format"] = json!("other")),
        ("unknown field", &|v| v["more"] = json!(1)),
        ("in the folder pictures", &|v| v["scenes"][0]["pictures"][0]["file"] = json!("../secret.png")),
        ("in the folder pictures", &|v| v["scenes"][0]["reference"]["file"] = json!("/etc/passwd")),
        ("in the folder pictures", &|v| v["scenes"][0]["coarse"]["file"] = json!("pictures/../a.png")),
        ("one for each condition", &|v| {
            v["scenes"][1]["pictures"].as_array_mut().unwrap().pop();
        }),
        ("of different names", &|v| v["conditions"][1]["name"] = v["conditions"][0]["name"].clone()),
        ("at least one rating", &|v| v["schedule"]["ratings"] = json!(0)),
        ("damaged", &|v| v["seed"] = json!(7)),
        ("the number of a condition", &|v| v["question"] = json!({"kind": "light", "standard": 3})),
    ] {
        let error = refused(change);
        assert!(error.contains(expected), "{expected}: {error}");
    }
    for hostile in ["", "{", "[]", "null", "\u{0}"] {
        fs::write(&path, hostile).unwrap();
        assert!(read(dir.path(), true).is_err(), "{hostile}");
    }
    // A picture that was replaced.
    fs::write(&path, good.to_string()).unwrap();
    assert!(read(dir.path(), true).is_ok());
    let picture = dir.path().join("pictures/scene-1-condition-2.png");
    fs::copy(dir.path().join("pictures/scene-1-condition-1.png"), &picture).unwrap();
    assert!(read(dir.path(), false).is_ok());
    assert!(read(dir.path(), true).unwrap_err().to_string().contains("damaged"));
}

/// The answers of a simulated observer: a trap, a rating and its repeat, training.
fn answered(dir: &Path, manifest: &Manifest) {
    let folder = AnswerFolder::open(dir).unwrap();
    let (mut observer, mut file) = folder.begin(manifest, 1, &secret_hash("secret"), &display()).unwrap();
    let [a, b] = [0, 2].map(Shown::Condition);
    for (trial, side) in [
        (trial(Role::Training, 0, b, a), Side::Left),
        (trial(Role::Rating, 0, a, b), Side::Right),
        (trial(Role::Trap, 1, Shown::Coarse, Shown::Reference), Side::Right),
        (trial(Role::Repeat, 0, b, a), Side::Left),
        (trial(Role::Rating, 1, a, b), Side::Left),
    ] {
        file.show(&mut observer, trial).unwrap();
        file.answer(&mut observer, side, 1200).unwrap();
    }
    file.show(&mut observer, trial(Role::Rating, 1, b, a)).unwrap();
}

#[test]
fn answers_are_read_as_they_were_given() {
    let dir = tempfile::tempdir().unwrap();
    let manifest = experiment(dir.path(), Question::Light { standard: 0 });
    answered(dir.path(), &manifest);
    let observers = read_observers(dir.path(), &manifest).unwrap();
    assert_eq!((observers.len(), observers[0].trials.len()), (1, 6));
    assert_eq!(observers[0].trials[5].answer, None);
    let found = choices(&manifest, &observers[0]);
    assert_eq!((found.repeats, found.traps), ([1, 1], [1, 1]));
    // The rating and its repeat on the first scene, and a rating on the second.
    assert_eq!(
        [found.scenes[0].wins(2, 0), found.scenes[0].wins(0, 2), found.scenes[1].wins(0, 2)],
        [2.0, 0.0, 1.0]
    );
    let light = manifest.answers(&observers).levels(&found);
    assert_eq!(
        light.iter().map(|l| (l.level, l.chosen, l.asked)).collect::<Vec<_>>(),
        [(-1.0, 0.0, 0.0), (1.0, 2.0, 3.0)]
    );
    let table = dir.path().join("answers.csv");
    write_table(&table, &manifest, &observers).unwrap();
    let text = fs::read_to_string(table).unwrap();
    assert_eq!(text.lines().count(), 6);
    assert!(text.contains("1,3,trap,\"two\",coarse,reference,right,1200"), "{text}");
}

/// A crash may cut the last line short: it is removed, and what was on the disk before stays.
#[test]
fn a_line_that_was_cut_short_is_removed() {
    let dir = tempfile::tempdir().unwrap();
    let manifest = experiment(dir.path(), Question::Scale);
    answered(dir.path(), &manifest);
    let path = dir.path().join(ANSWERS).join("observer-0001.jsonl");
    let whole = fs::read(&path).unwrap();
    let lines: Vec<usize> =
        whole.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(i, _)| i + 1).collect();
    for cut in lines[0] + 1..whole.len() {
        fs::write(&path, &whole[..cut]).unwrap();
        let complete = *lines.iter().rfind(|end| **end <= cut).unwrap();
        let folder = AnswerFolder::open(dir.path()).unwrap();
        let (observer, _) = folder.resume(&manifest).unwrap().pop().unwrap();
        assert_eq!(fs::read(&path).unwrap(), whole[..complete], "cut at {cut}");
        let answers = observer.trials.iter().filter(|t| t.answer.is_some()).count();
        assert_eq!(answers + observer.trials.len(), lines.iter().filter(|end| **end <= cut).count() - 1);
    }
    // The number of an observer belongs to one file.
    let (before, folder) = (fs::read(&path).unwrap(), AnswerFolder::open(dir.path()).unwrap());
    let error = folder.begin(&manifest, 1, &secret_hash("other"), &display()).unwrap_err().to_string();
    assert!(error.contains("observer-0001.jsonl"), "{error}");
    assert_eq!(fs::read(&path).unwrap(), before);
    drop(folder);
    // Without the first line there is no observer.
    fs::write(&path, &whole[..lines[0] - 1]).unwrap();
    assert!(AnswerFolder::open(dir.path()).unwrap().resume(&manifest).is_err());
}

#[test]
fn one_server_at_a_time_writes_answers() {
    let dir = tempfile::tempdir().unwrap();
    experiment(dir.path(), Question::Scale);
    let first = AnswerFolder::open(dir.path()).unwrap();
    let error = AnswerFolder::open(dir.path()).unwrap_err().to_string();
    assert!(error.contains("another server"), "{error}");
    drop(first);
    AnswerFolder::open(dir.path()).unwrap();
}

#[test]
fn answers_that_no_server_has_written_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let manifest = experiment(dir.path(), Question::Scale);
    answered(dir.path(), &manifest);
    let path = dir.path().join(ANSWERS).join("observer-0001.jsonl");
    let good = fs::read_to_string(&path).unwrap();
    for (from, to, expected) in [
        (manifest.id.as_str(), "0123", "answers to this experiment"),
        ("\"version\":1", "\"version\":9", "version 1 is read here"),
        ("\"number\":3,\"choice\"", "\"number\":2,\"choice\"", "an answer to the last pair"),
        ("\"scene\":1", "\"scene\":5", "pair"),
        ("\"condition\":2", "\"condition\":7", "pair"),
        ("\"choice\":\"left\"", "\"choice\":\"both\"", "a line of answers"),
        ("\"kind\":\"answer\"", "\"kind\":\"observer\"", "a line of answers"),
    ] {
        assert!(good.contains(from), "{from}");
        fs::write(&path, good.replacen(from, to, 1)).unwrap();
        let error = read_observers(dir.path(), &manifest).unwrap_err().to_string();
        assert!(error.contains(expected) && error.contains("observer-0001.jsonl"), "{from}: {error}");
    }
}
