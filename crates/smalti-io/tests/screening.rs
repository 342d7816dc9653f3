//! The closed form of expected errors ranks designs as pipelines that are learned for them do.
//!
//! It takes minutes: `just screening`, or
//! `cargo test --release -p smalti-io --test screening -- --ignored --nocapture`.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

#[path = "support/rank.rs"]
mod rank;

use std::path::PathBuf;

use smalti::design::light::LightSettings;
use smalti::design::screen::{Screen, ScreenCondition};
use smalti::design::{Metric, Sweep};
use smalti::experiment::{Resources, light_statistics};
use smalti_io::rendered::TrainingSet;
use smalti_io::{TomlSource, studies};

use rank::spearman;

/// 504 designs of random Gaussian filters, 3 to 6 colours, on leaves that nothing is learned from. No scene is a training scene.
const STUDY: &str = r#"
    camera = "bayer"
    seed = 7
    colors = [3, 4, 5, 6]
    processing = ["l3"]
    metrics = ["cpsnr_db", "pixel_delta_e_2000_mean", "scielab_mean"]
    scenes = [
        "dead-leaves?rows=384&cols=512&least=2&largest=150&seed=1001",
        "dead-leaves?rows=384&cols=512&least=1.2&largest=60&seed=2002",
    ]
    [sample]
    filters = 126
    [filters.gaussian_grid]
    centers_nm = [430, 2.5, 660]
    sigmas_nm = [20, 2.5, 55]
    min_spacing_nm = 20
    [mosaics]
    given = [["bc", "ab"], ["ab", "cd"], ["abc", "deb", "cad"], ["abc", "def", "bcd"]]
    [conditions.grid]
    luminance_cd_m2 = [1.0, 10.0, 80.0]
"#;

#[test]
#[ignore = "minutes: just screening"]
fn the_closed_form_ranks_designs_as_learned_pipelines_do() {
    let source = TomlSource { name: "screening.toml".into(), folder: PathBuf::new(), text: STUDY.into() };
    let (trials, _) = studies::from_source(&source).unwrap();
    let conditions = &trials.study().conditions;
    let camera = conditions[0].camera().unwrap();
    let resources = Resources { training_scenes: TrainingSet::default().stored(), ..Resources::default() };
    let settings = LightSettings::default();
    let statistics =
        light_statistics(&camera, &conditions[0].illuminant, None, &settings, resources).unwrap();
    let screened: Vec<ScreenCondition> =
        conditions.iter().map(|c| ScreenCondition::of_camera(&camera, c.luminance_cd_m2, 0.033)).collect();
    let screen = Screen::new(&camera, &statistics, &screened).unwrap();
    let images = |_: &str, make: &dyn Fn() -> _| make();
    let scored = Sweep::new(&trials, &images).score(0..trials.len(), &|| true).unwrap();
    // The least coefficients of CPSNR, ΔE2000 and S-CIELAB.
    for (at, least) in [[0.9, 0.8, 0.85], [0.95, 0.9, 0.85], [0.95, 0.9, 0.85]].into_iter().enumerate() {
        let here: Vec<_> = scored.iter().filter(|s| s.trial.condition == at).collect();
        let expected: Vec<_> = here
            .iter()
            .map(|s| screen.expected(&s.trial.design.cfa(camera.grid()).unwrap()).unwrap()[at])
            .collect();
        // The mean over the scenes, negated where less is better.
        let learned = |metric: Metric, sign: f64| -> Vec<f64> {
            let mean = |s: &&smalti::design::ScoredTrial| {
                sign * (s.value(metric, 0).unwrap() + s.value(metric, 1).unwrap()) / 2.0
            };
            here.iter().map(mean).collect()
        };
        let cpsnr: Vec<f64> = expected.iter().map(|e| e.cpsnr_db).collect();
        let color: Vec<f64> = expected.iter().map(|e| -e.delta_e_2000).collect();
        let seen: Vec<f64> = expected.iter().map(|e| -e.scielab).collect();
        let scielab = learned(Metric::Scielab, -1.0);
        let found = [
            spearman(&cpsnr, &learned(Metric::Cpsnr, 1.0)),
            spearman(&color, &learned(Metric::PixelDeltaE2000, -1.0)),
            spearman(&seen, &scielab),
        ];
        let by_color = spearman(&color, &scielab);
        let luminance = conditions[at].luminance_cd_m2;
        println!(
            "{luminance} cd/m²: {} designs, CPSNR {:.3}, ΔE2000 {:.3}, S-CIELAB {:.3} (by the expected ΔE2000 {by_color:.3})",
            here.len(),
            found[0],
            found[1],
            found[2]
        );
        // Within a number of filters, by which most figures differ most.
        for filters in 3..=6 {
            let within: Vec<usize> =
                (0..here.len()).filter(|i| here[*i].trial.design.mosaic.channels() == filters).collect();
            let of = |values: &[f64]| within.iter().map(|i| values[*i]).collect::<Vec<f64>>();
            println!(
                "    {filters} filters: S-CIELAB {:.3} (by the expected ΔE2000 {:.3})",
                spearman(&of(&seen), &of(&scielab)),
                spearman(&of(&color), &of(&scielab))
            );
        }
        assert!(here.len() >= 500);
        for (found, least) in found.into_iter().zip(least) {
            assert!(found >= least, "{luminance} cd/m²: {found} of at least {least}");
        }
        // By day, else there would be no use for it. In the dark, where noise decides, the expected ΔE2000 ranks S-CIELAB better.
        if luminance >= 10.0 {
            assert!(
                found[2] >= by_color,
                "{luminance} cd/m²: {} by S-CIELAB, {by_color} by ΔE2000",
                found[2]
            );
        }
    }
}
