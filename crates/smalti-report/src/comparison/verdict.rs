//! The verdict of a comparison in words.

use smalti::camera::PICTURE_METRICS;
use smalti::experiment::{Crossover, Estimate, Lead, LightVerdict, MetricVerdict, MoreLight, Verdict};
use smalti::numeric::bootstrap::Interval;

use super::results::Comparison;
use crate::words::listed;

/// How a metric is written in sentences: its name, its unit, and digits behind the point.
pub(super) const WORDS: [(&str, &str, usize); PICTURE_METRICS.len()] =
    [("CPSNR", " dB", 2), ("ΔE2000", "", 2), ("S-CIELAB", "", 2)];
/// A ratio of scores of one chart or edge from which the worse one counts as a cost.
const COSTLY: f64 = 1.02;

/// The verdict in one light.
pub(super) struct LightWords {
    /// Mean luminance of the scenes, cd/m².
    pub(super) luminance_cd_m2: f64,
    /// The contenders with the best CPSNR between which these scenes show no difference.
    pub(super) leaders: Vec<String>,
    /// For each metric its name and the verdict.
    pub(super) metrics: Vec<(&'static str, String)>,
    /// What the camera that leads in CPSNR loses elsewhere. Empty if nothing.
    pub(super) cost: String,
}

impl Comparison<'_> {
    /// What the intervals rest on, as a sentence.
    pub(super) fn verdict_basis(&self) -> String {
        let Verdict { scenes, seeds, .. } = self.verdict;
        match (scenes, seeds) {
            (1, 1) => "One scene, one seed of the noise: differences have no interval.".into(),
            (1, _) => format!(
                "One scene, {seeds} seeds of the noise: the intervals (95 %, paired bootstrap) cover the noise, not other scenes."
            ),
            (_, 1) => {
                format!("{scenes} scenes, one seed of the noise; intervals of 95 % (paired bootstrap).")
            }
            _ => {
                format!("{scenes} scenes, {seeds} seeds of the noise; intervals of 95 % (paired bootstrap).")
            }
        }
    }

    /// The verdict for each light.
    pub(super) fn verdict_words(&self) -> Vec<LightWords> {
        let of_light = |(light, verdict): (usize, &LightVerdict)| LightWords {
            luminance_cd_m2: verdict.luminance_cd_m2,
            leaders: self.leaders(verdict),
            metrics: verdict
                .metrics
                .iter()
                .zip(WORDS)
                .map(|(metric, (name, unit, digits))| (name, self.by_metric(metric, unit, digits)))
                .collect(),
            cost: self.cost(light, verdict),
        };
        self.verdict.lights.iter().enumerate().map(of_light).collect()
    }

    /// The luminances at which a lead changes, as sentences.
    pub(super) fn crossover_words(&self) -> Vec<String> {
        let of = |c: &Crossover| {
            let name = PICTURE_METRICS.iter().zip(WORDS).find(|(metric, _)| **metric == c.metric);
            let name = name.map_or(c.metric, |(_, (name, ..))| name);
            let [dim, bright] = c.between_cd_m2;
            format!(
                "{name}: {} is better below about {} cd/m²{}, {} above (interpolated between {dim} and {bright} cd/m²).",
                self.contender_name(c.below),
                significant(c.luminance_cd_m2.value),
                c.luminance_cd_m2.interval.map_or_else(String::new, |Interval { low, high }| format!(
                    " [{}, {}]",
                    significant(low),
                    significant(high)
                )),
                self.contender_name(c.above),
            )
        };
        self.verdict.crossovers.iter().map(of).collect()
    }

    /// The verdict as lines for a terminal. Empty when only one camera was scored.
    #[must_use]
    pub fn verdict_text(&self) -> String {
        if self.contenders.len() < 2 {
            return String::new();
        }
        let mut out = format!("Verdict. {}\n", self.verdict_basis());
        for LightWords { luminance_cd_m2, metrics, cost, .. } in self.verdict_words() {
            out += &format!("  {luminance_cd_m2} cd/m²\n");
            for (name, words) in metrics {
                out += &format!("    {name:<9} {words}\n");
            }
            if !cost.is_empty() {
                out += &format!("    cost      {cost}\n");
            }
        }
        for line in self.crossover_words() {
            out += &format!("  {line}\n");
        }
        out
    }

