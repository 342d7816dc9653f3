//! The results of an experiment in words and as tables of text.

use smalti::experiment::{AnsweredObserver, JudgedObserver, RatingResult};
use smalti::numeric::bootstrap::Estimate;
use smalti::rating::{Agreement, IntervalBasis, PsychometricFit, Reason};

use super::RatingReport;
use crate::comparison::columns::heading_of;
use crate::words::TextTable;

/// A number with a minus sign.
pub(super) fn number(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    // A zero has no sign.
    let is_zero = text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.');
    if is_zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "−") }
}

/// An interval.
pub(super) fn interval(estimate: &Estimate, digits: usize) -> Option<String> {
    let i = estimate.interval?;
    Some(format!("[{}, {}]", number(i.low, digits), number(i.high, digits)))
}

/// A number with its interval.
pub(super) fn estimated(estimate: &Estimate, digits: usize) -> String {
    let value = number(estimate.value, digits);
    interval(estimate, digits).map_or(value.clone(), |i| format!("{value} {i}"))
}

/// The words of a reason.
pub(super) fn reason(reason: Reason) -> &'static str {
    match reason {
        Reason::Traps => "traps",
        Reason::Repeats => "repeats",
        Reason::Outlier => "outlier",
    }
}

/// Why an observer is left out; `–` for one who is kept.
pub(super) fn reasons(observer: &JudgedObserver) -> String {
    let all: Vec<&str> = observer.screening.reasons.iter().map(|r| reason(*r)).collect();
    match (observer.is_kept, all.is_empty()) {
        (true, _) => "–".into(),
        (false, true) => "no ratings".into(),
        (false, false) => all.join(", "),
    }
}

/// The words of the basis of intervals.
pub(super) fn basis(basis: IntervalBasis) -> &'static str {
    match basis {
        IntervalBasis::Observers => {
            "Intervals of 95 % describe other observers like these: they are percentiles over resampled observers."
        }
        IntervalBasis::Answers => {
            "Intervals of 95 % describe further answers of these observers alone. With five observers or more they describe other observers."
        }
    }
}

/// The statement about light.
pub(super) fn light_words(varied: &str, standard: &str, fit: Option<&PsychometricFit>) -> String {
    let Some(fit) = fit else {
        return format!(
            "The choices for {varied} do not rise with its light, so that no amount of light can be stated at which it looks like {standard}."
        );
    };
    let value = &fit.equality;
    let word = |v: f64| if v < 0.0 { "less" } else { "more" };
    let amount = |v: f64| format!("{} stops {}", number(v.abs(), 2), word(v));
    let range = if fit.is_within {
        ""
    } else {
        " This lies beyond the amounts of light that were shown; an experiment with other --stops is needed."
    };
    match value.interval {
        None => {
            format!(
                "{varied} needs {} light (interval not known) to look like {standard}.{range}",
                amount(value.value)
            )
        }
        Some(i) if i.low <= 0.0 && i.high >= 0.0 => format!(
            "These choices do not show that {varied} needs more or less light to look like {standard}: the estimate is {}, and its interval of 95 % reaches from {} to {}.{range}",
            amount(value.value),
            amount(i.low),
            amount(i.high)
        ),
        Some(i) => {
            // Both ends are on the side of the estimate.
            let [near, far] = [i.low.abs().min(i.high.abs()), i.low.abs().max(i.high.abs())];
            let of = |v: f64| number(v, 2);
            format!(
                "{varied} needs {} light [{}, {}] to look like {standard}.{range}",
                amount(value.value),
                of(near),
                of(far)
            )
        }
    }
}

/// The metric whose rank correlation is the highest, if the intervals show that it is.
pub(super) fn shown_best(agreement: &[(String, Option<Agreement>)]) -> Option<&String> {
    let (name, best) = highest(agreement)?;
    let low = best.interval?.low;
    let is_below = |e: &Estimate| e.interval.is_some_and(|i| i.high < low);
    let others = agreement.iter().filter(|(other, _)| other != name);
    others.filter_map(|(_, a)| a.as_ref()).all(|a| is_below(&a.spearman)).then_some(name)
}

