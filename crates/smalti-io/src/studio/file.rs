//! The light of a scene, or of the training scene, in a file: a container with a hash, as statistics of light have.

use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::json;
use smalti::design::QuantizedPlanes;
use smalti::design::live::{LiveScene, LiveTraining};

use super::residuals::{packed, unpacked};
use crate::IoError;
use crate::container::{Content, Opened};

const SCENE: (&str, &str) = ("smalti-studio-scene", "1");
const TRAINING: (&str, &str) = ("smalti-studio-training", "2");

/// The bytes of the file of a scene; `path` is only named in errors.
///
/// # Errors
/// When a number of the light is too large.
pub fn scene_to_bytes(scene: &LiveScene, path: &Path) -> Result<Vec<u8>, IoError> {
    to_bytes(SCENE, scene, &[&scene.scene.light.planes], path)
}

/// The light of a scene; `path` is only named in errors.
///
/// # Errors
/// When the file is of another kind or version, or damaged.
pub fn scene_from_bytes(bytes: &[u8], path: &Path) -> Result<LiveScene, IoError> {
    from_bytes(SCENE, "the light of a scene for the studio", bytes, path, planes_of_scene)
}

/// The bytes of the file of a training scene and the targets; `path` is only named in errors.
///
/// # Errors
/// When a number of the light is too large.
pub fn training_to_bytes(training: &LiveTraining, path: &Path) -> Result<Vec<u8>, IoError> {
    let light = &training.training;
    let edges = [&training.edge, &training.low_contrast_edge].map(|e| &e.light.planes);
    let planes = [&light.chart.light.planes, &light.light.planes, &light.seen];
    to_bytes(TRAINING, training, &[&planes[..], &edges].concat(), path)
}

/// The light of a training scene; `path` is only named in errors.
///
/// # Errors
/// When the file is of another kind or version, or damaged.
pub fn training_from_bytes(bytes: &[u8], path: &Path) -> Result<LiveTraining, IoError> {
    from_bytes(TRAINING, "the light of a training scene for the studio", bytes, path, planes_of_training)
}

fn planes_of_scene(scene: &mut LiveScene) -> Vec<&mut QuantizedPlanes> {
    vec![&mut scene.scene.light.planes]
}

fn planes_of_training(training: &mut LiveTraining) -> Vec<&mut QuantizedPlanes> {
    let light = &mut training.training;
    vec![
        &mut light.chart.light.planes,
        &mut light.light.planes,
        &mut light.seen,
        &mut training.edge.light.planes,
        &mut training.low_contrast_edge.light.planes,
    ]
}

fn to_bytes(
    format: (&str, &str),
    about: &impl Serialize,
    planes: &[&QuantizedPlanes],
    path: &Path,
) -> Result<Vec<u8>, IoError> {
    let mut content = Content::default();
    content.text("format", format.0);
    content.text("version", format.1);
    content.text("about", json!(about));
    let Some(bytes) = packed(planes.iter().copied()) else {
        return Err(IoError::field(path, "a difference of the light", "beyond 16 bits", "a smaller one"));
    };
    content.tensor("differences", &[bytes.len()], bytes);
    content.into_bytes(path)
}

fn from_bytes<T: DeserializeOwned>(
    format: (&'static str, &'static str),
    expected: &'static str,
    bytes: &[u8],
    path: &Path,
    planes: fn(&mut T) -> Vec<&mut QuantizedPlanes>,
) -> Result<T, IoError> {
    let opened = Opened::new(bytes, path, expected, (format.0, &[format.1]))?;
    let mut content: T = opened.json("about")?;
    let (_, differences) = opened.any::<u8>("differences", 1)?;
    let sizes: Vec<[usize; 3]> = planes(&mut content).iter().map(|p| [p.rows, p.cols, p.count]).collect();
    let Some(codes) = unpacked(&differences, &sizes) else {
        let found = format!("{} bytes", differences.len());
        return Err(opened.wrong("tensor 'differences'", found, "two bytes for each number of the planes"));
    };
    for (planes, codes) in planes(&mut content).into_iter().zip(codes) {
        planes.codes = Arc::new(codes);
    }
    Ok(content)
}
