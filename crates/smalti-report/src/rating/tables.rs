//! The results of an experiment as CSV files.

use smalti::experiment::RatingResult;
use smalti::numeric::bootstrap::Estimate;
use smalti::rating::{Agreement, Level, PsychometricFit, Scales};

use super::RatingReport;

impl RatingReport<'_> {
    /// The results as CSV files, each with its name: `scale.csv` and `agreement.csv`, or for an experiment that asks for an amount of
    /// light `light.csv` and `levels.csv`. Intervals are those of 95 %; a value that is not known is empty.
    #[must_use]
    pub fn tables(&self) -> Vec<(&'static str, String)> {
        match &self.analysis.result {
            RatingResult::Scale { scales, agreement } => {
                vec![("scale.csv", self.scale(scales)), ("agreement.csv", self.agreement(agreement))]
            }
            RatingResult::Light { varied, standard, levels, fit } => {
                vec![
                    ("light.csv", self.light((varied, standard), fit.as_ref())),
                    ("levels.csv", by_level(levels)),
                ]
            }
        }
    }

    /// The scores of all scenes together and of each.
    fn scale(&self, scales: &Scales) -> String {
        let mut text =
            "scene,condition,jod,jod_low,jod_high,log_odds,log_odds_low,log_odds_high\n".to_owned();
        let names = std::iter::once("all").chain(self.answers.scenes.iter().map(String::as_str));
        for (scene, scale) in names.zip(std::iter::once(&scales.all).chain(&scales.scenes)) {
            let Ok(scale) = scale else { continue };
            for (i, name) in self.conditions().iter().enumerate() {
                let [jod, odds] = [&scale.jod[i], &scale.log_odds[i]].map(|e| with_ends(Some(e)));
                text += &format!("{},{},{jod},{odds}\n", quoted(scene), quoted(name));
            }
        }
        text
    }

    /// The rank correlations of each metric with the scores.
    fn agreement(&self, agreement: &[(String, Option<Agreement>)]) -> String {
        let mut text =
            "metric,spearman,spearman_low,spearman_high,kendall,kendall_low,kendall_high,scenes,conditions\n"
                .to_owned();
        let conditions = self.answers.conditions.len();
        for (name, found) in agreement {
            let found = found.as_ref();
            let [spearman, kendall] = [found.map(|a| &a.spearman), found.map(|a| &a.kendall)].map(with_ends);
            let scenes = found.map_or(0, |a| a.scenes);
            text += &format!("{},{spearman},{kendall},{scenes},{conditions}\n", quoted(name));
        }
        text
    }

    /// The light of equal appearance.
    fn light(&self, (varied, standard): (&str, &str), fit: Option<&PsychometricFit>) -> String {
        let [equality, spread] = [fit.map(|f| &f.equality), fit.map(|f| &f.spread)].map(with_ends);
        let number = |of: fn(&PsychometricFit) -> f64| fit.map_or_else(String::new, |f| of(f).to_string());
        let (lapse, deviance) = (number(|f| f.function.lapse), number(|f| f.deviance));
        let is_within = fit.map_or_else(String::new, |f| f.is_within.to_string());
        let (observers, answers) = (self.kept().count(), self.counted());
        let scenes = self.answers.scenes.len();
        format!(
            "varied,standard,equality_stops,equality_stops_low,equality_stops_high,is_within,spread_stops,spread_stops_low,spread_stops_high,lapse,deviance,\
             scenes,observers,answers\n\
             {},{},{equality},{is_within},{spread},{lapse},{deviance},{scenes},{observers},{answers}\n",
            quoted(varied),
            quoted(standard),
        )
    }
}

/// The choices in each amount of light.
fn by_level(levels: &[Level]) -> String {
    let row = |l: &Level| format!("{},{},{}\n", l.level, l.chosen, l.asked);
    "stops,preferred,asked\n".to_owned() + &levels.iter().map(row).collect::<String>()
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// A value and the ends of its interval, as three cells.
fn with_ends(estimate: Option<&Estimate>) -> String {
    let Some(estimate) = estimate else { return ",,".into() };
    match estimate.interval {
        Some(i) => format!("{},{},{}", estimate.value, i.low, i.high),
        None => format!("{},,", estimate.value),
    }
}
