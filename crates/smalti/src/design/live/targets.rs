//! The resolution and the noise of designs, on the targets of [`evaluate`](crate::camera::evaluate).

use serde::Serialize;

use super::learner::{LiveDesign, LiveLearner};
use crate::camera::chart::{GREYS, LUMINANCE, patches};
use crate::camera::description::AutoExposureName;
use crate::camera::target::{EDGE_REGION, edge_mtf50};
use crate::camera::{COMPARED_NOISE_CAPTURES, Camera, CameraError};
use crate::design::imaged_scene::ImagedScene;
use crate::design::pixel_light::PixelLight;
use crate::design::preview::PreviewScene;
use crate::isp::Isp;
use crate::metrics::luminance_noise::luminance_noise_of_captures;
use crate::metrics::{MetricError, Rect};
use crate::sensor::{Exposure, NoiseMode};
use crate::spectrum::{Spectrum, WavelengthGrid};

/// The resolution and the noise of a design with its learned pipeline, as `smalti compare` measures them. The fields have the names of the
/// catalogue of metrics. A figure is `None` where it cannot be measured, as on an edge that saturates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LiveTargetScores {
    /// MTF50 of an edge of high contrast without noise, cycles per mm on the sensor.
    pub mtf50_cy_per_mm: Option<f64>,
    /// The same in cycles per pixel.
    pub mtf50_cy_per_px: Option<f64>,
    /// MTF50 of an edge with a luminance ratio of 4:1 at the exposure of the other edge, cycles per mm on the sensor.
    pub mtf50_low_contrast_cy_per_mm: Option<f64>,
    /// The same in cycles per pixel.
    pub mtf50_low_contrast_cy_per_px: Option<f64>,
    /// `100 · std(Y) / mean(Y)` on the grey patches of the ColorChecker, percent: the mean over patches and over
    /// [`COMPARED_NOISE_CAPTURES`] captures.
    pub luminance_noise_percent: Option<f64>,
}

/// The light of a target on bare pixels.
#[derive(Debug)]
pub(super) struct TargetLight {
    pub(super) light: PixelLight,
    metered: Option<Vec<f64>>,
}

impl TargetLight {
    /// # Errors
    /// When the parts of the light do not fit each other.
    pub(super) fn new(scene: &PreviewScene, grid: WavelengthGrid) -> Result<Self, CameraError> {
        Ok(Self { light: scene.light.light(grid)?, metered: scene.metered.clone() })
    }

    /// The target at a mean luminance, behind a lens, on a camera.
    pub(super) fn imaged(
        &self,
        camera: &Camera,
        lens: &Spectrum,
        luminance_cd_m2: f64,
    ) -> Result<ImagedScene, CameraError> {
        let planes = self.light.planes();
        let camera = camera.with_size(planes.rows(), planes.cols());
        let pixels = self.light.behind(&camera.sensor, lens, luminance_cd_m2)?;
        let metered = metered(&camera, self.metered.as_deref(), lens, luminance_cd_m2)?;
        Ok(ImagedScene::from_pixels(camera, pixels, metered))
    }
}

/// The irradiance at the point that a camera meters, behind its lens; `None` if it meters no point. `bare` is that behind a clear lens.
pub(super) fn metered(
    camera: &Camera,
    bare: Option<&[f64]>,
    lens: &Spectrum,
    luminance_cd_m2: f64,
) -> Result<Option<Spectrum>, CameraError> {
    let is_point = camera.stated_time_s().is_none()
        && camera.description().exposure.auto != Some(AutoExposureName::Mean);
    match bare.filter(|_| is_point) {
        None => Ok(None),
        Some(bare) => {
            let values = bare.iter().zip(lens.values()).map(|(v, t)| v * t * luminance_cd_m2).collect();
            Ok(Some(Spectrum::new(camera.grid(), values)?))
        }
    }
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
        Ok(LiveTargetScores {
            mtf50_cy_per_mm: high.map(per_mm),
            mtf50_cy_per_px: high,
            mtf50_low_contrast_cy_per_mm: low.map(per_mm),
            mtf50_low_contrast_cy_per_px: low,
            luminance_noise_percent: noise(&target(&self.chart)?, design, seed)?,
        })
    }
}

/// MTF50 of the picture of an edge without noise, cycles per pixel; `None` when the picture shows no edge.
fn edge_frequency(
    edge: &ImagedScene,
    design: &LiveDesign,
    exposure: &Exposure,
) -> Result<Option<f64>, CameraError> {
    let raw = edge.camera.sensor.capture_ideal(&edge.pixels, exposure)?;
    let picture = Isp::render(&design.pipeline.renderer(), &raw)?;
    match edge_mtf50(picture.planes(), LUMINANCE, EDGE_REGION) {
        Err(CameraError::Metric(MetricError::NoEdge(_) | MetricError::LowContrast { .. })) => Ok(None),
        found => Ok(Some(found?.cy_per_px)),
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
