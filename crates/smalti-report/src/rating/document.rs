//! An experiment as one JSON document and as CSV.

use serde_json::{Value, json};
use smalti::numeric::bootstrap::Estimate;
use smalti::rating::{ScaleError, ScaledConditions};

use super::{RatingReport, RatingResult};
use crate::ReportError;

impl RatingReport<'_> {
    /// All results as one JSON document: results.json.
    ///
    /// # Errors
    /// When a value cannot be written as JSON.
    pub fn document(&self) -> Result<Value, ReportError> {
        let observers: Vec<Value> = self
            .observers
            .iter()
            .map(|o| {
                json!({
                    "number": o.number,
                    "answered": o.answered[0],
                    "pairs": o.answered[1],
                    "repeats": {"same": o.choices.repeats[0], "asked": o.choices.repeats[1]},
                    "traps": {"right": o.choices.traps[0], "asked": o.choices.traps[1]},
                    "likelihood": o.screening.likelihood,
                    "reasons": o.screening.reasons,
                    "kept": o.is_kept,
                    "device_pixel_ratio": o.device_pixel_ratio,
                    "gamma": o.gamma,
                })
            })
            .collect();
        let result = match self.result {
            RatingResult::Scale { scales, agreement } => {
                let scenes: Vec<Value> = scales
                    .scenes
                    .iter()
                    .zip(self.scenes)
                    .map(|(scale, name)| json!({"scene": name, "scale": self.scaled(scale)}))
                    .collect();
                let agreement: Vec<Value> =
                    agreement.iter().map(|(name, a)| json!({"metric": name, "agreement": a})).collect();
                json!({
                    "kind": "scale", "intervals_describe": scales.basis, "all": self.scaled(&scales.all),
                    "scenes": scenes, "agreement": agreement,
                })
            }
            RatingResult::Light { varied, standard, levels, fit } => {
                json!({"kind": "light", "varied": varied, "standard": standard, "levels": levels, "fit": fit})
            }
        };
        Ok(json!({
            "smalti_version": env!("CARGO_PKG_VERSION"),
            "title": self.title,
            "answers": self.answers(),
            "observers": observers,
            "result": result,
        }))
    }

    /// The scale of conditions, or why there is none.
    fn scaled(&self, scale: &Result<ScaledConditions, ScaleError>) -> Value {
        match scale {
            Err(error) => json!({"none": error.to_string()}),
            Ok(scale) => {
                let of = |(i, name): (usize, &String)| {
                    json!({
                        "condition": name, "jod": scale.jod[i], "below_best_jod": scale.below_best_jod[i],
                        "log_odds": scale.log_odds[i],
                    })
                };
                json!({"conditions": self.conditions.iter().enumerate().map(of).collect::<Vec<_>>()})
            }
        }
    }

    /// The figures as CSV: the scale of all scenes and of each, or the choices in each amount of light.
    #[must_use]
    pub fn csv(&self) -> String {
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let ends = |e: &Estimate| match e.interval {
            Some(i) => format!("{},{},{}", e.value, i.low, i.high),
            None => format!("{},,", e.value),
        };
        match self.result {
            RatingResult::Light { levels, .. } => {
                let row = |l: &smalti::rating::Level| format!("{},{},{}\n", l.level, l.chosen, l.asked);
                "stops,preferred,asked\n".to_owned() + &levels.iter().map(row).collect::<String>()
            }
            RatingResult::Scale { scales, .. } => {
                let mut text =
                    "scene,condition,jod,jod_low,jod_high,log_odds,log_odds_low,log_odds_high\n".to_owned();
                let names = std::iter::once("all").chain(self.scenes.iter().map(String::as_str));
                for (scene, scale) in names.zip(std::iter::once(&scales.all).chain(&scales.scenes)) {
                    let Ok(scale) = scale else { continue };
                    for (i, name) in self.conditions.iter().enumerate() {
                        let (jod, odds) = (ends(&scale.jod[i]), ends(&scale.log_odds[i]));
                        text += &format!("{},{},{jod},{odds}\n", quoted(scene), quoted(name));
                    }
                }
                text
            }
        }
    }
}
