//! Rankings of cameras do not depend on which infrared-cut filter they have, as long as they have one.

use serde_json::Value;

use crate::Place;

/// The cameras of the slides that the finding was made with: Bayer, and three with clear pixels.
const CAMERAS: [&str; 4] = ["bayer", "kodak", "clarity", "rgbw"];
/// A short-pass filter at 660 nm, in place of the built-in one at 650 nm.
const AT_660_NM: &str = "optics.ir_cut={short_pass={edge_nm=660,width_nm=6.83}}";

/// By how much each camera leads the first at the only light of a comparison, with the interval: value, low, high.
fn leads(results: &Value, metric: &str) -> Vec<[f64; 3]> {
    let metrics = results.pointer("/verdict/lights/0/metrics").unwrap().as_array().unwrap();
    let of = metrics.iter().find(|m| m["metric"] == metric).unwrap();
    let lead = |l: &Value| {
        let bound = |key: &str| l.pointer(&format!("/interval/{key}")).unwrap().as_f64().unwrap();
        [l["value"].as_f64().unwrap(), bound("low"), bound("high")]
    };
    of["from_first"].as_array().unwrap().iter().skip(1).map(lead).collect()
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
        let pairs = leads(&own, metric).into_iter().zip(leads(&other, metric));
        for ((a, b), camera) in pairs.zip(&CAMERAS[1..]) {
            let shown = |[value, low, high]: [f64; 3]| low * high > 0.0 && value.abs() >= least;
            let turned = a[0] * b[0] < 0.0 && shown(a) && shown(b);
            assert!(!turned, "{camera}, {metric}: {a:?} with the own filter, {b:?} with the other");
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
fn another_infrared_cut_turns_no_rank_with_learned_pipelines() {
    ranks_are_those_of_another_filter("--scene photo-astronaut");
}

/// The same on all photographs; `just rankings`.
#[test]
#[ignore = "takes minutes"]
fn another_infrared_cut_turns_no_rank_on_photographs() {
    ranks_are_those_of_another_filter(
        "--scene photo-astronaut --scene photo-brushes --scene photo-dahlia --scene photo-pagoda --scene photo-raccoon",
    );
}
