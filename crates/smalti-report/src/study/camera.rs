//! The design of a trial as the file of a camera, for all other commands.

use smalti::design::{TrialProcessing, Trials};

use crate::ReportError;
use crate::words::{plain, quoted};

/// TOML of the camera of a trial, with the command that computes the scores of the trial in a comment above it.
///
/// # Errors
/// [`ReportError::NoSuchTrial`]; when the design cannot be made.
pub fn camera_toml(trials: &Trials, number: u64) -> Result<String, ReportError> {
    let (study, count) = (trials.study(), trials.len());
    if number >= count {
        return Err(ReportError::NoSuchTrial { number, last: count.saturating_sub(1) });
    }
    let trial = trials.trial(number)?;
    let condition =
        study.conditions.get(trial.condition).ok_or(ReportError::Missing { what: "condition" })?;
    let mut camera = trial.design.camera(&condition.camera);
    let name = plain(&study.name);
    camera.name = format!("{name}-{number}");
    let file = quoted(&format!("{}.toml", camera.name));
    let luminance = condition.luminance_cd_m2;
    let scored = format!("--luminance {luminance} --illuminant {}", quoted(&condition.illuminant.name()));
    let again = match trial.processing {
        TrialProcessing::Classic => format!("smalti evaluate {file} {scored} --seed {}", study.seed),
        // The pipelines of a study are learned from fewer scenes.
        _ => format!("smalti compare {file} {scored}"),
    };
    let text = toml::to_string(&camera)?;
    let label = plain(&trial.design.filters.label);
    Ok(format!(
        "# Trial {number} of {name}: {label}. With this text in {file}, its scores are computed again by:\n# {again}\n{text}"
    ))
}
