//! A comparison as one JSON document.

use serde_json::{Map, Value, json};
use smalti::camera::PICTURE_METRICS;
use smalti::experiment::Contender;
use smalti::l3::{Pipeline, Quality};

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
                    .enumerate()
                    .map(|(number, (name, s))| {
                        let keeps_light = self.own_light.get(number).copied().unwrap_or_default();
                        let by_seed = s.by_seed.iter().zip(self.seed..).map(by_metric);
                        Ok(json!({
                            "scene": name,
                            "light": if keeps_light { "its own" } else { self.illuminant },
                            "scores": serde_json::to_value(&s.scores)?,
                            "by_seed": by_seed.collect::<Vec<_>>(),
                            "fixed_point_psnr_db": s.fixed_point.map(|f| f.psnr_db),
                            "fixed_point_cpsnr_loss_db": s.fixed_point.map(|f| f.cpsnr_loss_db),
                        }))
                    })
                    .collect::<Result<_, ReportError>>()?;
                let [cpsnr_db, delta_e, scielab] = o.means();
                entries.push(json!({
                    "camera": contender.label,
                    "pipeline": contender.processing.name(),
                    "quality": contender.quality().map(Quality::name),
                    "luminance_cd_m2": o.luminance_cd_m2,
                    "cpsnr_db": cpsnr_db,
                    "pixel_delta_e_2000_mean": delta_e,
                    "scielab_mean": scielab,
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
            "seeds": self.verdict.seeds,
            "contenders": self.contenders.iter().map(Contender::name).collect::<Vec<_>>(),
            "verdict": serde_json::to_value(self.verdict)?,
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

/// The figures of a picture for a seed.
fn by_metric((figures, seed): (&[f64; PICTURE_METRICS.len()], u64)) -> Value {
    let named = PICTURE_METRICS.iter().zip(figures).map(|(name, v)| ((*name).to_owned(), json!(v)));
    Value::Object(std::iter::once(("seed".to_owned(), json!(seed))).chain(named).collect())
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
        "quality": pipeline.quality().name(),
        "classes": summary.classes,
        "classes_that_occur": summary.occupied,
        "operators": summary.operators,
        "patches": summary.patches,
        "kernels": drawn,
    }))
}
