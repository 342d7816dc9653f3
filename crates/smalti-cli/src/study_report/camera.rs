//! A design as the file of a camera, for all other commands.

use std::path::Path;

use anyhow::{Context, ensure};
use smalti::design::Processing;
use smalti_io::dataset::Dataset;

use super::page::quoted;
use super::results::{designs, plain};

/// TOML of the camera of a design, and above it how its figures are found again.
pub(crate) fn toml(dir: &Path, number: u64) -> anyhow::Result<String> {
    let dataset = Dataset::open(dir)?;
    let designs = designs(&dataset).with_context(|| dir.display().to_string())?;
    let (study, count) = (designs.study(), designs.len());
    ensure!(number < count, "{}: it has designs 0 to {}, not {number}", dir.display(), count - 1);
    let design = designs.design(number)?;
    let condition = study.conditions.get(design.condition).context("no such condition")?;
    let mut camera = design.camera(&condition.camera);
    let name = plain(&study.name);
    camera.name = format!("{name}-{number}");
    let file = quoted(&format!("{}.toml", camera.name));
    let luminance = condition.luminance_cd_m2;
    let scored = format!("--luminance {luminance} --illuminant {}", quoted(&condition.illuminant.name()));
    let again = match design.processing {
        Processing::Classic => format!("smalti evaluate {file} {scored} --seed {}", study.seed),
        // Of a study, pipelines are learned from less.
        _ => format!("smalti compare {file} {scored}"),
    };
    let text = toml::to_string(&camera)?;
    let label = plain(&design.filters.label);
    Ok(format!(
        "# Design {number} of {name}: {label}. Its figures again, from this as {file}:\n# {again}\n{text}"
    ))
}