/// The metric with the highest rank correlation, above 0.
fn highest(agreement: &[(String, Option<Agreement>)]) -> Option<(&String, &Estimate)> {
    let known = agreement.iter().filter_map(|(name, a)| Some((name, &a.as_ref()?.spearman)));
    known.max_by(|a, b| a.1.value.total_cmp(&b.1.value)).filter(|(_, best)| best.value > 0.0)
}

/// The statement about metrics.
pub(super) fn agreement_words(agreement: &[(String, Option<Agreement>)]) -> String {
    let Some((name, best)) = highest(agreement) else {
        return "No metric orders the conditions as the observers do.".into();
    };
    let (name, value) = (heading_of(name), estimated(best, 2));
    match shown_best(agreement) {
        Some(_) => format!("{name} agrees best with the observers: Spearman’s rank correlation is {value}."),
        None => format!(
            "These answers cannot rank the metrics: the intervals of their rank correlations overlap. The highest of Spearman’s, {value}, is that of {name}."
        ),
    }
}

/// The numbers of observers who are kept, who have rated, and who opened the page, and that of the answers that count.
fn words_of_observers([kept, rated, all]: [usize; 3], answers: f64) -> String {
    let one = if rated == 1 { "observer" } else { "observers" };
    let excluded = match rated - kept {
        0 => String::new(),
        1 => ", of whom 1 is excluded".into(),
        excluded => format!(", of whom {excluded} are excluded"),
    };
    let visitors = match all - rated {
        0 => String::new(),
        1 => "; 1 more opened the page without rating a pair".into(),
        visitors => format!("; {visitors} more opened the page without rating a pair"),
    };
    format!("{rated} {one}{excluded}; {answers} answers{visitors}")
}

