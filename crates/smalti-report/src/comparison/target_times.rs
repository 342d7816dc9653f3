//! The exposure times of the targets of a comparison, on which MTF50, visual SNR and noise are measured.

use smalti::experiment::Outcome;

use super::results::Comparison;
use crate::words::time_ms;

/// The range of times over contenders, in words.
fn range(times_s: impl Iterator<Item = f64>) -> String {
    let (least, most) = times_s.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), s| (a.min(s), b.max(s)));
    let (least, most) = (time_ms(least * 1e3), time_ms(most * 1e3));
    if least == most { format!("{most} ms") } else { format!("{least} to {most} ms") }
}

/// Whether the targets and all scenes have one time.
fn has_one_time(outcome: &Outcome) -> bool {
    let times = &outcome.targets.exposure;
    let scenes = outcome.scenes.iter().map(|(_, s)| s.scores.exposure_time_s);
    scenes.chain([times.edge_s]).all(|time_s| time_ms(time_s * 1e3) == time_ms(times.macbeth_s * 1e3))
}

impl Comparison<'_> {
    /// For each luminance, the exposure times with which MTF50, visual SNR and noise are measured, as a sentence. Empty where they are
    /// those of the scenes.
    #[must_use]
    pub fn target_times(&self) -> Vec<String> {
        if self.outcomes.iter().flatten().all(has_one_time) {
            return Vec::new();
        }
        let of_light = |light: usize| {
            let targets: Vec<_> = self.in_light(light).map(|(_, o)| o.targets.exposure).collect();
            let luminance_cd_m2 = self.luminances().get(light).copied().unwrap_or(f64::NAN);
            format!(
                "At {luminance_cd_m2} cd/m², MTF50 is measured with an exposure of {} (slanted edge), visual SNR and noise with {} (ColorChecker).",
                range(targets.iter().map(|t| t.edge_s)),
                range(targets.iter().map(|t| t.macbeth_s)),
            )
        };
        (0..self.light_count()).map(of_light).collect()
    }
}
