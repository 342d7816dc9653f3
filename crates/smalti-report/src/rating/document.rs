//! An experiment as one JSON document.

use serde_json::{Value, json};
use smalti::experiment::RatingResult;
use smalti::rating::{ScaleError, ScaledConditions};

use super::RatingReport;
use crate::ReportError;

impl RatingReport<'_> {
    /// All results as one JSON document: results.json.
    ///
    /// # Errors
    /// When a value cannot be written as JSON.
    pub fn document(&self) -> Result<Value, ReportError> {
        let observers: Vec<Value> = self
            .observers()
            .map(|(o, judged)| {
                json!({
                    "number": o.number,
                    "answered": o.answered,
                    "pairs": o.pairs,
                    "repeats": {"same": o.choices.repeats[0], "asked": o.choices.repeats[1]},
                    "traps": {"right": o.choices.traps[0], "asked": o.choices.traps[1]},
                    "likelihood": judged.screening.likelihood,
                    "reasons": judged.screening.reasons,
                    "kept": judged.is_kept,
                    "device_pixel_ratio": o.device_pixel_ratio,
                    "gamma": o.gamma,
                })
            })
            .collect();
        let result = match &self.analysis.result {
            RatingResult::Scale { scales, agreement } => {
                let scenes: Vec<Value> = scales
                    .scenes
                    .iter()
                    .zip(&self.answers.scenes)
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
            "title": self.answers.title,
            "answers": self.counted(),
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
                json!({"conditions": self.conditions().iter().enumerate().map(of).collect::<Vec<_>>()})
            }
        }
    }
}
