//! The verdict of a comparison in words.

use smalti::camera::PICTURE_METRICS;
use smalti::experiment::{
    Crossover, Estimate, Finding, Lead, LightStops, LightVerdict, MetricVerdict, MoreLight, Outcome,
    StopsInterval, Verdict,
};
use smalti::metrics::esfr::Mtf50Reliability;
use smalti::metrics::smallest_relevant;
use smalti::numeric::bootstrap::LEAST_GROUPS;

use super::results::Comparison;
use crate::words::listed;

/// How a metric is written in sentences: its name, its unit, and digits behind the point.
pub(crate) const WORDS: [(&str, &str, usize); PICTURE_METRICS.len()] =
    [("CPSNR", " dB", 2), ("ΔE2000", "", 2), ("S-CIELAB", "", 2)];

/// The verdict in one light.
pub(super) struct LightWords {
    /// Mean luminance of the scenes, cd/m².
    pub(super) luminance_cd_m2: f64,
    /// The contenders with the best CPSNR between which these scenes show no relevant difference.
    pub(super) leaders: Vec<String>,
    /// For each metric its name and the verdict.
    pub(super) metrics: Vec<(&'static str, String)>,
    /// What each camera among the best in CPSNR loses elsewhere.
    pub(super) costs: Vec<String>,
}

impl Comparison<'_> {
    /// What the intervals rest on, as a sentence.
    pub(super) fn verdict_basis(&self) -> String {
        let Verdict { scenes, seeds, .. } = *self.verdict;
        let realisations =
            if seeds == 1 { "one noise realisation".into() } else { format!("{seeds} noise realisations") };
        let method = if scenes < LEAST_GROUPS { "Student's t" } else { "paired bootstrap" };
        match (scenes, seeds) {
            (1, 1) => format!("One scene, {realisations}: differences have no confidence interval."),
            (1, _) => format!(
                "One scene with {realisations}: the 95 % confidence intervals in brackets ({method}) cover the noise, not other scenes."
            ),
            (_, 1) => {
                format!("{scenes} scenes, {realisations}; 95 % confidence intervals in brackets ({method}).")
            }
            _ => format!(
                "{scenes} scenes with {realisations} each; 95 % confidence intervals in brackets ({method})."
            ),
        }
    }

    /// Which differences count as none, as a sentence.
    pub(super) fn verdict_limits() -> String {
        let least = |(metric, (name, unit, _)): (&&str, (&str, &str, usize))| {
            format!("{}{unit} in {name}", smallest_relevant(metric))
        };
        let least: Vec<String> = PICTURE_METRICS.iter().zip(WORDS).map(least).collect();
        format!("Differences below {} count as none.", listed(&least))
    }

    /// The verdict for each light. `list` joins the cameras behind the best one.
    pub(super) fn verdict_words(&self, list: fn(&[String]) -> String) -> Vec<LightWords> {
        let of_light = |(light, verdict): (usize, &LightVerdict)| LightWords {
            luminance_cd_m2: verdict.luminance_cd_m2,
            leaders: self.leaders(verdict),
            metrics: verdict
                .metrics
                .iter()
                .zip(WORDS)
                .map(|(metric, (name, unit, digits))| (name, self.by_metric(metric, unit, digits, list)))
                .collect(),
            costs: self.costs(light, verdict),
        };
        self.verdict.lights.iter().enumerate().map(of_light).collect()
    }

    /// The luminances at which a lead changes, as sentences: those of the best cameras, or those of the others.
    pub(super) fn crossover_words(&self, of_best: bool) -> Vec<String> {
        let of = |c: &Crossover| {
            let name = PICTURE_METRICS.iter().zip(WORDS).find(|(metric, _)| **metric == c.metric);
            let name = name.map_or(c.metric, |(_, (name, ..))| name);
            let [dim, bright] = c.between_cd_m2;
            format!(
                "{name}: {} is better up to {dim} cd/m², {} from {bright} cd/m² on; between them, interpolation places the crossover near {} cd/m² (no interval).",
                self.contender_name(c.below),
                self.contender_name(c.above),
                significant(c.interpolated_cd_m2),
            )
        };
        self.verdict.crossovers.iter().filter(|c| c.is_of_best == of_best).map(of).collect()
    }

