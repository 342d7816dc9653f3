//! Rankings of cameras do not depend on which infrared-cut filter they have, as long as they have one.

use serde_json::Value;

use crate::Place;

/// The cameras of the slides that the finding was made with: Bayer, and three with clear pixels.
const CAMERAS: [&str; 4] = ["bayer", "kodak", "clarity", "rgbw"];
/// A short-pass filter at 660 nm, in place of the built-in one at 650 nm.
const AT_660_NM: &str = "optics.ir_cut={short_pass={edge_nm=660,width_nm=6.83}}";

/// The scores of each camera for every scene and seed.
fn scores(results: &Value, metric: &str) -> Vec<Vec<f64>> {
    let of_seed = |seed: &Value| seed[metric].as_f64().unwrap();
    let of_scene =
        |scene: &Value| -> Vec<f64> { scene["by_seed"].as_array().unwrap().iter().map(of_seed).collect() };
    let of_camera = |r: &Value| r["scenes"].as_array().unwrap().iter().flat_map(of_scene).collect();
    results["results"].as_array().unwrap().iter().map(of_camera).collect()
}

/// By how much every camera leads every later one, with Student's 95 % interval of the paired differences: value, low, high.
fn leads(results: &Value, metric: &str) -> Vec<[f64; 3]> {
    let all = scores(results, metric);
    let lead = |a: &[f64], b: &[f64]| {
        let by: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        let n = by.len() as f64;
        let mean = by.iter().sum::<f64>() / n;
        let variance = by.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
        // The 0.975 quantile for the three seeds of one scene; of more scenes, a wider interval than theirs.
        let half = 4.303 * (variance / n).sqrt();
        [mean, mean - half, mean + half]
    };
    pairs().map(|[a, b]| lead(&all[a], &all[b])).collect()
}

/// The numbers of the cameras of every pair.
fn pairs() -> impl Iterator<Item = [usize; 2]> {
    (0..CAMERAS.len()).flat_map(|a| (a + 1..CAMERAS.len()).map(move |b| [a, b]))
}

/// The metrics, with the smallest difference that counts (`smalti compare` states it).
const METRICS: [(&str, f64); 2] = [("cpsnr_db", 0.1), ("pixel_delta_e_2000_mean", 0.05)];

/// Compares at 80 cd/m² with the own filter and with the other one. No lead, which is a difference that counts and whose interval does not
/// hold 0, becomes one of the other camera.
fn ranks_are_those_of_another_filter(arguments: &str) {
    let place = Place::new();
    let compare = |more: &str, out: &str| {
        let cameras = CAMERAS.join(" ");
        place.ok(&format!("compare {cameras} --luminance 80 {arguments} {more} -o {out}"));
        place.json(&format!("{out}/results.json"))
    };
    let (own, other) = (compare("", "own"), compare(&format!("--set {AT_660_NM}"), "other"));
    for (metric, least) in METRICS {
        let both = leads(&own, metric).into_iter().zip(leads(&other, metric));
        for ((a, b), pair) in both.zip(pairs()) {
            let [first, second] = pair.map(|number| CAMERAS[number]);
            let shown = |[value, low, high]: [f64; 3]| low * high > 0.0 && value.abs() >= least;
            let turned = a[0] * b[0] < 0.0 && shown(a) && shown(b);
            assert!(!turned, "{first} − {second}, {metric}: {a:?} with the own filter, {b:?} with the other");
        }
    }
}

/// The photograph on which a near-infrared leak had made red ochre with white pixels and magenta with others. The intervals are those of
/// the noise alone.
#[test]
fn another_infrared_cut_turns_no_rank_with_classic_processing() {
    ranks_are_those_of_another_filter("--scene photo-astronaut --processing bilinear");
}

/// The same with learned pipelines, which are the default.
#[test]
#[ignore = "takes minutes; `just rankings` runs it"]
fn another_infrared_cut_turns_no_rank_with_learned_pipelines() {
    ranks_are_those_of_another_filter("--scene photo-astronaut");
}

/// The same on all photographs.
#[test]
#[ignore = "takes minutes; `just rankings` runs it"]
fn another_infrared_cut_turns_no_rank_on_photographs() {
    ranks_are_those_of_another_filter(
        "--scene photo-astronaut --scene photo-brushes --scene photo-dahlia --scene photo-pagoda --scene photo-raccoon",
    );
}
