//! Pipelines that are learned from statistics of light score designs as pipelines from patches do: by how much they differ, beside
//! the spread of the latter over noise seeds and over training scenes.
//!
//! It takes half a minute: `just learned-statistics`, or
//! `cargo test --release -p smalti-io --test learned_statistics -- --ignored --nocapture`.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

#[path = "support/rank.rs"]
mod rank;

use std::ops::Range;
use std::path::PathBuf;

use rank::spearman;
use rayon::prelude::*;
use smalti::camera::{Camera, EvaluationSettings};
use smalti::design::{LearningSettings, LearningStatistics, Metric, PipelineTrainer, Targets};
use smalti::sensor::Cfa;
use smalti_io::{TomlSource, studies};

/// 150 designs of the study `table2-l3`, with other filters.
const STUDY: &str = r#"
    camera = "table1"
    seed = 11
    colors = [3, 4, 5, 6, 7]
    processing = "l3"
    [sample]
    filters = 30
    [filters.gaussian_grid]
    centers_nm = [430, 2.5, 660]
    sigmas_nm = [20, 2.5, 55]
    min_spacing_nm = 20
    [mosaics]
    given = [["bc", "ab"], ["ab", "cd"], ["abc", "deb", "cad"], ["abc", "def", "bcd"], ["abc", "def", "gce"]]
"#;
const SETS: usize = 30;
/// The metrics, with the greatest bias and root mean square difference relative to the larger spread, and the least rank correlation. The
/// bounds are a tenth above what was measured.
const METRICS: [(Metric, f64, f64, f64); 4] = [
    (Metric::DeltaE76, 0.19, 0.41, 0.997),
    (Metric::DeltaE2000, 0.23, 0.47, 0.993),
    (Metric::Mtf50CyPerMm, 0.36, 1.65, 0.65),
    (Metric::LuminanceNoise, 0.29, 0.46, 0.992),
];

type Figures = Vec<[f64; 4]>;

fn figures(camera: &Camera, cfas: &[Cfa], settings: &LearningSettings, seed: u64) -> Figures {
    let evaluation = EvaluationSettings { luminance_cd_m2: 75.0, seed, ..EvaluationSettings::default() };
    let images = |_: &str, make: &dyn Fn() -> _| make();
    let targets = Targets::new(camera, &evaluation, &Metric::USUAL, &[], &images).unwrap();
    let trainer = PipelineTrainer::new(&targets, settings, &images).unwrap();
    cfas.iter().step_by(SETS).for_each(|cfa| trainer.prepare(cfa.mosaic()).unwrap());
    let score = |cfa: &Cfa| {
        let (pipeline, reach) = trainer.pipeline(cfa).unwrap();
        let scores = targets.score_with(cfa, &pipeline.renderer(), reach).unwrap();
        METRICS.map(|(m, ..)| scores.value(m, 0).unwrap())
    };
    cfas.par_iter().map(score).collect()
}

/// The standard deviation of a design's figure over runs: root of the mean variance of the designs.
fn spread(runs: &[&Figures], designs: Range<usize>, metric: usize) -> f64 {
    let n = runs.len() as f64;
    let variance = |i: usize| {
        let mean = runs.iter().map(|r| r[i][metric]).sum::<f64>() / n;
        runs.iter().map(|r| (r[i][metric] - mean).powi(2)).sum::<f64>() / (n - 1.0)
    };
    (designs.clone().map(variance).sum::<f64>() / designs.len() as f64).sqrt()
}

#[test]
#[ignore = "a minute: just learned-statistics"]
fn statistics_of_light_score_designs_as_patches_do() {
    let source = TomlSource { name: "designs.toml".into(), folder: PathBuf::new(), text: STUDY.into() };
    let (trials, _) = studies::from_source(&source).unwrap();
    let camera = trials.study().conditions[0].camera().unwrap();
    let cfa = |i: u64| trials.trial(i).unwrap().design.cfa(camera.grid()).unwrap();
    let cfas: Vec<Cfa> = (0..trials.len()).map(cfa).collect();
    let patches = |scene, seed| {
        figures(&camera, &cfas, &LearningSettings { scene, ..LearningSettings::default() }, seed)
    };
    let seeds: Vec<Figures> = (1..=4).map(|seed| patches(0, seed)).collect();
    let scenes: Vec<Figures> = (1..=7).map(|scene| patches(scene, 1)).collect();
    let settings = LearningSettings { statistics: LearningStatistics::Light, ..LearningSettings::default() };
    let light = figures(&camera, &cfas, &settings, 1);
    let mut beyond = Vec::new();
    println!(
        "colours, metric: mean; spread over noise seeds, training scenes; bias, rms; rank correlation; pairs of training scenes that differ more"
    );
    for group in 0..cfas.len() / SETS {
        let at = group * SETS..(group + 1) * SETS;
        for (m, (metric, most_bias, most_rms, least_rank)) in METRICS.into_iter().enumerate() {
            let of = |run: &Figures| run[at.clone()].iter().map(|f| f[m]).collect::<Vec<f64>>();
            let (a, b) = (of(&seeds[0]), of(&light));
            let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / SETS as f64;
            let differences = || a.iter().zip(&b).map(|(a, b)| b - a);
            let (bias, rms) = (mean(&mut differences()), mean(&mut differences().map(|d| d * d)).sqrt());
            let of_seeds = spread(&seeds.iter().collect::<Vec<_>>(), at.clone(), m);
            let runs: Vec<&Figures> = seeds[..1].iter().chain(&scenes).collect();
            let of_scenes = spread(&runs, at.clone(), m);
            let rank = spearman(&a, &b);
            // The same for every two training scenes, both learned from patches.
            let between = |one: &Figures, other: &Figures| {
                mean(&mut at.clone().map(|d| (one[d][m] - other[d][m]).powi(2))).sqrt()
            };
            let pairs =
                runs.iter().enumerate().flat_map(|(i, one)| runs[..i].iter().map(|b| between(one, b)));
            let pairs: Vec<f64> = pairs.collect();
            let farther = pairs.iter().filter(|p| **p > rms).count();
            println!(
                "{}, {}: {:.3}; {of_seeds:.4}, {of_scenes:.4}; {bias:+.4}, {rms:.4}; {rank:.4}; {farther} of {}",
                3 + group,
                metric.name(),
                mean(&mut a.iter().copied()),
                pairs.len(),
            );
            let larger = of_seeds.max(of_scenes);
            let case = format!("{} colours, {}", 3 + group, metric.name());
            if !(bias.abs() < most_bias * larger
                && rms < most_rms * larger
                && rank > least_rank
                && farther > 0)
            {
                beyond.push(case);
            }
        }
    }
    assert!(beyond.is_empty(), "beyond the bounds: {beyond:?}");
}