impl RatingReport<'_> {
    /// The number of answers that count.
    pub(super) fn counted(&self) -> f64 {
        self.kept().flat_map(|o| &o.choices.scenes).map(smalti::rating::Counts::total).sum()
    }

    /// Who took part, in words. Who has rated nothing is no observer.
    pub(super) fn observers_words(&self) -> String {
        let has_rated = |o: &&AnsweredObserver| o.choices.scenes.iter().any(|s| s.total() > 0.0);
        let all = self.answers.observers.len();
        let rated = self.answers.observers.iter().filter(has_rated).count();
        words_of_observers([self.kept().count(), rated, all], self.counted())
    }

    /// The results as text: the statement, the scale, the agreement.
    #[must_use]
    pub fn text(&self, table: &TextTable<'_>) -> String {
        let mut out = format!("{}: {}.\n", self.answers.title, self.observers_words());
        match &self.analysis.result {
            RatingResult::Light { varied, standard, fit, levels } => {
                out += &format!("{}\n\n", light_words(varied, standard, fit.as_ref()));
                let row = |l: &smalti::rating::Level| {
                    let share =
                        if l.asked > 0.0 { number(100.0 * l.chosen / l.asked, 0) } else { "–".into() };
                    vec![number(l.level, 2), l.asked.to_string(), share]
                };
                let rows: Vec<Vec<String>> = levels.iter().map(row).collect();
                out += &table(&["stops", "answers", "preferred %"], &rows);
            }
            RatingResult::Scale { scales, agreement } => {
                match &scales.all {
                    Err(error) => out += &format!("There is no scale: {error}.\n"),
                    Ok(all) => {
                        let conditions = self.conditions();
                        let mut order: Vec<usize> = (0..conditions.len()).collect();
                        order.sort_by(|&a, &b| all.jod[b].value.total_cmp(&all.jod[a].value));
                        let row = |&i: &usize| {
                            vec![
                                conditions[i].clone(),
                                estimated(&all.jod[i], 2),
                                estimated(&all.below_best_jod[i], 2),
                                estimated(&all.log_odds[i], 2),
                            ]
                        };
                        let rows: Vec<Vec<String>> = order.iter().map(row).collect();
                        out += "\n";
                        out += &table(&["condition", "JOD", "below the best", "log odds"], &rows);
                        out += &format!("{}\n", basis(scales.basis));
                    }
                }
                let row = |(name, agreement): &(String, Option<smalti::rating::Agreement>)| {
                    let cell = |of: fn(&smalti::rating::Agreement) -> &Estimate| {
                        agreement.as_ref().map_or("–".into(), |a| estimated(of(a), 2))
                    };
                    vec![name.clone(), cell(|a| &a.spearman), cell(|a| &a.kendall)]
                };
                let rows: Vec<Vec<String>> = agreement.iter().map(row).collect();
                if !rows.is_empty() {
                    out += "\n";
                    out += &table(&["metric", "Spearman", "Kendall"], &rows);
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smalti::numeric::bootstrap::Interval;
    use smalti::rating::Psychometric;

    fn estimate(value: f64, low: f64, high: f64) -> Estimate {
        Estimate { value, interval: Some(Interval { low, high }) }
    }

    /// A difference that the interval does not show is not claimed, and amounts of less light have no sign beside the word.
    #[test]
    fn light_is_claimed_as_far_as_it_is_shown() {
        let words = |equality: Estimate| {
            let function = Psychometric { equality: equality.value, spread: 1.0, lapse: 0.0 };
            let fit = PsychometricFit {
                function,
                equality,
                spread: estimate(1.0, 0.5, 2.0),
                deviance: 1.0,
                is_within: true,
                basis: IntervalBasis::Observers,
                resolved: 1.0,
            };
            light_words("A", "B", Some(&fit))
        };
        assert_eq!(
            words(estimate(-0.6, -0.9, -0.2)),
            "A needs 0.60 stops less light [0.20, 0.90] to look like B."
        );
        assert_eq!(
            words(estimate(0.6, 0.2, 0.9)),
            "A needs 0.60 stops more light [0.20, 0.90] to look like B."
        );
        assert_eq!(
            words(estimate(-0.16, -0.53, 0.14)),
            "These choices do not show that A needs more or less light to look like B: the estimate is 0.16 stops less, and its interval of 95 % reaches from 0.53 stops less to 0.14 stops more."
        );
        let unknown = Estimate { value: 0.2, interval: None };
        assert_eq!(words(unknown), "A needs 0.20 stops more light (interval not known) to look like B.");
    }

    #[test]
    fn metrics_are_ranked_as_far_as_their_intervals_are_apart() {
        let of = |name: &str, spearman: Estimate| {
            (name.to_owned(), Some(Agreement { spearman, kendall: spearman, scenes: 2 }))
        };
        let apart = [of("scielab_mean", estimate(0.9, 0.8, 1.0)), of("visual_snr", estimate(0.3, 0.1, 0.7))];
        assert_eq!(shown_best(&apart).unwrap(), "scielab_mean");
        assert_eq!(
            agreement_words(&apart),
            "S-CIELAB agrees best with the observers: Spearman’s rank correlation is 0.90 [0.80, 1.00]."
        );
        let alike =
            [of("scielab_mean", estimate(0.57, -0.5, 1.0)), apart[1].clone(), ("cpsnr_db".into(), None)];
        assert_eq!(shown_best(&alike), None);
        assert_eq!(
            agreement_words(&alike),
            "These answers cannot rank the metrics: the intervals of their rank correlations overlap. The highest of Spearman’s, 0.57 [−0.50, 1.00], is that of S-CIELAB."
        );
        let against = [of("scielab_mean", estimate(-0.2, -0.5, 0.1))];
        assert!(agreement_words(&against).starts_with("No metric"));
    }

    #[test]
    fn who_rated_nothing_is_counted_apart() {
        assert_eq!(
            words_of_observers([3, 3, 11], 240.0),
            "3 observers; 240 answers; 8 more opened the page without rating a pair"
        );
        assert_eq!(
            words_of_observers([4, 6, 7], 99.0),
            "6 observers, of whom 2 are excluded; 99 answers; 1 more opened the page without rating a pair"
        );
        assert_eq!(words_of_observers([1, 1, 1], 9.0), "1 observer; 9 answers");
    }

    #[test]
    fn numbers_have_a_minus_sign_and_zero_has_none() {
        let estimate = Estimate { value: -0.004, interval: Some(Interval { low: -1.2, high: 0.3 }) };
        assert_eq!(estimated(&estimate, 2), "0.00 [−1.20, 0.30]");
        assert_eq!(estimated(&Estimate { value: 1.0, interval: None }, 1), "1.0");
    }
}
