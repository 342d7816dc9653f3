//! Pipelines from statistics of light against pipelines from patches.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use std::path::PathBuf;

use rayon::prelude::*;
use smalti::camera::{Camera, EvaluationSettings};
use smalti::design::{LearningSettings, LearningStatistics, Metric, PipelineTrainer, Targets};
use smalti::sensor::Cfa;
use smalti_io::{TomlSource, studies};

const STUDY: &str = r#"
    camera = "table1"
    seed = 11
    colors = [3, 4, 5, 6, 7]
    processing = "l3"
    [sample]
    filters = SETS
    [filters.gaussian_grid]
    centers_nm = [430, 2.5, 660]
    sigmas_nm = [20, 2.5, 55]
    min_spacing_nm = 20
    [mosaics]
    given = [["bc", "ab"], ["ab", "cd"], ["abc", "deb", "cad"], ["abc", "def", "bcd"], ["abc", "def", "gce"]]
"#;
const METRICS: [Metric; 4] =
    [Metric::DeltaE76, Metric::DeltaE2000, Metric::Mtf50CyPerMm, Metric::LuminanceNoise];

type Figures = Vec<[f64; 4]>;

fn env(name: &str, default: usize) -> usize {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

fn figures(camera: &Camera, cfas: &[Cfa], settings: &LearningSettings, seed: u64) -> Figures {
    let evaluation = EvaluationSettings { luminance_cd_m2: 75.0, seed, ..EvaluationSettings::default() };
    let images = |_: &str, make: &dyn Fn() -> _| make();
    let targets = Targets::new(camera, &evaluation, &Metric::USUAL, &[], &images).unwrap();
    let trainer = PipelineTrainer::new(&targets, settings, &images).unwrap();
    let score = |cfa: &Cfa| {
        let (pipeline, reach) = trainer.pipeline(cfa).unwrap();
        let scores = targets.score_with(cfa, &pipeline.renderer(), reach).unwrap();
        METRICS.map(|m| scores.value(m, 0).unwrap_or(f64::NAN))
    };
    // The mosaics once, before all cores.
    let each = cfas.len() / 5;
    (0..5).for_each(|i| {
        score(&cfas[i * each]);
    });
    let begun = std::time::Instant::now();
    let out = cfas.par_iter().map(score).collect();
    println!(
        "{:?}, scene {}, seed {seed}: {:.1} designs/s",
        settings.statistics,
        settings.scene,
        cfas.len() as f64 / begun.elapsed().as_secs_f64()
    );
    out
}

fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    order.iter().enumerate().for_each(|(r, &i)| ranks[i] = r as f64);
    ranks
}

fn spearman(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (ranks(a), ranks(b));
    let mean = (a.len() - 1) as f64 / 2.0;
    let sum = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - mean) * (y - mean)).sum::<f64>();
    sum(&a, &b) / (sum(&a, &a) * sum(&b, &b)).sqrt()
}

/// Root mean variance over runs.
fn spread(runs: &[&Figures], at: std::ops::Range<usize>, m: usize) -> f64 {
    let n = runs.len() as f64;
    let of = |i: usize| {
        let mean = runs.iter().map(|r| r[i][m]).sum::<f64>() / n;
        runs.iter().map(|r| (r[i][m] - mean).powi(2)).sum::<f64>() / (n - 1.0)
    };
    (at.clone().map(of).sum::<f64>() / at.len() as f64).sqrt()
}

#[test]
#[ignore = "minutes"]
fn statistics_of_light_give_the_figures_of_patches() {
    let sets = env("SETS", 30);
    let text = STUDY.replace("SETS", &sets.to_string());
    let source = TomlSource { name: "s.toml".into(), folder: PathBuf::new(), text };
    let (trials, _) = studies::from_source(&source).unwrap();
    let camera = trials.study().conditions[0].camera().unwrap();
    let cfas: Vec<Cfa> =
        (0..trials.len()).map(|i| trials.trial(i).unwrap().design.cfa(camera.grid()).unwrap()).collect();
    let path = std::env::var("REFERENCE").unwrap_or("/tmp/w-sweep-reference.json".into());
    let patches = |scene, seed, size_px| {
        let size_px = env("SIZE", size_px);
        figures(&camera, &cfas, &LearningSettings { scene, size_px, ..LearningSettings::default() }, seed)
    };
    let reference: Vec<Figures> = match std::fs::read(&path) {
        Ok(bytes) => serde_json::from_slice(&bytes).unwrap(),
        Err(_) => {
            let mut all: Vec<Figures> = (1..=4).map(|seed| patches(0, seed, 320)).collect();
            all.extend((1..4).map(|scene| patches(scene, 1, 320)));
            std::fs::write(&path, serde_json::to_vec(&all).unwrap()).unwrap();
            all
        }
    };
    let settings = LearningSettings { statistics: LearningStatistics::Light, ..LearningSettings::default() };
    let light = figures(&camera, &cfas, &settings, 1);
    println!("colours metric | mean | spread seeds, scenes | bias rms (sd of bias) | spearman");
    for c in 0..5 {
        let at = c * sets..(c + 1) * sets;
        for m in 0..4 {
            let of = |run: &Figures| run[at.clone()].iter().map(|f| f[m]).collect::<Vec<f64>>();
            let (a, b) = (of(&reference[0]), of(&light));
            let n = a.len() as f64;
            let d: Vec<f64> = a.iter().zip(&b).map(|(a, b)| b - a).collect();
            let bias = d.iter().sum::<f64>() / n;
            let rms = (d.iter().map(|d| d * d).sum::<f64>() / n).sqrt();
            let mut abs: Vec<f64> = d.iter().map(|d| d.abs()).collect();
            abs.sort_by(f64::total_cmp);
            let seeds = spread(&reference[..4].iter().collect::<Vec<_>>(), at.clone(), m);
            let scenes = spread(&[&reference[0], &reference[4], &reference[5], &reference[6]], at.clone(), m);
            println!(
                "{} {:24} | {:8.3} | {:.4} {:.4} | {:+.4} {:.4} median {:.4} max {:.3} | {:.4}",
                c + 3,
                METRICS[m].name(),
                a.iter().sum::<f64>() / n,
                seeds,
                scenes,
                bias,
                rms,
                abs[abs.len() / 2],
                abs[abs.len() - 1],
                spearman(&a, &b)
            );
        }
    }
}
