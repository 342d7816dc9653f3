//! The targets of an evaluation: the ColorChecker, a slanted edge and a zone plate.

use super::chart::{self, PATCH_SAMPLES};
use super::stable_text::stable_text;
use super::{Camera, CameraError};
use crate::metrics::esfr::{EsfrOptions, Mtf50Reliability, NYQUIST_CY_PER_PX, edge_sfr};
use crate::metrics::{MetricError, Rect};
use crate::numeric::Planes;
use crate::optics::OpticalImage;
use crate::scene::{self, Scene, Setting, SlantedBar, ZonePlate, macbeth};

/// Pixels of the sensor that the edge scene spans; it has 513 samples.
const EDGE_PX: usize = 120;
/// The region of the edge that is measured, as in ISETCam for this scene.
pub(crate) const EDGE_REGION: Rect = Rect { row: 27, col: 37, rows: 66, cols: 44 };
/// Luminance ratio of the edge of low contrast, as ISO 12233:2017 states it.
const LOW_CONTRAST_RATIO: f64 = 4.0;
/// Pixels of the sensor that the zone plate spans.
const ZONE_PX: usize = 256;
/// Samples of the zone plate per pixel of the sensor.
const ZONE_SAMPLES_PER_PX: usize = 3;

/// A scene, the camera with as many pixels as the scene covers, and the cache key of its optical image.
pub(crate) struct Target {
    pub(crate) camera: Camera,
    scene: Box<dyn Fn() -> Result<Scene, CameraError> + Sync>,
    pub(crate) key: String,
}

impl Target {
    fn new(
        camera: &Camera,
        rows: usize,
        cols: usize,
        setting: &Setting,
        name: &str,
        scene: impl Fn(&Setting) -> Result<Scene, CameraError> + Sync + 'static,
    ) -> Result<Self, CameraError> {
        let horizontal_fov_deg = camera.field_of_view_deg(cols, setting.distance_m)?;
        let setting = Setting { horizontal_fov_deg, ..setting.clone() };
        let key = stable_text(&(name, &setting, &camera.optics))?;
        Ok(Self { camera: camera.with_size(rows, cols), scene: Box::new(move || scene(&setting)), key })
    }

    pub(crate) fn chart(camera: &Camera, setting: &Setting) -> Result<Self, CameraError> {
        let [rows, cols] = chart::SIZE_PX;
        Self::new(camera, rows, cols, setting, "macbeth", |s| Ok(macbeth::chart(PATCH_SAMPLES, s)?))
    }

    pub(crate) fn edge(camera: &Camera, setting: &Setting) -> Result<Self, CameraError> {
        Self::bar(camera, setting, "edge", SlantedBar::default())
    }

    /// The edge with a contrast of 4:1, which processing that adapts to contrast renders as it renders most detail.
    pub(crate) fn low_contrast_edge(camera: &Camera, setting: &Setting) -> Result<Self, CameraError> {
        let bar = SlantedBar { contrast_ratio: LOW_CONTRAST_RATIO, ..SlantedBar::default() };
        Self::bar(camera, setting, "edge-4-1", bar)
    }

    fn bar(camera: &Camera, setting: &Setting, name: &str, bar: SlantedBar) -> Result<Self, CameraError> {
        let bar = SlantedBar { sampling: scene::PatternSampling::Area, ..bar };
        Self::new(camera, EDGE_PX, EDGE_PX, setting, name, move |s| Ok(scene::slanted_bar(&bar, s)?))
    }

    pub(crate) fn zone_plate(camera: &Camera, setting: &Setting) -> Result<Self, CameraError> {
        let size = ZONE_PX * ZONE_SAMPLES_PER_PX;
        // The zone plate reaches the Nyquist frequency of the sensor at the centre of each side.
        let plate = ZonePlate { size, frequency: 0.5 / ZONE_SAMPLES_PER_PX as f64, ..ZonePlate::default() };
        Self::new(camera, ZONE_PX, ZONE_PX, setting, "zone-plate", move |s| Ok(scene::zone_plate(&plate, s)?))
    }

    /// The optical image of the target.
    pub(crate) fn image(&self) -> Result<OpticalImage, CameraError> {
        Ok(self.camera.optics.image(&(self.scene)()?)?)
    }
}

/// Spatial frequency at which the edge response of the luminance plane falls to one half (MTF50).
pub(crate) struct EdgeMtf50 {
    pub(crate) cy_per_px: f64,
    pub(crate) reliability: Mtf50Reliability,
}

impl EdgeMtf50 {
    pub(crate) fn cy_per_mm(&self, camera: &Camera) -> f64 {
        self.cy_per_px / (camera.sensor.pixel.pitch_m * 1e3)
    }
}

pub(crate) fn edge_mtf50(picture: &Planes, luminance: usize, region: Rect) -> Result<EdgeMtf50, CameraError> {
    let sfr = edge_sfr(picture, luminance, region, &EsfrOptions::default())?;
    let found = sfr.mtf50_cy_per_px.zip(sfr.mtf50_reliability(NYQUIST_CY_PER_PX));
    let missing = MetricError::NoEdge("the response does not fall to one half");
    let (cy_per_px, reliability) = found.ok_or(missing)?;
    Ok(EdgeMtf50 { cy_per_px, reliability })
}