    /// The verdict as lines for a terminal. Empty when only one camera was scored.
    #[must_use]
    pub fn verdict_text(&self) -> String {
        if self.contenders.len() < 2 {
            return String::new();
        }
        let mut out = format!("Verdict. {}\n{}\n", self.verdict_basis(), Self::verdict_limits());
        for line in self.conditions.reservations() {
            out += &format!("{line}\n");
        }
        for LightWords { luminance_cd_m2, metrics, costs, .. } in self.verdict_words(in_lines) {
            out += &format!("  {luminance_cd_m2} cd/m²\n");
            for (name, words) in metrics {
                out += &format!("    {name:<9} {words}\n");
            }
            if !costs.is_empty() {
                out += &format!("    but, {ONCE}:\n");
            }
            for cost in costs {
                out += &format!("      {cost}\n");
            }
        }
        for line in self.crossover_words(true) {
            out += &format!("  {line}\n");
        }
        match self.crossover_words(false).len() {
            0 => out,
            1 => {
                out + "  One further crossover, between cameras that are not the best, is in results.json.\n"
            }
            more => {
                out + &format!(
                    "  {more} further crossovers, between cameras that are not the best, are in results.json.\n"
                )
            }
        }
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
    fn by_metric(
        &self,
        verdict: &MetricVerdict,
        unit: &str,
        digits: usize,
        list: fn(&[String]) -> String,
    ) -> String {
        let best = self.contender_name(verdict.best);
        let others: Vec<(usize, &Lead)> =
            verdict.leads.iter().enumerate().filter(|(number, _)| *number != verdict.best).collect();
        if let [(other, lead)] = others[..] {
            let other = self.contender_name(other);
            let by = amount(&lead.by, unit, digits);
            let none = match lead.finding {
                Finding::Lead => return format!("{best} leads {other} by {by}{}", light(lead)),
                Finding::NoDifference => "no difference that these scenes can show",
                Finding::Negligible => "no relevant difference",
            };
            let better =
                if lead.by.value > 0.0 { format!(" ({best} better by {by})") } else { String::new() };
            return format!("{none} between {best} and {other}{better}");
        }
        let with = |finding: Finding| -> Vec<(String, &Lead)> {
            let found = others.iter().filter(|(_, lead)| lead.finding == finding);
            found.map(|(number, lead)| (self.contender_name(*number), *lead)).collect()
        };
        let names = |found: Vec<(String, &Lead)>| -> Vec<String> { found.into_iter().map(|f| f.0).collect() };
        let behind: Vec<String> = with(Finding::Lead)
            .into_iter()
            .map(|(name, lead)| format!("{name} by {}{}", amount(&lead.by, unit, digits), light(lead)))
            .collect();
        let (same, near) = (names(with(Finding::NoDifference)), names(with(Finding::Negligible)));
        let largest = others.iter().max_by(|a, b| a.1.by.value.total_cmp(&b.1.by.value));
        if behind.is_empty() {
            let none = if same.is_empty() {
                "no relevant difference"
            } else {
                "no difference that these scenes can show"
            };
            let largest = largest.map_or_else(String::new, |(number, lead)| {
                format!(
                    "; the largest, from {}, is {}",
                    self.contender_name(*number),
                    amount(&lead.by, unit, digits)
                )
            });
            return format!("{none} ({best} has the best mean{largest})");
        }
        // Ties come first, so that nothing follows the list of those behind.
        let ties = [(same, "no difference that these scenes can show"), (near, "no relevant difference")];
        let ties = ties.into_iter().filter(|(names, _)| !names.is_empty());
        let between = |names: Vec<String>| listed(&[vec![best.clone()], names].concat());
        let ties: String = ties.map(|(names, none)| format!("{none} between {}; ", between(names))).collect();
        format!("{ties}{best} leads {}", list(&behind))
    }

    /// In which scores of the chart and the edge, which have no interval, each camera among the best in CPSNR is worse than another one,
    /// a sentence each. Nothing where all cameras are among the best. The other metrics of pictures have verdicts of their own.
    fn costs(&self, light: usize, verdict: &LightVerdict) -> Vec<String> {
        let Some(cpsnr) = verdict.metrics.first() else { return Vec::new() };
        let among: Vec<usize> =
            (0..self.contenders.len()).filter(|contender| cpsnr.is_among_best(*contender)).collect();
        if among.len() == self.contenders.len() {
            return Vec::new();
        }
        among.into_iter().filter_map(|contender| self.cost(light, contender)).collect()
    }

    /// What a camera loses in single scores. An MTF50 that cannot be trusted does not count, and all are in cycles per pixel, because the
    /// cameras capture the scene with equally many pixels.
    fn cost(&self, light: usize, best: usize) -> Option<String> {
        /// The name of a score, that of its metric, whether higher is better, and its value where it can be trusted.
        type Single = (&'static str, &'static str, bool, fn(&Outcome) -> Option<f64>);
        let single: [Single; 3] = [
            ("MTF50 of the 4:1 edge", "mtf50_low_contrast_cy_per_px", true, |o| {
                let is_reliable = o.targets.mtf50_low_contrast_reliability == Mtf50Reliability::Reliable;
                is_reliable.then_some(o.targets.mtf50_low_contrast_cy_per_px)
            }),
            ("visual SNR", "visual_snr", true, |o| Some(o.targets.visual_snr.median)),
            ("noise", "luminance_noise_percent", false, |o| Some(o.targets.luminance_noise_percent.mean)),
        ];
        let lost = |(name, metric, is_higher_better, of): &Single| {
            let scores: Vec<Option<f64>> = self.in_light(light).map(|(_, o)| of(o)).collect();
            let own = (*scores.get(best)?)?;
            let sign = if *is_higher_better { 1.0 } else { -1.0 };
            let finite =
                |(number, score): (usize, &Option<f64>)| Some((number, score.filter(|v| v.is_finite())?));
            let scores = scores.iter().enumerate().filter_map(finite);
            let (number, top) = scores.max_by(|a, b| (sign * a.1).total_cmp(&(sign * b.1)))?;
            let is_worse = sign * (top - own) > 0.0 && smallest_relevant(metric).is_relevant(own, top);
            let percent = (100.0 * (top / own - 1.0)).abs();
            let direction = if top > own { "higher" } else { "lower" };
            is_worse.then(|| {
                format!("{name} (that of {} is {percent:.0} % {direction})", self.contender_name(number))
            })
        };
        let lost: Vec<String> = single.iter().filter_map(lost).collect();
        (!lost.is_empty()).then(|| format!("{} is worse in {}", self.contender_name(best), listed(&lost)))
    }
}

/// How the scores of chart and edge are measured.
pub(super) const ONCE: &str = "each without an interval";
/// The most cameras behind the best one that the terminal names in one line.
const IN_ONE_LINE: usize = 1;

/// Cameras behind the best one for the terminal: a line each if they are many.
fn in_lines(behind: &[String]) -> String {
    if behind.len() <= IN_ONE_LINE {
        return listed(behind);
    }
    let lines: String = behind.iter().map(|one| format!("\n                {one}")).collect();
    format!("{} cameras:{lines}", behind.len())
}

/// A difference with its interval: `1.12 dB [0.71, 1.50]`.
pub(crate) fn amount(by: &Estimate, unit: &str, digits: usize) -> String {
    let interval =
        by.interval.map_or_else(String::new, |i| format!(" [{:.digits$}, {:.digits$}]", i.low, i.high));
    format!("{:.digits$}{unit}{interval}", by.value).replace('-', "−")
}

/// A lead as light.
fn light(lead: &Lead) -> String {
    match lead.light {
        None => String::new(),
        Some(MoreLight::Stops(LightStops { value, interval })) => {
            let interval = match interval {
                None => String::new(),
                Some(StopsInterval { low, high: Some(high) }) => format!(" [{low:.2}, {high:.2}]"),
                Some(StopsInterval { low, high: None }) => format!(", at least {low:.2}"),
            };
            format!(" (equivalent to {value:.2} stops more light{interval})")
        }
        Some(MoreLight::MoreThan(stops)) => format!(" (equivalent to more than {stops} stops more light)"),
        Some(MoreLight::Unreachable { rise_db }) => {
            let rise = if rise_db < 0.005 {
                "does not raise CPSNR".into()
            } else {
                format!("raises CPSNR by at most {rise_db:.2} dB")
            };
            format!(" (more light does not compensate: at this exposure time, it {rise})")
        }
    }
}

/// A luminance with two significant digits.
fn significant(value: f64) -> String {
    let digits = (1 - value.abs().max(1e-9).log10().floor() as i32).max(0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luminances_have_two_digits() {
        assert_eq!([0.123, 1.26, 9.96, 21.7, 123.4].map(significant), ["0.12", "1.3", "10.0", "22", "123"]);
    }

    #[test]
    fn light_that_does_not_suffice_is_not_a_number_of_stops() {
        let of = |more: MoreLight| {
            let by = Estimate { value: 1.0, interval: None };
            light(&Lead { by, finding: Finding::Lead, light: Some(more) })
        };
        let stops = |high| LightStops { value: 0.42, interval: Some(StopsInterval { low: 0.3, high }) };
        assert_eq!(
            of(MoreLight::Stops(stops(Some(0.55)))),
            " (equivalent to 0.42 stops more light [0.30, 0.55])"
        );
        assert_eq!(
            of(MoreLight::Stops(stops(None))),
            " (equivalent to 0.42 stops more light, at least 0.30)"
        );
        assert_eq!(of(MoreLight::MoreThan(4.0)), " (equivalent to more than 4 stops more light)");
        assert_eq!(
            of(MoreLight::Unreachable { rise_db: 0.31 }),
            " (more light does not compensate: at this exposure time, it raises CPSNR by at most 0.31 dB)"
        );
        assert!(of(MoreLight::Unreachable { rise_db: 0.0 }).contains("does not raise CPSNR"));
    }
}
