//! A comparison as one JSON document.

use serde_json::{Map, Value, json};
use smalti::l3::Pipeline;

use super::columns::mean;
use super::kernels::{dark_and_bright, weights};
use super::results::Comparison;
use crate::ReportError;

impl Comparison<'_> {
    /// All results as one JSON document: results.json.
    ///
    /// # Errors
    /// When a value cannot be written as JSON.
    pub fn document(&self) -> Result<Value, ReportError> {
        let mut entries = Vec::new();
        for (contender, outcomes) in self.contenders.iter().zip(self.outcomes) {
            for o in outcomes {
                let scenes: Vec<Value> = o
                    .scenes
                    .iter()
                    .zip(&o.fixed_point_psnr_db)
                    .map(|((name, s), fixed)| {
                        let scores = serde_json::to_value(s)?;
                        Ok(json!({"scene": name, "scores": scores, "fixed_point_psnr_db": fixed}))
                    })
                    .collect::<Result<_, ReportError>>()?;
                entries.push(json!({
                    "camera": contender.label,
                    "pipeline": contender.processing.name(),
                    "luminance_cd_m2": o.luminance_cd_m2,
                    "cpsnr_db": mean(o, |s| s.scores.cpsnr_db),
                    "pixel_delta_e_2000_mean": mean(o, |s| s.scores.pixel_delta_e_2000_mean),
                    "scielab_mean": mean(o, |s| s.scores.scielab_mean),
                    "targets": serde_json::to_value(&o.targets)?,
                    "scenes": scenes,
                }));
            }
        }
        let learned = self.learned();
        Ok(json!({
            "smalti_version": env!("CARGO_PKG_VERSION"),
            "illuminant": self.illuminant,
            "seed": self.seed,
            "exposure": self.conditions.exposure_as_json(),
            "differences": self.conditions.differences_as_json(),
            "left_out": self.left_out,
            "files": self.files(),
            "results": entries,
            "light_gains": self.gains.iter().map(|g| Ok(json!({
                "needs_more_light": g.first,
                "to_equal": g.other,
                "gains": serde_json::to_value(&g.gains)?,
            }))).collect::<Result<Vec<Value>, ReportError>>()?,
            "learned": learned.iter().map(|(c, p, _)| kernels_as_json(c.label, p)).collect::<Result<Vec<_>, _>>()?,
            "cameras": self.cameras.iter().map(|c| serde_json::to_value(c.description())).collect::<Result<Vec<_>, _>>()?,
        }))
    }
}

/// The number of classes of a pipeline, and the kernels that are drawn.
fn kernels_as_json(camera: &str, pipeline: &Pipeline) -> Result<Value, ReportError> {
    let summary = pipeline.summary();
    let drawn = dark_and_bright(pipeline)
        .into_iter()
        .map(|class| {
            let key = pipeline.key(class);
            let outputs = pipeline
                .outputs()
                .iter()
                .enumerate()
                .map(|(o, name)| Ok((name.clone(), json!(weights(pipeline, class, o)?))))
                .collect::<Result<Map<String, Value>, ReportError>>()?;
            Ok(json!({
                "position": key.position,
                "level": key.level,
                "texture": pipeline.axes().textures().names()[usize::from(key.texture)],
                "weights": outputs,
            }))
        })
        .collect::<Result<Vec<Value>, ReportError>>()?;
    Ok(json!({
        "camera": camera,
        "classes": summary.classes,
        "classes_that_occur": summary.occupied,
        "operators": summary.operators,
        "patches": summary.patches,
        "kernels": drawn,
    }))
}
