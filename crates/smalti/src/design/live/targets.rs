//! The resolution and the noise of designs, on the targets of [`evaluate`](crate::camera::evaluate).

use serde::Serialize;

use super::learner::{LiveDesign, LiveLearner};
use super::target_light::TargetLight;
use crate::camera::chart::{GREYS, LUMINANCE, patches};
use crate::camera::target::{EDGE_REGION, edge_mtf50};
use crate::camera::{COMPARED_NOISE_CAPTURES, CameraError};
use crate::design::imaged_scene::ImagedScene;
use crate::isp::Isp;
use crate::metrics::luminance_noise::luminance_noise_of_captures;
use crate::metrics::{MetricError, Rect};
use crate::sensor::{Exposure, NoiseMode};

/// The resolution and the noise of a design with its learned pipeline, as `smalti compare` measures them. The fields have the names of the
/// catalogue of metrics, but for the reason. A figure is `None` where it cannot be measured, as on an edge that saturates.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LiveTargetScores {
    /// MTF50 of an edge of high contrast without noise, cycles per mm on the sensor.
    pub mtf50_cy_per_mm: Option<f64>,
    /// The same in cycles per pixel.
    pub mtf50_cy_per_px: Option<f64>,
    /// MTF50 of an edge with a luminance ratio of 4:1 at the exposure of the other edge, cycles per mm on the sensor.
    pub mtf50_low_contrast_cy_per_mm: Option<f64>,
    /// The same in cycles per pixel.
    pub mtf50_low_contrast_cy_per_px: Option<f64>,
    /// Why the MTF50 of one of the edges, or of both, cannot be measured.
    pub no_mtf50: Option<String>,
    /// `100 · std(Y) / mean(Y)` on the grey patches of the ColorChecker, percent: the mean over patches and over
    /// [`COMPARED_NOISE_CAPTURES`] captures.
    pub luminance_noise_percent: Option<f64>,
}

impl LiveLearner {
    /// The resolution and the noise of a design. `seed` is that of the noise of the first capture.
    ///
    /// # Errors
    /// When no exposure is found or a stage fails.
    pub fn targets(&self, design: &LiveDesign, seed: u64) -> Result<LiveTargetScores, CameraError> {
        let target = |light: &TargetLight| light.imaged(&design.camera, &design.lens, design.luminance_cd_m2);
        let (edge, low_contrast) = (target(&self.edge)?, target(&self.low_contrast_edge)?);
        let (_, exposure) = edge.with_cfa(&design.camera.sensor.cfa)?;
        let high = edge_frequency(&edge, design, &exposure)?;
        let exposure = low_contrast.camera.exposure_for(exposure.time_s, &low_contrast.pixels)?;
        let low = edge_frequency(&low_contrast, design, &exposure)?;
        let per_mm = |f: f64| f / (design.camera.sensor.pixel.pitch_m * 1e3);
        let no_mtf50 = high.as_ref().err().or(low.as_ref().err()).map(ToString::to_string);
        let (high, low) = (high.ok(), low.ok());
        Ok(LiveTargetScores {
            mtf50_cy_per_mm: high.map(per_mm),
            mtf50_cy_per_px: high,
            mtf50_low_contrast_cy_per_mm: low.map(per_mm),
            mtf50_low_contrast_cy_per_px: low,
            no_mtf50,
            luminance_noise_percent: noise(&target(&self.chart)?, design, seed)?,
        })
    }
}

/// MTF50 of the picture of an edge without noise, cycles per pixel, or why it cannot be measured on the picture.
fn edge_frequency(
    edge: &ImagedScene,
    design: &LiveDesign,
    exposure: &Exposure,
) -> Result<Result<f64, MetricError>, CameraError> {
    let raw = edge.camera.sensor.capture_ideal(&edge.pixels, exposure)?;
    let picture = Isp::render(&design.pipeline.renderer(), &raw)?;
    match edge_mtf50(picture.planes(), LUMINANCE, EDGE_REGION) {
        Err(CameraError::Metric(error)) if error.is_about_edge() => Ok(Err(error)),
        found => Ok(Ok(found?.cy_per_px)),
    }
}

/// The noise of the grey patches, percent; `None` when a patch has no signal.
fn noise(chart: &ImagedScene, design: &LiveDesign, seed: u64) -> Result<Option<f64>, CameraError> {
    let (camera, exposure) = chart.with_cfa(&design.camera.sensor.cfa)?;
    let greys = &patches()[GREYS];
    let first = greys.iter().map(|p| p.row).min().unwrap_or(0);
    let end = greys.iter().map(|p| p.row + p.rows).max().unwrap_or(0);
    let (sensor, row) = chart.band(&camera.sensor, first, end, design.pipeline.reach());
    let capture = |number: u64| -> Result<_, CameraError> {
        let raw = sensor.capture(&chart.pixels, &exposure, NoiseMode::All, seed.wrapping_add(number))?;
        Ok(Isp::render(&design.pipeline.renderer(), &raw)?)
    };
    let captures = (0..COMPARED_NOISE_CAPTURES).map(capture).collect::<Result<Vec<_>, _>>()?;
    let planes: Vec<_> = captures.iter().map(|picture| picture.planes()).collect();
    let greys: Vec<Rect> = greys.iter().map(|p| Rect { row: p.row - row, ..*p }).collect();
    match luminance_noise_of_captures(&planes, LUMINANCE, &greys) {
        Err(MetricError::Undefined { .. }) => Ok(None),
        found => {
            let found = found?;
            Ok(Some(found.iter().map(|n| n.mean_percent).sum::<f64>() / found.len() as f64))
        }
    }
}