    /// The label of a contender, with its processing where the camera has several.
    pub(super) fn contender_name(&self, number: usize) -> String {
        let name = |c: &smalti::experiment::Contender<'_>| {
            let alone = self.contenders.iter().filter(|other| other.label == c.label).count() == 1;
            if alone { c.label.to_owned() } else { c.name() }
        };
        self.contenders.get(number).map(name).unwrap_or_default()
    }

    /// The contenders that are the best in CPSNR, or not distinguishable from the best.
    fn leaders(&self, verdict: &LightVerdict) -> Vec<String> {
        let Some(metric) = verdict.metrics.first() else { return Vec::new() };
        let among = (0..metric.leads.len()).filter(|number| metric.is_among_best(*number));
        among.map(|number| self.contender_name(number)).collect()
    }

    /// Who is the best by a metric, and by how much.
    fn by_metric(&self, verdict: &MetricVerdict, unit: &str, digits: usize) -> String {
        let best = self.contender_name(verdict.best);
        let others: Vec<(usize, &Lead)> =
            verdict.leads.iter().enumerate().filter(|(number, _)| *number != verdict.best).collect();
        if let [(other, lead)] = others[..] {
            let other = self.contender_name(other);
            let by = amount(&lead.by, unit, digits);
            return match lead.is_tie() {
                Some(true) => format!(
                    "no difference that these scenes can show between {best} and {other} ({best} ahead by {by})"
                ),
                _ => format!("{best} leads {other} by {by}{}", light(lead)),
            };
        }
        let (ties, behind): (Vec<_>, Vec<_>) =
            others.into_iter().partition(|(_, lead)| lead.is_tie() == Some(true));
        let ties: Vec<String> = ties.into_iter().map(|(number, _)| self.contender_name(number)).collect();
        let behind: Vec<String> = behind
            .into_iter()
            .map(|(number, lead)| {
                format!(
                    "{} by {}{}",
                    self.contender_name(number),
                    amount(&lead.by, unit, digits),
                    light(lead)
                )
            })
            .collect();
        let tied = match ties.len() {
            0 => String::new(),
            _ => format!("; these scenes show no difference from {}", listed(&ties)),
        };
        match behind.len() {
            0 => format!("no difference that these scenes can show ({best} has the best mean)"),
            _ => format!("{best} leads {}{tied}", listed(&behind)),
        }
    }

    /// What a camera that leads in CPSNR loses by the scores of the chart and the edge, which have no interval. Empty without such a
    /// lead; the other metrics of pictures have verdicts of their own.
    fn cost(&self, light: usize, verdict: &LightVerdict) -> String {
        let Some(cpsnr) = verdict.metrics.first() else { return String::new() };
        let best = cpsnr.best;
        if (0..self.contenders.len()).all(|contender| cpsnr.is_among_best(contender)) {
            return String::new();
        }
        let mut lost = Vec::new();
        type Score = fn(&smalti::camera::Evaluation) -> f64;
        let single: [(&str, Score); 3] = [
            ("MTF50", |e| e.mtf50_cy_per_mm),
            ("visual SNR", |e| e.visual_snr.median),
            ("noise", |e| 1.0 / e.luminance_noise_percent.mean),
        ];
        for (name, of) in single {
            let scores: Vec<f64> = self.in_light(light).map(|(_, o)| of(&o.targets)).collect();
            let Some(&own) = scores.get(best) else { continue };
            let ratio = |(number, score): (usize, &f64)| (number, score / own);
            let top = scores.iter().enumerate().map(ratio).filter(|(_, r)| r.is_finite());
            if let Some((number, ratio)) = top.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, r)| *r > COSTLY)
            {
                let percent = 100.0 * (ratio - 1.0);
                let other = self.contender_name(number);
                lost.push(match name {
                    "noise" => format!("{percent:.0} % more noise on the chart than {other}"),
                    _ => format!("{name} of {other} is {percent:.0} % higher"),
                });
            }
        }
        if lost.is_empty() {
            return String::new();
        }
        format!("of {}: {}", self.contender_name(best), lost.join("; "))
    }
}

/// A difference with its interval: `1.12 dB [0.71, 1.50]`.
pub(super) fn amount(by: &Estimate, unit: &str, digits: usize) -> String {
    let interval =
        by.interval.map_or_else(String::new, |i| format!(" [{:.digits$}, {:.digits$}]", i.low, i.high));
    format!("{:.digits$}{unit}{interval}", by.value).replace('-', "−")
}

/// A lead as light.
fn light(lead: &Lead) -> String {
    match &lead.light {
        None => String::new(),
        Some(MoreLight::Stops(stops)) => format!(" (worth {} of light)", amount(stops, " stops", 2)),
        Some(MoreLight::MoreThan(stops)) => format!(" (worth more than {stops} stops of light)"),
    }
}

/// A luminance with two significant digits.
fn significant(value: f64) -> String {
    let digits = (1 - value.abs().max(1e-9).log10().floor() as i32).max(0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::significant;

    #[test]
    fn luminances_have_two_digits() {
        assert_eq!([0.123, 1.26, 9.96, 21.7, 123.4].map(significant), ["0.12", "1.3", "10.0", "22", "123"]);
    }
}
