//! The results of an experiment in words and as tables of text.

use smalti::experiment::{JudgedObserver, RatingResult};
use smalti::numeric::bootstrap::Estimate;
use smalti::rating::{IntervalBasis, PsychometricFit, Reason};

use super::RatingReport;
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
    let amount = |v: f64| {
        let more = if v < 0.0 { "less" } else { "more" };
        format!("{} stops {more} light", number(v.abs(), 2))
    };
    let within = match interval(value, 2) {
        Some(interval) => format!(" {interval}"),
        None => " (interval not known)".into(),
    };
    let range = if fit.is_within {
        ""
    } else {
        " This lies beyond the amounts of light that were shown; an experiment with other --stops is needed."
    };
    format!("{varied} needs {}{within} to look like {standard}.{range}", amount(value.value))
}

impl RatingReport<'_> {
    /// The number of answers that count.
    pub(super) fn counted(&self) -> f64 {
        self.kept().flat_map(|o| &o.choices.scenes).map(smalti::rating::Counts::total).sum()
    }

    /// Who took part, in words.
    pub(super) fn observers_words(&self) -> String {
        let (kept, all) = (self.kept().count(), self.answers.observers.len());
        let one = if all == 1 { "observer" } else { "observers" };
        let left_out = match all - kept {
            0 => String::new(),
            1 => ", of whom 1 is excluded".into(),
            excluded => format!(", of whom {excluded} are excluded"),
        };
        format!("{all} {one}{left_out}; {} answers", self.counted())
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

    #[test]
    fn numbers_have_a_minus_sign_and_zero_has_none() {
        let estimate = Estimate { value: -0.004, interval: Some(Interval { low: -1.2, high: 0.3 }) };
        assert_eq!(estimated(&estimate, 2), "0.00 [−1.20, 0.30]");
        assert_eq!(estimated(&Estimate { value: 1.0, interval: None }, 1), "1.0");
    }
}
