//! One capture, from the scene to a scored picture.

use super::error::StageContext;
use super::{ExperimentError, Progress};
use crate::camera::{Camera, CameraError, Photograph, PictureScores, ScoreSettings, score_picture};
use crate::isp::{Isp, WhiteBalance};
use crate::l3::Pipeline;
use crate::metrics::MetricError;
use crate::optics::OpticalImage;
use crate::scene::Scene;
use crate::sensor::{Exposure, NoiseMode, Window};
use crate::spectrum::{Observer, Spectrum};

/// Maximum number of rows and of columns that are scored.
const MAX_SCORED_PX: usize = 2048;

/// Peak memory of a capture, measured on mosaics: raw samples, and pictures in XYZ during their comparison.
const BYTES_PER_PIXEL: u64 = 120;
/// Memory for each further photodiode of a binned sample, whose light an exposure rule may meter.
const BYTES_PER_PHOTODIODE: u64 = 4;

/// Settings of a simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulationSettings {
    /// The noise sources.
    pub noise: NoiseMode,
    /// Seed of the noise.
    pub seed: u64,
    /// Viewing conditions of the scores, as in a comparison.
    pub score: ScoreSettings,
}

/// The results of a simulation.
#[derive(Debug, Clone)]
pub struct Simulation {
    /// The results of every stage.
    pub photograph: Photograph,
    /// The scores of the centre of the picture against the reference of the standard observer; `None` when there is no light.
    pub score: Option<ScoredWindow>,
}

/// The scores of a part of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoredWindow {
    /// The scores.
    pub scores: PictureScores,
    /// The part of the sensor.
    pub window: Window,
}

/// Captures a scene, renders the raw image and scores the picture, in two steps of progress. The scene is dropped as soon as its
/// optical image is formed. A learned `pipeline`, if there is one, renders the raw image instead of the camera's own processing.
/// `memory_bytes` is the memory limit, if there is one.
///
/// # Errors
/// When memory does not suffice, a stage fails, or the work is stopped.
pub fn simulate(
    (camera, pipeline): (&Camera, Option<&Pipeline>),
    scene: Scene,
    settings: &SimulationSettings,
    progress: &dyn Progress,
    memory_bytes: Option<u64>,
) -> Result<Simulation, ExperimentError> {
    let light = scene.illuminant().clone();
    let photograph = capture((camera, pipeline), scene, settings, progress, memory_bytes)?;
    let (image, exposure) = (&photograph.optical_image, &photograph.exposure);
    let score = score_capture((camera, pipeline), &light, image, exposure, settings)?;
    Ok(Simulation { photograph, score })
}

/// [`simulate`] without the scores.
///
/// # Errors
/// As [`simulate`].
pub fn capture(
    (camera, pipeline): (&Camera, Option<&Pipeline>),
    scene: Scene,
    settings: &SimulationSettings,
    progress: &dyn Progress,
    memory_bytes: Option<u64>,
) -> Result<Photograph, ExperimentError> {
    ensure_memory(camera, memory_bytes)?;
    let about = || camera.description().name.clone();
    // Before the slow part of the work.
    if let Some(pipeline) = pipeline {
        pipeline.ensure_renders(&camera.sensor.cfa).in_context(about)?;
    }
    progress.expect(2);
    progress.begin("optics");
    let image = camera.optics.image(&scene).map_err(CameraError::from).in_context(about)?;
    let light = scene.illuminant().clone();
    drop(scene);
    progress.done();
    super::progress::ensure_running(progress)?;
    progress.begin("sensor and processing");
    let photograph = match pipeline {
        Some(pipeline) => camera.photograph_learned(pipeline, image, &light, (settings.noise, settings.seed)),
        None => camera.photograph(image, &light, settings.noise, settings.seed),
    };
    let photograph = photograph.in_context(about)?;
    progress.done();
    Ok(photograph)
}

/// Refuses a capture that exceeds the available memory, since the system would kill the program.
fn ensure_memory(camera: &Camera, memory_bytes: Option<u64>) -> Result<(), ExperimentError> {
    let Window { rows, cols, .. } = camera.sensor.read_window();
    let photodiodes = (camera.sensor.binning_side() as u64).pow(2);
    let each = BYTES_PER_PIXEL + (photodiodes - 1) * BYTES_PER_PHOTODIODE;
    let need = (rows as u64).saturating_mul(cols as u64).saturating_mul(each);
    match memory_bytes {
        Some(available) if need > available => Err(ExperimentError::CaptureMemory {
            rows,
            cols,
            need_mib: need >> 20,
            available_mib: available >> 20,
        }),
        _ => Ok(()),
    }
}

/// Captures an optical image under an illuminant (photons) and scores the centre of the picture, at most 2048 pixels high and
/// wide. `None` when there is no light.
///
/// # Errors
/// When a stage fails.
pub fn score_capture(
    (camera, pipeline): (&Camera, Option<&Pipeline>),
    light: &Spectrum,
    image: &OpticalImage,
    exposure: &Exposure,
    settings: &SimulationSettings,
) -> Result<Option<ScoredWindow>, ExperimentError> {
    let about = || camera.description().name.clone();
    let mosaic = camera.sensor.cfa.mosaic();
    let whole = camera.sensor.read_window();
    let middle = |first: usize, count: usize, tile: usize| {
        let taken = count.min(MAX_SCORED_PX);
        let skipped = (count - taken) / 2;
        (first + skipped - skipped % tile, taken)
    };
    let (row, rows) = middle(whole.row, whole.rows, mosaic.rows());
    let (col, cols) = middle(whole.col, whole.cols, mosaic.cols());
    let window = Window { row, col, rows, cols };
    let mut camera = camera.clone();
    camera.sensor.window = Some(window);
    // A windowed capture has the same bits as that part of the full capture.
    let score = || -> Result<_, CameraError> {
        let raw = camera.sensor.capture(image, exposure, settings.noise, settings.seed)?;
        let (picture, white) = match pipeline {
            Some(pipeline) => (pipeline.render(&raw)?, Observer::Cie1931.white(light)?),
            None => {
                let isp = camera.isp(light, WhiteBalance::None)?;
                (isp.render(&raw)?, isp.color_matrix.xyz_white())
            }
        };
        let reference = camera.reference_as_exposed(image, exposure, light)?;
        match score_picture(&picture, &reference, white, &settings.score) {
            Ok(scores) => Ok(Some(ScoredWindow { scores, window })),
            Err(CameraError::Metric(MetricError::Undefined { .. })) => Ok(None),
            Err(e) => Err(e),
        }
    };
    score().in_context(about)
}
