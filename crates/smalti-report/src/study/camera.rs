//! A design as the file of a camera, for all other commands.

use smalti::design::{Designs, Processing};

use crate::ReportError;
use crate::words::{plain, quoted};

/// TOML of the camera of a design, with the command that computes the scores of the design in a comment above it.
///
/// # Errors
/// [`ReportError::NoSuchDesign`]; when the design cannot be made.
pub fn camera_toml(designs: &Designs, number: u64) -> Result<String, ReportError> {
    let (study, count) = (designs.study(), designs.len());
    if number >= count {
        return Err(ReportError::NoSuchDesign { number, last: count.saturating_sub(1) });
    }
    let design = designs.design(number)?;
    let condition =
        study.conditions.get(design.condition).ok_or(ReportError::Missing { what: "condition" })?;
    let mut camera = design.camera(&condition.camera);
    let name = plain(&study.name);
    camera.name = format!("{name}-{number}");
    let file = quoted(&format!("{}.toml", camera.name));
    let luminance = condition.luminance_cd_m2;
    let scored = format!("--luminance {luminance} --illuminant {}", quoted(&condition.illuminant.name()));
    let again = match design.processing {
        Processing::Classic => format!("smalti evaluate {file} {scored} --seed {}", study.seed),
        // The pipelines of a study are learned from fewer scenes.
        _ => format!("smalti compare {file} {scored}"),
    };
    let text = toml::to_string(&camera)?;
    let label = plain(&design.filters.label);
    Ok(format!(
        "# Design {number} of {name}: {label}. With this text in {file}, its scores are computed again by:\n# {again}\n{text}"
    ))
}
