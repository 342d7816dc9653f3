//! Tables, raw captures and large pictures.

use std::path::Path;

use serde_json::{Value, json};
use smalti::camera::{Camera, ScoreSettings, TrainingSettings};
use smalti::experiment::{
    DefaultTraining, FieldOfView, PreparedCapture, Progress as _, SimulationSettings, displayed,
    learn_default, simulate,
};
use smalti::l3::{Pipeline, Quality, Training};
use smalti::sensor::NoiseMode;
use smalti::spectrum::Illuminant;
use smalti_io::dng::{self, DngInfo};
use smalti_io::picture::{self, Depth};
use smalti_io::{SceneRequest, l3, memory, scenes, studio};

use super::design::camera;
use super::error::JobError;
use super::material::{Found, Native};
use super::message::Capture;
use super::watch::Watch;

/// The illuminant of the scenes of the page.
pub(super) const LIGHT: Illuminant = Illuminant::D65;

/// The pipeline of a camera, learned as by `smalti train --illuminants D65`; the cache keeps its statistics.
fn pipeline(native: &Native, camera: &Camera, quality: Quality, watch: &Watch) -> Result<Pipeline, JobError> {
    let label = camera.description().name.clone();
    let of = DefaultTraining { camera: camera.clone(), label, light: LIGHT };
    let settings = TrainingSettings::default();
    let training = Training { quality, ..Training::default() };
    let learned = learn_default(&[of], (&settings, &training), native.resources(watch))?;
    learned.into_iter().next().ok_or(JobError::Broken)
}

/// The learned table of a design.
pub(super) fn table(
    native: &Native,
    design: &Value,
    quality: Quality,
    watch: &Watch,
) -> Result<Found, JobError> {
    let pipeline = pipeline(native, &camera(design)?, quality, watch)?;
    let summary = pipeline.summary();
    let said = json!({"patches": summary.patches, "classes": summary.classes, "occupied": summary.occupied});
    Ok(Found { said, files: vec![("table", l3::table_to_bytes(&pipeline, Path::new("table"))?)] })
}

/// A capture of a scene, and its picture with the pipeline of the design.
pub(super) fn capture(native: &Native, wanted: &Capture, watch: &Watch) -> Result<Found, JobError> {
    let camera = camera(&wanted.design)?;
    let name = studio::catalogue_name(&wanted.scene).ok_or(JobError::Broken)?;
    let pipeline = wanted.pipeline.map(|quality| pipeline(native, &camera, quality, watch)).transpose()?;
    watch.expect(1);
    watch.begin("scene");
    let request = SceneRequest {
        luminance_cd_m2: Some(wanted.luminance_cd_m2),
        illuminant: Some(LIGHT),
        grid: camera.description().wavelengths_nm.map(|_| camera.grid()),
        ..SceneRequest::default()
    };
    let scene = scenes::load(name, &request)?;
    let PreparedCapture { camera, scene, notes } =
        PreparedCapture::new(&camera, scene, FieldOfView::Fitted, false)?;
    notes.iter().for_each(|text| watch.note(text));
    let light = scene.illuminant().clone();
    watch.done();
    let settings = SimulationSettings { noise: NoiseMode::All, seed: SEED, score: ScoreSettings::default() };
    let shot = simulate((&camera, pipeline.as_ref()), scene, &settings, watch, memory::available_bytes())?;
    let photo = &shot.photograph;
    let info = DngInfo::of_camera(&camera, &light)?;
    let mut files = vec![("raw", dng::to_bytes(&photo.raw, &info, Path::new("raw"))?)];
    if let Some(pipeline) = &pipeline {
        let (shown, _) = displayed(&camera, photo)?;
        files.push(("picture", picture::png_bytes(&shown, Depth::Eight, Path::new("picture"))?));
        files.push(("table", l3::table_to_bytes(pipeline, Path::new("table"))?));
    }
    let scores = shot.score.as_ref().filter(|_| pipeline.is_some()).map(|s| &s.scores);
    let said = json!({
        "rows": photo.raw.rows(),
        "cols": photo.raw.cols(),
        "exposure_ms": photo.exposure.time_s * 1e3,
        "saturated_percent": photo.raw.saturated_percent(),
        "cpsnr_db": scores.map(|s| s.cpsnr_db),
        "pixel_delta_e_2000_mean": scores.map(|s| s.pixel_delta_e_2000_mean),
        "scielab_mean": scores.map(|s| s.scielab_mean),
    });
    Ok(Found { said, files })
}

/// Seed of the noise, as that of the command.
pub(super) const SEED: u64 = 1;
